"""`foldwing new`: from the starter to an FMU of a user's wing; the schema that it refers to, checked by an independent package."""

import json
import re
import subprocess

import jsonschema
import pytest
from conftest import ROOT
from fmpy import simulate_fmu

try:
    import tomllib
except ImportError:
    import tomli as tomllib

DIFF = ROOT / "examples/starter_three_bodies.diff"
MAXIMUM_CHANGED_LINES = 9


@pytest.fixture(scope="module")
def starter(foldwing, tmp_path_factory):
    """The starter with its schema, in a separate folder."""
    folder = tmp_path_factory.mktemp("starter")
    subprocess.run([foldwing, "new", "mywing.toml"], cwd=folder, check=True, capture_output=True)
    return folder / "mywing.toml"


def apply_diff(text, diff):
    """The text with a unified diff applied; every context line is compared."""
    old, new, at = text.split("\n"), [], 0
    for line in diff.split("\n")[2:]:
        hunk = re.match(r"@@ -(\d+)", line)
        if hunk:
            begin = int(hunk[1]) - 1
            new += old[at:begin]
            at = begin
        elif line.startswith("+"):
            new.append(line[1:])
        elif line:
            assert old[at] == line[1:], f"line {at + 1}: {old[at]!r} is not {line[1:]!r}"
            if line.startswith(" "):
                new.append(old[at])
            at += 1
    return "\n".join(new + old[at:])


def run_fmu(foldwing, model, outputs):
    """Checks, packages and simulates a model through FMPy with its default experiment."""
    fmu = model.with_suffix(".fmu")
    subprocess.run([foldwing, "check", model], check=True, capture_output=True)
    subprocess.run([foldwing, "package", model, "-o", fmu], check=True, capture_output=True)
    return simulate_fmu(fmu, output=outputs)


def test_f200_the_starter_is_an_fmu(foldwing, starter):
    """F-200. The unchanged starter becomes an FMU that unfolds and latches within half a second and stays latched."""
    result = run_fmu(foldwing, starter, ["fold.angle", "fold.latch_time", "fold.latched", "tip.position.x"])
    print(f"F-200 latched at {result['fold.latch_time'][-1]:.4f} s")
    assert 0.1 < result["fold.latch_time"][-1] < 0.5 and result["fold.latched"][-1]
    assert abs(result["tip.position.x"][-1] - 0.9) < 0.02  # deployed: 0.5 m and 0.4 m in line, slightly bent
    assert abs(result["fold.angle"][-1]) < 1e-3


def test_f201_three_bodies_in_under_ten_lines(foldwing, starter):
    """F-201. The committed diff turns the starter into a wing of three bodies with fewer than ten added and removed lines; it is checked,
    packaged and run through FMPy, both folds latch and the tip ends at the sum of the lengths. The page on the model file shows the same
    diff.
    """
    diff = DIFF.read_text(encoding="utf-8")
    changed = [line for line in diff.split("\n")[2:] if line.startswith(("+", "-"))]
    assert 0 < len(changed) <= MAXIMUM_CHANGED_LINES, changed
    three = starter.with_name("three.toml")
    # only the name of the model depends on the file's name
    three.write_text(apply_diff(starter.read_text(encoding="utf-8"), diff), encoding="utf-8")
    assert len(tomllib.loads(three.read_text(encoding="utf-8"))["body"]) == 3
    result = run_fmu(foldwing, three, ["fold.latch_time", "fold_tip.latch_time", "fold.latched", "fold_tip.latched", "tip.position.x"])
    times = [result[f"{joint}.latch_time"][-1] for joint in ("fold", "fold_tip")]
    print(f"F-201 {len(changed)} changed lines; latched at {times[0]:.4f} s and {times[1]:.4f} s")
    assert all(0.05 < time < 1.0 for time in times) and result["fold.latched"][-1] and result["fold_tip.latched"][-1]
    assert abs(result["tip.position.x"][-1] - 1.1) < 0.03
    assert diff in (ROOT / "docs/MODEL_FILE.md").read_text(encoding="utf-8")


def test_f202_models_fit_the_schema_by_another_program(starter):
    """F-202. The starter and all shipped models are valid against the schema that editors read, by the package jsonschema (draft 2020-12);
    the schema itself is valid; each of several corrupted starters is rejected.
    """
    schema = json.loads((starter.parent / "foldwing.schema.json").read_text(encoding="utf-8"))
    jsonschema.Draft202012Validator.check_schema(schema)
    validator = jsonschema.Draft202012Validator(schema)
    models = sorted((ROOT / "examples").glob("**/*.toml"))
    assert len(models) >= 10
    for path in [starter, *models]:
        text = path.read_text(encoding="utf-8")
        line = re.match(r"#:schema (\S+)\n", text)
        assert line and (path.parent / line[1]).is_file(), f"{path}: no schema where its first line points"
        if path.suffix == ".toml":
            errors = [f"{error.json_path}: {error.message}" for error in validator.iter_errors(tomllib.loads(text))]
            assert not errors, f"{path}: {errors}"
    text = starter.read_text(encoding="utf-8")
    for old, new in [("elements = 3", "elements = 0"), ("length_m = 0.5", 'length_m = "0.5"'), ('type = "revolute"', 'type = "hinge"'),
                     ("width_m", "widht_m"), ("[body]\n", "[bodies]\n"), ("stop_time_s", "stop_time"), ("[joint.fold]", '[joint."my fold"]')]:
        assert old in text
        damaged = tomllib.loads(text.replace(old, new, 1))
        assert not validator.is_valid(damaged), f"{new} passes"
