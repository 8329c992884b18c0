"""The same study with other steps, another order of its modes and contacts, or two workers: the same atlas is asked for."""
import copy
import os
import re
import subprocess

import numpy as np

import said
from judge import Atlas
from shared import Curves, shared

BESIDE = 1e-3  # relative: of the largest frequency of a branch, where a junction may have a larger one than the points beside it


def _run(program, study, folder, name, limit, *more):
    import json

    path, atlas = os.path.join(folder, f"{name}.yaml"), os.path.join(folder, f"{name}.ricochet")
    with open(path, "w", encoding="utf-8") as file:
        json.dump(study, file)
    try:
        out = subprocess.run([program, "run", path, "-o", atlas, *more], capture_output=True, text=True, timeout=limit, check=False)
    except subprocess.TimeoutExpired:
        return None
    return atlas if out.returncode == 0 else out.returncode


def curves_of(program, path, model):
    """An atlas with what the report says of its places: energies are matched to that and to nothing else."""
    return Curves(Atlas(path), model, said.read(program, path))


def _letters(word):
    """A word up to what numbers of contacts, images and readings change: the kinds of its events only, with their number."""
    return len(re.findall(r"[0-9a-z]", word.replace("-", ""))), word.count("-")


def _largest(curves, branch):
    """Energy and frequency, of the points of a branch and of the junctions that it passes, beside which no points are kept. A junction is
    drawn at the frequency of the longer period where they multiply, which the branch may not have."""
    energy, frequency = branch["energy_max"], branch["frequency_max"]
    for j in (curves.junctions[r["junction"]] for r in curves.atlas.on_branch[branch["id"]]):
        energy = max(energy, j["energy"])
        frequency = max([frequency, *(f for f in (j["frequency"], j["frequency"] * j["multiple"])
                                      if abs(f - frequency) <= BESIDE * frequency)])
    return energy, frequency


def _rows(curves):
    """Kind, letters, grazings or impacts, multiple; energy, frequency; label, id; and to what the report has the two known."""
    atlas, said_of = curves.atlas, curves.said
    junctions = [(j["kind"], _letters(j["word"]), j["grazings"], j["multiple"], j["energy"], j["frequency"], j["label"],
                  j["id"], said_of.of_junction(j["id"], _passes(atlas, j["id"]), j["energy"]), said_of.frequency(j["id"]))
                 for j in atlas.junctions]
    ends = [(("branch", b["symmetric"], b["reversible"]), _letters(b["word"]), b["impacts"], 0, *_largest(curves, b),
             b["label"], b["id"], said_of.of_ends(b["id"], b["energy_max"], (b["from_junction"], b["to_junction"])),
             said_of.frequency(b["from_junction"], b["to_junction"])) for b in atlas.branches]
    return junctions + ends


def _is_one(one, row, other, candidate):
    """Whether energies and frequencies agree to what is known of them; the largest of a branch may also be read off anywhere beside
    a turn that either report has without a junction."""
    for i, quantity in ((4, "energy"), (5, "frequency")):
        to = max(row[i + 4], candidate[i + 4])
        a, b = row[i], candidate[i]
        turned = isinstance(row[0], tuple) and (one.said.may_be(row[7], quantity, a, b) or
                                                other.said.may_be(candidate[7], quantity, a, b))
        if not turned and abs(a - b) > to * max(abs(a), abs(b)) + 1e-12:
            return False
    return True


def missing(one, other):
    """Rows of the curves `one` that `other` lacks, each row used once."""
    left, lost = _rows(other), []
    for row in _rows(one):
        for i, candidate in enumerate(left):
            if row[:4] == candidate[:4] and _is_one(one, row, other, candidate):
                del left[i]
                break
        else:
            lost.append(row)
    return lost


UNPLACED = re.compile(r"([a-z][a-z -]*?)(?: (\d+)/(\d+))? at E (\S+) omega ([^\s,)]+)")
RANGE = r".*?\(E (\S+) to ([^\s)]+)\)"
LOST = re.compile("multipliers are lost in rounding" + RANGE)
CROWDED = re.compile("events on it may lie closer together" + RANGE)
KINDS = {"period extremum": "period-extremum", "branch point": "branch-point", "asked-for value": "user"}


def gaps(curves):
    """What an atlas says may be missing: (kinds or None for all, multiple or 0, least and largest energy, branch). An event that
    did not converge is said where it was seen: it lies within that step of the branch or beside it."""
    out = []
    for b in curves.atlas.branches:
        for clause in (b["why"] or "").split("; "):
            if "not converge to a junction (" in clause:
                for kind, _, q, energy, _ in UNPLACED.findall(clause[clause.index("junction (") + 9:]):
                    out.append((kind.strip(), int(q or 0), *curves.step_around(b["id"], float(energy)), b["id"]))
            for pattern, kind in ((LOST, "multiplication"), (CROWDED, None)):
                found = pattern.search(clause)
                if found:
                    out.append((kind, 0, float(found[1]), float(found[2]), b["id"]))
    return out


def _is_kind(said, kind):
    """At a multiplication all functions vanish: what did not converge there may have been taken for a branch point."""
    return said in (None, "event") or kind == KINDS.get(said, said) or (said, kind) == ("branch point", "multiplication")


def _passes(atlas, junction):
    """The branches that a junction lies on."""
    on = {b for b, rows in atlas.on_branch.items() if any(r["junction"] == junction for r in rows)}
    return on | {b["id"] for b in atlas.branches if junction in (b["from_junction"], b["to_junction"])}


def _whole_times(atlas, junction, same):
    """The junctions of which one that no branch meets is made by going through them several times."""
    mine = next(j for j in atlas.junctions if j["id"] == junction)
    return [j["id"] for j in atlas.junctions if j["kind"] == mine["kind"] and j["id"] != junction and
            abs(j["energy"] - mine["energy"]) <= same * mine["energy"] and
            abs(j["frequency"] / mine["frequency"] - round(j["frequency"] / mine["frequency"])) <= same]


class Naming:
    """What of the rows of `one` that `other` lacks is named by `other`, or by `one` itself where it says that of its own."""

    def __init__(self, one, other):
        self.one, self.other, self.same = one, other, max(one.said.same, other.said.same)
        self.said = [(one, g) for g in gaps(one)] + [(other, g) for g in gaps(other)]
        self.stuck = [(c, b["id"]) for c in (one, other) for b in c.atlas.branches if b["stop"] == "failed"]
        self.ends = {b["id"]: {b["from_junction"], b["to_junction"]} - {None} for b in one.atlas.branches}
        self.kept = {}

    def is_one(self, branch, curves, other):
        key = branch, curves is self.one, other
        if key not in self.kept:
            self.kept[key] = (branch == other) if curves is self.one else shared(self.one, branch, curves, other)
        return self.kept[key]

    def refused(self, junction):
        """Whether departures from that junction are refused in the other atlas, which is said with its place."""
        mine = next(j for j in self.one.atlas.junctions if j["id"] == junction)
        return any(j["refused"] and j["kind"] == mine["kind"] and
                   all(abs(j[k] - mine[k]) <= self.same * abs(mine[k]) for k in ("energy", "frequency"))
                   for j in self.other.atlas.junctions)

    def branch(self, row, absent, lost):
        met = self.ends[row[7]] | {r["junction"] for r in self.one.atlas.on_branch[row[7]]}
        return (row[7] in self.one.said.along or bool(self.ends[row[7]] & absent) or
                (bool(met & absent) and self.ends[row[7]] <= lost) or any(self.refused(j) for j in met) or
                any(self.is_one(row[7], curves, b) for curves, b in self.stuck))

    def junction(self, row, absent):
        if row[7] in self.one.said.open:
            return True
        on, kinds = _passes(self.one.atlas, row[7]), {row[0]}
        if not on:  # where a multiplication is looked for at the end of a branch
            on, kinds = {b for j in _whole_times(self.one.atlas, row[7], self.same) for b in _passes(self.one.atlas, j)}, {row[0], "multiplication"}
        return bool(on & absent) or any(
            curves.beyond(b, row[4]) and any(self.is_one(mine, curves, b) for mine in on) for curves, b in self.stuck) or any(
            any(_is_kind(kind, k) for k in kinds) and q in (0, row[3]) and low <= row[4] <= high and any(self.is_one(b, curves, branch) for b in on)
            for curves, (kind, q, low, high, branch) in self.said)


def unnamed(lost, naming):
    """Rows that are lost without either atlas saying so: a gap of that kind has to hold the place, on the same branch by the
    orbits that both hold, or the report lists the junction as one whose label is not decided. What hangs on a row that is missing
    by name, and on nothing else, is missing with it."""
    left, branches, junctions, changed = list(lost), set(), set(), True
    gone = {row[7] for row in lost if not isinstance(row[0], tuple)}
    while changed:
        changed = False
        for row in list(left):
            whole = isinstance(row[0], tuple)
            if naming.branch(row, junctions, gone) if whole else naming.junction(row, branches):
                left.remove(row)
                (branches if whole else junctions).add(row[7])
                changed = True
    return left


def differ(one, other):
    """(rows that the curves `other` lack, rows that they have beyond, those of both that nobody names)."""
    lost, new = missing(one, other), missing(other, one)
    return lost, new, unnamed(lost, Naming(one, other)) + unnamed(new, Naming(other, one))


def variants(program, study, base_path, folder, which, limit):
    findings, named = [], []
    base = curves_of(program, base_path, study["model"])
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
        lost, more_rows, unsaid = differ(base, curves_of(program, atlas, other["model"]))
        if lost or more_rows:
            shown = unsaid or lost + more_rows
            text = f"{len(lost)} rows lost, {len(more_rows)} new, {len(unsaid)} of them not named: " + "; ".join(
                f"{'-' if row in lost else '+'} {row[0] if isinstance(row[0], str) else row[0][0]} {row[6]} E={row[4]:.9g} "
                f"w={row[5]:.9g}" for row in shown[:6])
            (findings if unsaid else named).append({"kind": f"other atlas, {name.split()[0]}", "where": name,
                                                    "text": text})
    if "workers" in which:
        atlas = _run(program, study, folder, "workers", limit, "-j", "2")
        if atlas is not None and (isinstance(atlas, int) or Atlas(atlas).meta.get("digest") != base.atlas.meta.get("digest")):
            findings.append({"kind": "other atlas, workers", "where": "-j 2", "text": "another digest"})
    return findings, named
