#!/usr/bin/env python3
"""Pictures of docs/guide/tutorial.md: those of the commands of that page, and of its gust alleviation.

Usage: plot_tutorial.py --foldwing target/release/foldwing --output docs/pictures; needs the Python package.
"""

import argparse
import runpy
import shutil
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

from house_style import BLUE, VERMILION, label_ends, mark, save, use  # noqa: E402

FOLDER = ROOT / "examples/tutorial"
MODEL = FOLDER / "sketch.toml"
DEPLOYED = ["--set", "fold1.start_angle=0", "--set", "fold2.start_angle=0"]


def by_the_command(foldwing, output):
    """Draws the figures of `simulate` and `flutter`, and one picture of a film."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        run = lambda *words: subprocess.run([foldwing, *words, "--quiet"], check=True, cwd=folder)  # noqa: E731
        run("simulate", MODEL, "--plot", "run")
        run("flutter", MODEL, *DEPLOYED, "--wind-m-s", "10:80:8", "--count", "4", "--plot", "flutter")
        run("render", MODEL, "--video", "film.png", "--from", "0.55", "--to", "0.6", "--fps", "1", "--speed", "1", "--size", "1000x560")
        shutil.copy(folder / "run/shapes.png", output / "tutorial_shapes.png")
        shutil.copy(folder / "run/fold_angles.png", output / "tutorial_fold_angles.png")
        shutil.copy(folder / "flutter/damping.png", output / "tutorial_flutter.png")
        shutil.copy(next(folder.glob("film*.png")), output / "tutorial_view.png")


def gust(output):
    """Draws strain and aileron angle in the gust, without and with feedback."""
    sys.argv = ["alleviate_gust.py", str(MODEL)]
    own = runpy.run_path(str(FOLDER / "alleviate_gust.py"), run_name="__main__")
    use()
    figure, (above, below) = plt.subplots(2, 1, figsize=(7, 4.6), sharex=True)
    for run, name, colour in [(own["free"], "fixed", BLUE), (own["damped"], "feedback", VERMILION)]:
        shown = run.time >= 1.5
        above.plot(run.time[shown], 1e6 * run[own["GAUGE"]][shown], color=colour, label=name)
        below.plot(run.time[shown], np.degrees(run[own["AILERON"]][shown]), color=colour, label=name)
    above.set(title="Gust of 1.5 m/s at 17.4 m/s", ylabel="root strain (µm/m)")
    below.set(xlabel="time (s)", ylabel="aileron (°)")
    below.set_xlim(1.5, 4.0)
    for axes in (above, below):
        label_ends(axes)
    for axes in (above, below):
        mark(axes, own["ON_S"], "on" if axes is above else "", at=0.15)
        mark(axes, 2.2, "gust" if axes is above else "", at=0.15)
    figure.align_ylabels()
    save(figure, output / "tutorial_gust.png")


def main():
    """Runs the command."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--foldwing", type=Path, required=True, help="the command")
    parser.add_argument("--output", type=Path, required=True, help="folder of the pictures")
    arguments = parser.parse_args()
    by_the_command(arguments.foldwing.resolve(), arguments.output)
    gust(arguments.output)


if __name__ == "__main__":
    main()
