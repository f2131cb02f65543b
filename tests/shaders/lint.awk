# Follows what may be NaN through the shaders: prints FILE:LINE: MESSAGE for each line that breaks a rule, and fails.
#
# A wild read is one of what an engine or a frame before has left and that holds light, a share or a count: dgb_radiance_at,
# dgb_albedo_at, or a fetch from dgb_last_irradiance, _irradiance1, _reflection, _frames or _bent.
#   1. A wild read is the argument of dgb_storable or dgb_storable_unit, or all of what is assigned to a variable, which is
#      then wild to the end of its function.
#   2. A wild variable is only read inside a call of dgb_storable or dgb_storable_unit, before ` < 1.0 ?`, in the select
#      `x > 0.0 ? (x < 1.0 ? x : 1.0) : 0.0`, or to be assigned to a wild one.
#   3. min, max and clamp are not applied to any read of an engine's texture: what they make of NaN differs between devices.
#   4. Nor are isnan and isinf called, which compilers may take to be false.
# Where the engine's textures are declared (18_source.glsl) there are definitions, not reads.

function report(message) {
    printf "%s:%d: %s\n", FILENAME, FNR, message
    bad = 1
}

# Where the bracket closes that is open at `i`.
function closing(line, i,    depth, c) {
    depth = 0
    for (; i < length(line); i++) {
        c = substr(line, i, 1)
        depth += (c == "(") - (c == ")")
        if (depth == 0) break
    }
    return i
}

function without_calls(line, name) {
    while (match(line, name "\\("))
        line = substr(line, 1, RSTART - 1) " " substr(line, closing(line, RSTART + RLENGTH - 1) + 1)
    return line
}

# Whether a call is all of what is assigned, from where the variable is named on.
function is_all_assigned(line, at) {
    line = substr(line, at)
    line = substr(line, closing(line, index(line, "(")) + 1)
    return line ~ /^(\.[a-z]+)?;/
}

function is_word_in(word, line) { return line ~ "(^|[^A-Za-z0-9_.])" word "($|[^A-Za-z0-9_])" }

function check_filters(line) {
    while (match(line, /(^|[^A-Za-z0-9_])(min|max|clamp)\(/)) {
        line = substr(line, RSTART + RLENGTH - 1)
        if (substr(line, 1, closing(line, 1)) ~ engine) report("min, max or clamp of what may be NaN")
        line = substr(line, 2)
    }
}

function check_variables(line,    name, rest) {
    rest = without_calls(line, "dgb_storable(_unit)?")
    for (name in is_wild) {
        select = name "\\.[a-z] > 0\\.0 \\? \\(" name "\\.[a-z] < 1\\.0 \\? " name "\\.[a-z] : 1\\.0\\) : 0\\.0"
        gsub(select, "", rest)
        gsub(name "\\.[a-z] < 1\\.0 \\?", "", rest)
    }
    for (name in is_wild)
        if (rest ~ "^ *(if \\([a-z]+\\) )?([a-z0-9]+ )?" name " += ") return
    for (name in is_wild)
        if (is_word_in(name, rest)) report(name " may be NaN here")
}

BEGIN {
    engine = "dgb_(depth|normal|radiance|albedo|velocity|back|roughness)_at\\(|dgb_engine_|texelFetch\\(dgb_last_"
    wild   = "dgb_(radiance|albedo)_at\\(|texelFetch\\(dgb_last_(irradiance1?|reflection|frames|bent),"
}

FNR == 1     { split("", is_wild) }
/^}/         { split("", is_wild) }
FILENAME !~ /18_source/ && !/^uniform/ {
    line = $0
    sub(/\/\/.*/, "", line)
    if (line ~ /(^|[^A-Za-z0-9_])is(nan|inf)\(/) report("isnan and isinf may be taken to be false")
    rest = without_calls(line, "dgb_storable(_unit)?")
    check_filters(rest)
    if (rest !~ wild) {
        check_variables(line)
    } else if (match(rest, "[A-Za-z0-9_]+ += (" wild ")") && is_all_assigned(rest, RSTART)) {
        name = substr(rest, RSTART)
        sub(/ .*/, "", name)
        is_wild[name] = 1
    } else {
        report("a read of what may be NaN that is neither scrubbed nor assigned")
    }
}

END { exit bad }
