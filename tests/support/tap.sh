# For the shell tests: sets $dir to a directory that goes at the end, and gives them `check` and `refuses`. Sourced from the
# top of the project.

dir=$(mktemp -d) || exit 1
trap 'rm -rf "$dir"' EXIT
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

# refuses COMMAND...: fails with exit status 2 and one line on the standard error output
refuses() {
    "$@" >"$dir/out" 2>"$dir/err"
    status=$?
    echo "exit status $status"
    cat "$dir/out" "$dir/err"
    [ $status -eq 2 ] && [ ! -s "$dir/out" ] && [ "$(wc -l <"$dir/err")" -eq 1 ]
}
