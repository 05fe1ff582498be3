"""Declared dependencies of Model Exchange beside differences: `studies/dependences.py`."""

import re
import subprocess
import sys
import zipfile

import pytest
from conftest import ROOT

sys.path.insert(0, str(ROOT / "studies"))
import dependences as study  # noqa: E402, the script itself


def packaged(foldwing, folder, model):
    path = folder / f"{model}.fmu"
    subprocess.run([foldwing, "package", ROOT / f"examples/models/{model}.toml", "-o", path, "--interface", "me", "--no-reference", "-q"], check=True)
    return path


@pytest.mark.parametrize("model", ["roll_fold", "flared_wing_tip", "double_pendulum"])
def test_me22_declared_dependencies_contain_those_of_differences(foldwing, tmp_path, model):
    """ME-22. No entry of the Jacobian that is not declared is found by differences; derivatives of coordinates are their rates alone, so
    that this block has one entry per row, except for redundant parameters of rotations."""
    blocks, false_zeros = study.study(packaged(foldwing, tmp_path, model), points=1)
    assert false_zeros == []
    entries, declared, found = blocks["coordinates", "rates"]
    assert found <= declared < entries / 10
    if model != "double_pendulum":
        assert entries == declared**2 == found**2
    assert blocks["rates", "coordinates"][2] > 0 and blocks["outputs", "inputs"][1] > blocks["outputs", "inputs"][2] > 0


def test_me22_a_missing_dependency_is_found(foldwing, tmp_path):
    """ME-22. A description without the dependencies of one output and of one derivative of a coordinate: both are reported by name."""
    path = packaged(foldwing, tmp_path, "roll_fold")
    with zipfile.ZipFile(path) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    text = members["modelDescription.xml"].decode()
    for part in ("Outputs", "Derivatives"):
        before, rest = text.split(f"<{part}>")
        rest = re.sub(r'dependencies="[^"]+" dependenciesKind="[^"]+"', 'dependencies="" dependenciesKind=""', rest, count=1)
        text = f"{before}<{part}>{rest}"
    members["modelDescription.xml"] = text.encode()
    with zipfile.ZipFile(tmp_path / "broken.fmu", "w") as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    _, false_zeros = study.study(tmp_path / "broken.fmu", points=1)
    unknowns = {name.split(" by ")[0] for name in false_zeros}
    assert len(unknowns) == 2 and any(name.startswith("der(state.") for name in unknowns), unknowns
