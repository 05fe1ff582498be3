"""A wing on a sliding joint of a beam in the wind, as an FMU of both versions: the motion of the command over a border of elements, rollback."""

import subprocess

import numpy as np
import pytest
from conftest import ROOT
from constraints import columns_of_the_command, states_are_whole, states_of_fmi_3_are_whole

STEP_S, STOP_S = 2e-3, 0.34
NAMES = ["slide.position", "slide.velocity", "aero.force.z", "aero.force.y", "energy.kinetic", "energy.total"]
AIR = """
[body.wing]
length_m = 0.3
section = "slender"
elements = 2
load_stations = 0

[joint.mount_of_wing]
type = "clamped"
parent = "bead"
child = "wing"
mount_rotation_deg = [0.0, 10.0, 90.0]

[aerodynamics]
model = "MODEL"
density_kg_m3 = 1.2
wind_m_s = [4.0, -9.0, 1.0]
step_s = 0.007

[surface.beam]
body = "beam"
chord_m = 0.1
strips = 3

[surface.wing]
body = "wing"
chord_m = 0.08
strips = 2

[solver]
"""


@pytest.fixture(scope="module", params=["strip", "uvlm"])
def model(request, tmp_path_factory):
    """The bead of the verification with a wing on it, in the air of strips or of a lattice."""
    path = tmp_path_factory.mktemp("rail") / "rail.toml"
    text = (ROOT / "tests/verification/plant/sliding.toml").read_text()
    path.write_text(text.replace("[solver]", AIR.replace("MODEL", request.param)))
    return path


@pytest.fixture(scope="module")
def packaged(foldwing, model):
    """Its FMUs by the version of FMI."""
    fmus = {}
    for version in ("2", "3"):
        fmus[version] = model.with_name(f"Rail{version}.fmu")
        subprocess.run([foldwing, "package", model, "-o", fmus[version], "--fmi", version], check=True)
    return fmus


@pytest.mark.parametrize("version", ["2", "3"])
def test_sj40_the_fmu_moves_as_the_command(foldwing, model, packaged, tmp_path, version):
    """SJ-40. FMPy finds no problem in the FMU; over 0.34 s in co-simulation, across a border of elements, position, loads and energies are
    bit-identical to those of `foldwing simulate`."""
    columns = columns_of_the_command(foldwing, model, packaged[version], tmp_path, NAMES, STEP_S, STOP_S)
    for name, column in columns.items():
        assert np.ptp(column) > 0, f"{name} does not change"
    assert columns["slide.position"].min() < 0.26 and columns["slide.position"].max() > 0.5, "over a border of elements"


def test_sj41_states_of_the_fmu_are_whole(packaged, tmp_path):
    """SJ-41. FMI 2.0: a state saved inside an aerodynamic step continues bit by bit over a border, in the same instance and, as bytes, in
    another one."""
    states_are_whole(packaged["2"], tmp_path, STEP_S)


def test_sj41_states_of_fmi_3_are_whole(packaged, tmp_path):
    """SJ-41. FMI 3.0: the same for position, loads and energies."""
    states_of_fmi_3_are_whole(packaged["3"], tmp_path, NAMES, STEP_S)
