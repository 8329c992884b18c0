#!/usr/bin/env python3
"""Mass and stiffness of a pinned beam with a lumped mass, as Matrix Market files: beam.py FOLDER [ELEMENTS [NODE MASS]]

Cubic (Hermite) finite elements of equal length; E elements give 2 E unknowns in the order
    rotation 0, deflection 1, rotation 1, ..., deflection E-1, rotation E-1, rotation E,
so that the deflection of node k (k = 1 .. E-1) is unknown 2 k. The beam has length 1 and mass 1, its bending stiffness is such
that the lowest frequency without the lumped mass is 1 rad/s; the exact ones are 1, 4, 9, 16, ...
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


def main():
    if not 2 <= len(sys.argv) <= 5 or len(sys.argv) == 4:
        sys.exit("usage: beam.py FOLDER [ELEMENTS [NODE MASS]]")
    folder = sys.argv[1]
    n_element = int(sys.argv[2]) if len(sys.argv) > 2 else 10
    node, lump = (int(sys.argv[3]), float(sys.argv[4])) if len(sys.argv) > 3 else (1, 0.0)
    if not 1 <= node < n_element:
        sys.exit(f"beam.py: NODE {node} is not between 1 and {n_element - 1}")
    mass, stiffness = beam(n_element)
    mass[2 * node - 1][2 * node - 1] += lump
    what = f"pinned beam, {n_element} Hermite elements"
    write(os.path.join(folder, "M.mtx"), f"{what}, mass, with {lump:g} at node {node}", mass)
    write(os.path.join(folder, "K.mtx"), f"{what}, stiffness", stiffness)


main()
