# What the shell tests share: the program, a folder of their own, and TAP lines. Sourced in the source root.
ricochet=${RICOCHET:?the program to test}
folder=$(mktemp -d) || exit 1
# A copy of the shell that a signal ends before it is the program runs this trap, too, and may not come to the end of a
# command: the folder is the first shell's, and is removed only where that is certain.
trap '[ "$BASHPID" = "$$" ] && rm -rf "$folder" "$folder-times"' EXIT
number=0 failed=0

# Whether the program was built with sanitizers: it is some times slower then, reserves terabytes of addresses and brings its own allocator.
sanitized() { grep -q '__[at]san_init' "$ricochet"; }

# Skips a test of the Python package where it cannot run: an instrumented library cannot be loaded by a program that is not.
needs_python()
{
    local why
    if sanitized; then why='the library is instrumented, and Python is not'
    else why=$(tools/python -c 'import sys; print(sys.executable)' 2>&1) && export PYTHON=$why && return # looked for once
    fi
    echo "1..0 # SKIP $why"
    exit 77
}

# Sets `python` to one that runs tools/check_certificate.py; skips without.
needs_checker()
{
    local one
    python=
    for one in python3 /usr/bin/python3; do
        if "$one" -c 'import importlib.util, sys; sys.exit(not all(map(importlib.util.find_spec, ["mpmath", "numpy", "yaml"])))' 2>/dev/null; then python=$one && break; fi
    done
    if [ -z "$python" ]; then echo '1..0 # SKIP no mpmath or numpy'; exit 77; fi
}

# The browser that $CHROMIUM names, or what is there; the one without windows takes two thirds of the time.
browser_there()
{
    echo "${CHROMIUM:-$(command -v chromium-headless-shell || command -v chromium || command -v chromium-browser || command -v google-chrome)}" | grep .
}

# Whether everything is to be tried that the suite takes a sample of (`make long`, CONTRIBUTING.md).
long_form() { [ "${RICOCHET_TEST_LONG:-0}" != 0 ]; }
every_of() { if long_form; then echo 1; else echo "$1"; fi; } # FEW: every how many cases one is taken
some_of() { if long_form; then echo "$2"; else echo "$1"; fi; } # SHORT LONG: how many cases are taken, or which

# left_out NAME REASON: one test that is skipped
left_out()
{
    number=$((number + 1))
    echo "ok $number - $1 # SKIP $2"
}

# With RICOCHET_TEST_COST=1: the processor's time of all that has ended up to here, after each test.
cost() { # without a process, which would count, too
    local own of_children
    times >"$folder-times"
    { read -r own && read -r of_children; } <"$folder-times"
    echo "# user and system so far: $of_children"
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
    [ -z "${RICOCHET_TEST_COST:-}" ] || cost
}

# claims FILE: a test for each line `NAME<tab>WHY` that a program has written there; WHY is empty if it holds
claims()
{
    local what why
    while IFS=$'\t' read -r what why; do ok "$what" eval 'echo "$why"; [ -z "$why" ]'; done <"$1"
}

# refusal COMMAND CODE PATTERN ARGUMENTS...: the program ends with the code and a message that fits, and answers nothing
refusal() {
    local command=$1 code=$2 pattern=$3 got=0
    shift 3
    "$ricochet" "$command" "$@" >"$folder/out" 2>"$folder/err" || got=$?
    cat "$folder/err"
    [ "$got" = "$code" ] && grep -q -e "$pattern" "$folder/err" && [ ! -s "$folder/out" ]
}

# plant ATLAS COPY LINES: a copy of an atlas that lines of Python have changed and whose digest is made anew. They have the database as db.
plant() {
    cp "$1" "$2"
    python3 -S - "$2" <<END
import math, random, sqlite3, struct, sys
db = sqlite3.connect(sys.argv[1])
def floats(blob): return list(struct.unpack(f"<{len(blob) // 8}d", blob))
def blob(x): return struct.pack(f"<{len(x)}d", *x)
$3
db.commit()
END
    python3 -S tools/attack/atlas_digest.py "$2" >/dev/null
}

# tables ATLAS: every row of every table bit for bit, but for the cache of traces and the texts about the run
tables() {
    python3 -S - "$1" <<'END'
import sqlite3, sys
atlas = sqlite3.connect(f"file:{sys.argv[1]}?mode=ro", uri=True)
names = [name for (name,) in atlas.execute("SELECT name FROM sqlite_master WHERE type = 'table' ORDER BY name")]
assert {"branch", "point", "junction"} <= set(names), names
for name in names:
    if name in ("trace", "meta") or name.startswith("sqlite_"):
        continue
    print(name)
    # quote() keeps every bit of a number
    row = " || ' ' || ".join(f'quote("{column[1]}")' for column in atlas.execute(f"PRAGMA table_info({name})"))
    print(*(text for (text,) in atlas.execute(f"SELECT {row} FROM {name} ORDER BY 1")), sep="\n")
END
    [ $? = 0 ] || echo "not read: $1 $RANDOM $RANDOM" # two that cannot be read are not the same
}

# same FILE FILE: they are, and there is something in them
same() { [ -s "$1" ] && cmp "$1" "$2"; }

# whole FILE: a picture that ends as its kind does; of an SVG every curve has a point
whole() {
    case $1 in
    *.svg) curves "$1" >/dev/null ;;
    *.pdf) [ "$(head -c 5 "$1")" = '%PDF-' ] && tail -c 16 "$1" | grep -q '%%EOF' ;;
    *.png) [ "$(head -c 4 "$1" | tail -c 3)" = PNG ] && tail -c 8 "$1" | head -c 4 | grep -q IEND ;;
    *) return 1 ;;
    esac
}

# curves SVG: of a well-formed picture the names of what is drawn, with the number of pieces of lines each has
curves() {
    python3 -S - "$1" <<'END'
import sys, xml.etree.ElementTree as xml
space = "{http://www.w3.org/2000/svg}"
pieces = {}
for group in xml.parse(sys.argv[1]).getroot().iter(space + "g"):
    title = group.find(space + "title")
    if title is not None and not title.text.startswith("gnuplot_plot"):
        pieces[title.text] = pieces.get(title.text, 0) + sum(path.get("d", "").count("M") for path in group.iter(space + "path"))
assert pieces and all(pieces.values()), pieces
print(*(f"{name}: {n}" for name, n in pieces.items()), sep="\n")
END
}

bytes() { stat -c %s "$1" 2>/dev/null || echo 0; } # FILE: its bytes

# listens PID: waits until the copy of the shell has become the program, and the program asks for signals: SIGINT and
# SIGTERM are bits of what it catches. A signal before that ends the copy of the shell, which tidies up the folder.
listens() {
    local caught
    while kill -0 "$1" 2>/dev/null; do
        if grep -q '^ricochet' "/proc/$1/comm" 2>/dev/null; then
            caught=$(sed -n 's/^SigCgt:[[:space:]]*//p' "/proc/$1/status" 2>/dev/null)
            [ $((0x0$caught & 0x4002)) = $((0x4002)) ] && break
        fi
        sleep 0.005
    done
}

# break_off SIGNAL PID ATLAS BYTES: the program gets the signal once the atlas has so many bytes, however fast the machine
# is; whether the signal ended it.
break_off() {
    listens "$2"
    while kill -0 "$2" 2>/dev/null && [ "$(bytes "$3")" -lt "$4" ]; do sleep 0.005; done
    kill -"$1" "$2" 2>/dev/null
    { wait "$2"; } 2>/dev/null
    [ $? -gt 128 ]
}

# The plan, and the exit code of the program.
finish() {
    echo "1..$number"
    [ "$failed" = 0 ]
}
