#!/usr/bin/env python3
"""Error of a sinusoidal load over the communication step, from the table that `cargo test --test verification capabilities::` writes."""

import argparse
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

BLUE, ORANGE, GREY = "#0072b2", "#e69f00", "#b0b0b0"


def main():
    """Draws both errors with lines of first and second order."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("results", type=Path, help="folder with input_derivatives.csv")
    parser.add_argument("pictures", type=Path, help="folder of the picture")
    arguments = parser.parse_args()
    rows = np.genfromtxt(arguments.results / "input_derivatives.csv", delimiter=",", names=True)
    step_ms = 1e3 * rows["step_s"]

    figure, axes = plt.subplots(figsize=(6, 4), layout="constrained")
    for column, order, label, color in (
        ("held_rad", 1, "held within the step", ORANGE),
        ("with_derivatives_rad", 2, "with fmi2SetRealInputDerivatives", BLUE),
    ):
        through = rows[column][-1] * (step_ms / step_ms[-1]) ** order
        axes.loglog(step_ms, through, color=GREY, linewidth=4, solid_capstyle="round", label=f"order {order}")
        axes.loglog(step_ms, rows[column], "o-", color=color, label=label)
    axes.set_xticks(step_ms, [f"{step:g}" for step in step_ms])
    axes.set_xticks([], minor=True)
    axes.set(xlabel="communication step (ms)", ylabel="error of the fold angle at 64 ms (rad)")
    axes.set_title("Sinusoidal load of 20 Hz on the folding wing", fontsize=10)
    axes.legend(frameon=False, fontsize=8)
    axes.grid(which="both", color="#eeeeee")
    figure.savefig(arguments.pictures / "input_derivatives.png", dpi=110, metadata={"Software": None})


if __name__ == "__main__":
    main()
