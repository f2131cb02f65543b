#!/bin/sh
# What a frame debugger shows of build/release/minimal: every pass is a group with its name, every object of the library has a
# label. Needs apitrace. Prints TAP.

cd "$(dirname "$0")/../.." || exit 1
. tests/support/tap.sh

for command in apitrace xvfb-run; do
    if ! command -v $command >/dev/null; then
        echo "1..0 # SKIP $command is not installed"
        exit 0
    fi
done

trace() {
    xvfb-run -a -s '-screen 0 1280x800x24' apitrace trace -o "$dir/minimal.trace" build/release/minimal 2 "$dir/a.ppm" &&
        apitrace dump --color=never "$dir/minimal.trace" >"$dir/calls"
}
# Names that came back, a line each: `glGenTextures(n = 2, textures = {1, 2})`, or `= &1` for one.
generated() { sed -n "s/.* glGen$1(.* = [&{]\([0-9, ]*\)}*)$/\1/p" "$dir/calls" | tr -d ' ' | tr ',' '\n' | sort -u; }
labelled() {
    sed -n "s/.*glObjectLabel(identifier = GL_$1, name = \([0-9]*\), .* \"dgb [a-z0-9_]*\")/\1/p" "$dir/calls" | sort -u
}
all_labelled() { # GEN KIND LEAST
    generated "$1" >"$dir/generated" && labelled "$2" >"$dir/labelled"
    echo "without a label:"
    [ "$(wc -l <"$dir/generated")" -ge "$3" ] && ! comm -23 "$dir/generated" "$dir/labelled" | grep .
}

# The groups in the order in which they first open. Frames begin with peeling; from the second on images are resolved.
groups() { sed -n 's/.*glPushDebugGroup(.* message = "\([a-z]*\)")/\1/p' "$dir/calls" | awk '!seen[$1]++' | tr '\n' ' '; }
has_groups() { groups && [ "$(groups)" = "layers pack mip tiles ao gather reconstruct resolve " ]; }

# Draws, programs in use and depth of groups: prints each full-screen draw of the library that stands in no group, or in one
# of another name than its program. Draws of the engine are those with programs that have no label.
misplaced_draws() {
    awk '/glObjectLabel\(identifier = GL_PROGRAM/ { match($0, /name = [0-9]+/); id = substr($0, RSTART + 7, RLENGTH - 7)
                                                     match($0, /"dgb [a-z]+"/); label[id] = substr($0, RSTART + 5, RLENGTH - 6) }
         /glUseProgram/     { match($0, /program = [0-9]+/); program = substr($0, RSTART + 10, RLENGTH - 10) }
         /glPushDebugGroup/ { match($0, /"[a-z]+"/); group[++depth] = substr($0, RSTART + 1, RLENGTH - 2) }
         /glPopDebugGroup/  { --depth }
         / glDrawArrays/    { ++draws; if (program in label && (depth != 1 || group[1] != label[program])) print
                              ours += program in label }
         END { if (depth != 0) print "groups left open: " depth
               if (ours < 20) print "only " ours " of " draws " draws are of the library" }' "$dir/calls"
}
none() { [ -z "$("$@" | tee /dev/stderr)" ]; }

check "minimal runs under apitrace"                     trace
check "every texture has a label"                       all_labelled Textures TEXTURE 10
check "every framebuffer has a label"                   all_labelled Framebuffers FRAMEBUFFER 10
check "every sampler has a label"                       all_labelled Samplers SAMPLER 1
check "every buffer has a label"                        all_labelled Buffers BUFFER 1
check "the groups are the passes, in their order"       has_groups
check "each pass is drawn in the group of its name"     none misplaced_draws
check "OpenGL reported nothing"                         none grep -E "glGetError\(\) = GL_(INVALID|OUT)" "$dir/calls"
echo "1..$tests"
