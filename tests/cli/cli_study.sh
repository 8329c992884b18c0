#!/usr/bin/env bash
# docs/study.md says what the reader takes: its studies run, its tables have the keys of the reader and no others, and which law takes which key.
set -u
. tests/support/tap.sh

python3 -S - "$folder" <<'P' || exit 1
import re, sys
page = open("docs/study.md").read()
for language, name, text in re.findall(r"```(yaml|text) (\S+)\n(.*?)```", page, re.S):
    open(f"{sys.argv[1]}/{name if language == 'text' else name + '.yaml'}", "w").write(text)
P
study() { # NAME BRANCHES: it runs, and has at least so many branches
    "$ricochet" check "$folder/$1.yaml" && "$ricochet" run "$folder/$1.yaml" >"$folder/said" 2>&1 || { cat "$folder/said"; return 1; }
    ! grep 'no orbit that meets' "$folder/said" && "$ricochet" verify "$folder/$1.ricochet" || return 1
    [ "$("$ricochet" branches "$folder/$1.ricochet" --csv | wc -l)" -gt "$2" ]
}
ok 'the rotor of docs/study.md' study rotor 20
ok 'the bar from files' study bar 3
ok 'two masses and a cubic spring' study cubic 3
named() { "$ricochet" junctions "$folder/cubic.ricochet" --csv | grep ',P,'; }
ok 'the name is found' named

# Names of units stand beside physical numbers, and nothing else changes.
sed '/^units:/d' "$folder/rotor.yaml" >"$folder/nameless.yaml"
named() { # PATTERN ARGUMENT...: output or stderr has it
    local pattern=$1
    shift
    "$ricochet" "$@" >"$folder/said" 2>&1 && grep -q -e "$pattern" "$folder/said" || { head -20 "$folder/said"; return 1; }
}
same_numbers() {
    "$ricochet" run "$folder/nameless.yaml" >/dev/null 2>&1
    cmp <(tables "$folder/nameless.ricochet") <(tables "$folder/rotor.ricochet")
}
ok 'units change no number' same_numbers
ok 'an atlas with units goes on without them' "$ricochet" run "$folder/nameless.yaml" -o "$folder/rotor.ricochet" --quiet
ok 'and with them' "$ricochet" run "$folder/rotor.yaml" --quiet
ok 'check says which mass belongs to them' named 'masses in N s^2/mm, which is t, stiffness in N/mm, energies in N mm' check "$folder/rotor.yaml"
ok 'check shows physical energies' named 'first touch at energy, N mm' check "$folder/rotor.yaml" --physical
ok 'lists name units' named 'lengths in mm, speeds in mm/s, energies in N mm' branches "$folder/rotor.ricochet" --physical
for what in points orbit; do ok "$what, too" named 'energies in N mm' $what "$folder/rotor.ricochet" --branch 3 $([ $what = orbit ] && echo --point 1) --physical; done
ok 'export has them' bash -c '"$0" export "$1/rotor.ricochet" -o "$1/out.csv" && grep -q ",mm,s,N," "$1/out.csv"' "$ricochet" "$folder"
ok 'so does the page' bash -c '"$0" view "$1/rotor.ricochet" --save "$1/page.html" >/dev/null 2>&1; grep -q "\"force\": *\"N\"" "$1/page.html"' "$ricochet" "$folder"
if command -v gnuplot >/dev/null; then
    drawn() { "$ricochet" plot "$2" "$folder/rotor.ricochet" --physical "${@:3}" -o "$folder/out.svg" && grep -q "$1" "$folder/out.svg"; }
    ok 'and the axes of pictures' drawn '(N mm)' fep
    ok 'of displacements' drawn 'displacement (mm)' orbit --branch 3 --point 1
    ok 'of speeds' drawn '(mm/s)' curves --branch 3 --x energy --y v1
fi
nonsense() { # PATTERN UNITS
    sed "s/^units:.*/units: $2/" "$folder/rotor.yaml" >"$folder/try.yaml"
    "$ricochet" check "$folder/try.yaml" >/dev/null 2>"$folder/said"
    [ $? = 2 ] && grep -e "$1" "$folder/said" || { cat "$folder/said"; return 1; }
}
ok 'a force is no length' nonsense 'try.yaml:2: units.length: N is no unit of length, but of force' '{length: N, force: N}'
ok 'a mass is no force' nonsense 'units.force: kg is no unit of force, but of mass; write one, such as N' '{length: mm, force: kg}'
ok 'a number is no name' nonsense 'is no name of a unit' '{length: 5, force: N}'
ok 'one is not enough' nonsense 'units.force: missing' '{length: mm}'
ok 'time is in seconds' nonsense 'frequencies are in rad/s' '{length: mm, force: N, time: ms}'

from_input() { diff <("$ricochet" check "$folder/rotor.yaml" --json) <("$ricochet" check - --json <"$folder/rotor.yaml"); }
ok 'a study on standard input' from_input
wrong_input() { # PATTERN TEXT
    printf "$2" | "$ricochet" check - >"$folder/out" 2>"$folder/said"
    [ $? = 2 ] && [ ! -s "$folder/out" ] && grep -e "$1" "$folder/said"
}
ok 'its place in messages' wrong_input '^ricochet: standard input:2: title: given twice' 'title: a\ntitle: b\n'
ok 'nothing there' wrong_input 'standard input is empty' ''
ok 'no text' wrong_input 'a zero byte' 'title: \0'

tables() {
    python3 -S - "$ricochet" "$folder" <<'P'
import re, subprocess, sys
program, folder = sys.argv[1:]
page = open("docs/study.md").read()

def says(text):
    open(f"{folder}/try.yaml", "w").write(text)
    done = subprocess.run([program, "check", f"{folder}/try.yaml"], capture_output=True, text=True)
    return done.returncode, done.stderr

def table(section):
    part = re.search(rf"^## {section}\n(.*?)(?=^## |\Z)", page, re.S | re.M).group(1)
    rows = [[cell.strip() for cell in line.strip("|\n").split("|")] for line in part.splitlines() if line.startswith("| `")]
    return {row[0].strip("`"): row[1:] for row in rows}

# every section with a key that is none: the message lists those that there are
model = "model:\n  mass: [[1]]\n  stiffness: [[1]]\n"
contact = "  contacts: [{normal: [1], clearance: 1}]\n"
region = "regions: [{energy: [1, 2], frequency: [1, 2]%s}]\n"
name = "names: [{name: a, kind: start, energy: 1, frequency: 1%s}]\n"
tries = {"study": "zzzz: 1\n" + model + contact, "model": model + "  zzzz: 1\n" + contact,
         "contacts": model + contact.replace("}", ", zzzz: 1}"), "names": name % ", zzzz: 1" + model + contact}
for section, text in tries.items():
    code, said = says(text)
    keys = re.search(r"the keys here are (.*)", said).group(1).split(", ")
    assert code == 2 and sorted(keys) == sorted(table(section)), (section, keys, list(table(section)))
code, said = says(model + contact + "explore: {zzzz: 1}\n")
keys = ["explore." + key for key in re.search(r"the keys here are (.*)", said).group(1).split(", ")]
assert sorted(keys + ["tolerance"]) == sorted(table("explore")), (keys, list(table("explore")))

# which law takes which key
values = {"normal": "[1]", "law": None, "clearance": "1", "sides": "both", "stiffness": "2", "exponent": "3", "length": "1", "reference": "1", "name": "a"}
rows = table("contacts")
tried = 0
for column, law in enumerate(["rigid", "bilinear", "power"]):
    takes = {key: row[column] for key, row in rows.items()}
    least = {key: values[key] for key in takes if takes[key] in ("required", "either") and key != "law"}
    least["law"] = law
    def whole(keys):
        return says(model + "  contacts: [{" + ", ".join(f"{key}: {value}" for key, value in keys.items()) + "}]\n")
    assert whole(least)[0] == 0, (law, whole(least))
    for key in takes:
        if key == "law":
            continue
        code, said = whole({**least, key: values[key]})
        assert (code == 0) == (takes[key] != "no" and takes[key] != "or"), (law, key, said)
        if takes[key] in ("required", "either"):
            code, said = whole({k: v for k, v in least.items() if k != key})
            assert code == 2 and "missing" in said, (law, key, said)
        tried += 1
    if law == "power":
        code, said = whole({**{k: v for k, v in least.items() if k != "stiffness"}, "length": 1, "reference": 1})
        assert code == 0, said
print(tried, "keys of laws")

# what is required is, and the defaults of contacts are those of the table
for key in ("mass", "stiffness", "contacts"):
    text = "\n".join(line for line in (model + contact).splitlines() if not line.startswith(f"  {key}:")) + "\n"
    assert says(text)[0] == 2 and table("model")[key][1] == "required"
same = [subprocess.run([program, "check", f"{folder}/try.yaml", "--json"], capture_output=True).stdout
        for text in (contact, contact.replace("}", ", sides: both, law: rigid}")) if says(model + text)[0] == 0]
assert len(same) == 2 and same[0] == same[1]
P
}
ok 'its tables are those of the reader' tables

limits() { # the numbers in the text
    python3 -S - "$ricochet" "$folder" <<'P'
import subprocess, sys
program, folder = sys.argv[1:]
def code(text):
    open(f"{folder}/try.yaml", "w").write(text)
    return subprocess.run([program, "check", f"{folder}/try.yaml"], capture_output=True).returncode
model = "model: {mass: [[1]], stiffness: [[1]], contacts: [%s]}\n"
contact = "{normal: [1], clearance: 1}"
region = "{energy: [1, 2], frequency: [1, 2]}"
assert code(model % ", ".join([contact] * 1000)) == 0 and code(model % ", ".join([contact] * 1001)) == 2
assert code(model % contact + "regions: [" + ", ".join([region] * 64) + "]\n") == 0
assert code(model % contact + "regions: [" + ", ".join([region] * 65) + "]\n") == 2
assert code(f"title: {'a' * 1000}\n" + model % contact) == 0 and code(f"title: {'a' * 1001}\n" + model % contact) == 2
for low, high, taken in (0, 1, 0), (-0.1, 1, 2), (1, 1.1, 2):
    assert code(model.replace("}", f", restitution: {high if taken and low == 1 else low}}}", 1) % contact) == taken
for exponent, taken in (3, 0), (99, 0), (1, 2), (4, 2), (101, 2):
    assert code(model % f"{{normal: [1], law: power, exponent: {exponent}, stiffness: 1}}") == taken
P
}
ok 'its limits are those of the reader' limits

together() { # of many contacts, all that close together are told, and taken as they are told
    python3 -S - "$ricochet" "$folder" <<'P'
import re, subprocess, sys
program, folder = sys.argv[1:]
n = 50
rows = lambda entry: "[" + ", ".join(str([entry(i, j) for j in range(n)]) for i in range(n)) + "]"
contacts = "".join(f"    - {{normal: {[int(i == j) for j in range(n)]}, clearance: 1}}\n" for i in range(n))
model = (f"model:\n  mass: {rows(lambda i, j: int(i == j))}\n"
         f"  stiffness: {rows(lambda i, j: 3 if i == j else -(abs(i - j) == 1))}\n")
def check(key, *options):
    open(f"{folder}/try.yaml", "w").write(f"{model}{key}  modes: all\n  contacts:\n{contacts}")
    done = subprocess.run([program, "check", f"{folder}/try.yaml", *options], capture_output=True, text=True)
    return done.returncode, done.stdout + done.stderr
code, said = check("")
told = re.findall(r"motions of modes ((?:\d+, )+)\.\.\. \((\d+) in all\) .*`(together: \S.*\]\])` under", said)
assert code == 0 and len(told) == 2 and [count for _, count, _ in told] == ["25", "25"], said
for modes, _, key in told:
    code, said = check(f"  {key}\n", "--json")
    assert code == 0 and said.count('"parted": true') == 25, said
P
}
ok 'all contacts that close together are told, however many' together

template() { # what `new` writes is true: it runs, and every value in it is the default
    (cd "$folder" && "$ricochet" new fresh && "$ricochet" check fresh/study.yaml && "$ricochet" run fresh/study.yaml) || return 1
    sed '/^explore:/,/^tolerance/d' "$folder/fresh/study.yaml" >"$folder/bare.yaml"
    grep -q '^explore' "$folder/bare.yaml" && return 1
    "$ricochet" run "$folder/bare.yaml" || return 1
    tables_of "$folder/fresh/study.ricochet" >"$folder/a" && tables_of "$folder/bare.ricochet" >"$folder/b" && same "$folder/a" "$folder/b"
}
tables_of() { "$ricochet" branches "$1" --csv && "$ricochet" junctions "$1" --csv; }
ok 'the template has the defaults' template
finish
