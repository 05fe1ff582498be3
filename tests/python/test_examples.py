"""The examples of the package agree with the documents."""

import subprocess
import sys

import numpy as np
import pytest


def output(*command):
    result = subprocess.run([sys.executable, *command], capture_output=True, text=True)
    assert result.returncode == 0, result.stdout + result.stderr
    return result.stdout.strip()


def test_ten_lines_print_what_the_guide_says():
    said = output("examples/python_ten_lines.py")
    assert said == "latched at 0.2223 s, largest strain 5.29e-03, tip between z = -0.172 and 0.126 m"
    assert said in open("docs/guide/first_scripts.md").read()


def test_the_environment_is_one_of_gymnasium():
    """Gymnasium's environment check, and a damper that performs better than none."""
    sys.path.insert(0, "examples")
    from gymnasium.utils.env_checker import check_env
    from gymnasium_wing import GAIN, LatchedWing, returned

    environment = LatchedWing()
    check_env(environment, skip_render_check=True)
    assert returned(environment, 0.0, 1) == returned(environment, 0.0, 1), "an episode depends on its seed alone"
    assert returned(environment, GAIN, 2) > 0.9 * returned(environment, 0.0, 2)


def test_the_ensemble_filter_converges():
    """F-45, F-46. A constant load is estimated from the noisy gauge, within the standard deviations of the ensemble; the gust is tracked.

    The bounds are twice the largest errors of four seeds: 0.019 N of 0.3 N; in the gust 15.3 % of the deflection (a model without load: 100
    %).
    """
    sys.path.insert(0, "examples")
    from kalman_wing import estimate

    constant = estimate(24, 1, lambda time_s: 0.3)
    half = len(constant.time_s) // 2
    off_N = constant.load_estimate_N[half:] - 0.3
    assert np.sqrt(np.mean(off_N**2)) < 0.04 and constant.covered() > 0.8
    assert np.mean(np.abs(off_N) <= 2.0 * constant.load_deviation_N[half:]) > 0.8
    # the deviations are those of the random walk between two windows, far below the 0.2 N of the start
    assert 0.01 < constant.load_deviation_N[half:].mean() < 0.03
    gust = estimate(24, 1)
    assert gust.tip_error() < 0.3 and gust.load_error_N() < 0.08
    assert output("examples/kalman_wing.py", "--members", "4").startswith("4 members, 400 samples: tip deflection off by ")


@pytest.mark.parametrize("notebook", ["latch_damper", "gusts", "reproduce_the_paper", pytest.param("identify", marks=pytest.mark.long)])
def test_notebooks_show_what_they_store(notebook):
    said = output("tools/run_notebook.py", f"examples/{notebook}.ipynb", "--check")
    assert "show what is stored" in said


def test_a_torque_over_time_closes_the_latch_softly():
    """GR-19. Twelve values already reduce the peak strain to less than half, and the latch closes at the given time, to the search's
    1e-4."""
    sys.path.insert(0, "examples")
    from soft_latch import LATCH, LATCH_S, land

    landing = land(12, max_runs=80)
    assert landing.found.results[LATCH] == pytest.approx(LATCH_S, rel=1e-4)
    assert landing.found.objective < 0.5 * abs(landing.own_peak)
