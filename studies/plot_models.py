#!/usr/bin/env python3
"""Pictures of four example models: the roll fold, the flared wing tip in its gust, the slender wing in flight, the crane.

Usage: plot_models.py --foldwing target/release/foldwing --output docs/pictures
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

from house_style import BLUE, FAINT, GREEN, SMALL, VERMILION, label_ends, mark, save, use  # noqa: E402

MODELS = ROOT / "examples/models"
PLACES = 9  # points along a body


def with_stations(text):
    """The model text with load stations along the whole length of every body, which give its shape."""
    text = re.sub(r"^load_stations = .*\n", "", text, flags=re.MULTILINE)

    def stations(match):
        places = np.linspace(0.0, float(match[1]), PLACES)
        return f"{match[0]}\nload_station_positions_m = [{', '.join(f'{place:.6f}' for place in places)}]"

    return re.sub(r"^length_m = (\S+)(?=\nsection)", stations, text, flags=re.MULTILINE)


def simulate(foldwing, text):
    """Columns of a run of a model text by its own simulation settings."""
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
    """x and z of the points of the bodies, one body after the other."""
    names = [f"station.{body}[{i + 1}].position" for body in bodies for i in range(PLACES)]
    return [np.array([columns[f"{name}.{axis}"][row] for name in names]) for axis in "xz"]


def row_at(columns, time_s):
    return int(np.abs(columns["time"] - time_s).argmin())


def roll_fold(foldwing, text):
    """Draws shapes while the panels unroll, and fold angles with the times of latching."""
    run = simulate(foldwing, text)
    figure, (left, right) = plt.subplots(1, 2, figsize=(12, 4.6), gridspec_kw={"width_ratios": (1.25, 1)})
    figure.subplots_adjust(left=0.06, right=0.9, top=0.86, bottom=0.12, wspace=0.22)
    times_s = [0.0, 0.06, 0.1, run["fold_inner.latch_time"][-1], 0.6, 1.0, 1.3, run["fold_outer.latch_time"][-1]]
    for color, time_s in zip(plt.cm.YlGnBu(np.linspace(0.3, 0.98, len(times_s))), times_s):
        x, z = shape(run, ("inner", "middle", "outer"), row_at(run, time_s))
        left.plot(x, z, color=color, linewidth=2.2, solid_capstyle="round")
        left.plot(x[PLACES::PLACES], z[PLACES::PLACES], "o", color="white", markeredgecolor=color, markersize=4.5)
        along = np.array([x[-1] - x[-2], z[-1] - z[-2]])
        # the first three end among other lines: their labels are placed at the moving hinge, where there is space
        aside = {0.0: (-26, 13), 0.06: (-26, 4), 0.1: (26, 2)}.get(time_s)
        end = 2 * PLACES - 1 if aside else -1
        along = np.array([x[end] - x[end - 1], z[end] - z[end - 1]])
        along = aside or 19 * along / np.linalg.norm(along)
        left.annotate(f"{time_s:.2f} s", (x[end], z[end]), xytext=along, textcoords="offset points", ha="center", va="center", fontsize=SMALL,
                      bbox={"boxstyle": "square,pad=0.1", "facecolor": "white", "edgecolor": "none", "alpha": 0.8})
    left.set(title="Shapes from the side", xlabel="x (m)", ylabel="z (m)", aspect="equal")
    left.margins(0.08)
    for (joint, color), height in zip((("fold_inner", BLUE), ("fold_outer", VERMILION)), (0.97, 0.86)):
        latch_s = run[f"{joint}.latch_time"][-1]
        right.plot(run["time"], np.degrees(run[f"{joint}.angle"]), color=color, label=joint)
        mark(right, latch_s, f"latched, {latch_s:.4f} s", color, height)
    right.set(title="Folds", xlabel="time (s)", ylabel="fold angle (°)", xlim=(0.0, run["time"][-1]))
    label_ends(right)
    return figure


def flared_wing_tip(foldwing, text):
    """Draws shapes, fold angle and root moment in the gust, compared with a locked hinge."""
    start = re.search(r"^start_angle_deg = .*$", text, flags=re.MULTILINE)[0]
    runs = {
        "free, flared": (simulate(foldwing, text), BLUE),
        "locked where\nit floats": (simulate(foldwing, text.replace(start, start + '\nmotion = "locked"')), GREEN),
        "locked straight": (simulate(foldwing, text.replace(start, 'start_angle_deg = 0.0\nmotion = "locked"')), VERMILION),
    }
    figure, axes = plt.subplot_mosaic([["shapes", "shapes"], ["fold", "moment"]], figsize=(8.6, 6.4))
    left, middle, right = (axes[name] for name in ("shapes", "fold", "moment"))
    figure.subplots_adjust(left=0.085, right=0.85, top=0.95, bottom=0.085, wspace=0.62, hspace=0.42)
    for name, (run, color) in runs.items():
        moment = -run["root.moment.y"]
        middle.plot(run["time"], np.degrees(run["fold.angle"]), color=color, label=name)
        right.plot(run["time"], moment, color=color, label=f"{name}:\npeak {moment.max():.1f}")
        highest = int(run["tip.position.z"].argmax())
        left.plot(*shape(run, ("inner", "tip"), highest), color=color, linewidth=2, label=name)
    run = runs["free, flared"][0]
    left.plot(*shape(run, ("inner", "tip"), row_at(run, 0.29)), color=FAINT, label="free, before\nthe gust")
    left.set(title="Highest shapes from behind; z stretched", xlabel="x (m)", ylabel="z (m)")
    middle.set(title="Fold; negative is up", xlabel="time (s)", ylabel="fold angle (°)", ylim=(-21.0, 2.5))
    right.set(title="Bending at the root", xlabel="time (s)", ylabel="moment (N·m)", ylim=(None, 50.0))
    for axes in (middle, right):
        axes.axvspan(0.3, 0.3 + 5.0 / 20.0, color=FAINT, alpha=0.16, linewidth=0)
        axes.annotate("gust at the wing", (0.425, 0.985), xycoords=("data", "axes fraction"), ha="center", va="top", fontsize=SMALL, color=FAINT)
        axes.set_xlim(0.0, run["time"][-1])
    left.set_xlim(0.0, 1.62)
    for axes in (left, middle, right):
        label_ends(axes)
    return figure


def slender_wing(foldwing, text):
    """Draws shapes without loads, in flight and in the gust, and tip and root moment over time, each with separate axes."""
    run = simulate(foldwing, text)
    bare = text.replace('model = "strip"', 'model = "none"').replace("gravity_m_s2 = [0.0, 0.0, -9.81]", "gravity_m_s2 = [0.0, 0.0, 0.0]")
    figure = plt.figure(figsize=(12, 4.8))
    left, upper, lower = (figure.add_axes(place) for place in ([0.055, 0.12, 0.4, 0.74], [0.6, 0.55, 0.385, 0.34], [0.6, 0.12, 0.385, 0.34]))
    highest = int(run["tip.position.z"].argmax())
    for columns, row, color, label in ((simulate(foldwing, bare), 0, FAINT, "without loads"), (run, 0, BLUE, "in flight"),
                                       (run, highest, VERMILION, f"in the gust,\n{run['time'][highest]:.2f} s")):
        left.plot(*shape(columns, ("wing",), row), color=color, linewidth=2.2, label=label)
    left.set(title="Shapes from behind", xlabel="x (m)", ylabel="z (m)", aspect="equal", ylim=(-0.8, None))
    label_ends(left)
    upper.plot(run["time"], run["tip.position.z"], color=BLUE)
    upper.set(title="height of the tip (m)", xticklabels=[], ylim=(0.0, 8.0))
    lower.plot(run["time"], -1e-3 * run["root.moment.y"], color=BLUE)
    lower.set(title="bending moment at the root (kN·m)", xlabel="time (s)")
    for axes in (upper, lower):
        axes.axvspan(0.5, 1.0, color=FAINT, alpha=0.16, linewidth=0)
        axes.set_xlim(0.0, run["time"][-1])
    upper.annotate("gust at the wing", (0.75, 0.03), xycoords=("data", "axes fraction"), ha="center", va="bottom", fontsize=SMALL, color=FAINT)
    return figure


def jib_crane(foldwing, text):
    """Draws the crane while its trolley moves out, and positions, swing and the moment at the mast over time."""
    run = simulate(foldwing, text)
    figure, axes = plt.subplot_mosaic([["shapes", "travel"], ["shapes", "swing"], ["shapes", "mast"]], figsize=(12, 5.6),
                                      gridspec_kw={"width_ratios": (1.35, 1)})
    figure.subplots_adjust(left=0.06, right=0.97, top=0.93, bottom=0.1, wspace=0.2, hspace=0.62)
    left = axes["shapes"]
    times_s = [0.0, 1.0, 1.6, 2.4, 8.0]
    for color, time_s in zip(plt.cm.YlGnBu(np.linspace(0.35, 0.98, len(times_s))), times_s):
        row = row_at(run, time_s)
        left.plot(*shape(run, ("jib",), row), color=color, linewidth=2.2, solid_capstyle="round")
        x, z = (run[f"station.trolley[1].position.{axis}"][row] for axis in "xz")
        hook = [run[f"station.load[1].position.{axis}"][row] for axis in "xz"]
        turn = 2.0 * np.arctan2(run["station.load[1].rotation.y"][row], run["station.load[1].rotation.w"][row])
        end = [hook[0] - np.sin(turn), hook[1] - np.cos(turn)]
        left.plot([x, hook[0], end[0]], [z, hook[1], end[1]], color=color, linewidth=1.2)
        left.plot(x, z, "s", color=color, markersize=6)
        left.plot(*end, "o", color=color, markersize=11)
        left.annotate(f"{time_s:.1f} s", end, xytext=(0, -15), textcoords="offset points", ha="center", va="center", fontsize=SMALL)
    left.set(title="From the side", xlabel="x (m)", ylabel="z (m)", aspect="equal", xlim=(-0.1, 3.1), ylim=(0.6, 2.15))
    for name, values, title, label in (
        ("travel", run["travel.position"], "Trolley", "position (m)"),
        ("swing", np.degrees(run["rope.angle"]), "Rope against the trolley", "angle (°)"),
        ("mast", 1e-3 * run["internal_load.foot.moment.y"], "Bending at the mast", "moment (kN·m)"),
    ):
        axes[name].plot(run["time"], values, color=BLUE)
        axes[name].set(title=title, ylabel=label, xlim=(0.0, run["time"][-1]))
        if name != "mast":
            axes[name].set_xticklabels([])
    axes["mast"].set_xlabel("time (s)")
    axes["travel"].axhline(2.6, color=FAINT, linewidth=0.8)
    axes["travel"].annotate("command", (0.1, 2.6), xytext=(0, 3), textcoords="offset points", fontsize=SMALL, color=FAINT)
    axes["travel"].set_ylim(0.5, 3.0)
    return figure


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--foldwing", type=Path, required=True)
    parser.add_argument("--output", type=Path, required=True)
    arguments = parser.parse_args()
    use()
    for draw, folder in ((roll_fold, MODELS), (flared_wing_tip, MODELS), (slender_wing, MODELS), (jib_crane, ROOT / "examples/sliding")):
        text = (folder / f"{draw.__name__}.toml").read_text(encoding="utf-8")
        figure = draw(arguments.foldwing.resolve(), text)
        save(figure, arguments.output / f"{draw.__name__}.png")


if __name__ == "__main__":
    main()
