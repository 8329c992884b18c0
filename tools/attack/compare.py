"""The same study with other steps, another order of its modes and contacts, or two workers: the same atlas is asked for."""
import copy
import os
import re
import subprocess

import numpy as np

from judge import Atlas, floats

SAME = 1e-7  # relative: energies and frequencies of junctions that are one


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
    junctions = [(j["kind"], _letters(j["word"]), j["grazings"], j["multiple"], j["energy"], j["frequency"], j["label"])
                 for j in atlas.junctions]
    ends = [(("branch", b["symmetric"], b["reversible"]), _letters(b["word"]), b["impacts"], 0,
             b["energy_max"], b["frequency_max"], b["label"]) for b in atlas.branches]
    return junctions + ends


def missing(one, other):
    """Rows of `one` that `other` lacks, each row used once."""
    left, lost = list(_rows(other)), []
    for row in _rows(one):
        for i, candidate in enumerate(left):
            if row[:4] == candidate[:4] and all(abs(a - b) <= SAME * max(abs(a), abs(b)) + 1e-12
                                                for a, b in zip(row[4:6], candidate[4:6])):
                del left[i]
                break
        else:
            lost.append(row)
    return lost


def _texts(*atlases):
    """What the atlases themselves say they have not done: unplaced events, blind parts, failed branches, refusals."""
    out = []
    for a in atlases:
        if int(a.meta.get("unplaced", 0)):
            out.append(f"{a.meta['unplaced']} events unplaced")
        if int(a.meta.get("blind", 0)):
            out.append(f"{a.meta['blind']} branches blind")
        out += [f"branch {b['label']}: {b['stop']} {b['why']}" for b in a.branches if b["stop"] == "failed"]
        out += [f"junction {j['label']}: {j['refusal']}" for j in a.junctions if j["refused"]]
    return out


def variants(program, study, base_path, folder, which, limit):
    findings, named = [], []
    base = Atlas(base_path)
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
        lost, more_rows = missing(base, atlas), missing(atlas, base)
        if lost or more_rows:
            said = _texts(base, atlas)
            text = f"{len(lost)} rows lost, {len(more_rows)} new: " + "; ".join(
                f"{'-' if row in lost else '+'} {row[0] if isinstance(row[0], str) else row[0][0]} {row[6]} E={row[4]:.9g} "
                f"w={row[5]:.9g}" for row in (lost + more_rows)[:6])
            (named if said else findings).append({"kind": f"other atlas, {name.split()[0]}", "where": name,
                                                  "text": text + (f" [{'; '.join(said[:3])}]" if said else "")})
    if "workers" in which:
        atlas = _run(program, study, folder, "workers", limit, "-j", "2")
        if atlas is not None and (isinstance(atlas, int) or atlas.meta.get("digest") != base.meta.get("digest")):
            findings.append({"kind": "other atlas, workers", "where": "-j 2", "text": "another digest"})
    return findings, named
