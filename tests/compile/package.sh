#!/bin/sh
# The versions that the headers state agree, and what `make install` and the README's CMake lines give compiles. Prints TAP.

cd "$(dirname "$0")/../.." || exit 1
. tests/support/tap.sh

# >> versions

number() { sed -n "s/^#define $2_VERSION_$3 //p" "$1"; }
string() { sed -n "s/^#define $2_VERSION_STRING \"\(.*\)\"/\1/p" "$1"; }
version=$(string deepgbuffer.h DGB)

is_version() { echo "$version" | grep -xE '[0-9]+\.[0-9]+\.[0-9]+'; }
states() { # FILE PREFIX
    echo "$1: numbers, string, title: $version?"
    [ "$(number "$1" "$2" MAJOR).$(number "$1" "$2" MINOR).$(number "$1" "$2" PATCH)" = "$version" ] &&
        [ "$(string "$1" "$2")" = "$version" ] && head -n 1 "$1" | grep -F " - v$version - "
}
history_begins_with() { sed -n '/^   VERSION HISTORY$/{n;p;}' deepgbuffer.h | grep -F " $1 "; }

# Another version of the core, with this backend.
mixed() {
    mkdir -p "$dir/mixed" && cp deepgbuffer_gl.h "$dir/mixed" &&
        sed 's/^\(#define DGB_VERSION_PATCH\) .*/\1 99/' deepgbuffer.h >"$dir/mixed/deepgbuffer.h" &&
        ! ${CC:-cc} -std=c99 -fsyntax-only -I"$dir/mixed" tests/compile/user.c 2>"$dir/error" &&
        grep "take both from one release" "$dir/error"
}

check "the version is three numbers"                    is_version
check "deepgbuffer.h says it everywhere alike"          states deepgbuffer.h DGB
check "deepgbuffer_gl.h says the same"                  states deepgbuffer_gl.h DGBGL
check "the version history begins with it"              history_begins_with "$version"
check "headers of two versions do not compile together" mixed

# >> make install

cat >"$dir/main.c" <<'END'
#define DEEPGBUFFER_IMPLEMENTATION
#include <deepgbuffer.h>
#include <deepgbuffer_gl.h>
#include <stdio.h>
int main(void) {
    printf("%s %d\n", DGB_VERSION_STRING, dgb_spiral_turns(9));
    return dgbgl_texture_name(dgbgl_texture(7)) != 7;
}
END
says_version() { echo "$1"; [ "$1" = "$version 2" ]; }

stage=$dir/stage prefix=/opt/of\ deepgbuffer
make_quietly() { env -u MAKEFLAGS -u MAKELEVEL make -s "$@" prefix="$prefix" DESTDIR="$stage"; }
installed() { (cd "$stage$prefix" && find . -type f | sort | tr '\n' ' '); }
is_installed() {
    installed
    [ "$(installed)" = "./include/deepgbuffer.h ./include/deepgbuffer_gl.h ./share/pkgconfig/deepgbuffer.pc " ]
}
package() { PKG_CONFIG_PATH=$dir/prefix/share/pkgconfig pkg-config "$@" deepgbuffer; }
nothing_is_left() { [ -z "$(installed)" ]; }
skip() { tests=$((tests + 1)) && echo "ok $tests - $1 # SKIP $2"; }

check "make install copies the headers"                 make_quietly install
check "and a pkg-config file"                           is_installed
check "the headers are the same"                        cmp deepgbuffer_gl.h "$stage$prefix/include/deepgbuffer_gl.h"
check "make uninstall removes them"                     make_quietly uninstall
check "and leaves nothing"                              nothing_is_left

compiles() {
    # shellcheck disable=SC2046 # flags are words
    ${CC:-cc} -std=c99 "$dir/main.c" -o "$dir/program" $(package --cflags --libs) &&
        says_version "$("$dir/program")"
}
with_pkg_config() {
    stage='' prefix=$dir/prefix
    check "make install without DESTDIR"                make_quietly install
    check "pkg-config knows the version"                [ "$(package --modversion)" = "$version" ]
    check "a program compiles by its flags"             compiles
}
if command -v pkg-config >/dev/null; then with_pkg_config; else skip "pkg-config" "it is not installed"; fi

# >> CMake, by the README's own lines

cmake_project() {
    {
        echo 'cmake_minimum_required(VERSION 3.14)'
        echo 'project(test C)'
        echo 'add_executable(my_program main.c)'
        sed -n '/^```cmake$/,/^```$/p' README.md | grep -v '^```'
    } >"$dir/CMakeLists.txt"
    cmake -S "$dir" -B "$dir/cmake" -DFETCHCONTENT_SOURCE_DIR_DEEPGBUFFER="$PWD" &&
        cmake --build "$dir/cmake" && says_version "$("$dir/cmake/my_program")"
}
if command -v cmake >/dev/null; then
    check "the README's CMake lines build a program"    cmake_project
else
    skip "CMake" "it is not installed"
fi
echo "1..$tests"
