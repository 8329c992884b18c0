"""Orbits the atlas lacks: Newton's method from random starts at given energies, for two modes between rigid stops.

Every orbit found has to lie between two stored points of a branch with as many impacts, or `ricochet hunt` has to name why not."""
import collections
import json
import os
import subprocess
import sys
import tempfile

import numpy as np

import arithmetic as ar
import gaps
import structures
from judge import Atlas
from orbits import Chain
from structure import Structure

STARTS = 100  # per word and energy
MOST = 3  # impacts
NAMED = ("known", "budget", "window", "isolated")  # what hunt may say of an orbit the atlas lacks
ROUNDS = 20  # of Newton's method


def _words(faces):
    """Sequences of faces up to where they begin, without those that repeat themselves."""
    words = [()]
    for size in range(1, MOST + 1):
        for word in np.ndindex(*([len(faces)] * size)):
            turns = [word[i:] + word[:i] for i in range(size)]
            if word == min(turns) and turns.count(word) == 1:
                words.append(word)
    return words[1:]


def _starts(s, word, energy, rng):
    """States at the first stop with that energy, random in place and direction, and random times."""
    face, n = s.faces[word[0]], s.n
    c = ar.double(s.c[face.contact])
    u = rng.standard_normal((STARTS, n)) * np.sqrt(2 * energy / max(ar.double(s.lam).min() / s.omega_ref**2, 1e-3))
    u += ((face.side * float(face.limit) - u @ c) / (c @ c))[:, None] * c
    A = ar.double(s.A)
    room = 2 * energy - ((u @ A) * u).sum(axis=1)
    v = rng.standard_normal((STARTS, n))
    v *= np.where(face.side * (v @ c) > 0, -1, 1)[:, None]
    v *= np.sqrt(np.maximum(room, 0) / (v * v).sum(axis=1))[:, None]
    slow = np.sqrt(ar.double(s.lam).min()) / s.omega_ref
    tau = rng.uniform(0, 1, (STARTS, len(word))) * 3 * np.pi / slow
    keep = room > 0
    return [x[keep].astype(ar.LONG) for x in (u, v, tau)]


def _normal_equations(J, off):
    square = np.einsum("pji,pjk->pik", J, J)
    square += 1e-14 * np.trace(square, axis1=1, axis2=2)[:, None, None] * np.eye(J.shape[2])
    return np.linalg.solve(square, np.einsum("pji,pj->pi", J, off)[:, :, None])[:, :, 0]


def _step(chain, energy, solve):
    """One of Newton's steps, no longer than a half."""
    s = chain.s
    off = np.concatenate([chain.residual(), (s.energy(frozenset(), chain.u, chain.v) - energy)[:, None]], axis=1)
    slope = np.concatenate([chain.u @ s.A, chain.v, chain.tau * 0], axis=1)[:, None, :]
    J, off = ar.double(np.concatenate([chain.jacobian(), slope], axis=1)), ar.double(off)
    sound = np.isfinite(J).all(axis=(1, 2)) & np.isfinite(off).all(axis=1)
    step = np.zeros((len(off), J.shape[2]))
    step[sound] = solve(J[sound], off[sound])
    size = np.abs(step).max(axis=1, keepdims=True)
    return chain.moved(-(step / np.maximum(1, 2 * size)).astype(ar.LONG))


def solutions(s, word, energy, rng):
    """The admissible orbits that Newton's method finds."""
    u, v, tau = _starts(s, word, energy, rng)
    if not len(u):
        return []
    chain = Chain(s, [(f, "hit") for f in word], frozenset(), u, v, tau)
    for _ in range(ROUNDS):
        chain = _step(chain, energy, _normal_equations)
    near = chain.relative_residual() < 1e-4
    if not near.any():
        return []
    chain = Chain(s, chain.events, frozenset(), chain.u[near], chain.v[near], chain.tau[near])
    for _ in range(3):
        chain = _step(chain, energy, lambda J, off: np.einsum("pij,pj->pi", np.linalg.pinv(J, rcond=1e-12), off))
    sized = np.abs(ar.double(s.energy(frozenset(), chain.u, chain.v)) / energy - 1)
    speeds = np.min([ar.double(x) for x in chain.speed], axis=0)
    good = (chain.relative_residual() < 1e-13) & (sized < 1e-12) & (speeds > 1e-6) & (ar.double(chain.tau).min(axis=1) > 1e-6)
    if not good.any():
        return []
    chain = Chain(s, chain.events, frozenset(), chain.u[good], chain.v[good], chain.tau[good])
    reach = gaps.Reach(chain).worst()
    periods = ar.double(chain.tau).sum(axis=1) / s.omega_ref
    out = []
    for p in np.nonzero(reach < 1 - 1e-9)[0]:
        if not any(abs(periods[p] - t) < 1e-7 * t for t in out):
            out.append(float(periods[p]))
    return out


def known(atlas, size, energy, period):
    """Whether a branch with that many impacts passes that energy with that period, between two stored points."""
    for branch in atlas.branches:
        if branch["impacts"] != size:
            continue
        rows = atlas.points[branch["id"]]
        for a, b in zip(rows, rows[1:]):
            low, high = sorted((a["energy"], b["energy"]))
            short, long = sorted((a["period"], b["period"]))
            wide = 0.1 * (long - short) + 1e-6 * long
            if low * (1 - 1e-9) <= energy <= high * (1 + 1e-9) and short - wide <= period <= long + wide:
                return True
    return False


def one(program, seed, folder):
    """(what the structure is, orbits found, those the atlas lacks), None where the seed is of another kind."""
    rng = np.random.default_rng(seed)
    _, text, study = structures.make(seed, "rigid", True)
    s = Structure(study["model"])
    if s.n != 2 or float(s.lam.min()) < 1e-6 * s.omega_ref**2:
        return None
    path, file = os.path.join(folder, "study.yaml"), os.path.join(folder, "brute.ricochet")
    study["explore"].update(impacts=6, depth=2, multiply=2)
    with open(path, "w", encoding="utf-8") as out:
        json.dump(study, out)
    if subprocess.run([program, "run", path, "-o", file], capture_output=True, timeout=120, check=False).returncode:
        return None
    atlas, lacks, found = Atlas(file), [], 0
    band = study["explore"]["frequency"]
    for part in (0.35, 0.8):
        energy = study["explore"]["energy"][1] * part
        for word in _words(s.faces):
            for period in solutions(s, word, energy / s.omega_ref**2, rng):
                if not band[0] < 2 * np.pi / period < band[1]:
                    continue
                found += 1
                if not known(atlas, len(word), energy, period):
                    lacks.append((word, energy, 2 * np.pi / period))
    told = {e: _hunt(program, path, file, e) for e in {e for _, e, _ in lacks}}
    return text, found, [(word, e, omega, _reason(told[e], word, omega)) for word, e, omega in lacks]


def _hunt(program, path, file, energy):
    """What the program itself finds at that energy, and says of each orbit."""
    out = subprocess.run([program, "hunt", path, "--atlas", file, "--energy", repr(energy), "--impacts", str(MOST), "--random",
                          "50000", "--json"], capture_output=True, text=True, timeout=300, check=False)
    return json.loads(out.stdout) if out.returncode in (0, 1) and out.stdout.strip() else []


def _reason(told, word, omega):
    for orbit in told:
        if orbit["impacts"] == len(word) and abs(orbit["frequency"] - omega) <= 1e-7 * omega:
            return orbit["atlas"]
    return "not found by hunt"


def main():
    program, first, count = os.path.abspath(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])
    done, seed, bad, reasons = 0, first, 0, collections.Counter()
    with tempfile.TemporaryDirectory() as folder:
        while done < count:
            result = one(program, seed, folder)
            if result:
                done += 1
                text, found, lacks = result
                wrong = [x for x in lacks if x[3] not in NAMED]
                bad += len(wrong)
                reasons.update(x[3] for x in lacks)
                reasons["found"] += found
                print(f"seed {seed} {text}: {found} orbits, {len(lacks)} not in the atlas", flush=True)
                for word, energy, omega, why in wrong:
                    print(f"    {word} energy {energy!r} frequency {omega!r}: {why}", flush=True)
            seed += 1
    print(f"{bad} orbits without a reason; {dict(reasons)}")
    return 1 if bad else 0


if __name__ == "__main__":
    np.seterr(all="ignore")
    sys.exit(main())
