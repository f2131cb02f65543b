#!/bin/sh
# build/release/integrations/*: each uses the library in as few lines as its first comment promises, and writes a picture that
# shows what it says. Prints TAP.

cd "$(dirname "$0")/../.." || exit 1
. tests/support/tap.sh

source_of() { ls examples/integrations/"$1".c examples/integrations/"$1".cpp 2>/dev/null; }
program_of() { echo build/release/integrations/"$1"; }

# >> the sources

# The lines between the marks, which do not count themselves, nor do empty ones.
of_library() {
    awk '/^ *\/\* << deepgbuffer \*\/$/ { on = 0 } on && NF { print } /^ *\/\* >> deepgbuffer \*\/$/ { on = 1 }' "$1"
}
promised() { sed -n '1,6s/.*<< deepgbuffer`[^0-9]* \([0-9]*\) lines.*/\1/p' "$1"; }
is_short() {
    lines=$(of_library "$1" | wc -l) promise=$(promised "$1")
    echo "$lines lines of $promise"
    [ "$lines" -ge 10 ] && [ "$promise" -le "$2" ] && [ "$lines" -le "$promise" ]
}
says_how() { for word in build run copy; do sed -n '2,6p' "$1" | grep -q "^   $word " || return 1; done; }
no_name_outside() {
    of_library "$1" >"$dir/library"
    ! grep -vxFf "$dir/library" "$1" | grep -E 'dgb(gl)?_[a-z]' | grep -v dgb_view
}
knows_no_gl() { ! grep -nE '(^|[^A-Za-z])(gl[A-Z_]|GL|dgbgl|epoxy|engine_program)' "$1"; }

# uses NAME LINES: the most that it may promise
uses() {
    check "$1 says how to build, to run and what to copy" says_how "$(source_of "$1")"
    check "$1 uses the library in $2 lines"               is_short "$(source_of "$1")" "$2"
    if [ "$1" != raii ]; then
        check "$1: all of it is marked, but for the camera" no_name_outside "$(source_of "$1")"
    fi
}

uses ao_depth 30
uses raw_gl 60
uses sdl2 30
uses gles3 60
uses custom_rhi 100
uses raii 50
check "custom_rhi.c knows no OpenGL" knows_no_gl examples/integrations/custom_rhi.c

# >> pictures: P6, 960 x 540

# run NAME FILE MORE...: what it prints is in $dir/out_NAME
run() {
    integration=$1
    shift
    "$(program_of "$integration")" "$@" >"$dir/out_$integration"
}

# The values of pixels in a row from X Y on, which goes on in the next row; of channel 0, 1 or 2.
values() { # FILE X Y COUNT CHANNEL
    od -An -v -tu1 -w3 -j $((15 + 3 * (960 * $3 + $2))) -N $((3 * $4)) "$1" | awk -v c="$(($5 + 1))" '{ print $c }'
}
mean()   { values "$@" | awk '{ sum += $1 } END { print sum / NR }'; }
lowest() { values "$@" | sort -n | head -n 1; }
between() { # LOW VALUE HIGH
    echo "$2"
    awk -v low="$1" -v x="$2" -v high="$3" 'BEGIN { exit !(x != "" && low <= x && x <= high) }'
}
less_by() { # LEAST DIFFERENCE, FROM, TO
    echo "from $2 to $3"
    awk -v least="$1" -v from="$2" -v to="$3" 'BEGIN { exit !(from != "" && to != "" && from - to >= least) }'
}
complete() { [ "$(head -n 1 "$1")" = "P6 960 540 255" ] && [ "$(wc -c <"$1")" -eq $((15 + 960 * 540 * 3)) ]; }
grey_is_grey() {
    tail -n +2 "$1" | od -An -v -tu1 -w3 | awk '{ bad += $1 != $2 || $2 != $3 } END { exit bad || !NR }'
}

# picture NAME: writes $dir/NAME.ppm, and refuses wrong arguments
picture() {
    check "$1 refuses no argument at all"               refuses "$(program_of "$1")"
    check "$1 refuses a picture that cannot be written" refuses "$(program_of "$1")" "$dir/missing/a.ppm"
    check "$1 writes a picture"                         run "$1" "$dir/$1.ppm"
    check "$1: the picture is complete"                 complete "$dir/$1.ppm"
}

value_of() { sed -n "s/.*$1 \([0-9.]*\).*/\1/p" "$dir/out_ao_depth"; }
renders_again() { run ao_depth "$dir/again.ppm" && cmp "$dir/ao_depth.ppm" "$dir/again.ppm"; }

picture ao_depth
a=$dir/ao_depth.ppm
check "ao_depth refuses two arguments"                refuses "$(program_of ao_depth)" "$dir/b.ppm" "$dir/c.ppm"
check "the darkest corner is dark, but not black"     between 0.1 "$(value_of min)" 0.5
check "most of the scene is open"                     between 0.85 "$(value_of mean)" 0.97
check "the picture is grey"                           grey_is_grey "$a"
check "the flat floor in front is white"              between 250 "$(lowest "$a" 0 430 $((960 * 110)) 0)" 255
check "the empty part of the wall is white"           between 250 "$(lowest "$a" 700 100 260 0)" 255
check "the front of the beam is white"                between 250 "$(lowest "$a" 370 30 250 0)" 255
check "the floor under the crate is in its shadow"    between 50 "$(lowest "$a" 250 283 40 0)" 150
check "the wall between two columns is in theirs"     between 80 "$(lowest "$a" 415 120 60 0)" 200
check "rendering again writes the same picture"       renders_again

picture custom_rhi
check "an interface of the engine's own draws the same as OpenGL" cmp "$a" "$dir/custom_rhi.ppm"

picture raii
check "an owner that was moved draws the same"        cmp "$a" "$dir/raii.ppm"
check "a wrong size is an exception that says so"     grep -x "error: DGB_INVALID: width and height .*" "$dir/out_raii"
check "so is a call out of turn"                      grep "^error: DGB_INVALID: there is nothing to" "$dir/out_raii"

# The second layer is what the post in the middle, in front of the wall, hides of the steps' and the wall's corner.
picture gles3
check "gles3 draws one layer"                         run gles3 "$dir/gles3_1.ppm" 1
check "gles3 refuses ten layers"                      refuses "$(program_of gles3)" "$dir/no.ppm" 10
check "the wall behind the post is darker with two layers" \
    less_by 20 "$(mean "$dir/gles3_1.ppm" 440 228 20 0)" "$(mean "$dir/gles3.ppm" 440 228 20 0)"
check "the floor in front, with nothing behind it, is not" \
    cmp -i 1248015 "$dir/gles3_1.ppm" "$dir/gles3.ppm" # from row 433 on
check "the floor under the crate is in its shadow"    between 50 "$(lowest "$dir/gles3.ppm" 250 283 40 0)" 150

# The red column's side turns away from the sun and towards what the column hides of the sunlit wall.
picture raw_gl
check "raw_gl draws one layer"                        run raw_gl "$dir/raw_gl_1.ppm" 1
check "light from behind the column reaches its side" \
    less_by 3 "$(mean "$dir/raw_gl.ppm" 567 150 3 0)" "$(mean "$dir/raw_gl_1.ppm" 567 150 3 0)"
fence() { mean "$dir/raw_gl.ppm" 420 "$1" 45 "$2"; } # ROW CHANNEL
check "the fence is green"                            less_by 50 "$(fence 238 1)" "$(fence 238 0)"
check "its holes show the wall, which is not"         less_by 20 "$(fence 246 0)" "$(fence 238 0)"

# >> sdl2, in a window that nobody sees

in_window() { xvfb-run -a -s '-screen 0 1280x800x24' "$@"; }
no_display() { env DISPLAY= WAYLAND_DISPLAY= SDL_VIDEODRIVER=x11 "$@"; }
draws_in_window() { in_window "$(program_of sdl2)" "$dir/sdl2.ppm" && cmp "$a" "$dir/sdl2.ppm"; }
skip() { tests=$((tests + 1)) && echo "ok $tests - $1 # SKIP $2"; }

if [ ! -x "$(program_of sdl2)" ]; then
    skip "sdl2" "SDL2 is not installed"
elif ! command -v xvfb-run >/dev/null; then
    skip "sdl2" "xvfb-run is not installed"
else
    check "sdl2 refuses two arguments"                refuses "$(program_of sdl2)" "$dir/b.ppm" "$dir/c.ppm"
    check "without a display sdl2 says so"            refuses no_display "$(program_of sdl2)"
    check "a window of SDL shows the same picture"    draws_in_window
fi
echo "1..$tests"
