"""Design and control: numbers of a model that minimise a result of its run, with the exact gradient of the run."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Dict, List, Mapping, Optional, Sequence, Tuple, Union, cast

import numpy as np
from numpy.typing import NDArray

from .errors import ModelError, SimulationError, StaticsError, UsageError
from .gradient import GradientStudies
from .inputs import Stimulus
from .optional import needed
from .trials import Bounds, Found, Trials
from .variable import Settings

if TYPE_CHECKING:
    from .model import Model

Array = NDArray[np.float64]
Objective = Union[str, Mapping[str, float]]
Limits = Mapping[str, Union[float, Tuple[Optional[float], Optional[float]]]]

# factor by which a failed trial shortens the steps around the best point found, from which the search starts again
_SHORTER = 0.3
_MAX_RESTARTS = 12
# fraction of the step bound below which a search has ended inside its bounds
_WITHIN = 0.99
# violation of a constraint, as a fraction of its scale, at which it counts as satisfied at any tolerance
_SATISFIED = 1e-6


class _Failed(Exception):
    """A trial whose run failed or whose values are not allowed."""

    def __init__(self, x: Array, cause: str) -> None:
        super().__init__(cause)
        self.x = x


class _Ended(Exception):
    """The number of runs is used up."""


class Optimum(Found):
    """Numbers with the smallest objective that was found."""

    def __init__(self, trials: Trials, x: Array, results: Dict[str, float], objective: float, search: _Search, message: str) -> None:
        super().__init__(trials, x)
        self.objective = objective
        """The objective."""
        self.results = results
        """Values of the results in objective and constraints, by name; for `peak(...)` the magnitude."""
        self.violation = search.violation(x)
        """Largest violation of a constraint relative to its scale: the larger magnitude of its limits, or 1."""
        self.converged = search.converged
        """Whether the search ended by its tolerance, with the constraints satisfied to this tolerance or to 1e-6 of their scale."""
        self.runs = search.runs
        """Runs of the search, of which `gradients` were differentiated."""
        self.gradients = search.gradients
        """Runs that were differentiated."""
        self.history: Array = np.array(search.history)
        """Objective of each differentiated run, shape (gradients,)."""
        self.message = message
        """Reason for the end of the search."""

    def __repr__(self) -> str:
        results = ", ".join(f"{name} = {value:.6g}" for name, value in self.results.items())
        ended = "" if self.converged else f"; NOT converged: {self.message}"
        return f"<foldwing.Optimum of {self.model.name}: {results}; {len(self.names)} numbers, {self.runs} runs{ended}>"


class _Search:
    """Objective and constraints at scaled numbers; each point is run once."""

    def __init__(self, trials: Trials, objective: Mapping[str, float], limits: Mapping[str, Tuple[float, float]], max_runs: int) -> None:
        self.trials, self.objective, self.max_runs = trials, objective, max_runs
        self.of = list(dict.fromkeys([*objective, *limits]))
        self.limits = limits
        self.runs = self.gradients = 0
        self.history: List[float] = []
        self.converged = False
        self._values: Dict[bytes, Array] = {}
        self._slopes: Dict[bytes, Array] = {}
        self.weights = np.array([objective.get(name, 0.0) for name in self.of])
        self.scales = {name: max(abs(bound) for bound in pair if np.isfinite(bound)) or 1.0 for name, pair in limits.items()}

    def _run(self, x: Array, by: Sequence[str]) -> Tuple[Array, Array]:
        if self.runs >= self.max_runs:
            raise _Ended
        allowed = self.trials.allowed
        if not np.all((allowed[:, 0] <= x) & (x <= allowed[:, 1])):
            raise _Failed(x, "a value that the model does not allow")
        self.runs += 1
        try:
            found = self.trials.gradient(x, self.of, by)
        except (ModelError, SimulationError, StaticsError) as error:
            raise _Failed(x, str(error)) from error
        if len(found.of) != len(self.of):
            raise UsageError(f"objective and constraints: {', '.join(self.of)} select {len(found.of)} results; name each result")
        # for `peak(...)` the magnitude counts
        signs = np.array([-1.0 if name.startswith("peak(") and value < 0.0 else 1.0 for name, value in zip(self.of, found.values)])
        return signs * found.values, signs[:, None] * found.jacobian

    def values(self, x: Array) -> Array:
        """Results, shape (results,)."""
        key = x.tobytes()
        if key not in self._values:
            self._values[key], _ = self._run(x, ())
        return self._values[key]

    def slopes(self, x: Array) -> Array:
        """Derivatives of the results with respect to the numbers, shape (results, numbers)."""
        key = x.tobytes()
        if key not in self._slopes:
            self._values[key], self._slopes[key] = self._run(x, self.trials.names)
            self.gradients += 1
            self.history.append(float(self.weights @ self._values[key]))
        return self._slopes[key]

    def violation(self, x: Array) -> float:
        """Largest violation of a constraint relative to its scale."""
        values = dict(zip(self.of, self.values(x)))
        over = [max(low - values[name], values[name] - high, 0.0) / self.scales[name] for name, (low, high) in self.limits.items()]
        return float(max(over, default=0.0))

    def merit(self, x: Array, size: float) -> float:
        """Objective divided by its reference size, plus a penalty for violated constraints, to compare points."""
        return float(self.weights @ self.values(x)) / size + 100.0 * self.violation(x)


def optimize(
    model: GradientStudies,
    objective: Objective,
    free: Union[Sequence[str], Bounds],
    *,
    constraints: Optional[Limits],
    start: Optional[Mapping[str, float]],
    inputs: Stimulus,
    stop: Optional[float],
    settings: Settings,
    tolerance: float,
    max_runs: int,
) -> Optimum:
    """See `Model.optimize`."""
    weights = {objective: 1.0} if isinstance(objective, str) else {name: float(weight) for name, weight in objective.items()}
    if not weights:
        raise UsageError("objective: no result is named")
    limits = {name: _limits(name, pair) for name, pair in (constraints or {}).items()}
    trials = Trials(model, free, option="free", results=list(weights), stop=stop, settings=settings, inputs=inputs)
    first = trials.first(start)
    search = _Search(trials, weights, limits, max_runs)
    try:
        search.slopes(first)
    except _Failed as failed:
        # report the error of the run at the start values itself
        if failed.__cause__ is None:
            raise UsageError(f"start: {failed}") from None
        raise failed.__cause__ from None
    scale = _scales(trials, first)
    size = abs(search.history[0]) or 1.0
    best, failure, reach = first, "", np.inf
    message = ""
    for _ in range(_MAX_RESTARTS):
        try:
            outcome = _solve(search, best, scale, size, reach, tolerance)
        except _Failed as failed:
            best, failure = _best(search, best, size), str(failed)
            step = float(np.max(np.abs(failed.x - best) / scale))
            reach = _SHORTER * (step if np.isfinite(step) and step > 0.0 else 1.0)
            continue
        except _Ended:
            best = _best(search, best, size)
            message = f"max_runs={max_runs} is reached"
            break
        # the solver ends at its last iterate, which may be worse than an earlier one
        point = np.clip(outcome.x * scale, trials.bounds[:, 0], trials.bounds[:, 1])
        better = search.merit(point, size) <= search.merit(best, size) - tolerance
        # at the bound of the steps, beyond which trials fail, the objective may still decrease
        within = bool(np.max(np.abs(point - best) / scale) < _WITHIN * reach)
        best = _best(search, point, size)
        if within or not better:
            search.converged = within and bool(outcome.success) and search.violation(best) <= max(_SATISFIED, tolerance)
            message = str(outcome.message) if within else f"trials fail beyond the best point: {failure}"
            break
        reach *= 2.0
    else:
        message = f"trials fail beyond the best point: {failure}"
    results = {name: float(value) for name, value in zip(search.of, search.values(best))}
    return Optimum(trials, best, results, float(search.weights @ search.values(best)), search, message)


def _solve(search: _Search, start: Array, scale: Array, size: float, reach: float, tolerance: float) -> Any:
    """Search from a point, with steps of at most `reach` scales away from it."""
    bounds = search.trials.bounds / scale[:, None]
    near = start / scale
    box = np.column_stack([np.maximum(bounds[:, 0], near - reach), np.minimum(bounds[:, 1], near + reach)])

    def rows(name: str, factor: float, shift: float) -> Tuple[Any, Any]:
        place = search.of.index(name)
        return (
            lambda z: factor * (search.values(z * scale)[place] - shift),
            lambda z: factor * search.slopes(z * scale)[place] * scale,
        )

    restrictions: List[Any] = []
    for name, (low, high) in search.limits.items():
        unit = search.scales[name]
        if low == high:
            value, slope = rows(name, 1.0 / unit, low)
            restrictions.append({"type": "eq", "fun": value, "jac": slope})
            continue
        for bound, sign in ((low, 1.0), (high, -1.0)):
            if np.isfinite(bound):
                value, slope = rows(name, sign / unit, bound)
                restrictions.append({"type": "ineq", "fun": value, "jac": slope})
    return needed("scipy.optimize").minimize(
        lambda z: float(search.weights @ search.values(z * scale)) / size,
        near,
        jac=lambda z: (search.weights @ search.slopes(z * scale)) * scale / size,
        bounds=box,
        constraints=restrictions,
        method="SLSQP",
        options={"maxiter": search.max_runs, "ftol": tolerance},
    )


def _best(search: _Search, point: Array, size: float) -> Array:
    """The best point that was evaluated."""
    points = [np.frombuffer(key) for key in search._values]
    return min([point, *points], key=lambda x: search.merit(x, size))


def _scales(trials: Trials, first: Array) -> Array:
    """Scales of the numbers: a quarter of the distance between their bounds, or the largest value of the same input over time, or the value
    itself."""
    width = 0.25 * (trials.bounds[:, 1] - trials.bounds[:, 0])
    own = np.array([trials.size(name, value) for name, value in zip(trials.names, first)])
    return np.where(np.isfinite(width) & (width > 0.0), width, own)


def _limits(name: str, pair: Any) -> Tuple[float, float]:
    low, high = pair if isinstance(pair, (tuple, list)) else (pair, pair)
    low, high = (-np.inf if low is None else float(low)), (np.inf if high is None else float(high))
    if not low <= high or (np.isinf(low) and np.isinf(high)):
        raise UsageError(f"constraints: {name} has {pair!r}; allowed are a number, or the lower and the upper limit, one of which may be None")
    return low, high
