#!/usr/bin/env python3
"""Error due to a sinusoidal load as a function of the communication step, from the table that `cargo test --test verification
capabilities::` writes."""

import argparse
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "examples"))

from house_style import BLUE, GRID, VERMILION, save, use  # noqa: E402


def main():
    """Draws both errors with lines of first and second order."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("results", type=Path, help="folder with input_derivatives.csv")
    parser.add_argument("pictures", type=Path, help="folder of the picture")
    arguments = parser.parse_args()
    rows = np.genfromtxt(arguments.results / "input_derivatives.csv", delimiter=",", names=True)
    step_ms = 1e3 * rows["step_s"]

    use()
    figure, axes = plt.subplots(figsize=(7.2, 4.6), layout="constrained")
    for column, order, label, color in (
        ("held_rad", 1, "held within the step; order 1 shaded", VERMILION),
        ("with_derivatives_rad", 2, "with fmi2SetRealInputDerivatives; order 2 shaded", BLUE),
    ):
        through = rows[column][-1] * (step_ms / step_ms[-1]) ** order
        axes.loglog(step_ms, through, color=GRID, linewidth=5, zorder=0)
        axes.loglog(step_ms, rows[column], "o-", color=color, markersize=4, label=label)
    axes.set_xticks(step_ms, [f"{step:g}" for step in step_ms])
    axes.set_xticks([], minor=True)
    axes.set(xlabel="communication step (ms)", ylabel="error of the fold angle at 64 ms (rad)", title="Sinusoidal load of 20 Hz on the folding wing")
    axes.legend()
    save(figure, arguments.pictures / "input_derivatives.png")


if __name__ == "__main__":
    main()
