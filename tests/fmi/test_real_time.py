"""Real-time mode through FMPy: an FMU of the shipped wing with one more line in its model file."""

import subprocess

import pytest
from conftest import ROOT
from driving import Fmu, instance
from fmpy.validation import validate_fmu

STEP_S = 1e-3


@pytest.fixture(scope="module")
def real_time(foldwing, tmp_path_factory):
    """The wing with `solver.mode = "real_time"`."""
    folder = tmp_path_factory.mktemp("real_time")
    model = folder / "wing.toml"
    text = (ROOT / "examples/models/folding_wing.toml").read_text()
    model.write_text(text + '\n[solver]\nmode = "real_time"\n')
    subprocess.run([foldwing, "package", model, "-o", folder / "wing.fmu"], check=True)
    return Fmu(folder / "wing.fmu", folder / "unpacked")


def test_f280_the_fmu_is_valid_and_deploys(real_time):
    """F-280. FMPy finds no problem in the description with its durations, and the wing latches at steps of 1 ms within 0.1 % of 0.12218 s,
    the latch time of the ordinary solver on this mesh (for the reason see P-111)."""
    assert not validate_fmu(real_time.path)
    result = real_time.simulate(stop_time=0.2, output_interval=STEP_S)
    assert abs(result["fold.latch_time"][-1] / 0.122178 - 1.0) < 1e-3


def test_f281_durations_are_read_and_are_no_part_of_the_state(real_time):
    """F-281. The FMU outputs the duration of its steps; after returning to a saved state all outputs are repeated bit-identically, and the
    durations are not part of the state."""
    with instance(real_time) as wing:
        wing.initialize()
        assert [wing.get(f"solver.step_time{end}") for end in ("", "_median", "_max")] == [0.0, 0.0, 0.0]
        wing.advance(50, STEP_S)
        last, median, slowest = (wing.get(f"solver.step_time{end}") for end in ("", "_median", "_max"))
        assert 0.0 < last <= slowest and 0.0 < median <= slowest
        assert wing.get("solver.failures") == 0 and wing.get("solver.iterations_max") <= 4
        assert wing.get("solver.unconverged") == 0
        saved = wing.slave.getFMUstate()
        wing.advance(10, STEP_S)
        expected, slowest = wing.bits(), wing.get("solver.step_time_max")
        wing.slave.setFMUstate(saved)
        wing.time_s = 50 * STEP_S
        assert wing.get("solver.step_time_max") == slowest
        wing.advance(10, STEP_S)
        assert wing.bits() == expected
