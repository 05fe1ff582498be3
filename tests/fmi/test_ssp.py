"""`package --ssp`: a system with parameters and their mapping, and a controller with the wing, compared with a single model."""

import math
import subprocess
import sys
import zipfile

import numpy as np
import pytest
from conftest import ROOT
from driving import Fmu, Instance
from fmpy import read_model_description, simulate_fmu
from fmpy.ssp.ssd import read_ssd, read_ssm, read_ssv

pytest.importorskip("pythonfmu", reason="needs pythonfmu (python/requirements-test.txt, Python 3.10)")
sys.path.insert(0, str(ROOT / "examples"))
import controlled_wing_ssp as study  # noqa: E402, the script itself

STOP_S = 0.05
START_DEG = 120.0


def packaged(foldwing, folder, model, *more):
    ssp, fmu = folder / f"{model}.ssp", folder / f"{model}.fmu"
    command = [foldwing, "package", ROOT / f"examples/models/{model}.toml", "-o", fmu, "--ssp", ssp, "--no-reference", "-q", *more]
    subprocess.run(command, check=True)
    return ssp, fmu


@pytest.fixture(scope="module")
def controlled(foldwing, tmp_path_factory):
    """Members of the system with the controller, and the FMU of the wing."""
    folder = tmp_path_factory.mktemp("ssp")
    members = study.system(foldwing, folder, START_DEG)
    return members, folder / "wing.fmu"


@pytest.mark.parametrize("model, more", [("folding_wing", ()), ("flared_wing_tip", ("--fmi", "3", "--scalars")), ("four_bar", ("--interface", "me"))])
def test_im02_structure_parameters_and_mapping_follow_the_schemas(foldwing, tmp_path, model, more):
    """IM-02. SSD, SSV and SSM pass the schemas of SSP 1.0 (FMPy); connectors are the inputs, outputs and parameters of the FMU; the mapped
    values are the start values of its description to the last bit but one, those of model files in degrees to the last."""
    ssp, fmu = packaged(foldwing, tmp_path, model, *more)
    structure = read_ssd(str(ssp))
    read_ssv(str(ssp), resource="resources/parameters.ssv")
    read_ssm(str(ssp), resource="resources/parameters.ssm")
    (component,) = structure.system.elements
    variables = read_model_description(str(fmu)).modelVariables
    exposed = {row.name: row.causality for row in variables if row.causality in ("input", "output", "parameter")}
    assert {connector.name: connector.kind for connector in component.connectors} == exposed
    starts = study.start_values(study.read(ssp))
    parameters = [row for row in variables if row.causality == "parameter"]
    assert len(starts) == len(parameters) > 5
    for row in parameters:
        found = starts[f"model.{row.name}"]
        if isinstance(found, bool):
            assert found == (row.start == "true"), row.name
        else:
            assert abs(found - float(row.start)) <= math.ulp(float(row.start)), row.name
    with zipfile.ZipFile(ssp) as archive:
        assert archive.namelist()[0] == "SystemStructure.ssd"
        assert archive.read("resources/model.fmu") == fmu.read_bytes()


def test_im02_angles_of_the_values_are_degrees_of_the_model_file(foldwing, tmp_path):
    """IM-02. The start angle of 170 degrees is 170.0 in the SSV, and exactly that of the FMU after the mapping."""
    ssp, fmu = packaged(foldwing, tmp_path, "folding_wing")
    members = study.read(ssp)
    assert b'<ssv:Parameter name="fold.start_angle_deg">' in members["resources/parameters.ssv"]
    assert b'<ssv:Real value="170.0" unit="deg"/>' in members["resources/parameters.ssv"]
    start = next(row.start for row in read_model_description(str(fmu)).modelVariables if row.name == "fold.start_angle")
    assert study.start_values(members)["model.fold.start_angle"] == float(start)


@pytest.mark.parametrize("more, words", [(("--fmi", "3", "--ssp", "x.ssp"), "SSP 1.0 has no arrays; add --scalars"),
                                         (("--ssp", "x.zip"), "the name of an SSP must end in .ssp; write x.zip.ssp")])
def test_im02_what_is_no_system_is_refused_by_name(foldwing, tmp_path, more, words):
    """IM-02. Arrays and other file extensions are rejected, and nothing is written."""
    run = subprocess.run([foldwing, "package", ROOT / "examples/models/folding_wing.toml", *more], capture_output=True, text=True, cwd=tmp_path)
    assert run.returncode == 2 and words in run.stderr
    assert list(tmp_path.iterdir()) == []


def by_hand(fmu, folder, steps, step_s):
    """Fold angle after each step by direct calls in the order of FMPy's SSP run: both components step with the connected values of the
    previous step, initially 0."""
    wing, angles = Instance(Fmu(fmu, folder)), []
    law, torque, seen = study.CONTROLLER, 0.0, (0.0, 0.0)
    try:
        wing.initialize(fold__start_angle=START_DEG * (math.pi / 180.0), solver__tolerance=1e-8)
        for _ in range(steps):
            wing.set("fold.external_torque", torque)
            wing.step(step_s)
            wanted = law["stiffness"] * (law["target"] - seen[0]) - law["damping"] * seen[1]
            torque, seen = max(-law["limit"], min(law["limit"], wanted)), (wing.get("fold.angle"), wing.get("fold.angular_velocity"))
            angles.append(seen[0])
    finally:
        wing.slave.freeInstance()
    return angles


def test_im03_controller_beside_the_wing_is_the_same_loop(controlled, tmp_path):
    """IM-03. FMPy's run of the system gives the fold angles of the FMU alone with the torque of the controller from the previous step as input."""
    members, fmu = controlled
    step_s = 5e-4
    steps = round(STOP_S / step_s)
    angles = [angle for (angle,) in study.run_fmpy(members, tmp_path, STOP_S, step_s)]
    alone = by_hand(fmu, tmp_path / "unpacked", steps, step_s)
    assert len(angles) == steps and np.array_equal(angles, alone)
    assert abs(angles[-1] - math.radians(START_DEG)) > 0.1, "the wing moves"


def test_im04_system_converges_to_the_model_with_that_motor(controlled, tmp_path):
    """IM-04. A spring in the controller is equivalent to that of a motor in a single model; the controller has a delay of one or two
    steps, so that the difference falls in proportion to the step."""
    members, fmu = controlled
    single = {"fold.start_angle": math.radians(START_DEG), "solver.tolerance": 1e-8}
    rows = read_model_description(str(fmu)).modelVariables
    starts = {row.name: float(row.start) for row in rows if row.name == "fold.motor_stiffness"}
    single["fold.motor_stiffness"] = starts["fold.motor_stiffness"] + study.CONTROLLER["stiffness"]
    model = simulate_fmu(str(fmu), stop_time=STOP_S, output_interval=STOP_S, start_values=single, output=["fold.angle"])["fold.angle"][-1]
    off = [abs(study.run_fmpy(members, tmp_path, STOP_S, step_s)[-1][0] - model) for step_s in (5e-4, 2.5e-4, 1.25e-4)]
    print(f"\nIM-04 differences {off} rad of {math.radians(START_DEG) - model:.3f} rad")
    assert off[-1] < 0.01 * (math.radians(START_DEG) - model)
    assert off[0] / off[1] == pytest.approx(2.0, rel=0.15) and off[1] / off[2] == pytest.approx(2.0, rel=0.15)
