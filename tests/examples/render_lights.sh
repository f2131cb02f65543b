#!/bin/sh
# Lights of build/release/render: what a plane gets from each kind, against closed forms; shadows, sums, refusals.
# Prints TAP.

cd "$(dirname "$0")/../.." || exit 1
. tests/support/tap.sh
render=$PWD/build/release/render
cd "$dir" || exit 1

# >> scenes: a white floor of 8 x 8 m, a roof of 1 x 1 m above it, and lights

# lit LIGHT NODE [NODES]: prints a scene; the first light's node is the one before the last, number 2
lit() {
    cat <<END
{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1, 2]}],
 "extensionsUsed": ["KHR_lights_punctual"], "extensionsRequired": ["KHR_lights_punctual"],
 "extensions": {"KHR_lights_punctual": {"lights": [$1]}},
 "nodes": [{"mesh": 0, "scale": [8, 1, 8]}, {"mesh": 0, "translation": [${roof:-0, -1, 0}]}, $2],
 "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
 "materials": [{"doubleSided": true, "pbrMetallicRoughness": {"metallicFactor": 0}}], ${animations:-}
 "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3",
                "min": [-0.5, 0, -0.5], "max": [0.5, 0, 0.5]},
               {"bufferView": 0, "byteOffset": 48, "componentType": 5121, "count": 6, "type": "SCALAR"},
               {"bufferView": 0, "byteOffset": 56, "componentType": 5126, "count": 2, "type": "SCALAR",
                "min": [0], "max": [1]},
               {"bufferView": 0, "byteOffset": 64, "componentType": 5126, "count": 2, "type": "VEC3"}],
 "bufferViews": [{"buffer": 0, "byteLength": 88}],
 "buffers": [{"byteLength": 88, "uri": "data:application/octet-stream;base64,$(base64 <quad.bin | tr -d '\n')"}]}
END
}
{
    # x, y, z of four corners; two triangles; times 0 and 1; places (1, 2, -1) and (-1, 2, 1)
    low='\000\000\000\277' zero='\000\000\000\000' high='\000\000\000\077' one='\000\000\200\077'
    two='\000\000\000\100' minus='\000\000\200\277'
    # shellcheck disable=SC2059 # the format is what is written
    printf "$low$zero$low$low$zero$high$high$zero$low$high$zero$high\\000\\001\\002\\002\\001\\003\\000\\000$zero$one"
    # shellcheck disable=SC2059
    printf "$one$two$minus$minus$two$one"
} >quad.bin

use='"extensions": {"KHR_lights_punctual": {"light": 0}}'
down='"rotation": [-0.70710678, 0, 0, 0.70710678]'
tilted='"rotation": [-0.5, -0.5, 0, 0.70710678]' # shines along (1, -1, 0)
sunny='{"type": "directional", "intensity": 3}'
bulb='{"type": "point", "intensity": 20}'
lamp='{"type": "spot", "intensity": 20, "spot": {"innerConeAngle": 0.3, "outerConeAngle": 0.7}}'
flood='{"type": "spot", "intensity": 20, "spot": {"innerConeAngle": 0.3, "outerConeAngle": 1.4}}'
above='"translation": [0.5, 2, -0.5]'
aside='"translation": [-2, 3, 0]'

lit "$bulb" "{$above, $use}"                                              >bulb.gltf
lit "$bulb" "{\"translation\": [0.5, 0.3, -0.5], $use}"                   >low.gltf
lit '{"type": "point", "intensity": 20, "range": 3}' "{$above, $use}"     >range.gltf
lit "$lamp" "{$above, $down, $use}"                                       >lamp.gltf
lit "$flood" "{$above, $down, $use}"                                      >flood.gltf
lit "$sunny" "{$down, \"scale\": [2, 3, 4], $use}"                        >sunny.gltf
lit '{"type": "point", "color": [1, 0.5, 0.25], "intensity": 20}' "{$above, $use}" >color.gltf
lit "$bulb, $lamp, $sunny" "{\"children\": [3, 4, 5]}, {$above, $use}, {\"translation\": [-1, 2, 1], $down,
     \"extensions\": {\"KHR_lights_punctual\": {\"light\": 1}}}, {$down,
     \"extensions\": {\"KHR_lights_punctual\": {\"light\": 2}}}"          >three.gltf
lit "$lamp" "{\"translation\": [-1, 2, 1], $down, $use}"                  >lamp_aside.gltf
lit '{"type": "point", "intensity": 0}' "{$above, $use}"                  >dark.gltf
animations='"animations": [{"samplers": [{"input": 2, "output": 3}],
                            "channels": [{"sampler": 0, "target": {"node": 2, "path": "translation"}}]}],'
lit "$bulb" "{$use}"                                                      >moving.gltf
animations=

roof='0, 1, 0'
lit "$bulb" "{$aside, $use}"                                              >roof_bulb.gltf
lit "$flood" "{$aside, $down, $use}"                                      >roof_flood.gltf
lit "$lamp" "{$aside, $tilted, $use}"                                      >roof_lamp.gltf
lit "$sunny" "{$tilted, $use}"                                            >roof_sunny.gltf
roof='0, -1, 0'

# >> pictures: the floor from above, 16 pixels a metre

# show SCENE OPTION...: writes final.text, a line a pixel: x z red green blue, in metres and W/m2/sr
show() {
    scene=$1
    shift
    "$render" "$scene" --size 96x96 --guard 0 --camera 0,10,0,0,0,0,45 --ortho 6 --frames 1 --effects none \
        --sky 0,0,0 --dump final=final.pfm --json report.json "$@" >/dev/null || return 1
    od -An -v -w12 -tf4 -j "$(head -n 3 final.pfm | wc -c)" final.pfm |
        awk '{ n = NR - 1; print (n % 96 + 0.5) / 16 - 3, 3 - (int(n / 96) + 0.5) / 16, $1, $2, $3 }' >final.text
}

# is FORMULA [TOLERANCE]: red is the value of the awk expression in x and z everywhere, but for a share of the brightest
is() {
    awk -v tolerance="${2:-0.005}" '
        function max(a, b) { return a > b ? a : b }
        function min(a, b) { return a < b ? a : b }
        # irradiance over pi from a point at (px, h, pz)
        function from(px, h, pz, intensity) {
            return intensity * h / (h * h + (x - px) ^ 2 + (z - pz) ^ 2) ^ 1.5 / pi
        }
        function cosine(px, h, pz) { return h / sqrt(h * h + (x - px) ^ 2 + (z - pz) ^ 2) }
        function cone(c, inner, outer) { a = min(max((c - cos(outer)) / (cos(inner) - cos(outer)), 0), 1); return a * a }
        BEGIN { pi = 3.14159265358979 }
        { x = $1; z = $2; wanted = '"$1"'; error = $3 - wanted; if (error < 0) error = -error
          if (!($3 ~ /^[0-9]/)) ++bad
          if (wanted > most) most = wanted
          if (error > worst) { worst = error; at = x " " z " has " $3 " instead of " wanted } }
        END { print "worst:", at, "; brightest", most
              exit !(NR == 9216 && most > 0 && !bad && worst <= tolerance * most) }' final.text
}
shown() { scene=$1 formula=$2; shift 2; show "$scene" "$@" && is "$formula"; }

check "a point light: I cos / d^2"              shown bulb.gltf 'from(0.5, 2, -0.5, 20)'
check "a low one: no shadow of the floor itself" shown low.gltf 'from(0.5, 0.3, -0.5, 20)'
check "--point is the same"                     shown dark.gltf 'from(0.5, 2, -0.5, 20)' --point 0.5,2,-0.5,20
check "two of them add up"                      shown dark.gltf 'from(0.5, 2, -0.5, 20) + from(-1, 1, 1, 5)' \
                                                      --point 0.5,2,-0.5,20 --point=-1,1,1,5
check "a range closes a window"                 shown range.gltf \
    'from(0.5, 2, -0.5, 20) * max(1 - (2 / 3 / cosine(0.5, 2, -0.5)) ^ 4, 0)'
check "a spot light has a cone"                 shown lamp.gltf \
    'from(0.5, 2, -0.5, 20) * cone(cosine(0.5, 2, -0.5), 0.3, 0.7)'
check "a wide one, too"                         shown flood.gltf \
    'from(0.5, 2, -0.5, 20) * cone(cosine(0.5, 2, -0.5), 0.3, 1.4)'
check "a directional light: E / pi"             shown sunny.gltf '3 / pi'
check "all three add up"                        shown three.gltf \
    'from(0.5, 2, -0.5, 20) + from(-1, 2, 1, 20) * cone(cosine(-1, 2, 1), 0.3, 0.7) + 3 / pi'
check "the sun adds to the file's lights"       shown bulb.gltf 'from(0.5, 2, -0.5, 20) + 2 / pi' --sun 0,1,0,2
check "--sun none leaves them alone"            shown bulb.gltf 'from(0.5, 2, -0.5, 20)' --sun none
check "a node moves its light"                  shown moving.gltf 'from(0.5, 2, -0.5, 20)' --time 0.25
check "half a second later, too"                shown moving.gltf 'from(0, 2, 0, 20)' --time 0.5

is_tinted() {
    show color.gltf && awk '{ for (c = 4; c <= 5; ++c) { error = $c - $3 * (c == 4 ? 0.5 : 0.25)
                                                         if (error < 0) error = -error
                                                         if (error > worst) worst = error } }
                            END { print "worst:", worst; exit !(NR == 9216 && worst < 0.002) }' final.text
}
check "a light has a color"                     is_tinted

# >> shadows

# shaded SCENE WANTED WHERE LOW HIGH HALF [REST [OPTION...]]: the roof's shadow, LOW < x < HIGH and |z| < HALF, is dark, or
# has what the REST of the lights give, and where else WHERE holds the floor has what is WANTED, to within 5 cm of the
# shadow's edge. The roof hides |x|, |z| < 0.5.
shaded() {
    scene=$1 wanted=$2 where=$3 low=$4 high=$5 half=$6 rest=${7:-0}
    shift 6
    if [ $# -gt 0 ]; then shift; fi
    show "$scene" "$@" || return 1
    awk -v low="$low" -v high="$high" -v half="$half" '
        function differs(is, wanted) { return is < 0.99 * wanted || is > 1.01 * wanted }
        function inside(x, z, m) { return x > low - m && x < high + m && z > -half - m && z < half + m }
        function roof(x, z) { return x > -0.54 && x < 0.54 && z > -0.54 && z < 0.54 }
        roof($1, $2) { next }
        { x = $1; z = $2; s = 9 + (x + 2) ^ 2 + z ^ 2; pi = 3.14159265 } # s: squared distance from (-2, 3, 0)
        inside(x, z, -0.05) { ++dark; if (differs($3, '"$rest"') && !leaks++) print "not dark:", $0; next }
        !inside(x, z, 0.05) && ('"$where"') {
            ++lit; wanted = '"$wanted"'
            if (differs($3, wanted) && !bad++) print "at", $0, "instead of", wanted }
        END { print dark + 0, "dark,", lit + 0, "lit,", leaks + 0, "leaks,", bad + 0, "wrong"
              exit !(dark > 150 && lit > 400 && !leaks && !bad) }' final.text
}
check "a point light casts a shadow"            shaded roof_bulb.gltf '60 / s ^ 1.5 / pi' 1 0.25 1.75 0.75
check "a wide spot light, too"                  shaded roof_flood.gltf '60 / s ^ 1.5 / pi' '3 / sqrt(s) > cos(0.3)' \
                                                       0.25 1.75 0.75
check "a spot light, too"                       shaded roof_lamp.gltf '60 / s ^ 1.5 / pi' \
                                                       '(x + 5) * 0.70710678 / sqrt(s) > cos(0.29)' 0.25 1.75 0.75
check "a directional light, too"                shaded roof_sunny.gltf '3 * 0.70710678 / pi' 1 0.5 1.5 0.5

both='60 / s ^ 1.5 / pi + 3 * 0.70710678 / pi'
check "each of two lights has its own: one"     shaded roof_bulb.gltf "$both" 'x > -0.45' 0.25 1.75 0.75 \
                                                       '3 * 0.70710678 / pi' --sun 1,1,0,3
check "and the other"                           shaded roof_bulb.gltf "$both" 'x < 0.2' -1.5 -0.5 0.5 \
                                                       '60 / s ^ 1.5 / pi' --sun 1,1,0,3

# >> report

says() { for text in "$@"; do grep -qF "$text" report.json || { echo "not there: $text"; return 1; }; done; }
reports() { show "$@" --point 3,2,1,0.5 --sun 0,2,0,4; }
check "it renders with a report"                reports three.gltf
check "the report has every light" says \
    '{"kind": "point", "intensity": [20, 20, 20], "position": [0.5, 2, -0.5]},' \
    '{"kind": "spot", "intensity": [20, 20, 20], "position": [-1, 2, 1], "direction": [-0, -1, ' \
    '"cone": [0.300000012, 0.699999988]},' '{"kind": "directional", "intensity": [3, 3, 3], "direction": [-0, -1, ' \
    '{"kind": "directional", "intensity": [4, 4, 4], "direction": [-0, -1, -0]},' \
    '{"kind": "point", "intensity": [0.5, 0.5, 0.5], "position": [3, 2, 1]}' '"shadow_maps": {"count": 15, "size": 2048}'
check "of a range, too"                         show range.gltf
check "the report has it"                       says '"range": 3}'

# >> how many there may be

points() { # COUNT COMMAND...: the command with so many lights
    count=$1
    shift
    while [ "$count" -gt 0 ]; do set -- "$@" --point "$count,1,0,1" && count=$((count - 1)); done
    "$@"
}
check "16 lights"                               points 16 show dark.gltf
check "they add up"                             is "$(seq 16 | sed 's/.*/from(&, 1, 0, 1) + /' | tr -d '\n') 0"
check "17 lights are refused"                   points 17 refuses "$render" dark.gltf
check "16 and the sun are refused"              points 16 refuses "$render" dark.gltf --sun 0,1,0,1
check "without a --sun, a scene has a sun"      points 16 refuses "$render"

# >> broken lights

bad() { lit "$2" "{${3:-$use}}" >"bad_$1.gltf"; }
bad kind            '{"type": "area", "intensity": 1}'
bad intensity       '{"type": "point", "intensity": -1}'
bad infinite        '{"type": "point", "intensity": 1e99}'
bad color           '{"type": "point", "color": [1, -1, 1]}'
bad short_color     '{"type": "point", "color": [1, 1]}'
bad range           '{"type": "point", "range": -1}'
bad no_cone         '{"type": "spot"}'
bad inner_cone      '{"type": "spot", "spot": {"innerConeAngle": -0.1}}'
bad inner_is_outer  '{"type": "spot", "spot": {"innerConeAngle": 0.6, "outerConeAngle": 0.5}}'
bad outer_cone      '{"type": "spot", "spot": {"outerConeAngle": 1.7}}'
bad closed_cone     '{"type": "spot", "spot": {"outerConeAngle": 0}}'
bad no_such_light   "$bulb" '"extensions": {"KHR_lights_punctual": {"light": 1}}'
bad negative_light  "$bulb" '"extensions": {"KHR_lights_punctual": {"light": -1}}'
bad no_number       "$bulb" '"extensions": {"KHR_lights_punctual": {}}'
bad matrix          "$bulb" "$use, \"matrix\": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1e99, 0, 0, 1]"
for scene in bad_*; do check "refused: $scene" refuses "$render" "$scene"; done

# >> OpenGL 3.3

# Mesa's own way to lack what is newer; other drivers render the same picture once more.
old_gl() { MESA_GL_VERSION_OVERRIDE=3.3 "$@"; }
check "in OpenGL 3.3, all three add up"         old_gl shown three.gltf \
    'from(0.5, 2, -0.5, 20) + from(-1, 2, 1, 20) * cone(cosine(-1, 2, 1), 0.3, 0.7) + 3 / pi'

echo "1..$tests"
