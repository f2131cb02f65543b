#!/bin/sh
# build/release/viewer in a window that nobody sees: its command line, what its screenshots show, and that neither wrong
# input nor a new size ends it. Prints TAP.

cd "$(dirname "$0")/../.." || exit 1
. tests/support/tap.sh

viewer=$PWD/build/release/viewer
render=$PWD/build/release/render
export LP_NUM_THREADS=2

skip() {
    echo "1..0 # SKIP $1"
    exit 0
}

if ! pkg-config --exists imgui; then skip "Dear ImGui is not installed"; fi
if ! command -v xvfb-run >/dev/null; then
    if [ "$CI" = true ]; then
        check "xvfb-run is installed" false
        echo "1..1"
        exit 1
    fi
    skip "xvfb-run is not installed"
fi

# >> without a window

options='size guard layers separation oracle emit divisor effects preset samples radius ao-samples ao-radius camera sun point
         sky probe exposure frames orbit clip time fps tracer roughness estimator slices thickness thickness-from view split screenshot path left no-panel no-labels'

help_names_all() {
    $viewer --help >"$dir/help" || return 1
    for option in $options; do
        grep -q -e "^ *--$option[ {]" "$dir/help" || { echo "--$option is missing"; return 1; }
    done
}
no_display() { env DISPLAY= WAYLAND_DISPLAY= "$@"; }
says() { refuses "$@" && cat "$dir/err" && grep -q "$sentence" "$dir/err"; }
refused() { # SENTENCE ARGUMENT...
    sentence=$1
    shift
    check "refused: $*" says "$viewer" "$@"
}

check "--help names every option"         help_names_all
sentence='there is no display .*xvfb-run'
check "without a display it says what to do" says no_display "$viewer"
refused 'not expected'                         --unknown
refused 'must be one of final, .*layer with'   --view shape
refused 'must be one of'                       --view ao1
refused 'must be one of'                       --view albedo8
refused 'must be 0 to 1'                       --split 1.5
refused 'must end in .png or .pfm'             --frames 1 --screenshot a.jpg
refused 'needs --frames'                       --screenshot a.png
refused 'there is no directory "missing"'      --frames 1 --screenshot missing/a.png
refused 'no-panel'                             --no-panel=maybe
refused 'must be 1, 2 or 4'                    --left '--divisor 3'
refused 'sun'                                  --left '--sun none'

# >> with a window that nobody sees

Xvfb -displayfd 3 -screen 0 1024x768x24 3>"$dir/display" 2>"$dir/server" &
server=$!
trap 'kill $server; rm -rf "$dir"' EXIT
trap 'exit 1' INT TERM
for wait in 1 2 3 4 5 6 7 8 9 10; do if [ -s "$dir/display" ]; then break; fi; sleep 0.5; done
DISPLAY=:$(cat "$dir/display")
export DISPLAY
cd "$dir" || exit 1

# Small and few samples, for the software rasteriser. Nothing but the picture, where a test compares pixels.
small="$viewer --size 160x120 --guard 16 --samples 4 --ao-samples 4"
bare="$small --no-panel --no-labels"

# shot NAME ARGUMENT...: both halves' pixels in the third frame; first: in the first one
shot() { name=$1; shift; $bare --frames 3 --screenshot "$name.pfm" "$@"; }
first() { name=$1; shift; $bare --frames 1 --screenshot "$name.pfm" "$@"; }

# The floats of a picture, a pixel a line, the bottom row first.
pixels() { tail -n +4 "$1.pfm" | od -An -v -tf4 -w12; }

# columns_differ A B LOW HIGH: how many pixels of these columns differ by more than rounding
columns_differ() {
    pixels "$1" >a.text
    pixels "$2" | paste -d ' ' a.text - | awk -v low="$3" -v high="$4" '
        { x = (NR - 1) % 160; far = 0
          for (i = 1; i <= 3; ++i) { d = $i - $(i + 3); if (d < 0) d = -d; if (d > 0.012) far = 1 }
          if (x >= low && x < high) count += far }
        END { if (NR != 19200) exit 1; print count + 0 }'
}
same_columns() { n=$(columns_differ "$@"); echo "$n differ"; [ "$n" -eq 0 ]; }
other_columns() { n=$(columns_differ "$@"); echo "$n differ"; [ "$n" -gt 100 ]; }

# With planes of its own, a camera rounds depth otherwise: a pixel in a hundred may then be of another surface.
nearly() { n=$(columns_differ "$1" "$2" 0 160); echo "$n differ"; [ "$n" -lt 192 ]; }

# Dark, bright and coloured parts, and many values.
shows_something() {
    pixels "$1" | awk '
        { low = $1 < $2 ? $1 : $2; if ($3 < low) low = $3
          high = $1 > $2 ? $1 : $2; if ($3 > high) high = $3
          bright += low > 0.6; dark += high < 0.4; colored += high - low > 0.2; values[$1, $2, $3] }
        END { for (v in values) ++colors
              print bright + 0, "bright", dark + 0, "dark", colored + 0, "coloured;", colors + 0, "colours"
              exit !(bright > 200 && dark > 200 && colored > 200 && colors > 500) }'
}
grey() { pixels "$1" | awk '{ bad += $1 != $2 || $2 != $3 } END { print bad + 0, "of", NR; exit bad > 0 || !NR }'; }

# The left half of the window with a panel is a window of its width without one. (Neither has a label.)
panel_leaves() {
    $viewer --size 80x120 --guard 16 --samples 4 --ao-samples 4 --no-panel --no-labels --frames 2 \
        --screenshot half.pfm && pixels panel | awk '(NR - 1) % 160 < 80' >a.text && pixels half >b.text && cmp a.text b.text
}

# Width and height in the header, four bytes each.
png_size_is() { [ "$(od -An -tu1 -j16 -N8 "$1" | tr -s ' ')" = " $2" ]; }
differ() { cmp -s "$1" "$2"; [ $? -eq 1 ]; }
pfm_size_is() { [ "$(head -n 2 "$1" | tail -n 1)" = "$2" ]; }

check "three frames"                               shot both
check "the screenshot has the window's size"       pfm_size_is both.pfm "160 120"
check "it shows something"                         shows_something both
check "three frames again"                         shot again
check "both are the same, bit for bit"             cmp both.pfm again.pfm

check "the left half alone"                        shot left --split 1
check "the right half alone"                       shot right --split 0
check "one layer and two differ"                   other_columns left right 0 160
check "left of the line stands the left one"       same_columns both left 0 80
check "right of it, the right one"                 same_columns both right 80 160
check "the line can stand elsewhere"               shot quarter --split 0.25
check "left of it, the left one"                   same_columns quarter left 0 40
check "right of it, the right one"                 same_columns quarter right 40 160

check "the left half with options of its own"      shot own --split 1 --left '--layers 2'
check "it is what the right one would be"          cmp own.pfm right.pfm
check "more than one of them"                      shot own --split 1 --left '--effects none --divisor 2'
check "it is another picture"                      other_columns own right 0 160

# A byte is half a step of 255 from its value; as much again for the shader's powers, in single precision.
same_as_render() {
    "$render" --size 160x120 --guard 16 --samples 4 --ao-samples 4 --frames 3 --dump final=final.pfm >render.log &&
        pixels final | awk '
            function filmic(x) { return x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14) }
            function srgb(x) { return x <= 0.0031308 ? 12.92 * x : 1.055 * x ^ (1 / 2.4) - 0.055 }
            function shown(x) { x = srgb(filmic(x)); return x < 1 ? x : 1 }
            { print shown($1), shown($2), shown($3) }' >rendered.text &&
        pixels right | paste -d ' ' rendered.text - | awk '
            { for (i = 1; i <= 3; ++i) { d = $i - $(i + 3); if (d < 0) d = -d; if (d > 1 / 255) ++bad } }
            END { print bad + 0, "of", NR, "differ"; exit bad > 0 || NR != 19200 }'
}
check "the picture is that of render"              same_as_render

# >> views

all_effects="--effects ao,gi,glossy --split 0"
views='direct indirect depth normal albedo radiance velocity validity ao irradiance confidence history reflection
       reflection_layer depth1 normal1 albedo1 radiance1 velocity1'
views_are_alike() {
    for view in $views; do shot "view_$view" $all_effects --view "$view" --orbit 1 >/dev/null || return 1; done
    for a in $views; do
        for b in $views; do
            if [ "$a" != "$b" ] && cmp -s "view_$a.pfm" "view_$b.pfm"; then echo "$a is $b"; return 1; fi
        done
    done
    false
}
views_differ() { views_are_alike >views.log; status=$?; cat views.log; [ $status -ne 0 ] && [ ! -s views.log ]; }
empty_is_dark() { pixels "$1" | awk '{ bad += $1 > 0.13 || $1 < 0.11 } END { exit bad > 0 || !NR }'; }

check "every view draws, each another picture"     views_differ
check "ambient visibility is grey"                 grey view_ao
check "confidence is grey"                         grey view_confidence
check "one layer has no layer 1"                   shot none --split 1 --view albedo1
check "then the half is dark grey"                 empty_is_dark none
check "without light there is no irradiance"       shot none --split 0 --view irradiance --effects ao
check "then the half is dark grey"                 empty_is_dark none

# >> panel

check "with the panel, a PNG"                      $viewer --size 640x480 --frames 2 --screenshot panel.png
check "it has the window's size"                   png_size_is panel.png "0 0 2 128 0 0 1 224"
check "the panel in a small window     "            $small --frames 2 --no-labels --screenshot panel.pfm
check "it stands in the right half"                other_columns panel both 80 160
check "and the picture in the left one"            panel_leaves

# >> camera, path

cat >path.txt <<'END'
# from the first frame's camera to another
0  -5 2 3  0 2 -4  60
1   5 3 3  0 2 -4  50
END
cat >middle.txt <<'END'
-1  -5 2 3  0 2 -4  60
 1   5 3 3  0 2 -4  50
END
printf '0 1 2 3\n' >short.txt
printf '1 0 0 0 0 0 1 60\n1 0 0 0 0 0 1 60\n' >still.txt
printf '# none\n' >none.txt

check "--camera moves it"                          shot moved --split 0 --camera=-5,2,3,0,2,-4,60
check "it is another picture"                      other_columns moved right 0 160
check "a path's first key is a camera"             first path --split 0 --path path.txt
check "that --camera can give"                     first key --split 0 --camera=-5,2,3,0,2,-4,60
check "both show the same"                         nearly path key
check "between two keys it is in the middle"       first middle --split 0 --path middle.txt
check "as a camera there is"                       first key --split 0 --camera=0,2.5,3,0,2,-4,55
check "both show the same"                         nearly middle key
check "a second on, the path is elsewhere"         shot later --split 0 --path path.txt --fps 1
check "its last key is a camera, too"              shot last --split 0 --camera=5,3,3,0,2,-4,50
check "and shows other surfaces than the first"    other_columns later path 0 160
check "a mistake in a path is told by its line"    refuses $bare --path short.txt
check "so is time that stands still"               refuses $bare --path still.txt
check "and a path without a camera"                refuses $bare --path none.txt

# >> scenes

check "the gallery moves"                          shot first --split 0 gallery --effects ao
check "later it looks otherwise"                   shot then --split 0 gallery --effects ao --time 2.5
check "for the visitor has moved"                  other_columns first then 0 160
check "a missing file is refused"                  refuses $bare missing.glb
printf 'no glTF' >wrong.glb
check "and one that is not glTF"                   refuses $bare wrong.glb
check "what the library refuses is its sentence"   refuses $bare --layers 2 --oracle peel --emit vertex
check "so is what the left half asks for"          refuses $bare --left '--guard 9000'

# >> input: a new size, keys; only where xdotool can send them

# plays COMMAND...: sends a window these while it draws, and then closes it
# shellcheck disable=SC2016 # the inner shell expands them
plays() {
    $played --frames 100000 >played.out 2>played.err &
    player=$!
    window=$(timeout 20 xdotool search --sync --onlyvisible --name '^deepgbuffer$')
    for command in "$@"; do sleep 1; eval "xdotool $command" || return 1; done
    sleep 1
    kill -0 $player || { cat played.err; return 1; } # it still runs
    kill $player
    wait $player 2>/dev/null
    cat played.err
    [ ! -s played.err ]
}

# The picture after a change of size is that of a window that had it from the start.
# shellcheck disable=SC2016
resized_is_fresh() {
    alone="--guard 16 --effects none --no-panel --no-labels"
    rm -f viewer_001.png
    $viewer --size 160x120 $alone --frames 1 --screenshot fresh.png || return 1
    played="$viewer --size 320x200 $alone"
    plays 'windowsize $window 160 120' 'windowfocus $window key F12' && cmp viewer_001.png fresh.png
}

# shellcheck disable=SC2016
if command -v xdotool >/dev/null; then
    check "a new size gives the picture of that size" resized_is_fresh
    rm -f viewer_001.png
    played=$small
    check "a new size does not end it" plays 'windowsize $window 321 203' 'windowsize $window 64 48' \
        'windowsize $window 200 150'
    check "nor do keys"                plays 'windowfocus $window key F1' 'key F2' 'key F5' 'key F10' 'key Tab Home space'
    check "F12 saves the window"       plays 'windowfocus $window key F12' 'key F1' 'key F12'
    check "its size is the window's"   png_size_is viewer_001.png "0 0 0 160 0 0 0 120"
    check "the next one has a new name" [ -s viewer_002.png ]
    check "without the panel"          differ viewer_001.png viewer_002.png
    check "F9 records a path"          plays 'windowfocus $window key F9' 'key F9'
    check "that can be followed"       first followed --path viewer_path.txt
else
    tests=$((tests + 1))
    echo "ok $tests - input # SKIP xdotool is not installed"
fi
echo "1..$tests"
