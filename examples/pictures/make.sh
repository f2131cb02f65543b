#!/bin/sh
# Makes the README's pictures anew, by the commands of their captions.
#     examples/pictures/make.sh [NAME...]     all, or those; a picture whose scene is not in SCENE_DIR is skipped
#     examples/pictures/make.sh --list        the list below
# They go where these are, or to PICTURES. optipng, where it is installed, makes them smaller.

# The picture, which file of its command it is, its command; after a + what the caption calls "with".
list() {
    sponza='build/release/render sponza.glb --out DIR --size 480x270 --preset quality --samples 60 --ao-samples 40'
    sponza="$sponza --camera=-9.8,1.5,3.7,4,1.8,3.2,60 --sun 0.25,0.95,0.15,10 --sky 0.02,0.026,0.032 --exposure 4"
    thickness='build/release/render gallery --out DIR --size 240x180 --guard 200 --effects ao,gi,reflect --time 2.2'
    thickness="$thickness --camera=0,1.7,3.2,2.8,1.65,-4,42"
    border='build/release/render --out DIR --size 240x160 --preset quality --samples 60 --frames 4'
    border="$border --camera=-6,1.7,-2,4,1.2,4,60 --sky 0.02,0.02,0.02 --exposure 1"
    cat <<END
halos visibility_one_vs_two build/release/render gallery --out DIR --size 320x240 --effects ao --preset quality \
    --ao-samples 40 --ao-radius 2.5 --camera=0.5,1.6,1,-4,1.5,-4,60
hidden_light one_vs_two build/release/render --out DIR --size 400x225 --preset quality --samples 60 --ao-samples 40 \
    --sky 0.02,0.02,0.02 --exposure 2
gallery_mirrors one_vs_two build/release/render gallery --out DIR --size 480x270 --effects ao,gi,reflect --guard 48 --time 2.2
thickness_thin final $thickness + --layers 1 --thickness-from constant --reflect-thickness 0.05
thickness_middle final $thickness + --layers 1 --thickness-from constant --reflect-thickness 0.5
thickness_thick final $thickness + --layers 1 --thickness-from constant --reflect-thickness 5
thickness_layers final $thickness
border_without final $border + --guard 0
border_with final $border
disocclusion disocclusion build/release/render --out DIR --size 480x270 --orbit 1
bounces bounces build/release/render --out DIR --size 320x180 --preset quality --compare-bounces 1,2,100 \
    --camera -15,7.2,-7,0,6.5,-7,70 --sun 0.3,0.5,0.6,12 --sky 0.01,0.015,0.02 --radius 12
sponza_one_vs_two one_vs_two $sponza
sponza_layer0 layer0 $sponza
sponza_layer1 layer1 $sponza
viewer FILE build/release/viewer gallery --size 960x540 --guard 48 --camera=0,1.7,3.2,1.9,1.65,-6,75 \
    --effects ao,gi,glossy --preset quality --split 0.79 --frames 8 --screenshot FILE.png
END
}

cd "$(dirname "$0")/../.." || exit 1
if [ "$*" = --list ]; then list | tr -s ' ' && exit; fi
wanted=" $* "
made=$(mktemp -d) || exit 1
trap 'rm -rf "$made"' EXIT

shown() { [ -n "${DISPLAY:-}${WAYLAND_DISPLAY:-}" ]; }

# Why the command cannot run here; nothing when it can.
missing() { # PROGRAM SCENE
    case $2 in
    *.glb) [ -e "${SCENE_DIR:-}/$2" ] || { echo "there is no $2 in SCENE_DIR=${SCENE_DIR:-}" && return; } ;;
    esac
    case $1 in
    */viewer)
        [ -x "$1" ] || { echo "Dear ImGui is missing" && return; }
        shown || command -v xvfb-run >/dev/null || echo "there is no display, and no xvfb-run" ;;
    esac
}

# Each command runs once, in a directory of its own, with the file and the directory it names in place.
run() { # DIRECTORY PROGRAM WORD...
    out=$1 words=
    shift
    [ ! -d "$out" ] || return 0
    mkdir "$out"
    for word in "$@"; do
        case $word in
        DIR)      word=$out ;;
        FILE.png) word=$out/FILE.png ;;
        *.glb)    word=$SCENE_DIR/$word ;;
        +)        continue ;;
        esac
        words="$words $word"
    done
    case $1 in */viewer) shown || words="xvfb-run -a $words" ;; esac
    # shellcheck disable=SC2086 # words
    $words >"$out/log" 2>&1 </dev/null || { cat "$out/log" >&2 && return 1; }
}

list | while read -r name file command; do
    case $wanted in '  ' | *" $name "*) ;; *) continue ;; esac
    # shellcheck disable=SC2086 # words
    set -- $command
    why=$(missing "$1" "$2")
    if [ -n "$why" ]; then echo "$name: skipped: $why" && continue; fi
    out=$made/$(echo "$command" | cksum | cut -d ' ' -f 1)
    run "$out" "$@" || exit 1
    picture=${PICTURES:-examples/pictures}/$name.png
    cp "$out/$file.png" "$picture" || exit 1
    if command -v optipng >/dev/null; then optipng -quiet -o2 -strip all "$picture" || exit 1; fi
    echo "$name: $(wc -c <"$picture") bytes"
done
