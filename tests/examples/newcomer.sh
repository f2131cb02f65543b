#!/bin/sh
# What somebody meets who has just arrived: no driver, an old one, no display, a wrong file, a missing package. Each ends with
# one sentence that says what to do. Prints TAP.

cd "$(dirname "$0")/../.." || exit 1
. tests/support/tap.sh

release=build/release

# says WORDS COMMAND...: refuses, in a sentence with these words
says() {
    words=$1
    shift
    refuses "$@" && grep -F -- "$words" "$dir/err"
}
skip() { tests=$((tests + 1)) && echo "ok $tests - $1 # SKIP $2"; }

no_driver() { env __EGL_VENDOR_LIBRARY_FILENAMES="$dir/missing.json" "$@"; }
old_driver() { env MESA_GL_VERSION_OVERRIDE=3.2 "$@"; }
no_display() { env DISPLAY= WAYLAND_DISPLAY= "$@"; }
in_window() { xvfb-run -a -s '-screen 0 1280x800x24' "$@"; }
refuses_in_window() { words=$1 && shift && in_window "$@" 2>&1 | tee "$dir/err" | grep -F -- "$words"; }

render="$release/render --size 64x48 --out $dir/pictures"

# shellcheck disable=SC2086 # words
{
check "without a driver render says which"            says "libegl-mesa0" no_driver $render
check "so does what has no window"                    says "libegl-mesa0" no_driver $release/integrations/ao_depth "$dir/a.ppm"
check "an old driver: render says what may help"      says "LIBGL_ALWAYS_SOFTWARE=1" old_driver $render
check "so does what has no window, with it"           says "LIBGL_ALWAYS_SOFTWARE=1" old_driver $release/integrations/raw_gl "$dir/a.ppm"
check "without a display minimal says how to get one" says "xvfb-run -a" no_display $release/minimal
check "a file that is not there is named"             says '"missing.glb" does not exist' $render missing.glb
check "a file of another kind is called so"           says "not valid glTF" $render README.md
check "a place where nothing can be written is named" says "/dev/null" $release/render --size 64x48 --out /dev/null/out
check "nothing was written"                           [ ! -e "$dir/pictures" ]
}

if [ -x $release/viewer ]; then
    check "without a display viewer says how to get one" says "xvfb-run -a" no_display $release/viewer
    if command -v xvfb-run >/dev/null; then
        check "an old driver: viewer says what may help" \
            refuses_in_window "LIBGL_ALWAYS_SOFTWARE=1" env MESA_GL_VERSION_OVERRIDE=3.2 $release/viewer --frames 1
    fi
else
    skip "viewer" "Dear ImGui is not installed"
fi

# >> a machine without packages

no_packages() { env -u MAKEFLAGS -u MAKELEVEL PKG_CONFIG_LIBDIR="$dir" make "$@"; }
names_package() { ! no_packages -n examples >"$dir/make" 2>&1 && grep "egl is missing: .make setup." "$dir/make"; }
check_needs_none() { no_packages -n check >"$dir/make" 2>&1; }
check "make examples names what is missing"           names_package
check "make check needs none"                         check_needs_none
echo "1..$tests"
