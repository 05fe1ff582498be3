"""`package --real-outputs-only`: outputs that are not Real become local variables of the description."""

import subprocess
import xml.etree.ElementTree as ET
import zipfile

import numpy as np
import pytest
from conftest import ROOT
from fmpy import read_model_description, simulate_fmu
from fmpy.validation import validate_fmu

MODEL = ROOT / "examples/models/folding_wing.toml"
REAL = ("Real", "Float64")
FORMS = [("--fmi", "2"), ("--fmi", "3"), ("--fmi", "3", "--scalars")]


def packaged(foldwing, path, *more):
    subprocess.run([foldwing, "package", MODEL, "-o", path, "--no-reference", "-q", *more], check=True)
    return path


@pytest.mark.parametrize("form", FORMS, ids=" ".join)
@pytest.mark.parametrize("interface", ["cs", "me", "cs,me"])
def test_ca05_outputs_are_real_and_the_rest_is_local(foldwing, tmp_path, form, interface):
    """CA-05. Every output is Real, `fold.latched` is a local variable, and no variable is lost: names, references, types and start values of
    both descriptions are equal, and so is the token, because the library has one table. FMPy's validation finds no problem."""
    plain = packaged(foldwing, tmp_path / "plain.fmu", "--interface", interface, *form)
    path = packaged(foldwing, tmp_path / "real.fmu", "--interface", interface, "--real-outputs-only", *form)
    assert validate_fmu(str(path)) == []
    both = [read_model_description(str(file)) for file in (plain, path)]
    assert both[0].guid == both[1].guid and both[0].instantiationToken == both[1].instantiationToken
    before, after = ({row.name: row for row in description.modelVariables} for description in both)
    others = {name for name, row in before.items() if row.causality == "output" and row.type not in REAL}
    assert "fold.latched" in others
    for name, row in before.items():
        found = after[name]
        assert (found.valueReference, found.type, found.start, found.variability) == (row.valueReference, row.type, row.start, row.variability)
        assert found.causality == ("local" if name in others else row.causality)
    assert len(before) == len(after)
    for description, count in zip(both, (len(others), 0)):
        assert sum(unknown.variable.type not in REAL for unknown in description.outputs) == count
        assert sum(unknown.variable.name in others for unknown in description.initialUnknowns) == count


@pytest.mark.parametrize("form", FORMS, ids=" ".join)
def test_ca05_values_are_the_same(foldwing, tmp_path, form):
    """CA-05. Co-simulation through the latch: same bits, the local variable included; Model Exchange has the same values."""
    plain = packaged(foldwing, tmp_path / "plain.fmu", "--interface", "cs,me", *form)
    path = packaged(foldwing, tmp_path / "real.fmu", "--interface", "cs,me", "--real-outputs-only", *form)
    for kind, stop_s, step_s in [("CoSimulation", 0.2, 1e-3), ("ModelExchange", 2e-3, 5e-5)]:
        names = ["fold.angle", "fold.latched", "energy.total"]
        first, second = (simulate_fmu(str(file), fmi_type=kind, stop_time=stop_s, output_interval=step_s, output=names) for file in (plain, path))
        assert all(np.array_equal(first[name], second[name]) for name in names), kind
        if kind == "CoSimulation":
            assert not second["fold.latched"][0] and second["fold.latched"][-1]


def test_ca05_connectors_of_the_system_are_real(foldwing, tmp_path):
    """CA-05. The connectors of `--ssp` are those of the FMU: no Boolean output."""
    ssp = tmp_path / "x.ssp"
    packaged(foldwing, tmp_path / "x.fmu", "--real-outputs-only", "--ssp", ssp)
    with zipfile.ZipFile(ssp) as archive:
        root = ET.fromstring(archive.read("SystemStructure.ssd"))
    space = "{http://ssp-standard.org/SSP1/SystemStructureDescription}"
    outputs = [row for row in root.iter(f"{space}Connector") if row.get("kind") == "output"]
    assert len(outputs) > 100 and all(row[0].tag.endswith("}Real") for row in outputs)
