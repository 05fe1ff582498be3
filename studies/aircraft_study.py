#!/usr/bin/env python3
"""Accuracy of the coupling in examples/flying_aircraft.py: comparison with the same aircraft as one model, and balance of momentum.

Usage: aircraft_study.py --foldwing COMMAND --fmu FoldingWing.fmu --table FILE.md --pictures FOLDER

The reference, examples/flying_aircraft.toml, needs no coupling. Momentum is measured in two ways: the centre of mass from the derivative
of the wings' potential energy with respect to gravity, angular momentum from an FMU of the same wing with stations at the Gauss points
of its elements.
"""

import argparse
import datetime
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from fmpy import extract, read_model_description
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Slave

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "examples"))

from flying_aircraft import (  # noqa: E402
    AXES,
    GRAVITY_M_S2,
    GUST_N,
    GUST_N_M,
    GUST_S,
    MOUNTS,
    RELEASE_S,
    ROOT_M,
    SOLVERS,
    WING_KG,
    Coupling,
    Fuselage,
    fly,
    gust_share,
    opened,
    rotation,
    saved,
)
from plot_aircraft import draw_convergence, draw_flight  # noqa: E402

WHOLE = ROOT / "examples/flying_aircraft.toml"
WING = ROOT / "examples/models/folding_wing.toml"
WHOLE_STEP_S = 1.25e-4  # the gust is linear between two of them
HALVES = 8  # of a body: four linear elements with two halves each
GAUSS = np.polynomial.legendre.leggauss(4)  # exact for products of two cubics
BODY_M, DENSITY_KG_M, ACTUATOR_KG = 0.15, 1425.0 * 0.05 * 0.002, 0.0203
SECTION_KG_M = 1425.0 / 12.0 * np.array([0.05**3 * 0.002 + 0.05 * 0.002**3, 0.05 * 0.002**3, 0.05**3 * 0.002])

STOP_S, PLACES_S, SHAPES_S = 0.2, (0.09, 0.2), (0.0, 0.05, 0.09, 0.13, 0.2)  # latches close at 0.099 and 0.148 s
STEPS_S, FALL_STEPS_S = (1e-3, 5e-4, 2.5e-4, 1.25e-4, 6.25e-5), (1e-3, 5e-4, 2.5e-4, 1.25e-4)
FALL_S, TOLERANCES = 0.09, (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8)
EFFORT_STEPS_S, FUSELAGES = (1e-3, 1e-4, 1e-5), (10.0, 1.0, 0.1)  # fractions of the fuselage's mass
COMPARED = ("held", "quasi-newton")

PAGE = """# An aircraft with two of the FMUs

Written by `make aircraft` (`studies/aircraft_study.py`), {date}. `examples/flying_aircraft.py` couples a rigid fuselage
of 0.3 kg in Python with two folding wings of 0.063 kg; the same aircraft in one piece, `examples/flying_aircraft.toml`
at a tolerance of 1e-10, is the reference. In brackets: order between a step and the one before.

## Against the aircraft in one piece

With gust; tolerance of the iteration 1e-8 of the largest load. The right latch closes at 98.7 ms, the left one at
148.4 ms.

{agreement}
Steps of 1 ms are too long to show an order. From 0.5 to 0.0625 ms the repeated steps reach orders of {orders} on
average, not 2: behind a jump something decays within any step, however short, and parts of a step that double resolve
it to a share only. Parts that grow more slowly leave less of it.

## Momentum in free fall

Without gust, largest change within {fall_ms} ms, from 65 stations per wing at Gauss points; angular momentum about the
centre of mass. The aircraft's momentum is 5.1 N·s.

{momentum}
The second table has the change due to the tolerance alone, at steps of {step_ms:g} ms against a tolerance of 1e-11.

## Effort of the solvers

Steps of each FMU per communication step, mean of 40 at the beginning, to a tolerance of 1e-8; *fails*: more than 50, or
diverged.

{effort}
Without knowledge of the apparent mass the iteration converges with the ratio of the mass that the wings put against
accelerations of the fuselage to its own. This is not the {wings_g:.0f} g of both wings, nor the mass by the
directional derivatives: these hold the state, and then the beam yields behind the root.

{moved}
So they suffice where steps are so short that the state hardly changes, and at the start, where one correction settles
the loads to round-off. The quasi-Newton iteration obtains the rest from its own repetitions in the first steps,
and keeps it.
"""


def packaged(foldwing, model, archive):
    """Packages a model file as an FMU."""
    subprocess.run([str(foldwing), "package", str(model), "-o", str(archive)], check=True, capture_output=True)
    return archive


def fly_whole(fmu, stop_s, solver_tolerance=1e-10, gust=True, root_m=ROOT_M):
    """Simulates the aircraft as one model; returns the columns that are compared, with the names of the coupling's `record`.

    `root_m` is the position of the right wing's root relative to the fuselage's centre of mass, in body axes.
    """
    description = read_model_description(str(fmu))
    reference = {variable.name: variable.valueReference for variable in description.modelVariables}

    def vector(group, axes=AXES):
        return [reference[f"{group}.{axis}"] for axis in axes]

    loads = vector("load.right_inner[1].force") + vector("load.right_inner[1].moment")
    angles = [reference["fold_right.angle"], reference["fold_left.angle"]]
    outputs = [vector("station.right_inner[1].position"), vector("flight.rotation", "wxyz"), angles]
    folder, rows = extract(str(fmu)), []
    slave = FMU2Slave(
        guid=description.guid,
        unzipDirectory=folder,
        instanceName="aircraft",
        modelIdentifier=description.coSimulation.modelIdentifier,
    )
    slave.instantiate()
    try:
        slave.setupExperiment(tolerance=solver_tolerance, startTime=0.0)
        slave.enterInitializationMode()
        slave.exitInitializationMode()
        for index in range(round(stop_s / WHOLE_STEP_S) + 1):
            time_s = index * WHOLE_STEP_S
            station_m, attitude, angles = (np.array(slave.getReal(group)) for group in outputs)
            rows.append([time_s, *(station_m - rotation(attitude) @ root_m), *attitude, *angles])
            if index == round(RELEASE_S["left"] / WHOLE_STEP_S):
                slave.setBoolean([reference["fold_left.release"]], [True])
            first, last = (
                gust_share(at) * gust * np.concatenate([GUST_N, GUST_N_M]) for at in (time_s, time_s + WHOLE_STEP_S)
            )
            slave.setReal(loads, list(first))
            if np.any(first != last):
                slave.setRealInputDerivatives(loads, [1] * len(loads), list((last - first) / WHOLE_STEP_S))
            slave.doStep(time_s, WHOLE_STEP_S)
    finally:
        slave.freeInstance()
        shutil.rmtree(folder, ignore_errors=True)
    names = [f"position.{axis}" for axis in AXES] + [f"attitude.{axis}" for axis in "wxyz"]
    return dict(zip(["time", *names, "right.fold.angle", "left.fold.angle"], np.array(rows).T))


def vectors(result, name, axes=AXES):
    """Columns of a vector, one row per time."""
    return np.column_stack([result[f"{name}.{axis}"] for axis in axes])


def at(result, time_s):
    """Position of the fuselage (m), attitude (matrix) and fold angles (rad) at a communication point."""
    row = int(np.argmin(np.abs(result["time"] - time_s)))
    assert abs(result["time"][row] - time_s) < 1e-9, f"{time_s} s is no communication point"
    attitude = rotation(vectors(result, "attitude", "wxyz")[row])
    return vectors(result, "position")[row], attitude, np.array([result[f"{side}.fold.angle"][row] for side in MOUNTS])


def distance(result, reference, time_s):
    """Distance between two runs: position of the fuselage in m, attitude in rad, and the larger difference of the fold angles in rad."""
    (place, attitude, angles), (other_place, other_attitude, other_angles) = at(result, time_s), at(reference, time_s)
    turned = np.linalg.norm(attitude - other_attitude) / np.sqrt(2.0)  # for small angles
    return np.array([np.linalg.norm(place - other_place), turned, np.abs(angles - other_angles).max()])


def free_path_m(start_m, velocity_m_s, mass_kg, times_s, gust):
    """Exact position of the centre of mass: a parabola, and the effect of the gust. One row per time."""
    begin_s, end_s = GUST_S
    length_s = end_s - begin_s
    within_s, after_s = np.clip(times_s - begin_s, 0.0, length_s), np.maximum(times_s - end_s, 0.0)
    ripple_s2 = (length_s / (2.0 * np.pi)) ** 2 * (1.0 - np.cos(2.0 * np.pi * within_s / length_s))
    pushed_s2 = 0.5 * (0.5 * within_s**2 - ripple_s2) + 0.5 * length_s * after_s
    path_m = start_m + np.outer(times_s, velocity_m_s) + np.outer(0.5 * times_s**2, GRAVITY_M_S2)
    return path_m + np.outer(pushed_s2, GUST_N / mass_kg) * gust


def off_path_m(result, fuselage, gust=True):
    """Maximum error of the centre of mass; the aircraft initially moves as a rigid body."""
    centre_m, spin_rad_s = vectors(result, "centre"), vectors(result, "spin")[0]
    velocity_m_s = vectors(result, "velocity")[0] + np.cross(spin_rad_s, centre_m[0] - vectors(result, "position")[0])
    mass_kg = fuselage.mass_kg + WING_KG * len(MOUNTS)
    path_m = free_path_m(centre_m[0], velocity_m_s, mass_kg, result["time"], gust)
    return np.linalg.norm(centre_m - path_m, axis=1).max()


def gauss_points():
    """Distances from a body's inner end in m, and the fraction of its length that each represents."""
    nodes, weights = GAUSS
    places = (np.arange(HALVES)[:, None] + 0.5 * (1.0 + nodes)) / HALVES
    return places.ravel() * BODY_M, np.tile(0.5 * weights, HALVES) / HALVES


def weighed_model():
    """Text of the wing's model with stations at the Gauss points of both bodies, and one at the actuator."""
    places_m = gauss_points()[0]
    text = WING.read_text()
    for body, stations_m in (("inner", [*places_m, BODY_M]), ("outer", places_m)):
        listed = ", ".join(f"{float(place_m)!r}" for place_m in stations_m)
        text = text.replace(f"[body.{body}]\n", f"[body.{body}]\nload_station_positions_m = [{listed}]\n")
    return text


class Balance:
    """Momentum of the aircraft from positions and velocities of the masses, with the FMU of `weighed_model`."""

    def __init__(self, wing):
        _, shares = gauss_points()
        stations = [("inner", i + 1) for i in range(len(shares) + 1)] + [("outer", i + 1) for i in range(len(shares))]
        beam_kg, sections = DENSITY_KG_M * BODY_M * shares, BODY_M * np.outer(shares, SECTION_KG_M)
        self.mass_kg = np.concatenate([beam_kg, [ACTUATOR_KG], beam_kg])
        self.section_kg_m2 = np.vstack([sections, np.zeros(3), sections])  # about the centre of each section
        self.groups = [("position", AXES), ("velocity", AXES), ("angular_velocity", AXES), ("rotation", "wxyz")]
        self.references = [
            wing.reference[f"station.{body}[{i}].{quantity}.{axis}"]
            for quantity, axes in self.groups
            for body, i in stations
            for axis in axes
        ]

    def of_wing(self, wing, motion):
        """Positions and velocities of the masses in inertial axes, and the angular momenta of the sections about their centres."""
        values, count = np.array(wing.slave.getReal(self.references)), len(self.mass_kg)
        place, velocity, spin = values[: 9 * count].reshape(3, count, 3) @ wing.mount.T
        place = place + wing.root_m
        velocity = velocity + np.cross(motion.spin_rad_s, place)
        spin = spin + motion.spin_rad_s
        attitudes = [wing.mount @ rotation(quaternion) for quaternion in values[9 * count :].reshape(count, 4)]
        own = sum(a @ (inertia * (a.T @ turning)) for a, inertia, turning in zip(attitudes, self.section_kg_m2, spin))
        to_inertial = rotation(motion.attitude).T
        return motion.position_m + place @ to_inertial, motion.velocity_m_s + velocity @ to_inertial, own @ to_inertial

    def of_aircraft(self, aircraft):
        """Centre of mass (m), momentum (N·s) and angular momentum about the centre of mass (N·m·s), inertial axes."""
        motion, fuselage = aircraft.motion, aircraft.fuselage
        masses = [np.array([fuselage.mass_kg])]
        places, velocities = [motion.position_m[None]], [motion.velocity_m_s[None]]
        angular = rotation(motion.attitude) @ fuselage.inertia_kg_m2 @ motion.spin_rad_s
        for wing in aircraft.wings:
            place, velocity, own = self.of_wing(wing, motion)
            masses, places, velocities = [*masses, self.mass_kg], [*places, place], [*velocities, velocity]
            angular = angular + own
        mass, place = np.concatenate(masses), np.vstack(places)
        momentum = mass[:, None] * np.vstack(velocities)
        centre_m = mass @ place / mass.sum()
        return centre_m, momentum.sum(axis=0), angular + np.cross(place - centre_m, momentum).sum(axis=0)


def momentum(fmu, coupling, stop_s):
    """Free fall without gust: momentum minus the impulse of the weight (N·s), angular momentum about the centre of mass (N·m·s).

    One row of six values per communication point."""
    seen = []
    with opened(fmu, coupling, gust=False) as aircraft:
        balance = Balance(aircraft.wings[0])
        mass_kg = balance.mass_kg.sum() * len(aircraft.wings) + aircraft.fuselage.mass_kg

        def watch(aircraft):
            _, linear, angular = balance.of_aircraft(aircraft)
            seen.append(np.concatenate([linear - mass_kg * aircraft.time_s * GRAVITY_M_S2, angular]))

        fly(aircraft, stop_s, watch)
    return np.array(seen)


def largest(rows):
    """Largest norm of the first three and of the last three columns of rows."""
    return np.array([np.linalg.norm(rows[:, :3], axis=1).max(), np.linalg.norm(rows[:, 3:], axis=1).max()])


def effort(fmu, coupling, fuselage, steps=40):
    """Mean number of FMU steps per communication step at the start; None if the iteration fails."""
    with opened(fmu, coupling, fuselage) as aircraft:
        try:
            aircraft.step(coupling.step_s)
            before = aircraft.steps_taken
            for _ in range(steps):
                aircraft.step(coupling.step_s)
        except (RuntimeError, FMICallException, ValueError):
            return None
        return (aircraft.steps_taken - before) / steps


def moved_g(fmu, step_s):
    """Apparent mass in g of both wings against accelerations along x, y and z near the start: at an instant, from the directional
    derivatives, and over a step, from differences between its repetitions."""
    with opened(fmu, Coupling(step_s)) as aircraft:
        aircraft.step(step_s)
        instant = sum(wing.apparent_mass() for wing in aircraft.wings).diagonal()[:3]
        over_step = []
        with saved(aircraft.wings) as restore:
            for axis, unit in enumerate(np.eye(6)[:3]):
                sides = []
                for accelerations in (aircraft.motion.accelerations + unit, aircraft.motion.accelerations - unit):
                    end = aircraft.fuselage.advanced(aircraft.motion, accelerations, step_s)
                    sides.append(aircraft.try_step(end, step_s)[0][axis])
                    restore()
                over_step.append(0.5 * (sides[0] - sides[1]) - aircraft.fuselage.mass_kg)
    return 1e3 * instant, 1e3 * np.array(over_step)


def table_of_moved_mass(fmu):
    """The apparent mass at an instant and over steps."""
    text = row("over", "along x, g", "along y, g", "along z, g") + "|---" * 4 + "|\n"
    found = {step_s: moved_g(fmu, step_s) for step_s in EFFORT_STEPS_S}
    text += row("an instant, by directional derivatives", *(f"{mass_g:.1f}" for mass_g in found[EFFORT_STEPS_S[-1]][0]))
    for step_s, (_, over_step) in reversed(found.items()):
        text += row(f"{1e3 * step_s:g} ms", *(f"{mass_g:.1f}" for mass_g in over_step))
    return text


def agreement(fmu, whole, solver):
    """Per communication step: distances at PLACES_S from the aircraft as one model, and the deviation of the centre of mass from its
    path."""
    found = []
    for step_s in STEPS_S:
        with opened(fmu, Coupling(step_s, solver)) as aircraft:
            result = fly(aircraft, STOP_S)
            off_m = off_path_m(result, aircraft.fuselage)
        found.append(np.concatenate([*(distance(result, whole, time_s) for time_s in PLACES_S), [off_m]]))
        print(f"{solver}, {1e3 * step_s:g} ms: {' '.join(f'{value:.1e}' for value in found[-1])}", flush=True)
    return np.array(found)


def shape_m(aircraft):
    """Points along both wings from tip to tip, from the fuselage's centre of mass in inertial axes."""
    halves = []
    for wing in aircraft.wings:
        inner, outer = (
            np.array([wing.slave.getReal(wing.vector(f"station.{body}[{i}].position")) for i in (1, 2, 3, 4)])
            for body in ("inner", "outer")
        )
        hinge = inner[3] + 0.5 * (inner[3] - inner[2])  # half a strip beyond the last station
        tip = wing.slave.getReal(wing.vector("tip.position"))
        halves.append(wing.root_m + np.vstack([np.zeros(3), inner, hinge, outer, tip]) @ wing.mount.T)
    right, left = halves
    return np.vstack([left[::-1], right[1:]]) @ rotation(aircraft.motion.attitude).T


def flight(fmu):
    """The default flight, and its shapes over time."""
    shapes = {}

    def watch(aircraft):
        wanted = [time_s for time_s in SHAPES_S if abs(time_s - aircraft.time_s) < 1e-9]
        shapes.update({time_s: shape_m(aircraft) for time_s in wanted})

    with opened(fmu) as aircraft:
        return fly(aircraft, STOP_S, watch), shapes


def row(*cells):
    """A row of a table."""
    return "| " + " | ".join(str(cell) for cell in cells) + " |\n"


def rows_by_step(found, steps_s):
    """Rows of errors by solver and step; in brackets the order of convergence from the step before, which is twice as long."""
    text = ""
    for solver, errors in found.items():
        text += row(solver, f"{1e3 * steps_s[0]:g}", *(f"{error:.1e}" for error in errors[0]))
        for step_s, before, after in zip(steps_s[1:], errors, errors[1:]):
            cells = (f"{error:.1e} ({order:.1f})" for error, order in zip(after, np.log2(before / after)))
            text += row(solver, f"{1e3 * step_s:g}", *cells)
    return text


def table_of_agreement(errors):
    """Distances by step, with orders."""
    text = (
        row(
            "coupling",
            "step, ms",
            *(
                f"{what} at {1e3 * time_s:.0f} ms"
                for time_s in PLACES_S
                for what in ("place, m", "attitude, rad", "fold angle, rad")
            ),
            "centre of mass off its path, m",
        )
        + "|---" * 9
        + "|\n"
    )
    return text + rows_by_step(errors, STEPS_S)


def range_of_orders(errors):
    """Smallest and largest of the mean orders from the second to the last step, over all measured quantities."""
    halvings = np.log2(STEPS_S[1] / STEPS_S[-1])
    orders = np.log2(errors[1] / errors[-1]) / halvings
    return f"{orders.min():.1f} to {orders.max():.1f}"


def table_of_momentum(by_step, by_tolerance):
    """Change of momentum by step, and the part of it that is due to the tolerance."""
    text = row("coupling", "step, ms", "momentum, N·s", "angular momentum, N·m·s") + "|---" * 4 + "|\n"
    text += rows_by_step(by_step, FALL_STEPS_S) + "\n"
    text += row("tolerance", "momentum, N·s", "angular momentum, N·m·s") + "|---" * 3 + "|\n"
    for tolerance, (linear, angular) in by_tolerance.items():
        text += row(f"{tolerance:.0e}", f"{linear:.1e}", f"{angular:.1e}")
    return text


def table_of_effort(fmu):
    """FMU steps per communication step by solver, step and mass of the fuselage."""
    solvers = [solver for solver in SOLVERS if solver != "held"]
    text = row("fuselage, kg", "step, ms", *solvers) + "|---" * (2 + len(solvers)) + "|\n"
    for share in FUSELAGES:
        fuselage = Fuselage(share * Fuselage().mass_kg, share * Fuselage().inertia_kg_m2)
        for step_s in EFFORT_STEPS_S:
            found = [effort(fmu, Coupling(step_s, solver), fuselage) for solver in solvers]
            cells = ("fails" if number is None else f"{number:.1f}" for number in found)
            text += row(f"{fuselage.mass_kg:g}", f"{1e3 * step_s:g}", *cells)
            print(text.splitlines()[-1], flush=True)
    return text


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--foldwing", required=True, help="the command `foldwing`")
    parser.add_argument("--fmu", required=True, help="FMU of examples/models/folding_wing.toml")
    parser.add_argument("--table", type=Path, required=True, help="file for the tables")
    parser.add_argument("--pictures", type=Path, required=True, help="folder for the pictures")
    arguments = parser.parse_args()

    with tempfile.TemporaryDirectory() as folder:
        model = Path(folder) / "weighed.toml"
        model.write_text(weighed_model())
        weighed = packaged(arguments.foldwing, model, model.with_suffix(".fmu"))
        whole = fly_whole(packaged(arguments.foldwing, WHOLE, Path(folder) / "whole.fmu"), STOP_S)
        errors = {solver: agreement(arguments.fmu, whole, solver) for solver in COMPARED}
        by_step = {}
        for solver in COMPARED:
            runs = [momentum(weighed, Coupling(step_s, solver), FALL_S) for step_s in FALL_STEPS_S]
            by_step[solver] = np.array([largest(run - run[0]) for run in runs])
        exact = momentum(weighed, Coupling(tolerance=1e-11), FALL_S)
        by_tolerance = {
            tolerance: largest(momentum(weighed, Coupling(tolerance=tolerance), FALL_S) - exact)
            for tolerance in TOLERANCES
        }
        print(table_of_momentum(by_step, by_tolerance), flush=True)
    draw_flight(*flight(arguments.fmu), GUST_S, arguments.pictures / "flying_aircraft.png")
    draw_convergence(STEPS_S, errors, by_tolerance, arguments.pictures / "aircraft_convergence.png")
    arguments.table.write_text(
        PAGE.format(
            date=datetime.date.today(),
            agreement=table_of_agreement(errors),
            orders=range_of_orders(errors[COMPARED[-1]]),
            momentum=table_of_momentum(by_step, by_tolerance),
            effort=table_of_effort(arguments.fmu),
            moved=table_of_moved_mass(arguments.fmu),
            wings_g=2e3 * WING_KG,
            fall_ms=round(1e3 * FALL_S),
            step_ms=1e3 * Coupling().step_s,
        )
    )


if __name__ == "__main__":
    main()
