"""The archive and its description, as read by an importer."""

import re
import subprocess
import zipfile

import pytest
from conftest import MODELS, ROOT
from fmpy.validation import validate_fmu

# Capability flags by design: a flag is true only if the capability is implemented.
FLAGS = {
    "modelIdentifier": "FoldingWing",
    "needsExecutionTool": False,
    "canHandleVariableCommunicationStepSize": True,
    "canInterpolateInputs": True,
    "maxOutputDerivativeOrder": 1,
    "canRunAsynchronuously": False,
    "canBeInstantiatedOnlyOncePerProcess": False,
    "canNotUseMemoryManagementFunctions": True,
    "canGetAndSetFMUstate": True,
    "canSerializeFMUstate": True,
    "providesDirectionalDerivative": True,
}

# One error each, as (what, pattern, replacement, words of FMPy's message).
FAULTS = [
    ("schema", r"<DefaultExperiment ", "<DefaultExperimnt ", "DefaultExperimnt"),
    ("unit", r'<Unit name="N.m">', '<Unit name="N_m">', "N.m"),
    ("start value", r'(<ScalarVariable name="fold.angle_command"[^>]*>\s*<Real[^>]*?) start="[^"]*"', r"\1", "fold.angle_command"),
    ("duplicate name", r'name="fold.angular_velocity"', 'name="fold.angle"', "fold.angle"),
    ("initial unknowns", r"(<InitialUnknowns>\s*)<Unknown [^>]*/>", r"\1", "InitialUnknowns|initial unknowns"),
    ("variable name", r'name="tip.position.x"', 'name="tip.position..x"', "tip.position..x"),
]


def members(path):
    """Every file of an archive."""
    with zipfile.ZipFile(path) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def test_f01_validation_finds_nothing(shipped):
    """F-01. FMPy's validation (schema, names, structure, start values, units) finds no problem in any shipped FMU."""
    assert validate_fmu(shipped.path) == []


@pytest.mark.parametrize("fault", FAULTS, ids=[fault[0] for fault in FAULTS])
def test_f02_validation_finds_deliberate_faults(wing, tmp_path, fault):
    """F-02. The validation of F-01 detects errors: each of several, introduced one at a time, is reported."""
    _, pattern, replacement, words = fault
    files = members(wing.path)
    description = files["modelDescription.xml"].decode()
    broken, count = re.subn(pattern, replacement, description, count=1)
    assert count == 1, f"{pattern} is not in the description"
    files["modelDescription.xml"] = broken.encode()

    path = tmp_path / "broken.fmu"
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in files.items():
            archive.writestr(name, content)

    problems = validate_fmu(str(path))
    assert any(re.search(words, problem) for problem in problems), problems


def test_f03_archive_is_the_same_when_packaged_twice(foldwing, tmp_path):
    """F-03. Packaging is reproducible: the same model, library and command give the same bytes, at other places and times, with icon,
    reference results and linear model."""
    model = ROOT / "examples/models/folding_wing.toml"
    copies = [tmp_path / "first.fmu", tmp_path / "folder/second.fmu"]
    copies[1].parent.mkdir()
    (tmp_path / "copy.toml").write_bytes(model.read_bytes())
    for source, copy in zip([model, tmp_path / "copy.toml"], copies):
        subprocess.run([foldwing, "package", source, "-o", copy, "--linear"], check=True, cwd=copy.parent)
    assert copies[0].read_bytes() == copies[1].read_bytes()
    assert {"model.png", "extra/org.foldwing.linear/linear.mat", "documentation/fmi-ls-ref.txt"} <= set(members(copies[0]))
    leftovers = {path.name for path in tmp_path.rglob("*") if path.is_file()} - {"first.fmu", "second.fmu", "copy.toml"}
    assert not leftovers


def test_f04_archive_holds_what_it_must(shipped):
    """F-04. Library, model file, documentation and licences are in the archive; the model file is the one packaged."""
    files = members(shipped.path)
    assert "modelDescription.xml" in files
    assert any(re.fullmatch(rf"binaries/(linux64|win64|darwin64)/{shipped.description.modelName}\.(so|dll|dylib)", name) for name in files)
    models = [path.read_bytes() for path in (ROOT / "examples/models").glob("*.toml")]
    assert files["resources/model.toml"] in models
    page = files["documentation/index.html"].decode()
    assert shipped.description.modelName in page and "<svg" in page
    assert all(name in page for name in shipped.variables if shipped.variables[name].causality == "input")
    assert {name.split("/")[-1] for name in files if name.startswith("documentation/licenses/")} == {
        "license.txt",
        "LICENSE-APACHE.txt",
        "LICENSE-MIT.txt",
        "THIRD_PARTY.txt",
    }
    assert "model.png" in files
    # no files where FMI 2.0 does not expect them
    places = {"binaries", "documentation", "extra", "resources", "modelDescription.xml", "model.png"}
    assert {name.split("/")[0] for name in files} == places


def test_f05_flags_are_what_the_library_can_do(shipped):
    """F-05. Exact capability flags, no directional derivatives for machines with aerodynamics; the naming convention is structured and the
    description carries no date."""
    found = {name: getattr(shipped.description.coSimulation, name) for name in FLAGS}
    in_air = "wind.velocity.x" in shipped.variables
    assert found == FLAGS | {"modelIdentifier": shipped.description.modelName, "providesDirectionalDerivative": not in_air}
    assert shipped.description.variableNamingConvention == "structured"
    assert shipped.description.generationDateAndTime is None
    assert shipped.description.generationTool == f"foldwing {shipped.description.version}"


def test_f06_archive_carries_the_committed_description(fmus):
    """F-06. The description inside each FMU is the one committed in the repository, byte for byte."""
    for model in MODELS:
        fmu = fmus[model]
        committed = (ROOT / f"modelDescription/{model}.xml").read_bytes()
        assert members(fmu.path)["modelDescription.xml"] == committed, f"{model}: `make bless` after a deliberate change"


def test_f07_every_real_has_a_unit_and_start_values_follow_the_rules(shipped):
    """F-07. Reals have a declared type with a unit, inputs and parameters have a start value, outputs have none."""
    for variable in shipped.description.modelVariables:
        if variable.type == "Real" and variable.causality != "independent":
            assert variable.declaredType is not None and variable.declaredType.unit, variable.name
        has_start = variable.start is not None
        assert has_start == (variable.causality in {"input", "parameter"}), variable.name
