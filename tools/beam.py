#!/usr/bin/env python3
"""Mass and stiffness of a beam, pinned or with a lumped mass, as Matrix Market files: beam.py FOLDER [ELEMENTS [NODE MASS SPRING]]

Cubic (Hermite) finite elements of equal length; E elements give 2 E unknowns in the order
    rotation 0, deflection 1, rotation 1, ..., deflection E-1, rotation E-1, rotation E,
so that the deflection of node k (k = 1 .. E-1) is unknown 2 k. The beam has length 1 and mass 1, its bending stiffness is such
that the lowest frequency of the pinned beam is 1 rad/s; the exact ones are 1, 4, 9, 16, ... With a lumped mass the left end is clamped, its
rotation is no unknown, and the mass, which hangs on a spring at NODE, is the last one.
"""
import math
import os
import sys


def beam(n_element):
    """(M, K), dense lists, both ends pinned."""
    h = 1.0 / n_element
    stiffness = math.pi**-4 / h**3
    k = [
        [12, 6 * h, -12, 6 * h],
        [6 * h, 4 * h * h, -6 * h, 2 * h * h],
        [-12, -6 * h, 12, -6 * h],
        [6 * h, 2 * h * h, -6 * h, 4 * h * h],
    ]
    m = [
        [156, 22 * h, 54, -13 * h],
        [22 * h, 4 * h * h, 13 * h, -3 * h * h],
        [54, 13 * h, 156, -22 * h],
        [-13 * h, -3 * h * h, -22 * h, 4 * h * h],
    ]
    n = 2 * (n_element + 1)
    mass = [[0.0] * n for _ in range(n)]
    stiff = [[0.0] * n for _ in range(n)]
    for e in range(n_element):
        for i in range(4):
            for j in range(4):
                mass[2 * e + i][2 * e + j] += m[i][j] * h / 420
                stiff[2 * e + i][2 * e + j] += k[i][j] * stiffness
    kept = [i for i in range(n) if i not in (0, n - 2)]  # no deflection at the ends
    return [[mass[i][j] for j in kept] for i in kept], [[stiff[i][j] for j in kept] for i in kept]


def write(path, comment, a):
    entries = [(i + 1, j + 1, a[i][j]) for j in range(len(a)) for i in range(j, len(a)) if a[i][j] != 0]
    with open(path, "w", encoding="ascii") as out:
        out.write(f"%%MatrixMarket matrix coordinate real symmetric\n% {comment}\n{len(a)} {len(a)} {len(entries)}\n")
        out.writelines(f"{i} {j} {value!r}\n" for i, j, value in entries)


def on_spring(mass, stiffness, node, lump, spring):
    """Clamps the left end (takes its rotation out) and hangs a mass on a spring at a node; the mass is the last unknown."""
    mass = [row[1:] + [0.0] for row in mass[1:]] + [[0.0] * (len(mass) - 1) + [lump]]
    stiffness = [row[1:] + [0.0] for row in stiffness[1:]] + [[0.0] * len(stiffness)]
    place, last = 2 * node - 2, len(mass) - 1
    for i, j, sign in ((place, place, 1), (last, last, 1), (place, last, -1), (last, place, -1)):
        stiffness[i][j] += sign * spring
    return mass, stiffness


def main():
    if len(sys.argv) not in (2, 3, 6):
        sys.exit("usage: beam.py FOLDER [ELEMENTS [NODE MASS SPRING]]")
    folder = sys.argv[1]
    n_element = int(sys.argv[2]) if len(sys.argv) > 2 else 10
    mass, stiffness = beam(n_element)
    what = f"pinned beam, {n_element} Hermite elements"
    if len(sys.argv) == 6:
        node, lump, spring = int(sys.argv[3]), float(sys.argv[4]), float(sys.argv[5])
        if not 1 <= node < n_element:
            sys.exit(f"beam.py: NODE {node} is not between 1 and {n_element - 1}")
        mass, stiffness = on_spring(mass, stiffness, node, lump, spring)
        what = f"clamped and pinned beam, {n_element} Hermite elements, mass {lump:g} on a spring {spring:g} at node {node}"
    write(os.path.join(folder, "M.mtx"), f"{what}: mass", mass)
    write(os.path.join(folder, "K.mtx"), f"{what}: stiffness", stiffness)


main()
