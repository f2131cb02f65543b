#!/bin/sh
# build/release/ao_from_depth writes plausible ambient visibility; its use of the library takes 30 lines.
# Prints TAP.

cd "$(dirname "$0")/../.." || exit 1
. tests/support/tap.sh

ao_from_depth=build/release/ao_from_depth

# The two comment lines count, too.
delimited() { awk '/^\/\* >> deepgbuffer \*\/$/, /^\/\* << deepgbuffer \*\/$/' examples/ao_from_depth.c; }
is_short() { lines=$(delimited | wc -l); echo "$lines lines"; [ "$lines" -ge 10 ] && [ "$lines" -le 30 ]; }
no_name_outside() {
    ! grep -vxFf "$dir/delimited" examples/ao_from_depth.c | grep -E 'dgb(gl)?_[a-z]' | grep -v dgb_view
}

delimited >"$dir/delimited"
check "the use of the library takes 10 to 30 lines"  is_short
check "all of it stands there, but for the camera"   no_name_outside
check "no argument is refused"                       refuses $ao_from_depth
check "two arguments are refused"                    refuses $ao_from_depth "$dir/a.ppm" "$dir/b.ppm"
check "a picture that cannot be written fails"       refuses $ao_from_depth "$dir/missing/a.ppm"

# >> the picture

value_of() { sed -n "s/.*$1 \([0-9.]*\).*/\1/p" "$dir/statistics"; }
between() { # LOW VALUE HIGH
    echo "$2"
    awk -v low="$1" -v x="$2" -v high="$3" 'BEGIN { exit !(x != "" && low <= x && x <= high) }'
}

# darkest_of FIRST COUNT: of pixels in a row, which goes on in the next row; pixel 960 begins the second row
darkest_of() {
    od -An -v -tu1 -j $((15 + 3 * $1)) -N $((3 * $2)) "$dir/a.ppm" |
        awk '{ for (i = 1; i <= NF; ++i) if (low == "" || $i < low) low = $i } END { print low }'
}
at() { echo $((960 * $2 + $1)); } # the pixel at X Y

# darkest_between LOW FIRST COUNT HIGH
darkest_between() { between "$1" "$(darkest_of "$2" "$3")" "$4"; }

grey_is_grey() {
    tail -n +2 "$dir/a.ppm" | od -An -v -tu1 |
        awk '{ for (i = 1; i <= NF; ++i) { bad += n++ % 3 && $i != last; last = $i } } END { exit bad || !n }'
}

render() { $ao_from_depth "$1" >"$dir/statistics"; }
renders_again() { render "$dir/b.ppm" && cmp "$dir/a.ppm" "$dir/b.ppm"; }

check "it writes a picture"                          render "$dir/a.ppm"
check "the picture is of 960 x 540 pixels"           [ "$(head -n 1 "$dir/a.ppm")" = "P6 960 540 255" ]
check "the picture is complete"                      [ "$(wc -c <"$dir/a.ppm")" -eq $((15 + 960 * 540 * 3)) ]
check "the darkest corner is dark, but not black"    between 0.1 "$(value_of min)" 0.5
check "most of the scene is open"                    between 0.85 "$(value_of mean)" 0.97
check "the picture is grey"                          grey_is_grey
check "the flat floor in front is white"             darkest_between 250 "$(at 0 430)" $((960 * 110)) 255
check "the empty part of the wall is white"          darkest_between 250 "$(at 700 100)" 260 255
check "the front of the beam is white"               darkest_between 250 "$(at 370 30)" 250 255
check "the floor under the crate is in its shadow"   darkest_between 50 "$(at 250 283)" 40 150
check "the wall between two columns is in theirs"    darkest_between 80 "$(at 415 120)" 60 200
check "rendering again writes the same picture"      renders_again
echo "1..$tests"
