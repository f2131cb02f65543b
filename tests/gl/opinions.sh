#!/bin/sh
# Second opinions: the OpenGL tests on other implementations than the one at hand, as far as this machine has them.
#
#     gl33       OpenGL 3.3 and nothing more: Mesa with its later versions and extensions taken away
#     es30-es32  OpenGL ES of these versions: the programs that make ES contexts
#     zink       Mesa's OpenGL over Vulkan, over its software rasteriser: other code from GLSL to the rasteriser, other memory
#     angle      every pair of shaders in the ES dialect, compiled and linked by ANGLE for SwiftShader, which share nothing
#                with Mesa (in Chromium, as WebGL 2)
#
#     tests/gl/opinions.sh [OPINION...]      PROGRAMS="test_es ..." picks programs, CHROMIUM=FILE another browser
#
# A line a test program, then one for each test in it that did not pass, or in part. Fails where a difference is not in the
# tables below.

cd "$(dirname "$0")/../.." || exit 1
programs=build/release/tests/gl
dir=$(mktemp -d) || exit 1
trap 'rm -rf "$dir"' EXIT
trap 'exit 130' INT TERM
export CMOCKA_MESSAGE_OUTPUT=TAP XDG_RUNTIME_DIR="${XDG_RUNTIME_DIR:-$dir}"

# What an implementation may refuse: OPINION ITEM REASON. A test may leave out cases for this item; one that ends at a dgb_init
# refused for it is skipped.
cat >"$dir/refusals" <<'END'
gl33 EMISSION       VERTEX, INSTANCED_GEOMETRY and IMAGE need OpenGL 4.1 to 4.3 or extensions
gl33 CLIP           needs glClipControl, of OpenGL 4.5
gl33 DEEP_VIEWPORT  needs glViewportIndexedf, of OpenGL 4.1
END

# What differs, and why: OPINION PROGRAM TEST REASON. TEST *: the program is not run. A test listed here must fail.
cat >"$dir/differences" <<'END'
gl33 test_guest   * the engine's state that it puts in disorder is OpenGL 4.5's
gl33 test_robust  * the engine's state that it puts in disorder is OpenGL 4.5's
zink test_guest   test_no_messages Mesa notes that it compiles shaders anew for a size of points that the engine left on
END

# reason FILE KEYS: the rest of the line whose first words are the keys
reason() {
    awk -v keys="$2" '{ n = split(keys, k, " "); for (i = 1; i <= n; ++i) if ($i != k[i]) next
                        for (i = 1; i <= n; ++i) sub(/^[^ ]+ +/, ""); print; exit }' "$1"
}

# Reads TAP; prints a line `passed|partly|failed|skipped TEST: reason` a test.
verdicts() {
    awk -v opinion="$1" -v program="$2" '
        function settle(line) {
            if (test == "") return
            if (test in listed) { differs[test] = 1; print "skipped", test ": " listed[test] }
            else if (item in allowed && line == "# 0x2 != 0") print "skipped", test ": " item ": " allowed[item]
            else print "failed", test ": " substr(line, 3)
            test = ""; item = ""
        }
        function pass(test, without, i) {
            for (i in out) {
                if (!(i in allowed)) { print "failed", test ": leaves out " i; return }
                without = without " " i
            }
            print without == "" ? "passed " test : "partly " test ": without" without
        }
        FILENAME ~ /refusals$/    { if ($1 == opinion) { i = $2; sub(/^[^ ]+ +[^ ]+ +/, ""); allowed[i] = $0 } next }
        FILENAME ~ /differences$/ { if ($1 == opinion && $2 == program) { t = $3; sub(/^[^ ]+ +[^ ]+ +[^ ]+ +/, ""); listed[t] = $0 } next }
        test != ""                { settle($0) }
        /^# DGB_UNSUPPORTED /     { item = $3; sub(/:$/, "", item) }
        /^# left out /            { out[$4] }
        /# *[Ss][Kk][Ii][Pp]/     { print "skipped", $NF ": by itself"; item = ""; next }
        /^ok /                    { pass($4); item = ""; split("", out) }
        /^not ok /                { test = $5; split("", out) }
        END                       { settle("# ")
                                    for (t in listed) if (!(t in differs)) print "failed", t ": passes, though listed" }' "$dir/refusals" "$dir/differences" "$dir/output"
}

failures=0

# report OPINION PROGRAM VERDICTS
report() {
    printf '%-6s %-16s %s\n' "$1" "$2" "$(awk '{ ++n[$1] } END {
        printf "%d passed, %d failed, %d skipped", n["passed"] + n["partly"], n["failed"], n["skipped"] }' "$3")"
    grep -v '^passed' "$3" | sed 's/^/         /'
    failures=$((failures + $(grep -c '^failed' "$3")))
}

# opinion NAME CONTEXT PROGRAM...: runs them under the environment at hand. CONTEXT: what the context's name must contain,
# or it is no other implementation that gave this opinion.
opinion() {
    name=$1 context=$2
    shift 2
    for program in "$@"; do
        why=$(reason "$dir/differences" "$name $program *")
        if [ -n "$why" ]; then
            echo "skipped all: $why" >"$dir/verdicts"
        else
            timeout "${TEST_TIMEOUT:-600}" "$programs/$program" >"$dir/output" 2>&1 </dev/null
            status=$?
            verdicts "$name" "$program" >"$dir/verdicts"
            if ! grep -q "^# context: .*$context" "$dir/output"; then
                echo "failed all: no context of $context" >>"$dir/verdicts"
            elif [ $status -ge 124 ]; then
                echo "failed all: exit status $status" >>"$dir/verdicts"
            fi
        fi
        report "$name" "$program" "$dir/verdicts"
    done
}

every=${PROGRAMS:-$(cd "$programs" && echo test_*)}

# KHR_debug stays: its messages are counted.
later="-GL_ARB_viewport_array -GL_ARB_clip_control -GL_ARB_texture_barrier -GL_NV_texture_barrier
    -GL_ARB_shader_image_load_store -GL_ARB_query_buffer_object -GL_ARB_shader_viewport_layer_array
    -GL_AMD_vertex_shader_layer -GL_ARB_fragment_shader_interlock"
gl33() (
    export DGB_GL_VERSION=3.3 MESA_GL_VERSION_OVERRIDE=3.3 MESA_GLSL_VERSION_OVERRIDE=330
    MESA_EXTENSION_OVERRIDE=$(echo $later)
    export MESA_EXTENSION_OVERRIDE
    opinion gl33 '3\.3 (Core Profile)' $every
    exit $failures
)

es() (
    export MESA_GLES_VERSION_OVERRIDE="$1.$2"
    opinion "es$1$2" "OpenGL ES $1\\.$2" ${PROGRAMS:-test_es test_hierarchy test_view}
    exit $failures
)

zink() (
    driver=$(ls /usr/share/vulkan/icd.d/lvp_icd*.json 2>/dev/null | head -n 1)
    if [ -z "$driver" ]; then
        echo "zink   skipped: Mesa's Vulkan driver is missing (Debian, Ubuntu: mesa-vulkan-drivers)"
        exit 0
    fi
    export LIBGL_ALWAYS_SOFTWARE=1 GALLIUM_DRIVER=zink VK_ICD_FILENAMES="$driver"
    opinion zink 'zink' $every
    exit $failures
)

# A page that compiles and links each pair of texts and leaves a line for each.
page() {
    echo '<html><body>'
    for vertex in "$dir"/text/*_es300*.vert; do
        name=${vertex##*/}
        name=${name%.vert}
        for stage in vert frag; do
            echo "<script type=\"x-shader/$stage\" title=\"$name\">"
            cat "$dir/text/$name.$stage"
            echo '</script>'
        done
    done | sed '/^<script/{N;s/\n//;}' # #version stands at the very start
    cat <<'END'
<pre></pre><script>
const gl = document.createElement("canvas").getContext("webgl2"), lines = [];
function compile(program, stage, text) {
    const shader = gl.createShader(stage);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
    gl.deleteShader(shader);
    return gl.getShaderInfoLog(shader);
}
for (const vertex of document.querySelectorAll("script[type='x-shader/vert']")) {
    const program = gl.createProgram();
    let log = compile(program, gl.VERTEX_SHADER, vertex.text);
    log += compile(program, gl.FRAGMENT_SHADER, vertex.nextElementSibling.text);
    gl.linkProgram(program);
    log += gl.getProgramInfoLog(program);
    const ok = gl.getProgramParameter(program, gl.LINK_STATUS);
    lines.push(ok ? "passed " + vertex.title : "failed " + vertex.title + ": " + log.replace(/\s+/g, " "));
    gl.deleteProgram(program);
}
document.querySelectorAll("script").forEach(s => s.remove());
document.querySelector("pre").textContent = "\n" + lines.join("\n") + "\n";
</script></body></html>
END
}

angle() (
    browser=${CHROMIUM:-chromium}
    if ! command -v "$browser" >/dev/null; then
        echo "angle  skipped: Chromium is missing (Debian: chromium), or CHROMIUM=FILE"
        exit 0
    fi
    mkdir "$dir/text"
    "${CC:-cc}" -std=c99 -I. tests/shaders/dump.c -lm -o "$dir/dump" && "$dir/dump" "$dir/text" || exit 1
    page >"$dir/page.html"
    timeout 600 "$browser" --headless --no-sandbox --use-gl=angle --use-angle=swiftshader --enable-unsafe-swiftshader \
        --user-data-dir="$dir/profile" --dump-dom "file://$dir/page.html" 2>/dev/null |
        grep -E '^(passed|failed) ' >"$dir/verdicts"
    count=$(ls "$dir"/text/*_es300*.vert | wc -l)
    if [ "$(wc -l <"$dir/verdicts")" -ne "$count" ]; then echo "failed all: not $count verdicts" >>"$dir/verdicts"; fi
    report angle 'shaders' "$dir/verdicts"
    exit $failures
)

all=0
for name in ${*:-gl33 es30 es31 es32 zink angle}; do
    case $name in
        es3[0-2]) es 3 "${name#es3}" ;;
        gl33 | zink | angle) "$name" ;;
        *) echo "opinions: $name: choose gl33, es30, es31, es32, zink or angle" >&2; exit 2 ;;
    esac || all=1
done
exit $all
