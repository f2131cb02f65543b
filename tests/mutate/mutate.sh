#!/bin/sh
# How many small mistakes in the mathematics of deepgbuffer.h the tests of tests/unit notice: tests/mutate/mutate.sh
#
# Makes COUNT=200 mutants (mutants.awk) of the pure functions, the same ones for the same SEED=1, runs the tests on each
# until one fails, `nproc` mutants at a time, and prints those that survive:
#     deepgbuffer.h:1286: `<` becomes `<=`: return x <= DGB_MAX_RADIANCE ? x : DGB_MAX_RADIANCE;
# Not counted are those that compile to the code of the original, and those that the table `equivalent` has, each line as the
# mutant has it, below the reason why nothing tells it from the original. Needs the objects of `make core-tests`. Fails
# below GOAL=90 percent; COUNT=0 makes every mutant.

here=tests/mutate
objects=${OBJECTS:-build/release}
compile="${CC:-cc} -std=c99 -w -O1 -ffp-contract=off"

# mutate.sh one LINE COLUMN OLD NEW: prints how that mutant ends, a tab, and what it is.
if [ "$1" = one ]; then
    line=$2 column=$3 old=$4 new=$5
    dir=$work/$line.$column.$$
    trap 'rm -rf "$dir"' EXIT
    mkdir "$dir"
    old=$old new=$new awk -v line="$line" -v column="$column" '
        NR == line { $0 = substr($0, 1, column - 1) ENVIRON["new"] substr($0, column + length(ENVIRON["old"])) }
        { print }' "$work/deepgbuffer.h" >"$dir/deepgbuffer.h"
    code=$(sed -n "${line}s/^ *//p" "$dir/deepgbuffer.h")
    say() { printf '%s\tdeepgbuffer.h:%s: `%s` becomes `%s`: %s\n' "$1" "$line" "$old" "$new" "$code"; exit; }

    if grep -Fxq -e "$code" $here/equivalent; then say equivalent; fi
    $compile -I"$dir" -c "$work/core.c" -o "$dir/core.o" 2>/dev/null || say invalid
    if cmp -s "$dir/core.o" "$work/core.o"; then say equivalent; fi
    while read -r test; do
        $compile "$objects/obj/$test.o" "$dir/core.o" "$objects/support.a" -lcmocka -lm -o "$dir/test" || say invalid
        timeout 120 "$dir/test" >/dev/null 2>&1 && continue
        (echo "$test" && grep -Fxv -e "$test" "$work/tests") >"$dir/tests" && mv "$dir/tests" "$work/tests"
        say killed
    done <"$work/tests"
    say survived
fi

work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
trap 'exit 130' INT TERM
export work

cp deepgbuffer.h "$work" || exit 1 # it may be edited meanwhile

# The tests, which must pass on the original: the fastest first. Later the one before them that killed the last mutant: its
# neighbours in the file are likely to die by the same.
printf '#define DEEPGBUFFER_IMPLEMENTATION\n#include <deepgbuffer.h>\n' >"$work/core.c"
$compile -I"$work" -c "$work/core.c" -o "$work/core.o" || exit 1
for source in tests/unit/test_*.c; do
    test=${source%.c}
    $compile "$objects/obj/$test.o" "$work/core.o" "$objects/support.a" -lcmocka -lm -o "$work/test" || exit 1
    start=$(date +%s%N)
    "$work/test" >/dev/null 2>&1 || { echo "$test fails without a mutant" >&2; exit 1; }
    echo "$(($(date +%s%N) - start)) $test" >>"$work/times"
done
sort -n "$work/times" | sed 's/.* //' >"$work/tests"

# A sample without replacement, in the order of the lines; the random numbers are Lehmer's.
awk -v 'from=^/\\* >> numbers' -v 'to=^/\\* >> parameters' -f $here/mutants.awk "$work/deepgbuffer.h" >"$work/all"
total=$(wc -l <"$work/all")
awk -v count="${COUNT:-200}" -v seed="${SEED:-1}" -v total="$total" '
    BEGIN { state = seed * 2654435 % 2147483646 + 1; left = count > 0 ? count : total }
    { state = state * 16807 % 2147483647 }
    state / 2147483647 * (total - NR + 1) < left { --left; print }' "$work/all" >"$work/sample"

tr '\t\n' '\0\0' <"$work/sample" | xargs -0 -n 4 -P "$(nproc 2>/dev/null || echo 2)" "$0" one >"$work/results"

awk -F '\t' -v goal="${GOAL:-90}" -v seed="${SEED:-1}" -v total="$total" '
    { ++count[$1] }
    $1 == "survived" || $1 == "invalid" { print $1 " " $2 | "sort" }
    END {
        close("sort")
        counted = count["killed"] + count["survived"]
        share = counted ? 100 * count["killed"] / counted : 0
        printf "%d of %d mutants killed, %.1f %%; %d more are equivalent, %d do not compile (of %d, seed %d)\n",
            count["killed"], counted, share, count["equivalent"], count["invalid"], total, seed
        exit share < goal
    }' "$work/results"
