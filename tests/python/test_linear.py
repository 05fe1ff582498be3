"""Linear models: against simulations, against their own frequency responses, through python-control."""

import json
import re
import subprocess

import control
import numpy as np
import pytest

import foldwing as fw

HELD = {"fold.release": False}
TORQUE, STRAIN, PATCH = "fold.external_torque", "gauge.root.strain", "load.inner[2].moment.y"


def latched(wing):
    """Linear model of the latched wing in equilibrium, from a moment on the inner wing to root strain and tip."""
    return wing.linearize(inputs=PATCH, outputs=[STRAIN, "tip.position.z"])


def gain(model, frequency_1_s):
    return model.C @ np.linalg.solve(1j * frequency_1_s * np.eye(len(model.A)) - model.A, model.B) + model.D


def test_a_model_says_which_wing_it_is_of(wing):
    held, free = wing.linearize(inputs=TORQUE, outputs=STRAIN, settings=HELD), latched(wing)
    assert held.joints["fold"]["latch"] == "open" and held.joints["fold"]["motion"] == "held"
    assert free.joints["fold"]["latch"] == "closed" and free.is_equilibrium
    assert "fold at 170.0000 deg, held" in repr(held) and "latch closed" in repr(free)
    assert not wing.linearize("start", inputs=TORQUE, outputs=STRAIN).is_equilibrium
    assert wing.linearize(0.05, inputs=TORQUE, outputs=STRAIN).about.startswith("about a state that is not an equilibrium")
    with pytest.raises(fw.UsageError, match="must be start, equilibrium, a time"):
        wing.linearize("rest")


def test_step_response_of_to_control_is_that_of_the_engine(wing):
    """A moment on the inner wing, up and down so that its quadratic part cancels; its cubic part stays below 1e-7 of the response. A step
    excites the fastest modes, up to 4e7 1/s: internal steps of 2 µs resolve their effect on the strain (the error is 8e-7 at 4 µs, 9e-8 at
    1 µs, and 3e-5 with error control at the smallest tolerance).
    """
    model = wing.linearize(inputs=PATCH, outputs=[STRAIN, "tip.position.z"])
    system = model.to_control()
    assert system.input_labels == ["load_inner_2_moment_y"] and system.output_labels == ["gauge_root_strain", "tip_position_z"]
    amount, times = 3e-4, np.linspace(0.0, 0.03, 31)
    response = control.step_response(system, times)

    def run(moment):
        sim = fw.Simulation(wing, [("solver.tolerance", 1e-12), ("solver.max_step", 2e-6)])
        sim.settle(0.0)
        sim[PATCH] = moment
        values = []
        for time in times[1:]:
            sim.step_to(time)
            values.append([sim[STRAIN], sim["tip.position.z"]])
        return np.array(values).T

    engine = np.zeros((2, len(times)))
    engine[:, 1:] = (run(amount) - run(-amount)) / (2 * amount)
    # the strain responds to the torque at once, through D
    error = np.abs(engine[:, 1:] - response.outputs[:, 0, 1:]).max(axis=1) / np.abs(engine).max(axis=1)
    print(f"step response against the engine: {error}")
    assert error.max() < 1e-6


def test_samples_are_those_of_the_step_response(wing):
    model = latched(wing)
    sampled = model.discretize(1e-3)
    response = control.step_response(model.to_control(), np.linspace(0.0, 0.1, 101)).outputs[:, 0]
    state = np.zeros(len(sampled.A))
    for point in range(101):
        output = sampled.C @ state + sampled.D[:, 0]
        assert np.allclose(output, response[:, point], rtol=0, atol=1e-7 * np.abs(response).max(axis=1)), point
        state = sampled.A @ state + sampled.B[:, 0]
    assert sampled.to_control().dt == 1e-3
    with pytest.raises(fw.UsageError, match="already discrete"):
        sampled.discretize(1e-3)


@pytest.mark.parametrize("method", ["balanced", "modal"])
def test_reduction_stays_within_its_bound(wing, method):
    model = latched(wing)
    poles = model.poles()
    grid = np.concatenate([np.geomspace(0.1, 1e6, 300), np.abs(poles.imag[poles.imag > 0])])
    for order in (4, 8, 12):
        small = model.reduce(order, method=method)
        assert len(small.A) <= order
        errors = [np.linalg.norm(gain(model, frequency) - gain(small, frequency), 2) for frequency in grid]
        scale = max(np.linalg.norm(gain(model, frequency), 2) for frequency in grid)
        print(f"{method} {order}: error {max(errors):.2e}, bound {small.error_bound:.2e}, largest gain {scale:.2e}")
        assert max(errors) <= small.error_bound * (1 + 1e-6) + 1e-8 * scale
        assert np.allclose(gain(small, 0.0), gain(model, 0.0), rtol=0, atol=1e-8 * scale)
    assert small.to_control().state_labels[0] == f"{method}_1"
    with pytest.raises(fw.UsageError, match="states cannot be kept: allowed are"):
        model.reduce(1000, method=method)


def test_the_command_reduces_alike(wing, command, tmp_path):
    out = tmp_path / "small.npz"
    options = ["--inputs", PATCH, "--outputs", f"{STRAIN},tip.position.z", "-o", out]
    said = subprocess.run([command, "linearize", wing.file, "--reduce", "8", *options], check=True, capture_output=True, text=True)
    small = latched(wing).reduce(8)
    assert " 8 states of " in said.stdout
    assert float(re.search(r"error bound \(H-infinity\) (\S+?)[;,)\s]", said.stdout)[1]) == pytest.approx(small.error_bound, rel=1e-3)
    file = np.load(out)
    assert np.array_equal(file["A"], small.A) and np.array_equal(file["D"], small.D)
    assert file["error_bound"] == small.error_bound and list(file["state_names"][:2]) == ["balanced_1", "balanced_2"]
    modal = subprocess.run([command, "linearize", wing.file, "--modes", "0", *options], capture_output=True, text=True)
    assert modal.returncode == 2 and "--modes 0: 0 states cannot be kept" in modal.stderr


def test_a_band_keeps_the_slow_modes(wing):
    """In a frequency band the error is the reported one, also between sampled frequencies; without a band the omitted modes are
    reported."""
    model = wing.linearize(inputs="fold.external_torque", outputs=[STRAIN, "tip.position.z", "tip.acceleration.z"])
    band = model.reduce(12, max_frequency_Hz=40.0)
    assert len(band.A) <= 12 and band.error_bound is None and band.accuracy.error.shape == (3, 1)
    slow_Hz = np.abs(model.poles()) / (2.0 * np.pi)
    slow_Hz = slow_Hz[slow_Hz <= 40.0]
    frequencies_1_s = 2.0 * np.pi * np.concatenate([np.linspace(0.0, 40.0, 333), slow_Hz])
    answers = np.array([gain(model, frequency_1_s) for frequency_1_s in frequencies_1_s])
    left = answers - np.array([gain(band, frequency_1_s) for frequency_1_s in frequencies_1_s])
    off = np.abs(left).max(axis=0) / np.abs(answers).max(axis=0)
    print(f"up to 40 Hz off by {off.ravel()}, stated {band.accuracy.error.ravel()}")
    assert np.allclose(off, band.accuracy.error, rtol=0.1, atol=1e-6) and off.max() < 0.02
    assert band.error_in_band == band.accuracy.error.max()
    with pytest.warns(UserWarning, match="the reduced model omits modes at .* Hz; balance for a frequency band"):
        everywhere = model.reduce(2)
    with pytest.warns(UserWarning, match="the reduced model omits modes at .* Hz; keep more states"):
        model.reduce(2, max_frequency_Hz=40.0)
    assert everywhere.accuracy.dropped and everywhere.error_in_band is None
    with pytest.raises(fw.FoldwingError, match="only balanced truncation can be limited to a frequency band"):
        model.reduce(4, method="modal", max_frequency_Hz=10.0)


def test_hankel_singular_values_fall(wing):
    values = latched(wing).hankel_singular_values()
    assert np.all(np.diff(values) <= 0) and values[0] > 0


def test_statics_and_modes_are_those_of_the_command(wing, command):
    import json

    printed = subprocess.run([command, "static", wing.file, "--json", "--set", "fold.release=0"], check=True, capture_output=True)
    rest = wing.static(settings=HELD)
    assert rest.data == json.loads(printed.stdout) and rest.stable
    assert rest.shape("inner").shape[1] == 3 and rest.strain("inner").shape[1] == 4
    printed = subprocess.run([command, "modes", wing.file, "--json", "--count", "4"], check=True, capture_output=True)
    modes = wing.modes(4)
    assert modes.data == json.loads(printed.stdout) and len(modes) == 4
    assert modes.shape(0, "outer").shape == rest.shape("outer").shape
    with pytest.raises(fw.UsageError, match="allowed are"):
        wing.modes(state="rest")


def test_a_lattice_is_linear_in_discrete_time(tmp_path, command):
    """With a lattice the model has the aerodynamic step; a gust is an input by its names or prefix; reductions preserve the step and their
    error bound; modes are rejected without an option of the command line."""
    text = open("examples/models/folding_wing_in_tunnel.toml").read()
    for old, new in [
        ("strips = 10", "strips = 3"),
        ("chord_panels = 4", "chord_panels = 2"),
        ("wake_rows = 30", "wake_rows = 10"),
        ("step_s = 1.25e-3", "step_s = 2.5e-3"),
        ("elements = 4", "elements = 2"),
    ]:
        assert old in text, old
        text = text.replace(old, new)
    path = tmp_path / "wing.toml"
    path.write_text(text)
    wing = fw.load(path)
    printed = subprocess.run([command, "modes", str(path), "--lattice", "--json", "--count", "4"], check=True, capture_output=True)
    modes = wing.modes(4, lattice=True)
    assert modes.data == json.loads(printed.stdout) and len(modes) == 4
    assert not np.array_equal(modes.eigenvalues_1_s, wing.modes(4).eigenvalues_1_s)
    with pytest.raises(fw.UsageError, match="lattice=True: the undeformed state has no loads"):
        wing.modes(lattice=True, state="undeformed")
    whole = wing.linearize(inputs=["gust.z", "wind.velocity.z"], outputs=STRAIN, lattice=True)
    assert whole.dt == 2.5e-3 and [signal.name for signal in whole.inputs] == ["wind.velocity.z", "gust.z"]
    for prefix in ["gust.", "gust.*"]:
        gusts = wing.linearize(inputs=prefix, outputs=STRAIN, lattice=True)
        assert [signal.name for signal in gusts.inputs] == ["gust.x", "gust.y", "gust.z"]
        assert np.array_equal(gusts.B[:, 2], whole.B[:, 1])
    small = whole.reduce(12)
    assert small.dt == whole.dt and small.A.shape == (12, 12)

    def answer(model, frequency_1_s):
        z = np.exp(1j * frequency_1_s * model.dt)
        return model.C @ np.linalg.solve(z * np.eye(len(model.A)) - model.A, model.B) + model.D

    for frequency_1_s in [0.1, 10.0, 100.0, 1000.0]:
        off = np.linalg.norm(answer(small, frequency_1_s) - answer(whole, frequency_1_s), 2)
        assert off <= small.error_bound * (1 + 1e-6), frequency_1_s
    with pytest.raises(fw.FoldwingError, match="balanced truncation only, not by modal truncation"):
        whole.reduce(4, method="modal")
    # for a band: the error is the reported one, also between sampled frequencies
    band = whole.reduce(10, max_frequency_Hz=30.0)
    assert band.dt == whole.dt and len(band.A) <= 10 and band.error_bound is None
    frequencies_1_s = 2.0 * np.pi * np.linspace(0.0, 30.0, 77)
    answers = np.array([answer(whole, frequency_1_s) for frequency_1_s in frequencies_1_s])
    left = answers - np.array([answer(band, frequency_1_s) for frequency_1_s in frequencies_1_s])
    off = np.max(np.abs(left).max(axis=0) / np.abs(answers).max(axis=0))
    assert off == pytest.approx(band.error_in_band, rel=0.05, abs=1e-6) and off < 0.01
    for hertz in [0.0, 200.0, float("nan")]:
        with pytest.raises(fw.UsageError, match="the upper end of the frequency band must be above 0 Hz, and in discrete time below half the sampling rate"):
            whole.reduce(4, max_frequency_Hz=hertz)


def test_gusts_are_inputs_with_strips(tmp_path, command):
    """The columns of a uniform gust are those of the command; selected alone, by prefix, and without linear aerodynamics an error that
    names the supported models."""
    goland = fw.load("examples/models/goland_wing.toml")
    file = tmp_path / "goland.json"
    words = ["linearize", "examples/models/goland_wing.toml", "--inputs", "gust.z,wind.velocity.z", "--outputs", "tip.position", "-o", file, "--quiet"]
    subprocess.run([command, *map(str, words)], check=True, capture_output=True)
    written = json.loads(file.read_text())
    model = goland.linearize(inputs=["gust.z", "wind.velocity.z"], outputs="tip.position")
    assert [signal.name for signal in model.inputs] == [signal["name"] for signal in written["inputs"]]
    assert "gust.z" in {signal.name for signal in model.inputs} and np.array_equal(model.B, np.array(written["B"]))
    assert [signal.name for signal in goland.linearize(inputs="gust.", outputs="tip.position").inputs] == ["gust.x", "gust.y", "gust.z"]
    with pytest.raises(fw.UsageError, match="have gusts as inputs"):
        fw.load("examples/models/folding_wing.toml").linearize(inputs="gust.z", outputs=STRAIN)
