"""A machine with a wheel and a skate as an FMU of both versions: the motion of the command, rollback, refusals."""

import subprocess

import numpy as np
import pytest
from conftest import ROOT
from constraints import columns_of_the_command, derivatives_are_slopes, states_are_whole, states_of_fmi_3_are_whole

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
    columns = columns_of_the_command(foldwing, model, packaged[version], tmp_path, NAMES, STEP_S, STOP_S)
    for name, column in columns.items():
        if name.endswith((".slip", ".height")):
            assert np.abs(column).max() < 1e-12, name
        else:
            assert np.ptp(column) > 0, f"{name} does not change"


def test_wh12_states_of_the_fmu_are_whole(packaged, tmp_path):
    """WH-12. FMI 2.0: a state saved in the middle of the motion continues bit by bit, in the same instance and, as bytes, in another one."""
    states_are_whole(packaged["2"], tmp_path, STEP_S)


def test_wh12_states_of_fmi_3_are_whole(packaged, tmp_path):
    """WH-12. FMI 3.0: the same for angles, forces of wheel and skate and energies."""
    states_of_fmi_3_are_whole(packaged["3"], tmp_path, NAMES, STEP_S)


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
    outputs = ["wheel.tyre.side_force", "wheel.tyre.rolling_force", "wheel.tyre.normal_force", "skate.rail.side_force", "root.force.y",
               "tip.angular_acceleration.y"]
    inputs = ["swivel.external_torque", "root.acceleration.x", "root.acceleration.z"]
    derivatives_are_slopes(packaged["2"], tmp_path, outputs, inputs, 1e-2, 4, STEP_S)
