"""Processor time of an FMU from `fmi2Instantiate` to the end of the initialisation, called from C."""

import re
import struct
import subprocess
import sys
from pathlib import Path

import pytest
from driving import Instance

LIMIT_MS = 5.0
TRIES = 15

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="builds the importer with the system's cc")


@pytest.fixture(scope="module")
def driver(tmp_path_factory):
    """The importer of run_library.c."""
    program = tmp_path_factory.mktemp("driver") / "run_library"
    source = Path(__file__).with_name("run_library.c")
    subprocess.run(["cc", "-O1", "-Wall", "-Wextra", "-Werror", source, "-o", program, "-ldl"], check=True)
    return program


def run(driver, fmu, references, step_s, steps):
    """Standard output and the start-up time in ms of one run in a new process."""
    library = next(Path(fmu.folder).glob("binaries/linux64/*.so"))
    uri = (Path(fmu.folder) / "resources").as_uri()
    command = [driver, library, uri, fmu.description.guid, str(step_s), str(steps)]
    outcome = subprocess.run(command, input="\n".join(map(str, references)), capture_output=True, text=True)
    assert outcome.returncode == 0, outcome.stderr
    return outcome.stdout, float(re.search(r"started in ([\d.]+) ms", outcome.stderr)[1])


def test_n08_an_instance_starts_within_five_milliseconds(driver, shipped):
    """N-08. Processor time of the start-up of each shipped model, without and with aerodynamics, in a new process: pages of the library are
    not yet loaded. The fastest of a few tries counts, because the limit must not depend on the load of the computer."""
    reference = next(variable.valueReference for variable in shipped.outputs if variable.type == "Real")
    fastest_ms = min(run(driver, shipped, [reference], 1e-3, 0)[1] for _ in range(TRIES))
    print(f"{Path(shipped.path).stem}: {fastest_ms:.2f} ms")
    assert fastest_ms < LIMIT_MS


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
