"""Gradients of runs, and identification of parameters from measurements with them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Dict, List, Mapping, Optional, Sequence, Tuple, TypeVar, Union, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native
from .arguments import checked_methods
from .errors import UsageError
from .inputs import Columns, Stimulus, table_of
from .optional import needed
from .style import heat_map
from .table import written as _written
from .variable import Settings, Start

if TYPE_CHECKING:
    from ._native import InputTable
    from .fit import Fit
    from .model import Model
    from .optimum import Limits, Objective, Optimum

Names = Union[str, Sequence[str]]
_FILE = "file:"
_Self = TypeVar("_Self", bound="GradientStudies")


@checked_methods
class GradientStudies:
    """Methods of `Model` for gradients of runs."""

    _native: _native.Model
    file: str

    def _settings(self, settings: Settings) -> List[Tuple[str, Start]]:
        raise NotImplementedError

    def gradient(
        self,
        of: Names,
        by: Names = (),
        *,
        stop: Optional[float] = None,
        settings: Settings = None,
        mode: str = "auto",
        inputs: Stimulus = None,
    ) -> Gradient:
        """Compute derivatives of results of a run with respect to numbers of the model, as `foldwing gradient`: the exact derivative of the
        discrete run, through latches and end stops.

        Args:
            of: results: a real output at the end of the run (`tip.position.z`) or at a time in s (`tip.position.z@0.2`), its largest
                value, smallest value or value of largest magnitude over the run (`max(...)`, `min(...)`, `peak(...)`), its
                mean or root mean square (`mean(...)`, `rms(...)`), `fold.latch_time` or `fold.latch_impulse`; vectors and patterns represent their components.
            by: real inputs and parameters, constant during the run, inputs over time at a row (`fold.command@0.1`; at a jump `0.1-` and
                `0.1+`) or at all rows (`fold.command@*`), and keys of the model file (`file:body.outer.length_m`); none: only the values.
            stop: stop time in s; default: that of the model.
            settings: start values.
            mode: `forward` (one pass for each number), `adjoint` (one for each result), or `auto`, the cheaper one.
            inputs: inputs over time: a mapping with an entry `time` in s and arrays of the same length, or a DataFrame; reals are
                interpolated linearly between the rows.

        Raises:
            StaticsError: for parts of the model that gradients do not cover, by name, and for events without a derivative.
            UsageError: for names that do not exist.

        >>> from foldwing import load
        >>> wing = load("examples/models/folding_wing.toml")
        >>> slopes = wing.gradient("fold.latch_time", ["fold.motor_stiffness", "file:body.outer.length_m"])
        >>> f"{slopes['fold.latch_time', 'fold.motor_stiffness']:.2f} s/(N·m/rad)"
        '-2.65 s/(N·m/rad)'
        >>> push = {"time": [0.0, 0.05, 0.1], "fold.external_torque": [0.0, 0.01, 0.0]}
        >>> slope = wing.gradient("fold.latch_time", "fold.external_torque@0.05", inputs=push)
        >>> f"{slope['fold.latch_time', 'fold.external_torque@0.05']:.3f} s/(N·m)"
        '0.644 s/(N·m)'
        """
        if mode not in ("auto", "forward", "adjoint"):
            raise UsageError(f"mode={mode!r}: allowed are auto, forward and adjoint")
        given = [f"{name}={_written(value)}" for name, value in self._settings(settings)]
        table, _ = self._input_columns(inputs)
        return Gradient(self._native.gradient(_listed(of), _listed(by), stop, given, mode, table))

    def _input_columns(self, inputs: Stimulus) -> Tuple[Optional[InputTable], Columns]:
        """Table of inputs over time for the extension module, and its columns."""
        if callable(inputs) or (isinstance(inputs, Mapping) and any(callable(course) for course in inputs.values())):
            raise UsageError("inputs: gradients need arrays with an entry `time` in s; sample functions at the times of the rows")
        return table_of(cast("Model", self), inputs, np.zeros(1))

    def with_values(self: _Self, values: Mapping[str, Any]) -> _Self:
        """Return the model with other values of keys of its file.

        Args:
            values: values by key, such as `{"file:body.outer.length_m": 0.3}`; array indices start at 0 (`file:gravity_m_s2.2`).

        Raises:
            UsageError: for keys that do not exist.
            ModelError: for values that the model rejects.

        >>> from foldwing import load
        >>> wing = load("examples/models/folding_wing.toml")
        >>> shorter = wing.with_values({"file:body.outer.length_m": 0.1})
        >>> shorter.name
        'FoldingWing'
        """
        written = [(key, _written(value)) for key, value in values.items()]
        return type(self)(self._native.text_with_values(written), self.file)  # type: ignore[call-arg]

    def fit(
        self,
        data: Any,
        free: Union[Sequence[str], Mapping[str, Optional[Tuple[float, float]]]],
        *,
        start: Optional[Mapping[str, float]] = None,
        sigma: Union[None, float, Mapping[str, float]] = None,
        settings: Settings = None,
        inputs: Stimulus = None,
        loss: str = "linear",
        max_runs: int = 50,
    ) -> Fit:
        """Identify numbers of the model from measurements: nonlinear least squares with the exact Jacobian of the run, as `foldwing
        fit`: the method of Levenberg and Marquardt with bounds.

        Args:
            data: a mapping with an entry `time` in s and arrays of the same length by the names of outputs (NaN: not measured), or a
                DataFrame whose column `time` or index is the time in s; and numbers by results as in `gradient`, such as
                `{"fold.latch_time": 0.122, "max(gauge.root.strain)": 4.1e-3}`.
            free: numbers to identify, as `by` in `gradient`: a list, or bounds by name (`None`: those of the model).
            start: start values of the search by name; default: those of the model.
            sigma: standard deviation of the measurements' noise, a number or by name. Without it residuals are scaled by the largest
                magnitude of each column, and the noise is estimated from the remaining residuals.
            settings: start values of inputs and parameters that are not free.
            inputs: inputs over time, as in `gradient`; their rows may be free (`fold.external_torque@*`).
            loss: `linear`, or a robust loss against outliers (`soft_l1`, `huber`, `cauchy`, `arctan`); they deviate from least squares
                for residuals above 1.
            max_runs: maximum number of runs of the search.

        Raises:
            UsageError: for data without a time, fewer measurements than numbers, names that do not exist, and start values outside their
                bounds.
            ModelError, SimulationError, StaticsError: if the run at the start values fails. If a later run fails, the search takes a
                shorter step.

        >>> from foldwing import load
        >>> wing = load("examples/models/folding_wing.toml")
        >>> truth = wing.simulate(stop=0.1, settings={"fold.motor_damping": 2e-3}, outputs="fold.angle", step=0.01)
        >>> found = wing.fit({"time": truth.time, "fold.angle": truth["fold.angle"]}, ["fold.motor_damping"])
        >>> f"{found['fold.motor_damping']:.6f}"
        '0.002000'
        """
        from .fit import fit

        return fit(self, data, free, start=start, sigma=sigma, settings=settings, inputs=inputs, loss=loss, max_runs=max_runs)


    def optimize(
        self,
        objective: Objective,
        free: Union[Sequence[str], Mapping[str, Optional[Tuple[float, float]]]],
        *,
        constraints: Optional[Limits] = None,
        start: Optional[Mapping[str, float]] = None,
        inputs: Stimulus = None,
        stop: Optional[float] = None,
        settings: Settings = None,
        tolerance: float = 1e-6,
        max_runs: int = 200,
    ) -> Optimum:
        """Find numbers of the model that minimise a result of its run, with the exact gradient of the run (needs SciPy): design of a
        model, or of a command over time.

        Args:
            objective: the result to minimise, as `of` in `gradient`, or weights by result, whose weighted sum is minimised; a negative
                weight maximises a result. For `peak(...)` the magnitude counts, here and in constraints.
            free: numbers to vary, as `by` in `gradient`: a list, or bounds by name (`None`: those of the model). `fold.external_torque@*`
                represents all rows of an input over time.
            constraints: limits of results: a number, or lower and upper limit, of which one may be `None`.
            start: start values of the search by name; default: those of the model and of `inputs`.
            inputs: inputs over time, as in `gradient`.
            stop: stop time in s; default: that of the model.
            settings: start values of inputs and parameters that are not free.
            tolerance: of the objective relative to its start value, and of the constraints relative to their scale.
            max_runs: maximum number of runs of the search.

        The search is SciPy's SLSQP, which is local. If a trial fails (values that the model rejects, a latch that is not reached), the
        search continues from the best point with shorter steps.

        Raises:
            UsageError: for names that do not exist, start values outside their bounds and limits that contradict one another.
            ModelError, SimulationError, StaticsError: if the run at the start values fails.

        >>> from foldwing import load
        >>> wing = load("examples/models/folding_wing.toml")
        >>> found = wing.optimize("peak(gauge.root.strain)", {"fold.motor_damping": (0.0, 2e-3)}, constraints={"fold.latch_time": (None, 0.15)})
        >>> f"{found.results['fold.latch_time']:.3f} s, {found.converged}"
        '0.149 s, True'
        """
        from .optimum import optimize

        return optimize(
            self,
            objective,
            free,
            constraints=constraints,
            start=start,
            inputs=inputs,
            stop=stop,
            settings=settings,
            tolerance=tolerance,
            max_runs=max_runs,
        )


class Gradient:
    """Results of a run with their derivatives. `data` contains the output of `foldwing gradient --json`."""

    def __init__(self, data: Dict[str, Any]) -> None:
        self.data = data
        """Data as printed by the command."""
        self.of: List[str] = [row["name"] for row in data["of"]]
        """Names of the results."""
        self.by: List[str] = [number["name"] for number in data["by"]]
        """Names of the numbers."""
        self.values: NDArray[np.float64] = np.array([row["value"] for row in data["of"]], dtype=np.float64)
        """Values of the results, shape (results,)."""
        self.times_s: NDArray[np.float64] = np.array([row["time_s"] for row in data["of"]], dtype=np.float64)
        """Times of the results in s, shape (results,)."""
        self.numbers: NDArray[np.float64] = np.array([number["value"] for number in data["by"]], dtype=np.float64)
        """Values of the numbers, shape (numbers,)."""
        table = [row["derivatives"] for row in data["of"]]
        self.jacobian: NDArray[np.float64] = np.array(table, dtype=np.float64).reshape(len(self.of), len(self.by))
        """Derivatives in SI units, shape (results, numbers)."""

    def __getitem__(self, names: Tuple[str, str]) -> float:
        of, by = names
        return float(self.jacobian[_place(self.of, of, "result"), _place(self.by, by, "number")])

    def value(self, of: str) -> float:
        """Value of a result."""
        return float(self.values[_place(self.of, of, "result")])

    def vjp(self, cotangents: ArrayLike) -> NDArray[np.float64]:
        """Products of cotangents of the results, shape (results,), with the Jacobian: the gradient of a scalar function of the results with
        respect to the numbers, shape (numbers,)."""
        return np.asarray(np.asarray(cotangents, dtype=np.float64) @ self.jacobian)

    def to_pandas(self) -> Any:
        """Convert to a DataFrame: a row for each result, a column for each number."""
        return needed("pandas").DataFrame(self.jacobian, index=self.of, columns=self.by)

    @property
    def relative(self) -> NDArray[np.float64]:
        """Change of each result in % for 1 % of each number, shape (results, numbers): relative to the magnitude of the result; NaN for
        results and numbers of zero."""
        with np.errstate(divide="ignore", invalid="ignore"):
            found = self.jacobian * self.numbers / np.abs(self.values)[:, None]
        found[(self.values == 0.0)[:, None] | (self.numbers == 0.0)] = np.nan
        return np.asarray(found)

    def plot(self, *, axes: Any = None) -> Any:
        """Plot the sensitivity of each result to each number: `relative` as a heat map (needs Matplotlib). Returns the figure."""
        return heat_map(self.relative.T, self.by, self.of, axes)

    def __repr__(self) -> str:
        size = f"{len(self.of)} results by {len(self.by)} numbers"
        return f"<foldwing.Gradient of {self.data['name']}: {size}, {self.data['steps']} steps, {self.data['mode']}>"


def _listed(names: Names) -> List[str]:
    return [names] if isinstance(names, str) else [str(name) for name in names]


def _place(names: List[str], name: str, kind: str) -> int:
    if name not in names:
        raise KeyError(f"no {kind} is named {name}; available are {', '.join(names)}")
    return names.index(name)
