"""Cost of an FMU from `fmi2Instantiate` to the end of the initialisation, called from C."""

import re
import shutil
import struct
import subprocess
import sys
from pathlib import Path

import pytest
from driving import Instance

# A tenth above `slender_wing`, the slowest one, with 18.3 million instructions; 21.4 million took 5.0 ms, page faults included (2026-11-30).
LIMIT_INSTRUCTIONS = 20.5e6

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="builds the importer with the system's cc")


@pytest.fixture(scope="module")
def driver(tmp_path_factory):
    """The importer of run_library.c."""
    program = tmp_path_factory.mktemp("driver") / "run_library"
    source = Path(__file__).with_name("run_library.c")
    subprocess.run(["cc", "-O1", "-Wall", "-Wextra", "-Werror", source, "-o", program, "-ldl"], check=True)
    return program


def run(driver, fmu, references, step_s, steps, tool=()):
    """Standard output and error of one run in a new process, under `tool`."""
    library = next(Path(fmu.folder).glob("binaries/linux64/*.so"))
    uri = (Path(fmu.folder) / "resources").as_uri()
    command = [*tool, driver, library, uri, fmu.description.guid, str(step_s), str(steps)]
    outcome = subprocess.run(command, input="\n".join(map(str, references)), capture_output=True, text=True)
    assert outcome.returncode == 0, outcome.stderr
    return outcome.stdout, outcome.stderr


def test_n08_instructions_of_the_start_of_an_instance(driver, shipped):
    """N-08. Instantiation and initialisation of each shipped model, without and with aerodynamics, in a new process. Instructions are counted
    in these two calls, because times depend on the computer and its load; the milliseconds are printed."""
    if shutil.which("valgrind") is None:
        pytest.skip("valgrind is not installed (Debian: valgrind): `.ci/run` installs it")
    reference = next(variable.valueReference for variable in shipped.outputs if variable.type == "Real")
    _, timed = run(driver, shipped, [reference], 1e-3, 0)
    calls = [f"--toggle-collect={call}" for call in ("fmi2Instantiate", "fmi2ExitInitializationMode")]
    tool = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", *calls]
    _, counted = run(driver, shipped, [reference], 1e-3, 0, tool)
    instructions = int(re.search(r"I +refs: +([\d,]+)", counted)[1].replace(",", ""))
    print(f"{Path(shipped.path).stem}: {instructions / 1e6:.1f} million instructions, {timed.strip()}")
    assert 1e6 < instructions < LIMIT_INSTRUCTIONS


def test_n09_an_importer_in_c_reads_what_fmpy_reads(driver, wing):
    """N-09. Every Real output over 20 steps is bit-identical: the same library, called by another program."""
    references = [variable.valueReference for variable in wing.outputs if variable.type == "Real"]
    text, _ = run(driver, wing, references, 1e-3, 20)
    instance = Instance(wing).initialize()
    rows = [instance.slave.getReal(references)]
    rows += [instance.advance(1, 1e-3).slave.getReal(references) for _ in range(20)]
    instance.slave.freeInstance()
    expected = [" ".join(struct.pack(">d", value).hex() for value in row) for row in rows]
    assert text.splitlines() == expected
