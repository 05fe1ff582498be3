"""The table of all names: up to date, complete, and its terms belong to existing names."""

import importlib.util
import json
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SPEC = importlib.util.spec_from_file_location("name_table", ROOT / "tools/name_table.py")
name_table = importlib.util.module_from_spec(SPEC)
sys.modules["name_table"] = name_table
SPEC.loader.exec_module(name_table)


def schema_keys(value):
    """Every property anywhere in the schema of model files."""
    if isinstance(value, dict):
        for key, part in (value.get("properties") or {}).items() if isinstance(value.get("properties"), dict) else ():
            yield key
        for part in value.values():
            yield from schema_keys(part)
    elif isinstance(value, list):
        for part in value:
            yield from schema_keys(part)


def test_the_page_is_current():
    written, unknown = name_table.page()
    assert unknown == [], "terms in tools/name_terms.toml of names that do not exist"
    assert written == name_table.PAGE.read_text(encoding="utf-8"), "python3 tools/name_table.py"


def test_no_key_lacks_a_row():
    """Keys of the schema, not of the page from which the table is generated."""
    schema = json.loads((ROOT / "examples/models/foldwing.schema.json").read_text(encoding="utf-8"))
    listed = {name for names in name_table.keys().values() for name in names} | set(name_table.FORMS)
    page = name_table.PAGE.read_text(encoding="utf-8")
    assert not [name for name in listed if f"| `{name}` |" not in page]
    missing = set(schema_keys(schema)) - listed
    assert len(listed) > 250 and missing == set(), missing


def test_no_option_or_public_name_lacks_a_row():
    page = name_table.PAGE.read_text(encoding="utf-8")
    options = set(re.findall(r"(?<=[\s`])--[a-z][a-z-]+", (ROOT / "docs/guide/commands.md").read_text(encoding="utf-8")))
    options -= {"--help", "--version"}
    assert len(options) > 70 and {option for option in options if f"`{option}`" not in page} == set()
    names = name_table.python()
    assert {"load", "Model.linearize", "Model.fit", "Simulation.save", "LinearModel.reduce"} <= set(names)
    assert not [name for name in names if f"| `{name}` |" not in page]


def test_terms_are_those_of_known_programs():
    four = name_table.PROGRAMS
    assert name_table.cells("MuJoCo: gear; OpenFAST: GBRatio", four) == " | GBRatio | gear | "
    assert name_table.cells("Exudyn: discAxis", (*four, name_table.RARE)) == " |  |  |  | discAxis"
    for unknown in ("Exudyn: something", "Adams: something"):
        try:
            name_table.cells(unknown, four)
        except (AssertionError, KeyError):
            continue
        raise AssertionError("an unknown program is an error")


def test_a_column_for_exudyn_only_where_it_has_a_term():
    page = name_table.PAGE.read_text(encoding="utf-8")
    tables = re.findall(r"^\| (?:key|variable|name|command, option) \|.*(?:\n\|.*)*", page, flags=re.MULTILINE)
    rare = [table for table in tables if "Exudyn |" in table.split("\n")[0]]
    assert len(tables) > 30 and len(rare) == 3, (len(tables), len(rare))
    assert all(re.search(r"\| [^|]+ \|$", table, flags=re.MULTILINE) for table in rare)
