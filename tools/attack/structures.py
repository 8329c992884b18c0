"""Random structures: everything from a seed, as a study that names every option but the tolerances."""
import numpy as np

KINDS = ("rigid", "bilinear", "mixed", "power")


def _round(x, digits=4):
    return float(f"{x:.{digits}g}")


def _matrices(rng, n, flavour):
    """Mass and stiffness with entries that are sums of few digits, so that rows of a free body add up to zero exactly."""
    if flavour == "chain" or flavour == "free":
        mass = np.diag(rng.integers(1, 9, n) / 4.0)
        k = rng.integers(1, 33, n + 1) / 4.0
        if flavour == "free":
            k[0] = k[n] = 0
        stiffness = np.diag(k[:n] + k[1:]) - np.diag(k[1:n], 1) - np.diag(k[1:n], -1)
        return mass, stiffness
    if flavour == "equal":
        mass = np.eye(n)
        stiffness = np.eye(n) * 2.0
        for i in range(n - 1):
            if rng.random() < 0.3:
                stiffness[i, i] += 1
        return mass, stiffness
    a = rng.integers(-4, 5, (n, n)) / 8.0
    mass = a @ a.T + np.diag(rng.integers(2, 9, n) / 4.0)
    if flavour == "resonant":
        low = np.linalg.cholesky(mass)
        q, _ = np.linalg.qr(rng.standard_normal((n, n)))
        ratio = np.array([1, 2, 3, 1, 4])[:n] + rng.choice([0, 1e-9, 1e-6, 1e-3, 1e-2]) * rng.standard_normal(n)
        stiffness = low @ q @ np.diag(ratio**2) @ q.T @ low.T
        return mass, (stiffness + stiffness.T) / 2
    b = rng.integers(-8, 9, (n, n)) / 4.0
    return mass, b @ b.T + np.diag(rng.integers(1, 9, n) / 4.0)


def _normals(rng, n, count):
    out = []
    for _ in range(count):
        b = np.zeros(n)
        i = rng.integers(n)
        choice = rng.random()
        if n > 1 and choice < 0.5:
            j = (i + 1) % n
            b[i], b[j] = -1, 1
        elif n > 1 and choice < 0.6:
            b = rng.integers(-2, 3, n).astype(float)
            b[i] = 1
        else:
            b[i] = 1
        if not any(abs(abs(b @ o) - np.sqrt((b @ b) * (o @ o))) < 1e-12 for o in out):
            out.append(b)
    return out


def _contact(rng, kind, law, b, d, typical):
    contact = {"normal": [float(x) for x in b], "law": law}
    if law == "power":
        contact["exponent"] = int(rng.choice([3, 5, 7, 9, 11, 15, 21]))
        if rng.random() < 0.5:
            contact["stiffness"] = _round(typical * 10 ** rng.uniform(-1.5, 1.5) / d ** (contact["exponent"] - 1))
        else:
            contact["length"], contact["reference"] = _round(d), _round(typical * 10 ** rng.uniform(-1, 1))
        return contact
    contact["clearance"] = _round(d)
    contact["sides"] = str(rng.choice(["both", "both", "both", "upper", "lower"]))
    if law == "bilinear":
        exponent = rng.choice([rng.uniform(-3, 0), rng.uniform(-1, 2), rng.uniform(-1, 2), rng.uniform(2, 6)])
        contact["stiffness"] = _round(typical * 10 ** exponent)
    return contact


def make(seed, kind=None, small=False):
    """(kind, what it is, study) of a seed."""
    rng = np.random.default_rng(seed)
    kind = kind or KINDS[seed % 4]
    n = int(rng.choice([1, 2, 2, 2, 3, 3, 4, 5])) if kind in ("rigid", "bilinear") else int(rng.choice([2, 2, 2, 3, 3, 4, 5]))
    if small and kind == "power":
        n = min(n, 3)  # four and five modes cost seconds each
    flavour = str(rng.choice(["full", "full", "full", "chain", "chain", "resonant", "free", "equal"]))
    if n == 1 or (flavour == "free" and kind == "power"):
        flavour = "full"
    mass, stiffness = _matrices(rng, n, flavour)
    count = int(rng.choice([1, 1, 2, 2, 3])) if kind != "mixed" else int(rng.choice([2, 2, 3]))
    count = min(count, max(n, 1)) if kind != "mixed" else count
    normals = _normals(rng, n, count)
    while kind == "mixed" and len(normals) < 2:
        normals = _normals(rng, n, count + 2)[:count]
    length = 10.0 ** rng.choice([0, 0, 0, -3, 1])
    pace = 10.0 ** rng.choice([0, 0, 0, 2.7])
    stiffness = stiffness * _round(pace**2, 2)
    lam = np.linalg.eigvalsh(np.linalg.solve(np.linalg.cholesky(mass), np.linalg.solve(np.linalg.cholesky(mass), stiffness).T))
    omega = np.sqrt(np.maximum(lam, 0))
    zero = omega < 1e-6 * omega.max()
    typical = float(np.median(np.diag(stiffness)))
    spacing = str(rng.choice(["plain", "plain", "plain", "equal", "near", "tiny"]))
    d = [_round(length * rng.uniform(0.5, 2), 3) for _ in normals]
    if spacing == "equal":
        d = [d[0]] * len(d)
    elif spacing == "near":
        d = [d[0] * (1 + i * float(rng.choice([1e-9, 1e-6, 1e-3]))) for i in range(len(d))]
    elif spacing == "tiny" and len(d) > 1:
        d[1] = d[0] * 1e-3
    laws = {"rigid": ["rigid"], "bilinear": ["bilinear"], "power": ["power"], "mixed": ["rigid", "bilinear"]}[kind]
    laws = [laws[i] if i < len(laws) else str(rng.choice(laws)) for i in range(len(normals))]
    if kind != "mixed":
        laws = [laws[0]] * len(normals)
    elif rng.random() < 0.5:
        laws.reverse()
    contacts = [_contact(rng, kind, law, b, x, typical) for law, b, x in zip(laws, normals, d)]
    window = _windows(rng, mass, stiffness, omega, zero, contacts, kind)
    model = {"mass": mass.tolist(), "stiffness": stiffness.tolist(), "contacts": contacts}
    most = int(rng.choice([3, 4, 6])) if small else int(rng.choice([4, 6, 8]))
    if n > 3 or len(contacts) > 2:
        most = min(most, 5)
    explore = {
        "start": "modes", "energy": window[0], "frequency": window[1], "impacts": most,
        "multiply": int(rng.choice([1, 2, 2, 3])) if not small else int(rng.choice([1, 2])),
        "depth": int(rng.choice([1, 2, 2])) if n < 4 else 1,
    }
    if kind == "power":
        explore["multiply"] = 1 if n > 3 else int(rng.choice([1, 2]))
        explore["depth"] = 1
    text = f"{n} dof, {flavour}, {spacing} clearances, {'+'.join(laws)}"
    return kind, text, {"title": f"seed {seed}", "model": model, "explore": explore}


def hard(seed, kind=None):
    """(kind, what it is, study) of a seed: larger budgets, more degrees of freedom, springs and clearances far from those of the
    structure, equal frequencies; meant for a `--limit`, after which what is there is judged."""
    rng = np.random.default_rng([seed, 3])
    kind, text, study = make(seed, kind)
    model, explore = study["model"], study["explore"]
    if rng.random() < 0.5:  # another structure, of more degrees of freedom
        n = int(rng.integers(4, 7))
        flavour = str(rng.choice(["full", "chain", "resonant", "equal"])) if n < 6 else str(rng.choice(["full", "chain"]))
        mass, stiffness = _matrices(rng, n, flavour)
        normals = _normals(rng, n, 1 if kind == "power" else int(rng.choice([2, 2, 3])))
        laws = ["rigid", "bilinear", "rigid"] if kind == "mixed" else [kind] * 3
        typical = float(np.median(np.diag(stiffness)))
        contacts = [_contact(rng, kind, law, b, _round(rng.uniform(0.5, 2), 3), typical) for law, b in zip(laws, normals)]
        model.update(mass=mass.tolist(), stiffness=stiffness.tolist(), contacts=contacts)
        text = f"{n} dof, {flavour}, {'+'.join(c['law'] for c in contacts)}"
    mass, stiffness, contacts = np.array(model["mass"]), np.array(model["stiffness"]), model["contacts"]
    typical = float(np.median(np.diag(stiffness)))
    for contact in contacts:
        if contact["law"] == "bilinear" and rng.random() < 0.5:
            contact["stiffness"] = _round(typical * 10 ** float(rng.choice([-6, -4, 5, 7])))
        if contact is not contacts[0] and "clearance" in contact and rng.random() < 0.4:
            contact["clearance"] = _round(contacts[0]["clearance"] * 10 ** rng.uniform(-4, 1), 3)
    omega = np.sqrt(np.maximum(np.linalg.eigvalsh(_standard(mass, stiffness)), 0))
    explore["energy"], explore["frequency"] = _windows(rng, mass, stiffness, omega, omega < 1e-6 * omega.max(), contacts, kind)
    explore.update(impacts=int(rng.integers(10, 21)), multiply=int(rng.integers(3, 7)), depth=int(rng.integers(2, 4)))
    study["title"] = f"hard {seed}"
    return kind, f"{text}; impacts {explore['impacts']}, multiply {explore['multiply']}, depth {explore['depth']}", study


def _near_matrices(rng, n):
    """(mass, stiffness, how far apart) with two frequencies or three that are 1e-6 .. 1e-14 apart, the others anywhere."""
    apart = 10.0 ** -rng.uniform(6, 14)
    lam = [1.0, (1 + apart) ** 2] + [(1 + apart * rng.uniform(-3, 3)) ** 2] * int(n > 3 and rng.random() < 0.3)
    lam = rng.permutation(lam + [_round(rng.uniform(1.3, 6)) for _ in range(n - len(lam))])
    if rng.random() < 0.4:
        return np.eye(n), np.diag(lam), f"{apart:.1e} apart, uncoupled"
    a = rng.integers(-4, 5, (n, n)) / 8.0
    mass = a @ a.T + np.diag(rng.integers(2, 9, n) / 4.0)
    low = np.linalg.cholesky(mass).astype(np.longdouble)
    q = np.linalg.qr(rng.standard_normal((n, n)))[0].astype(np.longdouble)
    q = q @ (1.5 * np.eye(n, dtype=np.longdouble) - 0.5 * (q.T @ q))
    stiffness = (low @ q @ np.diag(lam) @ q.T @ low.T).astype(float)
    return mass, (stiffness + stiffness.T) / 2, f"{apart:.1e} apart, coupled"


def near(seed, kind=None):
    """(kind, what it is, study) of a seed: frequencies that are all but equal, small budgets."""
    rng = np.random.default_rng([seed, 1])
    kind = kind or KINDS[seed % 4]
    n = int(rng.integers(2, 7)) if kind != "power" else int(rng.choice([2, 2, 3, 3, 4, 5]))
    mass, stiffness, text = _near_matrices(rng, n)
    normals = _normals(rng, n, 2 if kind == "mixed" else int(rng.choice([1, 1, 2])))
    if rng.random() < 0.6:
        normals = [np.round(rng.standard_normal(n), 2) for _ in normals]
    laws = ["rigid", "bilinear"] if kind == "mixed" else [kind] * len(normals)
    contacts = [_contact(rng, kind, law, b, _round(rng.uniform(0.6, 1.6), 3), 2.0) for law, b in zip(laws, normals)]
    omega = np.sqrt(np.linalg.eigvalsh(_standard(mass, stiffness)))
    window = _windows(rng, mass, stiffness, omega, np.zeros(n, bool), contacts, kind)
    explore = {"start": "modes", "energy": window[0], "frequency": window[1], "impacts": int(rng.choice([3, 4])), "multiply": 1, "depth": 1}
    model = {"mass": mass.tolist(), "stiffness": stiffness.tolist(), "contacts": contacts}
    return kind, f"{n} dof, {text}, {'+'.join(c['law'] for c in contacts)}", {"title": f"near {seed}", "model": model, "explore": explore}


def _body(rng, size):
    """(masses, stiffness) of a chain that nothing holds: its rows add up to zero exactly."""
    k = rng.integers(4, 33, size - 1) / 4.0
    stiffness = np.zeros((size, size))
    for i in range(size - 1):
        stiffness[i:i + 2, i:i + 2] += k[i] * np.array([[1, -1], [-1, 1]])
    return rng.integers(2, 9, size) / 4.0, stiffness


def bodies(seed, kind=None):
    """(kind, what it is, study) of a seed: two free bodies or three, contacts within them, between them, and with a wall."""
    rng = np.random.default_rng([seed, 2])
    kind = kind or ("rigid", "bilinear", "mixed")[seed % 3]
    sizes = [int(rng.choice([1, 2, 2, 3])) for _ in range(int(rng.choice([2, 2, 3])))]
    sizes[0] = max(sizes[0], 2)  # one that vibrates
    n, first = sum(sizes), np.concatenate([[0], np.cumsum(sizes)])
    mass, stiffness = np.zeros(n), np.zeros((n, n))
    for b, size in enumerate(sizes):
        part = slice(first[b], first[b + 1])
        mass[part], stiffness[part, part] = _body(rng, size)
    mass = np.diag(mass)
    normals = []
    for body in range(len(sizes)):
        one = np.zeros(n)
        i = first[body] + int(rng.integers(sizes[body]))
        if sizes[body] > 1 and (body == 0 or rng.random() < 0.6):  # within the body
            one[first[body] + sizes[body] - 1], one[first[body]] = 1, -1
            normals.append(one.copy())
        if body + 1 < len(sizes):  # and between this one and the next
            one[i], one[first[body + 1] + int(rng.integers(sizes[body + 1]))] = 1, -1
            normals.append(one.copy())
    wall = np.zeros(n)
    wall[rng.integers(n)] = 1
    if rng.random() < 0.5:
        wall[rng.integers(n)] = 1
    normals.append(wall)
    laws = ["rigid", "bilinear"] if kind == "mixed" else [kind]
    laws = [laws[i % len(laws)] for i in range(len(normals))]
    length = _round(rng.uniform(0.6, 1.5), 3)
    typical = float(np.median(np.diag(stiffness)[np.diag(stiffness) > 0]))
    share = [rng.uniform(0.5, 1)] + [rng.uniform(0.5, 2.5) for _ in normals[1:]]
    contacts = [_contact(rng, kind, law, b, length * x, typical) for law, b, x in zip(laws, normals, share)]
    contacts[-1]["sides"] = str(rng.choice(["lower", "upper", "both"]))
    omega = np.sqrt(np.maximum(np.linalg.eigvalsh(_standard(mass, stiffness)), 0))
    zero = omega < 1e-6 * omega.max()
    window = _windows(rng, mass, stiffness, omega, zero, contacts, kind)
    explore = {"start": "modes", "energy": window[0], "frequency": window[1], "impacts": int(rng.choice([4, 5])),
               "multiply": int(rng.choice([1, 2])), "depth": int(rng.choice([1, 2])) if n < 5 else 1}
    model = {"mass": mass.tolist(), "stiffness": stiffness.tolist(), "contacts": contacts}
    text = f"{n} dof, bodies of {'+'.join(map(str, sizes))}, {'+'.join(laws)}"
    return kind, text, {"title": f"bodies {seed}", "model": model, "explore": explore}


def _standard(mass, stiffness):
    low = np.linalg.cholesky(mass)
    return np.linalg.solve(low, np.linalg.solve(low, stiffness).T)


def _windows(rng, mass, stiffness, omega, zero, contacts, kind):
    """Scaled energies up to a few times a typical grazing energy; frequencies around those of the modes."""
    low = np.linalg.cholesky(mass)
    lam, q = np.linalg.eigh(np.linalg.solve(low, np.linalg.solve(low, stiffness).T))
    modes = np.linalg.solve(low.T, q)
    first = contacts[0]
    d = first.get("clearance", first.get("length", 1.0))
    energies = []
    for contact in contacts:
        c = modes.T @ np.array(contact["normal"])
        for i in range(len(c)):
            if zero[i] or abs(c[i]) < 1e-9 * np.abs(c).max():
                continue
            if kind == "power":
                m = contact["exponent"]
                if "length" in contact:
                    reach = contact["length"]
                else:
                    reach = (omega[i] ** 2 / (contact["stiffness"] * c[i] ** 2)) ** (1 / (m - 1))
            else:
                reach = contact["clearance"]
            energies.append(omega[i] ** 2 * reach**2 / (2 * c[i] ** 2) / d**2)
    energies = np.sort(energies) if energies else np.array([1.0])
    top = energies[min(len(energies) - 1, int(rng.integers(1, 3)))] * rng.uniform(1.5, 6)
    slow = omega[~zero].min() if (~zero).any() else 1.0
    return [0, _round(float(top))], [_round(float(slow * 0.2)), _round(float(omega.max() * 3))]
