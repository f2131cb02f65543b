#!/bin/sh
# The shaders as compiled for a GPU, by the table that gpu_cost writes: registers, spills, and whether the table can be
# trusted. Skips where libvulkan, the driver or glslangValidator is missing. Prints TAP.

cd "$(dirname "$0")/../.." || exit 1
. tests/support/tap.sh
program=build/release/tests/gpu_cost/gpu_cost
table=$dir/gpu_cost.csv

if [ ! -x $program ]; then echo "1..0 # SKIP libvulkan is missing"; exit 0; fi
$program "$dir" >"$dir/printed" 2>&1
status=$?
why=$(sed -n 's/^gpu_cost: skipped: //p' "$dir/printed")
if [ -n "$why" ]; then echo "1..0 # SKIP $why"; exit 0; fi

compiles() { cat "$dir/printed"; [ $status -eq 0 ]; }

# rows EXPRESSION: variants for which it holds; columns go by their names. Exit status 1: there are none.
rows() {
    condition=$(echo "$1" | tr '\n' ' ')
    awk -F, "NR == 1 { for (i = 1; i <= NF; ++i) at[\$i] = i; next }
             { for (name in at) is[name] = \$at[name]; if ($condition) { print is[\"variant\"]; ++found } }
             END { exit !found }" "$table"
}
none() { rows "$1"; [ $? -eq 1 ]; }

check "every variant compiles" compiles
for pass in pack mip tiles ao gather temporal reconstruct reflect; do
    check "$pass is in the table" rows "is[\"pass\"] == \"$pass\""
done

# A vector register spills to memory; a scalar one to a lane of a vector register, which costs two instructions: pack,
# with its many uniforms, may.
check "no vector register spills"                    none 'is["vgpr_spills"] > 0'
check "no scalar register spills but of pack"        none 'is["sgpr_spills"] > 0 && is["pass"] != "pack"'
# A SIMD shares 512 registers among its waves of 64 pixels: 32 leave it 16 waves, all that it can hold, to hide fetches
# with; 48 leave 10, 56 leave 9, 72 leave 7, 80 leave 6, 88 leave 5.
# at_most REGISTERS PASS BITMASK DEEP: the last two 1 or 0
at_most() {
    none "is[\"pass\"] == \"$2\" && (is[\"variant\"] ~ /bitmask/) == $3 && (is[\"variant\"] ~ /deep/) == $4 &&
        is[\"vgprs\"] > $1"
}
check "occlusion takes 32 registers at most"         at_most 32 ao 0 0
check "bounced light takes 48"                       at_most 48 gather 0 0
check "72 where the second layer receives as well"   at_most 72 gather 0 1
check "the bitmask takes 56 for occlusion"           at_most 56 ao 1 0
check "80 for light"                                 at_most 80 gather 1 0
check "88 where the second layer receives as well"   at_most 88 gather 1 1

# The driver counts the few instructions behind the branches around the loops for a half or three quarters: less than
# 1 %.
check "our account of instructions is the driver's"  none '
    (is["variant"] == "ao layers=1" || is["pass"] == "gather") && is["variant"] !~ /bitmask/ &&
    (is["our_inverse_throughput"] - is["inverse_throughput"]) ^ 2 > (0.01 * is["inverse_throughput"]) ^ 2'
# Of the bitmask up to 35 % stand behind branches, of which the driver counts a half at least: 18 % less is its least.
check "of the bitmask, but for branches"             none 'is["variant"] ~ /bitmask/ &&
    (is["inverse_throughput"] > 1.01 * is["our_inverse_throughput"] ||
     is["inverse_throughput"] < 0.82 * is["our_inverse_throughput"])'
# 16 x 16 texels of RG32F: a loop over rows, within which columns are unrolled
check "texels and bytes within loops are counted"    rows '
    is["variant"] == "tiles tiles_step=0" && is["fetches_balanced"] == 256 && is["bytes_balanced"] == 2048'
# z, normals, two radiances
check "texels and bytes outside of loops as well"    rows '
    is["variant"] == "mip layers=2 pack_radiance=1" && is["fetches_balanced"] == 4 && is["bytes_balanced"] == 20'
# 30 taps against 13; each fetches z and radiance
check "taps are those of the preset"                 rows '
    is["variant"] == "gather layers=1" && is["fetches_quality"] - is["fetches_performance"] == 34'
# of the taps 14 and 30: 7 and 15 steps to either side of the slice, each of which fetches z and radiance
check "the bitmask's steps are those of the preset"  rows '
    is["variant"] == "gather layers=1 bitmask_light=1" && is["fetches_quality"] - is["fetches_balanced"] == 32'
for pass in ao gather; do
    check "$pass: the second layer costs nothing in tiles where it cannot matter"  rows '
        is["variant"] == "'$pass' layers=2" && is["cycles_layer_0_balanced"] < 0.9 * is["cycles_balanced"]'
done

echo "1..$tests"
