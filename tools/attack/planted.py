"""Whether the judge sees: faults are planted in copies of atlases, and each has to be found under its own name.

    ATTACK_PART=planted tools/attack/attack PROGRAM [MOST]

With MOST that many branches are taken away, each looked for at one energy with a third of the motions, every fifth row is
missed by the comparison, and every other fault is planted in one structure, where it is one of a whole branch in some points
of it."""
import json
import os
import sqlite3
import struct
import subprocess
import sys
import tempfile

import numpy as np

import brute
import compare
import search
import structures
from judge import Atlas, Judge
from shared import Curves

WITHOUT = (130017,)  # bilinear: a branch is taken away, of which the junctions leave nothing out
SEEDS = (8, 24, 37, 18, 23)  # rigid with three and with two modes, bilinear, mixed, power law


def _float_blob(change):
    def edit(blob, rng):
        numbers = list(struct.unpack(f"<{len(blob) // 8}d", blob))
        return struct.pack(f"<{len(numbers)}d", *change(numbers, rng))
    return edit


def _one_off(numbers, rng):
    i = int(np.argmax(np.abs(numbers)))
    numbers[i] *= 1 + 1e-6
    return numbers


# table.column: what is done to a value of it, what finds it (any of these kinds), which rows it can be done to
FAULTS = {
    "energy": (lambda x, rng: x * (1 + 1e-6), {"energy"}, "energy > 0"),
    "frequency": (lambda x, rng: x * (1 + 1e-8), {"frequency"}, "1"),
    "state": (_float_blob(_one_off), {"residual", "energy"}, "1"),
    "flights": (_float_blob(_one_off), {"residual", "frequency"}, "1"),
    "stable": (lambda x, rng: 1 - x, {"flag"}, "stable < 2 AND abs(trace) < 1e6 AND abs(abs(trace) - 2) > 1e-6"),
    "trace": (lambda x, rng: x + 1e-6 * (1 + abs(x)), {"multiplier", "trace"}, "abs(trace) < 1e4"),
    "trace_asinh": (lambda x, rng: x + 1e-6, {"trace"}, "trace IS NOT NULL"),
    "reach": (lambda x, rng: x * 0.999, {"reach"}, "reach > 0.1"),
    "approach": (lambda x, rng: x * 1.001, {"approach"}, "approach > 1e-2"),
    "rotation": (lambda x, rng: (x + 1e-3) % 1, {"rotation"}, "rotation IS NOT NULL"),
}
BRANCH_FAULTS = {
    "symmetric": (lambda x, rng: 1, {"symmetric"}, "symmetric = 0"),
    "word": (lambda x, rng: x[::-1].translate(str.maketrans("01", "10")) + "0", {"word", "residual", "sequence"}, "1"),
    "points": (lambda x, rng: x + 1, {"rows"}, "1"),
}
JUNCTION_FAULTS = {
    "energy": (lambda x, rng: x * (1 + 1e-6), {"energy"}, "energy > 0"),
    "frequency": (lambda x, rng: x * (1 + 1e-6), {"frequency"}, "1"),
    "state": (_float_blob(_one_off), {"residual", "energy"}, "1"),
    "rotation_q": (lambda x, rng: x + 1, {"rotation"}, "kind = 'multiplication'"),
}


def _plant(atlas, table, column, fault, rng):
    """The row of a copy that is changed, drawn by chance: of a branch with impacts, or of a power law. None if there is none."""
    db = sqlite3.connect(atlas)
    edit, _, where = fault
    key = {"point": "branch IN (SELECT id FROM branch WHERE word <> '')", "branch": "word <> ''", "junction": "word <> ''"}[table]
    if column in ("frequency", "energy", "stable", "trace", "trace_asinh"):
        key += " OR NOT EXISTS (SELECT 1 FROM branch WHERE word <> '')"
    name = "branch, point" if table == "point" else "id, id"
    rows = db.execute(f"SELECT {name}, {column} FROM {table} WHERE ({key}) AND ({where})").fetchall()
    if rows:
        first, second, value = rows[int(rng.integers(len(rows)))]
        one = "branch = ? AND point = ?" if table == "point" else "id = ? AND id = ?"
        db.execute(f"UPDATE {table} SET {column} = ? WHERE {one}", (edit(value, rng), first, second))
        db.commit()
    db.close()
    return (first, second) if rows else None


def _swap(atlas, kind, rng):
    """Another orbit of the same branch in the place of a junction of that kind, with its energy and frequency: its id, or None."""
    db = sqlite3.connect(atlas)
    rows = db.execute("""SELECT j.id, p.energy, p.frequency, p.state, p.flights FROM junction j
        JOIN branch o ON o.word = j.word AND (j.id IN (o.from_junction, o.to_junction)
            OR j.id IN (SELECT junction FROM branch_junction WHERE branch = o.id))
        JOIN point p ON p.branch = o.id AND p.point BETWEEN 1 AND o.points - 2
        WHERE j.kind = ? AND j.word <> '' AND length(p.flights) = length(j.flights) AND abs(p.energy - j.energy) > 0.01 * j.energy""",
                      (kind,)).fetchall()
    if rows:
        id_, energy, frequency, state, flights = rows[int(rng.integers(len(rows)))]
        db.execute("UPDATE junction SET energy = ?, frequency = ?, state = ?, flights = ? WHERE id = ?",
                   (energy, frequency, state, flights, id_))
        db.commit()
    db.close()
    return (id_, id_) if rows else None


def _twice(atlas, rng):
    """A branch of orbits that are gone through twice: the branch, or None."""
    db = sqlite3.connect(atlas)
    rows = db.execute("SELECT id FROM branch WHERE word <> '' AND points > 2 AND impacts < 4").fetchall()
    if rows:
        (id_,) = rows[int(rng.integers(len(rows)))]
        word = db.execute("SELECT word FROM branch WHERE id = ?", (id_,)).fetchone()[0]
        db.execute("UPDATE branch SET word = ?, impacts = 2 * impacts WHERE id = ?", (word + ("." if "." in word else "") + word, id_))
        for point, flights in db.execute("SELECT point, flights FROM point WHERE branch = ?", (id_,)).fetchall():
            db.execute("UPDATE point SET flights = ?, period = 2 * period, frequency = frequency / 2 WHERE branch = ? AND point = ?",
                       (flights + flights, id_, point))
        db.commit()
    db.close()
    return (id_, id_) if rows else None


def _without(program, study, path, original, folder, seed, most):
    """(branches that the judge misses, of how many) where each branch that holds an orbit of a looked at energy is taken away,
    or where the first `most` are, which are looked for at one of these energies."""
    copy, missed, tried = os.path.join(folder, "copy.ricochet"), [], 0
    for branch in Atlas(original).branches:
        low, high = (branch[end] / study["explore"]["energy"][1] for end in ("energy_min", "energy_max"))
        parts = [part for part in brute.PARTS if low < part < high]
        if tried == most or not branch["word"] or not parts:
            continue
        with open(original, "rb") as there, open(copy, "wb") as here:
            here.write(there.read())
        db = sqlite3.connect(copy)
        for table, column in (("point", "branch"), ("branch_junction", "branch"), ("junction_branch", "branch"), ("branch", "id")):
            db.execute(f"DELETE FROM {table} WHERE {column} = ?", (branch["id"],))
        db.commit()
        db.close()
        tried += 1
        found = brute.Exclusion(program, study, path, copy, seed).run(brute.PARTS if most is None else parts[:1]).findings
        missed += [] if any(f["kind"] == "lost orbit" for f in found) else [branch["label"]]
    return missed, tried


def _unseen(program, study, original, folder, table, column, every):
    """(rows, one of `every`, that the comparison does not miss in a copy without them, of how many), ends of the energy window
    apart. A copy that lacks rows is refused by the program: what is said is said of the original."""
    copy, missed, tried = os.path.join(folder, "copy.ricochet"), [], 0
    curves = compare.curves_of(program, original, study["model"])
    whole, named = curves.atlas, curves.said.open if table == "junction" else ()
    for row in (whole.junctions if table == "junction" else whole.branches)[::every]:
        if row["id"] in named:
            continue
        with open(original, "rb") as there, open(copy, "wb") as here:
            here.write(there.read())
        db = sqlite3.connect(copy)
        for other in (table, "junction_branch", "branch_junction"):
            db.execute(f"DELETE FROM {other} WHERE {column if other != table else 'id'} = ?", (row["id"],))
        db.commit()
        db.close()
        tried += 1
        missed += [] if compare.differ(curves, Curves(Atlas(copy), study["model"], curves.said))[2] else [row["label"]]
    return missed, tried


def _findings(study, path, table, row, points=None):
    """Of that branch, point or junction alone; of a branch by its first `points`."""
    atlas = Atlas(path)
    atlas.branches = [b for b in atlas.branches if table != "junction" and b["id"] == row[0]]
    atlas.junctions = [j for j in atlas.junctions if table == "junction" and j["id"] == row[0]]
    if table == "branch":
        atlas.points = {row[0]: atlas.points[row[0]][:points]}
    if table == "point":
        atlas.points = {row[0]: [p for p in atlas.points[row[0]] if p["point"] == row[1]]}
    return {(f["kind"], f["where"]) for f in Judge(study["model"], atlas, budget=10**9).run().findings}


class Turns:
    """Which fault is planted in which of the SEEDS: all in all; in the short form each once, in the structure whose turn it is
    or in the next one that has a row for it, and every fourth of those of points in the last one, a power law, too."""

    def __init__(self, short):
        self.short, self.planted = short, set()

    def due(self, name, number, structure):
        turn, last = number % (len(SEEDS) - 1), len(SEEDS) - 1
        return not self.short or (turn == 0 if structure == last else turn <= structure and name not in self.planted)


def main():
    program, rng = os.path.abspath(sys.argv[1]), np.random.default_rng(1)
    most = int(sys.argv[2]) if len(sys.argv) > 2 else None  # branches that are taken away
    done = missed = 0
    turns = Turns(most is not None)
    if turns.short:
        search.STARTS = {modes: count // 3 for modes, count in search.STARTS.items()}
    with tempfile.TemporaryDirectory() as folder:
        for structure, seed in enumerate(SEEDS):
            _, text, study = structures.make(seed)
            path, atlas = os.path.join(folder, "study.yaml"), os.path.join(folder, f"{seed}.ricochet")
            with open(path, "w", encoding="utf-8") as file:
                json.dump(study, file)
            subprocess.run([program, "run", path, "-o", atlas], check=True, capture_output=True)
            with open(atlas, "rb") as file:
                original = file.read()
            for number, kind in enumerate(("extremum", "grazing")):
                if not turns.due(kind, number, structure):
                    continue
                copy = os.path.join(folder, "copy.ricochet")
                with open(copy, "wb") as file:
                    file.write(original)
                row = _swap(copy, kind, rng)
                if row is None:
                    continue
                turns.planted.add(kind)
                found = _findings(study, copy, "junction", row) - _findings(study, atlas, "junction", row)
                seen = any(x == kind for x, _ in found)
                done += 1
                missed += not seen
                print(f"{'ok' if seen else 'not ok'} {done} - another orbit as {kind} of seed {seed} ({text})", flush=True)
            copy = os.path.join(folder, "copy.ricochet")
            with open(copy, "wb") as file:
                file.write(original)
            row = _twice(copy, rng) if turns.due("twice", 2, structure) else None
            if row is not None:
                turns.planted.add("twice")
                seen = any(kind == "repeats" for kind, _ in _findings(study, copy, "branch", row, 4 if turns.short else None))
                done += 1
                missed += not seen
                print(f"{'ok' if seen else 'not ok'} {done} - orbits gone through twice of seed {seed} ({text})", flush=True)
            for table, faults in (("point", FAULTS), ("branch", BRANCH_FAULTS), ("junction", JUNCTION_FAULTS)):
                if study["model"]["contacts"][0]["law"] == "power" and table != "point":
                    continue
                for number, (column, fault) in enumerate(faults.items()):
                    if not turns.due(f"{table}.{column}", number, structure):
                        continue
                    copy = os.path.join(folder, "copy.ricochet")
                    with open(copy, "wb") as file:
                        file.write(original)
                    row = _plant(copy, table, column, fault, rng)
                    if row is None:
                        continue
                    turns.planted.add(f"{table}.{column}")
                    found = _findings(study, copy, table, row) - _findings(study, atlas, table, row)
                    seen = any(kind in fault[1] for kind, _ in found)
                    done += 1
                    missed += not seen
                    print(f"{'ok' if seen else 'not ok'} {done} - {table}.{column} of seed {seed} ({text})", flush=True)
        for seed in WITHOUT:
            _, text, study = structures.make(seed, None, True)
            path, atlas = os.path.join(folder, "study.yaml"), os.path.join(folder, f"{seed}.ricochet")
            with open(path, "w", encoding="utf-8") as file:
                json.dump(study, file)
            subprocess.run([program, "run", path, "-o", atlas], check=True, capture_output=True)
            for table in ("branch", "junction"):
                lost, tried = _unseen(program, study, atlas, folder, table, table, 1 if most is None else 5)
                done += 1
                missed += bool(lost) or not tried
                print(f"{'not ok' if lost or not tried else 'ok'} {done} - {tried} times another atlas, a {table} less, of seed {seed} {lost}")
            lost, tried = _without(program, study, path, atlas, folder, seed, most)
            done += 1
            missed += bool(lost) or not tried
            print(f"{'not ok' if lost or not tried else 'ok'} {done} - any of {tried} branches away of seed {seed} ({text}) {lost}")
    print(f"1..{done}")
    return 1 if missed or not done else 0


if __name__ == "__main__":
    np.seterr(all="ignore")
    sys.exit(main())
