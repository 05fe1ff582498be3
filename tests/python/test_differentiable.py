"""Runs as functions of JAX and PyTorch, against fourth-order differences of runs. Tests of a library are skipped if it is missing."""

import sys

import numpy as np
import pytest

import foldwing as fw

WING = "examples/models/folding_wing.toml"
NUMBERS = ["fold.motor_damping", "fold.motor_constant_torque", "file:section.plate.youngs_modulus_Pa"]
# Before the latch and with damped strains at a tight tolerance, where differences of runs with independent steps are accurate.
RESULTS = ["fold.angle@0.08", "gauge.root.strain@0.08", "tip.position.x@0.06"]
DAMPED = {"file:solver.tolerance": 1e-11, "file:body.inner.stiffness_damping_s": 1e-4, "file:body.outer.stiffness_damping_s": 1e-4}
WEIGHTS = np.array([1.0, 300.0, -2.0])
X = np.array([8e-4, 0.043, 2.83e9])


def damped():
    return fw.load(WING).with_values(DAMPED)


def loss(results, square):
    """A nonlinear function of the results, with the functions of either library."""
    return square(results[0] * WEIGHTS[0] + results[1] * WEIGHTS[1] + results[2] * WEIGHTS[2]) + results[0] * results[2]


def differences(model):
    """Derivatives of the loss by fourth-order differences of runs with steps of 2e-3, relative to each number."""

    def value(x):
        settings = dict(zip(NUMBERS[:2], map(float, x[:2])))
        run = model.with_values({NUMBERS[2]: float(x[2])}).gradient(RESULTS, stop=0.08, settings=settings)
        return loss(run.values, np.square)

    slopes = []
    for place in range(len(X)):
        shift = np.zeros(len(X))
        shift[place] = 2e-3 * X[place]
        slopes.append((8.0 * (value(X + shift) - value(X - shift)) - (value(X + 2.0 * shift) - value(X - 2.0 * shift))) / (12.0 * shift[place]))
    return np.array(slopes)


def test_grad_of_jax_is_that_of_differences():
    """GR-29, A6: gradient of a loss through a run, with and without compilation, against the run's own gradient."""
    jax = pytest.importorskip("jax", reason="JAX is not installed: its gradients are compared where it is")
    jax.config.update("jax_enable_x64", True)
    model = damped()
    function = fw.jax_function(model, NUMBERS, RESULTS, stop=0.08)

    def through(x):
        return loss(function(x), jax.numpy.square)

    found = np.asarray(jax.grad(through)(X))
    due = differences(model)
    assert np.abs(found * X - due * X).max() < 1e-6 * np.abs(due * X).max(), (found * X, due * X)
    assert np.array_equal(np.asarray(jax.jit(jax.grad(through))(X)), found)
    own = model.gradient(RESULTS, NUMBERS, stop=0.08)
    assert np.asarray(function(X)) == pytest.approx(own.values, rel=1e-12)
    rows = jax.vmap(function)(np.array([X, 1.01 * X]))
    assert rows.shape == (2, 3) and np.array_equal(np.asarray(rows[0]), np.asarray(function(X)))
    assert function(X.astype(np.float32)).dtype == np.float32
    for wrong, cause in [(X[:2], "it must be \\(3,\\), in the order fold.motor_damping"), (np.zeros((1, 3)), "has the shape \\(1, 3\\)")]:
        with pytest.raises(fw.UsageError, match=cause):
            function(wrong)


def test_backward_of_torch_is_that_of_differences():
    """GR-30: the same with PyTorch."""
    torch = pytest.importorskip("torch", reason="PyTorch is not installed: its gradients are compared where it is")
    model = damped()
    function = fw.torch_function(model, NUMBERS, RESULTS, stop=0.08)
    x = torch.tensor(X, dtype=torch.float64, requires_grad=True)
    loss(function(x), torch.square).backward()
    due = differences(model)
    found = x.grad.numpy()
    assert np.abs(found * X - due * X).max() < 1e-6 * np.abs(due * X).max(), (found * X, due * X)
    single = function(x.detach().to(torch.float32))
    assert single.dtype == torch.float32 and not single.requires_grad
    with pytest.raises(fw.UsageError, match="it must be \\(3,\\)"):
        function(torch.zeros(2))
    with pytest.raises(fw.UsageError, match="fold.motor_damping is not finite"):
        function(torch.full((3,), torch.nan, dtype=torch.float64))


def test_rows_of_an_input_are_numbers():
    """Rows of a torque over time through the latching: the derivatives of `Model.gradient`."""
    jax = pytest.importorskip("jax", reason="JAX is not installed: its gradients are compared where it is")
    jax.config.update("jax_enable_x64", True)
    wing = fw.load(WING)
    push = {"time": [0.0, 0.05, 0.1], "fold.external_torque": [0.0, 0.01, 0.0]}
    function = fw.jax_function(wing, ["fold.external_torque@*"], "fold.latch_time", stimulus=push)
    found = np.asarray(jax.jacrev(function)(np.array(push["fold.external_torque"])))
    due = wing.gradient("fold.latch_time", "fold.external_torque@*", inputs=push).jacobian
    assert found.shape == (1, 3) and found == pytest.approx(due, rel=1e-12)


@pytest.mark.parametrize("library", ["jax", "torch"])
def test_a_missing_library_is_named(library, monkeypatch):
    monkeypatch.setitem(sys.modules, library, None)
    function = getattr(fw, f"{library}_function")
    with pytest.raises(ImportError, match=f"{library} is not installed; type: pip install {library}"):
        function(fw.load(WING), NUMBERS, RESULTS)


@pytest.mark.parametrize("library", ["jax", "torch"])
def test_names_that_do_not_fit_are_refused(library):
    pytest.importorskip(library, reason=f"{library} is not installed")
    function = getattr(fw, f"{library}_function")
    with pytest.raises(fw.UsageError, match="select 3 results; name each result"):
        function(fw.load(WING), NUMBERS[:1], "tip.position")
    with pytest.raises(fw.UsageError, match="inputs: no number is named"):
        function(fw.load(WING), [], "fold.angle")
