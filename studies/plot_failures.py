#!/usr/bin/env python3
"""Pictures of the folding wings of `examples/failures`, each compared with the intact machine.

Usage: plot_failures.py --foldwing target/release/foldwing --output docs/pictures
"""

import argparse
import csv
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "examples"))

from house_style import BLUE, FAINT, VERMILION, label_ends, mark, save, use  # noqa: E402

MODELS = ROOT / "examples/failures"


def simulate(foldwing, text):
    """Columns of a run of a model text."""
    with tempfile.TemporaryDirectory() as folder:
        model, table = Path(folder) / "model.toml", Path(folder) / "run.csv"
        model.write_text(text, encoding="utf-8")
        subprocess.run([foldwing, "simulate", model, "--quiet", "--csv", table], check=True)
        with table.open(encoding="utf-8") as lines:
            rows = list(csv.reader(lines))
    number = {"true": 1.0, "false": 0.0}
    values = np.array([[number.get(item) if item in number else float(item) for item in row] for row in rows[1:]])
    return dict(zip(rows[0], values.T))


def both(foldwing, name):
    """Runs of the machine that fails, and of the same machine without failures."""
    text = (MODELS / f"{name}.toml").read_text(encoding="utf-8")
    sound = re.sub(r"^\[failure\..*?(?=^\[(?!failure)|\Z)", "", text, flags=re.DOTALL | re.MULTILINE)
    return simulate(foldwing, text), simulate(foldwing, sound)


def frame(title, ylabel):
    figure, axes = plt.subplots(figsize=(7, 3.2))
    figure.subplots_adjust(left=0.1, right=0.84, top=0.86, bottom=0.16)
    axes.set(title=title, xlabel="time (s)", ylabel=ylabel)
    return figure, axes


def fold(foldwing, name, failure, title):
    """Draws the fold angle of a wing compared with the intact one."""
    failing, sound = both(foldwing, name)
    figure, axes = frame(title, "fold angle (°)")
    axes.plot(sound["time"], np.degrees(sound["fold.angle"]), color=FAINT, label="intact")
    axes.plot(failing["time"], np.degrees(failing["fold.angle"]), color=VERMILION, label="with failure")
    axes.set_xlim(0.0, failing["time"][-1])
    mark(axes, failing[f"failure.{failure}.time"][-1], "failure", VERMILION, 0.98)
    label_ends(axes)
    return figure


def motor_loss(foldwing):
    return fold(foldwing, "motor_loss", "motor", "Loss of the motor during deployment")


def latch_no_capture(foldwing):
    return fold(foldwing, "latch_no_capture", "latch", "A latch that does not close")


def one_side_unfolds(foldwing):
    """Draws the fold angles of both sides and the roll of the aircraft."""
    failing, sound = both(foldwing, "one_side_unfolds")
    figure, axes = frame("The left motor jams, the right wing unfolds", "angle (°)")

    def roll_deg(run):
        return np.degrees(2.0 * np.arctan2(run["flight.rotation.y"], run["flight.rotation.w"]))

    axes.plot(failing["time"], np.degrees(failing["fold_right.angle"]), color=BLUE, label="right fold")
    axes.plot(failing["time"], np.degrees(failing["fold_left.angle"]), color=BLUE, linestyle="--", label="left fold")
    axes.plot(failing["time"], roll_deg(failing), color=VERMILION, label="roll")
    axes.plot(sound["time"], roll_deg(sound), color=FAINT, label="roll, both\nunfold")
    axes.set_xlim(0.0, failing["time"][-1])
    label_ends(axes)
    return figure


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--foldwing", type=Path, required=True)
    parser.add_argument("--output", type=Path, required=True)
    arguments = parser.parse_args()
    use()
    for draw in (motor_loss, latch_no_capture, one_side_unfolds):
        save(draw(arguments.foldwing.resolve()), arguments.output / f"{draw.__name__}.png")


if __name__ == "__main__":
    main()
