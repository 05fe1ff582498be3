"""The deployment in the wind tunnel: lattice, strips and no aerodynamics through FMPy; states that contain a wake."""

import multiprocessing
import subprocess
import sys

import numpy as np
import pytest
from conftest import ROOT
from driving import Fmu, answer_of, instance
from test_state import continue_elsewhere

sys.path.insert(0, str(ROOT / "studies"))

from tunnel_study import MODEL, PAPER_LATCH_S, PAPER_TIP_M, TIP_TIME_S, air, change  # noqa: E402
from tunnel_study import strips as of_strips  # noqa: E402

BEFORE_LATCH = 164, 1e-3  # steps and their size in s; at 10 m/s the latch closes at 0.166 s
SPANNING_STEP_S = 2e-3  # that of `continue_elsewhere`: neither it nor the aerodynamic step divides the other
STEPS_BEYOND = 8
LATER_SPEED_M_S = 20.0


def packaged(foldwing, folder, name, changes):
    """FMU of the tunnel model with keys changed."""
    text = MODEL.read_text()
    for table, key, value in changes:
        text = change(text, table, key, value)
    model, archive = folder / f"{name}.toml", folder / f"{name}.fmu"
    model.write_text(text)
    subprocess.run([str(foldwing), "package", str(model), "-o", str(archive)], check=True, capture_output=True)
    return Fmu(archive, folder / name)


@pytest.fixture(scope="module")
def tunnel(fmus):
    """FMU of the wing in the tunnel: lattice with a prescribed wake."""
    return fmus["folding_wing_in_tunnel"]


@pytest.fixture(scope="module")
def strips(foldwing, tmp_path_factory):
    """The same wing with strips."""
    return packaged(foldwing, tmp_path_factory.mktemp("strips"), "strips", of_strips())


@pytest.fixture(scope="module")
def free_wake(foldwing, tmp_path_factory):
    """The same wing with a short free wake."""
    return packaged(foldwing, tmp_path_factory.mktemp("free"), "free", air(free_wake="true", wake_rows="8"))


@pytest.fixture(scope="module")
def deployments(wing, tunnel):
    """Runs by wind speed; without aerodynamics at 0."""
    runs = {speed: tunnel.simulate(start_values={"wind.velocity.y": -float(speed)}) for speed in (10, 20)}
    return {0: wing.simulate(), **runs}


def peak(result):
    """Largest magnitude of the root strain."""
    return np.abs(result["gauge.root.strain"]).max()


def test_f60_deployment_in_the_wind_tunnel(deployments):
    """F-60. Latch at 10 and 20 m/s within 3 % of the paper's simulation, tip at 0.2 s and 10 m/s within 15 %; the peak
    strain falls with the speed.

    The tolerances are the project's targets. docs/tables/tunnel.md gives the effect of each choice of the model: core radius and wall alone
    change the latch time by 1 to 2 %.
    """
    for speed in (10, 20):
        result = deployments[speed]
        latch_s = result["fold.latch_time"][-1]
        print(f"{speed} m/s: latch at {latch_s:.5f} s, peak strain {peak(result):.4e}")
        assert result["fold.latch_count"][-1] == 1
        assert latch_s == pytest.approx(PAPER_LATCH_S[speed], rel=0.03)
    tip_m = np.interp(TIP_TIME_S, deployments[10]["time"], deployments[10]["tip.position.z"])
    print(f"tip at {TIP_TIME_S} s: {tip_m:.4f} m")
    assert tip_m == pytest.approx(PAPER_TIP_M, rel=0.15)
    assert peak(deployments[0]) > peak(deployments[10]) > peak(deployments[20])


def test_f61_strips_and_lattice_slow_the_wing(deployments, strips):
    """F-61. All three aerodynamic models run to the end; air slows the wing, strips without finite-span effects more than the lattice."""
    result = strips.simulate()
    latch_s = {name: run["fold.latch_time"][-1] for name, run in {**deployments, "strips": result}.items()}
    print(f"latch times {latch_s}")
    assert all(np.isfinite(result[name]).all() for name in result.dtype.names)
    assert latch_s[0] < latch_s[10] < latch_s["strips"]
    assert np.abs(result["aero.force.z"]).max() > 0.05  # N; an eighth of the plates' weight


@pytest.mark.parametrize("air", ["tunnel", "free_wake", "strips"])
def test_f62_restored_state_with_air_repeats_bit_for_bit(air, request):
    """F-62. Steps that include the latching and a change of the wind, repeated from a restored state, give identical outputs: the wake and
    the lag states are part of the state."""

    def onwards(fmu):
        first = fmu.history(2, SPANNING_STEP_S)
        fmu.set("wind.velocity.y", -LATER_SPEED_M_S)
        return first + fmu.history(STEPS_BEYOND, SPANNING_STEP_S)

    with instance(request.getfixturevalue(air)) as fmu:
        fmu.initialize().advance(*BEFORE_LATCH)
        at, standing = fmu.time_s, fmu.bits()
        before = fmu.slave.getFMUstate()
        first = onwards(fmu)
        for excursion in (0, 20):
            fmu.advance(excursion, 1e-3)
            fmu.slave.setFMUstate(before)
            fmu.time_s = at
            assert fmu.bits() == standing
            assert onwards(fmu) == first
        fmu.slave.freeFMUstate(before)
    assert len(set(first)) == len(first)


@pytest.mark.parametrize("air", ["tunnel", "strips"])
def test_f63_serialised_state_with_air_continues_in_another_process(air, request, tmp_path):
    """F-63. A state with aerodynamics, restored in another process, continues bit-identically past the latch."""
    model = request.getfixturevalue(air)
    with instance(model) as fmu:
        fmu.initialize().advance(*BEFORE_LATCH)
        at = fmu.time_s
        state = fmu.slave.getFMUstate()
        serialized = fmu.slave.serializeFMUstate(state)
        fmu.slave.freeFMUstate(state)
        here = fmu.history(STEPS_BEYOND, SPANNING_STEP_S)
    context = multiprocessing.get_context("spawn")  # inherits nothing
    queue = context.Queue()
    other = context.Process(
        target=continue_elsewhere, args=(model.path, str(tmp_path), serialized, at, STEPS_BEYOND, queue), daemon=True
    )
    other.start()
    assert answer_of(other, queue) == here


def test_f64_communication_step_does_not_move_the_latch_in_wind(tunnel):
    """F-64. With a steady wind the aerodynamic steps do not depend on the communication step: latch times agree to the accuracy with which
    the latch is located (F-16's 2e-5 s is for a variable step; here 1e-9 s)."""
    latch_s = [
        tunnel.simulate(stop_time=0.18, output_interval=step_s)["fold.latch_time"][-1] for step_s in (5e-4, 2.3e-3, 9e-3)
    ]
    print(f"spread {max(latch_s) - min(latch_s):.1e} s")
    assert max(latch_s) - min(latch_s) < 1e-9
