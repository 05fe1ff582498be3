"""A state feedback designed with `foldwing linearize` damps the wing inside the FMU: examples/damp_latched_wing.py."""

import importlib.util

import numpy as np
import pytest
from conftest import ROOT

PUSH_N, PUSH_S = 0.2, 0.1  # bends the tip by 2 cm: large compared with the vibration of the latch, small enough to be linear
START = {"fold.start_angle": 1e-5, "solver.tolerance": 1e-6}  # latches in the first millisecond, without an impact


def push(time_s):
    """Smooth force on the outer end in N that excites slow modes, and fast ones hardly."""
    return PUSH_N * np.sin(np.pi * time_s / PUSH_S) ** 2 if time_s < PUSH_S else 0.0


@pytest.fixture(scope="module")
def example():
    """The script as a module."""
    spec = importlib.util.spec_from_file_location("damp_latched_wing", ROOT / "examples/damp_latched_wing.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def linear(example, foldwing):
    """A, B, C of the latched wing and its strain in equilibrium."""
    return example.linear_model(foldwing)


@pytest.fixture
def damper(example, linear):
    """The feedback, with its filter at zero."""
    a, b, c, rest = linear
    return example.Damper(*example.flap_modes(a, b, c), rest)


def measured_poles(strain, period_s, order=12):
    """Poles in 1/s of a free decay from its samples only: matrix pencil (Hua and Sarkar 1990).

    Uses every fourth sample, which keeps modes up to 125 Hz distinct; the order allows for modes faster than the first.
    """
    samples = strain[::4]
    windows = np.lib.stride_tricks.sliding_window_view(samples, len(samples) // 2)
    basis = np.linalg.svd(windows, full_matrices=False)[2][:order].T
    shift = np.linalg.lstsq(basis[:-1], basis[1:], rcond=None)[0]
    return np.log(np.linalg.eigvals(shift).astype(complex)) / (4 * period_s)


def nearest(poles, pole):
    """The pole nearest to a given one."""
    return poles[np.argmin(np.abs(poles - pole))]


def ringing(example, result, rest):
    """Strain about equilibrium, after the push and while it is well above the vibration of the latch."""
    first = round(PUSH_S / example.PERIOD_S) + 2
    return result[example.GAUGE][first : first + 800] - rest


def test_f41_feedback_decays_as_designed(example, linear, damper, wing):
    """F-41. First flap mode of the FMU, from its strain: the poles without feedback and with it are within 1 % of those of the linear
    model.

    1 % allows for the nonlinearity, of the order of the square of a deflection of 7 % of the length, and for the vibration of the latch.
    """
    a, b, c, rest = linear
    cases = {"left alone": (None, np.linalg.eigvals(a)), "state feedback": (damper, damper.poles(a, b, c))}
    decays = {}
    for name, (controller, predicted) in cases.items():
        result = example.ring(wing.path, controller, push, stop_s=1.0, **START)
        assert result["fold.latched"][1:].all()
        poles = measured_poles(ringing(example, result, rest), example.PERIOD_S)
        slowest = [pole for pole in predicted if 20.0 < pole.imag < 35.0]
        expected = max(slowest, key=lambda pole: pole.real)
        pole = nearest(poles, expected)
        print(f"F-41 {name}: {pole:.3f} 1/s, predicted {expected:.3f}, off by {abs(pole / expected - 1):.1e}")
        assert abs(pole / expected - 1.0) < 1e-2
        assert pole.real == pytest.approx(expected.real, rel=2e-2)
        decays[name] = -pole.real
    ratio = decays["state feedback"] / decays["left alone"]
    print(f"F-41 decays {ratio:.2f} times as fast")
    assert ratio > 5.0


def test_f42_linear_loop_foretells_the_strain(example, linear, damper, wing):
    """F-42. The closed loop on all states of the linear model, sample by sample, gives the FMU's strain to 3 % of its peak: three times the
    effect of the latch's vibration and the nonlinearity; none of its states grows."""
    a, b, c, rest = linear
    assert damper.poles(a, b, c).real.max() < -0.5
    result = example.ring(wing.path, damper, push, stop_s=1.0, **START)
    twin = example.Damper(*example.flap_modes(a, b, c), rest)
    a, b = example.sampled(a, b)
    state, moment, strain = np.zeros((len(a), 1)), 0.0, [rest]
    for sample in range(len(result) - 1):
        state = a @ state + b @ [[moment], [push(sample * example.PERIOD_S)]]
        strain.append(rest + (c[0] @ state).item())
        moment = twin.moment(strain[-1])
    off = np.abs(result[example.GAUGE] - strain).max() / np.abs(strain).max()
    print(f"F-42 strain off by {off:.1e} of the peak")
    assert off < 3e-2


def test_f43_feedback_stops_the_ringing_after_unfolding(example, linear, damper, wing):
    """F-43. The shipped wing unfolds and latches: with the feedback the strain falls below 5 % of its peak at least four times sooner, the
    feedback removes energy, and the energy balance closes as without it, to 1 % of the largest kinetic energy, as in F-18 at this
    tolerance."""
    rest = linear[3]
    runs = {"left alone": example.ring(wing.path), "state feedback": example.ring(wing.path, damper)}
    settling = {}
    for name, run in runs.items():
        account = run["energy.total"] - run["energy.work"] + run["energy.dissipated"]
        drift = np.ptp(account) / run["energy.kinetic"].max()
        settling[name] = example.settling(run, rest)
        print(f"F-43 {name}: below 5 % after {settling[name]:.3f} s, work {run['energy.work'][-1]:.2e} J, account {drift:.1e}")
        assert drift < 1e-2
    assert settling["left alone"] > 4.0 * settling["state feedback"]
    assert runs["state feedback"]["energy.work"][-1] < 0.0
    # no input does work; the latch closes at the edge of its window, 1e-6 rad from its angle: ½ · 260 N·m/rad · 1e-12
    assert 0.0 <= runs["left alone"]["energy.work"][-1] < 1.31e-10
    assert np.abs(runs["state feedback"][example.ACTUATOR]).max() <= example.LARGEST_MOMENT_N_M
