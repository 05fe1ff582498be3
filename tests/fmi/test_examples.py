"""The scripts of `examples/` that users copy run as they stand."""

import re
import subprocess
import sys

import pytest
from conftest import ROOT


def test_f40_ten_lines_of_python(wing):
    """F-40. The script of the README: released at 0.1 s, the wing latches 0.1222 s later, ± 0.5 % of the latch time.

    The wing bends under gravity while it is held, so that the start differs a little from the reference's.
    """
    command = [sys.executable, str(ROOT / "examples/fmpy_ten_lines.py"), wing.path]
    run = subprocess.run(command, capture_output=True, text=True, check=True)
    latch_s = float(re.search(r"latched at ([\d.]+) s", run.stdout)[1])
    assert latch_s - 0.1 == pytest.approx(0.1222, rel=5e-3)


def test_f44_damp_latched_wing(foldwing, wing, tmp_path):
    """F-44. The script of the state feedback prints what F-43 checks and draws its picture."""
    picture = tmp_path / "damped.png"
    script = str(ROOT / "examples/damp_latched_wing.py")
    command = [sys.executable, script, "--foldwing", str(foldwing), "--fmu", wing.path, "--picture", str(picture)]
    run = subprocess.run(command, capture_output=True, text=True, check=True)
    free, damped = (float(time) for time in re.findall(r"of its peak after +([\d.]+) s", run.stdout))
    assert free > 4.0 * damped > 0.0
    assert picture.stat().st_size > 10_000
