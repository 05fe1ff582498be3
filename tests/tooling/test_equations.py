"""The table of equations with their code and tests: up to date, and complete."""

import importlib.util
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SPEC = importlib.util.spec_from_file_location("equation_table", ROOT / "tools/equation_table.py")
equation_table = importlib.util.module_from_spec(SPEC)
sys.modules["equation_table"] = equation_table
SPEC.loader.exec_module(equation_table)


def test_the_table_is_current_and_every_equation_has_code_and_a_test():
    written, lacking = equation_table.page()
    assert lacking == [], "equations that no comment in crates/ names, or without a planted fault and a test"
    assert written == equation_table.PAGE.read_text(encoding="utf-8"), "python3 tools/equation_table.py"


def test_every_label_of_the_notation_has_a_row():
    notation = (ROOT / "docs/NOTATION.md").read_text(encoding="utf-8")
    labels = set(re.findall(r"^\*\*\(([A-Z]+\d+)\)\*\*", notation, re.M))
    rows = set(re.findall(r"^\| ([A-Z]+\d+) \|", equation_table.PAGE.read_text(encoding="utf-8"), re.M))
    assert len(labels) > 250 and labels == rows, labels ^ rows


def test_comments_name_their_equations():
    assert equation_table.named("Motion of the outer end, eq. (K5), with shear, eq. (K12).") == {"K5", "K12"}
    assert equation_table.named("NOTATION eqs. (K2)–(K4); eqs. (X17) to (X19)") == {"K2", "K3", "K4", "X17", "X18", "X19"}
    assert equation_table.named("row (P3) of the table") == set()
