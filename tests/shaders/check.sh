#!/bin/sh
# Every shader variant, as tests/shaders/dump.c writes them (NAME.vert, NAME.geom, NAME.frag), passes glslangValidator.
# Prints TAP.

cd "$(dirname "$0")/../.." || exit 1
dir=build/shaders

if ! command -v glslangValidator >/dev/null; then
    if [ "$CI" = true ]; then echo "not ok 1 - glslangValidator is missing"; echo 1..1; exit 1; fi
    echo "1..0 # SKIP glslangValidator is missing"
    exit 0
fi

rm -rf "$dir"
mkdir -p "$dir/text"
"${CC:-cc}" -std=c99 -I. tests/shaders/dump.c -lm -o "$dir/dump" && "$dir/dump" "$dir/text" || exit 1

tests=0
for shader in "$dir"/text/*; do
    [ -e "$shader" ] || continue
    tests=$((tests + 1))
    if glslangValidator "$shader" >"$dir/log"; then
        echo "ok $tests - ${shader##*/}"
    else
        echo "not ok $tests - ${shader##*/}"
        sed 's/^/# /' "$dir/log"
    fi
done
echo "1..$tests"
