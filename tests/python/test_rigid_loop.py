"""Rigid loops from Python: models from text and from code, the bits of the command, rollback, and what is refused by name."""

import csv
import subprocess
from pathlib import Path

import numpy as np
import pytest

import foldwing as fw

FOUR_BAR = "examples/models/four_bar.toml"
TIED = """
name = "Tied"
gravity_m_s2 = [0.0, 0.0, -9.8]

[section.plate]
shape = "rectangle"
width_m = 0.1
height_m = 0.01
density_kg_m3 = 2000.0
youngs_modulus_Pa = 1e10
poisson_ratio = 0.3

[body.wing]
length_m = 1.0
section = "plate"
elements = 2

[joint.hinge]
type = "revolute"
parent = "root"
child = "wing"
axis = [0.0, -1.0, 0.0]

[loop.tie]
bodies = ["wing", "root"]
offsets_m = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]
rigid = true

[aerodynamics]
model = "strip"
wind_m_s = [0.0, -10.0, 1.0]

[surface.wing]
body = "wing"
chord_m = 0.1
strips = 2

[simulation]
stop_time_s = 0.1
step_s = 2e-3
"""
# their sums have no round-off
STEP_S, STOP_S = 2**-9, 50 * 2**-9
COLUMNS = ["motor.angle", "loop.front.force.x", "loop.back.force.x", "loop.front.gap.y", "energy.total"]


def rigid(path):
    """Text of a model file with rigid loops in place of penalties."""
    lines, table = [], ""
    for line in Path(path).read_text().splitlines():
        table = line if line.startswith("[") else table
        if table.startswith("[loop.") and line.startswith(("stiffness_N_m", "damping_N_s_m")):
            line = "rigid = true" if line.startswith("stiffness") else ""
        lines.append(line)
    return "\n".join(lines)


def bars(**pin):
    """A triangle of two rigid bars in the plane x-z, hinged to the root 1 m apart and pinned to each other at (0.5, 0, -0.5)."""
    arm = 0.5 * 2**0.5
    machine = fw.Builder("Triangle", gravity_m_s2=[0.0, 0.0, -9.8])
    for name, place, angle in [("left", 0.0, 45.0), ("right", 1.0, 135.0)]:
        machine.table("rigid_body", name, mass_kg=2.0, centre_of_mass_m=[0.5 * arm, 0.0, 0.0], inertia_kg_m2=[1e-3, 0.1, 0.1, 0.0, 0.0, 0.0])
        machine.revolute(f"{name}_hinge", name, axis=[0.0, 1.0, 0.0], root_position_m=[place, 0.0, 0.0], start_angle_deg=angle)
    return machine.table("loop", "pin", bodies=["left", "right"], offsets_m=[[arm, 0.0, 0.0]] * 2, **pin).build()


def test_lp36_a_run_has_the_bits_of_the_command(command, tmp_path):
    """LP-36. `simulate`, and a loop over steps with a step that is taken back, give the bits of `foldwing simulate`; no gap."""
    path, out = tmp_path / "rigid.toml", tmp_path / "out.csv"
    path.write_text(rigid(FOUR_BAR))
    named = [word for name in COLUMNS for word in ("--variables", name)]
    subprocess.run([command, "simulate", path, "--csv", out, "-q", "--stop", str(STOP_S), "--step", str(STEP_S), *named], check=True)
    with open(out) as file:
        rows = list(csv.DictReader(file))
    expected = {name: np.array([float(row[name]) for row in rows]) for name in COLUMNS}
    assert np.ptp(expected["loop.front.force.x"]) > 1.0
    assert np.abs(expected["loop.front.gap.y"]).max() < 1e-14
    model = fw.load(path)
    run = model.simulate(stop=STOP_S, step=STEP_S, outputs=COLUMNS)
    for name in COLUMNS:
        assert np.array_equal(run[name], expected[name]), name
    sim = model.start()
    for row in range(1, len(rows)):
        saved = sim.save()
        sim.step(STEP_S)
        if row % 10 == 0:
            sim.restore(saved)
            sim.step(STEP_S)
        for name in COLUMNS:
            assert sim[name] == expected[name][row], (row, name)


def test_lp37_a_triangle_from_code_carries_its_weight():
    """LP-37. Two bars pinned to each other cannot move: the pin carries half the weight of a bar across, W/2 along x, in a run and in
    statics, and nothing along z."""
    model = bars(rigid=True)
    weight_n = 2.0 * 9.8
    run = model.simulate(stop=0.2, step=0.01, outputs=["loop.pin.force.x", "loop.pin.force.z", "left_hinge.angle"])
    assert np.abs(run["left_hinge.angle"] - np.pi / 4).max() < 1e-13
    assert np.abs(np.abs(run["loop.pin.force.x"]) - 0.5 * weight_n).max() < 1e-11 * weight_n
    assert np.abs(run["loop.pin.force.z"]).max() < 1e-11 * weight_n
    sim = model.start()
    assert abs(abs(sim["loop.pin.force.x"]) - 0.5 * weight_n) < 1e-11 * weight_n


def test_lp38_what_rigid_loops_refuse_is_named(tmp_path):
    """LP-38. Linear models of moving states, periodic motions, FMUs with such a linear model or for Model Exchange and a penalty
    beside `rigid` are refused with the name of the loop or the cure."""
    model = fw.Model(rigid(FOUR_BAR))
    tied = fw.Model(TIED)
    refusals = [
        (lambda: model.linearize("start"), fw.FoldwingError, 'rigid loops are linearised at rest only.*"front" stiffness_N_m'),
        (lambda: model.periodic(60.0, shaft="motor"), fw.FoldwingError, 'no periodic motion.*the loop "front" is rigid.*stiffness_N_m'),
        (lambda: model.package(tmp_path / "a.fmu", interface="me"), fw.FoldwingError, "rigid.*stiffness_N_m"),
        (lambda: model.package(tmp_path / "b.fmu", linear="start"), fw.FoldwingError, "rigid.*stiffness_N_m"),
        (lambda: bars(rigid=True, stiffness_N_m=1e5), fw.ModelError, "no penalty in a loop with rigid = true"),
    ]
    for refused, kind, words in refusals:
        with pytest.raises(kind, match="(?s)" + words):
            refused()
    assert not list(tmp_path.iterdir())
    run = tied.simulate(stop=0.02, outputs=["loop.tie.force.z", "loop.tie.gap.z"])
    assert np.abs(run["loop.tie.gap.z"]).max() < 1e-14 and np.abs(run["loop.tie.force.z"]).max() > 1.0


def test_lp49_gradients_of_a_four_bar_linkage_with_rigid_loops():
    """LP-49. Angle of the crank and mean force of the pin by the damping of the motor and the width of the bars, forward and
    adjoint, against differences of runs with fixed steps, over 1e-3 of the numbers: to 1e-5, as these runs close their loops in directions
    of their own. The force at an instant depends on these directions: its differences are 10 % off."""
    text = rigid(FOUR_BAR).replace("[simulation]", "[solver]\ntolerance = 1e-12\nfixed_step_s = 0.001\n\n[simulation]")
    assert "fixed_step_s" in text and text.count("[solver]") == 1
    of, by = ["motor.angle", "mean(loop.front.force.x)"], ["motor.motor_damping", "file:section.bar.width_m"]
    forward = fw.Model(text).gradient(of, by, stop=STOP_S, mode="forward")
    adjoint = fw.Model(text).gradient(of, by, stop=STOP_S, mode="adjoint")
    assert np.allclose(forward.jacobian, adjoint.jacobian, rtol=1e-7, atol=0.0)
    for column, (key, value) in enumerate([("damping_N_m_s_rad = 0.1", 0.1), ("width_m = 0.02", 0.02)]):
        ends = []
        for sign in (1.0, -1.0):
            changed = text.replace(key, f"{key.split(' = ')[0]} = {value * (1.0 + 1e-3 * sign)!r}")
            assert changed != text
            ends.append(np.array(fw.Model(changed).gradient(of, by, stop=STOP_S, mode="forward").values))
        known = (ends[0] - ends[1]) / (2e-3 * value)
        assert np.allclose(forward.jacobian[:, column], known, rtol=1e-5, atol=0.0), (key, forward.jacobian[:, column], known)
