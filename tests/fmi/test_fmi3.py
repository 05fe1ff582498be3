"""FMI 3.0 through FMPy: its checks, its co-simulation and its Model Exchange, against FMI 2.0 of the same model."""

import subprocess
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest
from conftest import MODELS, ROOT, WHOLE, whole
from fmpy import read_model_description, simulate_fmu
from fmpy.validation import validate_fmu
from lxml import etree
from test_model_exchange import with_elements

SAMPLED = {"folding_wing_in_tunnel"}  # a lattice
CONTINUOUS = [model for model in MODELS if model not in SAMPLED]
SCHEMAS = Path(fmpy.__file__).parent / "schema/fmi3"


class Third:
    """An FMU of FMI 3.0 with its description."""

    def __init__(self, path):
        self.path = str(path)
        self.description = read_model_description(self.path)
        self.variables = {variable.name: variable for variable in self.description.modelVariables}

    def simulate(self, names, **arguments):
        return simulate_fmu(self.path, validate=False, output=names, **arguments)


@pytest.fixture(scope="session")
def third(foldwing, tmp_path_factory):
    """FMUs of FMI 3.0 by the name of the model file, for both interface types if the model allows it."""
    folder = tmp_path_factory.mktemp("fmi3")

    def make(model, elements=4):
        fmu = folder / f"{model}_{elements}.fmu"
        if not fmu.exists():
            path = fmu.with_suffix(".toml")
            path.write_text(with_elements((ROOT / "examples/models" / f"{model}.toml").read_text(), elements))
            kinds = "cs" if model in SAMPLED else "cs,me"
            command = [foldwing, "package", path, "-o", fmu, "--fmi", "3", "--interface", kinds]
            subprocess.run(command, check=True)
        return Third(fmu)

    return make


@pytest.mark.parametrize("model", MODELS)
def test_f310_shipped_models_run_in_both_versions(model, third, fmus):
    """F-310. Every shipped machine: FMPy finds no problem in the FMU of FMI 3.0, the official schemas accept description and terminals, and
    in co-simulation every output is bit-identical to that of FMI 2.0."""
    fmu, second = third(model), fmus[model]
    assert validate_fmu(fmu.path) == []
    with zipfile.ZipFile(fmu.path) as archive:
        names = set(archive.namelist())
        for member, schema in [
            ("modelDescription.xml", "fmi3ModelDescription.xsd"),
            ("terminalsAndIcons/terminalsAndIcons.xml", "fmi3TerminalsAndIcons.xsd"),
        ]:
            etree.XMLSchema(etree.parse(SCHEMAS / schema)).assertValid(etree.fromstring(archive.read(member)))
        assert "terminalsAndIcons/icon.png" in names and f"binaries/x86_64-linux/{second.description.modelName}.so" in names
        terminals = etree.fromstring(archive.read("terminalsAndIcons/terminalsAndIcons.xml"))
    members = [member.get("variableName") for member in terminals.iter("TerminalMemberVariable")]
    assert members and set(members) <= set(fmu.variables)
    experiment = second.description.defaultExperiment
    step_s = float(experiment.stepSize)
    arguments = {"stop_time": 20 * step_s, "output_interval": step_s, "fmi_type": "CoSimulation"}
    outputs = [v for v in fmu.description.modelVariables if v.causality == "output" and v.type == "Float64"]
    found = fmu.simulate([v.name for v in outputs], **arguments)
    expected = second.simulate(**arguments)
    seen = 0
    for variable in outputs:
        for name, values in elements(variable, found[variable.name], second):
            assert np.array_equal(values, expected[name]), name
            seen += 1
    assert seen == sum(1 for v in second.outputs if v.type == "Real")


def elements(variable, values, second):
    """The scalars of FMI 2.0 in an array: names with their values over time."""
    if not variable.dimensions:
        return [(variable.name, values)]
    rows = values.reshape(len(values), -1)
    group, key = variable.name.rsplit(".", 1)
    if variable.name == "gauge.strain":
        names = [n for n in second.variables if n.startswith("gauge.") and n.endswith(".strain")]
    elif group.startswith(("station.", "load.", "aero.load.", "aero.circulation")):
        count = int(variable.dimensions[0].start)
        inner = axes(rows.shape[1] // count)
        if group.startswith("aero.circulation"):
            names = [f"{variable.name}[{i + 1}]" for i in range(count)]
        else:
            names = [f"{group}[{i + 1}].{key}{axis}" for i in range(count) for axis in inner]
    else:
        names = [f"{variable.name}{axis}" for axis in axes(rows.shape[1])]
    assert len(names) == rows.shape[1], variable.name
    return zip(names, rows.T)


def axes(count):
    return {1: [""], 3: [".x", ".y", ".z"], 4: [".w", ".x", ".y", ".z"]}[count]


@pytest.mark.parametrize("model", CONTINUOUS)
def test_f311_shipped_models_run_in_model_exchange(model, third):
    """F-311. Every shipped machine without a lattice in Model Exchange of FMI 3.0: FMPy integrates it with CVode at a tolerance of 1e-6;
    angles and positions of tips agree with co-simulation to 1e-4 of their scale, with the method and duration of F-300."""
    fmu = third(model)
    points = 400 if WHOLE else 100
    stop_s = 5e-5 * points
    ends = (".angle", ".position")
    names = [name for name, v in fmu.variables.items() if v.causality == "output" and name.endswith(ends)]
    arguments = {"stop_time": stop_s, "output_interval": stop_s / points, "record_events": False}
    found = fmu.simulate(names, fmi_type="ModelExchange", relative_tolerance=1e-6, **arguments)
    expected = fmu.simulate(
        names, fmi_type="CoSimulation", start_values={"solver.tolerance": 1e-8}, **arguments
    )
    assert len(found) == len(expected) == points + 1
    worst = max(np.abs(found[name] - expected[name]).max() for name in names)
    print(f"{model}: {len(fmu.description.modelVariables)} variables, worst difference {worst:.1e}")
    assert worst < 1e-4


@pytest.mark.parametrize("elements", [1, pytest.param(4, marks=whole)])
def test_f312_the_wing_latches_as_in_co_simulation(third, elements):
    """F-312. FMPy's CVode at a tolerance of 1e-9 finds the latch by the event indicator, within 1e-6 s of co-simulation."""
    fmu = third("folding_wing", elements)
    arguments = {"stop_time": 0.13, "output_interval": 1e-4}
    names = ["fold.latch_time", "fold.latch_count", "fold.angle", "energy.total"]
    found = fmu.simulate(names, fmi_type="ModelExchange", relative_tolerance=1e-9, **arguments)
    expected = fmu.simulate(
        names, fmi_type="CoSimulation", start_values={"solver.tolerance": 1e-9}, **arguments
    )
    latch_s, reference_s = found["fold.latch_time"][-1], expected["fold.latch_time"][-1]
    print(f"latch at {latch_s:.9f} s, {latch_s - reference_s:+.1e} s beside co-simulation")
    assert found["fold.latch_count"][-1] == 1
    assert abs(latch_s - reference_s) < 1e-6
    for name in ["fold.angle", "energy.total"]:
        assert abs(found[name][-1] - expected[name][-1]) < 1e-6, name


@pytest.mark.parametrize("interval_s", [0.001, 0.005, 0.02, 0.05])
def test_f313_event_mode_ends_the_step_at_the_latch(interval_s, third):
    """F-313. FMPy with Event Mode and early return: the result has a point at the latch time, whatever the communication step, and the
    latch closes there."""
    fmu = third("folding_wing")
    names = ["fold.latch_time", "fold.latched"]
    result = fmu.simulate(
        names,
        fmi_type="CoSimulation",
        stop_time=0.15,
        output_interval=interval_s,
        use_event_mode=True,
        early_return_allowed=True,
    )
    latch_s = result["fold.latch_time"][-1]
    at = np.flatnonzero(result["time"] == latch_s)
    print(f"{interval_s} s: latch at {latch_s:.9f} s, rows {at}")
    assert len(at) == 2 and list(result["fold.latched"][at]) == [False, True]
    whole = fmu.simulate(names, fmi_type="CoSimulation", stop_time=0.15, output_interval=interval_s)
    assert abs(latch_s - whole["fold.latch_time"][-1]) < 1e-6


def test_f314_arrays_are_inputs_and_start_values(third, fmus):
    """F-314. FMPy passes loads as one array, over time and as start values, with the same result as the scalars of FMI 2.0."""
    fmu, second = third("folding_wing"), fmus["folding_wing"]
    time = np.array([0.0, 0.05])
    force = np.zeros((2, 4, 3))
    force[1] = np.arange(12).reshape(4, 3) * 1e-3
    array = np.zeros(2, dtype=[("time", float), ("load.outer.force", float, (4, 3))])
    array["time"], array["load.outer.force"] = time, force
    scalar_names = [f"load.outer[{i + 1}].force.{axis}" for i in range(4) for axis in "xyz"]
    scalars = np.zeros(2, dtype=[("time", float)] + [(name, float) for name in scalar_names])
    scalars["time"] = time
    for name, values in zip(scalar_names, force.reshape(2, 12).T):
        scalars[name] = values
    arguments = {"stop_time": 0.05, "output_interval": 1e-3, "fmi_type": "CoSimulation"}
    found = fmu.simulate(["tip.position"], input=array, start_values={"gravity": [0.0, 0.0, -9.81]}, **arguments)
    starts = {"gravity.x": 0.0, "gravity.y": 0.0, "gravity.z": -9.81}
    names = ["tip.position.x", "tip.position.y", "tip.position.z"]
    expected = second.simulate(input=scalars, start_values=starts, output=names, **arguments)
    for i, name in enumerate(names):
        # FMPy sets the derivatives of inputs in FMI 2.0 only on request: both hold inputs during a step
        assert np.array_equal(found["tip.position"][:, i], expected[name])


def test_f315_the_description_is_small(foldwing, tmp_path):
    """F-315. With 100 load stations the description of FMI 3.0 has at most a tenth of the bytes of that of FMI 2.0."""
    text = (ROOT / "examples/models/folding_wing.toml").read_text().replace("[body.outer]\n", "[body.outer]\nload_stations = 100\n")
    path = tmp_path / "many.toml"
    path.write_text(text)
    sizes = []
    for version in ["2", "3"]:
        command = [foldwing, "package", path, "--fmi", version, "--description-only"]
        sizes.append(len(subprocess.run(command, check=True, capture_output=True).stdout))
    print(f"modelDescription.xml with 100 stations: {sizes[0]} bytes in FMI 2.0, {sizes[1]} in FMI 3.0")
    assert sizes[1] * 10 <= sizes[0]
