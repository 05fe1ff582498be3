"""A machine with a cylindrical joint as an FMU of both versions: variables with units, the motion of the command, Model Exchange, rollback."""

import subprocess

import fmpy
import numpy as np
import pytest
from constraints import columns_of_the_command, states_are_whole, states_of_fmi_3_are_whole

STEP_S, STOP_S = 2e-3, 0.2
NAMES = ["strut_translation.position", "strut_translation.velocity", "strut_rotation.angle", "strut_rotation.angular_velocity",
         "strut_translation.total_force", "strut_rotation.total_torque", "strut_rotation.reaction_moment.y", "energy.kinetic", "energy.total"]
MODEL = """
name = "Boom"
gravity_m_s2 = [0.0, 2.0, -9.0]

[rigid_body.mast]
mass_kg = 2.0
inertia_kg_m2 = [0.02, 0.02, 0.02, 0.0, 0.0, 0.0]

[section.tube]
shape = "tube"
diameter_m = 0.02
wall_m = 0.001
material = "aluminium 7075-T6"

[body.boom]
section = "tube"
length_m = 0.8
elements = 2
stiffness_damping_s = 2e-4

[mass.load]
body = "boom"
position_m = 0.8
mass_kg = 0.2
offset_m = [0.0, 0.05, 0.03]

[joint.slew]
type = "revolute"
parent = "root"
child = "mast"
axis = [0.0, 0.0, 1.0]
start_rate_deg_s = 60.0

[joint.strut]
type = "cylindrical"
parent = "mast"
child = "boom"
axis = [1.0, 0.0, 0.0]
parent_offset_m = [0.05, 0.0, 0.1]

[joint.strut.translation]
motor.stiffness_N_m = 800.0
motor.damping_N_s_m = 20.0
motor.command_m = 0.05
end_stops.upper_m = 0.03
end_stops.stiffness_N_m = 2e4

[joint.strut.rotation]
start_angle_deg = 20.0
spring.stiffness_N_m_rad = 0.5
latch.angle_deg = 10.0
latch.stiffness_N_m_rad = 40.0

[simulation]
stop_time_s = 0.2
step_s = 2e-3
"""


@pytest.fixture(scope="module")
def model(tmp_path_factory):
    """A boom that telescopes and rolls on a mast that slews."""
    path = tmp_path_factory.mktemp("boom") / "boom.toml"
    path.write_text(MODEL)
    return path


@pytest.fixture(scope="module")
def packaged(foldwing, model):
    """Its FMUs, with both interfaces, by the version of FMI."""
    fmus = {}
    for version in ("2", "3"):
        fmus[version] = model.with_name(f"Boom{version}.fmu")
        subprocess.run([foldwing, "package", model, "-o", fmus[version], "--fmi", version, "--interface", "cs,me"], check=True)
    return fmus


@pytest.mark.parametrize("version", ["2", "3"])
def test_cj14_the_fmu_moves_as_the_command(foldwing, model, packaged, tmp_path, version):
    """CJ-14. FMPy finds no problem in the FMU; over 0.2 s in co-simulation, through an end stop and a latch, motion, forces, reactions and
    energies are bit-identical to those of `foldwing simulate`."""
    columns = columns_of_the_command(foldwing, model, packaged[version], tmp_path, NAMES, STEP_S, STOP_S)
    for name, column in columns.items():
        assert np.ptp(column) > 0, f"{name} does not change"
    assert columns["strut_translation.position"].max() > 0.03, "the end stop acts"
    variables = {variable.name: variable for variable in fmpy.read_model_description(str(packaged[version])).modelVariables}
    for name, causality, unit in [
        ("strut_translation.position_command", "input", "m"),
        ("strut_translation.external_force", "input", "N"),
        ("strut_translation.release", "input", None),
        ("strut_rotation.external_torque", "input", "N.m"),
        ("strut_rotation.latch_enable", "input", None),
        ("strut_translation.motor_stiffness", "parameter", "N/m"),
        ("strut_rotation.spring_stiffness", "parameter", "N.m/rad"),
        ("strut_rotation.latch_stiffness", "parameter", "N.m/rad"),
        ("strut_translation.position", "output", "m"),
        ("strut_rotation.angle", "output", "rad"),
    ]:
        variable = variables[name]
        declared = variable.unit or (variable.declaredType.unit if variable.declaredType else None)
        assert (variable.causality, declared) == (causality, unit), name
    assert not [name for name in variables if name.startswith("body.strut_carriage")]


def test_cj15_model_exchange_agrees_with_co_simulation(packaged):
    """CJ-15. CVode at 1e-9 over the continuous states, among them position and angle, and co-simulation at 1e-9: within 2e-5 of the largest
    values, through both events."""
    states = [variable.name for variable in fmpy.read_model_description(str(packaged["2"])).modelVariables]
    assert "state.strut_translation.position" in states and "state.strut_rotation.angle" in states
    settings = {"stop_time": 0.1, "output_interval": STEP_S, "output": NAMES[:4]}
    own = fmpy.simulate_fmu(str(packaged["2"]), fmi_type="CoSimulation", start_values={"solver.tolerance": 1e-9}, **settings)
    other = fmpy.simulate_fmu(str(packaged["2"]), fmi_type="ModelExchange", relative_tolerance=1e-9, **settings)
    for name in NAMES[:4]:
        there = np.interp(own["time"], other["time"], other[name])
        miss = np.abs(there - own[name]).max() / np.abs(own[name]).max()
        print(f"CJ-15 {name}: {miss:.1e}")
        assert miss < 2e-5, name


def test_cj16_states_of_the_fmu_are_whole(packaged, tmp_path):
    """CJ-16. FMI 2.0: a state saved in the middle of the motion continues bit by bit, in the same instance and, as bytes, in another one."""
    states_are_whole(packaged["2"], tmp_path, STEP_S)


def test_cj16_states_of_fmi_3_are_whole(packaged, tmp_path):
    """CJ-16. FMI 3.0: the same for motion, forces, reactions and energies."""
    states_of_fmi_3_are_whole(packaged["3"], tmp_path, NAMES, STEP_S)
