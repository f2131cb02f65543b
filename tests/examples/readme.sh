#!/bin/sh
# What the README says works: its C compiles, its commands name targets, programs and options that there are. (Its CMake is
# built by tests/compile/package.sh.) Prints TAP.

cd "$(dirname "$0")/../.." || exit 1
. tests/support/tap.sh

skip() { tests=$((tests + 1)) && echo "ok $tests - $1 # SKIP $2"; }

# >> C

# What the README leaves to the reader.
cat >"$dir/yours.h" <<'END'
#include "deepgbuffer.h"
static void* scene;
#ifdef __cplusplus
extern "C" {
#endif
void* my_get_proc(const char* name);
void set_matrices(void* s, const float* view, const float* projection, const float* last_view, const float* last_projection);
void draw_opaque(void* s, int instances);
void get_camera(float* view, float* projection);
void light(dgb_texture radiance);
void composite(dgb_texture ao, dgb_texture irradiance);
#ifdef __cplusplus
}
#endif
END
{
    echo '#include "yours.h"'
    sed -n '/^```c$/,/^```$/p' README.md | grep -v '^```'
} >"$dir/use.c"
compiles() { "$@" -Wall -Werror -I. -I"$dir" -c "$dir/use.c" -o "$dir/use.o"; }
names() { nm "$dir/use.o" | grep -qw "T $1"; }

check "the C is C++"            compiles "${CXX:-c++}" -std=c++11 -x c++
check "the C is C99"            compiles "${CC:-cc}" -std=c99 -pedantic
check "it has a frame"          names frame
check "and both libraries"      names dgbgl_init

# >> commands: a line each, from the indented lines and from between backticks

without_fences() { awk '/^```/ { inside = !inside; next } !inside' README.md; }
indented() { without_fences | sed -n 's/^    //p' | sed -e ':join' -e '/\\$/{N;s/\\\n//;bjoin' -e '}' | sed 's/ && /\n/g'; }
quoted() { without_fences | awk 'BEGIN { RS = "`" } NR % 2 == 0 { gsub(/\n/, " "); print }'; }
{ indented; quoted; } | grep -E '^(make |build/release/.*[^/]$)' | tr -d '[]' | sort -u >"$dir/commands"

is_target() { grep -q "^$1:.*##" Makefile || { echo "no target $1"; false; }; }
is_variable() { grep -qE "^$1 +\?=|\\\$\($1\)|if \\\$\($1\)" Makefile || { echo "no variable $1"; false; }; }
makes() {
    for word in "$@"; do
        case $word in *=*) is_variable "${word%%=*}" ;; *) is_target "$word" ;; esac || return 1
    done
}
# Options that stand in a source of the program, for programs that would take long to run.
knows() { # SOURCES WORD...
    sources=$1
    shift
    for word in "$@"; do
        # shellcheck disable=SC2086 # a list
        case $word in --*) grep -q "\"$word\"" $sources || { echo "no option $word"; return 1; } ;; esac
    done
}
# Options are read before a window is opened.
shows() {
    env DISPLAY= WAYLAND_DISPLAY= build/release/viewer "$@" 2>&1 | tee "$dir/viewer" | grep -qE 'no display|^Usage'
    grep -E 'no display|^Usage' "$dir/viewer" || { cat "$dir/viewer"; false; }
}
accepts() {
    case $1 in
    make) shift && makes "$@" ;;
    build/release/render) "$@" --plan >/dev/null ;;
    build/release/viewer) shift && shows "$@" ;;
    build/release/trade) shift && knows "$(ls tests/trade/*.cpp)" "$@" ;;
    build/release/tests/bench/*) [ -e "tests/bench/${1##*/}.cpp" ] && shift && knows tests/bench/bench.hpp "$@" ;;
    *) echo "what is $1?" && false ;;
    esac
}
refuses_wrong() { ! accepts "$@"; }

check "there are commands"      [ "$(wc -l <"$dir/commands")" -ge 20 ]
while read -r command; do
    case $command in
    build/release/viewer*) [ -x build/release/viewer ] || { skip "$command" "Dear ImGui is not installed" && continue; } ;;
    esac
    # shellcheck disable=SC2086 # words
    check "$command" accepts $command </dev/null
done <"$dir/commands"

# >> pictures: those that are there, those that are shown and those that examples/pictures/make.sh makes are the same, and the
# captions give its commands

one_line() { tr -s '\n' ' ' <"$1"; }
pictures_agree() { # README LIST
    find examples/pictures -name '*.png' | sed 's|.*/\(.*\)\.png|\1|' | sort >"$dir/there"
    grep -o 'examples/pictures/[a-z0-9_]*\.png' "$1" | sed 's|.*/\(.*\)\.png|\1|' | sort -u >"$dir/shown"
    cut -d ' ' -f 1 "$2" | sort >"$dir/made"
    diff "$dir/there" "$dir/shown" && diff "$dir/there" "$dir/made"
}
captions_agree() { # README LIST
    cut -d ' ' -f 3- "$2" | sed 's/ + /\n/' | sort -u | while read -r part; do
        one_line "$1" | grep -qF -e "\`$part\`" || { echo "no caption says $part"; exit 1; }
    done
}
examples/pictures/make.sh --list >"$dir/list"
check "every picture is shown and made" pictures_agree README.md "$dir/list"
check "captions say how"                captions_agree README.md "$dir/list"

mkdir "$dir/pictures"
makes_one() {
    PICTURES=$dir/pictures examples/pictures/make.sh border_without && [ "$(ls "$dir/pictures")" = border_without.png ]
}
skips_scenes() {
    SCENE_DIR=$dir PICTURES=$dir/pictures examples/pictures/make.sh sponza_layer0 | grep 'skipped: there is no sponza.glb' &&
        [ ! -e "$dir/pictures/sponza_layer0.png" ]
}
check "one picture is made"             makes_one
check "without its scene, none"         skips_scenes

# The check itself can fail.
grep -v halos "$dir/list" >"$dir/fewer"
sed 's/--guard 0$/--guard 1/' "$dir/list" >"$dir/other"
disagrees() { ! "$@"; }
check "a picture that is not made is found" disagrees pictures_agree README.md "$dir/fewer"
check "a caption of another is found"       disagrees captions_agree README.md "$dir/other"
check "a wrong target is found"   refuses_wrong make demolish
check "a wrong variable is found" refuses_wrong make bench SCENERY=x
check "a wrong option is found"   refuses_wrong build/release/render --out DIR --sizes 1x1
if [ -x build/release/viewer ]; then
    check "of the viewer, too"    refuses_wrong build/release/viewer --sizes 1x1
fi
check "of a benchmark, too"       refuses_wrong build/release/tests/bench/oracles --slow
check "a wrong program is found"  refuses_wrong build/release/rendered --out DIR
echo "1..$tests"
