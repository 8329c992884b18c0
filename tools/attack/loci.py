"""Junctions that are followed while a parameter changes random structures, judged at each value as those of an atlas are.

`ricochet locus` follows junctions of a random structure, of which stiffness, masses or clearances change by chance. Ends of the curves
and points drawn by chance are judged on the structure that belongs to their value, made of the study's matrices here: the orbit solves its equations,
no stop is passed, energy and frequency are those of matrices and flights, and what makes it a junction holds there (judge.py). A curve
of a study without impacts is that of a linear mode: its frequency is one of the structure there, and the motion touches.

    ATTACK_PART=loci tools/attack/attack build/ricochet KIND STRUCTURES SEED [POINTS]
"""
import collections
import copy
import json
import os
import subprocess
import sys
import tempfile

import numpy as np

import judge
import structures

LIMIT = 60  # s of a run, and of a curve
CURVES = 6  # of a structure, of all kinds of junctions in turn
FAR = 1e-9  # frequency or touch of a linear mode


class Alone:
    """An atlas of nothing."""

    def __init__(self):
        self.branches, self.junctions, self.points, self.on_branch = [], [], {}, {}


def varied(rng, study):
    """The study with a section `vary`, whose parameter goes from 0.7 to 1.3 about the structure at 1."""
    study = copy.deepcopy(study)
    model, what = study["model"], rng.choice(["stiffness", "mass", "clearance"])
    vary = {"name": "p", "at": 1, "from": 0.7, "to": 1.3}
    if what == "clearance":
        vary["clearance"] = [float(c["clearance"] * rng.choice([0, 0.5, 1])) if i else c["clearance"] * 0.5
                             for i, c in enumerate(model["contacts"])]
    else:
        n = len(model["mass"])
        b = np.zeros(n)
        i, j = rng.integers(n), rng.integers(n)
        b[i] += 1
        b[j] -= i != j
        size = float(np.diag(np.array(model[what])).min()) * 0.4
        vary[what] = (size * np.outer(b, b)).tolist()
    study["vary"] = vary
    return study, str(what)


def model_at(study, value):
    model, vary = copy.deepcopy(study["model"]), study["vary"]
    by = value - vary["at"]
    for name in ("mass", "stiffness"):
        if name in vary:
            model[name] = (np.array(model[name]) + by * np.array(vary[name])).tolist()
    for contact, slope in zip(model["contacts"], vary.get("clearance", [])):
        contact["clearance"] += by * slope
    return model


def call(command):
    out = subprocess.run(command, capture_output=True, text=True, timeout=4 * LIMIT, check=False)
    return out.returncode, out.stdout, out.stderr


def chosen(rng, junctions):
    """Some junctions, of each kind one after the other."""
    kinds = collections.defaultdict(list)
    for j in rng.permutation(len(junctions)):
        kinds[junctions[j]["kind"]].append(junctions[j])
    out = []
    while len(out) < CURVES and any(kinds.values()):
        out += [kinds[k].pop() for k in sorted(kinds) if kinds[k]]
    return out[:CURVES]


def linear(study, row):
    """What is wrong with a point on the curve of a linear mode, or nothing."""
    model = model_at(study, row["value"])
    M, K = np.array(model["mass"], float), np.array(model["stiffness"], float)
    L = np.linalg.inv(np.linalg.cholesky(M))
    omega = np.sqrt(np.maximum(np.linalg.eigvalsh(L @ K @ L.T), 0))
    if np.abs(omega - row["frequency"]).min() > FAR * row["frequency"]:
        return "no frequency of the structure"
    x, v = np.split(np.array(row["state"]), 2)
    d = model["contacts"][0]["clearance"]
    reach = max(np.hypot(np.dot(c["normal"], x), np.dot(c["normal"], v) / row["frequency"]) * d / c["clearance"] for c in model["contacts"])
    return "" if abs(reach - 1) < FAR else f"the mode opens a gap to {reach!r}"


def as_stored(row, junction):
    """A point of a curve as the row of a junction, of the orbit gone through once."""
    return {"id": junction["id"], "label": f"{junction['kind']} at {row['value']!r}", "kind": junction["kind"], "word": junction["word"],
            "energy": row["energy"], "frequency": row["frequency"], "multiple": 1,
            "state": np.array(row["state"]).tobytes(), "flights": np.array(row["flights"]).tobytes(),
            "rotation_p": junction["rotation_p"], "rotation_q": junction["rotation_q"]}


def one(program, seed, kind, points, counts):
    rng = np.random.default_rng([seed, 1])  # not that of the structure
    kind, text, study = structures.make(seed, kind, True)
    study, what = varied(rng, study)
    findings = []
    with tempfile.TemporaryDirectory() as folder:
        path, out = os.path.join(folder, "s.yaml"), os.path.join(folder, "a.ricochet")
        with open(path, "w", encoding="utf-8") as file:
            json.dump(study, file)
        code, _, said = call([program, "run", path, "-o", out, "--seconds", str(LIMIT)])
        if code not in (0, 3):
            counts["refused"] += 1
            return findings
        counts["structures"] += 1
        for junction in chosen(rng, judge.Atlas(out).junctions):
            code, curve, said = call([program, "locus", out, "--junction", str(junction["id"]), "--max-step", "0.1", "--json"])
            if code:
                counts["curves refused" if said.strip() else "curves without a word"] += 1
                if code not in (1, 2) or not said.strip():
                    findings.append(f"junction {junction['id']}: exit {code}: {said[-200:]}")
                continue
            rows = json.loads(curve)
            counts["curves"] += 1
            counts[f"curves of kind {junction['kind']}"] += 1
            for i in sorted({0, len(rows) - 1, *rng.choice(len(rows), min(points, len(rows)), replace=False)}):
                findings += judged(study, rows[i], junction, counts)
    return [f"{kind}: {text}, {what}: {f}" for f in findings]


def judged(study, row, junction, counts):
    counts["points"] += 1
    if not junction["word"] and study["model"]["contacts"][0]["law"] != "power":  # there no word says so
        wrong = linear(study, row)
        return [f"junction {junction['id']} at {row['value']!r}: {wrong}"] if wrong else []
    alone = Alone()
    alone.junctions = [as_stored(row, junction)]
    verdict = judge.Judge(model_at(study, row["value"]), alone).run()
    return [f"{f['kind']}: {f['where']}: {f['text']} ({row['mark'] or 'between'}: {row['what'][:80]})" for f in verdict.findings]


def main():
    if len(sys.argv) < 5:
        sys.exit(__doc__)
    program, kind = os.path.abspath(sys.argv[1]), sys.argv[2]
    count, seed, points = (int(x) for x in (sys.argv[3:] + ["12"])[:3])
    counts, wrong = collections.Counter(), 0
    for s in range(seed, seed + count):
        for finding in one(program, s, kind, points, counts):
            print(f"seed {s}: {finding}", flush=True)
            wrong += 1
    for name, value in sorted(counts.items()):
        print(f"{value:8} {name}")
    print(f"{kind}: {wrong} findings")
    sys.exit(bool(wrong))


if __name__ == "__main__":
    main()
