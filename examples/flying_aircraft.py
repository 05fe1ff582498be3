#!/usr/bin/env python3
"""Coupling of two folding wings with an aircraft: a rigid fuselage in Python and two instances of one FMU.

Usage: flying_aircraft.py --fmu target/fmu/FoldingWing.fmu [--step 5e-4] [--tolerance 1e-8] [--solver quasi-newton]
                          [--csv OUT.csv]

The aircraft falls while its wings unfold, the left one released 50 ms after the right one, with a gust load. The fuselage
prescribes the motion of the wing roots, the wings return reactions:

    fuselage -> wing   root.acceleration, root.angular_velocity, root.angular_acceleration, gravity
    wing -> fuselage   root.force, root.moment

Both directions have direct feedthrough: loads depend on accelerations, accelerations on loads (an algebraic loop). Every step
is therefore repeated from saved FMU states until they agree at its end. Within a step the inputs are linear in time: the
coupling is of second order, except for vibrations right after a jump. The unknowns are the six accelerations of the fuselage;
the solvers differ in their Jacobian of the wing loads, which is the apparent mass of the wings:

    held           no Jacobian, no repetitions (explicit): first order
    fixed-point    no Jacobian: slow, and divergent if the wings are heavier than the fuselage
    newton         directional derivatives of the FMU. They keep the state constant: exact at the start and for very short
                   steps, but over a finite step the flexible wing couples far more of its mass than at an instant
    quasi-newton   starts like newton and updates the Jacobian in its own repetitions (Broyden), over all steps

Body axes: x right, y forward, z up, origin in the fuselage's centre of mass. The FMU's x axis is along its span, so the
left wing is the right one rotated by 180 degrees about z. That is its mirror image if section and hinge are symmetric
fore and aft, as here; a swept wing needs a separate model file for the other side. `Mount` positions each wing on the
fuselage: the lever arms of its root enter motion and moments.
"""

import argparse
import csv
import shutil
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave

AXES = "xyz"
GRAVITY_M_S2 = np.array([0.0, 0.0, -9.81])
WING_KG = 0.06305  # `foldwing check examples/models/folding_wing.toml`
ROOT_M = np.array([0.0, -0.02, 0.03])  # attachment of both wings to the fuselage, relative to its centre of mass
RELEASE_S = {"right": 0.0, "left": 0.05}
START_M_S, START_RAD_S = np.array([0.0, 12.0, 0.0]), np.radians([10.0, 40.0, -20.0])  # of the wing roots, body axes
GUST_S = (0.02, 0.08)  # 1 - cos shape
GUST_N, GUST_N_M = np.array([0.3, -0.2, 2.0]), np.array([0.004, 0.02, 0.003])  # on the wing roots, inertial axes

# Only internal damping of the wings: mass-proportional damping, relative to the moving root, would remove momentum.
DAMPING = {
    "body.inner.mass_damping": 0.0,
    "body.inner.stiffness_damping": 2e-4,
    "body.outer.mass_damping": 0.0,
    "body.outer.stiffness_damping": 2e-4,
}
SOLVERS = ("held", "fixed-point", "newton", "quasi-newton")
ARM_M = 0.15  # weight of moments relative to forces, and of angular relative to linear accelerations
HALVINGS = 12  # number of halvings of the first step after a jump
TINY_N = 1e-12  # zero loads: avoid division by zero


@dataclass(frozen=True)
class Mount:
    """Mounting of a wing on the fuselage: position of its root from the centre of mass in body axes, rotation body axes <- root frame."""

    root_m: np.ndarray
    rotation: np.ndarray


MOUNTS = {"right": Mount(ROOT_M, np.diag([1.0, 1.0, 1.0])), "left": Mount(ROOT_M, np.diag([-1.0, -1.0, 1.0]))}


@dataclass
class Motion:
    """Motion of the fuselage: position and velocity of its centre of mass in inertial axes, other quantities in body axes."""

    position_m: np.ndarray
    velocity_m_s: np.ndarray
    attitude: np.ndarray  # quaternion (w, x, y, z), inertial <- body
    spin_rad_s: np.ndarray
    accelerations: np.ndarray  # acceleration of the centre of mass in m/s2, then the angular acceleration in rad/s2

    def to_body(self, vector):
        """Transform a vector from inertial to body axes."""
        return rotation(self.attitude).T @ vector


@dataclass
class Fuselage:
    """Rigid body, with inertia about the centre of mass in body axes."""

    mass_kg: float = 0.3
    inertia_kg_m2: np.ndarray = field(
        default_factory=lambda: np.array([[2.4e-3, 0.0, 0.0], [0.0, 3e-4, 9e-5], [0.0, 9e-5, 2.55e-3]])
    )

    def mass_matrix(self):
        """Mass matrix: derivative of force and moment with respect to accelerations, 6x6."""
        zero = np.zeros((3, 3))
        return np.block([[self.mass_kg * np.eye(3), zero], [zero, self.inertia_kg_m2]])

    def missing(self, motion, load):
        """Residual force and moment of the equations of motion (body axes), excluding gravity and the load."""
        spin, weight_n = motion.spin_rad_s, self.mass_kg * motion.to_body(GRAVITY_M_S2)
        gyroscopic_n_m = np.cross(spin, self.inertia_kg_m2 @ spin)
        return self.mass_matrix() @ motion.accelerations + np.concatenate([-weight_n, gyroscopic_n_m]) - load

    @staticmethod
    def advanced(start, accelerations, step_s):
        """Advance the motion by a step with accelerations that change linearly to the given ones; second order."""
        spin_rad_s = start.spin_rad_s + 0.5 * step_s * (start.accelerations[3:] + accelerations[3:])
        attitude = product(start.attitude, turn(0.5 * step_s * (start.spin_rad_s + spin_rad_s)))
        first, last = rotation(start.attitude) @ start.accelerations[:3], rotation(attitude) @ accelerations[:3]
        velocity_m_s = start.velocity_m_s + 0.5 * step_s * (first + last)
        position_m = start.position_m + step_s * start.velocity_m_s + step_s**2 * (2.0 * first + last) / 6.0
        return Motion(position_m, velocity_m_s, attitude, spin_rad_s, accelerations)


class Wing:
    """FMU instance on the fuselage, in Initialization Mode."""

    def __init__(self, path, folder, side, solver_tolerance, mount):
        description = read_model_description(str(path))
        self.reference = {variable.name: variable.valueReference for variable in description.modelVariables}
        self.side, self.root_m, self.mount = side, mount.root_m, mount.rotation
        self.accelerations = self.vector("root.acceleration") + self.vector("root.angular_acceleration")
        self.motion = self.accelerations + self.vector("root.angular_velocity") + self.vector("gravity")
        self.reaction = self.vector("root.force") + self.vector("root.moment")
        self.slave = FMU2Slave(
            guid=description.guid,
            unzipDirectory=str(folder),
            instanceName=side,
            modelIdentifier=description.coSimulation.modelIdentifier,
        )
        self.slave.instantiate()
        self.slave.setupExperiment(tolerance=solver_tolerance, startTime=0.0)
        for name, value in DAMPING.items():
            self.slave.setReal([self.reference[name]], [value])
        self.release(RELEASE_S[side] <= 0.0)
        self.slave.enterInitializationMode()

    def vector(self, group):
        """Value references of a vector."""
        return [self.reference[f"{group}.{axis}"] for axis in AXES]

    def get(self, name):
        """Value of a Real output."""
        return self.slave.getReal([self.reference[name]])[0]

    def release(self, let_go):
        """Release or lock the fold joint."""
        self.slave.setBoolean([self.reference["fold.release"]], [let_go])

    def root_accelerations(self, accelerations):
        """Matrix from accelerations of the fuselage to those of the root, root frame, without terms of the angular velocity."""
        root_m_s2 = accelerations[:3] + np.cross(accelerations[3:], self.root_m)
        return np.concatenate([root_m_s2 @ self.mount, accelerations[3:] @ self.mount])

    def root_motion(self, motion):
        """FMU inputs for a motion of the fuselage."""
        spin = motion.spin_rad_s
        centripetal = np.concatenate([np.cross(spin, np.cross(spin, self.root_m)), np.zeros(3)])
        rest = [spin @ self.mount, motion.to_body(GRAVITY_M_S2) @ self.mount]
        return np.concatenate([self.root_accelerations(motion.accelerations + centripetal), *rest])

    def set_motion(self, motion):
        """Set the FMU inputs."""
        self.slave.setReal(self.motion, list(self.root_motion(motion)))

    def step(self, time_s, step_s, start, end):
        """Perform a communication step with inputs linear in time from one motion to another."""
        self.set_motion(start)
        rates = (self.root_motion(end) - self.root_motion(start)) / step_s
        self.slave.setRealInputDerivatives(self.motion, [1] * len(rates), list(rates))
        self.slave.doStep(time_s, step_s)

    def load(self):
        """Force and moment on the fuselage, about its centre of mass in body axes."""
        return self.about_centre(self.slave.getReal(self.reaction))

    def about_centre(self, reaction):
        """Transfer a reaction at the root to the fuselage's centre of mass, in body axes."""
        force_n, moment_n_m = np.reshape(reaction, (2, 3)) @ self.mount.T
        return np.concatenate([force_n, moment_n_m + np.cross(self.root_m, force_n)])

    def apparent_mass(self):
        """Apparent mass: decrease of the load per unit of the fuselage's accelerations at constant positions and velocities, 6x6."""
        columns = []
        for unit in np.eye(6):
            seed = list(self.root_accelerations(unit))
            derivative = self.slave.getDirectionalDerivative(self.reaction, self.accelerations, seed)
            columns.append(-self.about_centre(derivative))
        return np.array(columns).T

    def first_moment_kg_m(self):
        """Product of mass and position of the centre of mass relative to the root, body axes: minus the derivative of the potential energy
        with respect to gravity."""
        potential = [self.reference["energy.gravity"]]
        by_axis = [self.slave.getDirectionalDerivative(potential, [axis], [1.0])[0] for axis in self.vector("gravity")]
        return -self.mount @ by_axis


@dataclass
class Coupling:
    """Settings of the coupling of fuselage and wings."""

    step_s: float = 5e-4
    solver: str = "quasi-newton"
    tolerance: float = 1e-8  # tolerance of the loads at the end of a step, relative to the largest so far
    repetitions: int = 50  # maximum number per step


class Aircraft:
    """Fuselage with wings: common motion and coupling iteration."""

    def __init__(self, fuselage, wings, coupling, gust=True):
        self.fuselage, self.wings, self.coupling, self.gust = fuselage, wings, coupling, gust
        self.time_s, self.jumped, self.largest_n = 0.0, True, TINY_N
        self.learned = {}  # by step length: correction of the instantaneous Jacobian
        self.steps_taken = 0  # by each wing, repetitions included
        velocity_m_s = START_M_S - np.cross(START_RAD_S, ROOT_M)
        self.motion = Motion(-ROOT_M, velocity_m_s, np.array([1.0, 0.0, 0.0, 0.0]), START_RAD_S, np.zeros(6))
        self.settle()

    def missing(self, motion, time_s):
        """Residual force and moment of a motion under the wing loads, and its norm relative to these."""
        load = sum(wing.load() for wing in self.wings)
        self.largest_n = max(self.largest_n, size_n(load))
        if self.gust:
            force_n, moment_n_m = (motion.to_body(gust_share(time_s) * part) for part in (GUST_N, GUST_N_M))
            load = load + np.concatenate([force_n, moment_n_m + np.cross(ROOT_M, force_n)])
        missing = self.fuselage.missing(motion, load)
        return missing, size_n(missing) / self.largest_n

    def settle(self):
        """Solve for the initial accelerations. The loads are linear in them, so one correction suffices."""
        for wing in self.wings:
            wing.set_motion(self.motion)
        missing, _ = self.missing(self.motion, self.time_s)
        slope = self.fuselage.mass_matrix() + sum(wing.apparent_mass() for wing in self.wings)
        self.motion = replace(self.motion, accelerations=self.motion.accelerations - np.linalg.solve(slope, missing))
        for wing in self.wings:
            wing.set_motion(self.motion)
        self.start_share = self.missing(self.motion, self.time_s)[1]
        for wing in self.wings:
            wing.slave.exitInitializationMode()

    def release(self, side):
        """Release the joint of a wing."""
        for wing in self.wings:
            if wing.side == side:
                wing.release(True)
        self.jumped = True

    def step(self, step_s):
        """Perform a communication step; after a jump with substeps of doubling length, to resolve the initial vibration."""
        parts = [2.0**-HALVINGS] + [2.0**-i for i in range(HALVINGS, 0, -1)] if self.jumped else [1.0]
        self.jumped = False
        for part in parts:
            if self.coupling.solver == "held":
                self.step_held(part * step_s)
            else:
                self.step_agreed(part * step_s)

    def step_held(self, step_s):
        """Explicit step: the wings use the accelerations at its start, the fuselage the loads at its end."""
        held = self.fuselage.advanced(self.motion, self.motion.accelerations, step_s)
        missing = self.try_step(held, step_s)[0]
        accelerations = held.accelerations - np.linalg.solve(self.fuselage.mass_matrix(), missing)
        self.motion, self.time_s = self.fuselage.advanced(self.motion, accelerations, step_s), self.time_s + step_s

    def step_agreed(self, step_s):
        """Implicit step, repeated from the saved states until loads and motion at its end are consistent."""
        slope, tried = self.slope(step_s), None
        accelerations = self.motion.accelerations
        with saved(self.wings) as restore:
            for repetition in range(self.coupling.repetitions):
                if repetition:
                    restore()
                end = self.fuselage.advanced(self.motion, accelerations, step_s)
                missing, share = self.try_step(end, step_s)
                if share <= self.coupling.tolerance:
                    self.motion, self.time_s = end, self.time_s + step_s
                    return
                if tried and self.coupling.solver == "quasi-newton":
                    slope += self.lesson(slope, accelerations - tried[0], missing - tried[1], step_s)
                tried = accelerations, missing
                accelerations = accelerations - np.linalg.solve(slope, missing)
        at = f"{self.time_s + step_s:.6f} s"
        raise RuntimeError(f"loads at {at} are off by {share:.1e} after {self.coupling.repetitions} repetitions")

    def try_step(self, end, step_s):
        """Advance the wings to the end of a step; returns the residual there."""
        for wing in self.wings:
            wing.step(self.time_s, step_s, self.motion, end)
        self.steps_taken += 1
        return self.missing(end, self.time_s + step_s)

    def slope(self, step_s):
        """Jacobian of the residual with respect to the accelerations, as approximated by the solver, 6x6."""
        slope = self.fuselage.mass_matrix()
        if self.coupling.solver != "fixed-point":
            slope = slope + sum(wing.apparent_mass() for wing in self.wings)
        return slope + self.learned.get(step_s, 0.0)

    def lesson(self, slope, change, effect, step_s):
        """Broyden update of the Jacobian along the last change of accelerations; kept for later steps."""
        weighted = np.array([1.0, 1.0, 1.0, ARM_M**2, ARM_M**2, ARM_M**2]) * change
        correction = np.outer(effect - slope @ change, weighted) / (weighted @ change)
        self.learned[step_s] = self.learned.get(step_s, 0.0) + correction
        return correction

    def centre_of_mass(self):
        """Centre of mass of fuselage and wings, inertial axes, m."""
        mass_kg = self.fuselage.mass_kg + WING_KG * len(self.wings)
        moment_kg_m = sum(WING_KG * wing.root_m + wing.first_moment_kg_m() for wing in self.wings)
        return self.motion.position_m + rotation(self.motion.attitude) @ moment_kg_m / mass_kg


@contextmanager
def saved(wings):
    """Save the states of the FMUs; calling the returned function restores them."""
    states = [wing.slave.getFMUState() for wing in wings]

    def restore():
        for wing, state in zip(wings, states):
            wing.slave.setFMUState(state)

    try:
        yield restore
    finally:
        for wing, state in zip(wings, states):
            wing.slave.freeFMUState(state)


def rotation(quaternion):
    """Matrix of a unit quaternion (w, x, y, z)."""
    w, x, y, z = quaternion
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + 2.0 * (w * cross + cross @ cross)


def turn(vector_rad):
    """Unit quaternion of a rotation vector."""
    half_rad = 0.5 * np.linalg.norm(vector_rad)
    return np.concatenate([[np.cos(half_rad)], 0.5 * np.sinc(half_rad / np.pi) * vector_rad])


def product(p, q):
    """Product of two quaternions, normalised."""
    scalar, vector = p[0] * q[0] - p[1:] @ q[1:], p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:])
    whole = np.concatenate([[scalar], vector])
    return whole / np.linalg.norm(whole)


def size_n(load):
    """Magnitude of a force and a moment as one number in N."""
    return max(np.linalg.norm(load[:3]), np.linalg.norm(load[3:]) / ARM_M)


def gust_share(time_s):
    """Fraction of the gust's peak, from 0 to 1."""
    begin_s, end_s = GUST_S
    phase = 2.0 * np.pi * (time_s - begin_s) / (end_s - begin_s)
    return 0.5 * (1.0 - np.cos(phase)) if begin_s < time_s < end_s else 0.0


def record(aircraft):
    """One row of the result."""
    motion = aircraft.motion
    row = {"time": aircraft.time_s, "steps": aircraft.steps_taken}
    vectors = {
        "position": motion.position_m,
        "velocity": motion.velocity_m_s,
        "spin": motion.spin_rad_s,
        "centre": aircraft.centre_of_mass(),
    }
    row.update({f"{name}.{axis}": value for name, vector in vectors.items() for axis, value in zip(AXES, vector)})
    row.update({f"attitude.{name}": value for name, value in zip("wxyz", motion.attitude)})
    for wing in aircraft.wings:
        row.update({f"{wing.side}.{name}": wing.get(name) for name in ("fold.angle", "fold.latch_time")})
    return row


@contextmanager
def opened(fmu, coupling=None, fuselage=None, gust=True, solver_tolerance=1e-9, mounts=MOUNTS):
    """Create the aircraft at the start, with its FMU unpacked into a temporary folder."""
    folder, wings = extract(str(fmu)), []
    try:
        for side, mount in mounts.items():
            wings.append(Wing(fmu, folder, side, solver_tolerance, mount))
        yield Aircraft(fuselage or Fuselage(), wings, coupling or Coupling(), gust)
    finally:
        for wing in wings:
            wing.slave.freeInstance()
        shutil.rmtree(folder, ignore_errors=True)


def fly(aircraft, stop_s, watch=lambda aircraft: None):
    """Simulate to `stop_s`; returns columns by name. `watch` is called at every communication point.

    A wing is released at the communication point nearest to its time.
    """
    rows, step_s = [record(aircraft)], aircraft.coupling.step_s
    watch(aircraft)
    for index in range(round(stop_s / step_s)):
        for side, release_s in RELEASE_S.items():
            if index and index == round(release_s / step_s):
                aircraft.release(side)
        aircraft.step(step_s)
        rows.append(record(aircraft))
        watch(aircraft)
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--fmu", required=True, help="FMU of examples/models/folding_wing.toml")
    parser.add_argument("--stop", type=float, default=0.2, help="stop time, s")
    parser.add_argument("--step", type=float, default=5e-4, help="communication step, s")
    parser.add_argument("--tolerance", type=float, default=1e-8, help="relative tolerance of the loads at the end of a step")
    parser.add_argument("--solver", choices=SOLVERS, default="quasi-newton")
    parser.add_argument("--csv", type=Path, help="output file of the motion")
    arguments = parser.parse_args()
    if not 0.0 < arguments.step <= arguments.stop:
        parser.error(f"--step {arguments.step} s must be above 0 and at most --stop {arguments.stop} s")
    if not arguments.tolerance > 0.0:
        parser.error(f"--tolerance {arguments.tolerance} must be above 0")

    with opened(arguments.fmu, Coupling(arguments.step, arguments.solver, arguments.tolerance)) as aircraft:
        result = fly(aircraft, arguments.stop)
    if arguments.csv:
        with open(arguments.csv, "w", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(result)
            writer.writerows([[repr(value.item()) for value in row] for row in zip(*result.values())])
    for side in MOUNTS:
        latch_s = result[f"{side}.fold.latch_time"][-1]
        print(f"{side + ' wing':23}{'did not latch' if latch_s < 0 else f'latches at {latch_s:.4f} s'}")
    print(f"steps of each FMU      {result['steps'][-1] / (len(result['time']) - 1):.1f} per communication step")
    print(f"fastest roll           {np.degrees(np.abs(result['spin.y']).max()):.0f} deg/s")


if __name__ == "__main__":
    main()
