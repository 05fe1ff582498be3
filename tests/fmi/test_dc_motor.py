"""A machine with a DC motor as an FMU of both versions: the motion of the command, Model Exchange, rollback."""

import subprocess

import fmpy
import numpy as np
import pytest
from conftest import ROOT
from constraints import columns_of_the_command, states_are_whole, states_of_fmi_3_are_whole

STEP_S, STOP_S = 2e-3, 0.04
NAMES = ["fold.angle", "fold.angular_velocity", "fold.current", "fold.dc_motor_torque", "fold.total_torque", "fold.electrical_power",
         "energy.kinetic", "energy.total"]


@pytest.fixture(scope="module")
def model():
    """The fold with a geared motor of the examples."""
    return ROOT / "examples/motors/geared_fold.toml"


@pytest.fixture(scope="module")
def packaged(foldwing, model, tmp_path_factory):
    """Its FMUs, with both interfaces, by the version of FMI."""
    fmus = {}
    for version in ("2", "3"):
        fmus[version] = tmp_path_factory.mktemp("motor") / f"Motor{version}.fmu"
        subprocess.run([foldwing, "package", model, "-o", fmus[version], "--fmi", version, "--interface", "cs,me"], check=True)
    return fmus


@pytest.mark.parametrize("version", ["2", "3"])
def test_dc13_the_fmu_moves_as_the_command(foldwing, model, packaged, tmp_path, version):
    """DC-13. FMPy finds no problem in the FMU; over 0.04 s in co-simulation, angle, current, torques, power and energies are bit-identical to
    those of `foldwing simulate`."""
    columns = columns_of_the_command(foldwing, model, packaged[version], tmp_path, NAMES, STEP_S, STOP_S)
    for name, column in columns.items():
        assert np.ptp(column) > 0, f"{name} does not change"


def test_dc14_model_exchange_agrees_with_co_simulation(packaged):
    """DC-14. CVode at 1e-8 over the continuous states, among them the current and not its charge, and co-simulation at 1e-8: within 5e-6 of
    the largest values."""
    states = [variable.name for variable in fmpy.read_model_description(str(packaged["2"])).modelVariables]
    assert "state.fold.current" in states and not [name for name in states if "charge" in name or "coordinate[" in name]
    settings = {"stop_time": 0.03, "output_interval": STEP_S, "output": NAMES[:6]}
    own = fmpy.simulate_fmu(str(packaged["2"]), fmi_type="CoSimulation", start_values={"solver.tolerance": 1e-8}, **settings)
    other = fmpy.simulate_fmu(str(packaged["2"]), fmi_type="ModelExchange", relative_tolerance=1e-8, **settings)
    for name in NAMES[:6]:
        there = np.interp(own["time"], other["time"], other[name])
        miss = np.abs(there - own[name]).max() / np.abs(own[name]).max()
        print(f"DC-14 {name}: {miss:.1e}")
        assert miss < 5e-6, name


def test_dc15_states_of_the_fmu_are_whole(packaged, tmp_path):
    """DC-15. FMI 2.0: a state saved in the middle of the motion continues bit by bit, in the same instance and, as bytes, in another one."""
    states_are_whole(packaged["2"], tmp_path, STEP_S)


def test_dc15_states_of_fmi_3_are_whole(packaged, tmp_path):
    """DC-15. FMI 3.0: the same for angle, current, torques, power and energies."""
    states_of_fmi_3_are_whole(packaged["3"], tmp_path, NAMES, STEP_S)
