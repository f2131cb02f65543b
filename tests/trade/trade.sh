#!/bin/sh
# build/release/trade in its quick form: what it writes is whole and finite, it goes on where it stopped, and what everybody
# should find in it is there. Prints TAP.

cd "$(dirname "$0")/../.." || exit 1
. tests/support/tap.sh
trade=$PWD/build/release/trade

budget() { "$trade" --check-budget; }
check "the table of budgets in the header is that of budget.csv" budget
cd "$dir" || exit 1

sweep() { "$trade" --quick >table && [ -s build/trade/trade.csv ]; }
check "the quick sweep" sweep

finite() { # no cell is empty but the parameter of a preset, and every measure is a number
    awk -F, 'NR == 1 { n = NF; next }
             { ++rows; if (NF != n) exit 1; for (i = 10; i <= NF; ++i) if ($i !~ /^-?[0-9.]+(e[-+][0-9]+)?$/) exit 1 }
             END { exit rows < 24 }' build/trade/trade.csv
}
check "24 rows and more, all finite" finite

front() { awk -F, 'NR > 1 && $NF == 1 { seen[$4] = 1 } END { exit !(seen["ao"] && seen["irradiance"] && seen["reflection"]) }' build/trade/trade.csv; }
check "every effect has a front" front

# measure EFFECT VARIED COLUMN [FRAMES CAMERA]: of the quick sweep's only scene
measure() {
    awk -F, -v effect="$1" -v varied="$2" -v name="$3" -v frames="${4:-1}" -v camera="${5:-moving}" '
        NR == 1 { for (i = 1; i <= NF; ++i) column[$i] = i; next }
        $(column["effect"]) == effect && $(column["varied"]) == varied && $(column["frames"]) == frames &&
            $(column["camera"]) == camera { print $(column[name]) }' build/trade/trade.csv
}
less() { awk -v a="$1" -v b="$2" 'BEGIN { exit !(a != "" && b != "" && a + 0 < b + 0) }'; }
second_layer() { less "$(measure ao '' rmse)" "$(measure ao layers=1 rmse)"; }
check "occlusion is nearer to the truth with two layers than with one" second_layer
second_mirror() { less "$(measure reflection '' wrong)" "$(measure reflection layers=1 wrong)"; }
check "fewer mirrored hits are wrong with two layers" second_mirror
more_taps() { less "$(measure ao taps=60 rmse)" "$(measure ao taps=4 rmse)"; }
check "more taps, less error" more_taps
average() { less "$(measure ao '' rmse 4 still)" "$(measure ao weight=0 rmse 4 still)"; }
check "four frames, less error than one" average
steadier() { less "$(measure ao '' change 4 moving)" "$(measure ao weight=0 change 4 moving)"; }
check "history steadies what the camera moves past" steadier
still() { less "$(measure ao weight=0 change 4 still)" 1e-5; } # rounding of where a point was in the frame before
check "nothing changes before a still camera without history" still
same() { [ -n "$1" ] && [ "$1" = "$2" ]; }
near() { awk -v a="$1" -v b="$2" -v share="$3" 'BEGIN { exit !(a != "" && b > 0 && (a - b) ^ 2 <= (share * b) ^ 2) }'; }
alone() { near "$(measure ao weight=0 rmse 4 moving)" "$(measure ao '' rmse)" 0.001; } # normals go through a copy in one of the two
check "without history the last frame is as a first one" alone
oracles() { less "$(measure irradiance oracle=peel rmse 16)" "$(measure irradiance oracle=previous rmse 16)"; }
check "exact layers, less error under way" oracles
delayed() { same "$(measure irradiance oracle=delay rmse 16)" "$(measure irradiance oracle=peel rmse 16)"; }
check "a frame late, but exact" delayed
horizons() { less "$(measure ao 'layers=1 baseline=gtao' rmse_cosine)" "$(measure ao 'layers=1 baseline=sao' rmse_cosine)"; }
check "horizons are nearer to cosine-weighted visibility than obscurance is" horizons
bytes() { less "$(measure ao layers=1 bytes)" "$(measure ao '' bytes)"; }
check "one layer takes fewer bytes" bytes

resume() { # of a run that was cut off before the last digit
    rows=$(cat build/trade/rows.csv) && printf %s "${rows%?}" >build/trade/rows.csv
    "$trade" --quick >table && grep -q ' 1 to measure' table &&
        [ "$(tail -n +2 build/trade/trade.csv | wc -l)" -eq "$(echo "$rows" | wc -l)" ] &&
        [ "$(cut -d, -f1-9 build/trade/rows.csv)" = "$(echo "$rows" | cut -d, -f1-9)" ]
}
check "what is there is not measured again" resume

views() { # each is measured, though the file is the same
    "$trade" --quick --size 48x32 @-10,6,0,0,5,0,60 @10,6,0,0,5,0,60 >table && [ "$(grep -c ' 0 to measure' table)" -eq 0 ] &&
        [ "$(cut -d, -f1,2 build/trade/trade.csv | sort -u | tr '\n' ';')" = \
            'atrium 2,atrium@10 6 0 0 5 0 60;atrium,atrium@-10 6 0 0 5 0 60;scene,view;' ]
}
check "two views of a scene are two" views


questions() {
    "$trade" --questions --quick >answers &&
        awk -F, 'NR > 1 { seen[$2] = 1 } END { exit !(seen["layers"] && seen["ladder"] && seen["pattern"] && seen["turns"]) }' \
            build/trade/questions.csv
}
check "the questions are answered" questions

estimators() { # of light, who errs least for as much as 2.5 times the preset's cost
    "$trade" --estimators --quick gallery >league &&
        awk '/^irradiance/ { light = 1 } light && /^    (paper|bitmask)/ { ++n; least[$1 $2] = $NF } 
             END { exit !(n == 4 && least["bitmask2"] == "(1)") }' league
}
check "the bitmask errs least in the gallery's light" estimators

refused() { ! "$trade" "$@" 2>err && [ "$(wc -l <err)" -eq 1 ]; }
check "an unknown option is refused"  refused --fast
check "a size that is none is refused" refused --size 10x10
check "a scene that is not there is refused" refused --quick nowhere.glb

echo "1..$tests"
