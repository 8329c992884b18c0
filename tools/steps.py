#!/usr/bin/env python3
"""Whether an atlas depends on the step length: explores studies with 20 largest steps over a factor 100 and compares what comes out.

    tools/steps.py [--program build/ricochet] [--steps 20] [--range 0.01 1] [--random N] [--kinds rigid ...] [--seed S] [--limit SECONDS] [STUDY ...]

Junctions must agree in kind, word, a, b and, to 1e-9, in energy and frequency, to 1e-6 in their orbits; branches in word, symmetry, ends, stop
and in the junctions that they pass, in order. Events that make no junction are counted, not compared. Each line of the report is something
that only some of the runs have. Without a STUDY all examples are measured;
--random N adds N structures drawn with the seed S, of two to five masses and of the kinds in turn; --limit leaves out what takes longer.
Exit status 1 if anything differs.
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


def matrix(rows):
    return "[" + ", ".join("[" + ", ".join(repr(x) for x in row) + "]" for row in rows) + "]"


def random_contact(rng, n, law, sides):
    a = rng.randrange(n)
    normal = [0] * n
    normal[a] = 1
    if n > 1 and rng.random() < 0.5:
        normal[rng.choice([i for i in range(n) if i != a])] = -1
    if law == "power":
        return f"{{law: power, normal: {normal}, exponent: {rng.choice([3, 3, 5, 7])}, stiffness: {rng.uniform(0.2, 3)!r}}}"
    stiffness = f", stiffness: {10 ** rng.uniform(-0.5, 2.5)!r}" if law == "bilinear" else ""
    return f"{{law: {law}, normal: {normal}, clearance: {rng.uniform(0.5, 1.5)!r}, sides: {sides}{stiffness}}}"


def random_study(rng, kind):
    """A chain of 2 to 5 masses, some of them alike, with one to three contacts of the laws of its kind."""
    n = rng.choice([2, 2, 2, 3, 3, 4, 5])
    masses = [rng.uniform(0.5, 2) for _ in range(n)]
    springs = [rng.uniform(0.3, 6) for _ in range(n + 1)]
    if rng.random() < 0.2: # left-right images, and nearly equal frequencies
        masses = [masses[min(i, n - 1 - i)] * (1 + 1e-7 * rng.random()) for i in range(n)]
        springs = [springs[min(i, n - i)] for i in range(n + 1)]
    if rng.random() < 0.5:
        springs[n] = 0
    stiffness = [[springs[i] + springs[i + 1] if i == j else -springs[max(i, j)] if abs(i - j) == 1 else 0 for j in range(n)] for i in range(n)]
    mass = [[masses[i] if i == j else 0 for j in range(n)] for i in range(n)]
    laws = {"rigid": ["rigid"], "bilinear": ["bilinear"], "power": ["power"], "mixed": ["rigid", "bilinear"]}[kind]
    if kind != "mixed" and rng.random() < 0.4:
        laws = laws * 2
    contacts = [random_contact(rng, n, law, rng.choice(["both", "both", "upper", "lower"])) for law in laws]
    impacts = rng.choice([6, 8, 10]) if n == 2 else rng.choice([4, 6])
    top = 10 ** rng.uniform(0.7, 2) if kind != "power" else 10 ** rng.uniform(0, 1.3)
    return (f"title: random\nmodel:\n  mass: {matrix(mass)}\n  stiffness: {matrix(stiffness)}\n  contacts:\n    - " + "\n    - ".join(contacts) +
            f"\nexplore: {{energy: [0, {top!r}], frequency: [{rng.uniform(0.2, 0.6)!r}, 10], impacts: {impacts}, multiply: {rng.choice([1, 2, 3, 4])}, "
            f"depth: {rng.choice([2, 3])}}}\n")


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
        why = re.sub(r"(; )?\d+ events? on it do(es)? not converge to a junction( \([^)]*\))?", "", row[8])
        why = re.sub(r"(; )?(on (up to )?\S+ % of it multipliers are lost|events on it may lie closer).*", "", why)
        branches[(*row[1:8], why, number[row[9]], number[row[10]], tuple(passed[row[0]]))] += 1
    unplaced = atlas.execute("SELECT value FROM meta WHERE key = 'unplaced'").fetchone()
    atlas.close()
    return found, branches, int(unplaced[0]) if unplaced else 0


def which(steps, has):
    return f"{sum(has)} of {len(steps)} ({', '.join(f'{h:.2g}' for h, x in zip(steps, has) if (not x) == (sum(has) * 2 > len(has)))}" \
           f"{' have not' if sum(has) * 2 > len(has) else ' have'})"


def compare(program, study, steps, folder, limit=None):
    junctions, runs, began = Junctions(), [], time.time()
    for i, step in enumerate(steps):
        out = os.path.join(folder, f"{i}.ricochet")
        if os.path.exists(out): # of a run that was not finished
            os.remove(out)
        try:
            subprocess.run([program, "run", study, "-o", out, "--max-step", repr(step)], check=True, capture_output=True, timeout=limit)
        except subprocess.TimeoutExpired:
            print(f"{study}: not finished in {limit} s with the step {step:.2g}", flush=True)
            return None
        except subprocess.CalledProcessError as error:
            print(f"{study}: {error.stderr.decode().strip()}", flush=True)
            return None
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


KINDS = ["rigid", "bilinear", "mixed", "power"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("studies", nargs="*")
    parser.add_argument("--program", default="build/ricochet")
    parser.add_argument("--steps", type=int, default=20)
    parser.add_argument("--range", type=float, nargs=2, default=(0.01, 1), metavar=("SMALLEST", "LARGEST"))
    parser.add_argument("--random", type=int, default=0)
    parser.add_argument("--kinds", nargs="+", default=KINDS, choices=KINDS)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--limit", type=float, help="seconds for one run")
    parser.add_argument("--keep", help="folder for the random studies")
    args = parser.parse_args()
    smallest, largest = args.range
    steps = [smallest * (largest / smallest) ** (i / max(1, args.steps - 1)) for i in range(args.steps)]
    studies = args.studies or ([] if args.random else sorted(glob.glob("examples/*/study.yaml")))
    counts, same = collections.Counter(), True
    with tempfile.TemporaryDirectory() as folder:
        for i in range(args.random):
            kind = args.kinds[i % len(args.kinds)]
            path = os.path.join(args.keep or folder, f"random-{kind}-{args.seed}-{i}.yaml")
            with open(path, "w") as out:
                out.write(random_study(random.Random(f"{args.seed} {i} {kind}"), kind))
            studies.append(path)
        for study in studies:
            result = compare(args.program, study, steps, folder, args.limit)
            counts[result] += 1
            same &= result is not False
    print(f"{len(studies)} studies: {counts[True]} the same, {counts[False]} with differences, {counts[None]} not compared")
    return 0 if same else 1


if __name__ == "__main__":
    sys.exit(main())
