#!/usr/bin/env python3
"""Release of a folding wing tip in a gust: reduction of the root moment by a hinge that is locked in flight, with the FMU in FMPy.

Usage: release_in_gust.py --foldwing target/release/foldwing --picture OUT.png

The wing is `wind_tunnel/baseline_wing.toml`, a half wing of the University of Bristol with a flared folding tip, in a 1-cos gust.
With the hinge locked (`fold.release` false) it is a wing without hinge. A controller samples the root bending moment, as measured by
strain gauges, releases the tip when the moment has risen by THRESHOLD_N_M, and locks it again when the tip has returned. The flare
reduces the incidence of a tip that folds upwards, which alleviates the gust load. For comparison, a tip that is never locked is
simulated from its equilibrium fold angle.
"""

import argparse
import json
import math
import re
import subprocess
import tempfile
from pathlib import Path

import numpy as np
from fmpy import read_model_description, simulate_fmu

MODEL = Path(__file__).parent / "wind_tunnel/baseline_wing.toml"
ANGLE, RATE, MOMENT = "fold.angle", "fold.angular_velocity", "root.moment.y"
RELEASE, TORQUE = "fold.release", "fold.external_torque"
PITCH_DEG, SPEED_M_S = 7.5, 18.0
GUST_M_S, GUST_START_S, GUST_LENGTH_M = 2.0, 0.2, 6.0  # upwards; it passes the wing in a third of a second
STOP_S, PERIOD_S = 1.4, 2e-3  # the controller samples every two milliseconds
THRESHOLD_N_M = 0.5
STIFFNESS_N_M_RAD, DAMPING_N_M_S_RAD, LIMIT_N_M = 1.0, 0.1, 0.3  # of the motor that returns the tip
NEAR_RAD, SLOW_RAD_S = math.radians(1.5), 0.2  # angle and rate for locking again


def model(start_deg, release, lattice=True):
    """Model file at the operating point: root pitch, initial fold angle, locked or released, and gust."""
    text = MODEL.read_text(encoding="utf-8")
    if not lattice:
        text = text.replace('model = "uvlm"', 'model = "strip"\ntip_loss = "lifting_line"')
    text = re.sub(r"(?m)^mount_rotation_deg = .*", f"mount_rotation_deg = [{PITCH_DEG}, 0.0, 0.0]", text)
    text = re.sub(r"(?m)^wind_m_s = .*", f"wind_m_s = [0.0, {-SPEED_M_S}, 0.0]", text)
    text = re.sub(r"(?m)^start_angle_deg = .*", f"start_angle_deg = {start_deg!r}\nrelease = {str(release).lower()}", text)
    text = re.sub(r"(?m)^stop_time_s = .*", f"stop_time_s = {STOP_S}", text)
    gust = ["[gust.upwash]", 'shape = "one_minus_cosine"', f"velocity_m_s = [0.0, 0.0, {GUST_M_S}]", f"length_m = {GUST_LENGTH_M}",
            "origin_m = [0.0, 0.0, 0.0]", f"start_s = {GUST_START_S}"]
    return text.replace("[simulation]", "\n".join([*gust, "", "[simulation]"]))


def command(foldwing, text, *arguments):
    """Output of `foldwing` for a model text; MODEL in the arguments is replaced by the path of its file."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "wing.toml"
        path.write_text(text, encoding="utf-8")
        return subprocess.run([str(foldwing), *(path if argument == "MODEL" else argument for argument in arguments)], check=True,
                              capture_output=True, text=True).stdout


def coasting_deg(foldwing, lattice=True):
    """Equilibrium fold angle of the free tip in steady wind."""
    rest = json.loads(command(foldwing, model(0.0, True, lattice), "static", "MODEL", "--json"))
    return math.degrees(next(joint["angle_rad"] for joint in rest["joints"] if joint["name"] == "fold"))


class Guard:
    """Controller: releases the hinge on a rise of the root moment, returns the tip with a weak motor, and locks it at low rate.

    Locking the hinge as soon as the tip returns, at 8 rad/s, would load the root more than the gust."""

    def __init__(self, references):
        self.references, self.steady_N_m, self.let_go_s, self.held_s, self.returns = references, None, None, None, False

    def __call__(self, time_s, recorder):
        fmu, ref = recorder.fmu, self.references
        moment, angle, rate = fmu.getReal([ref[MOMENT], ref[ANGLE], ref[RATE]])
        if self.steady_N_m is None:
            self.steady_N_m, self.start_rad = moment, angle
        off = angle - self.start_rad
        if self.let_go_s is None:
            if abs(moment - self.steady_N_m) > THRESHOLD_N_M:
                self.let_go_s = time_s
                fmu.setBoolean([ref[RELEASE]], [True])
        elif self.held_s is None:
            self.returns = self.returns or (rate > 0.0 and off < -math.radians(5.0))  # tip up is negative here
            if self.returns and abs(off) < NEAR_RAD and abs(rate) < SLOW_RAD_S:
                self.held_s = time_s
                fmu.setBoolean([ref[RELEASE]], [False])
            torque = -STIFFNESS_N_M_RAD * off - DAMPING_N_M_S_RAD * rate if self.returns else 0.0
            fmu.setReal([ref[TORQUE]], [min(max(torque, -LIMIT_N_M), LIMIT_N_M)])
        return True


def fly(foldwing, start_deg, release, guarded=False, lattice=True):
    """Simulate moment and fold angle in the gust with FMPy, with the controller if given."""
    with tempfile.TemporaryDirectory() as folder:
        fmu = str(Path(folder) / "wing.fmu")
        command(foldwing, model(start_deg, release, lattice), "package", "MODEL", "-o", fmu)
        references = {variable.name: variable.valueReference for variable in read_model_description(fmu).modelVariables}
        guard = Guard(references) if guarded else None
        result = simulate_fmu(fmu, stop_time=STOP_S, output_interval=PERIOD_S, output=[MOMENT, ANGLE], step_finished=guard)
    return result, guard


def bending(result):
    """Root bending moment in N·m, positive upwards."""
    return -result[MOMENT]


def draw(runs, guard, path):
    """Plot root moment and fold angle over time, with the switching times of the controller."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    from house_style import BLUE, FAINT, GREEN, SMALL, VERMILION, label_ends, mark, save, use

    use()
    figure, (upper, lower) = plt.subplots(2, 1, figsize=(8.6, 6.4), sharex=True, height_ratios=(3, 2))
    figure.subplots_adjust(left=0.09, right=0.81, top=0.93, bottom=0.08, hspace=0.12)
    for (name, result), colour in zip(runs.items(), (VERMILION, GREEN, BLUE)):
        label = f"{name}:\n{bending(result).min():.1f} to {bending(result).max():.1f}".replace("-", "−")
        upper.plot(result["time"], bending(result), color=colour, label=label)
        lower.plot(result["time"], -np.degrees(result[ANGLE]), color=colour, label=name)
    for axes in (upper, lower):
        axes.axvspan(GUST_START_S, GUST_START_S + GUST_LENGTH_M / SPEED_M_S, color=FAINT, alpha=0.16, linewidth=0)
        axes.set_xlim(0.0, STOP_S)
        for time_s in (guard.let_go_s, guard.held_s):
            if time_s is not None:
                mark(axes, time_s, "", BLUE)
    upper.set(ylabel="bending moment at the root (N·m)", title="Wing tip released in a gust")
    for time_s, words, side in ((guard.let_go_s, "released", "right"), (guard.held_s, "locked again", "left")):
        if time_s is not None:
            upper.annotate(f"{words}, {time_s:.3f} s", (time_s, 0.03), xycoords=("data", "axes fraction"), fontsize=SMALL, color=BLUE,
                           xytext=(4 if side == "left" else -4, 0), textcoords="offset points", ha=side)
    lower.annotate("gust at the root", (GUST_START_S + GUST_LENGTH_M / SPEED_M_S, 0.03), xycoords=("data", "axes fraction"), xytext=(-4, 0),
                   textcoords="offset points", ha="right", va="bottom", fontsize=SMALL, color=FAINT)
    lower.set(xlabel="time (s)", ylabel="fold angle, tip up (°)")
    label_ends(upper)
    label_ends(lower)
    path.parent.mkdir(parents=True, exist_ok=True)
    save(figure, path)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--foldwing", required=True, help="the command `foldwing`")
    parser.add_argument("--strips", action="store_true", help="strip theory with a lifting line instead of the vortex lattice: a fifth of the computing time")
    parser.add_argument("--picture", type=Path, help="output file of the plot")
    arguments = parser.parse_args()

    foldwing, lattice = arguments.foldwing, not arguments.strips
    held, _ = fly(foldwing, 0.0, release=False, lattice=lattice)
    free, _ = fly(foldwing, coasting_deg(foldwing, lattice), release=True, lattice=lattice)
    guarded, guard = fly(foldwing, 0.0, release=False, guarded=True, lattice=lattice)
    runs = {"locked": held, "free": free, "released in the gust": guarded}
    for name, result in runs.items():
        moment, up_deg = bending(result), 0.0 - np.degrees(result[ANGLE])
        print(f"{name:20} root moment {moment[0]:5.2f} N.m before the gust, {moment.min():6.2f} to {moment.max():5.2f} in it, "
              f"tip {up_deg.min():5.1f} to {up_deg.max():4.1f} deg up")
    rises = [bending(result).max() - bending(held)[0] for result in (held, guarded)]
    print(f"{'controller':20} released at {guard.let_go_s:.3f} s, locked again at {guard.held_s:.3f} s: moment increment reduced by {1 - rises[1] / rises[0]:.0%}")
    if arguments.picture:
        draw(runs, guard, arguments.picture)


if __name__ == "__main__":
    main()
