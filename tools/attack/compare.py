"""The same study with other steps, another order of its modes and contacts, or two workers: the same atlas is asked for."""
import copy
import os
import re
import subprocess

import numpy as np

from judge import Atlas, floats

SAME = 1e-7  # relative: energies and frequencies of junctions that are one
MATRICES = 16 * 2.2e-16  # of a squared frequency: what rounding of the matrices makes of it
ROUGHEST = 1e-4  # and of a place on a branch, at most, where two frequencies differ by little more


def _run(program, study, folder, name, limit, *more):
    import json

    path, atlas = os.path.join(folder, f"{name}.yaml"), os.path.join(folder, f"{name}.ricochet")
    with open(path, "w", encoding="utf-8") as file:
        json.dump(study, file)
    try:
        out = subprocess.run([program, "run", path, "-o", atlas, *more], capture_output=True, text=True, timeout=limit, check=False)
    except subprocess.TimeoutExpired:
        return None
    return Atlas(atlas) if out.returncode == 0 else out.returncode


def _letters(word):
    """A word up to what numbers of contacts, images and readings change: the kinds of its events only, with their number."""
    return len(re.findall(r"[0-9a-z]", word.replace("-", ""))), word.count("-")


def _rows(atlas):
    junctions = [(j["kind"], _letters(j["word"]), j["grazings"], j["multiple"], j["energy"], j["frequency"], j["label"],
                  j["id"]) for j in atlas.junctions]
    ends = [(("branch", b["symmetric"], b["reversible"]), _letters(b["word"]), b["impacts"], 0,
             b["energy_max"], b["frequency_max"], b["label"], b["id"]) for b in atlas.branches]
    return junctions + ends


def rounded(model):
    """To what the places on branches are known by the matrices: springs mix modes of nearly the same frequency at energies
    in proportion to their difference, and that is known to the rounding of the frequencies."""
    root = np.linalg.inv(np.linalg.cholesky(np.array(model["mass"], dtype=float)))
    squares = np.linalg.eigvalsh(root @ np.array(model["stiffness"], dtype=float) @ root.T)
    apart = np.diff(squares).min() / squares.max() if len(squares) > 1 else 1
    return min(max(SAME, MATRICES / max(apart, 1e-300)), ROUGHEST)


def missing(one, other, same=SAME):
    """Rows of `one` that `other` lacks, each row used once."""
    left, lost = list(_rows(other)), []
    for row in _rows(one):
        for i, candidate in enumerate(left):
            if row[:4] == candidate[:4] and all(abs(a - b) <= same * max(abs(a), abs(b)) + 1e-12
                                                for a, b in zip(row[4:6], candidate[4:6])):
                del left[i]
                break
        else:
            lost.append(row)
    return lost


PLACE = 1e-4  # relative: an event that did not converge is said where it was seen, which is not where it is
UNPLACED = re.compile(r"([a-z][a-z -]*?)(?: (\d+)/(\d+))? at E (\S+) omega ([^\s,)]+)")
RANGE = r".*?\(E (\S+) to ([^\s)]+)\)"
LOST = re.compile("multipliers are lost in rounding" + RANGE)
CROWDED = re.compile("events on it may lie closer together" + RANGE)
KINDS = {"period extremum": "period-extremum", "branch point": "branch-point", "asked-for value": "user"}


def gaps(atlas):
    """What an atlas says may be missing: (kinds or None for all, multiple or 0, least and largest energy, letters)."""
    out = []
    for b in atlas.branches:
        why, letters = b["why"] or "", _letters(b["word"])
        for clause in why.split("; "):
            if "not converge to a junction (" in clause:
                for kind, _, q, energy, _ in UNPLACED.findall(clause[clause.index("junction (") + 9:]):
                    e = float(energy)
                    out.append((kind.strip(), int(q or 0), e * (1 - PLACE), e * (1 + PLACE), letters))
            for pattern, kind in ((LOST, "multiplication"), (CROWDED, None)):
                found = pattern.search(clause)
                if found:
                    out.append((kind, 0, float(found[1]), float(found[2]), letters))
    return out


def _is_kind(said, kind):
    return said in (None, "event") or kind == KINDS.get(said, said)


def _passes(atlas, junction):
    """The branches that a junction lies on."""
    on = {b for b, rows in atlas.on_branch.items() if any(r["junction"] == junction for r in rows)}
    return on | {b["id"] for b in atlas.branches if junction in (b["from_junction"], b["to_junction"])}


def unnamed(lost, one, other):
    """Rows of `one` that `other` lacks without either saying so: a gap of that kind has to hold the place, on a branch
    of as many letters. What hangs on a junction that is missing by name, and on nothing else, is missing with it."""
    said = gaps(one) + gaps(other)
    words = {b["id"]: _letters(b["word"]) for b in one.branches}
    stuck = {_letters(b["word"]) for a in (one, other) for b in a.branches if b["stop"] == "failed"}
    left = list(lost)
    absent_branches, absent_junctions = set(), set()
    changed = True
    while changed:
        changed = False
        for row in list(left):
            branch = isinstance(row[0], tuple)
            if branch:
                ends = [b for b in one.branches if b["id"] == row[7]][0]
                touched = {ends["from_junction"], ends["to_junction"]} - {None}
                named = bool(touched & absent_junctions) or words[row[7]] in stuck
            else:
                on = _passes(one, row[7])
                named = bool(on & absent_branches) or any(
                    _is_kind(kind, row[0]) and q in (0, row[3]) and low <= row[4] <= high and
                    letters in {words[b] for b in on} for kind, q, low, high, letters in said)
            if named:
                left.remove(row)
                (absent_branches if branch else absent_junctions).add(row[7])
                changed = True
    return left


def variants(program, study, base_path, folder, which, limit):
    findings, named = [], []
    base = Atlas(base_path)
    same = rounded(study["model"])
    tries = []
    if "step" in which:
        for factor in (0.3, 3):
            other = copy.deepcopy(study)
            other["explore"]["step"] = 0.03 * factor
            tries.append((f"step x{factor}", other, ()))
    if "order" in which:
        other = copy.deepcopy(study)
        n = len(other["model"]["mass"])
        order = np.arange(n)[::-1]
        for key in ("mass", "stiffness"):
            other["model"][key] = np.array(other["model"][key])[np.ix_(order, order)].tolist()
        for contact in other["model"]["contacts"]:
            contact["normal"] = np.array(contact["normal"])[order].tolist()
        tries.append(("order", other, ()))
    for name, other, more in tries:
        atlas = _run(program, other, folder, re.sub(r"\W", "", name), limit, *more)
        if atlas is None or isinstance(atlas, int):
            if atlas is not None:
                findings.append({"kind": "other atlas", "where": name, "text": f"exit {atlas}"})
            continue
        lost, more_rows = missing(base, atlas, same), missing(atlas, base, same)
        if lost or more_rows:
            unsaid = unnamed(lost, base, atlas) + unnamed(more_rows, atlas, base)
            shown = unsaid or lost + more_rows
            text = f"{len(lost)} rows lost, {len(more_rows)} new, {len(unsaid)} of them not named: " + "; ".join(
                f"{'-' if row in lost else '+'} {row[0] if isinstance(row[0], str) else row[0][0]} {row[6]} E={row[4]:.9g} "
                f"w={row[5]:.9g}" for row in shown[:6])
            (findings if unsaid else named).append({"kind": f"other atlas, {name.split()[0]}", "where": name,
                                                    "text": text})
    if "workers" in which:
        atlas = _run(program, study, folder, "workers", limit, "-j", "2")
        if atlas is not None and (isinstance(atlas, int) or atlas.meta.get("digest") != base.meta.get("digest")):
            findings.append({"kind": "other atlas, workers", "where": "-j 2", "text": "another digest"})
    return findings, named
