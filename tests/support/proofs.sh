# What the tests of proofs share, over tap.sh.

# needs_flint ATLAS: skips all where the program was built without FLINT
needs_flint() {
    if "$ricochet" prove "$1" --branch 1 --point 0 2>&1 | grep -q 'left out of this program'; then
        echo '1..0 # SKIP the program was built without FLINT'
        exit 77
    fi
}
# prove ATLAS OUT ARGUMENT...: the rows
prove() { "$ricochet" prove "$1" --json "${@:3}" >"$2" 2>/dev/null; [ -s "$2" ]; }
# rows FILE CODE: Python over `rows` of FILE, without those that are left out by name
rows() { python3 - "$1" <<END
import json, math, sys
rows = [row for row in json.load(open(sys.argv[1])) if row["verdict"] != "left out"]
proved = [row for row in rows if row["verdict"] == "proved"]
$2
END
}
