"""The examples of the package agree with the documents."""

import subprocess
import sys

import pytest


def output(*command):
    result = subprocess.run([sys.executable, *command], capture_output=True, text=True)
    assert result.returncode == 0, result.stdout + result.stderr
    return result.stdout.strip()


def test_ten_lines_print_what_the_readme_says():
    said = output("examples/python_ten_lines.py")
    assert said == "latched at 0.2223 s, largest strain 5.29e-03, tip between z = -0.172 and 0.126 m"
    assert said in open("README.md").read()


def test_the_environment_is_one_of_gymnasium():
    """Gymnasium's own check, and a damper that does better than none."""
    sys.path.insert(0, "examples")
    from gymnasium.utils.env_checker import check_env
    from gymnasium_wing import GAIN, LatchedWing, returned

    environment = LatchedWing()
    check_env(environment, skip_render_check=True)
    assert returned(environment, 0.0, 1) == returned(environment, 0.0, 1), "an episode depends on its seed alone"
    assert returned(environment, GAIN, 2) > 0.9 * returned(environment, 0.0, 2)


@pytest.mark.parametrize("notebook", ["latch_damper", "gusts", "reproduce_the_paper", pytest.param("identify", marks=pytest.mark.long)])
def test_notebooks_show_what_they_store(notebook):
    said = output("tools/run_notebook.py", f"examples/{notebook}.ipynb", "--check")
    assert "show what is stored" in said
