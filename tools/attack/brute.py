"""Orbits the atlas lacks: all that the judge finds at a few energies have to be in the atlas, or what leaves them out has a name.

An orbit that is found (search.py) and is on no stored branch (stored.py) is followed to both ends of its family (follow.py). It is
excused if the family meets a junction of which departures are beyond a budget or refused, a corner, or none at all: an island, which
`ricochet hunt` has to list where it can, between rigid stops that see two modes. A family that meets a junction of which nothing
is left, or a stored branch where it has no junction, is lost."""
import collections
import json
import os
import subprocess
import sys
import tempfile

import numpy as np

import follow
import search
import stored
import structures
from judge import Atlas
from structure import Structure

PARTS = (0.35, 0.8)  # of the upper end of the window: where is looked
MOST = 4  # impacts
FOLLOWED = 6  # orbits of one energy that are followed
FREE = 1e-6  # of the largest: a squared frequency that counts as none
LONG = 120  # s for one hunt
NAMED = ("budget", "corner", "named")  # reasons for which the report names a place
CONTINUUM = 1e-10  # second smallest singular value: orbits of one energy are not isolated, as of bodies that do not feel each other
SEEN = 1e-7  # relative: hunt's orbit and the judge's
PASSES = 1e-5  # the same: a stored branch beside an end
HUNTED = ("--lines", "4000", "--rows", "40", "--row", "600", "--random", "50000")


def suits(model):
    """The structure, None if it has not two or three modes that are held and that contacts see."""
    if model["contacts"][0]["law"] == "power":
        return None
    s = Structure(model)
    return s if s.n in search.STARTS and float(s.lam.min()) > FREE * s.omega_ref**2 else None


class Exclusion:
    """What is found of one atlas: counts by reason, and findings (kind, where, text)."""

    def __init__(self, program, study, path, file, seed):
        self.program, self.study, self.path, self.file = program, study, path, file
        self.s, self.atlas = suits(study["model"]), Atlas(file)
        self.rng = np.random.default_rng(seed)
        self.counts, self.findings = collections.Counter(), []
        self.bounds = study["explore"]
        self.most = min(MOST, self.bounds["impacts"])

    def run(self, parts=PARTS):
        for part in parts:
            self._at(self.bounds["energy"][1] * part)
        return self

    def _at(self, energy):
        s, (low, high) = self.s, self.bounds["frequency"]
        scaled, longest = energy / s.omega_ref**2, 2 * np.pi / low * s.omega_ref
        found = search.orbits_at(s, scaled, self.most, longest, self.rng)
        found = [o for o in found if low < self._frequency(o) < high]
        have = [o for _, o in stored.at(s, self.atlas, scaled, self.most)]
        self.counts["brute orbits"] += len(found)
        self.counts["brute in the atlas"] += sum(any(o.same(h) for h in have) for o in found)
        self.counts["brute not found of the atlas"] += sum(not any(o.same(h) for o in found) for h in have)
        lacks = [o for o in found if not any(o.same(h) for h in have)]
        self.counts["brute not looked into"] += max(0, len(lacks) - FOLLOWED)
        told = self._hunt(energy) if lacks and self._hunts() else None
        for orbit in lacks[:FOLLOWED]:
            self._lacking(orbit, energy, told)

    def _frequency(self, orbit):
        return 2 * np.pi * self.s.omega_ref / orbit.period

    def _hunts(self):
        return self.s.n == 2 and all(f.spring == 0 for f in self.s.faces)

    def _hunt(self, energy):
        """What the program itself finds at that energy; None where it does not hunt."""
        command = [self.program, "hunt", self.path, "--atlas", self.file, "--energy", repr(energy), "--impacts", str(self.most)]
        try:
            out = subprocess.run([*command, *HUNTED, "--json"], capture_output=True, text=True, timeout=LONG, check=False)
        except subprocess.TimeoutExpired:
            self.counts["brute hunt too long"] += 1
            return None
        return json.loads(out.stdout) if out.returncode in (0, 1) and out.stdout.strip() else None

    def _lacking(self, orbit, energy, told):
        if orbit.chain.singular()[1][0][-2] < CONTINUUM:
            self.counts["brute continua"] += 1
            return
        omega = self._frequency(orbit)
        where = f"energy {energy!r} frequency {omega!r} events {orbit.letters()}"
        why, text = self._why(orbit)
        if told is not None:
            hunted = [t for t in told if t["impacts"] == orbit.impacts and abs(t["frequency"] - omega) <= SEEN * omega]
            if not hunted:
                self.counts["brute not found by hunt"] += 1
                if why == "isolated":
                    self._find("hunt", where, "an island that hunt does not list")
            elif why not in NAMED and all(t["atlas"] in ("known", "unexplained") for t in hunted):
                self._find("lost orbit", where, f"hunt: {hunted[0]['atlas']}; {text}")
                return
            elif why == "lost":
                self.counts[f"brute {hunted[0]['atlas']} by hunt"] += 1
                return
        self.counts[f"brute {why}"] += 1
        if why == "lost":
            self._find("lost orbit", where, text)

    def _find(self, kind, where, text):
        self.findings.append({"kind": kind, "where": where, "text": text})

    def _why(self, orbit):
        """(reason, text) why the atlas lacks an orbit."""
        ends = follow.ends(orbit, self.bounds["energy"], self.bounds["frequency"])
        met = [(end, j) for end in ends for j in follow.junctions(self.atlas, end, 1)]
        for end, j in met:
            if j["over_budget"] or j["refused"] or j["kind"] == "corner":
                return ("corner" if j["kind"] == "corner" else "budget"), f"junction {j['id']} {j['label']}"
        if met:
            end, j = met[0]
            return "lost", f"its family meets junction {j['id']} {j['label']} ({end.what}), of which nothing is left out"
        for end in ends:
            for k in range(2, self.bounds["multiply"] + 1):  # multiples of a junction without a row of their own
                for j in follow.junctions(self.atlas, end, k):
                    if j["over_budget"] or j["refused"]:
                        return "budget", f"{k} times junction {j['id']} {j['label']}"
            passed = self._passed(end)
            if passed:
                return passed
        if any(end.what in ("not followed", "long") for end in ends):
            return "not followed", ""
        return "isolated", ""

    def _passed(self, end):
        """Of an end on a stored branch that has no junction there."""
        if end.what != "touch":
            return None
        for k in range(1, self.bounds["multiply"] + 1):
            for beside in (1 - 1e-7, 1 + 1e-7):
                for id_, o in stored.at(self.s, self.atlas, end.energy * beside / self.s.omega_ref**2, self.most):
                    if abs(self._frequency(o) - k * end.frequency) < PASSES * end.frequency:
                        branch = next(b for b in self.atlas.branches if b["id"] == id_)
                        if 0 < self.bounds["depth"] <= branch["depth"]:
                            return "budget", f"branch {id_} {branch['label']} is as deep as is asked for"
                        text = f"its family ends on branch {id_} {branch['label']} at energy {end.energy!r}, where no junction is"
                        return ("named", text) if "may be missing" in branch["why"] else ("lost", text)
        return None


def main():
    """By itself: program, first seed, number of structures."""
    program, seed, count = os.path.abspath(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])
    done, bad, sums = 0, 0, collections.Counter()
    with tempfile.TemporaryDirectory() as folder:
        while done < count:
            kind, text, study = structures.make(seed, None, True)
            path, file = os.path.join(folder, f"{seed}.yaml"), os.path.join(folder, f"{seed}.ricochet")
            if kind != "power" and suits(study["model"]) is not None:
                with open(path, "w", encoding="utf-8") as out:
                    json.dump(study, out)
                ran = subprocess.run([program, "run", path, "-o", file], capture_output=True, timeout=300, check=False)
                if ran.returncode == 0:
                    done += 1
                    result = Exclusion(program, study, path, file, seed).run()
                    sums.update(result.counts)
                    bad += len(result.findings)
                    print(f"seed {seed} {kind}: {text}: {dict(result.counts)}", flush=True)
                    for f in result.findings:
                        print(f"    {f['kind']}: {f['where']}: {f['text']}", flush=True)
            seed += 1
    print(f"{bad} findings; {dict(sums)}")
    return 1 if bad else 0


if __name__ == "__main__":
    np.seterr(all="ignore")
    sys.exit(main())
