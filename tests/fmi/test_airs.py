"""Machines with several aerodynamic models as FMUs of both versions: the motion of the command, rollback, Model Exchange without rotors."""

import subprocess

import fmpy
import numpy as np
import pytest
from conftest import ROOT
from constraints import columns_of_the_command, states_are_whole, states_of_fmi_3_are_whole

CASES = {
    "twin_rotor": (0.02, 0.6, ["rotor.port.thrust", "rotor.port.power", "rotor.starboard.thrust", "rotor.starboard.speed", "port_shaft.angle",
                               "energy.dissipated", "energy.kinetic", "energy.work"]),
    "wing_with_propellers": (0.002, 0.06, ["rotor.right.thrust", "rotor.right.torque", "rotor.left.thrust", "rotor.left.speed",
                                           "right_shaft.angular_velocity", "energy.dissipated", "energy.elastic", "energy.work"]),
    "wing_with_fuselage": (0.005, 0.3, ["aero.force.x", "aero.moment.y", "aero.load.fuselage[1].force.z", "aero.load.fuselage[3].moment.z", "energy.elastic",
                                        "energy.kinetic", "energy.work"]),
}


@pytest.fixture(scope="module", params=[(name, version) for name in CASES for version in ("2", "3")], ids=lambda case: "-".join(case))
def packaged(request, foldwing, tmp_path_factory):
    """Name of the case, version of FMI, its model and its FMU."""
    name, version = request.param
    model = ROOT / f"examples/airs/{name}.toml"
    fmu = tmp_path_factory.mktemp("airs") / f"{name}{version}.fmu"
    subprocess.run([foldwing, "package", model, "-o", fmu, "--fmi", version], check=True)
    return name, version, model, fmu


def test_rt30_the_fmu_moves_as_the_command(foldwing, packaged, tmp_path):
    """RT-30, SB-16. FMPy finds no problem in the FMU; loads of all rotors, shafts and energies are bit-identical to those of `foldwing simulate`."""
    name, _, model, fmu = packaged
    step_s, stop_s, names = CASES[name]
    columns = columns_of_the_command(foldwing, model, fmu, tmp_path, names, step_s, stop_s)
    for name, column in columns.items():
        assert np.ptp(column) > 0, f"{name} does not change"


def test_rt30_states_are_whole(packaged, tmp_path):
    """RT-30, SB-16. A saved state continues bit by bit, in the same instance and, as bytes, in another one, also within an aerodynamic step."""
    name, version, _, fmu = packaged
    step_s, _, names = CASES[name]
    if version == "2":
        states_are_whole(fmu, tmp_path, 0.37 * step_s)
    else:
        states_of_fmi_3_are_whole(fmu, tmp_path, names, 0.37 * step_s)


@pytest.mark.parametrize("name", CASES)
def test_rt30_model_exchange_with_rotors_is_refused(foldwing, tmp_path, name):
    """RT-30, SB-16. Model Exchange with rotors is refused with the reason; `check` says that no model reaches another, and names the parts."""
    model = ROOT / f"examples/airs/{name}.toml"
    if name != "wing_with_fuselage":
        run = subprocess.run([foldwing, "package", model, "-o", tmp_path / "no.fmu", "--interface", "me"], capture_output=True, text=True)
        assert run.returncode != 0 and "fixed aerodynamic steps" in run.stderr, run.stderr
    told = subprocess.run([foldwing, "check", model], check=True, capture_output=True, text=True).stdout
    expected = {"twin_rotor": "the wake of a rotor does not reach the others", "wing_with_propellers": "slipstream of a rotor does not reach the wing",
                "wing_with_fuselage": "wing and slender body do not act on each other"}
    assert expected[name] in told and "bem" not in told, told


@pytest.mark.parametrize("version", ["2", "3"])
def test_sb23_model_exchange_agrees_with_co_simulation(foldwing, tmp_path, version):
    """SB-23. Strips with a slender body in Model Exchange: CVode at 1e-7 and co-simulation with short steps of the air have the same motion; the
    bound is what is left of the steps of the air."""
    text = (ROOT / "examples/airs/wing_with_fuselage.toml").read_text()
    model = tmp_path / "glider.toml"
    model.write_text(text.replace("step_s = 0.0025", "step_s = 0.0005"))
    fmu = tmp_path / f"glider{version}.fmu"
    subprocess.run([foldwing, "package", model, "-o", fmu, "--fmi", version, "--interface", "cs,me"], check=True)
    # forces are arrays in FMI 3.0
    names = ["energy.elastic", "energy.kinetic"] + (["aero.force.z", "aero.moment.y"] if version == "2" else [])
    settings = {"stop_time": 0.05, "output_interval": 0.005, "output": names}
    own = fmpy.simulate_fmu(str(fmu), fmi_type="CoSimulation", **settings)
    other = fmpy.simulate_fmu(str(fmu), fmi_type="ModelExchange", relative_tolerance=1e-7, **settings)
    for name in names:
        there = np.interp(own["time"][4:], other["time"], other[name])
        miss = np.abs(there - own[name][4:]).max() / np.abs(own[name][4:]).max()
        print(f"SB-23 {name}: {miss:.1e}")
        assert miss < (1e-4 if name.startswith("energy") else 5e-3), name
