"""Frequencies of the NREL 5 MW blade at standstill by finite elements in two planes, with and without shear.

Independent of the engine, for the test WT-37. The model includes bending about both axes of sections that rotate with the twist, and
rotary inertia, but no stretch and torsion; the shear stiffness is a tenth of the axial stiffness, as in BeamDyn's file.

    python studies/blade_frequencies.py examples/turbine/nrel_5mw_blade.csv
"""

import csv
import sys

import numpy as np
import scipy.linalg

LENGTH_M = 61.5
ELEMENTS = 240


def matrices(data, shear_factor):
    """Stiffness and mass matrix of the clamped blade; each node has two transverse deflections and the rotations about the two transverse
    axes."""
    step = LENGTH_M / ELEMENTS
    size = 4 * (ELEMENTS + 1)
    stiffness, mass = np.zeros((size, size)), np.zeros((size, size))
    for element in range(ELEMENTS):
        share = (element + 0.5) / ELEMENTS
        at = {name: np.interp(share, data["eta"], values) for name, values in data.items()}
        angle = np.radians(at["twist_deg"])
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        bending = turn @ np.diag([at["edge_stiffness_N_m2"], at["flap_stiffness_N_m2"]]) @ turn.T
        rotary = turn @ np.diag([at["second_moment_yy_kg_m"], at["second_moment_zz_kg_m"]]) @ turn.T
        curve, slide = np.zeros((2, 8)), np.zeros((2, 8))
        curve[0, [2, 6]] = curve[1, [3, 7]] = [-1.0 / step, 1.0 / step]
        slide[0, [0, 4, 3, 7]] = [-1.0 / step, 1.0 / step, -0.5, -0.5]
        slide[1, [1, 5, 2, 6]] = [-1.0 / step, 1.0 / step, 0.5, 0.5]
        # one integration point per element; the bending deflection that it misses is added to the shear flexibility
        across = np.array([[0.0, 1.0], [-1.0, 0.0]])
        missed = step**2 / 12.0 * np.linalg.inv(across @ bending @ across.T)
        shear = np.linalg.inv(np.eye(2) / (0.1 * at["axial_stiffness_N"] * shear_factor) + missed)
        own = step * (curve.T @ bending @ curve + slide.T @ shear @ slide)
        inertia = np.zeros((8, 8))
        for a in range(2):
            for b in range(2):
                weight = step * (1.0 / 3.0 if a == b else 1.0 / 6.0)
                inertia[4 * a : 4 * a + 2, 4 * b : 4 * b + 2] = np.eye(2) * at["mass_kg_m"] * weight
                inertia[4 * a + 2 : 4 * a + 4, 4 * b + 2 : 4 * b + 4] = rotary * weight
        place = slice(4 * element, 4 * element + 8)
        stiffness[place, place] += own
        mass[place, place] += inertia
    return stiffness[4:, 4:], mass[4:, 4:]


def main():
    """Prints five frequencies in Hz with shear and without."""
    with open(sys.argv[1], encoding="utf-8") as file:
        rows = list(csv.reader(line for line in file if not line.startswith("#")))
    data = {name: np.array([float(row[i]) for row in rows[1:]]) for i, name in enumerate(rows[0])}
    for name, factor in (("with shear", 1.0), ("without", 1e4)):
        squares = scipy.linalg.eigh(*matrices(data, factor), eigvals_only=True, subset_by_index=[0, 4])
        print(name, (np.sqrt(squares) / (2.0 * np.pi)).tolist())


if __name__ == "__main__":
    main()
