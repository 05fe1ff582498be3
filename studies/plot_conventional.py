#!/usr/bin/env python3
"""Figures 4 to 7 of Otsuka et al. from the tables that `cargo test --test verification conventional::` writes."""

import argparse
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

BLUE, ORANGE, GREEN, RED, GREY = "#0072b2", "#e69f00", "#009e73", "#d55e00", "#b0b0b0"
CONSTRAINTS = {
    "ball": ("gap_m", "|r_P − r_Q| (m)"),
    "universal": ("cardan", "|r_y^P · r_z^Q|"),
    "revolute": ("hinge", "|r_x^P + r_z^Q|"),
}


def table(path):
    """Columns of a CSV file with one header line, by name."""
    return np.genfromtxt(path, delimiter=",", names=True)


def draw(axes, pair, columns, labels):
    """Both methods over each other: the DAE broad and pale, joint parameters thin."""
    ours, dae = pair
    for column, label, color in zip(columns, labels, (BLUE, ORANGE, GREEN, RED)):
        axes.plot(dae["t_s"], dae[column], color=GREY, linewidth=4, solid_capstyle="round")
        axes.plot(ours["t_s"], ours[column], color=color, linewidth=1.1, label=label)
    axes.margins(y=0.2)
    axes.legend(fontsize=7, frameon=False, ncols=2)


def pendulum(results, joint, reference, output):
    """Strains, tip, energies, constraint, joint force of one double pendulum."""
    ours = table(results / f"double_pendulum_{joint}_joint_parameters.csv")
    dae = table(results / f"double_pendulum_{joint}_dae.csv")
    product = table(results / f"double_pendulum_{joint}_product.csv")
    pair = (ours, dae)
    figure, grid = plt.subplots(2, 3, figsize=(12, 6.2), layout="constrained")

    draw(grid[0, 0], pair, ("kx_1_m", "ky_1_m", "kz_1_m"), ("κx", "κy", "κz"))
    grid[0, 0].set(title="Curvatures of A's first element", ylabel="1/m")
    draw(grid[0, 1], pair, ("ex",), ("εx",))
    grid[0, 1].set(title="Extension of A's first element", ylabel="–")

    draw(grid[0, 2], pair, ("tip_x_m", "tip_y_m", "tip_z_m"), ("X", "Y", "Z"))
    for column in ("tip_x_m", "tip_y_m", "tip_z_m"):
        grid[0, 2].plot(product["t_s"][::8], product[column][::8], "k.", markersize=3)
    grid[0, 2].plot([], [], "k.", markersize=3, label="product, O(n)")
    if joint == "ball":
        rows = table(reference)
        for column, sign in (("tip_X", 1), ("tip_Y", 1), ("tip_Z", -1)):
            grid[0, 2].plot(rows["t_s"][::8], sign * rows[column][::8], "k+", markersize=5, markeredgewidth=0.6)
        grid[0, 2].plot([], [], "k+", markersize=5, label="Exudyn")
    grid[0, 2].legend(fontsize=7, frameon=False, ncols=2)
    grid[0, 2].set(title="Tip", ylabel="m")

    draw(grid[1, 0], pair, ("kinetic_j", "elastic_j", "gravity_j"), ("kinetic", "elastic", "gravity"))
    total = ours["kinetic_j"] + ours["elastic_j"] + ours["gravity_j"]
    grid[1, 0].plot(ours["t_s"], total, "k--", linewidth=0.8, label="total")
    grid[1, 0].legend(fontsize=7, frameon=False, ncols=2)
    grid[1, 0].set(title=f"Energies; total within {np.abs(total).max():.0e} J", ylabel="J", xlabel="time (s)")

    column, label = CONSTRAINTS[joint]
    floor = 1e-18
    grid[1, 1].semilogy(dae["t_s"], np.maximum(np.abs(dae[column]), floor), color=RED, linewidth=1, label="DAE")
    grid[1, 1].semilogy(
        ours["t_s"], np.maximum(np.abs(ours[column]), floor), color=BLUE, linewidth=1, label="joint parameters"
    )
    grid[1, 1].legend(fontsize=7, frameon=False)
    grid[1, 1].set(title=f"Constraint {label}", xlabel="time (s)", ylim=(1e-18, 1e-10))

    draw(grid[1, 2], pair, ("fx_n", "fy_n", "fz_n"), ("X", "Y", "Z"))
    grid[1, 2].set(title="Joint force on B; multipliers (pale), inward sum", ylabel="N", xlabel="time (s)")
    figure.suptitle(
        f"Double pendulum, ball and {joint} joint: joint parameters (thin, coloured) over the index-1 DAE (pale)",
        fontsize=11,
    )
    figure.savefig(output / f"double_pendulum_{joint}.png", dpi=100)
    plt.close(figure)


def two_bodies(results, reference, output):
    """Free end over time and the error of its RMS against the number of sections."""
    figure, grid = plt.subplots(1, 3, figsize=(13, 4.2), layout="constrained")
    rows = table(reference)
    for axes, column, letter in ((grid[0], "tip_x_m", "X"), (grid[1], "tip_z_m", "Z")):
        axes.plot(rows["t_s"], rows[f"tip_{letter}_m"], color=GREY, linewidth=5, label="Exudyn, 32 elements")
        for name, sections, color, label in (
            ("constant", 6, BLUE, "constant, 6 sections"),
            ("linear", 6, GREEN, "linear, 6 sections"),
            ("segments_half_root_spring", 6, ORANGE, "segments, 2EI/l at clamp, 6"),
            ("segments_whole_root_spring", 6, RED, "segments, EI/l at clamp, 6"),
        ):
            path = table(results / f"two_body_path_{name}_{sections}.csv")
            axes.plot(path["t_s"], path[column], color=color, linewidth=1, label=label)
        path = table(results / "two_body_path_segments_whole_root_spring_30.csv")
        axes.plot(path["t_s"], path[column], color=RED, linewidth=1, linestyle=":", label="segments, EI/l at clamp, 30")
        axes.set(title=f"{letter} of the free end", xlabel="time (s)", ylabel="m")
    grid[1].legend(fontsize=7, frameon=False)

    for name, color, label in (
        ("segments_whole_root_spring", RED, "segments, EI/l at clamp: order 1"),
        ("segments_half_root_spring", ORANGE, "segments, 2EI/l at clamp: order 2"),
        ("constant", BLUE, "constant elements: order 2"),
        ("linear", GREEN, "linear elements: order 4"),
    ):
        errors = table(results / f"two_body_error_{name}.csv")
        grid[2].loglog(errors["sections"], errors["error_converged"], "o-", color=color, markersize=3, label=label)
    grid[2].set(title="Error of RMS(Z) against the converged value", xlabel="sections per body", ylabel="–")
    grid[2].set_xticks([2, 4, 6, 10, 20, 30, 50], ["2", "4", "6", "10", "20", "30", "50"])
    grid[2].minorticks_off()
    grid[2].grid(True, linewidth=0.3)
    grid[2].legend(fontsize=7, frameon=False)
    figure.savefig(output / "two_body_convergence.png", dpi=100)
    plt.close(figure)


def main():
    """Reads the tables, writes the pictures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("results", type=Path, help="folder of the tables, target/verification")
    parser.add_argument("output", type=Path, help="folder of the pictures")
    parser.add_argument("--reference", type=Path, default=Path("tests/reference"), help="folder of the references")
    arguments = parser.parse_args()
    plt.rcParams.update({"font.size": 8, "axes.titlesize": 9, "axes.spines.top": False, "axes.spines.right": False})
    arguments.output.mkdir(parents=True, exist_ok=True)
    for joint in CONSTRAINTS:
        reference = arguments.reference / "double_pendulum_ball_ball_exudyn.csv"
        pendulum(arguments.results, joint, reference, arguments.output)
    two_bodies(arguments.results, arguments.reference / "two_body_exudyn_shear_rotary.csv", arguments.output)


if __name__ == "__main__":
    main()
