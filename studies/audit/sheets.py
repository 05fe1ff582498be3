"""Surfaces of the lattice close to each other: a wing that is folded flat, and leading-edge suction at a hinge near 0 degrees."""

from __future__ import annotations

import numpy as np
from machine import run

STIFF = """
[section.plate]
shape = "explicit"
axial_stiffness_N = 1e10
torsional_rigidity_N_m2 = 1e8
flap_stiffness_N_m2 = 1e8
edge_stiffness_N_m2 = 1e8
mass_kg_m = 100.0
second_moments_kg_m = [1.0, 0.0, 0.1]
"""
LOADS = [f"aero.load.outer[1].{what}.{axis}" for what in ("force", "moment") for axis in "xyz"]


def wing(lengths_m, chord_m, strips, chord_panels, axis, fold_deg, speed_m_s, incidence_deg, keys=""):
    """A stiff half wing on a wall with a locked fold."""
    incidence = np.radians(incidence_deg)
    wind = [0.0, float(-speed_m_s * np.cos(incidence)), float(speed_m_s * np.sin(incidence))]
    text = f'name = "Wing"\n{STIFF}'
    for name, length_m in zip(("inner", "outer"), lengths_m):
        text += f'[body.{name}]\nlength_m = {length_m}\nsection = "plate"\nelements = 1\nload_stations = 1\n'
    text += '[joint.mount]\ntype = "clamped"\nparent = "root"\nchild = "inner"\n[joint.fold]\ntype = "revolute"\n'
    text += f'parent = "inner"\nchild = "outer"\naxis = {axis}\nstart_angle_deg = {fold_deg}\nmotion = "locked"\n'
    text += f'[aerodynamics]\nmodel = "uvlm"\ndensity_kg_m3 = 1.2\nwind_m_s = {wind}\nwake_rows = 5\n'
    text += f"mirror_normal = [1.0, 0.0, 0.0]\n{keys}\n"
    for name, count in zip(("inner", "outer"), strips):
        text += f'[surface.{name}]\nbody = "{name}"\nchord_m = {chord_m}\nelastic_axis_fraction = 0.25\nstrips = {count}\n'
        text += f"chord_panels = {chord_panels}\n"
    return text + "[simulation]\nstop_time_s = 0.01\nstep_s = 0.01\n"


def lift_n(fold_deg, strips, chord_panels):
    """Lift in N of the folded wing, or the error message."""
    text = wing((0.6, 0.4), 0.2, strips, chord_panels, [0.0, 1.0, 0.0], -fold_deg, 10.0, 5.0)
    got = run(text, outputs=["aero.force.z"])
    return f"{got.columns['aero.force.z'][0]:.3f}" if got.columns else got.message[-60:]


def hinge_torque_n_m(fold_deg, suction):
    """Aerodynamic torque about a hinge flared by 20 degrees, in N·m."""
    flare, fold = np.radians(20.0), np.radians(fold_deg)
    axis = np.array([np.sin(flare), np.cos(flare), 0.0])
    keys = f"leading_edge_suction = {str(suction).lower()}"
    text = wing((0.365, 0.135), 0.078, (12, 5), 4, [float(x) for x in axis], fold_deg, 18.0, 10.0, keys)
    columns = run(text, outputs=LOADS).columns
    force, moment = (np.array([columns[name][0] for name in LOADS[i : i + 3]]) for i in (0, 3))
    arm = np.array([0.0675, 0.0, 0.0])
    along = axis * (axis @ arm)
    arm = along + (arm - along) * np.cos(fold) + np.cross(axis, arm) * np.sin(fold)
    return (moment + np.cross(arm, force)) @ axis


if __name__ == "__main__":
    for fold_deg, right in ((150, 2.78), (175, 2.70), (178, 2.67), (179, 2.66), (180, "refused")):
        lifts = [lift_n(fold_deg, *mesh) for mesh in (((6, 4), 2), ((12, 8), 4), ((24, 16), 4))]
        print(f"folded by {fold_deg} deg: lift {', '.join(lifts)} N on three meshes; right: {right}")
    for suction in (False, True):
        slope = (hinge_torque_n_m(0.3, suction) - hinge_torque_n_m(-0.3, suction)) / 0.6 * 1e3
        print(f"hinge torque near 0 deg, suction {suction}: {slope:.2f} mN.m/deg; right: that without suction")
