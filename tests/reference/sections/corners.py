#!/usr/bin/env python3
"""Torsion of corners and junctions of walls: Laplace's and Poisson's equations by finite differences.

Prints the constants of NOTATION (S17) and (S19): the contribution of a right-angled corner or a T-junction in addition to its straight
walls up to the inner corner, with arms so long that the rest equals straight walls. Needs numpy and scipy.
"""

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spl


def solve(inside, height, h, held):
    """Solutions of ∇²u = 0 with u = `height` on the boundary, and ∇²u = −2 with 0 there; the edges of the array are symmetry lines."""
    nx, ny = inside.shape
    index = -np.ones((nx, ny), int)
    free = inside & ~held
    index[free] = np.arange(free.sum())
    rows, cols, data = [], [], []
    rhs = np.zeros((free.sum(), 2))
    rhs[:, 1] = 2 * h * h
    i, j = np.nonzero(free)
    p = index[i, j]
    rows.append(p), cols.append(p), data.append(np.full(len(p), 4.0))
    for di, dj in ((-1, 0), (1, 0), (0, -1), (0, 1)):
        a, b = i + di, j + dj
        a, b = np.where(a < 0, 1, np.where(a >= nx, nx - 2, a)), np.where(b < 0, 1, np.where(b >= ny, ny - 2, b))
        q = index[a, b]
        inner = q >= 0
        rows.append(p[inner]), cols.append(q[inner]), data.append(np.full(inner.sum(), -1.0))
        np.add.at(rhs[:, 0], p[~inner], height[a, b][~inner])
    matrix = sp.csc_matrix((np.concatenate(data), (np.concatenate(rows), np.concatenate(cols))))
    found = spl.splu(matrix).solve(rhs)
    out = []
    for k, rim in enumerate((height, np.zeros_like(height))):
        u = rim.copy()
        u[free] = found[:, k]
        out.append(u)
    return out


def integral(u, cells, h):
    return (((u[:-1, :-1] + u[1:, :-1] + u[:-1, 1:] + u[1:, 1:]) / 4) * cells).sum() * h * h


def corner(a, b, n, arms=4):
    """κ relative to a b, and λ: ∫h dA and the torsion constant in addition to the walls up to the inner corner, walls of thickness a along
    y and b along x."""
    h = 1.0 / n
    na, nb = round(a / h), round(b / h)
    far = round(arms * max(a, b) / h)
    x, y = np.meshgrid(np.arange(na + far + 1), np.arange(nb + far + 1), indexing="ij")
    hollow = (x >= na) & (y >= nb)
    held = hollow | (x == 0) | (y == 0)
    level, stress = solve(np.ones_like(held), np.where(hollow, 1.0, 0.0), h, held)
    cells = ~((x[:-1, :-1] >= na) & (y[:-1, :-1] >= nb))
    arm = far * h
    return (
        (integral(level, cells, h) - 0.5 * b * arm - 0.5 * a * arm) / (a * b),
        2 * integral(stress, cells, h) - (b**3 + a**3) * arm / 3,
    )


def junction(w, n, arms=4):
    """Torsion constant of a T in addition to a complete flange of thickness 1 and a web of thickness w up to it."""
    h = 1.0 / n
    half = round(0.5 * w / h)
    far = round(arms * max(1.0, w) / h)
    # half of the section, symmetric about x = 0: flange 0 < y < 1, web below
    x, y = np.meshgrid(np.arange(half + far + 1), np.arange(far + n + 1), indexing="ij")
    outside = (x >= half) & (y <= far)
    held = outside | (y == far + n)
    _, stress = solve(np.ones_like(held), np.zeros(held.shape), h, held)
    cells = ~((x[:-1, :-1] >= half) & (y[:-1, :-1] < far))
    arm = far * h
    return 2 * (2 * integral(stress, cells, h)) - 2 * (half * h + arm) / 3 - (2 * half * h) ** 3 * arm / 3


def limit(of, n):
    """Extrapolated from meshes n and 2n; the error falls with the power 4/3 of a re-entrant corner."""
    coarse, fine = np.array(of(n)), np.array(of(2 * n))
    return fine + (fine - coarse) / (2 ** (4 / 3) - 1)


def main():
    for ratio in (0.25, 0.5, 0.75, 1.0):
        print("corner", ratio, limit(lambda n: corner(1.0, ratio, n), 40), flush=True)
    for ratio in (0.25, 0.5, 1.0, 1.5, 2.0):
        print("junction", ratio, limit(lambda n: junction(ratio, n), 40), flush=True)


if __name__ == "__main__":
    main()
