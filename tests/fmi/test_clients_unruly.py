"""`foldwing run` with a misbehaving FMU or command line: exit codes, messages, the rows written until then."""

import os
import shutil
import subprocess
import zipfile
from pathlib import Path

import fmpy
import pytest
from conftest import ROOT
from test_clients_run import numbers, run, runner  # noqa: F401, the fixture

PLATFORM = {"linux": "linux64", "win": "win64", "darwin": "darwin64"}[fmpy.system]
LIBRARY = f"binaries/{PLATFORM}/unruly{fmpy.sharedLibraryExtension}"
DESCRIPTION = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" fmiVersion="2.0" modelName="Unruly"
    guid="{unruly}">
  <CoSimulation modelIdentifier="unruly" canHandleVariableCommunicationStepSize="false"/>
  <UnitDefinitions><Unit name="K"><BaseUnit K="1"/><DisplayUnit name="degC" offset="-273.15"/></Unit></UnitDefinitions>
  <TypeDefinitions>
    <SimpleType name="Gear">
      <Enumeration><Item name="park" value="1"/><Item name="drive" value="4"/></Enumeration>
    </SimpleType>
  </TypeDefinitions>
  <DefaultExperiment stopTime="0.5" stepSize="0.1"/>
  <ModelVariables>
    <ScalarVariable name="mode" valueReference="0" causality="parameter" variability="fixed">
      <Integer start="0" min="0"/>
    </ScalarVariable>
    <ScalarVariable name="y" valueReference="1" causality="output">
      <Real/>
    </ScalarVariable>
    <ScalarVariable name="u" valueReference="2" causality="input" canHandleMultipleSetPerTimeInstant="true">
      <Real start="0" unit="K" max="400"/>
    </ScalarVariable>
    <ScalarVariable name="gear" valueReference="3" causality="parameter" variability="fixed">
      <Enumeration declaredType="Gear" start="1"/>
    </ScalarVariable>
    <ScalarVariable name="label" valueReference="4" causality="parameter" variability="fixed">
      <String start="none"/>
    </ScalarVariable>
  </ModelVariables>
  <ModelStructure><Outputs><Unknown index="2"/></Outputs></ModelStructure>
</fmiModelDescription>
"""


def compiled(folder, *options):
    """The misbehaving library."""
    compiler = shutil.which("cc")
    if compiler is None:
        assert os.environ.get("CI") != "true", "no C compiler"
        pytest.skip("no C compiler `cc` on this machine")
    target = folder / "unruly.so"
    headers = Path(fmpy.__file__).parent / "c-code"
    source = ROOT / "tests/fmi/unruly_fmu.c"
    subprocess.run([compiler, "-shared", "-fPIC", *options, f"-I{headers}", "-o", target, source], check=True)
    return target.read_bytes()


@pytest.fixture(scope="module")
def make(tmp_path_factory):
    """Writes variants of the FMU: a description, and members by name."""
    folder = tmp_path_factory.mktemp("unruly")
    library = compiled(folder)

    def write(name, description=DESCRIPTION, files=None):
        path = folder / f"{name}.fmu"
        with zipfile.ZipFile(path, "w") as archive:
            if description is not None:
                archive.writestr("modelDescription.xml", description)
            for member, content in ({LIBRARY: library} if files is None else files).items():
                archive.writestr(member, content)
        return path

    return write


def test_f140_statuses_end_the_run_as_the_standard_says(runner, make):  # noqa: F811
    """F-140. Steps from 0.2 s on return each status: warnings continue, an FMU that requests termination ends at its own time, all others
    fail with exit code 3; the rows until then are written. After `fmi2Fatal` the FMU is not even freed (it would abort)."""
    fmu = make("unruly")
    whole, short = [0.0, 0.1, 0.2, 0.3, 0.4, 0.5], [0.0, 0.1, 0.2]
    cases = [
        (0, 0, whole, "Unruly: 0.500000 s simulated"),
        (1, 0, whole, "Unruly: warning: it is 0.2 s, 50%\n"),
        (1, 0, whole, ", 3 warnings\n"),
        (2, 3, short, "fmi2DoStep from 0.2 s: the FMU returned fmi2Discard"),
        (3, 0, [*short, 0.25], "the FMU ended the simulation at 0.25 s"),
        (4, 3, short, "fmi2DoStep from 0.2 s: the FMU returned fmi2Error"),
        (4, 3, short, "Unruly: error: gave up"),
        (5, 3, short, "the FMU returned fmi2Fatal"),
        (6, 3, short, "the FMU returned fmi2Pending, which is not supported, or a status that FMI does not define"),
        (7, 3, short, "the FMU returned fmi2Pending, which is not supported, or a status that FMI does not define"),
    ]
    for mode, code, times, words in cases:
        columns, text = run(runner, fmu, "--set", f"mode={mode}", code=code)
        assert words in text and "panicked" not in text, (mode, text)
        assert numbers(columns["time"]) == pytest.approx(times, abs=1e-12), mode
        assert numbers(columns["y"]) == pytest.approx(times, abs=1e-12), mode


def test_f141_values_of_every_type(runner, make, tmp_path):  # noqa: F811
    """F-141. Units, names of enumeration items and strings are set and read back; informational messages are shown on request."""
    fmu = make("unruly")
    outputs = [argument for name in ["u", "gear", "label"] for argument in ("--variables", name)]
    settings = ["--set", "u=20 degC", "--set", "gear=drive", "--set", "label=two words, one comma"]
    columns, text = run(runner, fmu, *settings, *outputs, "--stop", 0.1, "--log")
    assert numbers(columns["u"]) == pytest.approx([293.15] * 2)
    assert (columns["gear"], columns["label"]) == (["4"] * 2, ["two words, one comma"] * 2)
    assert "Unruly: note: made\n" in text
    _, text = run(runner, fmu, "--stop", 0.1)
    assert "made" not in text
    listing = subprocess.run([runner, "run", fmu, "--list-variables"], capture_output=True, text=True, check=True).stdout
    assert "parameter gear: Enumeration of park, drive = 1\n" in listing and "input u: Real = 0 K\n" in listing


def test_f142_bad_command_lines_are_refused(runner, make, tmp_path):  # noqa: F811
    """F-142. Errors give cause, location and allowed values; nothing is run."""
    fmu = make("unruly")

    def table(name, text):
        (tmp_path / name).write_text(text)
        return ["--inputs", tmp_path / name]

    for code, arguments, words in [
        (2, ["--set", "u"], "--set u: must be NAME=VALUE"),
        (2, ["--set", "gaer=1"], "did you mean `gear`?"),
        (2, ["--set", "zzz=1"], "`foldwing run X.fmu --list-variables` lists the names"),
        (2, ["--set", "y=1"], "`y` cannot be set, it is computed (output)"),
        (2, ["--set", "u=1 m"], "`m` is not one of its units; allowed: K, degC"),
        (2, ["--set", "u=500"], "`500` is out of range; allowed is -inf to 400.0 K"),
        (2, ["--set", "mode=1.5"], "`1.5` is not a whole number"),
        (2, ["--set", "gear=fly"], "`fly` is not one of park (1), drive (4)"),
        (1, ["--set", "mode=8", "--set", "u=1"], "fmi2SetReal of u to 1.0: the FMU returned fmi2Discard"),
        (2, ["--variables", "x"], "no variable is named `x`"),
        (2, ["--stop", "0.25"], "0.25 s is not a whole number of steps of 0.1 s"),
        (2, ["--step", "-1"], "the step must be positive"),
        (2, ["--tolerance", "0"], "--tolerance 0: must be positive"),
        (4, ["--inputs", tmp_path / "none.csv"], "none.csv: cannot be read"),
        (1, table("y.csv", "time,y\n0,1\n"), "y.csv:1: column 2: `y` is not an input"),
        (1, table("u.csv", "time,u\n0,401\n"), "u.csv:2: column 2 (u): `401` is out of range; allowed is -inf to 400.0"),
    ]:
        columns, text = run(runner, fmu, *arguments, code=code)
        assert words in text and "panicked" not in text, (arguments, text)
        assert "y" not in columns or len(columns["y"]) == 0, "no row"


def test_f143_what_cannot_be_run_is_refused(runner, make, wing, tmp_path):  # noqa: F811
    """F-143. No archive, no description, another version or kind, no library, a library that does not load or lacks a function, a GUID that
    the library rejects: exit code 1 and the cause; a missing file: 4."""
    text = DESCRIPTION
    garbage = tmp_path / "garbage.fmu"
    garbage.write_bytes(b"not an archive")
    cut = tmp_path / "cut.fmu"
    cut.write_bytes(Path(wing.path).read_bytes()[:5000])
    without_step = compiled(tmp_path, "-DWITHOUT_DO_STEP")
    exchange = text.replace("<CoSimulation", "<ModelExchange").replace(
        ' canHandleVariableCommunicationStepSize="false"', ""
    )
    for code, fmu, words in [
        (4, tmp_path / "none.fmu", "none.fmu: cannot be read"),
        (1, tmp_path, "not an FMU: a folder"),
        (1, garbage, "garbage.fmu: not an FMU"),
        (1, cut, "cut.fmu: not an FMU"),
        (1, make("empty", None), "not an FMU: no modelDescription.xml in the archive"),
        (1, make("torn", text[:900]), "not an FMU: modelDescription.xml"),
        (1, make("one", text.replace('fmiVersion="2.0"', 'fmiVersion="1.0"')), "FMI 1.0; only FMI 2.0 and FMI 3.0 can be run"),
        (1, make("exchange", exchange), "for model exchange only"),
        (1, make("nameless", text.replace('\n    guid="{unruly}"', "")), "no attribute guid"),
        (1, make("windows", files={"binaries/win32/unruly.dll": b"x"}), "the FMU has win32"),
        (1, make("bare", files={}), "the FMU has no libraries at all"),
        (1, make("broken", files={LIBRARY: b"not a library"}), "cannot be loaded"),
        (1, make("lacking", files={LIBRARY: without_step}), "does not export the function fmi2DoStep"),
        (1, make("stranger", text.replace("{unruly}", "{other}")), "fmi2Instantiate returned no instance"),
        (1, make("stranger", text.replace("{unruly}", "{other}")), "the GUID is {other}, 100% expected {unruly}"),
    ]:
        _, said = run(runner, fmu, code=code)
        assert words in said and "panicked" not in said, (str(fmu), said)


def test_af9_hostile_archives_are_refused(runner, make, tmp_path):  # noqa: F811
    """AF-9. Identifiers and members outside the FMU's folder, links, archives that expand to a large size, and truncated libraries (they
    used to end the process with SIGBUS): exit code 1, the cause, and no files left."""
    library = compiled(tmp_path)
    link = zipfile.ZipInfo("resources/link")
    link.external_attr = 0o120777 << 16
    away = tmp_path / "escaped"
    bomb = tmp_path / "bomb.fmu"
    shutil.copy(make("whole"), bomb)
    with zipfile.ZipFile(bomb, "a", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        with archive.open("resources/zeros", "w", force_zip64=True) as member:
            for _ in range(1025):
                member.write(bytes(1 << 20))

    def called(identifier):
        return DESCRIPTION.replace('modelIdentifier="unruly"', f'modelIdentifier="{identifier}"')

    for fmu, words in [
        (make("absolute", called(tmp_path / "unruly")), "is not a library name; allowed: a C identifier"),
        (make("above", called("../../unruly")), "is not a library name; allowed: a C identifier"),
        (make("out", files={"../escaped": b"x", LIBRARY: library}), "leaves the folder of the FMU"),
        (make("rooted", files={str(away): b"x", LIBRARY: library}), "leaves the folder of the FMU"),
        (make("linked", files={link: b"/etc", LIBRARY: library}), "is a link"),
        (bomb, "more than 1073741824 bytes unpacked"),
        (make("half", files={LIBRARY: library[: len(library) // 2]}), "cut off"),
        (make("tenth", files={LIBRARY: library[: len(library) // 10]}), "cut off"),
    ]:
        _, said = run(runner, fmu, code=1)
        assert words in said and "panicked" not in said, (str(fmu), said)
    assert not away.exists()


def test_f144_command_without_the_feature_says_how_to_get_it(foldwing):
    """F-144. A build without the feature `import` ends with an error in one line."""
    done = subprocess.run([foldwing, "run", "x.fmu", "--csv", "-"], capture_output=True, text=True)
    assert done.returncode == 2 and done.stderr.count("\n") == 1
    assert "`make runner`" in done.stderr and "--features import" in done.stderr
