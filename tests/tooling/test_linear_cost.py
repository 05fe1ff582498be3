"""The cost of a step is linear in the number of elements: a short form of `make linear-cost`."""
import os
import pathlib
import shutil
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

import linear_cost  # noqa: E402

# Two falling beams on hinges, one of them with a spring.
CHAIN = """\
name = "Chain"
gravity_m_s2 = [0.0, 0.0, -9.8]

[section.strip]
shape = "rectangle"
width_m = 0.05
height_m = 0.004
density_kg_m3 = 2000.0
youngs_modulus_Pa = 6e9
poisson_ratio = 0.3

[body.inner]
length_m = 0.5
section = "strip"
elements = 1
stiffness_damping_s = 1e-3

[joint.shoulder]
type = "revolute"
parent = "root"
child = "inner"
axis = [0.1, 1.0, 0.0]

[body.outer]
length_m = 0.4
section = "strip"
elements = 1
element = "linear"
stiffness_damping_s = 1e-3

[joint.elbow]
type = "revolute"
parent = "inner"
child = "outer"
axis = [0.0, 1.0, 0.0]
start_angle_deg = 30.0

[joint.elbow.spring]
stiffness_N_m_rad = 0.5

[simulation]
step_s = 2e-3
stop_time_s = 0.04
"""


@pytest.mark.long
def test_the_cost_of_an_iteration_is_linear_in_the_elements():
    """X-12. A chain with 8, 16 and 32 elements in each body: the second doubling adds twice as many instructions as the first one, within
    the limit of `make linear-cost`; a quadratic cost would add four times as many. Instructions are counted, not timed."""
    if shutil.which("valgrind") is None:
        pytest.skip("valgrind is not installed (Debian: valgrind): `.ci/run` installs it")
    command = pathlib.Path(os.environ["FOLDWING"])
    costs = [linear_cost.cost(command, CHAIN, linear_cost.BEGIN * factor) for factor in linear_cost.FACTORS]
    ratio = (costs[2] - costs[1]) / (costs[1] - costs[0])
    print(f"X-12: {', '.join(f'{cost:.4g}' for cost in costs)} instructions per iteration, {ratio:.2f}")
    assert 1.0 < ratio <= linear_cost.BOUND, costs
