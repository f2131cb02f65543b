#!/bin/sh
# build/release/render --probe: what comes from where no surface is known, against closed forms. Prints TAP.

cd "$(dirname "$0")/../.." || exit 1
. tests/support/tap.sh
render=$PWD/build/release/render
cd "$dir" || exit 1

# walls MATERIAL NODE...: a scene of squares of 1 m on the XZ plane, of their own or the given material
walls() {
    material=$1
    shift
    nodes=$(printf ', {"mesh": 0, %s}' "$@") indices=$(seq -s , 0 $(($# - 1)))
    cat <<END
{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [$indices]}], "nodes": [${nodes#, }],
 "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
 "materials": [{"doubleSided": true, $material}],
 "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3",
                "min": [-0.5, 0, -0.5], "max": [0.5, 0, 0.5]},
               {"bufferView": 0, "byteOffset": 48, "componentType": 5121, "count": 6, "type": "SCALAR"}],
 "bufferViews": [{"buffer": 0, "byteLength": 54}],
 "buffers": [{"byteLength": 54, "uri": "data:application/octet-stream;base64,$(base64 <square.bin | tr -d '\n')"}]}
END
}
low='\000\000\000\277' zero='\000\000\000\000' high='\000\000\000\077'
# shellcheck disable=SC2059 # the format is what is written
printf "$low$zero$low$low$zero$high$high$zero$low$high$zero$high\\000\\001\\002\\002\\001\\003" >square.bin

of_albedo() { printf '"pbrMetallicRoughness": {"metallicFactor": 0, "baseColorFactor": [%s, %s, %s, 1]}' "$1" "$1" "$1"; }
black=$(of_albedo 0) white=$(of_albedo 1) grey=$(of_albedo 0.2)
glow='"emissiveFactor": [1, 1, 1]'
upright='"rotation": [0.70710678, 0, 0, 0.70710678]' # faces along Z
sideways='"rotation": [0, 0, 0.70710678, 0.70710678]' # faces along X
# room_of MATERIAL: 4 x 2 x 4 m around the origin
room_of() {
    walls "$1" '"translation": [0, -1, 0], "scale": [4, 1, 4]' '"translation": [0, 1, 0], "scale": [4, 1, 4]' \
        "\"translation\": [0, 0, -2], $upright, \"scale\": [4, 1, 2]" \
        "\"translation\": [0, 0, 2], $upright, \"scale\": [4, 1, 2]" \
        "\"translation\": [-2, 0, 0], $sideways, \"scale\": [2, 1, 4]" \
        "\"translation\": [2, 0, 0], $sideways, \"scale\": [2, 1, 4]"
}

room_of "$black, $glow"                                                        >furnace.gltf
room_of "$grey, $glow"                                                         >grey_furnace.gltf
walls "$black, $glow" '"translation": [0, 1, 0], "scale": [4000, 1, 4000]'     >ceiling.gltf
walls "$black, $glow" '"translation": [1000, 1, 0], "scale": [2000, 1, 4000]'  >quarter_xy.gltf
walls "$black, $glow" '"translation": [0, 1, 1000], "scale": [4000, 1, 2000]'  >quarter_yz.gltf
walls "$black, $glow" "\"translation\": [1, 0, 1000], $sideways, \"scale\": [4000, 1, 2000]" >quarter_xz.gltf
walls "$(of_albedo 1)" '"translation": [0, -1, 0], "scale": [4000, 1, 4000]'   >floor.gltf
walls "$black" '"translation": [0, -1, 0], "scale": [4000, 1, 4000]'           >black_floor.gltf
walls "$white" '"translation": [0, 0, -3], "rotation": [0.70710678, 0, 0, 0.70710678]' >wall.gltf

# show SCENE OPTION...: 48 x 48 pixels from the middle, along -Z; writes final.text, a line a pixel, bottom row first
to_text() { od -An -v -w"$((4 * $2))" -tf4 -j "$(head -n 3 "$1.pfm" | wc -c)" "$1.pfm" >"$1.text"; }
show() {
    "$render" "$@" --size 48x48 --guard "${guard:-0}" --frames 1 --json report.json --dump final=final.pfm >/dev/null &&
        to_text final 3
}
level='--camera 0,0,0,0,0,-1,90 --effects none'

# The nine numbers of the probe, red only.
harmonics() { sed -n '/"probe_harmonics"/,/]$/p' report.json | sed -n 's/^ *\[\([^,]*\),.*/\1/p'; }
# harmonics_are TOLERANCE NUMBER...: nine of them
harmonics_are() {
    tolerance=$1
    shift
    printf '%s\n' "$@" >wanted.text
    harmonics | paste -d ' ' - wanted.text | awk -v tolerance="$tolerance" '
        { error = $1 - $2; if (error < 0) error = -error; if (!($1 ~ /^-?[0-9]/) || error > tolerance) ++bad; print }
        END { exit bad || NR != 9 }'
}
# baked SCENE SKY TOLERANCE NUMBER...: what the eye in the middle bakes
# shellcheck disable=SC2086 # a list of words
baked() { show "$1" --probe cube $level --sun "${sun:-none}" --sky $2 && shift 2 && harmonics_are "$@"; }

# all_are LOW HIGH: every number of the picture
all_are() {
    awk -v low="$1" -v high="$2" '
        { for (i = 1; i <= 3; ++i) if ((!($i ~ /^[0-9]/) || $i < low || $i > high) && !bad++) print "first:", NR, $0 }
        END { print bad + 0, "numbers of", NR, "pixels are out of range"; exit !(NR == 2304 && !bad) }' final.text
}

# >> kinds

says() { grep -q "\"probe\": \"$1\"" report.json; }
hash_of() { show "$@" && sed -n 's/.*"hash": "\([0-9a-f]*\)".*/\1/p' report.json >a_hash; }
# shellcheck disable=SC2086 # a list of words
all_differ() {
    hash_of && mv a_hash default && hash_of --probe constant && says constant && mv a_hash constant &&
        hash_of --probe sky && says sky && mv a_hash sky && hash_of --probe cube && says cube &&
        cmp default constant && ! cmp -s constant sky && ! cmp -s constant a_hash && ! cmp -s sky a_hash
}
check "constant is the default, others are others"  all_differ

# >> a constant

# shellcheck disable=SC2086 # a list of words
constant() {
    show wall.gltf $level --sun none --sky "$1" && all_are "$2" "$3" && harmonics_are 1e-9 "$4" 0 0 0 0 0 0 0 0
}
check "constant: a wall is as bright as the sky"    constant 0.625,0.625,0.625 0.624999 0.625001 0.625

# >> a sky

# Seen at an elevation of which the sine is y: 1.5 - 0.75 y above, 0.3 below, of --sky.
# seen OPTION...: the picture of the sky, half of it below the horizon; no surface is in it
seen() {
    show wall.gltf --probe sky --sky 2,2,2 --effects none --camera 40,9000,-70,40,9000,-71,90 "$@" &&
        awk '{ x = ((NR - 1) % 48 + 0.5) / 24 - 1; y = (int((NR - 1) / 48) + 0.5) / 24 - 1
               wanted = y < 0 ? 0.6 : 3 - 1.5 * y / sqrt(x * x + y * y + 1); error = $1 - wanted
               if (error < 0) error = -error; if (!(error < 1e-3) && !bad++) print "at", x, y, $0, "instead of", wanted }
             END { print bad + 0, "wrong"; exit !(NR == 2304 && !bad) }' final.text
}
check "sky: what is seen"                           seen
guard=7
check "sky: with a guard band"                      seen
guard=0
check "sky: reversed depth"                         seen --clip reversed
check "sky: an infinite far plane"                  seen --clip reversed-infinite

# lit EYE_AND_TARGET LOW HIGH: a white square, which fills the view
# shellcheck disable=SC2086 # a list of words
lit() { show "$1" --probe sky --sun none --effects none --sky 2,2,2 --camera "$2" && all_are "$3" "$4"; }
walls "$white" '"scale": [9, 1, 9]'                                            >slab.gltf
walls "$white" "$upright, \"scale\": [9, 1, 9]"                                >upright.gltf
check "sky: a floor gets as much as from constant"  lit slab.gltf 0,1,0,0,0,0,60 1.98 2.02
check "sky: a soffit gets the ground's"             lit slab.gltf 0,-1,0,0,0,0,60 0.59 0.61
# half of the ground, half of the horizon and 2 / (3 pi) of what the zenith has less
check "sky: a wall gets half of each"               lit upright.gltf 0,0,1,0,0,0,60 1.47 1.49

# >> a cube

check "cube: a furnace"                             baked furnace.gltf 9,9,9 0.01 1 0 0 0 0 0 0 0 0
check "cube: a grey furnace has two bounces"        baked grey_furnace.gltf 9,9,9 0.01 1.24 0 0 0 0 0 0 0 0
check "cube: its walls get a third"                 all_are 1.245 1.255
check "cube: a ceiling"                             baked ceiling.gltf 0,0,0 0.005 0.5 0.5 0 0 0 0 0 0 0
# over a quarter of the sphere, xy has the mean 2 / (3 pi), of which 15 / 16 are left
check "cube: a quarter, x and y"                    baked quarter_xy.gltf 0,0,0 0.005 \
                                                          0.25 0.25 0 0.25 0.1989 0 0 0 0
check "cube: a quarter, y and z"                    baked quarter_yz.gltf 0,0,0 0.005 \
                                                          0.25 0.25 0.25 0 0 0.1989 0 0 0
check "cube: a quarter, x and z"                    baked quarter_xz.gltf 0,0,0 0.005 \
                                                          0.25 0 0.25 0.25 0 0 0 0.1989 0
check "cube: sky above a black floor"               baked black_floor.gltf 0.5,0.5,0.5 0.005 \
                                                          0.25 0.25 0 0 0 0 0 0 0
sun=0,1,0,3.14159
check "cube: direct light on a white floor"         baked floor.gltf 0,0,0 0.005 0.5 -0.5 0 0 0 0 0 0 0
sun=

# >> all of it

# final = albedo lerp(visibility * probe(normal), irradiance / pi, min(2 confidence, 1)), without emission, and with a camera that
# has the axes of the world
# shellcheck disable=SC2046,SC2086 # lists of words
composite_adds_up() {
    parts='albedo0 normal0 irradiance0 ao confidence0 final z0'
    set -- --probe "$1" --sky 0.3,0.3,0.3 --sun none --camera 2,1.7,-3,2,1.7,-4,70 --dump z0=z0.pfm
    for name in albedo0 normal0 irradiance0 ao confidence0; do set -- "$@" --dump "$name=$name.pfm"; done
    show "$@" || return 1
    for name in albedo0 normal0 irradiance0; do to_text $name 3; done
    for name in ao confidence0 z0; do to_text $name 1; done
    paste -d ' ' $(printf '%s.text ' $parts) | awk -v harmonics="$(harmonics | tr '\n' ' ')" '
        BEGIN { split(harmonics, c); pi = 3.14159265 }
        $15 < 0 { ++surfaces
                  x = $4; y = $5; z = $6
                  probe = c[1] + c[2] * y + c[3] * z + c[4] * x + c[5] * x * y + c[6] * y * z + c[7] * (3 * y * y - 1) + \
                          c[8] * x * z + c[9] * (z * z - x * x)
                  if (probe < 0) probe = 0
                  known = $11 < 0.5 ? 2 * $11 : 1
                  error = $12 - $1 * ($10 * probe * (1 - known) + $7 / pi * known)
                  if (error < 0) error = -error
                  if (error > worst) worst = error
                  if ($12 > most) most = $12 }
        END { print surfaces + 0, "pixels, wrong by", worst + 0, "of", most
              exit !(surfaces > 1000 && most > 0.02 && worst < 0.001) }'
}
check "sky: final is what its parts make it"        composite_adds_up sky
check "cube: final is what its parts make it"       composite_adds_up cube

# Mesa's own way to lack what is newer; other drivers render the same once more.
old_gl() { MESA_GL_VERSION_OVERRIDE=3.3 "$@"; }
check "cube: in OpenGL 3.3"                         old_gl baked ceiling.gltf 0,0,0 0.005 0.5 0.5 0 0 0 0 0 0 0

echo "1..$tests"
