"""Forced motions of random structures, flown by matrix exponentials.

`ricochet response` makes curves of motions under damping and a harmonic force. Points of them drawn by chance are flown anew: the state
(x, v, cos, sin, 1) goes through each phase of closed springs by one exponential, contacts are looked for on a grid of 0.08 rad of the
fastest mode and located by bisection. A motion has to return after its period, whatever it meets on the way, and its largest multiplier
is compared with that of differences, where three sizes of them agree, and the stability flag with both. It takes SciPy, too (Debian: python3-scipy).

    ATTACK_PART=forced tools/attack/attack build/ricochet KIND STRUCTURES SEED [POINTS]
"""
import json
import math
import os
import subprocess
import sys
import tempfile

import numpy as np
from scipy.linalg import expm

import structures

GRID = 0.08  # rad of the fastest mode or of the force, between two looks at the gaps
RETURN = 1e-9  # times the largest multiplier, relative to the motion
SLOW = 1e-4  # scaled speed of an impact below which the stored digits leave more open, in proportion
SIZES = (1e-7, 1e-8, 1e-9)  # of differences, relative
AGREE = 2e-4  # relative: differences that agree with each other, and with what is stored
LOST = 1e6  # multiplier of an orbit that has none stored
IMPACTS = 400  # of one period: more are none of a motion that was asked for
LIMIT = 60  # s


class Shaken:
    """A structure with damping and a force, in the numbers of its study."""

    def __init__(self, model, zeta, force, point):
        self.M, K = np.array(model["mass"], float), np.array(model["stiffness"], float)
        self.n, self.inverse = len(self.M), np.linalg.inv(self.M)
        root = np.linalg.inv(np.linalg.cholesky(self.M))
        lam, Q = np.linalg.eigh(root @ K @ root.T)
        MPhi = self.M @ root.T @ Q
        self.K, self.C = K, MPhi @ np.diag(2 * zeta * np.sqrt(np.maximum(lam, 0))) @ MPhi.T
        self.f, self.omega, self.restitution = point["level"] * np.array(force), point["omega"], point["restitution"]
        sides = {"both": (1, -1), "upper": (1,), "lower": (-1,)}
        self.faces = [(side * np.array(c["normal"], float), c["clearance"], c["law"] == "rigid", c.get("stiffness", 0.0))
                      for c in model["contacts"] for side in sides[c["sides"]]]
        self.phases = {}

    def phase(self, closed):
        """Matrix, step and map of a step while the springs in `closed` are."""
        if closed not in self.phases:
            n, K, b = self.n, self.K.copy(), np.zeros(self.n)
            for k in closed:
                g, d, _, stiffness = self.faces[k]
                K += stiffness * np.outer(g, g)
                b += stiffness * d * g
            A = np.zeros((2 * n + 3, 2 * n + 3))
            A[:n, n:2 * n] = np.eye(n)
            A[n:2 * n] = self.inverse @ np.column_stack([-K, -self.C, self.f, np.zeros(n), b])
            A[2 * n, 2 * n + 1], A[2 * n + 1, 2 * n] = -self.omega, self.omega
            step = GRID / max(math.sqrt(abs(np.linalg.eigvals(self.inverse @ K)).max()), self.omega)
            self.phases[closed] = A, step, expm(A * step)
        return self.phases[closed]

    def meets(self, A, y, z, step, f, sign, left):
        """First time in the step from y to z at which the gap of a face closes, or its spring opens; None if it does not."""
        g, d = self.faces[f][:2]
        n = self.n
        rate = lambda t: sign * (g @ (expm(A * t) @ y)[n:2 * n])
        gap = lambda t: sign * (g @ (expm(A * t) @ y)[:n] - d)
        a, b = -1.0 if left else sign * (g @ y[:n] - d), sign * (g @ z[:n] - d)
        up, after, low, high = sign * (g @ y[n:2 * n]), sign * (g @ z[n:2 * n]), 0.0, step
        if a >= 0:
            return None
        if b <= 0 and not (up > 0 > after):
            return None
        if b <= 0:  # a maximum within
            high = bisect(rate, step, falling=True)
            if gap(high) <= 1e-12 * d:
                return None
        elif left:  # it has left the face, and comes back
            low = bisect(lambda t: -rate(t), step, falling=True) if up < 0 < after else 0.0
        return bisect(lambda t: -gap(low + t), high - low, falling=True) + low

    def fly(self, x, v, phase, time, left=None, closed=frozenset()):
        """x, v, the faces met and the springs that are closed after `time`; None if there is no end of impacts."""
        y, met, t, n = np.concatenate([x, v, [math.cos(phase), math.sin(phase), 1]]), [], 0.0, self.n
        while t < time * (1 - 1e-15):
            A, step, through = self.phase(closed)
            step, z = (step, through @ y) if step <= time - t else (time - t, expm(A * (time - t)) @ y)
            times = [(s, f) for f in range(len(self.faces))
                     if (s := self.meets(A, y, z, step, f, -1 if f in closed else 1, f == left)) is not None]
            left = None
            if not times:
                y, t = z, t + step
                continue
            s, left = min(times)
            y, t = expm(A * s) @ y, t + s
            g, _, rigid, _ = self.faces[left]
            if rigid:
                y[n:2 * n] -= (1 + self.restitution) * (g @ y[n:2 * n]) / (g @ self.inverse @ g) * (self.inverse @ g)
            else:
                closed = closed ^ {left}
            met.append(left)
            if len(met) > IMPACTS:
                return None
        return y[:n], y[n:2 * n], met, closed


def bisect(f, high, falling):
    """Where f, positive at 0 and not at `high`, changes its sign."""
    low = 0.0
    for _ in range(60):
        middle = (low + high) / 2
        if (f(middle) > 0) == falling:
            low = middle
        else:
            high = middle
    return (low + high) / 2


def at_flight(s, point):
    """The motion half way through its longest flight: x, v, phase, springs closed; None without an end."""
    n, flights = s.n, point["flights"]
    x, v = point["x"][:n], point["x"][n:]
    on = [f for f, (g, d, rigid, _) in enumerate(s.faces) if abs(g @ x - d) < 1e-12 * d and (not rigid or g @ v <= 0)]
    left = on[0] if on and point["events"] else None
    closed = frozenset(f for f, (g, d, rigid, _) in enumerate(s.faces)
                       if not rigid and (g @ v > 0 if f == left else g @ x - d > 1e-9 * d))
    k = int(np.argmax(flights))
    time = sum(flights[:k]) + flights[k] / 2
    there = s.fly(x, v, point["phase"], time, left, closed)
    return there and (there[0], there[1], point["phase"] + point["omega"] * time, there[3])


def largest_by_differences(s, x, v, phase, period, closed, met, size):
    n, z, columns = s.n, np.concatenate([x, v]), []
    for j in range(2 * n):
        off, ends = size * np.abs(z[:n] if j < n else z[n:]).max(), []
        for sign in (1, -1):
            moved = z.copy()
            moved[j] += sign * off
            end = s.fly(moved[:n], moved[n:], phase, period, None, closed)
            if end is None or end[2] != met:
                return None
            ends.append(np.concatenate(end[:2]))
        columns.append((ends[0] - ends[1]) / (2 * off))
    return np.abs(np.linalg.eigvals(np.array(columns).T)).max()


def judge(model, zeta, force, point):
    """What is wrong with a point, "" if nothing is, and whether its largest multiplier was confirmed."""
    s, largest = Shaken(model, zeta, force, point), point["largest"] or LOST
    there = at_flight(s, point)
    end = there and s.fly(there[0], there[1], there[2], point["period"], None, there[3])
    if not end:
        return "impacts without end", False
    x, v = there[:2]
    off = max(np.abs(end[0] - x).max() / np.abs(x).max(), np.abs(end[1] - v).max() / np.abs(v).max())
    if off > RETURN * max(1, largest) * max(1, SLOW / (point["approach"] or SLOW)):
        return f"returns to {off:.2g} after {len(end[2])} events, multiplier {largest:.3g}", False
    found = [largest_by_differences(s, x, v, there[2], point["period"], there[3], end[2], size) for size in SIZES]
    found = [f for f in found if f is not None]
    sure = len(found) == len(SIZES) and max(found) - min(found) <= AGREE * min(found)
    if not sure or point["largest"] is None:
        return "", False
    if abs(found[1] - largest) > AGREE * largest:
        return f"largest multiplier {found[1]:.8g}, {largest:.8g} stored", False
    if abs(found[1] - 1) > 2 * AGREE and point["stable"] != ("yes" if found[1] < 1 else "no"):
        return f"largest multiplier {found[1]:.8g}, stable {point['stable']}", False
    return "", True


def points_of(program, path, count, rng, length):
    read = lambda *more: json.loads(subprocess.run([program, "response", path, *more, "--json"], stdout=subprocess.PIPE, check=True).stdout)
    events = {curve["id"]: curve["word"] != "-" for curve in read()}
    points = read("--points")
    for i in sorted(rng.choice(len(points), min(count, len(points)), replace=False)):
        yield points[i] | {"x": np.array(points[i]["state"]) * length, "events": events[points[i]["curve"]]}


def one(program, kind, seed, count, tally):
    study = structures.make(seed, kind)[2]
    model, rng = study["model"], np.random.default_rng(seed)
    M, K = np.array(model["mass"]), np.array(model["stiffness"])
    slowest = math.sqrt(max(np.sort(np.linalg.eigvals(np.linalg.solve(M, K)).real)[0], 0))
    if not slowest > 0:
        return
    force = [round(float(f), 3) for f in rng.uniform(-1, 1, len(M))]
    zeta, level = float(rng.choice([0.003, 0.01, 0.03])), float(rng.choice([0.05, 0.3])) * np.abs(K).max()
    restitution = float(rng.choice([1, 0.95, 0.8]))
    level *= min(c["clearance"] for c in model["contacts"])
    study["explore"] |= {"impacts": 4, "multiply": 1, "depth": 1}
    with tempfile.TemporaryDirectory() as folder:
        yaml, atlas, path = (os.path.join(folder, name) for name in ("s.yaml", "s.ricochet", "s.response"))
        with open(yaml, "w", encoding="utf-8") as out:
            json.dump(study, out)
        ask = [program, "response", atlas, "--force", ",".join(map(str, force)), "--damping", str(zeta), "--level", repr(level),
               "--omega", f"{0.6 * slowest:.4g},{1.5 * slowest:.4g}", "--impacts", "6", "--most-curves", "12",
               "--most-points", "200", "-o", path]
        if any(c["law"] == "rigid" for c in model["contacts"]):
            ask += ["--restitution", str(restitution)]
        subprocess.run([program, "run", yaml, "-o", atlas, "--quiet", "--seconds", "10"], capture_output=True, check=False)
        try:
            if subprocess.run(ask, capture_output=True, timeout=LIMIT, check=False).returncode:
                tally["none found"] += 1
                return
        except subprocess.TimeoutExpired:
            tally["over the limit"] += 1
            return
        for point in points_of(program, path, count, rng, model["contacts"][0]["clearance"]):
            wrong, sure = judge(model, zeta, force, point)
            tally["motions"] += 1
            tally["multipliers confirmed"] += sure
            if wrong:
                tally["findings"] += 1
                print(f"seed {seed} {kind}: curve {point['curve']} point {point['point']}: {wrong}", flush=True)


def main():
    program, kind = sys.argv[1:3]
    if kind == "power":
        sys.exit("power laws have no flights in closed form: rigid, bilinear, or mixed")
    count, seed, points = (int(x) for x in (sys.argv[3:] + ["10", "1", "25"][len(sys.argv) - 3:])[:3])
    tally = dict.fromkeys(("motions", "multipliers confirmed", "findings", "none found", "over the limit"), 0)
    for s in range(seed, seed + count):
        one(program, kind, s, points, tally)
    print(f"{kind}: " + ", ".join(f"{n} {what}" for what, n in tally.items()))
    sys.exit(bool(tally["findings"]) or not tally["motions"])


if __name__ == "__main__":
    main()
