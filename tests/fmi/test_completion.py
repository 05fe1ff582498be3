"""Completion of the model file in the documentation's pages, in Node without a browser."""

import json
import re
import shutil
import subprocess

import pytest
from conftest import ROOT

BEGIN = 'name = "w"\n[section.s]\nshape = "tube"\n[body.inner]\nlength_m = 1.0\n[rigid_body.hub]\n[joint.fold]\nchild = "inner"\n'


@pytest.fixture(scope="module")
def complete():
    """Completions at the cursors `|` of texts, and the units of all keys."""
    node = shutil.which("node")
    if node is None:
        pytest.skip("node is not installed (Debian: nodejs)")

    def run(*texts):
        done = subprocess.run([node, ROOT / "tests/fmi/completion.mjs"], input=json.dumps(texts), capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        found = json.loads(done.stdout)
        return [one and {**one, "labels": list(one["options"])} for one in found["found"]], found["units"]

    return run


def test_f380_keys_of_the_table(complete):
    """F-380. The keys of the table that contains the cursor, without those that it has, with unit, sentence and default of the schema.

    A section offers the keys of its shape only; in strings, comments and arrays nothing is offered.
    """
    (solver, motor, tube, top, inside, comment, text), _ = complete(
        BEGIN + "[solver]\ntolerance = 1e-5\n|", BEGIN + "[joint.fold.motor]\nst|\n[solver]\n", BEGIN.replace('"tube"\n', '"tube"\n|'), "|",
        "[body.a]\nload_station_positions_m = [\n  0.1,\n  |\n]\n", "[solver]\n# m|", 'description = "max_|"')
    schema = json.loads((ROOT / "examples/models/foldwing.schema.json").read_text(encoding="utf-8"))
    assert set(solver["labels"]) == set(schema["$defs"]["SolverFile"]["properties"]) - {"tolerance"}
    step = solver["options"]["max_step_s"]
    assert step["detail"].startswith("s") and step["info"] == ["Maximum internal step.", "Unit: s.", "Default: 0.005."] and step["apply"] == "max_step_s = "
    assert motor["from"] == "st" and motor["options"]["stiffness_N_m_rad"]["detail"].startswith("N·m/rad")
    assert {"diameter_m", "wall_m", "material"} == set(tube["labels"])
    assert {"name", "gravity_m_s2"} <= set(top["labels"]) and "solver" not in top["labels"]
    assert inside is None and comment is None and text is None


def test_f381_values_and_tables(complete):
    """F-381. Words of enumerations, true and false, names of the model where a key refers to it, and tables with those of the model inside."""
    (method, partial, shape, parent, section, boolean, tables), _ = complete(
        BEGIN + "[solver]\nmethod = |", BEGIN + '[solver]\nmethod = "es|"', '[section.s]\nshape = "|"', BEGIN + "parent = |", BEGIN.replace("length_m = 1.0", "section = |"),
        BEGIN + "[body.other]\nshear = |", BEGIN + "[joint.fold.|")
    assert set(method["labels"]) == {'"generalized_alpha"', '"tr_bdf2"', '"sdirk2"', '"esdirk3"', '"esdirk4"', '"rk4"'}
    assert (partial["from"], partial["to"]) == ('"es', '"') and partial["labels"] == method["labels"]
    assert {'"rectangle"', '"tube"', '"profile"', '"explicit"', '"table"'} <= set(shape["labels"])
    assert parent["labels"] == ['"root"', '"inner"', '"hub"']
    assert section["labels"] == ['"s"']
    assert boolean["labels"] == ["true", "false"]
    assert {"joint.fold.motor", "joint.fold.spring", "joint.fold.latch", "solver", "body."} <= set(tables["labels"])
    assert tables["options"]["joint.fold.motor"]["apply"] == "joint.fold.motor]" and tables["options"]["joint.fold.motor"]["info"]


def test_f382_every_key_with_a_unit_shows_it(complete):
    """F-382. Every key of the schema that ends in a unit has one, and no other key has: as in the model file, units are the ends of names."""
    _, units = complete()
    unit = re.compile(r"_(1_)?(kg|m|s|N|Pa|deg|rad|SI|m2|m3|s2|kg2|rpm2)$")
    assert len(units) > 200
    wrong = {key: shown for key, shown in units.items() if bool(shown) != bool(unit.search(key))}
    assert not wrong, wrong
    assert (units["stiffness_N_m"], units["mass_kg_m"], units["second_moments_kg_m"], units["torque_limit_N_m"]) == ("N/m", "kg/m", "kg·m", "N·m")
