#!/usr/bin/env python3
"""How the families of the article go on, level by level, and with which powers: scaling.py PROGRAM [--short] [--page FILE]

Explores the two masses of the article, lists each family of points by its number k, and fits y = c x^p (`power`). Prints the
tables of docs/article.md. `--short` computes fewer levels; with `--page` it compares what it has with the tables of that
page, line by line, and ends with exit status 1 if a number differs.
"""
import json
import math
import os
import subprocess
import sys
import tempfile

OMEGA_0 = math.sqrt(8 / 3)
OMEGA_2 = math.sqrt((11 + math.sqrt(57)) / 4)  # 2 w^4 - 11 w^2 + 8 = 0
STUDY = """model:
  mass: [[2, 0], [0, 1]]
  stiffness: [[9, -1], [-1, 1]]
  contacts: [{normal: [-1, 1], clearance: 1, sides: both, law: rigid}]
explore: {%s}
"""


class Atlas:
    """Branches and junctions of a study, by their numbers."""

    def __init__(self, program, folder, explore):
        study, atlas = os.path.join(folder, "study.yaml"), os.path.join(folder, "atlas.ricochet")
        with open(study, "w", encoding="utf-8") as file:
            file.write(STUDY % explore)
        if os.path.exists(atlas):
            os.remove(atlas)
        subprocess.run([program, "run", study, "-o", atlas, "-j", "1", "--quiet"], check=True, capture_output=True)
        self.branches, self.junctions = (self.listing(program, what, atlas) for what in ("branches", "junctions"))

    @staticmethod
    def listing(program, what, atlas):
        done = subprocess.run([program, what, atlas, "--json"], check=True, capture_output=True)
        return {row["id"]: row for row in json.loads(done.stdout)}

    def branch(self, label):
        """The one branch with mirror points of that label."""
        found = [b for b in self.branches.values() if b["label"] == label and b["reversible"]]
        assert len(found) == 1, (label, len(found))
        return found[0]

    def on(self, branch, *kinds):
        """Junctions of these kinds on a branch, from low energies on."""
        rows = [self.junctions[j] for j in branch["junctions"]]
        return sorted((j for j in rows if j["kind"] in kinds), key=lambda j: j["energy"])

    def ends(self, branch):
        return [self.junctions[j] for j in (branch["from"], branch["to"]) if j]


def chattering(atlas, k):
    """S_2k[01]^k: its C_33, its C_32, between which it is stable, and its highest frequency."""
    branch = atlas.branch(f"S{2 * k}[{'01' * k}]")
    meet = next(j for j in atlas.on(branch, "multiplication") if j["impacts"] == 2 and j["multiple"] == k)
    stable = atlas.on(branch, "branch-point")
    assert len(stable) == 1
    return {"E of C_33": meet["energy"], "ω − ω₀ there": meet["frequency"] - OMEGA_0, "E of C_32": stable[0]["energy"],
            "ω − ω₀ at the top": branch["frequency_max"] - OMEGA_0}


def sticking(atlas, j):
    """S_2j[0^j 1^j]: its C_31 and last C_32, its least frequency, and the end of high energy."""
    branch = atlas.branch(f"S{2 * j}[{'0' * j}{'1' * j}]")
    turn, points = atlas.on(branch, "extremum"), atlas.on(branch, "branch-point")
    turn = [t for t in turn if (t["a"], t["b"]) == (3, 1)]
    assert len(turn) == 1 and len(points) == (2 if j < 7 else 3)
    end = max(atlas.ends(branch), key=lambda x: x["energy"])
    return {"E of C_31": turn[0]["energy"], "E of the tongue": points[0]["energy"],
            "ω₀ − ω at the bottom": OMEGA_0 - branch["frequency_min"], "E of the end": end["energy"]}


def loop(program, folder, k, bottom):
    """The loop of F_2^k: C_33 on the k-duplicate of S2-, and where its two families come to the energy of G_0,2k."""
    top = 2.7538 + 3.5 / k**2  # above this one, below the next C_33
    atlas = Atlas(program, folder, f"start: [2], energy: [0, {8 if k < 5 else 3}], frequency: [{OMEGA_2 / k * 1.0001}, {top}], "
                                   f"impacts: {2 * k}, multiply: {k}, cascade: [{k}], depth: 0")
    meet = next(j for j in atlas.junctions.values() if j["kind"] == "multiplication" and j["impacts"] == 2 and j["multiple"] == k)
    families = [atlas.branches[b] for b in meet["branches"] if atlas.branches[b]["impacts"] == 2 * k]
    assert len(families) == 2 and all(b["stop"] == "junction" for b in families)
    ends = [max(atlas.ends(b), key=lambda x: x["energy"]) for b in families]
    mode = next(j for j in atlas.junctions.values() if j["kind"] == "grazing" and not j["impacts"])
    slow, fast = sorted(e["frequency"] for e in ends)
    return {"E − E of C2_31": meet["energy"] - bottom["energy"], "k ω − ω of C2_31": k * meet["frequency"] - bottom["frequency"],
            "E of the first end − E₀": ends_off(ends, slow, mode), "E of the second − E₀": ends_off(ends, fast, mode),
            "k − T / T₂ there": k - OMEGA_2 / slow, "and there": k - OMEGA_2 / fast}


def ends_off(ends, frequency, mode):
    return next(e["energy"] for e in ends if e["frequency"] == frequency) - mode["energy"]


def slope(a, b):
    return math.log(b[1] / a[1]) / math.log(b[0] / a[0])


def power(rows):
    """y = c x^p from [(x, y)]: p and its error. Slopes between neighbours are led to their limit as p + b / x and as
    p + b / x^2: p lies in their middle, and the error is what they differ by and what the last level changes."""
    at = [(math.sqrt(a[0] * b[0]), slope(a, b)) for a, b in zip(rows, rows[1:])]
    ends, moved = [], 0
    for order in (1, 2):
        limits = [(q * y**order - p * x**order) / (y**order - x**order) for (x, p), (y, q) in zip(at[-3:], at[-2:])]
        ends.append(limits[-1])
        moved = max(moved, abs(limits[-1] - limits[-2]))
    return sum(ends) / 2, max(ends) - min(ends) + moved


def cell(value):
    return "0" if abs(value) < 1e-8 else f"{value:.7g}"  # nearer than that it is rounding


def table(name, rows, skip=()):
    """Lines of Markdown: a row for each level, and the powers where there are levels enough."""
    columns = list(next(iter(rows.values())))
    lines = [f"| {name} | " + " | ".join(columns) + " |", "|---" * (len(columns) + 1) + "|"]
    lines += [f"| {k} | " + " | ".join(cell(v) for v in row.values()) + " |" for k, row in rows.items()]
    if len(rows) > 7:
        fits = ["" if c in skip else "%.3f ± %.3f" % power([(k, row[c]) for k, row in rows.items()]) for c in columns]
        lines.append("| power | " + " | ".join(fits) + " |")
    return lines


def compute(program, short):
    """The lines of all tables, one list for each."""
    with tempfile.TemporaryDirectory() as folder:
        top, impacts = (2000, 14) if short else (300000, 34)
        path = Atlas(program, folder, f"start: [1], energy: [0, {top}], frequency: [0.9, 80], impacts: {impacts}, multiply: 1, depth: 0, "
                                      "symmetric: true")
        modes = Atlas(program, folder, "start: [2], energy: [0, 4], frequency: [2, 4], impacts: 2, multiply: 1, depth: 1")
        bottom = next(j for j in modes.junctions.values() if j["kind"] == "extremum")
        loops = {k: loop(program, folder, k, bottom) for k in ([2, 3, 4, 5, 6, 15] if short else range(2, 21))}
        return [table("k", {k: chattering(path, k) for k in range(3, 8 if short else 18, 2)}),
                table("j", {j: sticking(path, j) for j in range(2, 4 if short else 12)}),
                table("k", loops, skip=list(loops[2])[2:])]


def main():
    options = sys.argv[1:]
    page = options.pop(options.index("--page") + 1) if "--page" in options else None
    short, program = "--short" in options, [o for o in options if not o.startswith("--")]
    if len(program) != 1:
        sys.exit(__doc__)
    tables = compute(program[0], short)
    print("\n\n".join("\n".join(lines) for lines in tables))
    if page:
        with open(page, encoding="utf-8") as file:
            held = set(file.read().split("\n"))
        strange = [line for lines in tables for line in lines if line not in held]
        sys.exit("\n".join(["", f"{page} has not:"] + strange) if strange else 0)


if __name__ == "__main__":
    main()
