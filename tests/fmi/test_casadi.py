"""CasADi on Model Exchange FMUs: optimal control with the FMU's derivatives, replayed in co-simulation."""

import sys

import numpy as np
import pytest
from conftest import ROOT, whole

pytest.importorskip("casadi", reason="needs casadi (python/requirements-casadi.txt)")
sys.path[:0] = [str(ROOT / "examples")]

import fastest_unfolding as study  # noqa: E402


@pytest.fixture(scope="module")
def unfolding(foldwing, tmp_path_factory):
    """The equations of the wing with one element per body, and its FMU for co-simulation."""
    folder = tmp_path_factory.mktemp("unfolding")
    wing = study.equations(study.package(foldwing, folder, 1, "me"))
    return wing, study.package(foldwing, folder, 1, "cs")


# intervals; allowed difference of the replayed strain, relative to the bound
@pytest.mark.parametrize("intervals, allowed", [(20, 0.01), pytest.param(60, 0.01, marks=whole)])
def test_ca03_the_fastest_unfolding_is_what_co_simulation_does(unfolding, intervals, allowed):
    """CA-03. IPOPT finds the fastest torque with the FMU's derivatives: it holds the folded wing at first, the strain reaches its bound and
    does not pass it, and co-simulation with that torque has the predicted strain, latches at the predicted time, and is at rest afterwards."""
    wing, fmu = unfolding
    optimum = study.solve(wing, intervals)
    assert optimum.converged
    assert wing.hold * study.TORQUE_LIMIT_N_M == pytest.approx(study.STIFFNESS_N_M_RAD * study.FOLDED_RAD + study.CONSTANT_TORQUE_N_M, rel=0.05)
    assert np.abs(optimum.torque_n_m).max() <= study.TORQUE_LIMIT_N_M * (1 + 1e-6)
    assert np.abs(optimum.strain).max() == pytest.approx(study.BOUND, rel=1e-3)
    run = study.replay(fmu, optimum)
    off, before, after = study.compare(optimum, run)
    assert run["fold.latch_time"][-1] == pytest.approx(optimum.duration_s, abs=5e-3)
    assert off < allowed and before < (1 + allowed) * study.BOUND
    assert after < 0.3 * study.BOUND


def test_ca04_refining_keeps_the_motion():
    """CA-04. On twice as many intervals, states that are cubic in each interval and a torque linear in it have the same values at all times."""
    times = np.array([0.0, *study.casadi.collocation_points(study.POINTS, "radau")])
    intervals, duration_s = 4, 0.3
    wing = study.Wing(None, np.array([1.0, -2.0]), None, None, 0.0)

    def states(s):
        return np.stack([1.0 + 0.3 * s - 0.2 * s**2 + 0.05 * s**3, -2.0 + s**3], axis=-1)

    def torque(s):
        return 0.4 - 0.1 * s

    def unknowns(intervals, step):
        at = (np.arange(intervals)[:, None] + times[1:]).ravel() * step
        return np.r_[duration_s, torque(np.arange(intervals + 1) * step), states(at).ravel()]

    fine = study.refine(wing, unknowns(intervals, 1.0), times)
    assert np.allclose(fine, unknowns(2 * intervals, 0.5), rtol=0.0, atol=1e-13)
