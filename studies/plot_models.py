#!/usr/bin/env python3
"""Pictures of three example models: the roll fold, the flared wing tip in its gust, the slender wing in flight.

Usage: plot_models.py --foldwing target/release/foldwing --output docs/pictures
"""

import argparse
import csv
import re
import subprocess
import tempfile
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

MODELS = Path(__file__).resolve().parents[1] / "examples/models"
BLUE, ORANGE, GREEN, RED, GREY = "#0072b2", "#e69f00", "#009e73", "#d55e00", "#9a9a9a"
PLACES = 9  # points along a body


def with_stations(text):
    """The model text with load stations from end to end of every body, which then tell its shape."""
    text = re.sub(r"^load_stations = .*\n", "", text, flags=re.MULTILINE)

    def stations(match):
        places = np.linspace(0.0, float(match[1]), PLACES)
        return f"{match[0]}\nload_station_positions_m = [{', '.join(f'{place:.6f}' for place in places)}]"

    return re.sub(r"^length_m = (\S+)(?=\nsection)", stations, text, flags=re.MULTILINE)


def simulate(foldwing, text):
    """Columns of a run of a model text by its default experiment."""
    with tempfile.TemporaryDirectory() as folder:
        model, table = Path(folder) / "model.toml", Path(folder) / "run.csv"
        model.write_text(with_stations(text), encoding="utf-8")
        subprocess.run([foldwing, "simulate", model, "--quiet", "--csv", table], check=True)
        with table.open(encoding="utf-8") as lines:
            rows = list(csv.reader(lines))
    number = {"true": 1.0, "false": 0.0}
    values = np.array([[number.get(item) if item in number else float(item) for item in row] for row in rows[1:]])
    return dict(zip(rows[0], values.T))


def shape(columns, bodies, row):
    """x and z of the bodies' points, one body after the other."""
    names = [f"station.{body}[{i + 1}].position" for body in bodies for i in range(PLACES)]
    return [np.array([columns[f"{name}.{axis}"][row] for name in names]) for axis in "xz"]


def row_at(columns, time_s):
    return int(np.abs(columns["time"] - time_s).argmin())


def roll_fold(foldwing, text):
    """Shapes as the panels unroll; fold angles with the instants of latching."""
    run = simulate(foldwing, text)
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.2), layout="constrained")
    times_s = [0.0, 0.06, 0.1, run["fold_inner.latch_time"][-1], 0.6, 1.0, 1.3, run["fold_outer.latch_time"][-1]]
    for color, time_s in zip(plt.cm.viridis(np.linspace(0.0, 0.92, len(times_s))), times_s):
        x, z = shape(run, ("inner", "middle", "outer"), row_at(run, time_s))
        left.plot(x, z, color=color, linewidth=2, label=f"{time_s:.2f} s")
        left.plot(x[PLACES::PLACES], z[PLACES::PLACES], "o", color=color, markersize=4)
    left.set(title="Shapes, from the side", xlabel="x (m)", ylabel="z (m)", aspect="equal", ylim=(-0.3, 0.06))
    left.legend(fontsize=8, frameon=False, ncols=4, loc="lower center")
    for joint, color in (("fold_inner", BLUE), ("fold_outer", ORANGE)):
        latch_s = run[f"{joint}.latch_time"][-1]
        right.plot(run["time"], np.degrees(run[f"{joint}.angle"]), color=color, label=f"{joint}, latched at {latch_s:.4f} s")
        right.axvline(latch_s, color=color, linewidth=0.8, linestyle="--")
    right.set(title="Fold angles", xlabel="time (s)", ylabel="degrees")
    right.legend(fontsize=9, frameon=False)
    return figure


def flared_wing_tip(foldwing, text):
    """Shapes, fold angle and root moment in the gust, against a hinge that is locked."""
    start = re.search(r"^start_angle_deg = .*$", text, flags=re.MULTILINE)[0]
    runs = {
        "free, flared hinge": (simulate(foldwing, text), BLUE, "-"),
        "locked where it floats": (simulate(foldwing, text.replace(start, start + '\nmotion = "locked"')), GREEN, "--"),
        "locked straight": (simulate(foldwing, text.replace(start, 'start_angle_deg = 0.0\nmotion = "locked"')), RED, "-."),
    }
    figure, (left, middle, right) = plt.subplots(1, 3, figsize=(13, 4.0), layout="constrained")
    for name, (run, color, style) in runs.items():
        moment = -run["root.moment.y"]
        peak = int(moment.argmax())
        middle.plot(run["time"], np.degrees(run["fold.angle"]), style, color=color, label=name)
        right.plot(run["time"], moment, style, color=color, label=f"{name}: {moment[peak]:.1f} N·m")
        highest = int(run["tip.position.z"].argmax())
        left.plot(*shape(run, ("inner", "tip"), highest), style, color=color, label=f"{name}, highest")
    left.plot(*shape(runs["free, flared hinge"][0], ("inner", "tip"), row_at(run, 0.29)), color=GREY, label="before the gust")
    left.set(title="Shapes, from behind; z stretched", xlabel="x (m)", ylabel="z (m)")
    middle.set(title="Fold angle; negative is up", xlabel="time (s)", ylabel="degrees")
    right.set(title="Bending moment at the root", xlabel="time (s)", ylabel="N·m")
    right.set_ylim(top=50.0)
    for axes in (middle, right):
        axes.axvspan(0.3, 0.3 + 5.0 / 20.0, color=GREY, alpha=0.2, linewidth=0, label="gust at the wing")
    for axes in (left, middle, right):
        axes.legend(fontsize=8, frameon=False)
    return figure


def slender_wing(foldwing, text):
    """Shapes without loads, in flight and in the gust; tip and root moment over time."""
    run = simulate(foldwing, text)
    bare = text.replace('model = "strip"', 'model = "none"').replace("gravity_m_s2 = [0.0, 0.0, -9.81]", "gravity_m_s2 = [0.0, 0.0, 0.0]")
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.2), layout="constrained")
    highest = int(run["tip.position.z"].argmax())
    for columns, row, color, label in ((simulate(foldwing, bare), 0, GREY, "without loads"), (run, 0, BLUE, "in flight"),
                                       (run, highest, RED, f"in the gust, at {run['time'][highest]:.2f} s")):
        left.plot(*shape(columns, ("wing",), row), color=color, linewidth=2, label=label)
    left.set(title="Shapes, from behind", xlabel="x (m)", ylabel="z (m)", aspect="equal")
    left.legend(fontsize=9, frameon=False)
    right.plot(run["time"], run["tip.position.z"], color=BLUE, label="height of the tip (m)")
    right.set(title="Height of the tip, bending moment at the root", xlabel="time (s)", ylabel="m")
    twin = right.twinx()
    twin.plot(run["time"], -1e-3 * run["root.moment.y"], color=ORANGE)
    right.plot([], [], color=ORANGE, label="moment at the root (kN·m, right)")
    twin.set_ylabel("kN·m")
    right.axvspan(0.5, 1.0, color=GREY, alpha=0.2, linewidth=0, label="gust at the wing")
    right.legend(fontsize=8, frameon=False)
    return figure


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--foldwing", type=Path, required=True)
    parser.add_argument("--output", type=Path, required=True)
    arguments = parser.parse_args()
    for draw in (roll_fold, flared_wing_tip, slender_wing):
        text = (MODELS / f"{draw.__name__}.toml").read_text(encoding="utf-8")
        figure = draw(arguments.foldwing.resolve(), text)
        figure.savefig(arguments.output / f"{draw.__name__}.png", dpi=100)
        plt.close(figure)


if __name__ == "__main__":
    main()
