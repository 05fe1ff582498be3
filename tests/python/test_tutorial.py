"""The tutorial: its model and script are the shipped ones, the output is the one on the page, and the same wing without a file."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import foldwing as fw

PAGE = Path("docs/guide/tutorial.md").read_text(encoding="utf-8")
FOLDER = Path("examples/tutorial")


def blocks(language):
    """Code blocks of the page."""
    return re.findall(rf"```{language}\n(.*?)```", PAGE, flags=re.DOTALL)


def test_the_page_shows_the_shipped_files():
    assert blocks("toml") == [(FOLDER / "sketch.toml").read_text(encoding="utf-8")]
    assert (FOLDER / "alleviate_gust.py").read_text(encoding="utf-8") in blocks("python")


def test_the_feedback_reduces_the_strain_as_the_page_says(tmp_path):
    """TU-01. The line printed by the script is that of the page."""
    for file in FOLDER.iterdir():
        shutil.copy(file, tmp_path)
    done = subprocess.run([sys.executable, "alleviate_gust.py"], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0 and f"prints `{done.stdout.strip()}`" in PAGE, done.stdout + done.stderr


def test_the_wing_without_a_file_is_that_of_the_page(tmp_path):
    """TU-02. Latch times and the absence of flutter are those of the page."""
    (script,) = [script for script in blocks("python") if "from_dict" in script]
    done = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    (first, second) = re.search(r"latched at ([\d.]+) and ([\d.]+) s", done.stdout).groups()
    assert f"it latches at {first} and {second} s" in PAGE and "flutter at [] m/s" in done.stdout


def test_figures_of_the_page():
    """TU-03. Speed of level flight, the state there, latch times of the sweep, flutter: as printed on the page."""
    wing = fw.load(FOLDER / "sketch.toml")
    deployed = {"fold1.start_angle": 0.0, "fold2.start_angle": 0.0}
    trim = wing.trim("wind.velocity.y", {"root.force.z": 41.2}, settings=deployed)
    assert f"{-trim.settings['wind.velocity.y']:.1f} m/s. There" in PAGE
    rest = wing.static(settings={**deployed, "wind.velocity.y": -17.4})
    assert f"strain of the tube {-1e6 * rest.gauges['root']:.0f} µm/m" in PAGE
    assert f"tip is {1e3 * rest.shape('outer')[-1][2]:.0f} mm above" in PAGE
    modes = wing.modes(2, settings={**deployed, "wind.velocity.y": -17.4})
    assert f"at {modes.frequency_Hz[0]:.2f} Hz" in PAGE and f"at {modes.frequency_Hz[1]:.2f} Hz" in PAGE
    torques = "file:joint.fold2.motor.constant_torque_N_m"
    table = wing.sweep({"wind.velocity.y": [-10, -12, -14, -16, -18], torques: [4, 6, 8]}, stop=3.0, outputs="fold2.latch_time")
    latched = table["fold2.latch_time"].reshape(5, 3)
    for row, torque in enumerate((4, 6, 8)):
        cells = " | ".join("–" if time < 0.0 else f"{time:.3f}" for time in latched[:, row])
        assert f"| {torque} N·m | {cells} |" in PAGE
    (flutter,) = re.findall(r"^flutter at ([\d.]+) m/s", PAGE, flags=re.MULTILINE)
    found = wing.flutter([60, 80], count=4, settings=deployed)
    assert abs(found.flutter_m_s[0] - float(flutter)) < 1e-5
