"""Bounds of `make wasm-fmu`: differences of the component are measured by the size of an output, or by the effect of last digits."""

import importlib.util
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SPEC = importlib.util.spec_from_file_location("wasm_component", ROOT / "studies/wasm_component.py")
study = importlib.util.module_from_spec(SPEC)
sys.modules["wasm_component"] = study
SPEC.loader.exec_module(study)

UNITS = ["m", "m", "rad/s"]
ROWS = [[1.0, 0.5, 1e-6], [2.0, 0.01, -3e-6]]


def moved(column, distance):
    """The rows with a value of one column changed."""
    return [ROWS[0], [value + (distance if k == column else 0.0) for k, value in enumerate(ROWS[1])]]


def test_sizes_of_columns():
    """The largest value, a tenth of the largest of the unit, or the least size."""
    assert study.sizes(ROWS, UNITS) == [2.0, 0.5, study.LEAST]
    assert study.sizes([[1.0, 0.01, 0.0]], UNITS) == [1.0, 0.1, study.LEAST]
    assert study.apart(ROWS, moved(1, 0.05), UNITS) == pytest.approx(0.1)


def test_difference_is_bounded_by_the_size_or_by_last_digits_of_its_unit():
    """Last digits change the angular velocity by 2e-9 rad/s: the component may differ by that much there, and by 1e-6 of the size elsewhere;
    noise of one unit does not excuse another unit."""
    changed = [moved(2, 2e-9), moved(2, -1e-9), moved(0, 1e-12)]

    def over(rows):
        return study.excess(ROWS, rows, changed, UNITS, 1e-6)

    assert over(moved(2, 1.9e-9)) == pytest.approx(0.95) and over(moved(2, 2.1e-9)) > 1.0
    assert over(moved(0, 1.9e-6)) < 1.0 < over(moved(0, 2.1e-6))
    assert over(moved(1, 0.4e-6)) < 1.0 < over(moved(1, 0.6e-6))
    assert study.excess(ROWS, moved(2, 1e-9), [ROWS], UNITS, 1e-6) > 1.0, "without the last digits 1e-10 of the least size is the bound"
