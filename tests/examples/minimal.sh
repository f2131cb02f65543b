#!/bin/sh
# build/release/minimal saves a frame that shows something, refuses wrong arguments, and has a short source.
# Prints TAP.

cd "$(dirname "$0")/../.." || exit 1
. tests/support/tap.sh

minimal=build/release/minimal

no_display() { env DISPLAY= WAYLAND_DISPLAY= "$@"; }
is_short() { lines=$(wc -l <examples/minimal.c); echo "$lines lines"; [ "$lines" -lt 150 ]; }

check "examples/minimal.c has less than 150 lines"  is_short
check "one argument is refused"                     refuses $minimal 3
check "three arguments are refused"                 refuses $minimal 3 "$dir/a.ppm" more
check "no frames at all are refused"                refuses $minimal 0 "$dir/a.ppm"
check "a negative number of frames is refused"      refuses $minimal -1 "$dir/a.ppm"
check "a word for the number of frames is refused"  refuses $minimal many "$dir/a.ppm"
check "without a display it says so"                refuses no_display $minimal 3 "$dir/a.ppm"
check "refusals write nothing"                      [ ! -e "$dir/a.ppm" ]

# >> frames, in a window that nobody sees

render() { xvfb-run -a -s '-screen 0 1280x800x24' $minimal "$@"; }

differ() { cmp -s "$1" "$2"; [ $? -eq 1 ]; }
size_is() { [ "$(wc -c <"$1")" -eq "$2" ]; }
header_is() { [ "$(head -n 1 "$1")" = "$2" ]; }

# The pixels of a picture, one a line: red, green, blue.
pixels() {
    tail -n +2 "$1" | od -An -v -tu1 |
        awk '{ for (i = 1; i <= NF; ++i) printf "%s%s", $i, ++n % 3 ? " " : "\n" }'
}

# White, strong colours and dark, each on a good part of the picture.
shows_something() {
    pixels "$1" | awk '
        { low = $1 < $2 ? $1 : $2; if ($3 < low) low = $3
          high = $1 > $2 ? $1 : $2; if ($3 > high) high = $3
          white += low > 230; colored += high - low > 120; dark += high < 128; values[$1, $2, $3] }
        END { for (v in values) ++colors
              print white + 0, "white", colored + 0, "strongly coloured", dark + 0, "dark;", colors, "colours"
              exit !(white > 0.01 * NR && colored > 0.05 * NR && dark > 0.05 * NR && colors > 1000) }'
}

frames() {
    check "it saves the third frame"                render 3 "$dir/3.ppm"
    check "the frame is a picture of 960 x 540"     header_is "$dir/3.ppm" "P6 960 540 255"
    check "the picture is complete"                 size_is "$dir/3.ppm" $((15 + 960 * 540 * 3))
    check "the picture shows something"             shows_something "$dir/3.ppm"
    check "it saves the third frame again"          render 3 "$dir/again.ppm"
    check "both are the same"                       cmp "$dir/3.ppm" "$dir/again.ppm"
    check "it saves the first frame"                render 1 "$dir/1.ppm"
    check "the camera has moved by the third"       differ "$dir/1.ppm" "$dir/3.ppm"
    check "a picture that cannot be written fails"  refuses render 1 "$dir/missing/1.ppm"
}

if command -v xvfb-run >/dev/null; then
    frames
elif [ "$CI" = true ]; then
    check "xvfb-run is installed" false
else
    tests=$((tests + 1))
    echo "ok $tests - frames # SKIP xvfb-run is not installed"
fi
echo "1..$tests"
