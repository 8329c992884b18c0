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
# prove_some ATLAS OUT BRANCH...: the rows of these branches, of all where none is named
prove_some() {
    local branch
    if [ $# = 2 ]; then prove "$1" "$2"; return; fi
    for branch in "${@:3}"; do "$ricochet" prove "$1" --branch "$branch" --json 2>/dev/null; done | python3 -S -c '
import json, sys
decoder, text, rows = json.JSONDecoder(), sys.stdin.read().strip(), []
while text:
    part, end = decoder.raw_decode(text)
    rows, text = rows + part, text[end:].strip()
print(json.dumps(rows))' >"$2"
}
# certificates ATLAS FILE OPTION BRANCH...: of these branches in one file, of all where none is named; OPTION is --curves or nothing
certificates() {
    local one first=1
    if [ $# = 3 ]; then "$ricochet" prove "$1" $3 -o "$2"; return; fi
    for one in "${@:4}"; do
        rm -f "$2-one"
        "$ricochet" prove "$1" $3 --branch "$one" -o "$2-one"
        tail -n +$first "$2-one" >>"$2"
        first=2
    done
}
# rows FILE CODE: Python over `rows` of FILE, without those that are left out by name
rows() { python3 - "$1" <<END
import json, math, sys
rows = [row for row in json.load(open(sys.argv[1])) if row["verdict"] != "left out"]
proved = [row for row in rows if row["verdict"] == "proved"]
$2
END
}
