"""Two FMUs on an aircraft in Python, examples/flying_aircraft.py: against a single model of the aircraft; momentum."""

import re
import subprocess
import sys

import numpy as np
import pytest
from conftest import ROOT

sys.path.insert(0, str(ROOT / "studies"))

import aircraft_study as study  # noqa: E402
import flying_aircraft  # noqa: E402
from flying_aircraft import ROOT_M, Aircraft, Coupling, Fuselage, Mount, fly, opened, rotation, turn  # noqa: E402

STOP_S = 0.09  # before the first latch closes
STEPS_S = (5e-4, 2.5e-4)


@pytest.fixture(scope="module")
def whole(foldwing, tmp_path_factory):
    """Motion of the aircraft as a single model."""
    archive = tmp_path_factory.mktemp("whole") / "whole.fmu"
    return study.fly_whole(study.packaged(foldwing, study.WHOLE, archive), STOP_S)


@pytest.fixture(scope="module")
def weighed(foldwing, tmp_path_factory):
    """FMU of the wing with stations from which its momentum is computed."""
    model = tmp_path_factory.mktemp("weighed") / "weighed.toml"
    model.write_text(study.weighed_model())
    return study.packaged(foldwing, model, model.with_suffix(".fmu"))


def test_f80_loads_are_linear_in_the_accelerations_at_the_start(wing):
    """F-80. One correction with the apparent mass solves the start: to round-off, 1e-10 of the load.

    The apparent mass, computed only from directional derivatives, is symmetric (to 1e-9 of its largest entry, with moments over an arm of
    0.15 m) and has no negative eigenvalue, as it must be for a passive wing.
    """
    with opened(wing.path) as aircraft:
        print(f"F-80 missing after one correction: {aircraft.start_share:.1e} of the load")
        assert aircraft.start_share < 1e-10
        aircraft.step(5e-4)
        for part in aircraft.wings:
            scale = np.array([1.0, 1.0, 1.0, 0.15, 0.15, 0.15])
            mass = part.apparent_mass() / np.outer(scale, scale)
            assert mass == pytest.approx(mass.T, abs=1e-9 * np.abs(mass).max())
            values = np.linalg.eigvalsh(mass)
            assert values.max() > 1e-3 and values.min() > -1e-9 * values.max()


def test_f81_agrees_with_the_aircraft_in_one_piece(wing, whole):
    """F-81. Position, attitude and fold angles at 90 ms, after gust and second release, converge to those of the single model.

    Repeated steps: second order, 1.7 at least between the two finest; held accelerations: first order. The bounds 5e-6 m, 1e-5 rad and 2e-5
    rad at steps of 0.25 ms are two to six times the observed errors, and less than a hundredth of a millimetre for 1.1 m flown.
    """
    orders = {}
    for solver in ("held", "quasi-newton"):
        off = []
        for step_s in STEPS_S:
            with opened(wing.path, Coupling(step_s, solver)) as aircraft:
                off.append(study.distance(fly(aircraft, STOP_S), whole, STOP_S))
            print(f"F-81 {solver}, {1e3 * step_s:g} ms: {off[-1][0]:.2e} m, {off[-1][1]:.2e} rad, {off[-1][2]:.2e} rad")
        orders[solver] = np.log2(off[-2] / off[-1])
        print(f"F-81 {solver}: orders {np.round(orders[solver], 2)}")
    assert (off[-1] < [5e-6, 1e-5, 2e-5]).all()
    assert (orders["quasi-newton"] > 1.7).all()
    assert (orders["held"] < 1.3).all()


@pytest.mark.long
def test_f292_roots_aside_and_turned(wing, foldwing, tmp_path):
    """F-292. Wings whose roots are offset from the fuselage's origin, the right one rotated: the lever arms in Python agree with the
    offsets in the model file. Bounds and order as in F-81; with the roots at the origin the runs differ by more than 1e-4 m.
    """
    offsets_m, turned_deg = {"right": [0.03, 0.01, 0.02], "left": [-0.02, 0.0, 0.01]}, [5.0, 3.0, -7.0]
    text = study.WHOLE.read_text()
    for side, offset_m in offsets_m.items():
        keys = f'parent_offset_m = {offset_m}\nchild = "{side}_inner"'
        keys += f"\nmount_rotation_deg = {turned_deg}" if side == "right" else ""
        text = text.replace(f'child = "{side}_inner"', keys, 1)
    model = tmp_path / "aside.toml"
    model.write_text(text)
    roots_m = {side: ROOT_M + offset_m for side, offset_m in offsets_m.items()}
    archive = study.packaged(foldwing, model, tmp_path / "aside.fmu")
    whole = study.fly_whole(archive, STOP_S, gust=False, root_m=roots_m["right"])
    mounts = {
        "right": Mount(roots_m["right"], rotation(turn(np.radians(turned_deg)))),
        "left": Mount(roots_m["left"], np.diag([-1.0, -1.0, 1.0])),
    }
    off = []
    for step_s in STEPS_S:
        with opened(wing.path, Coupling(step_s), gust=False, mounts=mounts) as aircraft:
            off.append(study.distance(fly(aircraft, STOP_S), whole, STOP_S))
        print(f"F-292 {1e3 * step_s:g} ms: {off[-1][0]:.2e} m, {off[-1][1]:.2e} rad, {off[-1][2]:.2e} rad")
    assert (off[-1] < [5e-6, 1e-5, 2e-5]).all()
    assert (np.log2(off[-2] / off[-1]) > 1.7).all()
    with opened(wing.path, Coupling(5e-4), gust=False) as aircraft:
        assert study.distance(fly(aircraft, STOP_S), whole, STOP_S)[0] > 1e-4


@pytest.mark.long
def test_f82_momentum_is_conserved_to_step_and_tolerance(weighed):
    """F-82. In free fall the momentum minus that due to weight, and the angular momentum about the centre of mass, are constant.

    The error of the step falls with its square: to a third at most for half the step, with held accelerations only to a half. The error of
    the tolerance is proportional to it: a hundredth of the tolerance leaves a twentieth at most.
    """
    stop_s = 0.03

    def change(coupling):
        rows = study.momentum(weighed, coupling, stop_s)
        return rows, study.largest(rows - rows[0])

    by_step = {
        solver: [change(Coupling(step_s, solver))[1] for step_s in (5e-4, 2.5e-4)]
        for solver in ("held", "quasi-newton")
    }
    for solver, found in by_step.items():
        print(f"F-82 {solver}: {found} N.s and N.m.s, ratios {found[0] / found[1]}")
    assert (by_step["quasi-newton"][0] > 3.0 * by_step["quasi-newton"][1]).all()
    assert (by_step["held"][1] > 5.0 * by_step["quasi-newton"][1]).all()
    exact, _ = change(Coupling(tolerance=1e-11))
    lost = [study.largest(change(Coupling(tolerance=tolerance))[0] - exact) for tolerance in (1e-2, 1e-4, 1e-6)]
    print(f"F-82 lost to tolerances of 1e-2, 1e-4, 1e-6: {lost}")
    for coarse, fine in zip(lost, lost[1:]):
        assert (fine < 0.05 * coarse).all()


def test_f83_centre_of_mass_follows_its_path(wing, weighed):
    """F-83. The centre of mass, from the derivative of the wings' potential with respect to gravity, falls on a parabola, accelerated by
    the gust: to 3e-5 m, a few times the error of the coupling at this step.

    It equals the centre computed from 65 stations per wing, to 1e-8 m: between nodes positions are not exactly cubic.
    """
    with opened(wing.path) as aircraft:
        off_m = study.off_path_m(fly(aircraft, STOP_S), aircraft.fuselage)
    print(f"F-83 centre of mass off its path: {off_m:.1e} m")
    assert off_m < 3e-5
    with opened(weighed) as aircraft:
        fly(aircraft, 0.01)
        centre_m = study.Balance(aircraft.wings[0]).of_aircraft(aircraft)[0]
        apart_m = np.abs(centre_m - aircraft.centre_of_mass()).max()
    print(f"F-83 centre of mass by stations: {apart_m:.1e} m apart")
    assert apart_m < 1e-8


def test_f84_repetitions_leave_no_trace(wing, monkeypatch):
    """F-84. A flight without saved states, with the inputs found by the iteration, is bit-identical.

    Every step of the first flight was tried several times with other accelerations, across the release of a joint. If a restored state
    depended on these trials, the outputs of the second flight would differ.
    """
    references = [variable.valueReference for variable in wing.outputs if variable.type == "Real"]

    def outputs(aircraft):
        return [part.slave.getReal(references) for part in aircraft.wings]

    class Told(Aircraft):
        """A flight with the ends of steps from another flight."""

        def step_agreed(self, step_s):
            self.try_step(ends[self.steps_taken], step_s)
            self.motion, self.time_s = ends[self.steps_taken - 1], self.time_s + step_s

    class Telling(Aircraft):
        """A flight that records the ends of its steps."""

        def step_agreed(self, step_s):
            super().step_agreed(step_s)
            ends.append(self.motion)

    def flown(kind):
        """All outputs at the communication points, and the number of steps that each FMU took."""
        seen = []
        monkeypatch.setattr(flying_aircraft, "Aircraft", kind)
        with opened(wing.path) as aircraft:
            fly(aircraft, 0.06, lambda aircraft: seen.append(outputs(aircraft)))
            return seen, aircraft.steps_taken

    ends = []
    told_of, steps_with_repetitions = flown(Telling)
    told, steps = flown(Told)
    print(f"F-84 {steps_with_repetitions} steps, {steps} told")
    assert steps == len(ends) and steps_with_repetitions > 3 * steps
    assert told == told_of


def test_f85_a_light_fuselage_needs_the_step_s_own_mass(wing):
    """F-85. Steps of each FMU per communication step of 0.1 ms, to a tolerance of 1e-8.

    With a fuselage heavier than the wings every solver converges, quasi-Newton fastest; with one of 30 g, a quarter of the wings' mass,
    only quasi-Newton converges within 50.
    """
    heavy, light = (Fuselage(share * Fuselage().mass_kg, share * Fuselage().inertia_kg_m2) for share in (10.0, 0.1))
    found = {
        (fuselage.mass_kg, solver): study.effort(wing.path, Coupling(1e-4, solver), fuselage)
        for fuselage in (heavy, light)
        for solver in ("fixed-point", "newton", "quasi-newton")
    }
    print(f"F-85 {found}")
    assert found[heavy.mass_kg, "quasi-newton"] < found[heavy.mass_kg, "newton"] <= found[heavy.mass_kg, "fixed-point"]
    assert found[light.mass_kg, "fixed-point"] is None and found[light.mass_kg, "newton"] is None
    assert found[light.mass_kg, "quasi-newton"] < 10.0


def test_f86_script(wing, tmp_path):
    """F-86. The unchanged script, at steps of 1 ms: latch times as with fine steps, 98.7 and 148.4 ms, to the last digit.

    The effect of a step of a millisecond is smaller, and the table has a row per communication point.
    """
    table = tmp_path / "flight.csv"
    command = [
        sys.executable,
        str(ROOT / "examples/flying_aircraft.py"),
        "--fmu",
        wing.path,
        "--step",
        "1e-3",
        "--csv",
        str(table),
    ]
    run = subprocess.run(command, capture_output=True, text=True, check=True)
    latch_s = [float(time) for time in re.findall(r"latches at ([\d.]+) s", run.stdout)]
    assert latch_s == pytest.approx([0.0987, 0.1484], abs=1.01e-4)
    rows = np.genfromtxt(table, delimiter=",", names=True, deletechars="")
    assert len(rows) == 201 and rows["right.fold.angle"][-1] == pytest.approx(0.0, abs=1e-2)
