"""Geometrically exact solution of the NREL 5 MW blade with a tenth of its stiffness under a dead force at the tip.

Independent of the engine, for the test WT-36: a rod that stretches, twists and bends but does not shear, as an initial-value
problem from the root (scipy's DOP853 at 1e-11, restarted at every station). Newton's method finds the three components of the root
moment for which the moment at the tip is zero. Sections are interpolated linearly between the stations of the table; the twist is a
natural cubic spline.

    python studies/soft_blade.py examples/turbine/nrel_5mw_blade.csv
"""

import csv
import sys

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

LENGTH_M = 61.5
SOFTER = 0.1


def table(path):
    """Columns of the section file, by name."""
    with open(path, encoding="utf-8") as file:
        rows = list(csv.reader(line for line in file if not line.startswith("#")))
    return {name: np.array([float(row[i]) for row in rows[1:]]) for i, name in enumerate(rows[0])}


def main():
    """Prints position and rotation of the tip for a few forces."""
    data = table(sys.argv[1])
    s_m = data["eta"] * LENGTH_M
    names = ("axial_stiffness_N", "torsional_rigidity_N_m2", "flap_stiffness_N_m2", "edge_stiffness_N_m2")
    stiffness = np.array([SOFTER * data[name] for name in names])
    twist = CubicSpline(s_m, np.radians(data["twist_deg"]), bc_type="natural")

    def slope(s, state, force):
        frame, moment = state[3:12].reshape(3, 3), state[12:15]
        own = [np.interp(s, s_m, row) for row in stiffness]
        stretch = frame[:, 0] @ force / own[0]
        curvature = frame.T @ moment / own[1:] + np.array([twist(s, 1), 0.0, 0.0])
        k = curvature
        hat = np.array([[0, -k[2], k[1]], [k[2], 0, -k[0]], [-k[1], k[0], 0]])
        tangent = (1.0 + stretch) * frame[:, 0]
        return np.concatenate([tangent, (frame @ hat).ravel(), -np.cross(tangent, force)])

    def tip(root_moment, force):
        angle = twist(0.0)
        first = np.array([[1, 0, 0], [0, np.cos(angle), -np.sin(angle)], [0, np.sin(angle), np.cos(angle)]])
        state = np.concatenate([np.zeros(3), first.ravel(), root_moment])
        for start, end in zip(s_m[:-1], s_m[1:]):
            state = solve_ivp(slope, (start, end), state, "DOP853", args=(force,), rtol=1e-11, atol=1e-9).y[:, -1]
        return state

    for target in ([0.0, 0.0, 5e3], [0.0, 0.0, 2e4], [-3e3, 8e3, 2e4]):
        target = np.array(target)
        moment = np.zeros(3)
        for share in np.linspace(0.125, 1.0, 8):
            force = share * target
            for _ in range(20):
                end = tip(moment, force)
                if np.abs(end[12:15]).max() < 1e-3:
                    break
                columns = [(tip(moment + h, force)[12:15] - end[12:15]) / 100.0 for h in 100.0 * np.eye(3)]
                moment = moment - np.linalg.solve(np.array(columns).T, end[12:15])
        print(f"force {target.tolist()} N: tip {end[:3].tolist()} m, root moment {moment.tolist()} N m")


if __name__ == "__main__":
    main()
