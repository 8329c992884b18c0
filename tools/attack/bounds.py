"""Errors of multipliers over the bounds that the library states of them, on random structures.

    ATTACK_PART=bounds tools/attack/attack LIBRARY PROGRAM KIND [STRUCTURES [SEED [POINTS]]]

LIBRARY is build/src/libricochet.so, PROGRAM build/ricochet. Orbits are asked of the library with their multipliers and the bound
(ric_orbit_multiplier_error); the same orbit, from its state and flights, is polished in long doubles and its multipliers made there,
and in 50 digits where moving it within the rounding of long doubles says that those do not suffice. Exit status 1: a ratio above 1.
"""
import ctypes as C
import json
import os
import subprocess
import sys
import tempfile

import numpy as np

import arithmetic as ar
import judge
import orbits
import smooth
import structures


def library(path):
    lib = C.CDLL(os.path.abspath(path))
    lib.ric_orbit_multiplier_error.restype = C.c_double
    lib.ric_orbit_find.argtypes = [C.c_void_p, C.c_int, C.c_int, C.c_double, C.POINTER(C.c_int), C.POINTER(C.c_void_p)]
    for name in ("ric_orbit_multiplier_error", "ric_orbit_letters"):
        getattr(lib, name).argtypes = [C.c_void_p]
    lib.ric_orbit_multipliers.argtypes = [C.c_void_p, C.c_void_p]
    lib.ric_orbit_data.argtypes = [C.c_void_p] * 5
    lib.ric_orbits_free.argtypes = [C.c_int, C.c_void_p]
    lib.ric_atlas_free.argtypes = [C.c_void_p]
    return lib


def ask(lib, atlas, branch, point, n):
    """State, flights, rho [n - 1] and bound of a stored point, asked again; None if the library has none."""
    count, out = C.c_int(), C.c_void_p()
    if lib.ric_orbit_find(atlas, branch, 0, float(point), C.byref(count), C.byref(out)) or count.value < 1:
        return None
    orbit = C.cast(out, C.POINTER(C.c_void_p))[0]
    state, flights, z = np.zeros(64), np.zeros(max(lib.ric_orbit_letters(orbit), 1)), np.zeros(256)
    lib.ric_orbit_data(orbit, None, state.ctypes.data, flights.ctypes.data, None)
    lib.ric_orbit_multipliers(orbit, z.ctypes.data)
    error = lib.ric_orbit_multiplier_error(orbit)
    lib.ric_orbits_free(count.value, out)
    pairs = z[:4 * (n - 1)].reshape(-1, 4)
    return state, flights, pairs[:, 0] + 1j * pairs[:, 1] + pairs[:, 2] + 1j * pairs[:, 3], error


def exactly(j, word, row):
    chain, _, _ = j.chain_of(word, [row], j.exact())
    chain, _ = orbits.polish_finely(chain)
    return j._rho(chain)[0] if chain.relative_residual()[0] < 1e-35 else None


def reference(j, word, row, enough):
    """rho of the orbit, and whether it is known to `enough`."""
    if j.s.power:
        u, w, _ = j.s.from_stored(judge.floats(row["state"])[None, :])
        T = ar.array(np.array([row["flights_sum"]]), False) * j.s.omega_ref
        X = smooth.integrate(j.s, u, w, T)[2]
        return j._power_rho(u, w, X, False)[0], j._power_rho(*j._power_shaken(u, w, T, 3e-19), False)[0]
    chain, _, _ = j.chain_of(word, [row])
    fine, _ = orbits.polish(chain)
    rho, again = j._rho(fine)[0], j._rho(j._shaken(fine, 3e-19))[0]
    if not np.abs(rho - again).max() <= enough:
        exact = exactly(j, word, row)
        if exact is not None:
            return exact, exact
    return rho, again


def off(right, rho):
    return max(np.abs(right - x).min() for x in rho if np.isfinite(x))


def one(lib, program, seed, kind, points, rng, ratios, unknown):
    kind, _, study = structures.make(seed, kind, True)
    with tempfile.TemporaryDirectory() as folder:
        path, out = os.path.join(folder, "s.yaml"), os.path.join(folder, "a.ricochet")
        with open(path, "w", encoding="utf-8") as file:
            json.dump(study, file)
        try:
            if subprocess.run([program, "run", path, "-o", out], capture_output=True, timeout=60, check=False).returncode:
                return
        except subprocess.TimeoutExpired:
            return
        table, handle = judge.Atlas(out), C.c_void_p()
        if lib.ric_atlas_read(out.encode(), C.byref(handle)):
            return
        j = judge.Judge(study["model"], table)
        places = [(b, row["point"]) for b in table.branches if b["word"] or j.s.power for row in table.points[b["id"]]]
        ends = [p for p in places if p[1] in (0, p[0]["points"] - 1)]
        chosen = [places[i] for i in rng.choice(len(places), min(points, len(places)), replace=False)] if places else []
        chosen += [ends[i] for i in rng.choice(len(ends), min(points // 4, len(ends)), replace=False)] if ends else []
        for branch, point in chosen:
            if not branch["impacts"] and not j.s.power:
                continue
            asked = ask(lib, handle, branch["id"], point, j.s.n)
            if asked is None or j.s.n < 2 or not np.isfinite(asked[2]).any():
                unknown.append((seed, branch["id"], point))
                continue
            state, flights, rho, error = asked
            row = {"state": state[:2 * len(study["model"]["mass"])].tobytes(), "flights": flights.tobytes(),
                   "flights_sum": flights.sum(), "point": point}
            with np.errstate(all="ignore"):
                right, again = reference(j, branch["word"], row, error / 10)
            if not np.abs(right - again).max() <= error / 10:
                unknown.append((seed, branch["id"], point))
                continue
            if off(right, rho) > error and not j.s.power:  # where pairs all but meet long doubles may agree on what is wrong
                exact = exactly(j, branch["word"], row)
                right = right if exact is None else exact
            worst = off(right, rho)
            ratios.append((worst / error, seed, branch["id"], point, error))
        lib.ric_atlas_free(handle)


def main():
    lib, program, kind = library(sys.argv[1]), sys.argv[2], sys.argv[3]
    count, seed, points = (int(x) for x in (sys.argv[4:] + ["40", "1", "12"][len(sys.argv) - 4:])[:3])
    rng, ratios, unknown = np.random.default_rng(seed), [], []
    for s in range(seed, seed + count):
        one(lib, program, s, kind, points, rng, ratios, unknown)
    if not ratios:
        sys.exit(f"{kind}: no orbit was compared")
    r = np.array([x[0] for x in ratios])
    for worst in sorted(ratios, reverse=True)[:8]:
        print("ratio %.3g at seed %d, branch %d, point %d, bound %.2g" % worst)
    print(f"{kind}: {len(r)} orbits, {len(unknown)} without multipliers or a reference; error over bound: "
          f"median {np.median(r):.2g}, nine in ten {np.quantile(r, 0.9):.2g}, largest {r.max():.2g}")
    sys.exit(bool((r > 1).any()))


if __name__ == "__main__":
    main()
