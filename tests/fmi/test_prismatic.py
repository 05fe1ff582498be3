"""A machine with a prismatic joint as an FMU: its variables and units, free fall down a slope, a spring, a latch."""

import math
import subprocess

import fmpy
import fmpy.validation
import pytest

SLOPE_RAD = 0.5
GRAVITY_M_S2 = 9.8
MASS_KG = 2.0
MODEL = f"""
name = "Slide"
gravity_m_s2 = [0.0, 0.0, -{GRAVITY_M_S2}]

[rigid_body.block]
mass_kg = {MASS_KG}
inertia_kg_m2 = [0.01, 0.02, 0.03, 0.0, 0.0, 0.0]

[joint.slide]
type = "prismatic"
parent = "root"
child = "block"
axis = [{math.cos(SLOPE_RAD)}, 0.0, -{math.sin(SLOPE_RAD)}]
release = false
motor.stiffness_N_m = 0.0
spring.stiffness_N_m = 0.0
latch = {{ kind = "rigid", position_m = 1.0, enable = false }}

[solver]
tolerance = 1e-8
"""

UNITS = {
    "slide.neutral_position": "m", "slide.position": "m", "slide.velocity": "m/s", "slide.holding_force": "N", "slide.total_force": "N",
    "slide.motor_force": "N", "slide.spring_force": "N", "slide.external_force": "N", "slide.latch_force": "N",
    "slide.latch_impulse": "N.s", "slide.external_force": "N", "slide.position_command": "m", "slide.start_position": "m",
    "slide.motor_stiffness": "N/m", "slide.motor_damping": "N.s/m", "slide.motor_constant_force": "N", "slide.motor_force_limit": "N",
    "slide.motor_rate_limit": "m/s", "slide.spring_stiffness": "N/m", "slide.spring_damping": "N.s/m",
    "slide.rest_position": "m",
    **{f"slide.reaction_force.{axis}": "N" for axis in "xyz"},
    **{f"slide.reaction_moment.{axis}": "N.m" for axis in "xyz"},
}


@pytest.fixture(scope="module")
def fmu(foldwing, tmp_path_factory):
    """The packaged FMU."""
    folder = tmp_path_factory.mktemp("slide")
    (folder / "slide.toml").write_text(MODEL)
    subprocess.run([foldwing, "package", folder / "slide.toml", "-o", folder / "Slide.fmu"], check=True)
    return folder / "Slide.fmu"


def simulated(fmu, start, end_s=0.4):
    names = ["slide.position", "slide.velocity", "slide.holding_force", "slide.latched", "slide.latch_impulse"]
    rows = fmpy.simulate_fmu(str(fmu), stop_time=end_s, output_interval=0.01, start_values=start, output=names)
    return rows[-1]


def test_f290_variables_have_the_units_of_a_slide(fmu):
    """F-290. Every variable of the joint in m and N, none in rad; the description is valid."""
    assert fmpy.validation.validate_fmu(str(fmu)) == []
    description = fmpy.read_model_description(str(fmu))
    types = {kind.name: kind.unit for kind in description.typeDefinitions}
    found = {v.name: types[v.declaredType.name] for v in description.modelVariables
             if v.name.startswith("slide.") and v.type == "Real" and not v.name.endswith("time")}
    assert found == UNITS


def test_f291_a_block_slides_down_a_slope(fmu):
    """F-291. Locked it does not move; released it falls by ½ g sin α t²; on its spring it oscillates at √(k/m); a rigid latch stops it."""
    pull_m_s2 = GRAVITY_M_S2 * math.sin(SLOPE_RAD)
    held = simulated(fmu, {})
    assert held["slide.position"] == 0.0
    assert held["slide.holding_force"] == pytest.approx(-MASS_KG * pull_m_s2, rel=1e-12)
    free = simulated(fmu, {"slide.release": True})
    assert free["slide.position"] == pytest.approx(0.5 * pull_m_s2 * 0.16, rel=1e-10)
    sprung = simulated(fmu, {"slide.release": True, "slide.spring_stiffness": 50.0})
    rate = math.sqrt(50.0 / MASS_KG)
    assert sprung["slide.position"] == pytest.approx(pull_m_s2 / rate**2 * (1 - math.cos(0.4 * rate)), rel=1e-6)
    caught = simulated(fmu, {"slide.release": True, "slide.latch_enable": True}, 0.7)
    assert caught["slide.latched"] and caught["slide.velocity"] == 0.0
    assert caught["slide.position"] == pytest.approx(1.0, abs=2e-6)
    assert caught["slide.latch_impulse"] == pytest.approx(-MASS_KG * math.sqrt(2 * pull_m_s2), rel=1e-5)
