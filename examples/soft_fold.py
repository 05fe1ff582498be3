#!/usr/bin/env python3
"""Soft unfolding and folding: hinge controller designed on `foldwing linearize`, tested on the FMU.

Usage: soft_fold.py --foldwing target/release/foldwing --fmu target/fmu/FoldingWing.fmu --picture OUT.png

Without control, the motor drives the wing into its latch at full speed. Here the hinge follows a smooth reference that
reaches the latch at almost zero rate: feedforward torque for a rigid outer wing, plus feedback of the measured angle and
rate. Stiffness and damping of the feedback are selected from a set of candidates for the best damping of the slow modes of
the open wing at several fold angles, with stability for 10 % lower and higher stiffness of the wing. With a matched hinge
impedance the hinge absorbs the bending vibration of the inner wing; a stiff hinge would not.

Sensors are `fold.angle`, `fold.angular_velocity` and the latch contact `fold.latched`; the strain gauge is used for evaluation only.
"""

import argparse
import subprocess
import tempfile
from itertools import product
from pathlib import Path

import numpy as np
from damp_latched_wing import MODEL, flap_modes, sampled
from deploy import latch_time, peak
from fmpy import read_model_description, simulate_fmu

ANGLE, RATE, GAUGE = "fold.angle", "fold.angular_velocity", "gauge.root.strain"
PERIOD_S = 1e-3  # sampling period and communication step
RATE_FILTER_HZ = 20.0  # low-pass filter of the measured rate; without it the feedback would excite modes above 100 Hz

FOLDED_RAD, LATCH_RAD = np.radians(170.0), 0.0
BEYOND_RAD = 0.05  # overshoot of the reference beyond the latch angle, so that the latch closes reliably
TORQUE_LIMIT_N_M, RATE_LIMIT_RAD_S = 0.12, 15.0  # motor torque on the folded wing, and slew rate of its command

# motor and outer wing of the model file
STIFFNESS_N_M_RAD, DAMPING_N_M_S_RAD, CONSTANT_TORQUE_N_M = 0.026, 0.0008, 0.043
OUTER_MASS_KG, OUTER_LENGTH_M, GRAVITY_M_S2 = 0.021375, 0.15, 9.8
INERTIA_KG_M2 = OUTER_MASS_KG * OUTER_LENGTH_M**2 / 3
WEIGHT_N_M = OUTER_MASS_KG * GRAVITY_M_S2 * OUTER_LENGTH_M / 2  # times sin(angle): torque of gravity about the hinge

ARRIVAL_DEG = (0.5, 30, 60)  # fold angles for the damping criterion: at larger angles the hinge hardly affects the slow modes
ALL_DEG = (*ARRIVAL_DEG, 120, 165)
STIFFNESS_FACTORS = (1.0, 0.9, 1.1)
SLOW_HZ = 20.0
CANDIDATES = tuple(product((0.05, 0.1, 0.2), (0.001, 0.002, 0.004, 0.008)))  # N·m/rad and N·m·s/rad


def open_wing(foldwing, angle_deg, stiffness_factor=1.0, model=MODEL):
    """A, B, C of the wing in equilibrium at a fold angle with open latch; from hinge torque to angle, rate and strain."""
    angle = np.radians(angle_deg)
    settings = {"fold.latch_enable": 0, "fold.start_angle": angle, "fold.motor_constant_torque": 0,
                "fold.angle_command": angle - WEIGHT_N_M * np.sin(angle) / STIFFNESS_N_M_RAD,
                "body.inner.stiffness_factor": stiffness_factor, "body.outer.stiffness_factor": stiffness_factor}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "open.npz"
        command = [str(foldwing), "linearize", str(model), "--state", "equilibrium", "--inputs", "fold.external_torque",
                   "--outputs", f"{ANGLE},{RATE},{GAUGE}", "--output", str(path)]
        for name, value in settings.items():
            command += ["--set", f"{name}={value}"]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        with np.load(path) as file:
            return file["A"], file["B"], file["C"]


def share():
    """Weight of a new sample in the filtered rate."""
    return 1.0 - np.exp(-2.0 * np.pi * RATE_FILTER_HZ * PERIOD_S)


def closed_loop(a, b, c, stiffness, damping):
    """Closed loop in discrete time; the last state is the filtered rate."""
    angle, rate = c[:1], c[1:2]
    on_wing = a - b @ (stiffness * angle + damping * share() * rate)
    return np.block([[on_wing, -b * damping * (1.0 - share())], [share() * rate, np.eye(1) * (1.0 - share())]])


def damping_ratios(a, b, c, gains):
    """Closed-loop damping ratios of the slow poles of a wing, given by its flapwise modes."""
    poles = np.log(np.linalg.eigvals(closed_loop(*sampled(a, b, PERIOD_S), c, *gains)).astype(complex)) / PERIOD_S
    poles = poles[(poles.imag > 0) & (np.abs(poles) < 2 * np.pi * SLOW_HZ)]
    return -poles.real / np.abs(poles)


def design(foldwing, candidates=CANDIDATES):
    """Select the stiffness in N·m/rad and damping in N·m·s/rad with the largest minimum damping of the slow modes near the latch.

    Returns the gains and that damping ratio. Candidates that are unstable for any wing or angle are excluded.
    """
    wings = {key: open_wing(foldwing, *key) for key in product(ALL_DEG, STIFFNESS_FACTORS)}
    steps = [(*sampled(a, b, PERIOD_S), c) for a, b, c in wings.values()]
    near = [flap_modes(*wings[angle_deg, 1.0]) for angle_deg in ARRIVAL_DEG]
    worst = {gains: min(damping_ratios(*wing, gains).min() for wing in near) for gains in candidates}
    for gains in sorted(worst, key=worst.get, reverse=True):
        if all(np.abs(np.linalg.eigvals(closed_loop(*step, *gains))).max() < 1.0 for step in steps):
            return gains, worst[gains]
    raise ArithmeticError("no candidate is stable on every wing")


class Move:
    """Reference motion from one angle to another, with zero rate and acceleration at both ends."""

    def __init__(self, from_rad, to_rad, start_s, duration_s):
        self.from_rad, self.way_rad, self.start_s, self.duration_s = from_rad, to_rad - from_rad, start_s, duration_s

    def at(self, time_s):
        """Angle in rad, rate in rad/s, acceleration in rad/s²."""
        s = np.clip((time_s - self.start_s) / self.duration_s, 0.0, 1.0)
        return (self.from_rad + self.way_rad * s**3 * (10 - 15 * s + 6 * s**2),
                self.way_rad / self.duration_s * 30 * s**2 * (1 - s) ** 2,
                self.way_rad / self.duration_s**2 * 60 * s * (1 - s) * (1 - 2 * s))


class SoftFold:
    """Controller: hinge torque from measured angle and rate, along a reference motion."""

    def __init__(self, gains):
        self.stiffness, self.damping = gains
        self.rate_error = 0.0

    def torque(self, move, time_s, angle_rad, rate_rad_s):
        """External torque in N·m for one sampling period, with the motor's command at the reference angle."""
        angle, rate, acceleration = move.at(time_s)
        forward = CONSTANT_TORQUE_N_M + DAMPING_N_M_S_RAD * rate + INERTIA_KG_M2 * acceleration - WEIGHT_N_M * np.sin(angle)
        self.rate_error += share() * (rate_rad_s - rate - self.rate_error)
        return forward - self.stiffness * (angle_rad - angle) - self.damping * self.rate_error


def fly(fmu, gains=None, move_s=0.5, fold_at_s=None, stop_s=1.0, **start):
    """Simulate unfolding, with the controller if gains are given, and folding from `fold_at_s` on.

    `start`: start values of the FMU, by names with `__` for dots. Returns the result of FMPy.
    """
    reference = {v.name: [v.valueReference] for v in read_model_description(str(fmu)).modelVariables}
    values = {name.replace("__", "."): value for name, value in start.items()}
    unfold, fold = Move(FOLDED_RAD, LATCH_RAD - BEYOND_RAD, 0.0, move_s), None
    controller = gains and SoftFold(gains)
    if controller:
        values |= {"fold.motor_torque_limit": TORQUE_LIMIT_N_M, "fold.motor_rate_limit": RATE_LIMIT_RAD_S,
                   "fold.angle_command": FOLDED_RAD, "fold.external_torque": controller.torque(unfold, 0.0, FOLDED_RAD, 0.0)}

    def control(time, recorder):
        nonlocal fold, controller
        wing = recorder.fmu
        (angle,), (rate,) = wing.getReal(reference[ANGLE]), wing.getReal(reference[RATE])
        if fold is None and fold_at_s is not None and time >= fold_at_s:
            fold, controller = Move(angle, FOLDED_RAD, time, move_s), SoftFold(gains)
            wing.setBoolean(reference["fold.latch_enable"], [False])
        if fold is None and wing.getBoolean(reference["fold.latched"])[0]:
            command, torque = LATCH_RAD, 0.0  # the latch holds the wing
        else:
            move = fold or unfold
            command, torque = move.at(time)[0], controller.torque(move, time, angle, rate)
        wing.setReal(reference["fold.angle_command"], [command])
        wing.setReal(reference["fold.external_torque"], [torque])
        return True

    outputs = [ANGLE, RATE, GAUGE, "fold.latched", "fold.latch_time", "fold.latch_count", "fold.total_torque"]
    return simulate_fmu(str(fmu), stop_time=stop_s, output_interval=PERIOD_S, output=outputs, start_values=values,
                        step_finished=control if controller else None)


def largest(result):
    """Largest magnitude of the root strain."""
    return abs(peak(result)[1])


def draw(free, soft, others, trade, path):
    """Plot fold angle and strain over time, and peak strain over latch time."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    from house_style import BLACK, BLUE, FAINT, SKY, SMALL, VERMILION, mark, save, use

    use()
    figure, ((angle, cost), (strain, torque)) = plt.subplots(2, 2, figsize=(10.4, 6.2), width_ratios=(3, 2),
                                                             layout="constrained")
    for result, colour, name in ((free, FAINT, "uncontrolled"), (soft, BLUE, "soft fold")):
        angle.plot(result["time"], np.degrees(result[ANGLE]), color=colour, label=name)
        strain.plot(result["time"], 1e3 * result[GAUGE], color=colour, linewidth=1.2, label=name, zorder=3)
        mark(angle, latch_time(result), f"latched,\n{latch_time(result):.3f} s", VERMILION, 0.97 if result is free else 0.75)
        mark(strain, latch_time(result), "", VERMILION)
    for result in others:
        line, = strain.plot(result["time"], 1e3 * result[GAUGE], color=SKY, linewidth=0.9)
    line.set_label("soft fold, wing stiffness ±10 %")
    strain.legend(loc="upper right")
    angle.set(ylabel="fold angle (°)", yticks=range(0, 181, 45), xticklabels=[], title="Unfolding, latching, folding")
    angle.legend(loc="upper center")
    strain.set(xlabel="time (s)", ylabel="strain at the root gauge (10⁻³)")
    torque.plot(soft["time"], 1e3 * soft["fold.total_torque"], color=BLUE, linewidth=1.2)
    torque.set(xlabel="time (s)", ylabel="hinge torque (mN·m)", title="Soft fold: hinge torque")
    for axes in (angle, strain, torque):
        axes.set_xlim(0.0, soft["time"][-1])
    cost.plot([latch_time(run) for run in trade], [1e3 * largest(run) for run in trade], "o-", color=BLUE)
    cost.annotate("soft fold, various durations", (latch_time(trade[3]), 1e3 * largest(trade[3])), xytext=(4, 8),
                  textcoords="offset points", color=BLUE, fontsize=SMALL)
    cost.plot(latch_time(free), 1e3 * largest(free), "s", color=BLACK)
    cost.annotate("uncontrolled", (latch_time(free), 1e3 * largest(free)), xytext=(8, 0), textcoords="offset points", va="center",
                  color=BLACK, fontsize=SMALL)
    cost.axhline(0.5e3 * largest(free), color=FAINT, linestyle=":")
    cost.annotate("half of the uncontrolled peak", (0.99, 0.5e3 * largest(free)), xycoords=("axes fraction", "data"), xytext=(0, 3),
                  textcoords="offset points", ha="right", color=FAINT, fontsize=SMALL)
    cost.set(xlabel="latch time (s)", ylabel="peak strain (10⁻³)", ylim=(0, None), xlim=(0, None), title="Peak strain over latch time")
    path.parent.mkdir(parents=True, exist_ok=True)
    save(figure, path)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--foldwing", required=True, help="the command `foldwing`")
    parser.add_argument("--fmu", required=True, help="FMU of examples/models/folding_wing.toml")
    parser.add_argument("--picture", type=Path, help="output file of the plot")
    arguments = parser.parse_args()

    gains, ratio = design(arguments.foldwing)
    print(f"{'feedback':21} {gains[0]} N.m/rad, {gains[1]} N.m.s/rad; "
          f"slow modes near the latch damped by {ratio:.2f}")
    free, soft = fly(arguments.fmu), fly(arguments.fmu, gains, fold_at_s=1.2, stop_s=2.2)
    unfolding = soft[soft["time"] < 1.2]
    for name, run in (("left alone", free), ("soft fold", unfolding)):
        print(f"{name:21} latches at {latch_time(run):.4f} s, peak strain {largest(run):.3e}")
    print(f"{'folding again':21} peak strain {largest(soft[soft['time'] >= 1.2]):.3e}, "
          f"{np.degrees(soft[ANGLE][-1]):.1f} deg at the end")
    print(f"{'largest torque, rate':21} {np.abs(soft['fold.total_torque']).max():.4f} N.m of {TORQUE_LIMIT_N_M}, "
          f"{np.abs(soft[RATE]).max():.1f} rad/s")
    others = [fly(arguments.fmu, gains, fold_at_s=1.2, stop_s=2.2, body__inner__stiffness_factor=factor,
                  body__outer__stiffness_factor=factor) for factor in STIFFNESS_FACTORS[1:]]
    for factor, run in zip(STIFFNESS_FACTORS[1:], others):
        unfolding, folding = run[run["time"] < 1.2], run[run["time"] >= 1.2]
        print(f"{f'stiffness x {factor}':21} latches at {latch_time(run):.4f} s, peak strain {largest(unfolding):.3e}, "
              f"{largest(folding):.3e} folding")
    trade = [fly(arguments.fmu, gains, move_s) for move_s in (0.2, 0.25, 0.3, 0.4, 0.5, 0.6, 0.8)]
    for run in trade:
        print(f"{'trade':21} latches at {latch_time(run):.4f} s, peak strain {largest(run):.3e}")
    if arguments.picture:
        draw(free, soft, others, trade, arguments.picture)


if __name__ == "__main__":
    main()
