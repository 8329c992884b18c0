#!/usr/bin/env python3
"""Keeps docs/map.md true: rooms.py prints TAP lines and ends with exit status 1 if

- a source lies in no room of the map, the map names a file that is not there, or a way to something names a function that is
  not in the file it names, or the picture has other rooms, or in another order, than the table;
- a file includes a header of another room that is not its room.h, or a room above its own;
- rooms include each other in a circle, or files of one room do, by their headers;
- a function that leaves its file does not carry the first word of the file's name;
- a file asks which law a contact has that is neither of the ground (model, study, flow), nor of the second way (check, hunt);
- a number such as 1e-9 stands in a formula: it has a name, a reason, and its place, src/base/tolerances.h or the top of a file;
- a function has more than 60 lines, half of them more than 11 or one in ten 30, or one takes more than 6 parameters that is not
  named in tools/rooms.parameters, with a reason.
"""
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
SOURCES = ROOT / "src"
# Templates that are included to make code, not to declare it.
TEMPLATES = {"flow/taylor.h", "flow/taylor_plain.h"}
# Who may ask for a law: the rest goes through the tables of flow/flight_law.h and orbit/periodic_form.h. The flight of a
# shooting problem asks so that rigid flights cost nothing more.
LAWS = {"model", "study", "flow", "check", "hunt", "orbit/shooting"}
# What every file uses keeps its short name.
SHORT = {"ric_fail", "ric_no_memory", "ric_trust", "ric_malloc", "ric_calloc", "ric_realloc", "ric_strdup", "ric_lapack", "ric_file_read"}


def rooms_of_map():
    """Room -> files, in the order of the page."""
    rows = re.findall(r"^\| `(\w+)` \| (.*) \|$", (ROOT / "docs/map.md").read_text(), re.M)
    return {room: re.findall(r"`(\w+)`", files) for room, files in rows}


def includes(path):
    return re.findall(r'^#include "([\w/]+\.h)"', path.read_text(), re.M)


def circles(edges):
    """One circle of a graph, as a list of its nodes, or []."""
    done, way = set(), []

    def visit(node):
        if node in way:
            return way[way.index(node):] + [node]
        if node in done:
            return []
        way.append(node)
        found = next(filter(None, map(visit, sorted(edges.get(node, ())))), [])
        way.pop()
        done.add(node)
        return found

    return next(filter(None, map(visit, sorted(edges))), [])


def check_files(rooms):
    there = {f"{path.parent.name}/{path.stem}" for path in SOURCES.glob("*/*.[ch]") if path.name != "room.h"}
    mapped = {f"{room}/{file}" for room, files in rooms.items() for file in files}
    flat = [path.name for path in SOURCES.glob("*.[ch]")]
    return [f"{name} is in no room" for name in flat] + [f"{name} is not in docs/map.md" for name in sorted(there - mapped)] + [
        f"{name} of docs/map.md does not exist" for name in sorted(mapped - there)]


def check_ways():
    """The ways: each name is defined in the nearest file that is named behind it or, for want of one, before it."""
    page, wrong = (ROOT / "docs/map.md").read_text(), []
    for row in re.findall(r"^\| .* \| (.*) \|$", page.partition("## Where is")[2].partition("## Rooms")[0], re.M):
        words = [w for w in re.findall(r"`([\w/.]+)`", row) if w.startswith(("ric_", "cli_", "cmd_")) or "/" in w]
        files = {i: ROOT / w if w.startswith(("cli/", "docs/")) else SOURCES / w for i, w in enumerate(words) if "/" in w}
        wrong += [f"there is no {words[i]}" for i, path in files.items() if not path.exists()]
        for i, word in enumerate(words):
            behind, before = [k for k in files if k > i], [k for k in files if k < i]
            where = [files[k] for k in (behind[:1] + before[-1:])]
            if "/" not in word and not any(re.search(rf"\b{word}( = {{|\()", path.read_text()) for path in where if path.exists()):
                wrong.append(f"{word} is not in {' or '.join(path.name for path in where)}")
    picture = re.findall(r"^ (\w+)  ", page.partition("```text")[2].partition("```")[0], re.M)
    if picture[::-1] != list(rooms_of_map()):
        wrong.append(f"the picture shows {' '.join(picture)}")
    return wrong


def check_directions(rooms):
    order, wrong = list(rooms), []
    for path in sorted(SOURCES.glob("*/*.[ch]")):
        here = path.parent.name
        for name in includes(path):
            if "/" not in name or name in TEMPLATES:
                continue
            room, header = name.split("/")
            if header != "room.h" or room == here:
                wrong.append(f"{here}/{path.name} includes {name}: other rooms are included by their room.h, the own one by file")
            elif order.index(room) >= order.index(here):
                wrong.append(f"{here}/{path.name} includes {name}, which is above it")
    return wrong


def check_circles():
    edges = {}
    for path in SOURCES.glob("*/*.h"):
        edges[f"{path.parent.name}/{path.name}"] = {
            name if "/" in name else f"{path.parent.name}/{name}" for name in includes(path)}
    found = circles(edges)
    return [" includes ".join(found)] if found else []


def functions(path):
    """Names of the functions that leave a file."""
    return re.findall(r"^(?!static)[a-z][\w \t]*?[ *](ric_\w+)\(", path.read_text(), re.M)


def check_prefixes():
    public = set(re.findall(r"\b(ric_\w+)\(", (ROOT / "include/ricochet.h").read_text()))
    wrong = []
    for path in sorted(SOURCES.glob("*/*.c")):
        word = path.stem.split("_")[0].removesuffix("s")
        for name in functions(path):
            if name not in public | SHORT and not name.startswith(f"ric_{word}"):
                wrong.append(f"{path.parent.name}/{path.name} holds {name}")
    return wrong


def check_laws():
    wrong = []
    for path in sorted(SOURCES.glob("*/*.[ch]")):
        if path.parent.name in LAWS or f"{path.parent.name}/{path.stem}" in LAWS:
            continue
        for number, line in enumerate(path.read_text().splitlines(), 1):
            if re.search(r"RIC_LAW_\w+", line) and not re.search(r"^\s*\[RIC_LAW_\w+\] =", line):
                wrong.append(f"{path.parent.name}/{path.name}:{number} asks for a law")
    return wrong


def check_numbers():
    wrong = []
    for path in sorted(SOURCES.glob("*/*.[ch]")):
        code = re.sub(r"/\*.*?\*/", lambda found: "\n" * found.group().count("\n"), path.read_text(), flags=re.S)
        for number, line in enumerate(code.splitlines(), 1):
            if re.match(r"#define|\s*static const|\s*const double|\s*[{]?[-\d.e, {}]*[}]?,?$", line):
                continue
            if re.search(r"(?<![\w.])[\d.]+e-?\d+|[<>]=? *-?\d*\.\d", re.sub(r'"(\\.|[^"])*"', "", line)):
                wrong.append(f"{path.parent.name}/{path.name}:{number} has a number without a name: {line.strip()}")
    return wrong


def bodies(path):
    """Name, lines and parameters of the functions of a file, as clang-format leaves them."""
    lines, out = path.read_text().splitlines(), []
    for first in (i for i, line in enumerate(lines) if line == "{"):
        begin = first
        while begin > 0 and lines[begin - 1] and not lines[begin - 1].startswith(("#", "/*", " *", "}")):
            begin -= 1
        found = re.search(r"(\w+)\((.*)\)\s*$", re.sub(r"__attribute__\(\(.*?\)\)", "", " ".join(lines[begin:first])))
        if not found:
            continue
        last = next(i for i in range(first, len(lines)) if lines[i].startswith("}"))
        flat = re.sub(r"\([^()]*\)", "", found[2])
        count = 0 if flat.strip() in ("", "void") else flat.count(",") + 1
        out.append((f"{path.parent.name}/{path.name} {found[1]}", last - begin + 1, count))
    return out


def parameters():
    """Who may take more than 6 parameters, and the lines without a reason."""
    lines = [line for line in (ROOT / "tools/rooms.parameters").read_text().splitlines() if line and not line.startswith("#")]
    return {line.partition(":")[0] for line in lines}, [line for line in lines if len(line.partition(":")[2].split()) < 3]


def check_functions():
    known, silent = parameters()
    found = [f for path in sorted(SOURCES.glob("*/*.c")) for f in bodies(path)]
    lengths = sorted(lines for _, lines, _ in found)
    wrong = [f"{name} has {lines} lines" for name, lines, _ in found if lines > 60]
    if lengths[len(lengths) // 2] > 11 or lengths[len(lengths) * 9 // 10] >= 30:
        wrong.append(f"half of the functions have more than {lengths[len(lengths) // 2] - 1} lines, one in ten "
                     f"{lengths[len(lengths) * 9 // 10]}")
    many = {name for name, _, count in found if count > 6}
    return wrong + [f"tools/rooms.parameters says not why: {line}" for line in silent] + [
        f"{name} takes more than 6 parameters" for name in sorted(many - known)] + [
        f"{name} of tools/rooms.parameters does not, or is gone" for name in sorted(known - many)]


def check_tests():
    """cmocka compares floats: seven digits, whatever tolerance is written."""
    return [f"{path.relative_to(ROOT)}:{number}: assert_float_equal compares in single precision; "
            "tests/support/close.h has assert_close"
            for path in sorted((ROOT / "tests").glob("*/*.c"))
            for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1)
            if re.search(r"\bassert_float_(not_)?equal\b", line)]


def main():
    rooms, failed = rooms_of_map(), 0
    checks = [("every source lies in a room of docs/map.md", check_files(rooms)),
              ("its ways lead where it says", check_ways()),
              ("rooms are entered from above, by their header", check_directions(rooms)),
              ("no headers include each other in a circle", check_circles()),
              ("functions carry the name of their file", check_prefixes()),
              ("only the ground asks which law a contact has", check_laws()),
              ("numbers of a tolerance have names", check_numbers()),
              ("functions fit a screen and take few parameters", check_functions()),
              ("tests compare numbers in double", check_tests())]
    print(f"1..{len(checks)}")
    for number, (text, wrong) in enumerate(checks, 1):
        print(f"{'not ok' if wrong else 'ok'} {number} - {text}")
        for line in wrong:
            print(f"# {line}")
        failed += bool(wrong)
    return 1 if failed else 0


sys.exit(main())
