#!/bin/sh
# Every fuzz target over its corpus, and over inputs that libFuzzer makes up, where clang has it: for FUZZ_SECONDS, others each
# time, or for 20 seconds, the same each time. The input that makes a target fail stays in build/. Prints TAP.

cd "$(dirname "$0")/../.." || exit 1
. tests/support/tap.sh

seed=${FUZZ_SECONDS:+0} # 0: another each time
seed=${seed:-1}

known() { "build/sanitize/tests/fuzz/fuzz_$target" "$corpus"/*; }
new() {
    set -- "$dir/$target" "$corpus" -max_total_time="${FUZZ_SECONDS:-20}" -seed="$seed"
    set -- "$@" -max_len=4096 -timeout=20 -rss_limit_mb=4096
    if [ -f "tests/fuzz/$target.dict" ]; then set -- "$@" -dict="tests/fuzz/$target.dict"; fi
    mkdir "$dir/$target" && "build/fuzz/tests/fuzz/fuzz_$target" "$@" -artifact_prefix="build/$target-"
}

for source in tests/fuzz/fuzz_*.c*; do
    target=${source#tests/fuzz/fuzz_}
    target=${target%.c*}
    corpus=tests/fuzz/corpus/$target
    check "$target: corpus" known
    if [ -x "build/fuzz/tests/fuzz/fuzz_$target" ]; then
        check "$target: new inputs" new
    else
        tests=$((tests + 1))
        echo "ok $tests - $target: new inputs # SKIP libFuzzer is missing (Debian, Ubuntu: libclang-rt-dev)"
    fi
done
echo "1..$tests"
