"""Inputs over time for `Model.simulate`: a table, or a function called at every step."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Callable, Dict, Mapping, Optional, Tuple, Union, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native
from .errors import UsageError

if TYPE_CHECKING:
    from .model import Model
    from .simulation import Simulation

Array = NDArray[np.float64]
Course = Union[float, bool, ArrayLike, Callable[[float], float]]
Feed = Callable[[float, "Simulation"], Optional[Mapping[str, Union[float, int, bool]]]]
# `Any` represents a pandas DataFrame: pandas is not imported here
Stimulus = Union[None, Mapping[str, Course], Feed, Any]
Columns = Optional[Tuple[Array, Dict[str, Array]]]


class Inputs:
    """Inputs of a run with communication points `times`."""

    def __init__(self, model: Model, given: Stimulus, times: Array) -> None:
        self.function: Optional[Feed] = cast(Feed, given) if callable(given) else None
        """Function called at every communication point, instead of a table."""
        self.table: Optional[_native.InputTable] = None
        """Table for the extension module."""
        self.columns: Columns = None
        """Times in s and values by name."""
        if self.function is None:
            self.table, self.columns = table_of(model, given, times)


def table_of(model: Model, given: Stimulus, times: Array) -> Tuple[Optional[_native.InputTable], Columns]:
    """Input table and its columns from a mapping or a DataFrame."""
    if given is None:
        return None, None
    if callable(given):
        raise UsageError("inputs: only simulate takes a function of the simulation; give functions of time by name")
    courses = _courses(given)
    base = courses.pop("time", None)
    functions = [name for name, course in courses.items() if callable(course)]
    if base is None:
        rows = [name for name, course in courses.items() if not callable(course) and np.ndim(course) > 0]
        if rows:
            raise UsageError(f"inputs: {rows[0]} is an array, but there is no entry `time` in s")
    at = times if functions or base is None else _column("time", base)
    columns: Dict[str, Array] = {}
    for name, course in courses.items():
        if callable(course):
            columns[name] = np.array([float(cast(Any, course)(float(time))) for time in at])
        elif np.ndim(course) == 0:
            columns[name] = np.full(len(at), _column(name, [course])[0])
        elif functions:
            held = name in model.variables and model.variables[name].type != "Real"
            columns[name] = _resampled(name, _column("time", base), _column(name, course), at, held)
        else:
            columns[name] = _column(name, course)
    if not columns:
        return None, None
    return _native.InputTable(model._native, at, list(columns.items())), (at, columns)


def _courses(given: Any) -> Dict[str, Any]:
    if isinstance(given, Mapping):
        return dict(given)
    if hasattr(given, "columns") and hasattr(given, "index"):  # a DataFrame
        courses = {str(name): given[name].to_numpy() for name in given.columns}
        if "time" not in courses:
            courses["time"] = given.index.to_numpy()
        return courses
    raise UsageError(f"inputs: {type(given).__name__} is neither a mapping, a DataFrame nor a function")


def _column(name: str, values: Any) -> Array:
    try:
        column = np.ascontiguousarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise UsageError(f"inputs: {name}: not all values are numbers") from None
    if column.ndim != 1:
        raise UsageError(f"inputs: {name}: has {column.ndim} dimensions; one value per time is allowed")
    return column


def _resampled(name: str, times: Array, values: Array, at: Array, held: bool) -> Array:
    """Interpolate values at other times: linear, or held (zero order); constant outside."""
    if len(values) != len(times):
        raise UsageError(f"inputs: {name}: {len(values)} values for {len(times)} times")
    following = np.searchsorted(times, at, side="right")
    before = np.clip(following - 1, 0, None)
    after = np.clip(following, None, len(times) - 1)
    span = times[after] - times[before]
    inside = (following > 0) & (span > 0.0) & (not held)
    share = np.where(inside, (at - times[before]) / np.where(inside, span, 1.0), 0.0)
    return np.asarray(values[before] + share * (values[after] - values[before]))
