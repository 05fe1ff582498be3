#!/usr/bin/env python3
"""Figures 4 to 7 of Otsuka et al. from the tables that `cargo test --test verification conventional::` writes."""

import argparse
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "examples"))

from house_style import BLACK, BLUE, GREEN, INK, ORANGE, SMALL, VERMILION, label_ends, number, save, use  # noqa: E402

FLOOR = 1e-18  # below round-off: replaces zero on a logarithmic axis
CONSTRAINTS = {
    "ball": ("gap_m", "gap |r_P − r_Q| (m)"),
    "universal": ("cardan", "|r_y^P · r_z^Q| (–)"),
    "revolute": ("hinge", "|r_x^P + r_z^Q| (–)"),
}
# the compared quantities: columns, names, heading with unit, unit of the difference
COMPARED = (
    (("kx_1_m", "ky_1_m", "kz_1_m"), ("κx", "κy", "κz"), "curvature of A's first element (1/m)", "1/m"),
    (("ex",), ("εx",), "extension of A's first element (10⁻⁶)", "–"),
    (("tip_x_m", "tip_y_m", "tip_z_m"), ("X", "Y", "Z"), "position of the tip (m)", "m"),
    (("fx_n", "fy_n", "fz_n"), ("X", "Y", "Z"), "joint force on B (N)", "N"),
)
COLOURS = (BLUE, VERMILION, GREEN)
WIDTH_IN = 8.6  # width at which the documents show the figures, so that letters have their size


def table(path):
    """Columns of a CSV file with one header line, by name."""
    return np.genfromtxt(path, delimiter=",", names=True)


def powers(axis):
    """Labels powers of ten of a logarithmic axis without exponents, which would be smaller than the other letters."""
    axis.set_major_formatter(lambda value, _: number(f"1e{round(np.log10(value))}"))


def pendulum(results, joint, reference, output):
    """Draws one double pendulum: motion at the left, difference of the two methods at the right; energies and the constraint."""
    ours = table(results / f"double_pendulum_{joint}_joint_parameters.csv")
    dae = table(results / f"double_pendulum_{joint}_dae.csv")
    product = table(results / f"double_pendulum_{joint}_product.csv")
    figure, grid = plt.subplots(5, 2, figsize=(WIDTH_IN, 11.0), sharex=True)
    figure.subplots_adjust(left=0.075, right=0.89, top=0.915, bottom=0.045, wspace=0.36, hspace=0.30)
    for (upper, lower), (columns, names, heading, unit) in zip(grid, COMPARED):
        factor = 1e6 if columns == ("ex",) else 1.0
        for column, name, colour in zip(columns, names, COLOURS):
            upper.plot(ours["t_s"], factor * ours[column], color=colour, linewidth=1.2, label=name)
            difference = np.maximum(np.abs(ours[column] - dae[column]), FLOOR)
            lower.semilogy(ours["t_s"], difference, color=colour, linewidth=1.0, label=name)
        upper.set_title(heading, fontsize=10)
        lower.set_title(f"difference of the two methods ({unit})", fontsize=10)
    tip = grid[2, 0]
    for column in ("tip_x_m", "tip_y_m", "tip_z_m"):
        tip.plot(product["t_s"][::8], product[column][::8], ".", color=INK, markersize=3.5)
    others = "dots: O(n) of the product"
    if joint == "ball":
        rows = table(reference)
        for column, sign in (("tip_X", 1), ("tip_Y", 1), ("tip_Z", -1)):
            tip.plot(rows["t_s"][::8], sign * rows[column][::8], "+", color=INK, markersize=6, markeredgewidth=0.6)
        others += "; +: Exudyn"
    tip.set_ylim(bottom=-4.4)
    tip.annotate(others, (0.03, 0.03), xycoords="axes fraction", fontsize=SMALL, color=INK)

    energy, constraint = grid[4]
    for column, name, colour in (("kinetic_j", "kinetic", BLUE), ("elastic_j", "elastic", ORANGE), ("gravity_j", "gravity", GREEN)):
        energy.plot(ours["t_s"], ours[column], color=colour, linewidth=1.2, label=name)
    total = ours["kinetic_j"] + ours["elastic_j"] + ours["gravity_j"]
    energy.plot(ours["t_s"], total, color=BLACK, linestyle=(0, (4, 3)), linewidth=1.0, label="total")
    energy.set_title(f"energy (J); total within {np.abs(total).max():.0e}".replace("-", "−"), fontsize=10)
    column, label = CONSTRAINTS[joint]
    constraint.semilogy(dae["t_s"], np.maximum(np.abs(dae[column]), FLOOR), color=VERMILION, linewidth=1, label="DAE")
    constraint.semilogy(ours["t_s"], np.maximum(np.abs(ours[column]), FLOOR), color=BLUE, linewidth=1, label="joint\nparameters")
    constraint.set_title(f"constraint {label}", fontsize=10)
    constraint.set_ylim(FLOOR, 1e-10)
    for axes in grid.flat:
        axes.set_xlim(ours["t_s"][0], ours["t_s"][-1])
    for axes in grid[4]:
        axes.set_xlabel("time (s)")
    for axes in grid[:, 1]:
        powers(axes.yaxis)
    for axes in grid.flat:
        label_ends(axes)
    figure.text(0.012, 0.973, f"Double pendulum, ball and {joint} joint", fontsize=13.5, weight="bold")
    figure.text(0.012, 0.950, "left: joint parameters; right: their difference to the index-1 DAE of the conventional form", fontsize=SMALL + 1)
    save(figure, output / f"double_pendulum_{joint}.png")


def two_bodies(results, reference, output):
    """Draws the free end over time, its difference from the reference, and the error of its RMS over the number of sections."""
    figure, found = plt.subplot_mosaic([["end", "error"], ["difference", "difference"]], figsize=(WIDTH_IN, 7.8))
    figure.subplots_adjust(left=0.08, right=0.84, top=0.88, bottom=0.07, wspace=0.75, hspace=0.32)
    grid = [found[name] for name in ("end", "difference", "error")]
    rows = table(reference)
    shown = (
        ("constant", 6, BLUE, "constant, 6"),
        ("linear", 6, GREEN, "linear, 6"),
        ("segments_half_root_spring", 6, ORANGE, "segments,\n2EI/l at clamp, 6"),
        ("segments_whole_root_spring", 6, VERMILION, "segments,\nEI/l at clamp, 6"),
        ("segments_whole_root_spring", 30, BLACK, "segments,\nEI/l at clamp, 30"),
    )
    grid[0].plot(rows["t_s"], rows["tip_Z_m"], color=BLACK, linewidth=1.4, label="Exudyn,\n32 elements")
    for name, sections, colour, label in shown:
        path = table(results / f"two_body_path_{name}_{sections}.csv")
        at = np.interp(rows["t_s"], path["t_s"], path["tip_z_m"])
        if name == "segments_whole_root_spring" and sections == 6:
            grid[0].plot(path["t_s"], path["tip_z_m"], color=colour, linewidth=1.1, label=label)
        grid[1].semilogy(rows["t_s"], np.maximum(np.abs(at - rows["tip_Z_m"]), 1e-6), color=colour, linewidth=1.1, label=label)
    grid[0].set(xlabel="time (s)", ylabel="Z of the free end (m)", title="Free end, coarsest mesh")
    grid[1].set(xlabel="time (s)", ylabel="difference in Z to Exudyn (m)", title="Difference; number: sections per body")
    for name, colour, label in (
        ("segments_whole_root_spring", VERMILION, "segments, EI/l\nat clamp: order 1"),
        ("segments_half_root_spring", ORANGE, "segments, 2EI/l\nat clamp: order 2"),
        ("constant", BLUE, "constant elements:\norder 2"),
        ("linear", GREEN, "linear elements:\norder 4"),
    ):
        errors = table(results / f"two_body_error_{name}.csv")
        grid[2].loglog(errors["sections"], errors["error_converged"], "o-", color=colour, markersize=3.5, label=label)
    grid[2].set(xlabel="sections per body", ylabel="relative error of RMS(Z) (–)", title="Error of the RMS")
    grid[2].set_xticks([2, 4, 6, 10, 20, 30, 50], ["2", "4", "6", "10", "20", "30", "50"])
    grid[2].minorticks_off()
    powers(grid[1].yaxis)
    powers(grid[2].yaxis)
    for axes in grid:
        axes.set_xlim(axes.get_xlim()[0] if axes is grid[2] else 0.0, axes.get_xlim()[1] if axes is grid[2] else rows["t_s"][-1])
        label_ends(axes)
    figure.text(0.012, 0.955, "Two bodies and a joint: elements of strain against rigid segments", fontsize=13.5, weight="bold")
    save(figure, output / "two_body_convergence.png")


def main():
    """Reads the tables and writes the pictures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("results", type=Path, help="folder of the tables, target/verification")
    parser.add_argument("output", type=Path, help="folder of the pictures")
    parser.add_argument("--reference", type=Path, default=Path("tests/reference"), help="folder of the references")
    arguments = parser.parse_args()
    use()
    arguments.output.mkdir(parents=True, exist_ok=True)
    for joint in CONSTRAINTS:
        reference = arguments.reference / "double_pendulum_ball_ball_exudyn.csv"
        pendulum(arguments.results, joint, reference, arguments.output)
    two_bodies(arguments.results, arguments.reference / "two_body_exudyn_shear_rotary.csv", arguments.output)


if __name__ == "__main__":
    main()
