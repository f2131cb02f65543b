#!/bin/sh
# Light that bounces again and again in build/release/render: --bounces, --delta, --boost, --alpha, the dumps of the second
# layer and of history, and the pictures about them. Prints TAP.

cd "$(dirname "$0")/../.." || exit 1
. tests/support/tap.sh
render=$PWD/build/release/render
cd "$dir" || exit 1

# >> scenes: a floor of 4 x 4 m and a wall along its left side. The sun in the zenith lights the floor alone, so the floor
# >> gets light at the second bounce first.

# corner R,G,B: of that albedo
corner() {
    cat <<END
{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}],
 "nodes": [{"mesh": 0, "scale": [4, 1, 4]},
           {"mesh": 0, "translation": [-2, 2, 0], "rotation": [0, 0, 0.70710678, -0.70710678], "scale": [4, 1, 4]}],
 "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
 "materials": [{"doubleSided": true, "pbrMetallicRoughness": {"metallicFactor": 0, "baseColorFactor": [$1, 1]}}],
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
corner 0.8,0.8,0.8 >grey.gltf
corner 0.8,0,0     >red.gltf

# in_corner SCENE OPTION...: 64 x 48 pixels that both squares fill for the most part; writes irradiance0.pfm
in_corner() {
    scene=$1
    shift
    "$render" "$scene.gltf" --size 64x48 --guard 16 --camera 1.5,2.5,4,-1.5,0.8,-0.5,45 --sun 0,1,0,10 --sky 0,0,0 \
        --dump irradiance0=irradiance0.pfm "$@" >/dev/null
}

# The numbers of NAME.pfm, CHANNELS a line: a line a pixel.
pixels() { od -An -v -w"$((4 * $2))" -tf4 -j "$(head -n 3 "$1.pfm" | wc -c)" "$1.pfm"; }
# print_mean OPTION...: of the red irradiance in the corner
print_mean() { in_corner "${scene_name:-grey}" "$@" && pixels irradiance0 3 | awk '{ sum += $1 } END { print sum / NR }'; }
# increase NUMBER...: by more than a hundredth of the greater one
increase() {
    echo "$@"
    echo "$@" | awk '{ for (i = 2; i <= NF; ++i) if ($i ~ /[^-+.0-9e]/ || $(i - 1) >= 0.99 * $i) exit 1; exit NF < 2 }'
}

# >> refusals

# refuses_all_of ARGUMENT...: in an empty directory, which stays empty; the sentence names the first argument
refuses_all_of() {
    mkdir empty && cd empty || return 1
    refuses "$render" "$@"
    status=$? files=$(ls -A)
    cd .. && rm -rf empty
    echo "files: $files"
    [ $status -eq 0 ] && [ -z "$files" ] && grep -q -e "$1" err
}
refused() { check "refused: $*" refuses_all_of "$@" --out out --dump z0=z0.pfm; }
for value in 0 -1 1.5 nan inf many '';             do refused --bounces "$value"; done
for value in 1 -0.1 0.9995 nan half '';            do refused --alpha "$value"; done
for value in 1.1 -0.1 nan inf half '';             do refused --delta "$value"; done
for value in 1 1,2,3 -1,1 1,-1 nan,1 1,inf '1,' ',1' ''; do refused --boost "$value"; done
for value in 0 1.5 1001 nan 1,,2 1,0 -1 1,2,3,4,5 ''; do refused --compare-bounces "$value"; done
refused --bounces 9
refused --bounces 4 --frames 3
refused --compare-bounces 1,2 --effects ao
check "refused: --compare-bounces without --out" refuses_all_of --compare-bounces 1,2 --dump z0=z0.pfm
for name in irradiance1 irradiance1_raw confidence1 history0 history1; do
    refused --dump "$name=a.pfm" --effects ao
    refused --dump "$name=a.pfm" --effects none
done
for name in irradiance1 irradiance1_raw confidence1 history1; do refused --dump "$name=a.pfm" --layers 1; done

help_names_all() {
    "$render" --help >help || return 1
    for word in bounces compare-bounces delta boost alpha; do
        grep -q -e "^ *--$word " help || { echo "--$word is missing"; return 1; }
    done
    for word in confidence fallback second_alone disocclusion bounces.png; do
        grep -q -w "$word" help || { echo "$word is missing"; return 1; }
    done
}
check "--help names the options and pictures" help_names_all

# >> bounces

more_bounces() { increase "$(print_mean --bounces 1)" "$(print_mean --bounces 2)" "$(print_mean --bounces 8)"; }
more_delta() {
    increase "$(print_mean --delta 0)" "$(print_mean --delta 0.3)" "$(print_mean --delta 0.6)" "$(print_mean --delta 1)"
}
more_boost() { increase "$(print_mean --boost 0,0)" "$(print_mean --boost 0.7,0)" "$(print_mean --boost 1.2,0)"; }
more_red_boost() {
    scene_name=red
    increase "$(print_mean --boost 0,0)" "$(print_mean --boost 0,0.7)" "$(print_mean --boost 0,1.2)"
}
# same_light SCENE "OPTION..." "OPTION...": bit for bit, and not black
# shellcheck disable=SC2086 # lists of words
same_light() {
    in_corner "$1" $2 && mv irradiance0.pfm first.pfm && in_corner "$1" $3 && cmp first.pfm irradiance0.pfm &&
        pixels irradiance0 3 | awk '$1 > 0 { ++lit } END { print lit + 0, "lit"; exit lit < 500 }'
}
# The floor is where normals point up in world space: towards the camera's up.
floor_waits() { # for the second bounce
    for bounces in 1 2; do
        in_corner grey --bounces $bounces --dump radiance0=radiance0.pfm || return 1
        pixels irradiance0 3 >light.text
        pixels radiance0 3 | paste -d ' ' light.text - | awk -v bounces=$bounces '
            $4 > 0 { ++sunlit; if ($1 > 0) ++lit } END { print bounces, "bounces:", lit + 0, "of", sunlit + 0, "are lit"
            exit !(sunlit > 300 && (bounces == 1 ? lit == 0 : lit > 0.9 * sunlit)) }' || return 1
    done
}
check "1 bounce is darker than 2, 2 than 8"       more_bounces
check "what the sun lights waits for bounce 2"    floor_waits
check "more delta, more light"                    more_delta
check "more boost of grey, more light"            more_boost
check "more boost of red, more light"             more_red_boost
check "--delta 0 is --bounces 1"                  same_light grey '--alpha 0 --delta 0' '--alpha 0 --bounces 1'
check "also with history"                         same_light grey '--delta 0' '--bounces 1'
check "--boost 0,1: grey does not bounce again"   same_light grey '--alpha 0 --boost 0,1' '--alpha 0 --bounces 1'
check "--boost 1,0: red does not"                 same_light red '--alpha 0 --boost 1,0' '--alpha 0 --bounces 1'
check "--boost 1,1 is the default"                same_light red '--boost 1,1' ''
check "--alpha 0.85 --delta 1 are the defaults"   same_light grey '--alpha 0.85 --delta 1' ''

# >> the temporal average

# alone FRAMES OPTION...: a single shaded pixel, which the reconstruction leaves alone
alone() {
    frames=$1
    shift
    "$render" grey.gltf --size 1x1 --guard 4 --preset performance --camera 1,1,0,-2,0.2,0,4 --sun 0,1,0,10 --radius 4 \
        --ao-radius 2 --ao-samples 3 --frames "$frames" "$@" >/dev/null
}
no_history() {
    for frames in 1 2 3 5; do
        alone $frames --alpha 0 --dump irradiance0_raw=raw.pfm --dump irradiance0=mean.pfm --dump ao_raw=ao_raw.pfm \
            --dump ao=ao.pfm || return 1
        cmp raw.pfm mean.pfm && cmp ao_raw.pfm ao.pfm && pixels raw 3 | awk '{ exit !($1 > 0) }' || return 1
    done
}
# The first frames weigh alike, until history has the weight that was asked for. Both are bytes: halves of 1/255.
averages() { # ALPHA
    for frames in 1 2 3 4 5 6 7 8 9 10; do
        alone "$frames" --alpha "$1" --dump ao_raw=raw.pfm --dump ao=mean.pfm && pixels raw 1 | tr '\n' ' ' && pixels mean 1
    done >means.text
    awk -v alpha="$1" '
        { weight = (NR - 1) / NR < alpha ? (NR - 1) / NR : alpha
          mean = weight * mean + (1 - weight) * $1; error = $2 - mean; if (error * error > 0.005 ^ 2) ++bad
          print $0, mean; error = $2 - $1; if (error * error > 0.02 ^ 2) ++differ }
        END { print bad + 0, "bad,", differ + 0, "differ"; exit !(NR == 10 && !bad && differ >= 4) }' means.text
}
# print_change ALPHA: of the light in the corner from one frame to the next
print_change() {
    in_corner grey --delta 0 --frames 9 --alpha "$1" && pixels irradiance0 3 >last.text &&
        in_corner grey --delta 0 --frames 10 --alpha "$1" &&
        pixels irradiance0 3 | paste -d ' ' last.text - | awk '{ sum += ($4 - $1) ^ 2 } END { print sqrt(sum / NR) }'
}
history_calms() { increase "$(print_change 0.95)" "$(print_change 0.85)" "$(print_change 0.5)"; }
# Without history to hide it, noise stands still.
nothing_changes() { [ "$(print_change 0)" = 0 ]; }
check "--alpha 0: the mean is what was gathered"  no_history
check "--alpha 0.85: the mean of the frames"      averages 0.85
check "--alpha 0.5 also"                          averages 0.5
check "more alpha, less change by the frame"      history_calms
check "--alpha 0: none while nothing moves"       nothing_changes

# >> history

# atrium OPTION...: a small picture of it
atrium() { "$render" --size "${size:-160x90}" --guard 16 "$@" >/dev/null; }
# counts LAYER FRAMES: how many pixels have which count; the surfaces of that layer and no others have one
counts() {
    pixels "z$1" 1 >z.text
    pixels "history$1" 1 | paste -d ' ' z.text - | awk -v most="$2" '
        { if ($1 == 0 ? $2 != 0 : !($2 >= 1 && $2 <= most)) { if (!bad++) print "first:", NR, $0 } }
        $1 < 0 { ++surfaces; if ($2 == 1) ++new; if ($2 == most) ++old }
        END { print bad + 0, "bad,", surfaces + 0, "surfaces,", new + 0, "new,", old + 0, "old"
              print surfaces + 0, new + 0, old + 0 >"counted"
              exit !(NR == 14400 && !bad && surfaces > 1000) }'
}
history_of() { # FRAMES OPTION...
    frames=$1
    shift
    atrium --frames "$frames" --dump z0=z0.pfm --dump z1=z1.pfm --dump history0=history0.pfm --dump history1=history1.pfm "$@" &&
        counts 0 "${most:-$frames}" && mv counted counted0 && counts 1 "${most:-$frames}" && mv counted counted1
}
still() {
    for frames in 1 2 3 6; do
        history_of $frames "$@" && awk '$1 != $3 { exit 1 }' counted0 counted1 || return 1
    done
}
# Most pixels have history, others have not.
turning() {
    history_of 6 --orbit 2 --oracle peel &&
        awk '{ if (!($2 > 20 && $2 < 0.25 * $1 && $3 > 0.5 * $1)) exit 1 }' counted0
}
no_more_than_64() { most=64 history_of 66 --effects gi --samples 1 && awk '$1 != $3 { exit 1 }' counted0; }
two_layers_remember_more() {
    history_of 6 --orbit 2 --oracle peel && read -r _ two _ <counted0 &&
        atrium --frames 6 --orbit 2 --layers 1 --dump z0=z0.pfm --dump history0=history0.pfm && counts 0 6 &&
        read -r _ one _ <counted && echo "$two against $one" && [ "$two" -lt $((one * 9 / 10)) ]
}
check "a still camera: 1, 2, 3 and 6 frames"     still
check "the same without ambient occlusion"       still --effects gi
check "the same with --alpha 0"                  still --alpha 0
check "it counts to 64"                          no_more_than_64
check "a turning one: some begin anew"           turning
check "two layers remember more than one"        two_layers_remember_more

# >> the second layer

# zero_where_empty NAME CHANNELS: and finite, not negative, and not all 0
zero_where_empty() {
    pixels z1 1 >z.text
    pixels "$1" "$2" | paste -d ' ' z.text - | awk '
        { for (i = 2; i <= NF; ++i) if (!($i ~ /^[0-9]/) || $i > 1e4 || ($1 == 0 && $i != 0)) { if (!bad++) print NR, $0 } }
        $1 < 0 && $2 > 0 { ++lit }
        END { print bad + 0, "bad,", lit + 0, "are not 0"; exit !(NR == 14400 && !bad && lit > 500) }'
}
second_layer() {
    atrium --dump z1=z1.pfm --dump irradiance1=irradiance1.pfm --dump irradiance1_raw=irradiance1_raw.pfm \
        --dump confidence1=confidence1.pfm "$@" &&
        zero_where_empty irradiance1 3 && zero_where_empty irradiance1_raw 3 && zero_where_empty confidence1 1
}
check "the second layer has light where it is"   second_layer
check "also while the camera turns"              second_layer --orbit 3
check "also without ambient occlusion"           second_layer --effects gi
check "also after 1 bounce"                      second_layer --bounces 1
check "also at half the resolution"              second_layer --divisor 2

# >> pictures

png_size_is() { # FILE WIDTH HEIGHT, each below 65536
    sides=$(od -An -tu1 -j 16 -N 8 "$1" | awk '{ print 256 * $3 + $4, 256 * $7 + $8 }')
    echo "$1 $sides"
    [ "$sides" = "$2 $3" ]
}
about_light='confidence fallback second_alone disocclusion bounces visibility_one_vs_two'
# exactly NAME...: of the pictures above, those are in out and no others
exactly() {
    for name in $about_light; do
        case " $* " in *" $name "*) wanted=1 ;; *) wanted=0 ;; esac
        there=0
        if [ -e "out/$name.png" ]; then there=1; fi
        [ $wanted -eq $there ] || { echo "$name: $there, not $wanted"; return 1; }
    done
}
into_out() { rm -rf out && atrium --frames "${last:-2}" --out out "$@"; }
all_effects() {
    into_out --compare-bounces 1,3,2 && exactly confidence fallback second_alone disocclusion bounces visibility_one_vs_two &&
        png_size_is out/confidence.png 160 90 && png_size_is out/fallback.png 640 90 &&
        png_size_is out/second_alone.png 480 180 && png_size_is out/disocclusion.png 160 90 &&
        png_size_is out/bounces.png 480 180
}
light_alone() {
    into_out --effects gi && exactly confidence fallback second_alone && png_size_is out/second_alone.png 480 90
}
occlusion_alone() {
    into_out --effects ao && exactly visibility_one_vs_two && png_size_is out/visibility_one_vs_two.png 320 90
}
no_effect()       { into_out --effects none && exactly; }
one_layer() {
    into_out --layers 1 && exactly confidence fallback second_alone disocclusion visibility_one_vs_two
}
tiny()            { size=1x1 into_out --compare-bounces 1 && png_size_is out/bounces.png 1 2; }
# Pictures must not change what else is written, nor each other.
same_with_pictures() {
    atrium --frames 3 --json without.json --dump final=without.pfm || return 1
    rm -rf out other
    atrium --frames 3 --json with.json --dump final=with.pfm --out out --compare-bounces 2 &&
        atrium --frames 3 --out other && cmp without.pfm with.pfm &&
        [ "$(grep '"hash"' with.json)" = "$(grep '"hash"' without.json)" ] || return 1
    for name in other/*.png; do cmp "$name" "out/${name#other/}" || return 1; done
}

# >> what they show, away from their labels

# png FILE: prints a pixel a line, from the upper left, "r g b". stb writes one IDAT, right behind the header.
png() {
    columns=$(od -An -tu1 -j 16 -N 4 "$1" | awk '{ print 256 * $3 + $4 }')
    # a gzip header instead of zlib's; what comes at the end is not gzip's
    { printf '\037\213\010\000\000\000\000\000\000\003'; tail -c +44 "$1"; } | gzip -dc 2>/dev/null |
        od -An -v -tu1 -w$((3 * columns + 1)) | awk '
            function distance(x) { return x < 0 ? -x : x }
            function predictor(kind, a, b, c) { # left, above, above left
                if (kind < 3) return kind == 1 ? a : kind == 2 ? b : 0
                if (kind == 3) return int((a + b) / 2)
                p = distance(b - c); q = distance(a - c); r = distance(a + b - 2 * c)
                return p <= q && p <= r ? a : q <= r ? b : c
            }
            { for (i = 2; i <= NF; ++i) {
                  a = i > 4 ? line[i - 3] : 0; c = i > 4 ? above[i - 3] : 0
                  line[i] = ($i + predictor($1, a, above[i] + 0, c)) % 256 }
              for (i = 2; i <= NF; i += 3) print line[i], line[i + 1], line[i + 2]
              for (i = 2; i <= NF; ++i) above[i] = line[i] }'
}

# A dump's numbers in the order of a picture 160 pixels wide.
top_down() {
    pixels "$1" 1 | awk '{ line[NR] = $1 }
        END { for (y = NR / 160 - 1; y >= 0; --y) for (x = 1; x <= 160; ++x) print line[160 * y + x] }'
}
confidence_is_grey() {
    into_out --dump confidence0=confidence0.pfm && top_down confidence0 >wanted.text && png out/confidence.png |
        paste -d ' ' - wanted.text | awk 'NR > 160 * 24 && (NR - 1) % 160 < 100 { # left of the histogram
            error = $1 - 255 * $4; if (error > 0.6 || error < -0.6 || $1 != $2 || $1 != $3) ++bad
            if ($1 > 30) ++bright } END { print bad + 0, bright + 0; exit !(NR == 14400 && !bad && bright > 100) }'
}
# Its histogram stands on a light grey axis of 32 bins, and the fullest bin is 90 / 4 pixels high.
histogram_stands() {
    png out/confidence.png | awk '{ x = (NR - 1) % 160; y = int((NR - 1) / 160) }
        $1 == 160 && $2 == 160 && $3 == 160 { ++axis[y] } $1 == 255 { ++column[x] }
        END { for (y in axis) if (axis[y] > longest) longest = axis[y]
              for (x in column) if (column[x] > highest) highest = column[x]
              print longest, highest; exit !(longest == 32 && highest >= 22) }'
}
# column_means FILE COLUMNS FROM TO: of these rows of each column, 160 pixels wide; of all three channels
column_means() {
    png "$1" | awk -v columns="$2" -v from="$3" -v to="$4" '
        { x = (NR - 1) % (160 * columns); y = int((NR - 1) / (160 * columns)) }
        y >= from && y < to { sum[int(x / 160)] += $1 + $2 + $3 }
        END { for (i = 0; i < columns; ++i) printf "%s ", sum[i] / (480 * (to - from)); print "" }'
}
# Without light from elsewhere the probe gives none, and confidence takes light away.
fallback_blends() {
    into_out --sky 0,0,0 && column_means out/fallback.png 4 24 90 | tee means &&
        awk '{ exit !($1 == 0 && $2 > 10 && $3 > 0 && $3 < $2 && $4 < $2 && $4 > 0) }' means &&
        png out/indirect.png | tail -n +3841 >wanted.text && png out/fallback.png |
        awk '{ x = (NR - 1) % 640 } NR > 640 * 24 && x >= 320 && x < 480' >blended.text && cmp wanted.text blended.text
}
second_alone_is_that() {
    into_out && column_means out/second_alone.png 3 24 90 | tee means &&
        awk '{ exit !($1 < $2 && $3 > $2 && $3 < 254) }' means && column_means out/second_alone.png 3 114 180 | tee means &&
        awk '{ exit !($3 > 1 && $1 > 1.1 * $2 && $1 > $3) }' means
}
nothing_without_second() { # layer: then the first is all there is
    into_out --separation 1000 && column_means out/second_alone.png 3 24 90 | tee means &&
        awk '{ exit !($1 < 250 && $1 == $2 && $3 == 255) }' means && column_means out/second_alone.png 3 114 180 | tee means &&
        awk '{ exit !($1 > 1 && $1 == $2 && $3 == 0) }' means
}
bounces_brighten() {
    into_out --sky 0,0,0 --compare-bounces 1,2,8 && column_means out/bounces.png 3 114 180 | tee means &&
        awk '{ exit !($1 > 1 && $2 > $1 && $3 > $2) }' means
}
colours_are_disocclusions() {
    last=6 into_out --orbit 2 --oracle peel --dump history0=history0.pfm --dump z0=z0.pfm || return 1
    top_down history0 >wanted.text
    top_down z0 | paste -d ' ' wanted.text - >both.text
    png out/disocclusion.png | paste -d ' ' - both.text | awk 'NR > 160 * 40 {
        new = $5 < 0 && $4 == 1; yellow = $1 == 255 && $2 == 255 && $3 == 0; cyan = $1 == 0 && $2 == 255 && $3 == 255
        if (new != yellow || (!yellow && !cyan && ($1 != $2 || $1 != $3))) ++bad
        yellows += yellow; cyans += cyan }
        END { print bad + 0, "bad,", yellows + 0, "yellow,", cyans + 0, "cyan"; exit !(!bad && yellows > 10 && cyans > 10) }'
}
still_is_grey() {
    into_out && png out/disocclusion.png | awk '$1 != $2 || $1 != $3 { ++bad } END { print bad + 0; exit NR != 14400 || bad }'
}
check "both effects: five pictures, and sizes"   all_effects
check "bounced light alone: three"               light_alone
check "occlusion alone: none of them"            occlusion_alone
check "no effect: none of them"                  no_effect
check "one layer: four"                          one_layer
check "a picture of one pixel"                   tiny
check "with pictures, the same dumps and hash"   same_with_pictures
check "confidence is what the dump says"         confidence_is_grey
check "beside it stands a histogram"             histogram_stands
check "the fallback blends two lights"           fallback_blends
check "the second layer alone"                   second_alone_is_that
check "alone, where there is none"               nothing_without_second
check "compared bounces get brighter"            bounces_brighten
check "disocclusions: yellow, cyan, else grey"   colours_are_disocclusions
check "a still camera: none"                     still_is_grey

# >> report

says() { for text in "$@"; do grep -q "^ *$text,\$" report.json || { cat report.json; return 1; }; done; }
reports() {
    options=$1
    shift
    # shellcheck disable=SC2086 # a list of words
    atrium --frames 3 --json report.json $options && says "$@"
}
mean_is_reported() {
    atrium --frames 3 --json report.json --dump z0=z0.pfm --dump confidence0=confidence0.pfm || return 1
    pixels z0 1 >z.text
    said=$(sed -n 's/.*"mean_confidence": \([0-9.]*\),/\1/p' report.json)
    pixels confidence0 1 | paste -d ' ' z.text - | awk -v said="$said" '
        $1 < 0 { sum += $2; ++surfaces } END { mean = sum / surfaces; print said, mean; error = said - mean
        exit !(mean > 0 && error < 2e-6 && error > -2e-6) }'
}
check "it reports the defaults"      reports '' '"bounces": 3' '"alpha": 0.850000024' '"delta": 1'
check "it reports what was asked"    reports '--bounces 2 --alpha 0.5 --delta 0.25' '"bounces": 2' '"alpha": 0.5' '"delta": 0.25'
check "it reports mean confidence"   mean_is_reported
check "without light there is none"  reports '--effects ao' '"bounces": 0' '"mean_confidence": null'

echo "1..$tests"
