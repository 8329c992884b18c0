#!/usr/bin/env python3
"""Plants faults in atlases and counts those that `ricochet verify` finds.

    tools/attack/plant.py [--places N] [--seed S] [--program RICOCHET] ATLAS...

A fault is one number of one stored point, or a letter of a word, at a random place:

    flag       a stable flag turned, to the other or to undecided
    trace      off by a relative 1e-6, or by ten times the bound that verify gives, whichever is larger (two modes)
    rotation   off by 1e-6, or by what ten times that bound makes of it, or 1 - gamma
    speed      a velocity of the stored state off by a relative 1e-6
    energy, frequency, reach, approach   off by a relative 1e-6, at least by 1e-8
    word       a letter changed
    touch      a grazing moved along the branch without the touch, to a stored point whose reach is off 1 by 1e-5 to 0.1

Many faults go into one copy of an atlas, each at a point of its own, a letter or a frequency into one alone, which may
be refused as a whole; the digest is made anew (atlas_digest.py) and verify is asked about each of these points. A fault
is found if it exits with 1 for that point. Where verify says of the right number that it could not check it, the place is
counted apart: before, or of a flag that is now undecided, which claims nothing. The original has to pass. Exit code
1 if a fault was missed, or an original does not pass. Standard library only.
"""

import argparse
import json
import math
import random
import shutil
import sqlite3
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
import atlas_digest  # noqa: E402

KINDS = ["flag", "trace", "rotation", "speed", "energy", "frequency", "reach", "approach", "word"]
ENOUGH = 1e-8


def verify(program, atlas, *more):
    done = subprocess.run([program, "verify", atlas, *more, "--json"], capture_output=True, text=True)
    rows = json.loads(done.stdout) if done.stdout.strip() else []
    rows.sort(key=lambda row: row["kind"] != "point")
    return done.returncode, rows


def moved(rng, value):
    return value + rng.choice([-1, 1]) * max(1e-6 * abs(value), ENOUGH)


def unchecked(check):
    """Names of the numbers that verify says it could not check."""
    return check["unchecked"].split(", ")


def set_trace(db, at, asinh):
    trace, log_trace = None, None
    if abs(asinh) < 700:
        trace = 2 * math.sinh(asinh)
    if asinh != 0:
        log_trace = abs(asinh) + math.log(-math.expm1(-2 * abs(asinh)))
    db.execute("UPDATE point SET trace = ?, log_trace = ?, trace_asinh = ? WHERE branch = ? AND point = ?",
               [trace, log_trace, asinh, *at])


def plant(rng, db, kind, at, point, check):
    """Returns what was done, or None where there is nothing to do it to, and whether verify can know."""
    def put(column, value):
        db.execute(f"UPDATE point SET {column} = ? WHERE branch = ? AND point = ?", [value, *at])
        return f"{column} {point[column]!r} -> {value!r}"

    if kind == "flag":
        new = rng.choice([flag for flag in (0, 1, 2) if flag != point["stable"]])
        return put("stable", new), check["stable_agrees"] == "yes" and point["stable"] != 2
    if kind == "trace":
        if point["trace_asinh"] is None or check["multiplier_bound"] is None:
            return None, False
        y, bound = point["trace_asinh"], check["multiplier_bound"]
        relative = abs(math.tanh(y)) if abs(y) < 300 else 1
        new = y + rng.choice([-1, 1]) * max(1e-6 * relative, 10 * bound)
        set_trace(db, at, new)
        return f"trace_asinh {y!r} -> {new!r}", check["multipliers_agree"] == "yes"
    if kind == "rotation":
        if point["rotation"] is None:
            return None, False
        slope = 4 * math.pi * abs(math.sin(2 * math.pi * point["rotation"]))  # of trace = 2 cos(2 pi gamma)
        if check["multiplier_bound"] is None or slope < 1e-4:
            return None, False
        off = max(1e-6, 10 * check["multiplier_bound"] * math.hypot(2, 2 * math.sinh(point["trace_asinh"])) / slope)
        new = point["rotation"] + (off if point["rotation"] < 0.5 else -off)
        if rng.random() < 0.3 and abs(point["rotation"] - 0.5) > off and point["rotation"] > off:
            new = 1 - point["rotation"]
        return put("rotation", new), check["multipliers_agree"] == "yes"
    if kind == "speed":
        numbers = list(struct.unpack(f"<{len(point['state']) // 8}d", point["state"]))
        n = len(numbers) // 2
        largest = max(range(n, 2 * n), key=lambda i: abs(numbers[i]))
        if abs(numbers[largest]) < 1e-6:
            return None, False
        numbers[largest] *= 1 + rng.choice([-1, 1]) * 1e-6
        put("state", struct.pack(f"<{2 * n}d", *numbers))
        return f"v{largest - n + 1} off by 1e-6", f"v{largest - n + 1}" not in unchecked(check)
    if point[kind] is None:
        return None, False
    new = moved(rng, point[kind])
    if kind == "frequency":
        put("period", 2 * math.pi / new)
    return put(kind, new), kind not in unchecked(check)


def plant_letter(rng, db, branch, faces):
    places = [i for i, letter in enumerate(branch["word"]) if letter != "-"]
    if not places or faces < 2 or "." in branch["word"]:
        return None
    i = rng.choice(places)
    letters = [c for c in "0123456789abcdefghijklmnopqrstuvwxyz"[:faces] if c != branch["word"][i]]
    word = branch["word"][:i] + rng.choice(letters) + branch["word"][i + 1:]
    db.execute("UPDATE branch SET word = ? WHERE id = ?", [word, branch["id"]])
    return f"word {branch['word']} -> {word}"


def choose(rng, checks, places):
    """Points that pass, each with a kind of fault."""
    good = [row for row in checks if row["passed"] and row["kind"] == "point"]
    rng.shuffle(good)
    return [(row, rng.choice(KINDS)) for row in good[:places]]


TOLD = {"flag": "stable_agrees", "trace": "multipliers_agree", "rotation": "multipliers_agree"}  # where verify says that it cannot tell
ALONE = ("word", "frequency")  # the file may be one that no run can have written, which is refused as a whole


def open_copy(original, folder):
    copy = Path(folder) / "planted.ricochet"
    shutil.copy(original, copy)
    db = sqlite3.connect(copy)
    db.row_factory = sqlite3.Row
    return copy, db


def plant_touches(db):
    """Moves grazings, all that can be; ids and what was done."""
    planted = []
    for junction in db.execute("SELECT * FROM junction WHERE kind = 'grazing' AND word != ''").fetchall():
        # where an impact has no speed either, what is planted is a grazing of its own
        point = db.execute(
            "SELECT point.* FROM point JOIN branch ON branch.id = point.branch WHERE branch.word = ? AND "
            "(from_junction = ? OR to_junction = ?) AND abs(reach - 1) > 1e-5 AND abs(reach - 1) < 0.1 AND "
            "approach > 1e-3 * point.frequency ORDER BY abs(reach - 1)",
            [junction["word"], junction["id"], junction["id"]]).fetchone()
        if point:
            db.execute("UPDATE junction SET state = ?, flights = ?, energy = ?, frequency = ? WHERE id = ?",
                       [point["state"], point["flights"], point["energy"], point["frequency"] / junction["multiple"], junction["id"]])
            planted.append((junction["id"], f"{junction['label']} at a reach of {point['reach']!r}"))
    return planted


def judge_touches(program, original, folder, count):
    copy, db = open_copy(original, folder)
    planted = plant_touches(db)
    db.commit()
    db.close()
    atlas_digest.update(copy)
    rows = {row["junction"]: row for row in verify(program, str(copy))[1] if row["kind"] == "junction"} if planted else {}
    for junction, what in planted:
        row = rows.get(junction)  # no rows: refused as a whole
        count["planted"] += 1
        if row is None or not row["passed"]:
            count["found"] += 1
        elif "touch" in unchecked(row):
            count["unchecked"] += 1
            print(f"{original}: junction {junction}: cannot tell: touch: {what}")
        else:
            count["missed"] += 1
            print(f"{original}: junction {junction}: not found: touch: {what}")


def judge(program, original, copy, fault, count):
    at, kind, what, known = fault
    point = [] if kind == "word" else ["--point", str(at[1])]  # a word is that of all points of its branch
    code, rows = verify(program, str(copy), "--branch", str(at[0]), *point)
    count["planted"] += 1
    if code == 1 and (not rows or not all(row["passed"] for row in rows)):  # no rows: refused, for this fault alone
        count["found"] += 1
    elif code == 0 and (not known or rows[0][TOLD.get(kind, "passed")] == "unchecked"):
        count["unchecked"] += 1
        print(f"{original}: branch {at[0]}, point {at[1]}: cannot tell: {kind}: {what}")
    else:
        count["missed"] += 1
        print(f"{original}: branch {at[0]}, point {at[1]}: not found: {kind}: {what} (exit code {code})")


def plant_all(program, original, chosen, rng, folder, count):
    """Into one copy, or where that is refused as a whole into one each; then every fault is asked for."""
    copy, db = open_copy(original, folder)
    branches = {row["id"]: dict(row) for row in db.execute("SELECT * FROM branch")}
    faces = len({c for b in branches.values() for c in b["word"] if c not in "-."})
    planted = []
    for check, kind in chosen:
        at = (check["branch"], check["point"])
        point = dict(db.execute("SELECT * FROM point WHERE branch = ? AND point = ?", at).fetchone())
        what, known = (plant_letter(rng, db, branches[at[0]], faces), True) if kind == "word" \
            else plant(rng, db, kind, at, point, check)
        if what:
            planted.append((at, kind, what, known))
    db.commit()
    db.close()
    if planted:
        atlas_digest.update(copy)
        refused = verify(program, str(copy))
        if len(chosen) > 1 and refused[0] == 1 and not refused[1]:
            for one in chosen:
                plant_all(program, original, [one], rng, folder, count)
            return
    for fault in planted:
        judge(program, original, copy, fault, count)


def run(program, original, places, rng, folder, count):
    code, checks = verify(program, original, "--all")
    if code:
        print(f"{original}: {sum(not row['passed'] for row in checks)} of {len(checks)} points do not pass as they are")
        count["sick"] += 1
    chosen = choose(rng, checks, places)
    plant_all(program, original, [c for c in chosen if c[1] not in ALONE], rng, folder, count)
    for one in chosen:
        if one[1] in ALONE:
            plant_all(program, original, [one], rng, folder, count)
    judge_touches(program, original, folder, count)


def main():
    parser = argparse.ArgumentParser(usage=__doc__)
    parser.add_argument("--places", type=int, default=60)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--program", default="build/ricochet")
    parser.add_argument("atlas", nargs="+")
    given = parser.parse_args()
    rng = random.Random(given.seed)
    count = {"planted": 0, "found": 0, "unchecked": 0, "missed": 0, "sick": 0}
    with tempfile.TemporaryDirectory() as folder:
        for k, atlas in enumerate(given.atlas):
            left = given.places - count["planted"]
            run(given.program, atlas, -(-left // (len(given.atlas) - k)), rng, folder, count)
    print(f"seed {given.seed}: {count['planted']} faults planted, {count['found']} found, {count['unchecked']} where "
          f"verify says that it cannot tell, {count['missed']} missed")
    sys.exit(1 if count["missed"] or count["sick"] or not count["planted"] else 0)


if __name__ == "__main__":
    main()
