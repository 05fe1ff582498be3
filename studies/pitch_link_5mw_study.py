#!/usr/bin/env python3
"""Effect of the gears that remain in the pitch circuit on the flexible blade of the NREL 5 MW turbine: the maximum root strain after the
pitch link has opened, with static polars and with dynamic stall.

Usage: pitch_link_5mw_study.py --foldwing target/release/foldwing --output docs/pictures --table docs/tables/pitch_link_5mw.md
"""

import argparse
import csv
import os
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "examples"))
sys.path.insert(0, str(ROOT / "studies"))

from house_style import BLUE, FAINT, GREEN, VERMILION, label_ends, mark, save, use  # noqa: E402
from pitch_link_study import changed  # noqa: E402

MODEL = ROOT / "examples/failures/pitch_link_5mw.toml"
INERTIAS_KG_M2 = np.array([0.0, 1e3, 3e3, 1e4, 2e4, 3e4, 5e4, 1e5, 2e5, 3e5])
SHOWN = ((0.0, VERMILION), (3e4, BLUE), (3e5, GREEN))
OPENS_S = 30.0
OUTPUTS = "gauge.flap.strain,gauge.edge.strain,pitch.angle,shaft.angular_velocity"


def simulate(foldwing, folder, name, inertia_kg_m2, dynamic_stall):
    """Columns of a run with the given gear inertia, and the strain around the circumference of the root."""
    text = changed(MODEL.read_text(encoding="utf-8"), r"(?<=\[joint\.pitch\.motor\]\ninertia_kg_m2 = )[-+.e0-9]+", repr(float(inertia_kg_m2)))
    polars = (MODEL.parent / "../turbine/polars").resolve()
    text = text.replace('"../turbine/polars/', f'"{Path(os.path.relpath(polars, folder)).as_posix()}/')
    if dynamic_stall:
        text = changed(text, r'^pitch_rate = "air"', "dynamic_stall = true")
    (folder / f"{name}.toml").write_text(text, encoding="utf-8")
    done = subprocess.run([foldwing, "simulate", f"{name}.toml", "--quiet", "--csv", f"{name}.csv", "--variables", OUTPUTS], capture_output=True, text=True, cwd=folder, check=False)
    if done.returncode:
        raise SystemExit(f"{inertia_kg_m2}: {done.stderr}")
    with (folder / f"{name}.csv").open(encoding="utf-8") as lines:
        rows = list(csv.reader(lines))
    run = dict(zip(rows[0], np.array([[float(item) for item in row] for row in rows[1:]]).T))
    run["strain"] = np.hypot(run["gauge.flap.strain"], run["gauge.edge.strain"])
    run["after"] = run["time"] >= OPENS_S
    run["before"] = (run["time"] > 20.0) & ~run["after"]
    return run


def figures(run):
    """Maximum strain before and after, its time after the opening in s, minimum pitch in the first two seconds and maximum pitch in degrees, time to half speed in s."""
    after, time = run["after"], run["time"][run["after"]] - OPENS_S
    strain, pitch, speed = run["strain"][after], np.degrees(run["pitch.angle"][after]), run["shaft.angular_velocity"][after]
    half_s = time[np.argmax(speed < 0.5 * speed[0])]
    return run["strain"][run["before"]].max(), strain.max(), time[strain.argmax()], pitch[time <= 2.0].min(), pitch.max(), half_s


def draw(runs):
    """Pitch, strain and speed over time on the left, the maximum strain over the inertia on the right."""
    figure = plt.figure(figsize=(13, 6.4))
    grid = figure.add_gridspec(3, 2, left=0.05, right=0.97, top=0.94, bottom=0.09, hspace=0.34, wspace=0.26, width_ratios=(1.25, 1.0))
    left = [figure.add_subplot(grid[row, 0]) for row in range(3)]
    right = figure.add_subplot(grid[:, 1])
    for inertia_kg_m2, colour in SHOWN:
        run = runs[inertia_kg_m2, False]
        time, label = run["time"] - OPENS_S, f"{inertia_kg_m2 / 1000.0:.0f} t·m²"
        left[0].plot(time, np.degrees(run["pitch.angle"]), color=colour, label=label)
        left[1].plot(time, 1e3 * run["strain"], color=colour, label=label)
        left[2].plot(time, run["shaft.angular_velocity"], color=colour, label=label)
    left[0].set(title="Pitch angle (°), negative to feather", ylim=(-120.0, 100.0))
    left[1].set(title="Strain at the root (10⁻³)", ylim=(0.0, 3.8))
    left[2].set(title="Rotor speed (rad/s)", xlabel="time after the pitch link has opened (s)", ylim=(-0.2, 1.5))
    for place in left:
        place.set_xlim(-1.0, 10.0)
        place.label_outer()
        label_ends(place)
    mark(left[2], 0.5, "brake", FAINT, 0.3)
    for dynamic_stall, colour, label in ((False, VERMILION, "static polars"), (True, BLUE, "dynamic stall")):
        largest = [1e3 * figures(runs[inertia, dynamic_stall])[1] for inertia in INERTIAS_KG_M2]
        right.plot(INERTIAS_KG_M2 / 1000.0, largest, "o-", color=colour, markersize=4.5, label=label)
    right.legend(frameon=False, loc="upper right")
    before = 1e3 * figures(runs[0.0, False])[0]
    right.axhline(before, color=FAINT, linewidth=1.0)
    right.annotate("in operation", (300.0, before), xytext=(0, -12), textcoords="offset points", color=FAINT, ha="right")
    right.set(
        title="Maximum strain at the root after the failure (10⁻³)",
        xlabel="remaining inertia in the pitch circuit (t·m²)", ylim=(0.0, 3.8)
    )
    right.set_xscale("symlog", linthresh=1.0)
    right.set_xlim(-0.05, 400.0)
    right.set_xticks([0, 1, 3, 10, 30, 100, 300], ["0", "1", "3", "10", "30", "100", "300"])
    right.minorticks_off()
    return figure


def table(runs):
    """Figures in Markdown."""
    lines = ["# Pitch-link failure of the flexible blade of the 5 MW turbine", "",
             "`studies/pitch_link_5mw_study.py`: `examples/failures/pitch_link_5mw.toml` over the inertia of the remaining gears. The blade itself has 28.1 t·m² about",
             "its pitch axis. Columns: maximum strain (10⁻³) on the circumference of the root; minimum pitch within two seconds; time to half speed.", "",
             "| inertia (t·m²) | strain before | after, static polars | minimum pitch (°) | half speed (s) | after, dynamic stall | minimum pitch (°) | half speed (s) |",
             "|---|---|---|---|---|---|---|---|"]
    for inertia in INERTIAS_KG_M2:
        plain, dynamic = (figures(runs[inertia, stall]) for stall in (False, True))
        lines.append(f"| {inertia / 1000.0:g} | {1e3 * plain[0]:.3f} | {1e3 * plain[1]:.3f} | {plain[3]:.1f} | {plain[5]:.2f} | {1e3 * dynamic[1]:.3f} | {dynamic[3]:.1f} | {dynamic[5]:.2f} |")
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--foldwing", type=Path, required=True)
    parser.add_argument("--output", type=Path, required=True)
    parser.add_argument("--table", type=Path, required=True)
    arguments = parser.parse_args()
    use()
    cases = [(inertia, stall) for inertia in INERTIAS_KG_M2 for stall in (False, True)]
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(2) as pool:
        done = pool.map(lambda case: simulate(arguments.foldwing.resolve(), Path(folder), f"{case[0]:g}_{case[1]}", *case), cases)
        runs = dict(zip(cases, done))
    save(draw(runs), arguments.output / "pitch_link_5mw.png")
    text = table(runs)
    arguments.table.write_text(text, encoding="utf-8")
    print(text)


if __name__ == "__main__":
    main()
