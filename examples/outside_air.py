#!/usr/bin/env python3
"""External aerodynamics: a quasi-steady strip theory in Python coupled with an FMU without aerodynamics.

Usage: outside_air.py --fmu FoldingWing.fmu --output FILE.csv [--wind 0 -10 0] [--step 5e-4] [--iterations 20]

Every load station of the FMU (`station.<body>[i]`, `load.<body>[i]`) is the middle of a strip. The theory is that of
the built-in strip model without lag, apparent mass and suction: NOTATION eqs. (W2), (W4) and (W7) with `w_e = w`. The FMU's
root must not rotate, and its loads must be dead loads (`load_frame = "root"`, the default).

Two coupling schemes. Explicit: the loads of the last communication point are held during the step; first order in the step,
and unstable if the aerodynamic damping is large relative to the wing's inertia within a step. Implicit: every step is
repeated from a saved FMU state, with the mean of the loads at both ends, until the loads at its end agree with the motion
there, which leaves no first-order error.
"""

import argparse
import csv
import re
import shutil
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave

AXES = "xyz"
SOLVER_TOLERANCE = 1e-6  # solver tolerance of the FMU: the default 1e-4 gives velocities too inaccurate for an iteration over half a millisecond
STALLED = 1e-2  # fraction of the largest load
TINY_N = 1e-12  # zero loads: avoid division by zero
RECORDED = ["fold.angle", "gauge.root.strain", "tip.position.x", "tip.position.z", "energy.work"]


@dataclass
class Motion:
    """Motion of all stations in the root frame, one row each."""

    position_m: np.ndarray
    velocity_m_s: np.ndarray
    spin_rad_s: np.ndarray
    rotation: np.ndarray  # root <- section, one 3x3 matrix each


@dataclass
class Loads:
    """Forces in N and moments in N·m on all stations in the root frame, one row each."""

    force_n: np.ndarray
    moment_n_m: np.ndarray

    def flat(self):
        """Flat vector: forces, then moments."""
        return np.concatenate([self.force_n.ravel(), self.moment_n_m.ravel()])

    @classmethod
    def from_flat(cls, numbers):
        """The inverse of `flat`."""
        return cls(*np.asarray(numbers).reshape(2, -1, 3))


@dataclass
class QuasiSteadyStrips:
    """Thin plates, one per station, in a uniform wind. Chord lines are along the section's y axis."""

    width_m: np.ndarray  # width of each strip along the span
    wind_m_s: np.ndarray  # wind velocity, root frame
    leading_m: float = 0.025  # y of the leading edge in the section frame
    trailing_m: float = -0.025
    density_kg_m3: float = 1.225
    lift_slope_1_rad: float = 2.0 * np.pi

    def loads(self, motion):
        """Loads about the stations, eqs. (W2), (W4) and (W7) without lag and suction."""
        span, chordwise = motion.rotation[:, :, 0], motion.rotation[:, :, 1]
        across = np.cross(chordwise * (self.trailing_m - self.leading_m), span)
        up = across / np.linalg.norm(across, axis=1, keepdims=True)
        aft = np.cross(span, up)
        chord_m = abs(self.trailing_m - self.leading_m)

        arm_m = [chordwise * edge_m for edge_m in (self.leading_m, self.trailing_m)]
        air_m_s = [self.wind_m_s - motion.velocity_m_s - np.cross(motion.spin_rad_s, arm) for arm in arm_m]
        middle_m_s = 0.5 * (air_m_s[0] + air_m_s[1])
        difference_m_s = dot(air_m_s[1] - air_m_s[0], up)
        along_m_s, middle_up_m_s = dot(middle_m_s, aft), dot(middle_m_s, up)

        # leading edge: the control point is aft of mid-chord, the centre of pressure forward of it
        size_m_s = np.sqrt(along_m_s**2 + middle_up_m_s**2 + (0.25 * difference_m_s) ** 2)
        bias = np.divide(along_m_s, size_m_s, out=np.zeros_like(size_m_s), where=size_m_s > 0.0)
        downwash_m_s = middle_up_m_s + 0.25 * bias * difference_m_s
        pressure_arm_m = arm_m[0] + (arm_m[1] - arm_m[0]) * (0.5 - 0.25 * bias)[:, None]

        circulation_m2_s = 0.5 * chord_m * self.lift_slope_1_rad * downwash_m_s
        force_n = up * (self.density_kg_m3 * np.abs(along_m_s) * circulation_m2_s * self.width_m)[:, None]
        curvature_n_m = -np.pi / 16.0 * self.density_kg_m3 * chord_m**2 * along_m_s * bias * difference_m_s * self.width_m
        # nose-up rotation moves the leading edge, opposite to `aft`, towards `up`
        moment_n_m = np.cross(pressure_arm_m, force_n) + np.cross(up, aft) * curvature_n_m[:, None]
        return Loads(force_n, moment_n_m)


def dot(a, b):
    """Scalar products of rows."""
    return np.einsum("ij,ij->i", a, b)


def rotation(quaternion):
    """Matrices of unit quaternions (w, x, y, z), one row each."""
    w, x, y, z = np.asarray(quaternion).T
    return np.stack(
        [
            np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)], axis=-1),
            np.stack([2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)], axis=-1),
            np.stack([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], axis=-1),
        ],
        axis=-2,
    )


class Wing:
    """FMU instance as stations with motion and loads."""

    def __init__(self, path, folder, solver_tolerance):
        description = read_model_description(str(path))
        self.reference = {variable.name: variable.valueReference for variable in description.modelVariables}
        found = (re.fullmatch(r"station\.(\w+)\[(\d+)\]\.position\.x", name) for name in self.reference)
        self.stations = [(match[1], int(match[2])) for match in found if match]
        self.default_stop_s = float(description.defaultExperiment.stopTime)
        self.default_step_s = float(description.defaultExperiment.stepSize)
        self.motion_references = [
            self.reference[f"station.{body}[{i}].{quantity}.{axis}"]
            for quantity, axes in [("position", AXES), ("velocity", AXES), ("angular_velocity", AXES), ("rotation", "wxyz")]
            for body, i in self.stations
            for axis in axes
        ]
        self.load_references = [
            self.reference[f"load.{body}[{i}].{quantity}.{axis}"]
            for quantity in ("force", "moment")
            for body, i in self.stations
            for axis in AXES
        ]
        self.slave = FMU2Slave(
            guid=description.guid,
            unzipDirectory=str(folder),
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName="wing",
        )
        self.slave.instantiate()
        self.slave.setupExperiment(tolerance=solver_tolerance, startTime=0.0)
        self.slave.enterInitializationMode()

    def start(self):
        """Leave Initialization Mode."""
        self.slave.exitInitializationMode()

    def motion(self):
        """Current motion of all stations."""
        values = np.array(self.slave.getReal(self.motion_references))
        count = len(self.stations)
        vectors, quaternions = values[: 9 * count].reshape(3, count, 3), values[9 * count :].reshape(count, 4)
        return Motion(*vectors, rotation(quaternions))

    def widths_m(self):
        """Width of each strip: stations are at the centres of equal strips of a body that is straight at the start."""
        position_m = self.motion().position_m
        widths = {}
        for row, (body, i) in enumerate(self.stations):
            if i == 2:
                widths[body] = np.linalg.norm(position_m[row] - position_m[row - 1])
        return np.array([widths[body] for body, _ in self.stations])

    def set_loads(self, loads):
        """Set the loads, held until the next call."""
        self.slave.setReal(self.load_references, list(loads))

    def get(self, name):
        """Value of one Real output."""
        return self.slave.getReal([self.reference[name]])[0]


@contextmanager
def opened(path, solver_tolerance=SOLVER_TOLERANCE):
    """Instantiate a wing in Initialization Mode, unpacked into a temporary folder."""
    folder = extract(str(path))
    wing = Wing(path, folder, solver_tolerance)
    try:
        yield wing
    finally:
        wing.slave.terminate()
        wing.slave.freeInstance()
        shutil.rmtree(folder, ignore_errors=True)


def couple(path, air, stop_s=None, step_s=None, iterations=0, tolerance=1e-9, solver_tolerance=SOLVER_TOLERANCE):
    """Simulate FMU and aerodynamics; `air` creates an object with `loads(motion)` from the widths of the strips.

    `iterations`: 0 for explicit coupling, otherwise the maximum number of repetitions of a step; a step ends when no load
    changes by more than `tolerance` of the largest so far. Returns columns by name, among them the number of repetitions
    of each step.
    """
    with opened(path, solver_tolerance) as wing:
        strips = air(wing.widths_m())
        loads = strips.loads(wing.motion()).flat()
        wing.set_loads(loads)
        wing.start()
        stop_s, step_s = stop_s or wing.default_stop_s, step_s or wing.default_step_s
        rows = [record(wing, 0.0, loads, 0)]
        largest = np.abs(loads).max()
        for index in range(round(stop_s / step_s)):
            time_s = index * step_s
            if iterations:
                loads, used = iterated_step(wing, strips, loads, time_s, step_s, iterations, tolerance, largest)
            else:
                wing.set_loads(loads)
                wing.slave.doStep(time_s, step_s)
                loads, used = strips.loads(wing.motion()).flat(), 0
            largest = max(largest, np.abs(loads).max())
            rows.append(record(wing, time_s + step_s, loads, used))
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}


def iterated_step(wing, strips, loads, time_s, step_s, iterations, tolerance, largest):
    """Perform one step, repeated from the saved state until the loads at its end converge; returns loads and repetitions.

    `tolerance` is relative to the larger of the `largest` load so far and the largest current one. An FMU with variable
    steps may select slightly different steps in each repetition; if the change therefore stagnates below `STALLED` of the
    largest load, the step ends as well.
    """
    before = wing.slave.getFMUState()
    guess, last = loads, np.inf
    try:
        for used in range(1, iterations + 1):
            if used > 1:
                wing.slave.setFMUState(before)
            wing.set_loads(0.5 * (loads + guess))
            wing.slave.doStep(time_s, step_s)
            found = strips.loads(wing.motion()).flat()
            change = np.abs(found - guess).max() / max(largest, np.abs(found).max(), TINY_N)
            if change <= tolerance or last <= change < STALLED:
                return found, used
            guess, last = found, change
    finally:
        wing.slave.freeFMUState(before)
    raise RuntimeError(f"loads at {time_s + step_s} s still change by {change:.1e} after {iterations} repetitions")


def record(wing, time_s, loads, repetitions):
    """One row of the result."""
    row = {"time": time_s, "repetitions": repetitions}
    row.update({name: wing.get(name) for name in RECORDED})
    row["fold.latch_time"] = wing.get("fold.latch_time")
    force_n = Loads.from_flat(loads).force_n.sum(axis=0)
    row.update({f"aero.force.{axis}": value for axis, value in zip(AXES, force_n)})
    return row


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--fmu", required=True, help="FMU of a folding wing without aerodynamics")
    parser.add_argument("--output", required=True, help="output file (CSV)")
    parser.add_argument("--wind", type=float, nargs=3, default=[0.0, -10.0, 0.0], help="wind velocity, m/s")
    parser.add_argument("--density", type=float, default=1.225, help="air density, kg/m3")
    parser.add_argument("--leading", type=float, default=0.025, help="y of the leading edge in the section frame, m")
    parser.add_argument("--trailing", type=float, default=-0.025, help="y of the trailing edge, m")
    parser.add_argument("--stop", type=float, help="stop time, s (default: that of the FMU)")
    parser.add_argument("--step", type=float, help="communication step, s (default: that of the FMU)")
    parser.add_argument("--iterations", type=int, default=0, help="maximum number of repetitions of a step; 0: explicit coupling")
    arguments = parser.parse_args()

    def air(widths_m):
        wind_m_s = np.array(arguments.wind)
        return QuasiSteadyStrips(widths_m, wind_m_s, arguments.leading, arguments.trailing, arguments.density)

    result = couple(arguments.fmu, air, arguments.stop, arguments.step, arguments.iterations)
    with open(arguments.output, "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(result)
        writer.writerows([[repr(value.item()) for value in row] for row in zip(*result.values())])
    latch_s, strain = result["fold.latch_time"][-1], np.abs(result["gauge.root.strain"]).max()
    print(f"fold.latch_time   {'did not latch' if latch_s < 0 else f'{latch_s:.4f} s'}")
    print(f"peak root strain  {strain:.3e}")
    print(f"repetitions       {result['repetitions'][1:].mean():.1f} per step")


if __name__ == "__main__":
    main()
