"""A machine with a wheel and a skate as an FMU of both versions: the motion of the command, rollback, refusals."""

import csv
import subprocess

import fmpy
import fmpy.validation
import numpy as np
import pytest
from conftest import ROOT
from driving import Fmu, Instance
from fmpy.fmi3 import FMU3Slave

STEP_S, STOP_S = 2e-3, 0.3
NAMES = ["swivel.angle", "axle.angular_velocity", "wheel.tyre.side_force", "wheel.tyre.rolling_force", "wheel.tyre.normal_force",
         "wheel.tyre.slip", "wheel.tyre.height", "skate.rail.side_force", "energy.kinetic", "energy.total"]


@pytest.fixture(scope="module")
def model(tmp_path_factory):
    """The castoring wheel of the examples with a skate at the middle of its leg."""
    path = tmp_path_factory.mktemp("gear") / "gear.toml"
    text = (ROOT / "examples/gear/castor.toml").read_text()
    skate = '[skate.rail]\nbody = "leg"\nposition_m = 0.3\nhold_normal = false\ndirection = [0.0, 0.0, -1.0]\n\n'
    path.write_text(text.replace("[simulation]", skate + "[simulation]"))
    return path


@pytest.fixture(scope="module")
def packaged(foldwing, model):
    """Its FMUs by the version of FMI."""
    fmus = {}
    for version in ("2", "3"):
        fmus[version] = model.with_name(f"Gear{version}.fmu")
        subprocess.run([foldwing, "package", model, "-o", fmus[version], "--fmi", version], check=True)
    return fmus


@pytest.mark.parametrize("version", ["2", "3"])
def test_wh11_the_fmu_moves_as_the_command(foldwing, model, packaged, tmp_path, version):
    """WH-11. FMPy finds no problem in the FMU; over 0.3 s in co-simulation, angles, forces of wheel and skate and energies are
    bit-identical to those of `foldwing simulate`; slip and height are round-off."""
    out = tmp_path / "out.csv"
    named = [word for name in NAMES for word in ("--variables", name)]
    subprocess.run([foldwing, "simulate", model, "--csv", out, "-q", "--stop", str(STOP_S), "--step", str(STEP_S), *named], check=True)
    with open(out) as file:
        rows = list(csv.DictReader(file))
    assert fmpy.validation.validate_fmu(str(packaged[version])) == []
    found = fmpy.simulate_fmu(str(packaged[version]), fmi_type="CoSimulation", stop_time=STOP_S, output_interval=STEP_S, output=NAMES)
    assert len(rows) == len(found) == round(STOP_S / STEP_S) + 1
    for name in NAMES:
        expected = np.array([float(row[name]) for row in rows])
        assert np.array_equal(found[name], expected), name
        if name.endswith((".slip", ".height")):
            assert np.abs(expected).max() < 1e-12, name
        else:
            assert np.ptp(expected) > 0, f"{name} does not change"


def test_wh12_states_of_the_fmu_are_whole(packaged, tmp_path):
    """WH-12. FMI 2.0: a state saved in the middle of the motion continues bit by bit, in the same instance and, as bytes, in another one."""
    fmu = Fmu(packaged["2"], tmp_path)
    first, second = Instance(fmu).initialize(), Instance(fmu).initialize()
    first.advance(37, STEP_S)
    slave = first.slave
    state, time_s, there = slave.getFMUstate(), first.time_s, first.bits()
    onward = first.history(60, STEP_S)
    assert onward[-1] != there
    slave.setFMUstate(state)
    first.time_s = time_s
    assert first.bits() == there
    assert first.history(60, STEP_S) == onward
    copy = second.slave.deSerializeFMUstate(slave.serializeFMUstate(state))
    second.slave.setFMUstate(copy)
    second.time_s = time_s
    assert second.history(60, STEP_S) == onward


def test_wh12_states_of_fmi_3_are_whole(packaged, tmp_path):
    """WH-12. FMI 3.0: the same for angles, forces of wheel and skate and energies."""
    folder = fmpy.extract(str(packaged["3"]), str(tmp_path))
    description = fmpy.read_model_description(str(packaged["3"]))
    chosen = [v.valueReference for v in description.modelVariables if v.name in NAMES]
    assert len(chosen) == len(NAMES)

    def started():
        slave = FMU3Slave(guid=description.guid, unzipDirectory=folder,
                          modelIdentifier=description.coSimulation.modelIdentifier, instanceName="gear")
        slave.instantiate()
        slave.enterInitializationMode()
        slave.exitInitializationMode()
        return slave

    def history(slave, first, last):
        rows = []
        for step in range(first, last):
            slave.doStep(step * STEP_S, STEP_S)
            rows.append(list(slave.getFloat64(chosen)))
        return rows

    one, other = started(), started()
    history(one, 0, 37)
    state = one.getFMUState()
    onward = history(one, 37, 97)
    assert len({tuple(row) for row in onward}) == len(onward)
    one.setFMUState(state)
    assert history(one, 37, 97) == onward
    other.setFMUState(other.deserializeFMUState(one.serializeFMUState(state)))
    assert history(other, 37, 97) == onward
    for slave in (one, other):
        slave.terminate()
        slave.freeInstance()


@pytest.mark.parametrize("version", ["2", "3"])
@pytest.mark.parametrize("kinds", ["me", "cs,me"])
def test_wh13_model_exchange_is_refused_by_name(foldwing, model, tmp_path, version, kinds):
    """WH-13. An FMU for Model Exchange is refused; the message states the cause and the cure, and no file is written."""
    fmu = tmp_path / "Gear.fmu"
    said = subprocess.run([foldwing, "package", model, "-o", fmu, "--fmi", version, "--interface", kinds], capture_output=True, text=True)
    assert said.returncode != 0 and not fmu.exists()
    assert "a skate or a wheel" in said.stderr and "co-simulation" in said.stderr, said.stderr


def test_wh14_directional_derivatives_know_the_wheel(packaged, tmp_path):
    """WH-14. FMI 2.0 in the middle of the motion: directional derivatives of the forces of the wheel, the root's force and an acceleration
    with respect to a torque and accelerations of the root equal central differences of the outputs."""
    fmu = Fmu(packaged["2"], tmp_path)
    one = Instance(fmu).initialize()
    one.advance(20, STEP_S)
    outputs = ["wheel.tyre.side_force", "wheel.tyre.rolling_force", "wheel.tyre.normal_force", "skate.rail.side_force", "root.force.y",
               "tip.angular_acceleration.y"]
    for name in ("swivel.external_torque", "root.acceleration.x", "root.acceleration.z"):
        references = [[fmu.variables[v].valueReference for v in names] for names in (outputs, [name])]
        found = np.array(one.slave.getDirectionalDerivative(*references, [1.0]))
        sides = []
        for change in (1e-2, -1e-2):
            one.set(name, change)
            sides.append(np.array([one.get(output) for output in outputs]))
        one.set(name, 0.0)
        expected = (sides[0] - sides[1]) / 2e-2
        # the outputs are linear in loads: what remains is their round-off over the difference
        assert np.abs(found - expected).max() < 1e-8 * np.abs(expected).max(), name
        assert np.abs(found[:4]).max() > 1e-6, f"{name} does not reach the wheel"
