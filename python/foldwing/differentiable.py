"""Runs of a model as functions that JAX and PyTorch differentiate. Neither library is a dependency."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Callable, List, Optional, Sequence, Union

import numpy as np
from numpy.typing import NDArray

from .errors import UsageError
from .inputs import Stimulus
from .optional import needed
from .trials import Trials
from .variable import Settings

if TYPE_CHECKING:
    from .model import Model

Array = NDArray[np.float64]


class _Runs:
    """Results and their products with cotangents at values of the numbers."""

    def __init__(
        self,
        model: Model,
        inputs: Union[str, Sequence[str]],
        outputs: Union[str, Sequence[str]],
        stop: Optional[float],
        settings: Settings,
        stimulus: Stimulus,
    ) -> None:
        self.of: List[str] = [outputs] if isinstance(outputs, str) else [str(name) for name in outputs]
        self.trials = Trials(model, inputs, option="inputs", results=self.of, stop=stop, settings=settings, inputs=stimulus)
        found = self.trials.gradient(self.trials.values, self.of)
        if len(found.of) != len(self.of):
            raise UsageError(f"outputs: {', '.join(self.of)} select {len(found.of)} results; name each result")

    @property
    def count(self) -> int:
        return len(self.trials.names)

    def checked(self, x: Any) -> Array:
        values = np.asarray(x, dtype=np.float64)
        if values.shape != (self.count,):
            raise UsageError(f"x has the shape {values.shape}; it must be ({self.count},), in the order {', '.join(self.trials.names)}")
        if not np.isfinite(values).all():
            raise UsageError(f"x: {self.trials.names[int(np.argmin(np.isfinite(values)))]} is not finite")
        return values

    def results(self, x: Any) -> Array:
        return self.trials.gradient(self.checked(x), self.of).values

    def product(self, x: Any, cotangents: Any) -> Array:
        weights = np.asarray(cotangents, dtype=np.float64)
        found = self.trials.gradient(self.checked(x), self.of, self.trials.names)
        return found.vjp(weights)


def jax_function(
    model: Model,
    inputs: Union[str, Sequence[str]],
    outputs: Union[str, Sequence[str]],
    *,
    stop: Optional[float] = None,
    settings: Settings = None,
    stimulus: Stimulus = None,
) -> Callable[[Any], Any]:
    """Make a JAX function from runs of a model: `jax.grad`, `jax.vjp`, `jax.jit` and `jax.vmap` apply to it (needs JAX).

    The run is a host callback; its reverse-mode derivative is the exact one of `Model.gradient`. Forward mode (`jax.jvp`) is not
    available. JAX computes with 32 bits unless `jax.config.update("jax_enable_x64", True)` is called first; results and derivatives are
    then rounded.

    Args:
        model: model.
        inputs: numbers of the model, as `by` in `Model.gradient`.
        outputs: results of the run, as `of` in `Model.gradient`.
        stop: stop time in s; default: that of the model.
        settings: start values of inputs and parameters that are not among the numbers.
        stimulus: inputs over time, as `inputs` in `Model.gradient`; their rows may be numbers (`fold.external_torque@*`).

    Returns:
        Function of an array of shape (numbers,) in SI units whose result has the shape (results,).

    Raises:
        ImportError: without JAX.
        UsageError: for names that do not exist, and names that match several results.

    >>> from foldwing import jax_function, load
    >>> wing = load("examples/models/folding_wing.toml")
    >>> latch = jax_function(wing, "fold.motor_stiffness", "fold.latch_time")  # doctest: +SKIP
    >>> jax.grad(lambda x: latch(x)[0])(jax.numpy.array([0.026]))  # doctest: +SKIP
    Array([-2.6456], dtype=float64)
    """
    jax = needed("jax")
    runs = _Runs(model, inputs, outputs, stop, settings, stimulus)

    def host(shape: int, function: Callable[..., Array], x: Any, *further: Any) -> Any:
        # results in the precision of the numbers; the runs of a batch follow one another
        result = jax.ShapeDtypeStruct((shape,), x.dtype)
        rounded = lambda *values: function(*values).astype(values[0].dtype)  # noqa: E731
        return jax.pure_callback(rounded, result, x, *further, vmap_method="sequential")

    def computed(x: Any) -> Any:
        return host(len(runs.of), runs.results, x)

    results = jax.custom_vjp(computed)

    def forward(x: Any) -> Any:
        return results(x), x

    def backward(x: Any, cotangents: Any) -> Any:
        return (host(runs.count, runs.product, x, cotangents),)

    results.defvjp(forward, backward)

    def checked(x: Any) -> Any:
        x = jax.numpy.asarray(x)
        if x.shape != (runs.count,):
            runs.checked(np.zeros(x.shape))
        return results(x if jax.numpy.issubdtype(x.dtype, jax.numpy.floating) else x.astype(float))

    return checked


def torch_function(
    model: Model,
    inputs: Union[str, Sequence[str]],
    outputs: Union[str, Sequence[str]],
    *,
    stop: Optional[float] = None,
    settings: Settings = None,
    stimulus: Stimulus = None,
) -> Callable[[Any], Any]:
    """Make a PyTorch function from runs of a model: `backward` and `torch.autograd.grad` pass through it (needs PyTorch).

    Arguments and errors are those of `jax_function`. The function takes a tensor of shape (numbers,) on any device and returns one of shape
    (results,) with its type and device; runs are computed on the processor in 64 bits. There are no second derivatives.

    Raises:
        ImportError: without PyTorch.
        UsageError: for names that do not exist, and names that match several results.
    """
    torch = needed("torch")
    runs = _Runs(model, inputs, outputs, stop, settings, stimulus)

    def tensor(values: Array, like: Any) -> Any:
        return torch.as_tensor(values, dtype=like.dtype, device=like.device)

    class Results(torch.autograd.Function):  # type: ignore[misc,name-defined]
        @staticmethod
        def forward(context: Any, x: Any) -> Any:
            context.save_for_backward(x)
            return tensor(runs.results(x.detach().cpu().numpy()), x)

        @staticmethod
        @torch.autograd.function.once_differentiable  # type: ignore[untyped-decorator]
        def backward(context: Any, cotangents: Any) -> Any:
            (x,) = context.saved_tensors
            return tensor(runs.product(x.detach().cpu().numpy(), cotangents.detach().cpu().numpy()), x)

    def checked(x: Any) -> Any:
        x = torch.as_tensor(x)
        return Results.apply(x if x.is_floating_point() else x.to(torch.float64))

    return checked
