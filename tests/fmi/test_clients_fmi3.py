"""`foldwing run` with FMUs of FMI 3.0: Foldwing's own, and one in C with a variable of every type."""

import os
import shutil
import subprocess
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest
from conftest import MODELS, ROOT
from test_clients_run import numbers, run, runner  # noqa: F401, the fixture
from test_fmi3 import axes, third  # noqa: F401, the fixture

PLATFORM = {"linux": "x86_64-linux", "win": "x86_64-windows", "darwin": "x86_64-darwin"}[fmpy.system]
LIBRARY = f"binaries/{PLATFORM}/types{fmpy.sharedLibraryExtension}"
DESCRIPTION = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="Types" instantiationToken="{types}">
  <CoSimulation modelIdentifier="types" canHandleVariableCommunicationStepSize="true" hasEventMode="true"/>
  <UnitDefinitions><Unit name="K"><BaseUnit K="1"/><DisplayUnit name="degC" offset="-273.15"/></Unit></UnitDefinitions>
  <TypeDefinitions>
    <Float64Type name="Heat" unit="K" max="1000"/>
    <EnumerationType name="Gear"><Item name="park" value="1"/><Item name="drive" value="4"/></EnumerationType>
  </TypeDefinitions>
  <DefaultExperiment stopTime="0.5" stepSize="0.1"/>
  <ModelVariables>
    <Float64 name="time" valueReference="0" causality="independent" variability="continuous"/>
    <Float32 name="f32" valueReference="1" causality="input" start="0"/>
    <Float64 name="f64" valueReference="2" causality="input" declaredType="Heat" start="0"><Alias name="heat"/></Float64>
    <Int8 name="i8" valueReference="3" causality="parameter" variability="tunable" start="0"/>
    <UInt8 name="u8" valueReference="4" causality="parameter" variability="tunable" start="0"/>
    <Int16 name="i16" valueReference="5" causality="parameter" variability="tunable" start="0"/>
    <UInt16 name="u16" valueReference="6" causality="parameter" variability="tunable" start="0"/>
    <Int32 name="i32" valueReference="7" causality="input" start="0" max="1000"/>
    <UInt32 name="u32" valueReference="8" causality="parameter" variability="tunable" start="0"/>
    <Int64 name="i64" valueReference="9" causality="parameter" variability="tunable" start="0"/>
    <UInt64 name="u64" valueReference="10" causality="parameter" variability="tunable" start="0"/>
    <Boolean name="flag" valueReference="11" causality="input" start="false"/>
    <String name="text" valueReference="12" causality="parameter" variability="tunable"><Start value="none"/></String>
    <Enumeration name="gear" valueReference="13" causality="parameter" variability="tunable" declaredType="Gear" start="1"/>
    <Float64 name="matrix" valueReference="14" causality="input" start="1 2 3 4 5 6">
      <Dimension valueReference="22"/><Dimension start="3"/><Annotations><Annotation type="x">y</Annotation></Annotations>
    </Float64>
    <Boolean name="flags" valueReference="15" causality="parameter" variability="tunable" start="false true">
      <Dimension start="2"/>
    </Boolean>
    <String name="texts" valueReference="16" causality="parameter" variability="tunable">
      <Dimension start="2"/><Start value="a"/><Start value="b"/>
    </String>
    <Int32 name="mode" valueReference="17" causality="parameter" variability="tunable" start="0"/>
    <Float64 name="y" valueReference="18" causality="output"><Dimension valueReference="22"/><Dimension start="3"/></Float64>
    <Float64 name="from_file" valueReference="19" causality="output"/>
    <Float64 name="matrix_calls" valueReference="20" causality="output"/>
    <Binary name="bytes" valueReference="21" causality="output"/>
    <UInt64 name="length" valueReference="22" causality="structuralParameter" variability="fixed" start="2"/>
  </ModelVariables>
  <ModelStructure><Output valueReference="18"/></ModelStructure>
</fmiModelDescription>
"""
ALL = ["f32", "f64", "i8", "u8", "i16", "u16", "i32", "u32", "i64", "u64", "flag", "text", "gear"]


@pytest.fixture(scope="module")
def make(tmp_path_factory):
    """Writes variants of the FMU."""
    folder = tmp_path_factory.mktemp("types")
    compiler = shutil.which("cc")
    if compiler is None:
        assert os.environ.get("CI") != "true", "no C compiler"
        pytest.skip("no C compiler `cc` on this machine")
    headers, library = Path(fmpy.__file__).parent / "c-code", folder / "types.so"
    source = ROOT / "tests/fmi/types_fmu3.c"
    subprocess.run([compiler, "-shared", "-fPIC", f"-I{headers}", "-o", library, source], check=True)

    def write(name="types", description=DESCRIPTION):
        path = folder / f"{name}.fmu"
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr("modelDescription.xml", description)
            archive.writestr(LIBRARY, library.read_bytes())
            archive.writestr("resources/numbers/value.txt", "42.5")
        return path

    return write


@pytest.mark.parametrize("model", MODELS)
def test_f320_our_fmus_give_the_same_digits_in_both_versions(model, runner, third, fmus):  # noqa: F811
    """F-320. `foldwing run` writes the same digits for the FMU of FMI 3.0 as for that of FMI 2.0, for every shipped model; elements of
    arrays are columns with indices."""
    second = fmus[model]
    step_s = float(second.description.defaultExperiment.stepSize)
    grid = ["-q", "--stop", repr(10 * step_s), "--step", repr(step_s)]
    old, _ = run(runner, second.path, *grid)
    new, _ = run(runner, third(model).path, *grid)
    assert new.pop("time") == old.pop("time")
    # the same signals in the same order, except for signals of several stations, whose keys are adjacent in arrays
    assert len(new) == len(old)
    assert sorted(map(tuple, new.values())) == sorted(map(tuple, old.values()))
    for name in set(new) & set(old):
        assert new[name] == old[name], name
    tip = next(name for name in old if name.endswith(".position.z"))
    assert new[tip.removesuffix(".z") + "[3]"] == old[tip]


def test_f321_loads_and_start_values_act_as_in_fmi_2(runner, third, fmus, tmp_path):  # noqa: F811
    """F-321. A load at a station over time, a torque and a start angle in degrees give the digits of FMI 2.0. The rest of the array keeps
    its start value."""
    results = []
    for fmu, force, gravity in [
        (fmus["folding_wing"].path, "load.outer[3].force.z", "gravity.x"),
        (third("folding_wing").path, "load.outer.force[3,3]", "gravity[1]"),
    ]:
        inputs = tmp_path / "in.csv"
        inputs.write_text(f'time,"{force}",fold.external_torque\n0,0,0\n0.05,0.4,0.01\n')
        columns, _ = run(
            runner, fmu, "--inputs", inputs, "--set", "fold.start_angle=100 deg", "--set", f"{gravity}=0.5",
            "--set", "fold.release=1", "--stop", 0.05, "--step", 1e-3, "--tolerance", 1e-6, "--variables", "fold.angle,fold.latched",
        )  # fmt: skip
        results.append(columns)
    assert results[0] == results[1]
    assert np.ptp(numbers(results[0]["fold.angle"])) > 0.1


def test_f322_every_type_and_arrays_pass_through(runner, make):  # noqa: F811
    """F-322. A foreign FMU with a variable of each type: values set are read back, to the last digit of 64 bits; elements of an array are
    set together; resources are found; clocks and binary variables are neither read nor set."""
    values = {
        "f32": "0.25", "f64": "20 degC", "i8": "-128", "u8": "255", "i16": "-32768", "u16": "65535", "i32": "-7",
        "u32": "4294967295", "i64": "-9223372036854775808", "u64": "18446744073709551615", "flag": "true",
        "text": "a, \"b\" ö", "gear": "drive", "matrix[1,2]": "-2.5", "matrix[2,3]": "60", "flags[1]": "1", "texts[2]": "second",
    }  # fmt: skip
    settings = [f"--set={name}={value}" for name, value in values.items()]
    names = [*ALL, "heat", "matrix*", "flags[1]", "flags[2]", "texts*", "y*", "from_file"]
    columns, _ = run(runner, make(), *settings, *[f"--variables={name}" for name in names])
    last = {name: column[-1] for name, column in columns.items()}
    expected = {
        "f32": "0.25", "f64": "293.15", "heat": "293.15", "i8": "-128", "u8": "255", "i16": "-32768", "u16": "65535",
        "i32": "-7", "u32": "4294967295", "i64": "-9223372036854775808", "u64": "18446744073709551615", "flag": "1",
        "text": "a, \"b\" ö", "gear": "4", "flags[1]": "1", "flags[2]": "1", "texts[1]": "a", "texts[2]": "second",
        "from_file": "42.5", "matrix_calls": "1.0",
    }  # fmt: skip
    assert {name: last[name] for name in expected} == expected
    matrix = [1.0, -2.5, 3.0, 4.0, 5.0, 60.0]
    for k, value in enumerate(matrix):
        index = f"[{k // 3 + 1},{k % 3 + 1}]"
        assert float(last[f"matrix{index}"]) == value
        assert float(last[f"y{index}"]) == 0.5 * value
    assert "bytes" not in columns
    default, _ = run(runner, make())
    assert list(default) == ["time", *(f"y[{i},{j}]" for i in (1, 2) for j in (1, 2, 3)), "from_file", "matrix_calls"]


def test_f323_inputs_over_time_set_each_array_once_per_step(runner, make, tmp_path):  # noqa: F811
    """F-323. Columns of a CSV are elements of one array: one call per step sets them, with linear interpolation."""
    inputs = tmp_path / "in.csv"
    inputs.write_text('time,"matrix[1,1]","matrix[2,3]",i32\n0,0,0,1\n0.5,5,-5,2\n')
    columns, _ = run(runner, make(), "--inputs", inputs, "--variables", "matrix*,i32,matrix_calls")
    assert np.allclose(numbers(columns["matrix[1,1]"]), [0.0, 0.0, 1.0, 2.0, 3.0, 4.0])
    assert np.allclose(numbers(columns["matrix[2,3]"]), [0.0, 0.0, -1.0, -2.0, -3.0, -4.0])
    assert set(columns["matrix[1,2]"]) == {"2.0"}
    assert columns["matrix_calls"][-1] == "6.0", "once in Initialization Mode, and once before each of five steps"


def test_f324_statuses_end_the_run_as_the_standard_says(runner, make):  # noqa: F811
    """F-324. Warnings are counted, an FMU may end the simulation; every other status ends the run with the rows written until then."""
    fmu = make()
    columns, told = run(runner, fmu, "--set", "mode=1")
    assert len(columns["time"]) == 6 and "3 warnings" in told
    columns, told = run(runner, fmu, "--set", "mode=3")
    assert columns["time"][-1] == "0.25" and "the FMU ended the simulation at 0.25 s" in told
    for mode, word in [
        (2, "fmi3Discard"), (4, "fmi3Error"), (5, "fmi3Fatal"), (6, "a status that FMI does not define"),
        (7, "it ended early, at 0.25 s, although early return was not allowed"),
    ]:  # fmt: skip
        columns, told = run(runner, fmu, "--set", f"mode={mode}", code=3)
        assert columns["time"][-1] == "0.2", mode
        assert "fmi3DoStep from 0.2 s" in told and word in told and "panicked" not in told, told
        assert mode != 4 or "Types: error: it fails" in told
    _, told = run(runner, fmu, "--log")
    assert "Types: note: made" in told
    _, told = run(runner, fmu, "--set", "f64=600", code=1)
    assert "fmi3SetFloat64 of f64 to 600.0: the FMU returned fmi3Discard" in told


def test_f325_slips_are_refused_by_name(runner, make):  # noqa: F811
    """F-325. Errors: values out of range, structural parameters, binary variables, other tokens, inconsistent descriptions."""
    fmu = make()
    for setting, word in [
        ("i8=200", "`200` is out of range; allowed is -128.0 to 127.0"),
        ("u64=-1", "out of range"),
        ("i32=1001", "allowed is -2147483648.0 to 1000.0"),
        ("i64=1.5", "`1.5` is not a whole number"),
        ("f64=2000", "allowed is -inf to 1000.0 K"),
        ("gear=reverse", "not one of park (1), drive (4)"),
        ("length=3", "cannot be set"),
        ("matrix=1", "matrix"),
        ("matrix[3,1]=1", "matrix"),
        ("bytes=00", "cannot be set"),
    ]:
        _, told = run(runner, fmu, "--set", setting, code=2)
        assert word in told, (setting, told)
    _, told = run(runner, fmu, "--variables", "bytes", code=2)
    assert "bytes" in told
    _, told = run(runner, make("token", DESCRIPTION.replace("{types}", "{x}")), code=1)
    assert "fmi3InstantiateCoSimulation returned no instance" in told and "the token is another one" in told
    for name, old, new, word in [
        ("beta", 'fmiVersion="3.0"', 'fmiVersion="3.0-beta.2"', "FMI 3.0-beta.2; only FMI 2.0 and FMI 3.0 can be run"),
        ("starts", 'start="1 2 3 4 5 6"', 'start="1 2 3"', "variable matrix: 3 start values for 6 elements"),
        ("huge", '<Dimension start="3"/></Float64>', '<Dimension start="9999999999"/></Float64>', "variable y: more than 1000000"),
        ("length", '<Dimension valueReference="22"/>', '<Dimension valueReference="99"/>', "a dimension without a length"),
        ("exchange", "CoSimulation", "ModelExchange", "only co-simulation can be run"),
    ]:
        _, told = run(runner, make(name, DESCRIPTION.replace(old, new)), code=1)
        assert word in told, (name, told)
    listing = subprocess.run([runner, "run", fmu, "--list-variables"], check=True, capture_output=True, text=True).stdout
    for line in ["input f32: Float32 = 0", "input matrix[2,3]: Float64 = 6", "parameter gear: Enumeration of park, drive = 1"]:
        assert line in listing.splitlines()
