"""`foldwing run`: Foldwing FMUs, a container of them by another tool, and an FMU made by PythonFMU."""

import csv
import io
import json
import os
import re
import signal
import subprocess
import sys
import sysconfig
import time
from pathlib import Path

import numpy as np
import pytest
from conftest import ROOT, from_environment
from fmpy import simulate_fmu
from test_clients_toolbox import CONTAINER, STEP_S, container  # noqa: F401, the fixture

SPRING = ROOT / "tests/fmi/spring_slave.py"


@pytest.fixture(scope="session")
def runner():
    """Path of a command that was built with the feature `import`."""
    return from_environment("FOLDWING_RUNNER")


def run(runner, fmu, *arguments, code=0, environment=None):
    """Columns of the CSV as texts, and standard error."""
    command = [str(runner), "run", str(fmu), "--csv", "-", *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, env={**os.environ, **(environment or {})})
    assert done.returncode == code, done.stderr
    rows = list(csv.DictReader(io.StringIO(done.stdout)))
    return ({name: [row[name] for row in rows] for name in rows[0]} if rows else {}), done.stderr


def numbers(texts):
    return np.array([float(text) for text in texts])


def test_f130_our_fmus_give_the_same_digits_as_simulate_and_fmpy(runner, foldwing, shipped, tmp_path):
    """F-130. `foldwing run X.fmu` writes the same bytes as `foldwing simulate X.toml`, and the same doubles as FMPy.

    Twenty steps of the model's default experiment suffice: a wrong order of calls would show in the first.
    """
    step_s = float(shipped.description.defaultExperiment.stepSize)
    grid = ["--stop", repr(20 * step_s), "--step", repr(step_s)]
    model = ROOT / "examples/models" / f"{Path(shipped.path).stem}.toml"
    files = [tmp_path / "run.csv", tmp_path / "simulate.csv"]
    subprocess.run([runner, "run", shipped.path, "--csv", files[0], "-q", *grid], check=True)
    subprocess.run([foldwing, "simulate", model, "--csv", files[1], "-q", *grid], check=True)
    assert files[0].read_bytes() == files[1].read_bytes()

    columns, _ = run(runner, shipped.path, *grid)
    rows = shipped.simulate(stop_time=20 * step_s, output_interval=step_s)
    assert len(rows) == len(columns["time"]) == 21
    for name in rows.dtype.names[1:]:
        assert np.array_equal(numbers(columns[name]), rows[name].astype(float)), name


def test_f131_start_values_inputs_and_tolerance_act_as_in_fmpy(runner, wing, tmp_path):
    """F-131. Start values, one of them in degrees, inputs over time and the tolerance: the same doubles as FMPy."""
    inputs = tmp_path / "in.csv"
    inputs.write_text("time,fold.release,fold.external_torque\n0,0,0\n0.02,1,0.01\n0.05,1,-0.02\n")
    start_rad = 150.0 * np.pi / 180.0
    columns, _ = run(
        runner, wing.path, "--stop", 0.06, "--step", 1e-3, "--tolerance", 1e-6, "--inputs", inputs,
        "--set", "fold.start_angle=150 deg", "--set", "fold.motor_damping=0.001", "--variables", "fold.angle",
    )  # fmt: skip
    time = np.linspace(0.0, 0.06, 61)
    signals = np.array(
        [(t, t >= 0.02, np.interp(t, [0.0, 0.02, 0.05], [0.0, 0.01, -0.02])) for t in time],
        dtype=[("time", float), ("fold.release", bool), ("fold.external_torque", float)],
    )
    rows = wing.simulate(
        stop_time=0.06, output_interval=1e-3, relative_tolerance=1e-6, input=signals, output=["fold.angle"],
        start_values={"fold.start_angle": start_rad, "fold.motor_damping": 0.001},
    )  # fmt: skip
    mine, theirs = numbers(columns["fold.angle"]), rows["fold.angle"]
    assert mine[0] == pytest.approx(start_rad, abs=1e-12) and theirs[0] == pytest.approx(start_rad, abs=1e-12)
    difference = np.abs(mine - theirs).max()
    print(f"\nF-131 largest difference {difference:.1e} rad")
    # the two interpolate the torque with different round-off, and degrees are converted by the description's factor
    assert difference < 1e-9
    assert abs(theirs[-1] - start_rad) > 0.1, "the wing moves"


def test_f132_container_of_another_tool(runner, container):  # noqa: F811
    """F-132. The container FMU built by fmucontainer, a foreign library: the same doubles as FMPy over 0.4 s."""
    columns, _ = run(runner, container)
    rows = simulate_fmu(str(container), stop_time=0.4, output_interval=STEP_S, validate=False)
    for name in (output[2] for output in CONTAINER["output"]):
        assert np.array_equal(numbers(columns[name]), rows[name]), name


def python_library():
    """Shared library of this Python, which FMUs of PythonFMU expect in the process; `None` if there is none."""
    name = sysconfig.get_config_var("INSTSONAME") or ""
    folders = [sysconfig.get_config_var("LIBDIR"), f"/usr/lib/{sysconfig.get_config_var('MULTIARCH')}"]
    version = f"libpython{sys.version_info.major}.{sys.version_info.minor}.so.1.0"
    names = [file for file in (name, version) if file.startswith("libpython")]
    candidates = [Path(folder or "/", file) for folder in folders for file in names]
    return next((path for path in candidates if path.is_file()), None)


def test_f133_fmu_of_another_language(runner, tmp_path):
    """F-133. A spring made by PythonFMU: reals, an integer, a Boolean and a string against FMPy.

    Its library uses Python from the process, so Python is preloaded into the runner.
    """
    pytest.importorskip("pythonfmu", reason="`make pytest` installs pythonfmu")
    library = python_library()
    if library is None:
        message = "no shared library of Python on this machine"
        assert os.environ.get("CI") != "true", message
        pytest.skip(message)
    subprocess.run([sys.executable, "-m", "pythonfmu", "build", "-f", SPRING, "-d", tmp_path], check=True)
    fmu = tmp_path / "SpringMass.fmu"
    environment = {"LD_PRELOAD": str(library), "PYTHONHOME": sys.base_prefix}
    names = ["position", "velocity", "steps", "moving", "label"]
    outputs = [argument for name in names for argument in ("--variables", name)]
    settings = ["--set", "stiffness=50", "--set", "label=a spring", "--stop", 1, "--step", 0.1]
    columns, _ = run(runner, fmu, *settings, *outputs, environment=environment)
    rows = simulate_fmu(
        str(fmu), stop_time=1.0, output_interval=0.1, validate=False, output=names[:4],
        start_values={"stiffness": 50.0, "label": "a spring"},
    )  # fmt: skip
    for name in names[:4]:
        assert np.array_equal(numbers(columns[name]), rows[name].astype(float)), name
    assert columns["label"] == ["a spring"] * 11 and rows["steps"][-1] == 10
    assert np.ptp(rows["position"]) > 0.05, "the mass moves"


WITHOUT_LATCH = ["energy.kinetic", "root.force.z", "root.moment.y"]
WITH_LATCH = ["gauge.root.strain", "fold.latched", "fold.latch_time"]


@pytest.mark.parametrize("model, names, stop_s", [("slender_wing", WITHOUT_LATCH, 0.05), ("folding_wing", WITH_LATCH, 0.2)])
def test_f188_run_draws_what_simulate_draws(runner, foldwing, fmus, tmp_path, model, names, stop_s):
    """F-188. `foldwing run --plot` of the FMU draws the variables of `--variables` with the same bytes as `foldwing simulate --plot`, and
    needs no CSV. If the latch is among them, both mark its closing at the same time, with the same words.
    """
    chosen = [f"--variables={name}" for name in names] + [f"--stop={stop_s}"]
    commands = {"model": [foldwing, "simulate", ROOT / f"examples/models/{model}.toml"], "fmu": [runner, "run", fmus[model].path]}
    for folder, command in commands.items():
        subprocess.run([*map(str, command), "--quiet", "--plot", tmp_path / folder, *chosen], check=True)
    drawn = sorted(path.name for path in (tmp_path / "fmu").iterdir())
    assert drawn == sorted(path.name for path in (tmp_path / "model").glob("outputs_*")) and len(drawn) >= 4
    for name in drawn:
        assert (tmp_path / "fmu" / name).read_bytes() == (tmp_path / "model" / name).read_bytes(), name
    marked = "fold latched, 0.1222 s" in (tmp_path / "fmu/outputs_1.svg").read_text(encoding="utf-8")
    assert marked == (model == "folding_wing")


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
def test_f139_ctrl_c_leaves_the_old_results_and_no_folder(runner, wing, tmp_path):
    """F-139. Ctrl-C in the middle of `foldwing run`: the old CSV is unchanged, with no other file next to it, and the unpacked FMU is
    removed."""
    results, unpacked = tmp_path / "results", tmp_path / "unpacked"
    results.mkdir(), unpacked.mkdir()
    environment = {**os.environ, "TMPDIR": str(unpacked)}
    target = results / "x.csv"
    command = [runner, "run", wing.path, "--csv", target, "-q", "--step", "1e-3", "--stop"]
    subprocess.run([*command, "1e-2"], check=True, env=environment)
    before = target.read_bytes()
    # interruptible however the tests were started: `nohup make test &` ignores SIGINT, and child processes inherit this
    interruptible = lambda: signal.signal(signal.SIGINT, signal.SIG_DFL)
    child = subprocess.Popen([*command, "1000"], env=environment, preexec_fn=interruptible)
    unfinished = lambda: [file for file in results.iterdir() if file.name.startswith(".foldwing-")]
    while not any(file.stat().st_size for file in unfinished()):
        assert child.poll() is None, "ended before rows had reached the disk"
        time.sleep(0.01)
    assert list(unpacked.iterdir())
    child.send_signal(signal.SIGINT)
    assert child.wait() == -signal.SIGINT
    assert target.read_bytes() == before
    assert list(results.iterdir()) == [target] and not list(unpacked.iterdir())


def test_an_fmu_alone_gives_a_summary(runner, wing, tmp_path):
    """Without files `run` prints the end of the run with final values; with `--json` all of them, equal to the last row of the table."""
    short = ["--stop", "0.02", "--step", "1e-3"]
    done = subprocess.run([runner, "run", wing.path, *short], capture_output=True, text=True, check=True)
    assert done.stdout == "" and re.search(r"^FoldingWing: 0.020000 s simulated in ", done.stderr)
    assert re.search(r"^fold.angle = \S+ rad$", done.stderr, re.MULTILINE)
    assert re.search(r"^and \d+ more variables; --csv OUT.csv writes all$", done.stderr, re.MULTILINE)
    assert len(done.stderr.splitlines()) == 22
    table = tmp_path / "x.csv"
    done = subprocess.run([runner, "run", wing.path, *short, "--csv", table, "--json", "-q"], capture_output=True, text=True, check=True)
    value, last = json.loads(done.stdout), list(csv.DictReader(table.open()))[-1]
    assert done.stderr == "" and value["stop_s"] == 0.02 and value["files"] == [str(table)] and value["warnings"] == 0
    assert set(value["final_values"]) == set(last) - {"time"}
    for name, number in value["final_values"].items():
        assert float(number) == float(last[name]), name
    quiet = subprocess.run([runner, "run", wing.path, *short, "-q"], capture_output=True, text=True, check=True)
    assert quiet.stdout == quiet.stderr == ""
    refused = subprocess.run([runner, "run", wing.path, "--csv", "-", "--json"], capture_output=True, text=True)
    assert refused.returncode == 2 and "--json writes to standard output too" in refused.stderr
