"""The scripts of `examples/` run unchanged."""

import csv
import math
import re
import subprocess
import sys

import pytest
from conftest import ROOT


def test_f40_ten_lines_of_python(wing):
    """F-40. The script of the README: released at 0.1 s, the wing latches 0.1222 s later, ± 0.5 % of the latch time.

    The wing bends under gravity while it is locked, so that the start differs slightly from the reference's.
    """
    command = [sys.executable, str(ROOT / "examples/fmpy_ten_lines.py"), wing.path]
    run = subprocess.run(command, capture_output=True, text=True, check=True)
    latch_s = float(re.search(r"latched at ([\d.]+) s", run.stdout)[1])
    assert latch_s - 0.1 == pytest.approx(0.1222, rel=5e-3)


def test_f44_damp_latched_wing(foldwing, wing, tmp_path):
    """F-44. The script of the state feedback prints the values checked by F-43 and draws its picture."""
    picture = tmp_path / "damped.png"
    script = str(ROOT / "examples/damp_latched_wing.py")
    command = [sys.executable, script, "--foldwing", str(foldwing), "--fmu", wing.path, "--picture", str(picture)]
    run = subprocess.run(command, capture_output=True, text=True, check=True)
    free, damped = (float(time) for time in re.findall(r"of its peak after +([\d.]+) s", run.stdout))
    assert free > 4.0 * damped > 0.0
    assert picture.stat().st_size > 10_000


def test_c44_two_body_model(foldwing, tmp_path):
    """C-44. The two-body system as a model file: RMS(Z) over 0.01 … 5 s within 1e-5 of the converged 10.146183 m, to which four linear
    elements per body agree within 4e-6; Z of the free end within 5 mm of Exudyn's, whose beams include shear (C-33).
    """
    table = tmp_path / "two_body.csv"
    command = [foldwing, "simulate", ROOT / "examples/two_body.toml", "--variables", "tip.position.z", "--csv", table]
    subprocess.run(list(map(str, command)), capture_output=True, check=True)
    with table.open() as file:
        path = {round(float(row["time"]), 6): float(row["tip.position.z"]) for row in csv.DictReader(file)}
    with (ROOT / "tests/reference/two_body_exudyn_shear_rotary.csv").open() as file:
        reference = {round(float(row["t_s"]), 6): float(row["tip_Z_m"]) for row in csv.DictReader(file)}
    samples = [z for time, z in path.items() if time > 0.0]
    assert len(samples) == 500 and path.keys() <= reference.keys()
    assert math.sqrt(sum(z * z for z in samples) / len(samples)) == pytest.approx(10.146183, rel=1e-5)
    assert max(abs(z - reference[time]) for time, z in path.items()) < 5e-3
