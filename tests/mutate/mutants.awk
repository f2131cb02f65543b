# Prints the mutants of C functions, one small mistake each: awk -v from=REGEX -v to=REGEX -f mutants.awk FILE
#
# Of the lines between the first that matches `from` and the next that matches `to`, what is inside function bodies, but not
# declarations without a value and tables of numbers. Fields, by tabs: line, column, what is there, what stands there instead.
#   operators      + - * / & | ^ << >> && || for their counterparts, alone and with =; - ! ~ before a value left out
#   comparisons    the border moved, the outcome turned round
#   constants      one more; integers one less; decimal fractions a hundredth more
#   names          sine for cosine, floor for ceil, fabs left out, true for false
# Operators stand between blanks, signs do not: the sources are formatted.

BEGIN {
    split("+ - * / & | ^ << >> && || += -= *= /= >>= <<= == != < <= > >=", old, " ")
    split("- + / * | & & >> << || && -= += /= *= <<= >>= != == <= < >= >", new, " ")
    for (i in old) swapped[old[i]] = new[i]
    split("< >= <= > > <= >= <", pairs, " ")
    for (i = 1; i < 8; i += 2) negated[pairs[i]] = pairs[i + 1]
    split("sin cos sinf cosf cos sin cosf sinf floorf ceilf true false false true", pairs, " ")
    for (i = 1; i < 14; i += 2) other_name[pairs[i]] = pairs[i + 1]
    other_name["fabsf"] = other_name["fabs"] = ""
}

function mutant(text, instead) { if (depth > 0) printf "%d\t%d\t%s\t%s\n", NR, at, text, instead }

function mutate_number(number) {
    if (substr($0, at + length(number)) ~ /^\] = \{/) return # an array's size
    mutant(number, "(" number " + 1)")
    if (number ~ /^0x|^[0-9]+u?$/) mutant(number, "(" number " - 1)")
    else if (number !~ /e|^0\.0f?$/) mutant(number, "(" number " * 1.01" (number ~ /f$/ ? "f)" : ")"))
}

function mutate_operator(operator) {
    if (operator in swapped) mutant(operator, swapped[operator])
    if (operator in negated) mutant(operator, negated[operator])
}

# The token at `at`, mutated; returns its length.
function token(rest, before) {
    if (match(rest, /^[A-Za-z_][A-Za-z_0-9]*/)) {
        text = substr(rest, 1, RLENGTH)
        if (text in other_name) mutant(text, other_name[text])
        return length(text)
    }
    if (match(rest, /^(0x[0-9a-f]+u?|[0-9]+(\.[0-9]*)?(e-?[0-9]+)?[fu]?)/)) {
        text = substr(rest, 1, RLENGTH)
        mutate_number(text)
        return length(text)
    }
    if (before == " " && match(rest, /^[-+*\/&|^<>=!]+ /)) {
        text = substr(rest, 1, RLENGTH - 1)
        mutate_operator(text)
        return length(text)
    }
    if (rest ~ /^[-!~][A-Za-z_0-9(]/ && before ~ /[ (!]/) mutant(substr(rest, 1, 1), "")
    if (rest ~ /^[{]/) ++depth
    if (rest ~ /^[}]/) --depth
    return 1
}

!inside && $0 ~ from { inside = 1 }
inside && $0 ~ to    { exit }
!inside || /^#/ { next }
/^    [0-9]/ { depth -= /};$/; next }
/^ *(static )?(const )?(float|double|int|bool|uint32_t) [^=(]*;$/ { next }
{
    comment = comment || /^ *\/\*/
    if (comment) { if (/\*\//) comment = 0; next }
    end = index($0, "/*") ? index($0, "/*") : length($0) + 1
    for (at = 1; at < end; at += token(substr($0, at), substr($0, at - 1, 1))) continue
}
