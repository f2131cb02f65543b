#!/bin/sh
# The command line of build/release/render: what it refuses, what it writes, what the files hold. Prints TAP.

cd "$(dirname "$0")/../.." || exit 1
render=$PWD/build/release/render
dir=$(mktemp -d) || exit 1
trap 'rm -rf "$dir"' EXIT
cd "$dir" || exit 1
tests=0

# check NAME COMMAND...: reports whether the command succeeds, and its output when it does not
check() {
    title=$1 tests=$((tests + 1))
    shift
    if "$@" >"$dir/log" 2>&1; then
        echo "ok $tests - $title"
    else
        echo "not ok $tests - $title"
        sed 's/^/# /' "$dir/log"
    fi
}

no_egl() { (export __EGL_VENDOR_LIBRARY_FILENAMES=/dev/null && "$@"); }

# >> help and plan need no GPU

options='out size guard layers separation oracle emit effects preset samples radius ao-samples ao-radius
         camera sun point sky probe ortho exposure profile frames orbit clip dump json plan help divisor time fps
         reflect-steps reflect-distance reflect-thickness thickness-from tracer roughness'

help_names_all() {
    no_egl "$render" --help >help || return 1
    for option in $options; do
        grep -q -e "^ *--$option " help || { echo "--$option is missing"; return 1; }
    done
}

plan() { no_egl "$render" --plan "$@" >plan && cat plan && [ -s plan ]; }
plan_names() { for word in "$@"; do grep -w "$word" plan || return 1; done; }
plan_lacks() { for word in "$@"; do if grep -w "$word" plan; then return 1; fi; done; }
plan_adds_up() {
    awk '/ bytes$/ { if ($1 == "total") total = $2; else sum += $(NF - 1) }
         END { print sum, "of", total; exit !(total > 0 && sum == total) }' plan
}
writes_nothing() { [ -z "$(ls -A untouched)" ]; }

mkdir untouched
check "--help names every option"            help_names_all
check "--plan needs no EGL"                  plan --out untouched/out --json untouched/a --dump z0=untouched/b
check "--plan writes nothing"                writes_nothing
check "it names passes and textures"         plan_names layers pack mip ao gather reconstruct z irradiance
check "its bytes add up"                     plan_adds_up
check "--plan without effects"               plan --effects none
check "it has no texture of theirs"          plan_lacks ao gather irradiance
check "its bytes add up"                     plan_adds_up
check "--plan of the widest picture"         plan --size 16384x16 --guard 0
check "its bytes add up"                     plan_adds_up

check "--plan of the linear tracer"          plan --effects reflect
check "it has no ranges"                     plan_lacks range ranges
check "--plan of the hierarchical tracer"    plan --effects reflect --tracer hierarchical
check "it names its pass and texture"        plan_names range ranges
check "its bytes add up"                     plan_adds_up
check "--plan of layers that end surfaces"   plan --effects reflect
check "it has no back faces"                 plan_lacks back
check "--plan of back faces that do"         plan --effects reflect --thickness-from back
check "it names their pass and texture"      plan_names back
check "its bytes add up"                     plan_adds_up
check "--plan of PREDICT and image emission"  plan --oracle predict --emit image --layers 4 --size 160x90
check "it names their passes and textures"   plan_names predict image resolve key predicted
check "its bytes add up"                     plan_adds_up
check "--plan of DELAY and multicast"        plan --oracle delay --emit multicast --layers 8
check "it has no key to resolve"             plan_lacks resolve key
check "its bytes add up"                     plan_adds_up

# >> refusals: exit status 2, one line on the standard error output, nothing written

# refuses ARGUMENT...: runs in an empty directory, which must stay empty
refuses() {
    (mkdir empty && cd empty && "$render" --out out --dump z1=z1.pfm "$@") >stdout 2>stderr
    status=$? files=$(ls -A empty)
    rm -rf empty
    echo "exit status $status, files: $files"
    cat stdout stderr
    [ $status -eq 2 ] && [ ! -s stdout ] && [ "$(wc -l <stderr)" -eq 1 ] && [ -z "$files" ]
}
refused() { check "refused: $*" refuses "$@"; }

# The sentence names what is wrong with the option.
refuses_option() { refuses "$@" && grep -q -e "^render: .*$1" stderr; }
refused_values() {
    option=$1
    shift
    for value in "$@"; do check "refused: $option '$value'" refuses_option "$option" "$value"; done
}

refused_values --size        0x0 0x90 160x0 -1x5 160 160x 160x90x2 axb 16385x16 99999999999x1 ''
refused_values --guard       -1 99999 1.5 many ''
refused_values --layers      0 9 -2 two 1.5
refused_values --separation  -1 nan inf 1e99 wide ''
refused_values --oracle      default PEEL 1 ''
refused_values --emit        all 0 instanced ''
refused_values --divisor     0 3 8 -2 1.5 half ''
refused_values --effects     ssr ao,, ao,none , ''
refused_values --preset      fast 2 ''
refused_values --samples     0 257 -1 8x
refused_values --radius      0 -1 nan inf far
refused_values --ao-samples  0 257 -1 8x
refused_values --ao-radius   0 -1 nan inf far
refused_values --camera      1,2,3 0,0,0,0,0,0,60 0,0,1,0,0,0,0 0,0,1,0,0,0,180 0,0,1,0,0,0,x \
                             0,0,inf,0,0,0,60
refused_values --sun         1,2,3 0,0,0,1 1,1,1,-1 1,1,1,nan up ''
refused_values --point       1,2,3 1,2,3,-1 1,2,3,nan 1,2,inf,1 1,2,3,4,5 here ''
refused_values --sky         1 1,1,-1 1,1,inf 1,1,1,1 ''
refused_values --probe       none SKY 1 ''
refused_values --ortho       0 -1 nan inf
refused_values --exposure    nan 31 bright
refused_values --reflect-steps     0 -1 4097 1.5 many ''
refused_values --reflect-distance  0 -1 nan inf far ''
refused_values --reflect-thickness 0 -1 nan inf thick ''
refused_values --thickness-from    backs 1 ''
refused_values --tracer      fast 1 ''
refused_values --roughness   -0.1 1.1 nan inf rough ''
refused_values --frames      0 -1 1.5 few
refused_values --orbit       nan 361 left
refused_values --time        -1 nan inf soon ''
refused_values --fps         0 -1 nan inf fast ''
refused_values --clip        forward 0 ''
refused_values --dump        z0 z0= =z0.pfm z2=z2.pfm
refused --no-such-option
refused -x
refused --size
refused one.gltf two.gltf
refused --size 1000x1000 --guard 16000
refused --oracle peel --emit vertex
refused --oracle peel --emit geometry
refused --oracle peel --emit instanced-geometry
refused --oracle peel --emit image
refused --emit image --divisor 2
refused --emit multicast --divisor 4
check "refused: layer 1 of one layer" refuses --layers 1
refused --effects ao --dump irradiance0=e.pfm
refused --effects gi --dump ao=ao.pfm
refused --dump reflection=r.pfm
refused --effects reflect --dump reflection_raw=r.pfm
refused --ortho 5 --clip reversed-infinite
refused --dump z0=missing/z0.pfm
refused --json missing/report.json
refused --json .
check "refused: no EGL" no_egl refuses

# >> broken scenes

triangle() { # BUFFER_URI VERTEX_COUNT NODE: the last three are what is broken
    printf '{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [%s],
             "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
             "accessors": [{"bufferView": 0, "componentType": 5126, "count": %s, "type": "VEC3",
                            "min": [0, 0, 0], "max": [1, 1, 0]}],
             "bufferViews": [{"buffer": 0, "byteLength": 36}],
             "buffers": [{"byteLength": 36, "uri": "%s"}]}\n' "$3" "$2" "$1"
}
vertices=data:application/octet-stream\;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA

mkdir scenes scenes/directory.gltf
head -c 36 /dev/zero >outside.bin
triangle "$vertices" 3 '{"mesh": 0}'                    >scenes/good.gltf
triangle "$vertices" 4 '{"mesh": 0}'                    >scenes/vertex_out_of_range.gltf
triangle "$vertices" 3 '{"mesh": 1}'                    >scenes/mesh_out_of_range.gltf
triangle "$vertices" 3 '{"mesh": 0, "children": [7]}'   >scenes/child_out_of_range.gltf
triangle "$vertices" 3 '{"mesh": 0, "children": [0]}'   >scenes/own_child.gltf
triangle ../outside.bin 3 '{"mesh": 0}'                 >scenes/outside.gltf
triangle "$PWD/outside.bin" 3 '{"mesh": 0}'             >scenes/absolute.gltf
triangle missing.bin 3 '{"mesh": 0}'                    >scenes/missing_buffer.gltf
triangle data:application/octet-stream\;base64,AAAA 3 '{"mesh": 0}' >scenes/short_buffer.gltf
head -c 300 scenes/good.gltf                            >scenes/truncated.gltf
printf '{"asset": }'                                    >scenes/bad_json.gltf
printf '{"asset": {"version": "2.0"}}'                  >scenes/no_meshes.gltf
printf '[]'                                             >scenes/array.gltf
printf ''                                               >scenes/empty.gltf
printf 'glTF\002\000\000\000\377\000\000\000'           >scenes/truncated.glb
printf 'glTF\002\000\000\000\014\000\000\000'           >scenes/no_chunk.glb
printf 'no scene at all'                                >scenes/text.glb

# floats NUMBER...: writes each as 4 bytes, the lowest first
floats() {
    # shellcheck disable=SC2059 # awk writes the format
    printf "$(printf '%s\n' "$@" | awk '
        $1 == "nan" { printf "\\000\\000\\300\\177"; next }
        { x = $1 < 0 ? -$1 : $1; e = 127
          while (x >= 2) { x /= 2; ++e }
          while (x < 1 && x > 0) { x *= 2; --e }
          b = x > 0 ? ($1 < 0) * 2^31 + e * 2^23 + int((x - 1) * 2^23 + 0.5) : 0
          for (i = 0; i < 4; ++i) { printf "\\%03o", b % 256; b = int(b / 256) } }')"
}

# A strip that two joints bend, the upper one animated, in front of one that no joint bends.
# skinned NAME=VALUE...: what is other than below
skinned() (
    weight=0.5 joint=001 bind=1 binds=2 joints='1, 2' skin=0 weights_type=5126 joints_type=5121 # in the skin
    times='0 1' interpolation=LINEAR sampler=0 target=2 path=rotation place='"translation": [0, 1, 0]'
    values='0 0 0 1  0 0 0.7071 0.7071' values_type=VEC4 keys=2 values_count=2
    for change in "$@"; do export "${change?}"; done
    # shellcheck disable=SC2059,SC2086 # formats, lists
    {
        floats -0.5 0 0  0.5 0 0  -0.5 1 0  0.5 1 0  -0.5 2 0  0.5 2 0
        floats 1 0 0 0  1 0 0 0  $weight 0.5 0 0  $weight 0.5 0 0  0 1 0 0  0 1 0 0
        floats $bind 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1  1 0 0 0 0 1 0 0 0 0 1 0 0 -1 0 1
        printf '\000\001\002\002\001\003\002\003\004\004\003\005'
        printf "\\000\\$joint\\000\\000%.0s" 1 2 3 4 5 6
        floats $times
        floats $values
    } >skin.bin
    size=$(wc -c <skin.bin)
    cat <<END
{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1, 3]}],
 "nodes": [{"mesh": 0, "skin": $skin}, {"children": [2]}, {$place}, {"mesh": 0, "translation": [0.3, 0, -1]}],
 "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "WEIGHTS_0": 1, "JOINTS_0": 4}, "indices": 3, "material": 0}]}],
 "materials": [{"doubleSided": true, "pbrMetallicRoughness": {"metallicFactor": 0}}],
 "skins": [{"inverseBindMatrices": 2, "joints": [$joints]}],
 "animations": [{"samplers": [{"input": 5, "output": 6, "interpolation": "$interpolation"}],
                 "channels": [{"sampler": $sampler, "target": {"node": $target, "path": "$path"}}]}],
 "accessors": [{"bufferView": 0, "byteOffset": 0, "componentType": 5126, "count": 6, "type": "VEC3",
                "min": [-0.5, 0, 0], "max": [0.5, 2, 0]},
               {"bufferView": 0, "byteOffset": 72, "componentType": $weights_type, "count": 6, "type": "VEC4"},
               {"bufferView": 0, "byteOffset": 168, "componentType": 5126, "count": $binds, "type": "MAT4"},
               {"bufferView": 0, "byteOffset": 296, "componentType": 5121, "count": 12, "type": "SCALAR"},
               {"bufferView": 0, "byteOffset": 308, "componentType": $joints_type, "count": 6, "type": "VEC4"},
               {"bufferView": 0, "byteOffset": 332, "componentType": 5126, "count": $keys, "type": "SCALAR"},
               {"bufferView": 0, "byteOffset": 340, "componentType": 5126, "count": $values_count, "type": "$values_type"}],
 "bufferViews": [{"buffer": 0, "byteLength": $size}],
 "buffers": [{"byteLength": $size, "uri": "data:application/octet-stream;base64,$(base64 <skin.bin | tr -d '\n')"}]}
END
)

bad_skin() { file=$1 && shift && skinned "$@" >"scenes/skin_$file.gltf"; }
bad_skin joint_out_of_range      joint=002
bad_skin joint_far_out_of_range  joint=377
bad_skin joint_type              joints_type=5126
bad_skin negative_weight         weight=-0.5
bad_skin weight_not_finite       weight=nan
bad_skin weights_out_of_range    weights_type=9
bad_skin bind_not_finite         bind=nan
bad_skin too_few_binds           binds=1
bad_skin too_many_binds          binds=9
bad_skin no_joints               joints=
bad_skin joint_without_node      joints='1, 9'
bad_skin joint_negative          joints='1, -1'
bad_skin no_such_skin            skin=1
bad_skin times_decrease          times='1 0'
bad_skin times_equal             times='1 1'
bad_skin time_negative           times='-1 1'
bad_skin time_not_finite         times='0 nan'
bad_skin no_times                keys=0
bad_skin too_many_times          keys=99
bad_skin value_not_finite        values='0 0 0 1  0 0 nan 1'
bad_skin too_few_values          values_count=1
bad_skin too_many_values         values_count=99
bad_skin rotation_of_three       values_type=VEC3
bad_skin scale_of_four           path=scale
bad_skin cubic_without_tangents  interpolation=CUBICSPLINE
bad_skin interpolation           interpolation=WAVE
bad_skin no_such_sampler         sampler=1
bad_skin no_such_target          target=9
bad_skin target_has_matrix       place='"matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 1, 0, 1]'

renders() { "$render" "$1" --size 32x32 --guard 0 --frames 1 --out good && [ -s good/final.png ]; }

check "a good scene renders" renders scenes/good.gltf
for scene in scenes/*; do
    if [ "$scene" != scenes/good.gltf ]; then check "refused: $scene" refuses "../$scene"; fi
done
refused ../scenes/missing.gltf

# >> a small picture: every file that can be written

small="$render --size 160x90 --frames 3"
dumps='z0 z1 normal0 normal1 albedo0 albedo1 radiance0 radiance1 ao ao_raw irradiance0 irradiance0_raw
       confidence0 reflection reflect_confidence reflect_layer reflect_length final'
pictures='final direct ambient_visibility indirect layer0 layer1'

render_all() {
    set --
    for name in $dumps; do set -- "$@" --dump "$name=$name.pfm"; done
    $small --effects ao,gi,reflect --sky 0.3,0.4,0.5 --out out/deeper --json report.json "$@"
}

png_size_is() { # FILE WIDTH HEIGHT, each below 65536
    signature=$(od -An -tx1 -N 8 "$1" | tr -d ' \n')
    size=$(od -An -tu1 -j 16 -N 8 "$1" | awk '{ print 256 * $3 + $4, 256 * $7 + $8 }')
    echo "$signature $size"
    [ "$signature" = 89504e470d0a1a0a ] && [ "$size" = "$2 $3" ]
}
pictures_are_there() {
    for name in $pictures; do png_size_is "out/deeper/$name.png" 160 90 || return 1; done
}

channels_of() { case $1 in z? | ao | ao_raw | confidence0 | reflect_*) echo 1 ;; *) echo 3 ;; esac; }
pfm_is_right() { # NAME
    channels=$(channels_of "$1")
    letters=PF
    if [ "$channels" -eq 1 ]; then letters=Pf; fi
    header=$(head -n 3 "$1.pfm" | tr '\n' ' ')
    bytes=$(wc -c <"$1.pfm")
    echo "$header, $bytes bytes"
    [ "$header" = "$letters 160 90 -1.0 " ] && [ "$bytes" -eq $((${#header} + 4 * 160 * 90 * channels)) ]
}

# The numbers of a dump, a pixel a line.
pixels() {
    od -An -v -tf4 -j "$(head -n 3 "$1.pfm" | wc -c)" "$1.pfm" |
        awk -v channels="$(channels_of "$1")" \
            '{ for (i = 1; i <= NF; ++i) printf "%s%s", $i, ++n % channels ? " " : "\n" }'
}

# within LOW HIGH NAME: every number is, and they are not all the same
within() {
    pixels "$3" | awk -v low="$1" -v high="$2" '
        { for (i = 1; i <= NF; ++i) {
              if ($i !~ /^-?[0-9]/ || $i < low || $i > high) { if (!bad++) print "first:", $i, "in line", NR }
              if ($i != first && NR > 1) various = 1
              first = NR == 1 ? $i : first } }
        END { print bad + 0, "numbers are out of range;", NR, "pixels"
              exit !(NR == 14400 && various && !bad) }'
}

# Unit where there is a surface, 0 where there is none.
normals_are_unit() { # LAYER
    pixels "z$1" >z.text
    pixels "normal$1" | paste -d ' ' z.text - | awk '
        { square = $2 * $2 + $3 * $3 + $4 * $4; wanted = $1 < 0
          if (square - wanted > 1e-5 || wanted - square > 1e-5) { if (!bad++) print "first:", $0 } }
        END { print bad + 0, "normals are wrong"; exit bad || NR != 14400 }'
}

second_layer_is_behind() { # by more than 0.5 m
    pixels z0 >z.text
    pixels z1 | paste -d ' ' z.text - | awk '
        { if ($2 < 0) { ++filled; if ($1 == 0 || $2 > $1 - 0.5 + 1e-5) { if (!bad++) print "first:", $0 } } }
        END { print filled + 0, "are filled,", bad + 0, "too near"; exit !(filled > 1000 && !bad) }'
}

# final = emission + direct + albedo / pi * lerp(visibility * irradiance of the sky, irradiance, min(2 confidence, 1)).
# The first two are radiance0, which has 6 bits after the point, 5 for blue, and may be rounded down.
composite_adds_up() {
    parts='radiance0 albedo0 irradiance0 ao confidence0 final z0'
    for name in $parts; do pixels "$name" >"part_$name"; done
    # shellcheck disable=SC2046,SC2086 # lists of words
    paste -d ' ' $(printf 'part_%s ' $parts) | awk '
        BEGIN { pi = 3.14159265; sky[1] = 0.3; sky[2] = 0.4; sky[3] = 0.5 }
        $15 < 0 { ++surfaces; known = $11 < 0.5 ? 2 * $11 : 1
                  for (c = 1; c <= 3; ++c) {
                      irradiance = $10 * pi * sky[c] * (1 - known) + $(6 + c) * known
                      error = $(11 + c) - ($c + $(3 + c) / pi * irradiance)
                      if (error < 0) error = -error
                      error -= $c / (c < 3 ? 64 : 32)
                      if (error > worst) worst = error } }
        END { print surfaces + 0, "pixels, too much by", worst + 0
              exit !(surfaces > 1000 && worst < 0.002) }'
}

check "it renders with every output"           render_all
check "the six pictures have the right size"   pictures_are_there
check "one layer stands beside two"            png_size_is out/deeper/one_vs_two.png 320 90
for name in $dumps; do check "$name.pfm has the right header and size" pfm_is_right "$name"; done
for name in z0 z1; do check "$name is finite and not positive" within -1000 0 $name; done
for name in ao ao_raw confidence0 reflect_confidence albedo0 albedo1; do check "$name is 0 to 1" within 0 1 $name; done
check "reflect_layer is 0 to 2" within 0 2 reflect_layer
for name in normal0 normal1; do check "$name is -1 to 1" within -1 1 $name; done
for name in radiance0 radiance1 irradiance0 irradiance0_raw reflection reflect_length final; do
    check "$name is finite and not negative" within 0 1000 $name
done
check "normals of layer 0 are unit or 0"       normals_are_unit 0
check "normals of layer 1 are unit or 0"       normals_are_unit 1
check "layer 1 lies behind layer 0"            second_layer_is_behind
check "final is what its parts make it"        composite_adds_up

# >> report

parses() {
    if command -v python3 >/dev/null; then
        python3 -c 'import json, sys; json.load(sys.stdin)' <report.json
    elif command -v node >/dev/null; then
        node -e 'JSON.parse(require("fs").readFileSync(0))' <report.json
    else # brackets in pairs, at least
        [ "$(tr -dc '{[' <report.json | wc -c)" -eq "$(tr -dc '}]' <report.json | wc -c)" ]
    fi
}
has_keys() {
    for key in renderer width height guard layers oracle emission lights shadow_maps probe probe_harmonics build triangles draw_calls vertices_shaded \
               passes name cpu_ms median min max gpu_ms textures bytes bytes_total hash; do
        grep -q "\"$key\": " report.json || { echo "$key is missing"; return 1; }
    done
}
says() { for text in "$@"; do grep -q "$text" report.json || { echo "not there: $text"; return 1; }; done; }
bytes_add_up() {
    tr ',}' '\n ' <report.json | awk '/"bytes":/ { sum += $NF } /"bytes_total":/ { total = $NF }
                                      END { print sum, "of", total; exit !(total > 0 && sum == total) }'
}
many_triangles() { [ "$(sed -n 's/.*"triangles": \([0-9]*\).*/\1/p' report.json)" -ge 50000 ]; }

check "the report is JSON"                     parses
check "it has every key"                       has_keys
check "it says what was asked for" \
    says '"width": 160,' '"height": 90,' '"guard": 64,' '"layers": 2,' '"oracle": "reproject",'
check "its bytes add up"                       bytes_add_up
check "the atrium has 50,000 triangles"        many_triangles

# >> the same picture, and other ones

hash_of() {
    rm -f hash.json
    $small --json hash.json "$@" >/dev/null && sed -n 's/.*"hash": "\([0-9a-f]\{16\}\)".*/\1/p' hash.json
}
same()    { hash=$(hash_of "$@"); echo "$hash"; [ -n "$hash" ] && [ "$hash" = "$reference" ]; }
another() { hash=$(hash_of "$@"); echo "$hash"; [ -n "$hash" ] && [ "$hash" != "$reference" ]; }

reference=$(hash_of)
check "the hash has 16 digits"                 [ ${#reference} -eq 16 ]
check "the same command, the same picture"     same
check "--oracle peel, the same picture"        same --oracle peel
check "--oracle previous, the same picture"    same --oracle previous
check "--oracle reproject, the same picture"   same --oracle reproject
check "--emit separate, the same picture"      same --emit separate
check "--emit vertex, the same picture"        same --emit vertex
check "--profile, the same picture"            same --profile
check "--layers 1, another picture"            another --layers 1
check "--layers 3, the same picture"           same --layers 3
check "--emit geometry renders"                hash_of --emit geometry
check "--effects none, another picture"        another --effects none
check "--effects ao,gi,reflect, the same picture" same --effects ao,gi,reflect
check "--effects reflect renders"              hash_of --effects reflect
mirror_image() { # OPTION...: a file of what every mirror shows
    "$render" --size 160x90 --guard 16 --frames 1 --effects reflect --dump reflection=mirror_image.pfm "$@" >/dev/null &&
        cksum <mirror_image.pfm
}
same_mirror_image() { [ "$(mirror_image --tracer linear)" = "$(mirror_image --tracer hierarchical)" ]; }
check "--tracer hierarchical, the same mirror image" same_mirror_image
check "--effects glossy, another picture"      another --effects ao,gi,glossy
check "--roughness without glossy, the same picture" same --roughness 0.1
hits() { # OPTION...: pixels whose mirrored ray meets something
    "$render" --size 160x90 --guard 16 --frames 1 --effects reflect --dump reflect_layer=reflect_hits.pfm "$@" >/dev/null &&
        pixels reflect_hits | awk '$1 > 0 { ++n } END { print n + 0 }'
}
grows() { # NUMBER...
    echo "$@" && [ $# -gt 1 ] && while [ $# -gt 1 ]; do [ "$1" -lt "$2" ] || return 1; shift; done
}
more_steps() { grows "$(hits --reflect-steps 1)" "$(hits --reflect-steps 16)" "$(hits --reflect-steps 256)"; }
longer_rays() { grows "$(hits --reflect-distance 1)" "$(hits --reflect-distance 4)" "$(hits --reflect-distance 16)"; }
thicker() { grows "$(hits --reflect-thickness 0.01)" "$(hits --reflect-thickness 0.5)"; }
check "--reflect-steps: more hit more"         more_steps
check "--reflect-distance: longer rays hit more" longer_rays
check "--reflect-thickness: thicker surfaces are hit more" thicker
measured() { grows "$(hits --reflect-thickness 4 --thickness-from back)" "$(hits --reflect-thickness 4)"; }
check "--thickness-from back: surfaces that end are hit less" measured
check "--preset quality, another picture"      another --preset quality
check "--separation 3, another picture"        another --separation 3
check "--samples 5, another picture"           another --samples 5
check "--radius 2, another picture"            another --radius 2
check "--ao-samples 5, another picture"        another --ao-samples 5
check "--ao-radius 3, another picture"         another --ao-radius 3
check "--sun none, another picture"            another --sun none
check "--point 0,1,0,9, another picture"       another --point 0,1,0,9
check "--sky 0,0,0, another picture"           another --sky 0,0,0
check "--exposure 1, another picture"          another --exposure 1
check "--orbit 5, another picture"             another --orbit 5
check "--ortho 8, another picture"             another --ortho 8
check "--guard 0, another picture"             another --guard 0

check "--oracle predict, the same picture"     same --oracle predict
check "--oracle delay, the same picture"       same --oracle delay
check "--emit image, the same picture"         same --emit image
check "--oracle predict --emit image"          same --oracle predict --emit image --layers 4
check "--layers 8, the same picture"           same --layers 8 --oracle delay
check "--emit instanced-geometry renders"      hash_of --emit instanced-geometry
check "--time without animation"               same --time 3.7 --fps 11
for divisor in 2 4; do
    check "--divisor $divisor, another picture" another --divisor $divisor
    check "--divisor $divisor with PEEL"        another --divisor $divisor --oracle peel
    check "--divisor $divisor with an odd size" hash_of --divisor $divisor --guard 3 --layers 3
done
check "--divisor 1, the same picture"          same --divisor 1

# Where the driver lacks it, one sentence; elsewhere it renders.
multicast() { refuses --emit multicast || hash_of --emit multicast; }
check "--emit multicast renders or is refused" multicast

# A layer of lower resolution is enlarged: every texel is a square of equal pixels.
squares_of() { # DIVISOR
    $small --guard 0 --divisor "$1" --effects none --dump radiance1=radiance1.pfm >/dev/null || return 1
    pixels radiance1 | awk -v d="$1" '
        { x = (NR - 1) % 160; y = int((NR - 1) / 160); at = int(x / d) " " int(y / d)
          if ($0 == "0 0 0") next # empty, or too near the first layer, which is not enlarged
          ++lit
          if (at in seen && seen[at] != $0) { if (!bad++) print "first:", x, y }
          seen[at] = $0 }
        END { print bad + 0, "of", lit + 0, "differ"; exit !(NR == 14400 && lit > 1000 && !bad) }'
}
check "--divisor 2 has squares of 2 pixels"    squares_of 2
check "--divisor 4 has squares of 4 pixels"    squares_of 4

# >> animation

mkdir moving
skinned                                                                   >moving/linear.gltf
skinned interpolation=STEP                                                >moving/step.gltf
skinned interpolation=CUBICSPLINE values_count=6 \
    values='0 0 0 0  0 0 0 1  0 0 0 0  0 0 0 0  0 0 0.7071 0.7071  0 0 0 0' >moving/cubic.gltf
skinned path=translation values='0 1 0  0.5 1 0' values_type=VEC3         >moving/translation.gltf
skinned path=scale values='1 1 1  2 2 2' values_type=VEC3                 >moving/scale.gltf
skinned path=translation target=3 values='0.3 0 -1  0.9 0 -1' values_type=VEC3 >moving/rigid.gltf
skinned values='0 0 0 1  0 0 0 1'                                         >moving/still.gltf

# moved SCENE FRAMES OPTION...: the hash of the last frame, and a sum of its second layer
moved() {
    scene=$1 frames=$2
    shift 2
    rm -f hash.json
    "$render" "moving/$scene.gltf" --size 96x64 --camera 0.5,1,5,0,1,0,45 --frames "$frames" "$@" \
        --json hash.json --dump z1=moved.pfm >/dev/null &&
        sed -n 's/.*"hash": "\([0-9a-f]\{16\}\)".*/\1/p' hash.json && cksum <moved.pfm
}
# Each takes two lists of arguments of `moved`.
# shellcheck disable=SC2086 # lists of words
alike()  { a=$(moved $1) b=$(moved $2) && echo "$a $b" && [ -n "$a" ] && [ "$a" = "$b" ]; }
# shellcheck disable=SC2086
differ() { a=$(moved $1) b=$(moved $2) && echo "$a $b" && [ -n "$a" ] && [ -n "$b" ] && [ "$a" != "$b" ]; }

for scene in linear cubic translation scale rigid; do
    check "$scene: time moves it"      differ "$scene 1" "$scene 1 --time 0.25"
done
check "an animation repeats"           alike "linear 1 --time 0.25" "linear 1 --time 2.25"
for scene in linear rigid; do
    turning="--time 0.25 --fps 4 --orbit 2" # the last frame begins the next round
    check "$scene: frames take time"   alike "$scene 1 --time 0.5" "$scene 2 --time 0.25 --fps 4 --oracle peel"
    check "$scene: PREDICT is exact"   alike "$scene 4 $turning --oracle peel" "$scene 4 $turning --oracle predict"
    check "$scene: DELAY is exact"     alike "$scene 3 $turning --oracle peel" "$scene 4 $turning --oracle delay"
done
check "PREVIOUS is not"                differ "linear 4 $turning --oracle peel" "linear 4 $turning --oracle previous"
# With level tangents, a quarter of the time is 3/16 - 2/64 of the way.
eased() {
    skinned path=translation target=3 values_type=VEC3 values='0 0 -1  0 0 1' >moving/even.gltf
    skinned path=translation target=3 values_type=VEC3 interpolation=CUBICSPLINE values_count=6 \
        values='0 0 0  0 0 -1  0 0 0  0 0 0  0 0 1  0 0 0' >moving/eased.gltf
    moved even 1 --time 0.15625 --dump z0=z0.pfm && pixels z0 >even.text &&
        moved eased 1 --time 0.25 --dump z0=z0.pfm && pixels z0 | paste -d ' ' even.text - | awk '
            $1 < 0 { ++filled; error = $1 - $2; if (error < 0) error = -error; if (error > 1e-3) ++bad }
            END { print bad + 0, "of", filled + 0, "differ"; exit !(NR == 6144 && filled > 300 && !bad) }'
}
check "STEP holds its value"           alike "step 1" "step 1 --time 0.75"
check "a cubic curve eases in and out" eased
check "nothing moves at rest"          alike "still 1" "still 3 --time 0.4"

# The depth convention changes rounding, no more: few pixels' z differs by more than a hundredth.
clip_is() {
    $small --dump z0=clip.pfm --clip "$1" >/dev/null || return 1
    mv clip.pfm z1.pfm && pixels z1 >clip.text
    paste -d ' ' z.text clip.text | awk '
        { error = $1 - $2; if (error < 0) error = -error; if (error > -0.01 * $1) ++bad }
        END { print bad + 0, "of", NR, "differ"; exit !(NR == 14400 && bad < 30) }'
}
for clip in standard reversed reversed-infinite; do
    check "--clip $clip sees the same surfaces" clip_is $clip
done

echo "1..$tests"
