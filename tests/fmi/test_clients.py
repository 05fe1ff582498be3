"""The FMU in FMPy's other interfaces: command, call log, cross-check, notebook, and two FMUs as one SSP system."""

import csv
import re
import subprocess
import sys

import numpy as np
import pytest
from conftest import ROOT
from driving import Instance
from fmpy import simulate_fmu
from fmpy.cross_check.validate_vendor_repo import validate_test_fmu

sys.path.insert(0, str(ROOT / "examples"))
import two_wings_ssp  # noqa: E402, the script itself

STEP_S = 5e-4
STEPS = 800


def fmpy(*arguments, cwd=None):
    """Output of FMPy's command."""
    command = [sys.executable, "-m", "fmpy", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=True, cwd=cwd).stdout


def in_turn(fmu, steps, step_s):
    """Two wings through direct calls: both step, then the latch of the left one releases the right one.

    Rows of (left angle, left latch time, right angle, right latch time) after each step.
    """
    left, right = Instance(fmu, name="left"), Instance(fmu, name="right")
    names, rows = ["fold.angle", "fold.latch_time"], []
    try:
        left.initialize()
        right.initialize(fold__release=False)
        release = False
        for _ in range(steps):
            right.set("fold.release", release)
            left.step(step_s)
            right.step(step_s)
            release = left.get("fold.latched")
            rows.append([wing.get(name) for wing in (left, right) for name in names])
    finally:
        left.slave.freeInstance()
        right.slave.freeInstance()
    return np.array(rows)


def test_f110_command_validates_without_a_finding(wing):
    """F-110. `fmpy validate` finds no problem and reports it in one line; F-01 does this for every shipped FMU."""
    assert fmpy("validate", wing.path).strip() == "No problems found."


def test_f111_command_shows_what_the_description_says(wing):
    """F-111. `fmpy info` reports type, name, experiment, the number of variables, and inputs and outputs by name."""
    text = fmpy("info", wing.path)
    count = len(wing.description.modelVariables)
    for pattern in [r"FMI Type +Co-Simulation", r"Model Name +FoldingWing", r"Stop Time +0.4", rf"Variables +{count}"]:
        assert re.search(pattern, text), pattern
    assert all(name in text for name in ["fold.angle_command", "fold.angle", "gauge.root.strain", "energy.total"])


def test_f112_command_simulates_and_logs_every_call(wing, tmp_path):
    """F-112. `fmpy simulate` gives results bit-identical to the API; its call log has the standard's order of calls."""
    out = tmp_path / "out.csv"
    names = ["fold.angle", "fold.latch_time"]
    text = fmpy(
        "simulate", wing.path, "--fmi-logging", "--stop-time", 0.4, "--output-interval", 1e-3,
        "--output-file", out, "--output-variables", *names,
    )  # fmt: skip
    with out.open() as file:
        last = list(csv.DictReader(file))[-1]
    api = wing.simulate(stop_time=0.4, output_interval=1e-3, output=names)
    assert [float(last[name]) for name in names] == [api[name][-1] for name in names]
    calls = re.findall(r"\[FMI\] (fmi2\w+)\(", text)
    assert calls[:2] == ["fmi2GetTypesPlatform", "fmi2GetVersion"] or calls[0] == "fmi2Instantiate", calls[:4]
    milestones = [
        "fmi2Instantiate", "fmi2SetupExperiment", "fmi2EnterInitializationMode", "fmi2ExitInitializationMode",
        "fmi2DoStep", "fmi2Terminate", "fmi2FreeInstance",
    ]  # fmt: skip
    places = [calls.index(name) for name in milestones]
    assert places == sorted(places) and calls.count("fmi2DoStep") == 400
    assert set(re.findall(r"-> ([A-Z]\w+)$", text, re.MULTILINE)) == {"OK"}, "no call warned or failed"


def test_f113_call_logger_sees_what_the_command_prints(wing):
    """F-113. The same log through the API: one line per call, with the values set."""
    lines = []
    simulate_fmu(
        wing.path, stop_time=0.01, output_interval=1e-3, start_values={"fold.angle_command": 0.25}, validate=False,
        output=["fold.angle"], fmi_call_logger=lines.append,
    )  # fmt: skip
    assert sum("fmi2DoStep(" in line for line in lines) == 10
    assert any("fmi2SetReal(" in line and "0.25" in line and line.endswith("-> OK") for line in lines)


def test_f114_cross_check_accepts_the_fmu(wing, tmp_path):
    """F-114. FMPy's check of cross-check submissions (file sizes, description, options, reference) finds nothing.

    The reference is the FMU's own result through FMPy: the check is that the submission is complete. A reference with a column that is not
    a variable is reported.
    """
    folder = tmp_path / "fmus/2.0/cs/linux64/foldwing/0.1.0/FoldingWing"
    folder.mkdir(parents=True)
    (folder / "FoldingWing.fmu").write_bytes(open(wing.path, "rb").read())
    (folder / "FoldingWing_ref.opt").write_text(
        "StartTime, 0\nStopTime, 0.4\nStepSize, 1e-3\nRelTol, 1e-4\nOutputIntervalLength, 0\n"
    )
    rows = wing.simulate(stop_time=0.4, output_interval=1e-3, output=["fold.angle", "gauge.root.strain"])
    reference = folder / "FoldingWing_ref.csv"

    def write(names):
        np.savetxt(reference, rows.tolist(), delimiter=",", header=",".join(f'"{n}"' for n in names), comments="")

    write(rows.dtype.names)
    assert validate_test_fmu(str(folder)) == []
    write(["time", "fold.angel", "gauge.root.strain"])
    assert any("fold.angel" in problem for problem in validate_test_fmu(str(folder)))


def test_f115_notebook_is_made(wing, tmp_path):
    """F-115. FMPy creates a notebook for the FMU; it contains every input and parameter with a start value."""
    path = tmp_path / "FoldingWing.fmu"
    path.write_bytes(open(wing.path, "rb").read())
    fmpy("create-jupyter-notebook", path, cwd=tmp_path)
    text = (tmp_path / "FoldingWing.ipynb").read_text()
    missing = [v.name for v in wing.description.modelVariables if v.causality == "parameter" and v.name not in text]
    assert missing == []


def test_f116_two_wings_as_one_system(wing, tmp_path):
    """F-116. The script of the SSP system: FMPy's SSP run is bit-identical to direct calls in the same order.

    The right wing is released when the left one latches and takes equally long, to 0.5 %: it bends under gravity while it is locked.
    """
    ssp = tmp_path / "two_wings.ssp"
    script = [sys.executable, str(ROOT / "examples/two_wings_ssp.py"), "--fmu", wing.path, "--output", str(ssp)]
    run = subprocess.run(script, capture_output=True, text=True, check=True)
    printed = [float(time) for time in re.findall(r"latches at ([\d.]+) s", run.stdout)]

    rows = two_wings_ssp.simulate(ssp, STEPS * STEP_S, STEP_S)
    paths = [f"{wing_name}.{name}" for wing_name in ("left", "right") for name in ("fold.angle", "fold.latch_time")]
    system = np.array([[row[path] for path in paths] for row in rows])
    alone = in_turn(wing, STEPS, STEP_S)
    assert np.array_equal(system[:STEPS], alone)
    left_s, right_s = alone[-1, 1], alone[-1, 3]
    print(f"\nF-116 left {left_s:.6f} s, right {right_s:.6f} s")
    assert printed == pytest.approx([left_s, right_s], abs=1e-4)
    assert right_s - left_s == pytest.approx(left_s, rel=5e-3)
