#!/bin/sh
# What may be NaN is scrubbed by selects in every shader, as tests/shaders/lint.awk defines it; and where it is not, that says so.
# Prints TAP.

cd "$(dirname "$0")/../.." || exit 1
dir=$(mktemp -d) || exit 1
trap 'rm -rf "$dir"' EXIT

tests=0
# report NAME: reports whether the last command succeeded, and what $dir/log says when it did not
report() {
    result=$?
    tests=$((tests + 1))
    name=$(echo "$1" | tr '\n' ' ')
    if [ $result -eq 0 ]; then echo "ok $tests - $name"; else echo "not ok $tests - $name"; sed 's/^/# /' "$dir/log"; fi
}

lint() { awk -f tests/shaders/lint.awk "$@" >"$dir/log" 2>&1; }

lint shaders_embedded/*.glsl
report "what may be NaN is scrubbed"

# accepts LINES, refuses LINES MESSAGE: in a function of their own
shader() { printf 'void main() {\n%s\n}\n' "$1" >"$dir/shader.glsl"; }
accepts() {
    shader "$1"
    lint "$dir/shader.glsl"
    report "accepts $1"
}
refuses() {
    shader "$1"
    ! lint "$dir/shader.glsl" && grep -q "shader.glsl:[0-9]*: .*$2" "$dir/log"
    report "refuses $1"
}

accepts 'vec3 r = dgb_storable(dgb_radiance_at(layer, p));'
accepts 'vec4 e = texelFetch(dgb_last_irradiance, p, 0);
x = vec4(dgb_storable(e.rgb), e.a > 0.0 ? (e.a < 1.0 ? e.a : 1.0) : 0.0);'
accepts 'max(float(a), dgb_storable(dgb_radiance_at(0, p)).r * b);'
refuses 'vec3 r = dgb_radiance_at(layer, p) + 1.0;' 'neither scrubbed nor assigned'
refuses 'dgb_out = texelFetch(dgb_last_bent, p, 0) * 2.0;' 'neither scrubbed nor assigned'
refuses 'vec3 a = dgb_albedo_at(0, p);
b = a * 2.0;' 'a may be NaN here'
refuses 'vec3 a = dgb_albedo_at(0, p);
b = dgb_storable(a) + a;' 'a may be NaN here'
refuses 'vec3 a = dgb_albedo_at(0, p);
b = max(a, 0.0);' 'a may be NaN here'
refuses 'x = max(0.0, dgb_roughness_at(p));' 'min, max or clamp'
refuses 'x = clamp(float(min(1, 2)) * texelFetch(dgb_last_z, p, 0).x, 0.0, 1.0);' 'min, max or clamp'
refuses 'if (isnan(x)) x = 0.0;' 'isnan'

# A scrub that is taken out of a shader is missed.
unscrubbed() {
    for file in 19_history 20_pack 55_temporal 65_reflect 68_glossy; do
        sed 's/dgb_storable_unit(/vec4(/; s/dgb_storable(/vec3(/' \
            "shaders_embedded/$file.glsl" >"$dir/$file.glsl"
        if lint "$dir/$file.glsl"; then echo "$file passes" >"$dir/log"; return 1; fi
    done
}
unscrubbed
report "refuses every shader that reads what may be NaN, without its scrubs"

echo "1..$tests"
