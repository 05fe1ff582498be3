"""The FMU in fmu-manipulation-toolbox: summary, the toolbox's checks of the standard, and two wings in one container FMU."""

import json
import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest
from conftest import MODELS
from fmpy import simulate_fmu
from fmpy.validation import validate_fmu
from test_clients import STEP_S, STEPS, in_turn
from test_description import members

pytest.importorskip("fmu_manipulation_toolbox", reason="`make pytest` installs fmu-manipulation-toolbox")

# Two wings; the latch of the left one releases the right one, as in examples/two_wings_ssp.py.
CONTAINER = {
    "name": "wings.fmu",
    "step_size": STEP_S,
    "auto_link": False,
    "auto_input": False,
    "auto_output": False,
    "auto_parameter": False,
    "fmu": ["left.fmu", "right.fmu"],
    "link": [["left.fmu", "fold.latched", "right.fmu", "fold.release"]],
    "output": [
        [f"{wing}.fmu", name, f"{wing}.{name}"]
        for wing in ("left", "right")
        for name in ("fold.angle", "fold.latch_time")
    ],
}


def tool(name, *arguments, cwd, faults=False):
    """Output of one of the toolbox's commands; its exit code is the result of its check."""
    command = [str(Path(sys.executable).parent / name), *map(str, arguments)]
    run = subprocess.run(command, capture_output=True, text=True, cwd=cwd)
    assert (run.returncode != 0) == faults, run.stdout + run.stderr
    return run.stdout + run.stderr


# Code that the command `fmutool` runs, for one FMU after the other: starting the command takes longer than its checks.
FMUTOOL = """
import sys
from fmu_manipulation_toolbox.cli.fmutool import fmutool
for path in sys.argv[1:]:
    print("==", path, flush=True)
    sys.argv = ["fmutool", "-input", path, "-summary", "-check"]
    try:
        code = fmutool()
    except SystemExit as end:
        code = end.code
    print("exit code", code or 0, flush=True)
"""


# session scope: pytest groups tests with the same `shipped` across files, and with module scope would start again for each
@pytest.fixture(scope="session")
def checked(fmus, tmp_path_factory):
    """Output of fmutool for every shipped FMU, by its path."""
    command = [sys.executable, "-c", FMUTOOL, *(fmus[model].path for model in MODELS)]
    said = subprocess.run(
        command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, cwd=tmp_path_factory.mktemp("checked")
    )
    assert said.returncode == 0, said.stdout
    parts = re.split(r"^== (.+)$", said.stdout, flags=re.M)
    return dict(zip(parts[1::2], parts[2::2]))


def test_f120_fmutool_finds_nothing(shipped, checked):
    """F-120. `fmutool -summary -check`: every shipped FMU satisfies the schema and the toolbox's rules beyond it."""
    text = checked[shipped.path]
    assert "exit code 0" in text, text
    assert "compliant with FMI-2.0" in text and "No semantic error against the FMI-2 standard" in text
    assert not re.search(r"^(ERROR|CRITICAL)", text, re.MULTILINE), text
    for causality in ("input", "output", "parameter"):
        count = sum(v.causality == causality for v in shipped.description.modelVariables)
        assert not count or re.search(rf"\b{causality} : {count}$", text, re.MULTILINE), causality


def test_f121_fmutool_finds_a_deliberate_fault(wing, tmp_path):
    """F-121. The check of F-120 detects errors: an input without its start value is reported."""
    files = members(wing.path)
    text = files["modelDescription.xml"].decode()
    pattern = r'(<ScalarVariable name="fold.angle_command"[^>]*>\s*<Real[^>]*?) start="[^"]*"'
    broken, count = re.subn(pattern, r"\1", text, count=1)
    assert count == 1
    files["modelDescription.xml"] = broken.encode()
    path = tmp_path / "broken.fmu"
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    assert re.search(r"ERROR.*fold\.angle_command", tool("fmutool", "-input", path, "-check", cwd=tmp_path, faults=True))


@pytest.fixture(scope="module")
def container(fmus, tmp_path_factory):
    """The container FMU, made once."""
    folder = tmp_path_factory.mktemp("container")
    for name in CONTAINER["fmu"]:
        shutil.copy(fmus["folding_wing"].path, folder / name)
    (folder / "wings.json").write_text(json.dumps(CONTAINER))
    tool("fmucontainer", "-container", "wings.json", "-fmu-directory", folder, cwd=folder)
    return folder / "wings.fmu"


def test_f122_container_of_two_wings_is_a_valid_fmu(container):
    """F-122. A container of two Foldwing FMUs by `fmucontainer` passes FMPy's validation, and has the library twice."""
    assert validate_fmu(str(container)) == []
    libraries = [name for name in members(container) if re.search(r"FoldingWing\.(so|dll|dylib)$", name)]
    assert len(libraries) == 2, libraries


def test_f123_container_gives_what_the_wings_give_alone(container, wing):
    """F-123. The container steps its FMUs in parallel and passes values on between steps; direct calls give the same values. Two copies of
    the library in one process share no state.

    The communication points `n h` of the container and the summed ones here differ in their last bits: 1e-12.
    """
    rows = simulate_fmu(str(container), stop_time=STEPS * STEP_S, output_interval=STEP_S, validate=False)
    names = [output[2] for output in CONTAINER["output"]]
    together = np.array([[row[name] for name in names] for row in rows])[1:]
    alone = in_turn(wing, STEPS, STEP_S)
    difference = np.abs(together - alone).max()
    print(f"\nF-123 latches {together[-1, 1]:.6f} and {together[-1, 3]:.6f} s, largest difference {difference:.1e}")
    assert difference < 1e-12
