#!/bin/sh
# Both headers compile without a warning in every language and mode they promise, and keep to themselves: no stray
# symbol, no mutable global, no library but libm, no GL word in the core. Prints TAP. Every program built here is run.

cd "$(dirname "$0")/../.." || exit 1
dir=$(mktemp -d) || exit 1
trap 'rm -rf "$dir"' EXIT

strict="-pedantic -Wall -Wextra -Wshadow -Wconversion -Werror -I."
here=tests/compile

# attempt NAME COMMAND...: reports whether the command succeeds, and its output when it does not
attempt() {
    name=$1
    shift
    if "$@" >"$out.log" 2>&1; then echo "ok - $name"; else echo "not ok - $name"; sed 's/^/# /' "$out.log"; fi
}

# build COMPILER ARGUMENTS...: compiles, links and runs
build() { "$@" -lm -o "$out.program" && "$out.program"; }

# >> every compiler, language and mode

compile_with() {
    cc=$1 out=$dir/$1
    if ! command -v "$cc" >/dev/null; then
        if [ "$CI" = true ]; then echo "not ok - $cc is missing"; else echo "ok - $cc # SKIP not installed"; fi
        return
    fi
    for std in c99 c11 c17 c++11 c++17 c++20; do
        case $std in c++*) language=c++ ;; *) language=c ;; esac
        compile="build $cc -x $language -std=$std $strict"
        # shellcheck disable=SC2086 # $compile is a list of words
        {
            attempt "$cc $std core alone"              $compile -O0 $here/core.c
            attempt "$cc $std core alone, -O2"         $compile -O2 $here/core.c
            attempt "$cc $std both in one unit"        $compile -O2 $here/both.c
            attempt "$cc $std both, -ffast-math"       $compile -O2 -ffast-math $here/both.c
            attempt "$cc $std both, DGB_API static"    $compile -O0 -DDGB_API=static $here/both.c
            attempt "$cc $std two units linked"        $compile -O0 $here/implementation.c $here/user.c
        }
    done
}

compile_with gcc >"$dir/gcc.tap" &
compile_with clang >"$dir/clang.tap" &
wait
cat "$dir/gcc.tap" "$dir/clang.tap" | tee "$dir/all.tap"

# >> the same numbers, whatever compiles them

# Results of the mathematics; all: every function's, integers: of those that compute in integers.
hashes() { build "$@" -std=c99 $strict -Itests/support -ffp-contract=off $here/bits.c >"$out.hashes"; }
hashes_like_the_first() {
    kind=$1
    shift
    # shellcheck disable=SC2086 # $strict is a list of words
    hashes "$@" || return
    if [ "$kind" = integers ]; then sed -i '/^integers/!d' "$out.hashes"; fi
    if [ ! -e "$dir/first.hashes" ]; then cp "$out.hashes" "$dir/first.hashes"; fi
    if [ "$kind" = all ]; then diff "$dir/first.hashes" "$out.hashes"; return; fi
    grep '^integers' "$dir/first.hashes" | diff - "$out.hashes" && [ -s "$out.hashes" ]
}

for cc in gcc clang; do
    out=$dir/bits
    if ! command -v "$cc" >/dev/null; then continue; fi # compile_with has said so
    for level in -O0 -O2 -O3; do attempt "$cc $level gives the same bits" hashes_like_the_first all "$cc" "$level"; done
    attempt "$cc -ffast-math gives the same integers" hashes_like_the_first integers "$cc" -O2 -ffast-math
done | tee -a "$dir/all.tap"

# >> one list of the mathematics: what is declared, guaranteed and called with any bits

declared() { sed -n '/--- mathematics/,/--- parameters of a frame/s/^DGB_API .*\(dgb_[a-z0-9_]*\)(.*/\1/p' deepgbuffer.h; }
guaranteed() { sed -n '/NUMERICAL GUARANTEES/,/THREADS/s/^ *\(dgb_[a-z0-9_]*\) .*/\1/p' deepgbuffer.h; }
called() { sed -n 's/^ *{"\(dgb_[a-z0-9_]*\)".*/\1/p' tests/support/mathematics.c | uniq; }
one_list() {
    declared >"$dir/declared" && guaranteed >"$dir/guaranteed" && called >"$dir/called"
    [ -s "$dir/declared" ] && diff "$dir/declared" "$dir/guaranteed" && diff "$dir/declared" "$dir/called"
}
out=$dir/list
attempt "the mathematics is declared, guaranteed and tested in one order" one_list | tee -a "$dir/all.tap"

# >> what the libraries bring into a program

# Fails when a line of the input does not match the pattern, and shows those lines.
only() { ! grep -vE "^($1)\$"; }
no()   { ! grep -nE "$1" "$2"; }

symbols() { nm "$@" "$dir/symbols.o"; }
exported()        { symbols -g --defined-only | awk '{ print $3 }' | only "$1"; }
no_mutable_data() { symbols | awk '$(NF - 1) ~ /[BbCDdSs]/ { print }' | only ''; }
imported()        { symbols -u | awk '{ print $2 }' | only "$libc"; }

libc='mem(cpy|set|move|cmp)|str(len|cmp|ncmp|str|chr|cspn)|_GLOBAL_OFFSET_TABLE_|__stack_chk_fail|__assert_fail'
libc="$libc|(sqrt|sin|cos|tan|asin|acos|atan|atan2|floor|ceil|fabs|pow|exp|exp2|log|log2|fmin|fmax|fmod|ldexp|frexp|round)f?"

{
    out=$dir/symbols
    cc="${CC:-cc} -std=c99 -I. -O0 -fno-pie -c -o $dir/symbols.o"
    attempt "the core has no GL word" no '(^|[^A-Za-z0-9_])(gl[A-Z]|GL_)' deepgbuffer.h

    # shellcheck disable=SC2086 # $cc is a list of words
    attempt "the core becomes an object file"   $cc -DDEEPGBUFFER_IMPLEMENTATION -x c deepgbuffer.h
    attempt "the core exports dgb_ only"        exported 'dgb_.*'
    attempt "the core has no mutable global"    no_mutable_data
    attempt "the core needs libc's math, mem*, str* and assert only" imported

    # shellcheck disable=SC2086
    attempt "both become an object file"        $cc $here/implementation.c
    attempt "both export dgb_ and dgbgl_ only"  exported '(dgb|dgbgl)_.*'
    attempt "both have no mutable global"       no_mutable_data
    attempt "both need libc's math, mem*, str* and assert only" imported
} | tee -a "$dir/all.tap"

echo "1..$(grep -cE '^(not )?ok' "$dir/all.tap")"
