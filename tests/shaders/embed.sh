#!/bin/sh
# shaders_embedded/embed.c: deepgbuffer_gl.h holds the shaders as they are, and the program does what it says. Prints TAP.

cd "$(dirname "$0")/../.." || exit 1
dir=$(mktemp -d) || exit 1
trap 'rm -rf "$dir"' EXIT

embed=$dir/embed
"${CC:-cc}" -std=c99 -pedantic -Wall -Wextra -Werror -O1 shaders_embedded/embed.c -o "$embed" || exit 1

tests=0
# report NAME: reports whether the last command succeeded, and what $dir/log says when it did not
report() {
    result=$?
    tests=$((tests + 1))
    if [ $result -eq 0 ]; then echo "ok $tests - $1"; else echo "not ok $tests - $1"; sed 's/^/# /' "$dir/log"; fi
}

"$embed" --check deepgbuffer_gl.h shaders_embedded/*.glsl >"$dir/log" 2>&1
report "deepgbuffer_gl.h holds shaders_embedded/*.glsl"

# >> what is written

header() {
    echo 'int before;'
    echo '/* >> embedded GLSL: written by shaders_embedded/embed.c from shaders_embedded/; run "make embed" */'
    echo 'old text'
    echo '/* << embedded GLSL */'
    echo 'int after;'
}
header >"$dir/h.h"
printf 'float a; // "quoted" \\ ??/ ???=  \n\n  float b;' >"$dir/03_first.glsl"
awk 'BEGIN { for (i = 0; i < 1000; i++) print "float value_" i "; // a line of some length" }' >"$dir/10_long_one.glsl"

"$embed" "$dir/h.h" "$dir"/*.glsl >"$dir/log" 2>&1
report "writes"
"$embed" --check "$dir/h.h" "$dir"/*.glsl >"$dir/log" 2>&1
report "finds no difference in what it wrote"
[ "$(sed -n '1p;$p' "$dir/h.h")" = "int before;
int after;" ] && ! grep -q 'old text' "$dir/h.h"
report "replaces what is between the markers and nothing else"

cat >"$dir/print.c" <<'END'
#include "h.h"
#include <stdio.h>
#include <string.h>
static int print(const char* const* text, int most) {
    for (; *text; text++) {
        if (strlen(*text) > 4000) { most = 1; }
        fputs(*text, stdout);
    }
    return most;
}
int main(void) { return print(dgbgli_glsl_first, 0) + print(dgbgli_glsl_long_one, 0) + before + after; }
END
{ echo '#line 30001'; sed 's/ *$//' "$dir/03_first.glsl"; echo; echo '#line 100001'; cat "$dir/10_long_one.glsl"; } >"$dir/want"
"${CC:-cc}" -std=c99 -pedantic -Wall -Wextra -Werror "$dir/print.c" -o "$dir/print" >"$dir/log" 2>&1 &&
    "$dir/print" >"$dir/got" && diff "$dir/want" "$dir/got" >"$dir/log"
report "the literals are at most 4000 bytes and give back the text"

# >> what is refused

# refuses TEXT MESSAGE: with TEXT as second line of a shader, embed fails, says FILE:2: MESSAGE and writes nothing
refuses() {
    mkdir -p "$dir/bad"
    printf 'float a;\n%b\n' "$1" >"$dir/bad/20_bad.glsl"
    header >"$dir/bad/h.h"
    ! "$embed" "$dir/bad/h.h" "$dir/bad/20_bad.glsl" >"$dir/log" 2>&1 &&
        grep -q "20_bad.glsl:2: .*$2" "$dir/log" && header | diff - "$dir/bad/h.h" >>"$dir/log"
    report "refuses a line: $2"
}
refuses 'float\tb;' 'a tab'
refuses 'float b; // \303\251' 'not printable ASCII'
refuses '#version 330' '#version'
refuses ' # include "x"' '#include'

header >"$dir/h.h"
! "$embed" --check "$dir/h.h" "$dir"/*.glsl >"$dir/log" 2>&1 &&
    grep -q "differs from shaders_embedded/: run .make embed." "$dir/log" && grep -q 'h.h:3:' "$dir/log"
report "says how to repair a difference and names its first line"
! "$embed" "$dir/h.h" "$dir/10_long_one.glsl" "$dir/03_first.glsl" >"$dir/log" 2>&1
report "refuses shaders out of order"
sed '/<</d' "$dir/h.h" >"$dir/unmarked.h"
! "$embed" "$dir/unmarked.h" "$dir/03_first.glsl" >"$dir/log" 2>&1
report "refuses a header without markers"

echo "1..$tests"
