#!/usr/bin/env python3
"""Closed-loop simulation of the NREL 5 MW turbine FMU with its reference controller, with FMPy.

Usage: closed_loop.py --foldwing target/release/foldwing [--duration 600] [--picture OUT.png] [--points] [--table OUT.md]

The turbine is `nrel_5mw_wind.toml` in the folder of this script: tower, drive train and blades are flexible. Its generator is
switched off by its input, and the controller of `nrel_controller.py` sets shaft torque and blade pitch instead. Simulations are in
steady wind and in seeded turbulence. `--points` computes the steady states at the wind speeds of OpenFAST's map of operating points,
under the conditions of that map: no cone, tilt, tower motion and gravity, AeroDyn's options.
"""

import argparse
import csv
import math
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave
from nrel_controller import RATED_POWER_W, RPM, Controller

FOLDER = Path(__file__).resolve().parent
MODEL = FOLDER / "nrel_5mw_wind.toml"
MAP = FOLDER.parents[1] / "tests/reference/turbine/openfast_aeromap_flexible.csv"
GEAR_RATIO, EFFICIENCY = 97.0, 0.944
STEP_S = 0.02  # of controller and aerodynamics: a twentieth of the shortest relevant period, that of the drive train
MEAN_M_S, SEED = 12.0, 7
SETTLE_S, MEAN_S = 240.0, 20.0  # of an operating point: time for the decay of transients, and averaging time

SPEED, AZIMUTH, FAST = "rotor.speed", "shaft.angle", "shaft.generator_speed"
PITCHES = [f"pitch{blade}.angle" for blade in (1, 2, 3)]
ENERGIES = ["energy.total", "energy.work", "energy.dissipated"]
RECORDED = ["rotor.wind", SPEED, FAST, "rotor.thrust", "rotor.power", "pitch1.angle", "body.blade1.deflection.z", "body.tower.deflection.z",
            "body.blade1.root_moment.y", *ENERGIES]

HEAD = """# Operating points of the turbine in closed loop

Steady states of the loop of `examples/turbine/closed_loop.py`, under the conditions of OpenFAST's map of operating points
(`openfast_aeromap_flexible.csv`: blades bend; no cone, tilt, tower motion and gravity; AeroDyn's rules), from a speed 3 % and a pitch 1 degree off;
"off" is the distance from the map. Above rated wind the map takes more than the rated power of 5.2966 MW out of the wind, so that the loop needs more pitch
and has less thrust; the last two columns are the same loop with the map's power for the rated one.
"""


def steady(text, wind_m_s):
    """Model text in steady, uniform wind."""
    return re.sub(r"(?m)^wind_m_s = .*", f"wind_m_s = [{wind_m_s!r}, 0.0, 0.0]", text)


def turbulent(text, mean_m_s, seed, duration_s):
    """Model text in turbulence of IEC 61400-1, class B (an intensity of 14 % at 15 m/s), with its shear."""
    planes = 1 << math.ceil(math.log2(duration_s / 0.25))
    wind = ["[wind]", "reference_height_m = 90.0", "downwind = [1.0, 0.0, 0.0]", "shear_exponent = 0.2", "", "[wind.turbulence]", f"seed = {seed}",
            f"mean_m_s = {mean_m_s!r}", f"standard_deviation_m_s = {0.14 * (0.75 * mean_m_s + 5.6)!r}", "points = [13, 13]",
            "spacing_m = [12.0, 12.0]", f"planes = {planes}", "plane_interval_s = 0.25", ""]
    return steady(text, 0.0).replace("[surface.blade]", "\n".join([*wind, "[surface.blade]"]))


def as_in_map(text, wind_m_s, speed_rpm, pitch_deg):
    """Model text under the conditions of OpenFAST's map: horizontal shaft on a rigid support, no cone, no gravity, AeroDyn's options."""
    text = re.sub(r"(?ms)^# Tower: .*?(?=^# Nacelle)", "", text)
    text = re.sub(r'(?ms)^\[joint\.yaw\].*?(?=^# The shaft)', '[joint.yaw]\ntype = "clamped"\nparent = "root"\nchild = "nacelle"\n\n', text)
    text = text.replace("rotation_deg = [0.0, 5.0, 0.0]", "rotation_deg = [0.0, 0.0, 0.0]")
    text = re.sub(r"(?m)^parent_offset_m = .*", "parent_offset_m = [0.0, 0.0, 1.5]", text)
    text = re.sub(r"(?m)^axis = \[0\.0436.*", f"axis = [0.0, 0.0, -1.0]\nstart_angle_deg = {pitch_deg!r}", text)
    text = re.sub(r"(?m)^mount_rotation_deg = .*", "mount_rotation_deg = [127.27922061357854, 0.0, 127.27922061357854]", text)
    text = re.sub(r"(?m)^gravity_m_s2 = .*", "gravity_m_s2 = [0.0, 0.0, 0.0]", text)
    text = re.sub(r"(?m)^start_rate_deg_s = .*", f"start_rate_deg_s = {6.0 * speed_rpm!r}", text)
    text = text.replace('model = "bem"', 'model = "bem"\nend_loads = "full_induction"\naerodyn_compatible = true')
    return steady(text, wind_m_s)


def in_real_time(text):
    """Model text in real-time mode, aerodynamics and structure with 5 ms steps: every step has the same cost."""
    text = text.replace("step_s = 0.02\n# The loads", "step_s = 0.005\n# The loads")
    return re.sub(r"(?ms)^\[solver\].*?(?=^\[)", '[solver]\nmode = "real_time"\nfixed_step_s = 0.005\n\n', text)


def with_polars(text):
    """Model text with absolute paths of the polar files, independent of the working folder."""
    return text.replace('"polars/', f'"{FOLDER.as_posix()}/polars/')


class Turbine:
    """FMU of a model text, simulated with the controller."""

    def __init__(self, foldwing, text, folder, rated_W):
        model, fmu = Path(folder) / "turbine.toml", Path(folder) / "turbine.fmu"
        model.write_text(with_polars(text), encoding="utf-8")
        subprocess.run([str(foldwing), "package", str(model), "-o", str(fmu), "--no-reference"], check=True, capture_output=True)
        description = read_model_description(str(fmu))
        self.references = {variable.name: variable.valueReference for variable in description.modelVariables}
        self.slave = FMU2Slave(guid=description.guid, unzipDirectory=extract(str(fmu), str(Path(folder) / "fmu")),
                               modelIdentifier=description.coSimulation.modelIdentifier, instanceName="turbine")
        self.slave.instantiate()
        self.slave.setupExperiment(startTime=0.0)
        self.slave.enterInitializationMode()
        self.slave.setBoolean([self.references["shaft.generator_on"]], [False])
        self.slave.exitInitializationMode()
        self.recorded = [name for name in RECORDED if name in self.references]  # without a tower it has no deflection
        self.controller = Controller(*self.get([FAST, PITCHES[0]]), rated_W)
        self.commands = [self.references[name] for name in ["shaft.external_torque", *(f"pitch{blade}.angle_command" for blade in (1, 2, 3))]]

    def get(self, names):
        """Values of variables."""
        return self.slave.getReal([self.references[name] for name in names])

    def run(self, duration_s, every=5):
        """Simulate `duration_s`; one row every `every` steps: time, recorded variables, generator torque in N·m."""
        rows = []
        fast = [self.references[FAST]]
        for index in range(round(duration_s / STEP_S)):
            torque, pitch = self.controller.step(self.slave.getReal(fast)[0], STEP_S)
            if index % every == 0:
                rows.append([index * STEP_S, *self.get(self.recorded), torque])
            self.slave.setReal(self.commands, [-GEAR_RATIO * torque, pitch, pitch, pitch])
            self.slave.doStep(index * STEP_S, STEP_S)
        rows.append([duration_s, *self.get(self.recorded), self.controller.torque_N_m])
        return {name: np.array(column) for name, column in zip(["time", *self.recorded, "torque"], zip(*rows))}

    def close(self):
        """Free the FMU."""
        self.slave.terminate()
        self.slave.freeInstance()


def fly(foldwing, text, duration_s, rated_W=RATED_POWER_W):
    """Simulate a model text; returns time histories and CPU time in s."""
    with tempfile.TemporaryDirectory() as folder:
        turbine = Turbine(foldwing, text, folder, rated_W)
        began = time.process_time()
        try:
            return turbine.run(duration_s), time.process_time() - began
        finally:
            turbine.close()


def account(run):
    """Largest error of the energy balance in J, and the generator energy in J."""
    total, work, dissipated = (run[name] for name in ENERGIES)
    balance = total - work + dissipated
    through = np.trapezoid(np.abs(run["torque"] * run[FAST]), run["time"])
    return np.abs(balance - balance[0]).max(), through


def summary(name, run, seconds):
    """One-line summary of a run."""
    late = run["time"] >= 0.1 * run["time"][-1]
    rpm, power = run[SPEED][late] / RPM, EFFICIENCY * (run["torque"] * run[FAST])[late] / 1e6
    error, through = account(run)
    return (f"{name:10} {run['time'][-1]:.0f} s: wind {run['rotor.wind'][late].mean():.2f} ± {run['rotor.wind'][late].std():.2f} m/s, rotor {rpm.mean():.3f} rpm "
            f"({rpm.min():.3f} to {rpm.max():.3f}), power {power.mean():.3f} MW ± {power.std():.3f}, pitch up to "
            f"{math.degrees(run['pitch1.angle'][late].max()):.2f} deg, energy account within {error:.3g} J of {through:.3g} J ({error / through:.1e}), "
            f"{seconds / run['time'][-1]:.4f} s of the processor per second")


def rest(foldwing, row, settle_s, rated_W=RATED_POWER_W):
    """Means over the last seconds of a run under the conditions of an operating point; the run starts away from the point to test
    convergence to it."""
    wind, rpm, pitch = row["WindSpeed_m_per_s"], row["RotorSpeed_RPM"], row["Pitch_deg"]
    text = as_in_map(MODEL.read_text(encoding="utf-8"), wind, 0.97 * rpm, max(pitch - 1.0, 0.0))
    run, _ = fly(foldwing, text, settle_s, rated_W)
    last = run["time"] > settle_s - MEAN_S
    if np.ptp(run[SPEED][last]) > 1e-5 * run[SPEED][-1]:
        raise SystemExit(f"no steady state at {wind} m/s within {settle_s} s")
    return {"rpm": run[SPEED][last].mean() / RPM, "pitch": math.degrees(run["pitch1.angle"][last].mean()),
            "power": run["rotor.power"][last].mean(), "thrust": run["rotor.thrust"][last].mean()}


def operating_points(foldwing, winds_m_s=None, settle_s=SETTLE_S):
    """For each operating point of the map, or those of some wind speeds: OpenFAST's values, and the steady state of the closed loop; above
    rated wind also that with the power of the map, which is up to a twentieth above rated power there."""
    with open(MAP, encoding="utf-8") as file:
        rows = [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)]
    speeds = [row["WindSpeed_m_per_s"] for row in rows]
    ascending = next((i for i in range(1, len(rows)) if speeds[i] < speeds[i - 1]), len(rows))  # followed by points without a controller
    points = []
    for row in rows[:ascending]:
        if winds_m_s is not None and row["WindSpeed_m_per_s"] not in winds_m_s:
            continue
        power = row["RtFldMxh_Nm"] * row["RotorSpeed_RPM"] * RPM
        points.append({
            "wind": row["WindSpeed_m_per_s"],
            "map": {"rpm": row["RotorSpeed_RPM"], "pitch": row["Pitch_deg"], "power": power, "thrust": row["RtFldFxh_N"]},
            "own": rest(foldwing, row, settle_s),
            "at_power": rest(foldwing, row, settle_s, power) if row["Pitch_deg"] > 0.0 else None,
        })
    return points


def table(points):
    """Markdown table of the operating points: values of the closed loop and deviations from the map."""
    def off(point, kind, name):
        if point[kind] is None:
            return ""
        own, reference = point[kind][name], point["map"][name]
        return (f"{own - reference:+.3f}°" if name == "pitch" else f"{100.0 * (own / reference - 1.0):+.2f} %").replace("-", "−")

    lines = ["| wind, m/s | rotor, rpm | off | pitch, deg | off | power, MW | off | thrust, kN | off | pitch at the map's power, off | thrust there, off |",
             "|---|---|---|---|---|---|---|---|---|---|---|"]
    for point in points:
        cells = [f"{point['wind']:g}"]
        for name, factor, digits in (("rpm", 1.0, 4), ("pitch", 1.0, 3), ("power", 1e-6, 4), ("thrust", 1e-3, 2)):
            cells += [f"{factor * point['own'][name]:.{digits}f}", off(point, "own", name)]
        cells += [off(point, "at_power", "pitch"), off(point, "at_power", "thrust")]
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"


def draw(runs, path):
    """Plot the time histories of the runs."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    sys.path.insert(0, str(FOLDER.parent))
    from house_style import BLUE, VERMILION, label_ends, save, use

    use()
    rows = (("wind at\nthe rotor\n(m/s)", lambda run: run["rotor.wind"]), ("rotor\n(rpm)", lambda run: run[SPEED] / RPM),
            ("pitch\n(deg)", lambda run: np.degrees(run["pitch1.angle"])), ("electrical\npower (MW)", lambda run: EFFICIENCY * run["torque"] * run[FAST] / 1e6),
            ("tip out of\nplane (m)", lambda run: run["body.blade1.deflection.z"]), ("tower top\nfore-aft (m)", lambda run: run["body.tower.deflection.z"]))
    figure, axes = plt.subplots(len(rows), 1, figsize=(8.2, 9.0), sharex=True)
    figure.subplots_adjust(left=0.12, right=0.84, top=0.955, bottom=0.055, hspace=0.16)
    for axis, (label, read) in zip(axes, rows):
        for (name, run), colour in zip(reversed(runs.items()), (VERMILION, BLUE)):
            axis.plot(run["time"], read(run), color=colour, label=name, linewidth=1.6 if colour == BLUE else 0.9)
        axis.set_ylabel(label)
    axes[0].set_title("NREL 5 MW turbine with its reference controller, through FMPy")
    axes[-1].set(xlabel="time (s)", xlim=(0.0, max(run["time"][-1] for run in runs.values())))
    label_ends(axes[1])
    figure.align_ylabels()
    path.parent.mkdir(parents=True, exist_ok=True)
    save(figure, path)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--foldwing", required=True, help="the command `foldwing`")
    parser.add_argument("--duration", type=float, default=600.0, help="duration of the runs in s (default: 600)")
    parser.add_argument("--mean", type=float, default=MEAN_M_S, help=f"mean wind in m/s (default: {MEAN_M_S})")
    parser.add_argument("--seed", type=int, default=SEED, help=f"seed of the turbulence (default: {SEED})")
    parser.add_argument("--picture", type=Path, help="output file of the time histories")
    parser.add_argument("--points", action="store_true", help="compare operating points with OpenFAST's map instead")
    parser.add_argument("--table", type=Path, help="output file of the table of --points")
    parser.add_argument("--real-time", type=Path, help="output file of the model under turbulence in real-time mode, for `foldwing latency`; no simulation")
    arguments = parser.parse_args()

    if arguments.real_time:
        text = in_real_time(turbulent(MODEL.read_text(encoding="utf-8"), arguments.mean, arguments.seed, arguments.duration))
        arguments.real_time.write_text(with_polars(text), encoding="utf-8")
        return
    if arguments.points:
        text = table(operating_points(arguments.foldwing))
        print(text, end="")
        if arguments.table:
            arguments.table.write_text(f"{HEAD}Written by `make turbine`, {time.strftime('%Y-%m-%d')}.\n\n{text}", encoding="utf-8")
        return
    text = MODEL.read_text(encoding="utf-8")
    runs = {}
    for name, model in (("steady", steady(text, arguments.mean)),
                        ("turbulent", turbulent(text, arguments.mean, arguments.seed, arguments.duration))):
        runs[name], seconds = fly(arguments.foldwing, model, arguments.duration)
        print(summary(name, runs[name], seconds))
    if arguments.picture:
        draw(runs, arguments.picture)


if __name__ == "__main__":
    main()
