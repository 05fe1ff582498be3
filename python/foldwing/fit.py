"""Identification of numbers of a model from measurements."""

from __future__ import annotations

from typing import Any, Dict, List, Mapping, Optional, Sequence, Tuple, Union

import numpy as np
from numpy.typing import NDArray

from . import _native
from .errors import ModelError, SimulationError, StaticsError, UsageError
from .gradient import Gradient, GradientStudies
from .inputs import Stimulus
from .trials import Found, Trials
from .variable import Settings

Array = NDArray[np.float64]

_LOSSES = ("linear", "soft_l1", "huber", "cauchy", "arctan")


class Fit(Found):
    """Identified numbers with their uncertainty."""

    def __init__(self, trials: Trials, outcome: Mapping[str, Any], measured: Measured) -> None:
        super().__init__(trials, np.asarray(outcome["x"], dtype=np.float64))
        names = self.names
        self.residuals: Array = np.asarray(outcome["residuals"], dtype=np.float64)
        """Differences from the measurements divided by their standard deviation or scale, shape (measurements,)."""
        self.measurements = measured.names
        """Name of each measurement; `NAME@TIME` for a value of a column."""
        self.runs = int(outcome["runs"])
        """Runs of the search."""
        self.converged = bool(outcome["converged"])
        """Whether the search ended by one of its tolerances and not by `max_runs`."""
        self.message = str(outcome["message"])
        """Reason for the end of the search."""
        self.noise = float(outcome["noise"])
        """Estimated noise in units of `sigma` or of the scale; 1 if `sigma` was given."""
        self.unidentified: List[Dict[str, float]] = [dict(zip(names, row)) for row in outcome["undetermined"]]
        """Directions in the space of the numbers, relative to their magnitudes, that the measurements do not
        determine."""
        self.covariance: Array = np.array(outcome["covariance"], dtype=np.float64)
        """Covariance of the values, shape (numbers, numbers); NaN if a direction is not determined."""
        self.standard_errors: Array = np.sqrt(np.diag(self.covariance))
        """Standard errors of the values, shape (numbers,)."""

    @property
    def correlation(self) -> Array:
        """Correlation of the values, shape (numbers, numbers)."""
        return self.covariance / np.outer(self.standard_errors, self.standard_errors)

    def __repr__(self) -> str:
        rows = (f"{name} = {value:.6g} ± {error:.2g}" for name, value, error in zip(self.names, self.values, self.standard_errors))
        ended = "" if self.converged else f"; NOT converged: {self.message}"
        weak = f"; {len(self.unidentified)} direction(s) not determined" if self.unidentified else ""
        return f"<foldwing.Fit of {self.model.name}: {', '.join(rows)}; {self.runs} runs{ended}{weak}>"


class Measured:
    """Measurements as results of a run, with their values and scales."""

    def __init__(self, data: Any, sigma: Union[None, float, Mapping[str, float]]) -> None:
        self.names: List[str] = []
        """Results, as `of` of `Model.gradient`."""
        values: List[float] = []
        scales: List[float] = []
        self.has_sigma = sigma is not None
        columns, times = _columns(data)
        for name, column in columns.items():
            given = np.asarray(column, dtype=np.float64)
            if given.ndim == 0:
                rows, own = [name], given.reshape(1)
            elif given.shape == (len(times),):
                there = np.isfinite(given)
                rows, own = [f"{name}@{float(time)!r}" for time in times[there]], given[there]
            else:
                raise UsageError(f"data: {name} has the shape {given.shape}; allowed are a number and ({len(times)},), one value per time")
            scale = _sigma(sigma, name)
            if scale is None:
                scale = float(np.max(np.abs(own), initial=0.0)) or 1.0
            self.names += rows
            values += own.tolist()
            scales += [scale] * len(rows)
        if not self.names:
            raise UsageError("data: there is no measurement")
        self.values: Array = np.array(values)
        """Measured values, shape (measurements,)."""
        self.scales: Array = np.array(scales)
        """Standard deviations or scales, shape (measurements,)."""


def _columns(data: Any) -> Tuple[Dict[str, Any], Array]:
    """Columns by name, and the times in s."""
    if hasattr(data, "columns") and hasattr(data, "index"):  # a DataFrame
        columns = {str(name): data[name].to_numpy() for name in data.columns}
        columns.setdefault("time", data.index.to_numpy())
    elif isinstance(data, Mapping):
        columns = {str(name): column for name, column in data.items()}
    else:
        raise UsageError("data: must be a mapping of names to values, or a DataFrame")
    times = np.atleast_1d(np.asarray(columns.pop("time", []), dtype=np.float64))
    arrays = [name for name, column in columns.items() if np.ndim(column) > 0]
    if arrays and not len(times):
        raise UsageError(f"data: {arrays[0]} is an array, but there is no entry `time` in s")
    if not np.isfinite(times).all() or (np.diff(times) <= 0.0).any():
        raise UsageError("data: `time` must increase")
    return columns, times


def _sigma(sigma: Union[None, float, Mapping[str, float]], name: str) -> Optional[float]:
    if sigma is None:
        return None
    if isinstance(sigma, Mapping):
        if name not in sigma:
            raise UsageError(f"sigma: no value for {name}; give one for each measured name, or one number for all")
        sigma = sigma[name]
    if not np.isfinite(sigma) or sigma <= 0.0:
        raise UsageError(f"sigma: {name} is {sigma!r}; a standard deviation must be positive")
    return float(sigma)


def fit(
    model: GradientStudies,
    data: Any,
    free: Union[Sequence[str], Mapping[str, Optional[Tuple[float, float]]]],
    *,
    start: Optional[Mapping[str, float]],
    sigma: Union[None, float, Mapping[str, float]],
    settings: Settings,
    inputs: Stimulus,
    loss: str,
    max_runs: int,
) -> Fit:
    """See `Model.fit`."""
    if loss not in _LOSSES:
        raise UsageError(f"loss={loss!r}: allowed are {', '.join(_LOSSES)}")
    measured = Measured(data, sigma)
    stop = max((float(name.rsplit("@", 1)[1]) for name in measured.names if "@" in name), default=None)
    if any("@" not in name for name in measured.names):
        stop = None  # results over the default run of the model
    trials = Trials(model, free, option="free", results=measured.names, stop=stop, settings=settings, inputs=inputs)
    names = trials.names

    def run(x: Array, by: Sequence[str]) -> Gradient:
        found = trials.gradient(x, measured.names, by)
        if len(found.of) != len(measured.names):
            raise UsageError(f"data: {', '.join(measured.names[:3])} select {len(found.of)} results; name each measurement")
        return found

    first = trials.first(start)
    if len(measured.values) < len(names):
        raise UsageError(f"data: {len(measured.values)} measurements cannot determine {len(names)} numbers; give more rows, or identify fewer numbers")
    if max_runs < 1:
        raise UsageError(f"max_runs={max_runs!r}: must be at least 1")
    # within the bounds and the range of each variable; the run rejects a start outside the range
    allowed = trials.allowed
    lower = np.minimum(np.maximum(trials.bounds[:, 0], allowed[:, 0]), first)
    upper = np.maximum(np.minimum(trials.bounds[:, 1], allowed[:, 1]), first)

    def residuals(x: Array) -> Optional[Array]:
        # the step is too long if the model rejects the values, or if the run does not contain all results
        # that were measured
        try:
            values = run(x, ()).values
        except (ModelError, SimulationError, StaticsError):
            if np.array_equal(x, first):
                raise
            return None
        return np.asarray((values - measured.values) / measured.scales)

    def jacobian(x: Array) -> Array:
        return np.ascontiguousarray(run(x, names).jacobian / measured.scales[:, None])

    outcome = _native.least_squares(
        residuals, jacobian, first.tolist(), list(zip(lower.tolist(), upper.tolist())), loss, max_runs, measured.has_sigma
    )
    return Fit(trials, outcome, measured)
