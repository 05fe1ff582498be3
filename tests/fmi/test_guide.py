"""The scripts in the guide run as printed."""

import re
import shutil
import subprocess
import sys

import numpy as np
import pytest
from conftest import ROOT, from_environment
from scipy.io import loadmat

GUIDE = ROOT / "docs/guide"


def blocks(page, language):
    """Code blocks of a page."""
    return re.findall(rf"```{language}\n(.*?)```", (GUIDE / page).read_text(encoding="utf-8"), flags=re.DOTALL)


@pytest.fixture(scope="module")
def place(foldwing, tmp_path_factory):
    """A folder with the files assumed by the pages: `wing.toml`, `Wing.fmu`, and the outputs of the pages' commands."""
    folder = tmp_path_factory.mktemp("guide")
    shutil.copy(ROOT / "examples/models/folding_wing.toml", folder / "wing.toml")
    shutil.copy(from_environment("FOLDWING_FMUS") / "folding_wing.fmu", folder / "Wing.fmu")
    for page in ["python.md", "simulink.md"]:
        for line in "".join(blocks(page, "sh")).splitlines():
            words = line.split("#")[0].split()
            if words[:1] == ["foldwing"]:
                done = subprocess.run([foldwing, *words[1:]], cwd=folder, capture_output=True, text=True)
                assert done.returncode == 0, f"{line}\n{done.stderr}"
    return folder


def test_f257_scripts_of_the_python_page_run(place):
    """F-257. Each block separately: the run prints a number, the linear model has the requested inputs and outputs."""
    # blocks that use the Python package need another environment
    scripts = [script for script in blocks("python.md", "python") if "import foldwing" not in script]
    assert len(scripts) == 2
    printed = []
    for script in scripts:
        done = subprocess.run([sys.executable, "-c", script], cwd=place, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        printed.append(done.stdout)
    assert abs(float(printed[0])) < 0.1, "from 1.5 rad the wing has unfolded by 0.4 s"
    assert "fold.external_torque" in printed[1] and "tip.position.z" in printed[1], printed[1]


def test_the_fmu_of_the_tutorial_latches_when_its_page_says(foldwing, tmp_path):
    """TU-04. The FMU of the sketched wing, by the page's command and script: latch times of the page."""
    shutil.copy(ROOT / "examples/tutorial/sketch.toml", tmp_path)
    (line,) = re.findall(r"^foldwing (package .*)$", "".join(blocks("tutorial.md", "sh")), flags=re.MULTILINE)
    done = subprocess.run([foldwing, *line.split()], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    (script,) = [script for script in blocks("tutorial.md", "python") if "fmpy" in script]
    done = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0 and f"`{done.stdout.strip()}`" in (GUIDE / "tutorial.md").read_text(encoding="utf-8"), done.stdout + done.stderr


def test_f258_the_matlab_script_finds_its_names(place):
    """F-258. The data that the MATLAB block of simulink.md reads from `linear.mat` exist: fields, inputs and outputs by name."""
    (script,) = blocks("simulink.md", "matlab")
    shutil.unpack_archive(place / "Wing.fmu", place / "Wing", format="zip")
    (path,) = re.findall(r"load\('(.*?)'\)", script)
    linear = loadmat(place / path, simplify_cells=True)
    fields = set(re.findall(r"\bm\.(\w+)", script))
    assert fields >= {"A", "B", "C", "D", "state_names", "input_names", "output_names"} and fields <= set(linear)
    names = {str(name) for key in ["input_names", "output_names"] for name in np.atleast_1d(linear[key])}
    quoted = [text for text in re.findall(r"'([^']*)'", script) if "." in text and "/" not in text and not text.endswith(".fmu")]
    assert set(quoted) == {"tip.position.z", "load.outer[4].force.z", "fold.external_torque"} and set(quoted) <= names
