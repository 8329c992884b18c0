#!/usr/bin/env python3
"""The families of an atlas that no linear mode reaches, as the table of docs/islands.md.

    tools/islands.py PROGRAM ATLAS

A family is what hangs together over junctions, duplicates of its grazings included. It is closed if every branch of it
ends at a junction and nothing is left to take at its grazings, but for their duplicates.
"""
import collections
import json
import subprocess
import sys


def listing(program, what, atlas):
    return json.loads(subprocess.run([program, what, atlas, "--json"], check=True, capture_output=True).stdout)


def touched(branch):
    return [j for j in (branch["from"], branch["to"], *branch["junctions"]) if j]


def families(branches, junctions):
    """Lists of branches."""
    at = collections.defaultdict(list)
    for b in branches:
        for j in touched(b):
            at[j].append(b["id"])
    parent = {b["id"]: b["id"] for b in branches}

    def root(i):
        while parent[i] != i:
            i = parent[i]
        return i

    def join(ids):
        for i in ids[1:]:
            parent[root(i)] = root(ids[0])

    grazings = collections.defaultdict(list)
    for j, ids in at.items():
        join(ids)
        if junctions[j]["kind"] == "grazing":
            grazings[f"{junctions[j]['energy']:.8e}"].append(j)
    for same in grazings.values():  # an orbit and its duplicates
        if any(junctions[j]["multiple"] > 1 for j in same):
            join([at[j][0] for j in same])
    out = collections.defaultdict(list)
    for b in branches:
        out[root(b["id"])].append(b)
    return list(out.values())


def place(j):
    return f"{j['label']} ({j['energy']:.6g}, {j['frequency']:.6g})"


def row(family, junctions):
    own = [b for b in family if all(junctions[j]["multiple"] == 1 for j in (b["from"], b["to"]) if j)]
    grazings = {j for b in own for j in (b["from"], b["to"]) if j and junctions[j]["kind"] == "grazing"}
    left = sum(junctions[j]["departures"][k] for j in grazings for k in ("over_budget", "refused"))
    window = any(b["stop"] != "junction" for b in own)
    own.sort(key=lambda b: (b["impacts"], b["label"]))
    labels = list(dict.fromkeys(b["label"] for b in own))
    ends = sorted((junctions[j] for j in grazings), key=lambda j: j["energy"])
    stable = max(b["stable_fraction"] for b in own)
    return (own[0]["impacts"], ends[0]["energy"] if ends else 0), (
        ", ".join(labels[:3]) + (" .." if len(labels) > 3 else ""), str(len(own)),
        " to ".join(place(j).replace(j["label"], f"G_{j['impacts']},{j['grazings']}") for j in (ends[:1] + ends[1:][-1:])),
        f"{min(b['energy_min'] for b in own):.6g} to {max(b['energy_max'] for b in own):.6g}",
        "in part" if stable > 0 else "no",
        "window" if window else "budget" if left else "closed")


def main():
    program, atlas = sys.argv[1:]
    junctions = {j["id"]: j for j in listing(program, "junctions", atlas)}
    branches = [b for b in listing(program, "branches", atlas) if not b["linked"]]
    rows = sorted(row(f, junctions) for f in families(branches, junctions))
    print("| branches | number | grazings (E, ω), lowest and highest | energies | stable | ends |\n" + "|---" * 6 + "|")
    for _, cells in rows:
        print("| " + " | ".join(cells) + " |")
    count = collections.Counter((cells[-1], cells[-2]) for _, cells in rows)
    print(f"\n{len(rows)} families, {len(branches)} branches: "
          + ", ".join(f"{n} {ends} (stable: {stable})" for (ends, stable), n in sorted(count.items())))


if __name__ == "__main__":
    main()
