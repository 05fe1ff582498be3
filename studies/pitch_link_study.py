#!/usr/bin/env python3
"""Design study of a blade with a pitch-link failure: the inertia of the gears remaining in the pitch circuit that prevents flutter.

Sweeps `examples/failures/pitch_link_in_wind.toml` over gear inertia and rotor speed, from the steady rotor at each speed; takes flutter
eigenvalues from linear models, and growth rates from small oscillations in time. Draws the quantities of the paper's Fig. 1 and the map
of safe parameters.

Usage: pitch_link_study.py --foldwing target/release/foldwing --output docs/pictures --table docs/tables/pitch_link.md
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

from house_style import BLUE, FAINT, GREEN, INK, SMALL, VERMILION, label_ends, mark, save, use  # noqa: E402

MODEL = ROOT / "examples/failures/pitch_link_in_wind.toml"
SPEEDS_RAD_S = np.array([2.5, 3.0, 3.25, 3.5, 3.75, 4.0, 4.25, 4.5])
INERTIAS_KG_M2 = np.array([0.0, 15.0, 30.0, 45.0, 60.0, 80.0, 100.0, 125.0, 150.0, 200.0, 250.0, 300.0])
LIMITS_DEG = np.round(np.arange(0.4, 2.0, 0.05), 2)  # flap angles whose exceedance the sweeps record, 16 in each
SHOWN = ((0.0, VERMILION), (30.0, BLUE), (300.0, GREEN))


def changed(text, pattern, new):
    """The model text with the only match of a pattern replaced; exits if there is no match or more than one."""
    text, count = re.subn(pattern, lambda _: new, text, flags=re.MULTILINE | re.DOTALL)
    if count != 1:
        raise SystemExit(f"{pattern!r} matches {count} places of the model; exactly one is required")
    return text


def with_inertia(text, inertia_kg_m2):
    """The model with another inertia of the gears."""
    return changed(text, r"(?<=\[joint\.pitch\.motor\]\ninertia_kg_m2 = )[-+.e0-9]+", repr(float(inertia_kg_m2)))


class Runs:
    """Runs of the command on variants of the model."""

    def __init__(self, foldwing, folder):
        self.foldwing = foldwing.resolve()
        self.folder = folder
        self.text = MODEL.read_text(encoding="utf-8")

    def call(self, *arguments):
        done = subprocess.run([self.foldwing, *arguments], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, cwd=self.folder, check=False)
        if done.returncode:
            raise SystemExit(f"foldwing {' '.join(map(str, arguments))}: {done.stderr}")

    def simulate(self, text, *options):
        """Columns of a run of a model text."""
        (self.folder / "model.toml").write_text(text, encoding="utf-8")
        self.call("simulate", "model.toml", "--quiet", "--force", "--csv", "run.csv", *options)
        with (self.folder / "run.csv").open(encoding="utf-8") as lines:
            rows = list(csv.reader(lines))
        number = {"true": 1.0, "false": 0.0}
        values = np.array([[number.get(item) if item in number else float(item) for item in row] for row in rows[1:]])
        return dict(zip(rows[0], values.T))

    def at_speed(self, speed_rad_s, inertia_kg_m2):
        """The model without failures, with its shaft rotating at a given speed."""
        text = changed(self.text, r"\[failure\.link\].*?(?=\[aerodynamics\])", "")
        text = with_inertia(text, inertia_kg_m2)
        text = changed(text, r"\[joint\.shaft\.motor\].*?(?=\[joint\.flap\])", "")
        turning = f'motion = "prescribed"\npolynomial_deg = [0.0, {float(np.degrees(speed_rad_s))!r}]'
        return changed(text, r"^start_rate_deg_s = [^\n]*", turning)

    def steady(self, speed_rad_s):
        """Flap angle in rad, aerodynamic torque on one blade and holding torque of the pitch in N·m of the steady rotor with held pitch."""
        text = changed(self.at_speed(speed_rad_s, 30.0), r"^stop_time_s = 8\.0", "stop_time_s = 15.0")
        run = self.simulate(text, "--variables", "flap.angle,rotor.torque,pitch.holding_torque")
        return run["flap.angle"][-1], run["rotor.torque"][-1] / 2.0, run["pitch.holding_torque"][-1]

    def released(self, speed_rad_s, inertia_kg_m2, steady):
        """Options and text of the blade at standstill with the aerodynamics of the steady rotor, free to pitch."""
        text = changed(self.at_speed(speed_rad_s, inertia_kg_m2), r"^release = false", "release = true")
        return text, ("--set", f"flap.start_angle={float(steady[0])!r}", "--set", f"pitch.motor_constant_torque={float(-steady[2])!r}")

    def roots(self, speed_rad_s, inertia_kg_m2, steady):
        """Oscillatory eigenvalues in 1/s and rad/s of the aeroelastic linear model, least damped first."""
        text, options = self.released(speed_rad_s, inertia_kg_m2, steady)
        (self.folder / "model.toml").write_text(text, encoding="utf-8")
        self.call("linearize", "model.toml", "--state", "start", "--inputs", "pitch.external_torque", "--outputs", "pitch.angle", "--force", "-o", "model.npz", *options)
        values = np.linalg.eigvals(np.load(self.folder / "model.npz")["A"])
        return sorted((value for value in values if value.imag > 0.5), key=lambda value: -value.real)

    def growth(self, speed_rad_s, inertia_kg_m2, steady):
        """Growth rate of a small oscillation in time, 1/s: from its peaks in the three seconds after the other oscillation has decayed to
        e^-7."""
        first, second = self.roots(speed_rad_s, inertia_kg_m2, steady)[:2]
        from_s = 7.0 / (first.real - second.real)
        text, options = self.released(speed_rad_s, inertia_kg_m2, steady)
        run = self.simulate(text, *options, "--set", f"pitch.start_angle={float(np.radians(-2.001))!r}", "--stop", f"{from_s + 3.0:.2f}", "--variables", "pitch.angle")
        time, swing = run["time"], run["pitch.angle"] - np.radians(-2.0)
        middle = np.arange(1, len(swing) - 1)
        peaks = [i for i in middle if abs(swing[i]) >= abs(swing[i - 1]) and abs(swing[i]) > abs(swing[i + 1]) and time[i] > from_s]
        tops = []
        for i in peaks:  # parabola through three points
            a, b, c = (abs(swing[j]) for j in (i - 1, i, i + 1))
            tops.append(b + (a - c) ** 2 / (8.0 * (2.0 * b - a - c)))
        return np.polyfit(time[peaks], np.log(tops), 1)[0]

    def sweep(self, steady):
        """Times to half speed in s and largest flap angles in degrees for all speeds and inertias, from one sweep: the limits are defined
        as failures without effect."""
        rows = {}
        for speed_rad_s in SPEEDS_RAD_S:
            flap, torque, _ = steady[speed_rad_s]
            for limits_deg in np.array_split(LIMITS_DEG, 2):
                watched = [("half", "shaft", f"rate_below_deg_s = {float(np.degrees(speed_rad_s / 2.0))!r}")]
                watched += [(f"flap{index}", "flap", f"angle_above_deg = {limit}") for index, limit in enumerate(limits_deg)]
                noted = "".join(f'[failure.{name}]\nkind = "spring_break"\njoint = "flap"\nremaining_fraction = 1.0\nwhen = {{ joint = "{joint}", {bound} }}\n\n'
                                for name, joint, bound in watched)
                text = changed(self.text, r"^\[aerodynamics\]", noted + "[aerodynamics]")
                text = changed(text, r"^start_rate_deg_s = [^\n]*", f"start_rate_deg_s = {float(np.degrees(speed_rad_s))!r}")
                (self.folder / "sweep.toml").write_text(text, encoding="utf-8")
                table = f"sweep_{speed_rad_s}_{limits_deg[0]}.csv"
                self.call("sweep", "sweep.toml", "--vary", "file:joint.pitch.motor.inertia_kg_m2=" + ",".join(map(str, INERTIAS_KG_M2)),
                          "--set", f"flap.start_angle={float(flap)!r}", "--set", f"shaft.motor_constant_torque={float(torque)!r}",
                          "--variables", ",".join(f"failure.{name}.time" for name, _, _ in watched), "--output", table)
                with (self.folder / table).open(encoding="utf-8") as lines:
                    for index, row in enumerate(csv.DictReader(lines)):
                        if row["status"] != "done":
                            raise SystemExit(f"{table}: {row['message']}")
                        passed = [limit for place, limit in enumerate(limits_deg) if float(row[f"failure.flap{place}.time"]) >= 0.0]
                        before = rows.get((speed_rad_s, index), (0.0, 0.0))[1]
                        rows[speed_rad_s, index] = (float(row["failure.half.time"]), max([before, *passed]))
        rows = list(rows.values())
        shape = (len(SPEEDS_RAD_S), len(INERTIAS_KG_M2))
        return np.array([row[0] for row in rows]).reshape(shape), np.array([row[1] for row in rows]).reshape(shape)


def histories(runs):
    """Draws flap, pitch and rotor speed after the failure, as in the paper's Fig. 1; one column per inertia."""
    figure, axes = plt.subplots(3, 1, figsize=(9, 7.2), sharex=True)
    figure.subplots_adjust(left=0.09, right=0.86, top=0.95, bottom=0.08, hspace=0.28)
    columns = {}
    for inertia_kg_m2, colour in SHOWN:
        text = with_inertia(runs.text, inertia_kg_m2)
        run = columns[inertia_kg_m2] = runs.simulate(text, "--variables", "flap.angle,pitch.angle,shaft.angular_velocity")
        for place, name in zip(axes, ("flap.angle", "pitch.angle")):
            place.plot(run["time"], np.degrees(run[name]), color=colour, label=f"{inertia_kg_m2:.0f} kg·m²")
        axes[2].plot(run["time"], run["shaft.angular_velocity"], color=colour, label=f"{inertia_kg_m2:.0f} kg·m²")
    axes[0].set(title="Flap angle (°), positive downwind")
    axes[1].set(title="Pitch angle (°), negative to feather", ylim=(-100.0, 20.0))
    axes[2].set(title="Rotor speed (rad/s)", xlabel="time after the pitch link has opened (s)", xlim=(0.0, 8.0), ylim=(0.0, 4.4))
    for place in axes:
        label_ends(place)
    mark(axes[2], 0.2, "brake", FAINT, 0.3)
    return figure, columns


def design(speeds, inertias, roots, growths, largest_deg):
    """Draws eigenvalues over the inertia with growth rates in time, and a map of the largest flap angle with the line of zero growth."""
    figure, (left, right) = plt.subplots(2, 1, figsize=(7.6, 8.2))
    figure.subplots_adjust(left=0.1, right=0.9, top=0.96, bottom=0.07, hspace=0.34)
    for speed, colour in ((3.0, GREEN), (3.5, BLUE), (4.0, VERMILION)):
        left.plot(inertias, roots[int(np.flatnonzero(speeds == speed)[0])], color=colour, label=f"{speed:.1f} rad/s")
    for inertia_kg_m2, rate in growths.items():
        left.plot(inertia_kg_m2, rate, "o", color="white", markeredgecolor=VERMILION, markersize=6)
    left.axhline(0.0, color=FAINT, linewidth=0.8)
    left.set(
        title="Growth rate: roots (lines), simulations (rings)",
        xlabel="remaining inertia in the pitch circuit (kg·m²)", ylabel="growth rate (1/s)", xlim=(0.0, inertias[-1])
    )
    label_ends(left)
    filled = right.contourf(inertias, speeds, largest_deg, levels=np.arange(0.3, 2.0, 0.1), cmap="YlOrRd", extend="max")
    bar = figure.colorbar(filled, ax=right)
    bar.set_label("largest flap angle (°)")
    bar.outline.set_visible(False)
    neutral = right.contour(inertias, speeds, roots, levels=[0.0], colors=[INK], linewidths=1.6)
    right.clabel(neutral, fmt={0.0: "no growth beyond"}, fontsize=SMALL)
    right.grid(False)
    right.set(
        title="Maximum flap angle within 8 s of the failure",
        xlabel="remaining inertia in the pitch circuit (kg·m²)", ylabel="rotor speed at the failure (rad/s)"
    )
    return figure


def table(columns, half_s, largest_deg, roots, growths):
    """Scenario table in Markdown."""
    lines = ["# Pitch-link failure of a blade, over the inertia of its gears", "",
             "`studies/pitch_link_study.py`, at 4 rad/s: the least damped root that swings, the growth of a small swing in time, the largest flap angle",
             "(in steps of 0.05°) and the time to half speed after the failure, from the steady rotor with the torque of its air on the generator.", "",
             "| inertia (kg·m²) | root (1/s) | in time (1/s) | largest flap (°) | half speed (s) |", "|---|---|---|---|---|"]
    at = int(np.flatnonzero(SPEEDS_RAD_S == 4.0)[0])
    for index, inertia_kg_m2 in enumerate(INERTIAS_KG_M2):
        growth = f"{growths[inertia_kg_m2]:+.4f}" if inertia_kg_m2 in growths else ""
        lines.append(f"| {inertia_kg_m2:g} | {roots[at][index]:+.4f} | {growth} | {largest_deg[at][index]:.2f} | {half_s[at][index]:.2f} |")
    lines += ["", "Largest and smallest pitch, and largest flap, within 8 s of the shipped model, whose generator takes 90 kN·m:", "", "| inertia (kg·m²) | pitch up (°) | pitch down until 4 s (°) | flap (°) |", "|---|---|---|---|"]
    for inertia_kg_m2, run in columns.items():
        pitch, early = np.degrees(run["pitch.angle"]), run["time"] <= 4.0
        lines.append(f"| {inertia_kg_m2:g} | {pitch.max():.2f} | {pitch[early].min():.2f} | {np.degrees(run['flap.angle']).max():.3f} |")
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--foldwing", type=Path, required=True)
    parser.add_argument("--output", type=Path, required=True)
    parser.add_argument("--table", type=Path, required=True)
    arguments = parser.parse_args()
    use()
    with tempfile.TemporaryDirectory() as folder:
        runs = Runs(arguments.foldwing, Path(folder))
        figure, columns = histories(runs)
        save(figure, arguments.output / "pitch_link.png")
        steady = {speed: runs.steady(speed) for speed in SPEEDS_RAD_S}
        roots = np.array([[runs.roots(speed, inertia, steady[speed])[0].real for inertia in INERTIAS_KG_M2] for speed in SPEEDS_RAD_S])
        growths = {inertia: runs.growth(4.0, inertia, steady[4.0]) for inertia in (0.0, 30.0, 60.0, 100.0, 150.0)}
        half_s, largest_deg = runs.sweep(steady)
        save(design(SPEEDS_RAD_S, INERTIAS_KG_M2, roots, growths, largest_deg), arguments.output / "pitch_link_map.png")
        text = table(columns, half_s, largest_deg, roots, growths)
        arguments.table.write_text(text, encoding="utf-8")
        print(text)


if __name__ == "__main__":
    main()
