# What the shell tests share: the program, a folder of their own, and TAP lines. Sourced in the source root.
ricochet=${RICOCHET:?the program to test}
folder=$(mktemp -d) || exit 1
trap 'rm -rf "$folder"' EXIT
number=0 failed=0

# Whether the program was built with sanitizers: it is some times slower then, reserves terabytes of addresses and brings its own allocator.
sanitized() { grep -q '__[at]san_init' "$ricochet"; }

# left_out NAME REASON: one test that is skipped
left_out()
{
    number=$((number + 1))
    echo "ok $number - $1 # SKIP $2"
}

# ok NAME COMMAND...: one test; what the command prints is shown if it fails
ok() {
    local name=$1
    shift
    number=$((number + 1))
    if "$@" >"$folder/log" 2>&1; then
        echo "ok $number - $name"
    else
        echo "not ok $number - $name"
        tail -n 12 "$folder/log" | sed 's/^/# /'
        failed=$((failed + 1))
    fi
}

# The plan, and the exit code of the program.
finish() {
    echo "1..$number"
    [ "$failed" = 0 ]
}
