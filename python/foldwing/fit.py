"""Identification of numbers of a model from measurements."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Dict, List, Mapping, Optional, Sequence, Tuple, Union, cast

import numpy as np
from numpy.typing import NDArray

from .errors import ModelError, SimulationError, StaticsError, UsageError
from .gradient import _FILE, Gradient, GradientStudies
from .optional import needed
from .variable import Start

if TYPE_CHECKING:
    from .model import Model

Array = NDArray[np.float64]

_LOSSES = ("linear", "soft_l1", "huber", "cauchy", "arctan")
# singular values of the scaled Jacobian below this share of the largest: round-off of the gradient and of the run decide the direction
_SINGULAR = 1e-6


class Fit:
    """Identified numbers with their uncertainty.

    Raises:
        KeyError: for names that were not free, in `fit[name]`.
    """

    def __init__(self, model: Model, settings: Mapping[str, Start], names: List[str], outcome: Any, measured: Measured) -> None:
        self.names = names
        """Names of the numbers, in the order of the arrays."""
        self.values: Array = np.asarray(outcome.x, dtype=np.float64)
        """Identified values in SI units, shape (numbers,)."""
        self.residuals: Array = np.asarray(outcome.fun, dtype=np.float64)
        """Differences from the measurements over their standard deviation or scale, shape (measurements,)."""
        self.measurements = measured.names
        """Name of each measurement, `NAME@TIME` for one in a column."""
        self.runs = int(outcome.nfev)
        """Runs of the search."""
        self.converged = bool(outcome.status > 0)
        """Whether the search ended by one of its tolerances and not by `max_runs`."""
        self.message = str(outcome.message)
        """Reason for the end of the search."""
        jacobian = np.asarray(outcome.jac, dtype=np.float64)
        degrees = len(self.residuals) - len(names)
        self.noise = 1.0
        """Estimated noise in units of `sigma` or of the scale; 1 if `sigma` was given."""
        if not measured.has_sigma:
            self.noise = float(np.sqrt(np.sum(self.residuals**2) / degrees)) if degrees > 0 else float("nan")
        size = np.where(self.values == 0.0, 1.0, np.abs(self.values))
        _, singular, directions = np.linalg.svd(jacobian * size, full_matrices=False)
        weak = singular <= _SINGULAR * (singular[0] if len(singular) else 0.0)
        self.unidentified: List[Dict[str, float]] = [dict(zip(names, map(float, row))) for row in directions[weak]]
        """Directions in the numbers, each relative to its size, that the measurements do not determine."""
        inverse = np.full_like(singular, np.inf)
        inverse[~weak] = 1.0 / singular[~weak] ** 2
        covariance = np.full((len(names), len(names)), np.nan)
        if not weak.any():
            covariance = (directions.T * inverse) @ directions * np.outer(size, size) * self.noise**2
        self.covariance: Array = covariance
        """Covariance of the values, shape (numbers, numbers); NaN if a direction is not determined."""
        self.standard_errors: Array = np.sqrt(np.diag(covariance))
        """Their standard errors, shape (numbers,)."""
        self._model, self._given = model, dict(settings)

    def __getitem__(self, name: str) -> float:
        if name not in self.names:
            raise KeyError(f"{name} was not free; there are {', '.join(self.names)}")
        return float(self.values[self.names.index(name)])

    @property
    def settings(self) -> Dict[str, Start]:
        """Given start values merged with the identified inputs and parameters: pass as `settings=` to runs of `model`."""
        found = {name: float(value) for name, value in zip(self.names, self.values) if not name.startswith(_FILE)}
        return {**self._given, **found}

    @property
    def model(self) -> Model:
        """The model with the identified keys of its file."""
        keys = {name: float(value) for name, value in zip(self.names, self.values) if name.startswith(_FILE)}
        return self._model.with_values(keys) if keys else self._model

    @property
    def correlation(self) -> Array:
        """Correlation of the values, shape (numbers, numbers)."""
        return self.covariance / np.outer(self.standard_errors, self.standard_errors)

    def __repr__(self) -> str:
        rows = (f"{name} = {value:.6g} ± {error:.2g}" for name, value, error in zip(self.names, self.values, self.standard_errors))
        ended = "" if self.converged else f"; NOT converged: {self.message}"
        weak = f"; {len(self.unidentified)} direction(s) not determined" if self.unidentified else ""
        return f"<foldwing.Fit of {self._model.name}: {', '.join(rows)}; {self.runs} runs{ended}{weak}>"


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
        raise UsageError(f"data: {arrays[0]} is an array without an entry `time` in s beside it")
    if not np.isfinite(times).all() or (np.diff(times) <= 0.0).any():
        raise UsageError("data: `time` must increase")
    return columns, times


def _sigma(sigma: Union[None, float, Mapping[str, float]], name: str) -> Optional[float]:
    if sigma is None:
        return None
    if isinstance(sigma, Mapping):
        if name not in sigma:
            raise UsageError(f"sigma: {name} has none; give one for each measured name, or one number for all")
        sigma = sigma[name]
    if not np.isfinite(sigma) or sigma <= 0.0:
        raise UsageError(f"sigma: {name} has {sigma!r}; a standard deviation is positive")
    return float(sigma)


def fit(
    model: GradientStudies,
    data: Any,
    free: Union[Sequence[str], Mapping[str, Optional[Tuple[float, float]]]],
    *,
    start: Optional[Mapping[str, float]],
    sigma: Union[None, float, Mapping[str, float]],
    settings: Optional[Mapping[str, Start]],
    loss: str,
    max_runs: int,
) -> Fit:
    """See `Model.fit`."""
    if loss not in _LOSSES:
        raise UsageError(f"loss={loss!r}: allowed are {', '.join(_LOSSES)}")
    measured = Measured(data, sigma)
    bounds = dict(free) if isinstance(free, Mapping) else {str(name): None for name in ([free] if isinstance(free, str) else free)}
    names = list(bounds)
    if not names:
        raise UsageError("free: there is no number to identify")
    given = dict(settings or {})
    unknown = [name for name in (start or {}) if name not in names]
    if unknown:
        raise UsageError(f"start: {unknown[0]} is not free; there are {', '.join(names)}")
    stop = max((float(name.rsplit("@", 1)[1]) for name in measured.names if "@" in name), default=None)
    if any("@" not in name for name in measured.names):
        stop = None  # results over the run of the model

    def run(x: Array, by: Sequence[str]) -> Gradient:
        point = dict(zip(names, map(float, x)))
        keys = {name: value for name, value in point.items() if name.startswith(_FILE)}
        there = model.with_values(keys) if keys else model
        others = {name: value for name, value in point.items() if not name.startswith(_FILE)}
        found = there.gradient(measured.names, by, stop=stop, settings={**given, **others})
        if len(found.of) != len(measured.names):
            raise UsageError(f"data: {', '.join(measured.names[:3])} stand for {len(found.of)} results; name each measurement")
        return found

    own = model.gradient(measured.names[:1], names, stop=stop, settings=given)
    if own.by != names:
        raise UsageError(f"free: {', '.join(names)} stand for {', '.join(own.by)}; name each number")
    first = np.array([(start or {}).get(name, value) for name, value in zip(names, own.numbers)], dtype=np.float64)
    limits = np.array([bounds[name] or (-np.inf, np.inf) for name in names], dtype=np.float64)
    lower, upper = limits[:, 0], limits[:, 1]
    ranges = {name: row.range for name, row in cast("Model", model).variables.items()}
    allowed = np.array([ranges.get(name) or (-np.inf, np.inf) for name in names], dtype=np.float64)
    for place, name in enumerate(names):
        if not lower[place] <= first[place] <= upper[place]:
            raise UsageError(f"start: {name} is {first[place]!r}, outside its bounds {lower[place]!r} to {upper[place]!r}")

    def residuals(x: Array) -> Array:
        # a step too far: values that the model does not allow, or a run without the results; the search tries a shorter one
        too_far = np.full(len(measured.values), np.inf)
        if not np.all((allowed[:, 0] <= x) & (x <= allowed[:, 1])):
            return too_far
        try:
            values = run(x, ()).values
        except (ModelError, SimulationError, StaticsError):
            if np.array_equal(x, first):
                raise
            return too_far
        return np.asarray((values - measured.values) / measured.scales)

    def jacobian(x: Array) -> Array:
        return np.asarray(run(x, names).jacobian / measured.scales[:, None])

    outcome = needed("scipy.optimize").least_squares(
        residuals,
        first,
        jac=jacobian,
        bounds=(lower, upper),
        x_scale=np.where(first == 0.0, 1.0, np.abs(first)),
        loss=loss,
        max_nfev=max_runs,
        xtol=1e-10,
        ftol=1e-12,
        gtol=1e-12,
    )
    return Fit(cast("Model", model), given, names, outcome, measured)
