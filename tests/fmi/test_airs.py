"""Machines with several aerodynamic models as FMUs of both versions: the motion of the command, rollback, Model Exchange."""

import collections
import pathlib
import shutil
import subprocess
import tempfile

import fmpy
import numpy as np
import pytest
from conftest import ROOT
from constraints import columns_of_the_command, states_are_whole, states_of_fmi_3_are_whole
from fmpy.validation import validate_fmu

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
def test_rt30_check_names_the_parts(foldwing, name):
    """RT-30, SB-16. `check` says that no model reaches another, and names the parts."""
    model = ROOT / f"examples/airs/{name}.toml"
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


ROTORS = {
    # model, replacements, duration in s, bound of the difference, lag states with their declared types
    "twin_rotor": ("airs/twin_rotor.toml", [("step_s = 0.01", "step_s = 0.001")], 0.04, 2e-4, {"Velocity": 2 * 3 * 7 * 4}),
    "wing_with_propellers": ("airs/wing_with_propellers.toml", [("step_s = 0.001", "step_s = 0.0001")], 0.01, 2e-3, {"Velocity": 32}),
    "nrel_5mw": (
        "turbine/nrel_5mw_wind.toml",
        [("step_s = 0.02\n# The", "step_s = 0.002\n# The"), ('hub = "hub"\n', 'hub = "hub"\ndynamic_inflow = true\ndynamic_stall = true\n')],
        0.1, 1e-3, {"Velocity": 3 * 17 * 4, "Angle": 3 * 14 * 2, "Ratio": 3 * 14 * 2},
    ),
}


@pytest.mark.parametrize("version", ["2", "3"])
@pytest.mark.parametrize("name", ROTORS)
def test_me33_rotors_in_model_exchange(foldwing, name, version):
    """ME-33. Machines with rotors: FMPy finds no problem in the FMU and integrates it with CVode at 1e-7; loads and speeds of the rotors agree with
    co-simulation with a tenth of the shipped steps of the air; the lag states have the names and types of linear models."""
    path, replacements, stop_s, bound, lags = ROTORS[name]
    text = (ROOT / "examples" / path).read_text()
    for before, after in replacements:
        assert before in text, before
        text = text.replace(before, after, 1)
    # beside its files of polars
    with tempfile.TemporaryDirectory() as folder:
        shutil.copytree(ROOT / "examples" / pathlib.Path(path).parent, f"{folder}/models")
        model, fmu = pathlib.Path(folder) / "models/model.toml", pathlib.Path(folder) / "rotors.fmu"
        model.write_text(text)
        subprocess.run([foldwing, "package", model, "-o", fmu, "--fmi", version, "--interface", "cs,me", "--no-reference"], check=True)
        assert validate_fmu(str(fmu)) == []
        described = fmpy.read_model_description(str(fmu))
        states = [v for v in described.modelVariables if v.name.startswith("state.") and (".station" in v.name or ".lag" in v.name)]
        types = collections.Counter(v.declaredType.name for v in states)
        if version == "2":
            assert types == lags
        outputs = [v.name for v in described.modelVariables if v.causality == "output" and v.name.startswith("rotor.")]
        names = [name for name in outputs if name.endswith((".thrust", ".torque", ".speed"))]
        settings = {"stop_time": stop_s, "output_interval": stop_s / 40, "output": names}
        own = fmpy.simulate_fmu(str(fmu), fmi_type="CoSimulation", **settings)
        other = fmpy.simulate_fmu(str(fmu), fmi_type="ModelExchange", relative_tolerance=1e-7, **settings)
        for output in names:
            there = np.interp(own["time"][8:], other["time"], other[output])
            miss = np.abs(there - own[output][8:]).max() / np.abs(own[output]).max()
            print(f"ME-33 {name} {version} {output}: {miss:.1e}")
            assert miss < bound, output
