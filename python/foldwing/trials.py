"""Runs of a model with varied numbers, with their gradients."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Dict, List, Mapping, Optional, Sequence, Tuple, cast

import numpy as np
from numpy.typing import NDArray

from .errors import UsageError
from .gradient import _FILE, Gradient, GradientStudies
from .inputs import Stimulus
from .variable import Settings, Start

if TYPE_CHECKING:
    from .model import Model

Array = NDArray[np.float64]
Bounds = Mapping[str, Optional[Tuple[float, float]]]


class Trials:
    """Numbers of a model that vary from run to run: inputs and parameters, rows of inputs over time, keys of its file.

    Args:
        option: name of the argument with the numbers, for messages.
        results: one of the results, to find the names and values of the numbers.

    Raises:
        UsageError: for names that do not exist, and bounds of several numbers of one input over time given twice.
    """

    def __init__(
        self,
        model: GradientStudies,
        free: Any,
        *,
        option: str,
        results: Sequence[str],
        stop: Optional[float],
        settings: Settings,
        inputs: Stimulus,
    ) -> None:
        self.model, self.stop = model, stop
        self.given: Dict[str, Start] = dict(settings or {})
        # the columns of the inputs: a copy, which trials change
        _, columns = model._input_columns(inputs)
        self.inputs: Optional[Dict[str, Array]] = None
        if columns is not None:
            times, given = columns
            self.inputs = {"time": np.array(times), **{name: np.array(values) for name, values in given.items()}}
        asked: Bounds = dict(free) if isinstance(free, Mapping) else {str(name): None for name in ([free] if isinstance(free, str) else free)}
        if not asked:
            raise UsageError(f"{option}: no number is named")
        own = model.gradient(list(results)[:1], list(asked), stop=stop, settings=self.given, inputs=self.inputs)
        self.names: List[str] = own.by
        """Names of the numbers."""
        self.values: Array = own.numbers
        """Values of the numbers in the model, shape (numbers,)."""
        every = {name.rsplit("@", 1)[0]: limits for name, limits in asked.items() if name.endswith("@*")}
        plain = [name for name in asked if not name.endswith("@*")]
        rows = [name for name in self.names if "@" in name and name.rsplit("@", 1)[0] in every]
        singles = [name for name in self.names if name not in rows]
        if len(singles) != len(plain):
            raise UsageError(f"{option}: {', '.join(plain)} select {', '.join(singles)}; name each number")
        limits = {**{name: every[name.rsplit("@", 1)[0]] for name in rows}, **dict(zip(singles, (asked[name] for name in plain)))}
        pairs = [limits[name] or (-np.inf, np.inf) for name in self.names]
        self.bounds: Array = np.array(pairs, dtype=np.float64)
        """Lower and upper bounds, shape (numbers, 2)."""
        ranges = {name: row.range for name, row in cast("Model", model).variables.items()}
        known = [ranges.get(self._column(name)) or (-np.inf, np.inf) for name in self.names]
        self.allowed: Array = np.array(known, dtype=np.float64)
        """Smallest and largest values that the variables allow, shape (numbers, 2)."""
        self._rows = {name: self._place(name) for name in self.names if "@" in name and not name.startswith(_FILE)}

    @staticmethod
    def _column(name: str) -> str:
        return name if name.startswith(_FILE) else name.rsplit("@", 1)[0]

    def _place(self, name: str) -> Tuple[str, int]:
        """Column and row of a value of an input over time."""
        column, at = name.rsplit("@", 1)
        time, side = (at[:-1], at[-1]) if at[-1] in "+-" else (at, "")
        assert self.inputs is not None, "rows belong to inputs"
        found = np.flatnonzero(self.inputs["time"] == float(time))
        return column, int(found[-1] if side == "+" else found[0])

    def _split(self, x: Array) -> Dict[str, float]:
        return {name: float(value) for name, value in zip(self.names, x)}

    def model_at(self, x: Array) -> Any:
        """Model with the values `x` of the keys of its file."""
        keys = {name: value for name, value in self._split(x).items() if name.startswith(_FILE)}
        return self.model.with_values(keys) if keys else self.model

    def settings_at(self, x: Array) -> Dict[str, Start]:
        """Given start values merged with those of the numbers."""
        own = {name: value for name, value in self._split(x).items() if not name.startswith(_FILE) and name not in self._rows}
        return {**self.given, **own}

    def inputs_at(self, x: Array) -> Optional[Dict[str, Array]]:
        """Inputs over time with the values of the numbers."""
        if self.inputs is None:
            return None
        columns = {name: column.copy() for name, column in self.inputs.items()}
        for name, value in self._split(x).items():
            if name in self._rows:
                column, row = self._rows[name]
                columns[column][row] = value
        return columns

    def first(self, start: Optional[Mapping[str, float]]) -> Array:
        """Values at which a search starts: those of the model, or of `start`.

        Raises:
            UsageError: for names that are not free, and values outside their bounds.
        """
        given = dict(start or {})
        unknown = [name for name in given if name not in self.names]
        if unknown:
            raise UsageError(f"start: {unknown[0]} is not free; free are {', '.join(self.names)}")
        first = np.array([given.get(name, value) for name, value in zip(self.names, self.values)], dtype=np.float64)
        for name, value, (lower, upper) in zip(self.names, first, self.bounds):
            if not lower <= value <= upper:
                raise UsageError(f"start: {name} is {float(value)!r}, outside its bounds {float(lower)!r} to {float(upper)!r}")
        return first

    def size(self, name: str, value: float) -> float:
        """Reference size of a number: the largest value of its input over time, otherwise the value itself, or 1."""
        if name in self._rows and self.inputs is not None:
            return float(np.max(np.abs(self.inputs[self._rows[name][0]]))) or 1.0
        return abs(float(value)) or 1.0

    def gradient(self, x: Array, of: Sequence[str], by: Sequence[str] = (), mode: str = "auto") -> Gradient:
        """Results at other values, with their derivatives with respect to the numbers of `by`."""
        return self.model_at(x).gradient(  # type: ignore[no-any-return]
            of, by, stop=self.stop, settings=self.settings_at(x), inputs=self.inputs_at(x), mode=mode
        )


class Found:
    """Values of the numbers that a search found.

    Raises:
        KeyError: for names that were not free, in `found[name]`.
    """

    def __init__(self, trials: Trials, values: Array) -> None:
        self._trials = trials
        self.names: List[str] = trials.names
        """Names of the numbers, in the order of the arrays."""
        self.values: Array = values
        """Values of the numbers in SI units, shape (numbers,)."""

    def __getitem__(self, name: str) -> float:
        if name not in self.names:
            raise KeyError(f"{name} was not free; free were {', '.join(self.names)}")
        return float(self.values[self.names.index(name)])

    @property
    def settings(self) -> Dict[str, Start]:
        """Given start values merged with the inputs and parameters found: pass as `settings=` to runs of `model`."""
        return self._trials.settings_at(self.values)

    @property
    def inputs(self) -> Optional[Dict[str, Array]]:
        """Given inputs over time with the values found: pass as `inputs=` to runs of `model`."""
        return self._trials.inputs_at(self.values)

    @property
    def model(self) -> Model:
        """Model with the found values of the keys of its file."""
        return cast("Model", self._trials.model_at(self.values))
