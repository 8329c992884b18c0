#!/usr/bin/env python3
"""Whether an atlas depends on the step length: explores studies with 20 largest steps over a factor 100 and compares what comes out.

    tools/steps.py [--program build/ricochet] [--steps 20] [--random N] [--seed S] [STUDY ...]

Junctions must agree in kind, word, a, b and, to 1e-9, in energy and frequency, to 1e-6 in their orbits; branches in word, symmetry, ends, stop
and in the junctions that they pass, in order. Events that make no junction are counted, not compared. Each line of the report is something
that only some of the runs have. Without a STUDY all examples are measured;
--random N adds N two-mass models drawn with the seed S. Exit status 1 if anything differs.
"""
import argparse
import collections
import glob
import os
import random
import re
import sqlite3
import struct
import subprocess
import sys
import tempfile
import time

TOLERANCE = 1e-9
ORBIT = 1e-6 # two junctions may be nearer than TOLERANCE: their orbits tell them apart


def random_study(rng):
    """Two masses, a stop on both sides of their distance or on the second one's motion."""
    m1, m2 = rng.uniform(0.5, 3), rng.uniform(0.5, 3)
    k1, k2, k3 = rng.uniform(0.5, 9), rng.uniform(0.3, 3), rng.choice([0, rng.uniform(0.3, 3)])
    normal, sides = rng.choice(["[-1, 1]", "[0, 1]", "[1, 0]"]), rng.choice(["both", "both", "upper"])
    return (f"title: random\nmodel:\n  mass: [[{m1!r}, 0], [0, {m2!r}]]\n  stiffness: [[{k1 + k2!r}, {-k2!r}], [{-k2!r}, {k2 + k3!r}]]\n"
            f"  contacts:\n    - {{name: stop, normal: {normal}, clearance: 1.0, sides: {sides}, law: rigid}}\n"
            f"explore: {{energy: [0, {20 * (k1 + k2)!r}], frequency: [0.1, 10], impacts: 12, multiply: 1, depth: 3}}\n")


class Junctions:
    """Every junction of every run, numbered: the same number for what agrees."""

    def __init__(self):
        self.known = collections.defaultdict(list)
        self.rows = []
        self.states = []

    def number(self, row):
        key, energy, frequency = tuple(row[:7]), row[7], row[8]
        state = struct.unpack(f"<{len(row[9]) // 8}d", row[9])
        for i in self.known[key]:
            e, f, other = self.states[i]
            far = max(abs(a - b) for a, b in zip(state, other)) > ORBIT * (1 + max(map(abs, state)))
            if abs(energy - e) <= TOLERANCE * abs(e) and abs(frequency - f) <= TOLERANCE * abs(f) and not far:
                return i
        self.known[key].append(len(self.rows))
        self.rows.append(row[:9])
        self.states.append((energy, frequency, state))
        return len(self.rows) - 1

    def text(self, i):
        if i is None:
            return "-"
        kind, word, a, b, multiple, p, _, energy, frequency = self.rows[i]
        return f"{kind} {a}{b} {word or '-'}{f' {p}/{multiple}' if multiple > 1 else ''} E {energy:.13g} omega {frequency:.13g}"


def read(path, junctions):
    atlas = sqlite3.connect(f"file:{path}?mode=ro", uri=True)
    number, found, branches = {None: None}, collections.Counter(), collections.Counter()
    for row in atlas.execute("SELECT id, kind, word, a, b, multiple, rotation_p, grazings, energy, frequency, state FROM junction ORDER BY id"):
        number[row[0]] = junctions.number(row[1:])
        found[number[row[0]]] += 1
    passed = collections.defaultdict(list)
    for branch, junction in atlas.execute("SELECT branch, junction FROM branch_junction ORDER BY branch, position"):
        passed[branch].append(number[junction])
    for row in atlas.execute("SELECT id, label, word, mirror, symmetric, reversible, depth, stop, why, from_junction, to_junction FROM branch"):
        why = re.sub(r"(; )?\d+ events? on it do(es)? not converge to (a junction|junctions)", "", row[8])
        branches[(*row[1:8], why, number[row[9]], number[row[10]], tuple(passed[row[0]]))] += 1
    unplaced = atlas.execute("SELECT value FROM meta WHERE key = 'unplaced'").fetchone()
    atlas.close()
    return found, branches, int(unplaced[0]) if unplaced else 0


def which(steps, has):
    return f"{sum(has)} of {len(steps)} ({', '.join(f'{h:.2g}' for h, x in zip(steps, has) if (not x) == (sum(has) * 2 > len(has)))}" \
           f"{' have not' if sum(has) * 2 > len(has) else ' have'})"


def compare(program, study, steps, folder):
    junctions, runs, began = Junctions(), [], time.time()
    for i, step in enumerate(steps):
        out = os.path.join(folder, f"{i}.ricochet")
        subprocess.run([program, "run", study, "-o", out, "--max-step", repr(step)], check=True, capture_output=True)
        runs.append(read(out, junctions))
        os.remove(out)
    lines = []
    for j in range(len(junctions.rows)):
        counts = [run[0][j] for run in runs]
        if min(counts) == 0:
            lines.append(f"  junction {junctions.text(j)}: {which(steps, [c > 0 for c in counts])}")
        if max(counts) > 1:
            lines.append(f"  junction {junctions.text(j)}: up to {max(counts)} times in one atlas")
    for b in sorted(set().union(*(run[1] for run in runs)), key=repr):
        counts = [run[1][b] for run in runs]
        if min(counts) == max(counts):
            continue
        label, word, mirror, *_, depth, stop, why, start, end, passed = b
        lines.append(f"  branch {label} {mirror} depth {depth} from {junctions.text(start)} to {junctions.text(end)} {stop} {why}: "
                     f"{which(steps, [c > 0 for c in counts])}")
        lines += [f"      passes {junctions.text(j)}" for j in passed]
    n_branch, n_junction = ([sum(run[k].values()) for run in runs] for k in (1, 0))
    span = lambda counts: f"{min(counts)}" if min(counts) == max(counts) else f"{min(counts)}-{max(counts)}"
    print(f"{study}: {span(n_branch)} branches, {span(n_junction)} junctions, {'SAME' if not lines else f'{len(lines)} differences'}, "
          f"{time.time() - began:.0f} s", flush=True)
    if any(run[2] for run in runs): # zeros in rounding, which make no junction
        print(f"  events that are no junctions: {span([run[2] for run in runs])}")
    for line in lines:
        print(line)
    return not lines


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("studies", nargs="*")
    parser.add_argument("--program", default="build/ricochet")
    parser.add_argument("--steps", type=int, default=20)
    parser.add_argument("--random", type=int, default=0)
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    steps = [10 ** (-2 + 2 * i / (args.steps - 1)) for i in range(args.steps)]
    studies = args.studies or ([] if args.random else sorted(glob.glob("examples/*/study.yaml")))
    rng, same = random.Random(args.seed), True
    with tempfile.TemporaryDirectory() as folder:
        for i in range(args.random):
            path = os.path.join(folder, f"random-{args.seed}-{i}.yaml")
            with open(path, "w") as out:
                out.write(random_study(rng))
            studies.append(path)
        for study in studies:
            same &= compare(args.program, study, steps, folder)
    return 0 if same else 1


if __name__ == "__main__":
    sys.exit(main())
