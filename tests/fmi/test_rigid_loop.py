"""A machine with rigid loops as an FMU of both versions: the motion of the command, rollback, continuation elsewhere, refusals."""

import subprocess

import numpy as np
import pytest
from conftest import ROOT
from constraints import columns_of_the_command, derivatives_are_slopes, states_are_whole, states_of_fmi_3_are_whole

STEP_S, STOP_S = 2e-3, 0.3
NAMES = ["motor.angle", "elbow.angle", "pivot.angular_velocity", "loop.front.force.x", "loop.front.gap.x", "loop.back.force.z", "loop.back.gap.z",
         "energy.kinetic", "energy.elastic", "energy.total", "energy.dissipated"]


def rigid(text):
    """The model with rigid loops in place of penalties."""
    return text.replace("stiffness_N_m = 5e5\ndamping_N_s_m = 50.0", "rigid = true")


@pytest.fixture(scope="module")
def model(tmp_path_factory):
    """The four-bar linkage of the examples, its pin made of two rigid loops whose axial rows are redundant."""
    path = tmp_path_factory.mktemp("rigid") / "rigid.toml"
    path.write_text(rigid((ROOT / "examples/models/four_bar.toml").read_text()))
    assert path.read_text().count("rigid = true") == 2
    return path


@pytest.fixture(scope="module")
def packaged(foldwing, model):
    """Its FMUs by the version of FMI."""
    fmus = {}
    for version in ("2", "3"):
        fmus[version] = model.with_name(f"Rigid{version}.fmu")
        subprocess.run([foldwing, "package", model, "-o", fmus[version], "--fmi", version], check=True)
    return fmus


@pytest.mark.parametrize("version", ["2", "3"])
def test_lp32_the_fmu_moves_as_the_command(foldwing, model, packaged, tmp_path, version):
    """LP-32. FMPy finds no problem in the FMU; over 0.3 s in co-simulation, angles, forces of the loops and energies are bit-identical to
    those of `foldwing simulate`; gaps are round-off."""
    columns = columns_of_the_command(foldwing, model, packaged[version], tmp_path, NAMES, STEP_S, STOP_S)
    for name, column in columns.items():
        if ".gap" in name:
            assert np.abs(column).max() < 1e-14, name
        else:
            assert np.ptp(column) > 0, f"{name} does not change"


def test_lp33_states_of_the_fmu_are_whole(packaged, tmp_path):
    """LP-33. FMI 2.0: a state saved in the middle of the motion, where the integrator is ahead of the communication point, continues bit by
    bit, in the same instance and, as bytes, in another one, which has not moved."""
    states_are_whole(packaged["2"], tmp_path, STEP_S)


def test_lp33_states_of_fmi_3_are_whole(packaged, tmp_path):
    """LP-33. FMI 3.0: the same for angles, forces of both loops and energies."""
    states_of_fmi_3_are_whole(packaged["3"], tmp_path, NAMES, STEP_S)


@pytest.mark.parametrize("version", ["2", "3"])
@pytest.mark.parametrize("kinds", ["me", "cs,me"])
def test_lp34_model_exchange_is_refused_by_name(foldwing, model, tmp_path, version, kinds):
    """LP-34. An FMU for Model Exchange is refused; the message states the cause and the cure, and no file is written."""
    fmu = tmp_path / "Rigid.fmu"
    said = subprocess.run([foldwing, "package", model, "-o", fmu, "--fmi", version, "--interface", kinds], capture_output=True, text=True)
    assert said.returncode != 0 and not fmu.exists()
    assert "rigid" in said.stderr and "stiffness_N_m" in said.stderr, said.stderr


def test_lp35_directional_derivatives_know_the_loops(packaged, tmp_path):
    """LP-35. FMI 2.0 in the middle of the motion: directional derivatives of the forces of both loops, the reaction of the crank and an
    acceleration with respect to loads and accelerations of the root equal central differences of the outputs."""
    outputs = [*(f"loop.{pin}.force.{axis}" for pin in ("front", "back") for axis in "xyz"), "motor.reaction_force.x",
               "tip.rocker.angular_acceleration.y"]
    inputs = ["load.coupler[1].force.z", "load.coupler[1].moment.y", "motor.external_torque", "root.acceleration.x"]
    derivatives_are_slopes(packaged["2"], tmp_path, outputs, inputs, 1e-3, 6, STEP_S)
