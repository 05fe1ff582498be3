"""The package as a whole: sweeps, FMUs, the included command, documentation, types, contents of the wheel."""

import csv
import doctest
import importlib
import inspect
import pkgutil
import subprocess
import sys
import zipfile
from importlib.metadata import distribution
from pathlib import Path

import numpy as np
import pandas
import pytest

import foldwing as fw

MODEL = "examples/models/folding_wing.toml"


def test_a_sweep_has_the_rows_of_the_command(wing, command, tmp_path):
    out = tmp_path / "out.csv"
    keys = {"fold.start_angle": [1.0, 2.5], "file:body.inner.elements": [2, 4], "solver.tolerance": [1e-4]}
    varied = [word for key, values in keys.items() for word in ("--vary", f"{key}={','.join(map(repr, values))}")]
    subprocess.run([command, "sweep", MODEL, *varied, "--output", out, "--variables", "fold.angle", "--stop", "0.2", "-q"], check=True)
    with open(out) as file:
        rows = list(csv.DictReader(file))
    table = wing.sweep(keys, outputs="fold.angle", stop=0.2)
    assert list(table) == list(rows[0]) and not table.failed.any()
    for name in ("fold.angle", "fold.first_latch_time", "gauge.root.strain.peak", "iterations"):
        assert np.array_equal(table[name], [float(row[name]) for row in rows]), name
    frame = pandas.DataFrame({"fold.start_angle": [1.0, 2.0], "fold.external_torque": [0.0, 0.01]})
    assert wing.sweep(frame, stop=0.1).to_pandas().shape[0] == 2
    with pytest.raises(fw.UsageError, match="sweep: variant 1: fold.start_angle=9.0"):
        wing.sweep({"fold.start_angle": [1.0, 9.0]})
    with pytest.raises(fw.UsageError, match="is not a key|unknown"):
        wing.sweep({"file:body.inner.lenght_m": [0.1]})


def test_fmus_are_those_of_the_command(wing, command, tmp_path):
    ours, theirs = tmp_path / "a.fmu", tmp_path / "b.fmu"
    wing.package(ours, reference=False)
    subprocess.run([command, "package", MODEL, "-o", theirs, "--no-reference"], check=True)
    assert ours.read_bytes() == theirs.read_bytes()
    (tmp_path / "c.fmu").write_text("mine")
    with pytest.raises(fw.FilesError, match="--force|not recognised"):
        wing.package(tmp_path / "c.fmu", reference=False)
    with pytest.raises(fw.UsageError, match="the name of an FMU must end in .fmu"):
        wing.package(tmp_path / "Wing")


def test_fmus_of_every_kind_are_those_of_the_command(wing, command, tmp_path):
    """Version, interface types and form of the variables give the same bytes as the command, and the same errors."""
    kinds = [
        (dict(fmi=3), ["--fmi", "3"]),
        (dict(interface="me"), ["--interface", "me"]),
        (dict(interface="me", accounts=True), ["--interface", "me", "--accounts"]),
        (dict(interface="me", real_outputs_only=True), ["--interface", "me", "--real-outputs-only"]),
        (dict(interface=("cs", "me"), fmi=3, scalars=True, linear="start"), ["--interface", "cs,me", "--fmi", "3", "--scalars", "--linear=start"]),
    ]
    for number, (given, words) in enumerate(kinds):
        ours, theirs = tmp_path / f"a{number}.fmu", tmp_path / f"b{number}.fmu"
        wing.package(ours, reference=False, **given)
        subprocess.run([command, "package", MODEL, "-o", theirs, "--no-reference", "-q", *words], check=True)
        assert ours.read_bytes() == theirs.read_bytes(), given
    # reference results are for FMI 2.0; with FMI 3.0 they are omitted, as in the command
    wing.package(tmp_path / "c.fmu", fmi=3)
    assert (tmp_path / "c.fmu").read_bytes() == (tmp_path / "a0.fmu").read_bytes()
    for given, words in [
        (dict(fmi=1), "fmi=1: allowed are 2 and 3"),
        (dict(interface="sc"), "interface='sc': allowed are"),
        (dict(interface=()), r"interface=\(\): allowed are"),
        (dict(scalars=True), "scalars=True: FMI 2.0 has no other variables; leave it out, or add fmi=3"),
        (dict(accounts=True), "accounts=True: co-simulation always has them; omit the option, or package Model Exchange alone"),
    ]:
        with pytest.raises(fw.UsageError, match=words):
            wing.package(tmp_path / "d.fmu", **given)
    lattice = fw.load("examples/models/folding_wing_in_tunnel.toml")
    with pytest.raises(fw.ModelError, match="^interface=me: "):
        lattice.package(tmp_path / "d.fmu", interface="me")
    assert not (tmp_path / "d.fmu").exists()


def test_systems_are_those_of_the_command(wing, command, tmp_path):
    """F-391. `ssp` writes the same system as `--ssp`, byte for byte, beside the same FMU; refusals are named with the keywords of Python, and
    leave nothing behind."""
    for number, (given, words) in enumerate([({}, []), (dict(fmi=3, scalars=True), ["--fmi", "3", "--scalars"]), (dict(interface=("cs", "me")), ["--interface", "cs,me"])]):
        ours, theirs = ([tmp_path / f"{who}{number}.{end}" for end in ("fmu", "ssp")] for who in "ab")
        assert wing.package(ours[0], ssp=ours[1], reference=False, **given) == ours[0]
        subprocess.run([command, "package", MODEL, "-o", theirs[0], "--ssp", theirs[1], "--no-reference", "-q", *words], check=True)
        assert [path.read_bytes() for path in ours] == [path.read_bytes() for path in theirs], given
        with zipfile.ZipFile(ours[1]) as system:
            assert system.read("resources/model.fmu") == ours[0].read_bytes()
            assert {"SystemStructure.ssd", "resources/parameters.ssv", "resources/parameters.ssm"} <= set(system.namelist())
    # written by Foldwing: replaced without `force`
    wing.package(ours[0], ssp=str(ours[1]), reference=False)
    (tmp_path / "mine.ssp").write_text("mine")
    for given, error, words in [
        (dict(ssp=tmp_path / "x.zip"), fw.UsageError, "x.zip: the name of an SSP must end in .ssp; write .*x.zip.ssp$"),
        (dict(ssp=tmp_path / "x.ssp", fmi=3), fw.UsageError, r"^ssp=.*x.ssp: SSP 1.0 has no arrays; add scalars=True, or leave out fmi=3$"),
        (dict(ssp=tmp_path / "mine.ssp"), fw.FilesError, "mine.ssp"),
        (dict(ssp=3), fw.ArgumentError, "^ssp=3: must be text or a path or None"),
    ]:
        with pytest.raises(error, match=words):
            wing.package(tmp_path / "d.fmu", reference=False, **given)
    assert not (tmp_path / "d.fmu").exists() and (tmp_path / "mine.ssp").read_text() == "mine"
    # a file of the user is overwritten with `force`
    wing.package(tmp_path / "d.fmu", ssp=tmp_path / "mine.ssp", reference=False, force=True)
    assert zipfile.is_zipfile(tmp_path / "mine.ssp")


def test_sweeps_have_start_values(wing, command, tmp_path):
    """`settings` are those of `--set`; a key of the variants has precedence."""
    out = tmp_path / "out.csv"
    words = ["--vary", "fold.start_angle=1.0,2.0", "--set", "gravity=0,0,-1.62", "--set", "fold.latch_enable=0"]
    subprocess.run([command, "sweep", MODEL, *words, "--output", out, "--variables", "tip.position", "--stop", "0.2", "-q"], check=True)
    with open(out) as file:
        rows = list(csv.DictReader(file))
    settings = {"gravity": [0.0, 0.0, -1.62], "fold.latch_enable": False, "fold.start_angle": 3.0}
    table = wing.sweep({"fold.start_angle": [1.0, 2.0]}, outputs="tip.position", stop=0.2, settings=settings)
    for name in ("fold.start_angle", "tip.position.z", "fold.first_latch_time", "iterations"):
        assert np.array_equal(table[name], [float(row[name]) for row in rows]), name
    with pytest.raises(fw.UsageError, match="fold.start_angle"):
        wing.sweep({"solver.tolerance": [1e-4]}, settings={"fold.start_angle": 99.0})


def test_the_command_is_inside(tmp_path):
    foldwing = Path(sys.executable).with_name("foldwing")
    said = subprocess.run([foldwing, "--version"], capture_output=True, text=True, check=True).stdout
    assert said.startswith(f"foldwing {fw.__version__}")
    subprocess.run([foldwing, "package", MODEL, "-o", tmp_path / "w.fmu", "--no-reference"], check=True)
    with zipfile.ZipFile(tmp_path / "w.fmu") as archive:
        assert any(name.startswith("binaries/") for name in archive.namelist())
    # it includes the templates
    subprocess.run([foldwing, "new", tmp_path / "plane.toml", "--template", "aircraft", "-q"], check=True)
    subprocess.run([foldwing, "examples", "turbine/nrel_5mw_wind.toml", "-o", tmp_path / "try", "-q"], check=True)
    assert fw.load(tmp_path / "plane.toml").name == "plane"
    assert fw.load(tmp_path / "try/turbine/nrel_5mw_wind.toml").text == fw.load("examples/turbine/nrel_5mw_wind.toml").text
    failed = subprocess.run([foldwing, "check", tmp_path / "none.toml"], capture_output=True, text=True)
    assert failed.returncode == 4 and "cannot be read" in failed.stderr
    assert subprocess.run([foldwing, "nothing"], capture_output=True).returncode == 2


def test_importing_is_quick_and_brings_numpy_alone():
    code = "import sys, foldwing; print([m for m in ('pandas', 'xarray', 'matplotlib', 'control', 'scipy') if m in sys.modules])"
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert said.strip() == "[]"


def test_arguments_of_wrong_types_are_named_with_what_is_allowed():
    model = fw.load(MODEL)
    wrong = [
        (lambda: model.simulate(stop="0.1 s"), "stop='0.1 s': must be a number or None"),
        (lambda: model.simulate(True), "stop=True: must be a number or None"),
        (lambda: model.simulate(0.1, outputs=3), "outputs=3: must be text or several texts or None"),
        (lambda: model.simulate(0.1, settings=["a=1"]), "settings=['a=1']: must be a mapping or None"),
        (lambda: model.modes("3"), "count='3': must be an integer"),
        (lambda: model.modes(3.0), "count=3.0: must be an integer"),
        (lambda: model.flutter("10:80:8"), "wind_m_s='10:80:8': must be several numbers"),
        (lambda: model.flutter([10, "80"]), "wind_m_s=[10, '80']: must be several numbers"),
        (lambda: model.flutter(10.0), "wind_m_s=10.0: must be several numbers"),
        (lambda: model.simulate(0.1, step_s=1e-3), "simulate: no argument is named 'step_s'; did you mean 'step'?"),
        (lambda: model.static(quickly=True), "static: no argument is named 'quickly'; its arguments are settings, path, branch"),
        (lambda: model.flutter(), "flutter: missing a required argument: 'wind_m_s'"),
        (lambda: model.package(3), "output=3: must be text or a path"),
        (lambda: fw.Model.from_dict("x"), "tree='x': must be a mapping"),
        (lambda: model.gradient(3), "of=3: must be"),
        (lambda: model.linearize(inputs="fold.external_torque").reduce("8"), "order='8': must be an integer"),
        (lambda: fw.load(3), "path=3: must be text or a path"),
    ]
    for call, message in wrong:
        with pytest.raises(fw.ArgumentError) as caught:
            call()
        assert isinstance(caught.value, TypeError) and isinstance(caught.value, fw.UsageError) and str(caught.value).startswith(message), str(caught.value)


def test_numbers_of_other_libraries_are_numbers():
    """Arguments accept values that convert to their type: scalars of NumPy and pandas, integers for reals, arrays and ranges for
    several."""
    model = fw.load(MODEL)
    held = {"fold.release": False}
    expected = model.modes(2, settings=held).frequency_Hz
    for count in (np.int64(2), np.array(2), pandas.Series([2])[0]):
        assert np.array_equal(model.modes(count, settings=held).frequency_Hz, expected)
    for stop in (np.float32(0.5), np.array(0.5), 1):
        assert model.simulate(stop, outputs="fold.angle", step=0.25).time[-1] == float(stop)
    goland = fw.load("examples/models/goland_wing.toml")
    winds = [np.array([100.0, 110.0]), range(100, 120, 10), (100, 110.0), iter([100.0, 110.0]), pandas.Series([100.0, 110.0])]
    found = [goland.flutter(wind, count=1).speed_m_s.tolist() for wind in winds]
    assert all(speeds == found[0] for speeds in found) and found[0][-1] == 110.0


class Unwrapped(doctest.DocTestFinder):
    """Finds the examples of functions with checked arguments: the functions that wrap them are from another module."""

    def _from_module(self, module, object):
        return super()._from_module(module, inspect.unwrap(object))


def test_examples_of_the_documentation_work():
    modules = [fw] + [importlib.import_module(f"foldwing.{found.name}") for found in pkgutil.iter_modules(fw.__path__)
                      if not found.name.endswith(("__main__", "_native", "foldwing_fmu"))]
    attempted = 0
    for module in modules:
        runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS)
        for example in Unwrapped().find(module, module.__name__):
            runner.run(example)
        assert runner.failures == 0, module.__name__
        attempted += runner.tries
    assert attempted > 90, "the examples were not found"


def test_stubs_are_those_of_the_module():
    """Every name of the native part is in its stub, and vice versa."""
    import ast

    import foldwing._native as native

    tree = ast.parse(Path(fw.__file__).with_name("_native.pyi").read_text())
    declared = {}
    for node in tree.body:
        if isinstance(node, ast.ClassDef):
            declared[node.name] = {entry.name for entry in node.body if isinstance(entry, ast.FunctionDef)}
        elif isinstance(node, ast.FunctionDef):
            declared[node.name] = None
    present = {name for name in vars(native) if not name.startswith("_")}
    assert present == {name for name in declared if not name.startswith("_")}
    for name, members in declared.items():
        if members is not None:
            own = {key for key in vars(getattr(native, name)) if not key.startswith("__") or key in ("__getitem__", "__setitem__")}
            assert own == members - {"__new__"}, name


@pytest.mark.parametrize("checker", [["mypy", "--strict"], ["pyright", "--pythonpath", sys.executable]])
def test_types_of_package_and_examples_hold(checker):
    examples = ["examples/python_ten_lines.py", "examples/gymnasium_wing.py", "examples/kalman_wing.py", "examples/soft_latch.py", "studies/python_cost.py"]
    targets = ["python/foldwing", *examples]
    result = subprocess.run([sys.executable, "-m", *checker, *targets], capture_output=True, text=True)
    assert result.returncode == 0, result.stdout + result.stderr


def test_the_wheel_holds_what_it_needs():
    files = {str(file) for file in distribution("foldwing").files}
    for wanted in ("foldwing/py.typed", "foldwing/_native.pyi", "foldwing/libfoldwing_fmu.so"):
        assert wanted in files
    assert any("LICENSE-MIT" in file for file in files) and any("THIRD_PARTY" in file for file in files)
    assert not any("backend" in file or file.endswith(".in") for file in files)
