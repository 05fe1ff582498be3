"""Parameter sweeps: variants and result table."""

from __future__ import annotations

import itertools
from typing import Any, Dict, Iterator, List, Mapping, Tuple

import numpy as np
from numpy.typing import NDArray

from .errors import UsageError
from .optional import needed


class SweepResult(Mapping[str, NDArray[Any]]):
    """Results of a sweep: columns by name, each of shape (variants,); numbers as float64, missing values as NaN, otherwise text."""

    def __init__(self, columns: List[str], cells: List[List[str]]) -> None:
        self._columns: Dict[str, NDArray[Any]] = {
            name: _parsed([row[place] for row in cells]) for place, name in enumerate(columns)
        }

    def __getitem__(self, name: str) -> NDArray[Any]:
        return self._columns[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    def __repr__(self) -> str:
        return f"<foldwing.SweepResult: {len(self['variant'])} variants, columns {', '.join(self)}>"

    @property
    def failed(self) -> NDArray[np.bool_]:
        """Mask of failed variants, shape (variants,); the reasons are in `message`."""
        return np.asarray(self["status"] != "done")

    def to_pandas(self) -> Any:
        """Convert to a DataFrame with one row for each variant."""
        return needed("pandas").DataFrame(self._columns).set_index("variant")


def grid_of(variants: Any, grid: bool) -> Tuple[List[str], List[List[str]]]:
    """Keys, and their values in the format of the model file, for each variant."""
    if hasattr(variants, "columns") and hasattr(variants, "index"):  # a DataFrame
        variants, grid = {str(name): variants[name].tolist() for name in variants.columns}, False
    if not isinstance(variants, Mapping) or not variants:
        raise UsageError("variants: must be a mapping of keys to values, or a DataFrame")
    axes = [[values] if np.ndim(values) == 0 else list(values) for values in variants.values()]
    if not grid and len({len(axis) for axis in axes}) > 1:
        raise UsageError(f"variants: {', '.join(str(len(axis)) for axis in axes)} values for the keys; without a grid all are equal")
    rows = itertools.product(*axes) if grid else zip(*axes)
    return [str(key) for key in variants], [[_written(value) for value in row] for row in rows]


def _written(value: Any) -> str:
    """Format a value as text that round-trips exactly."""
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, bool):
        return "true" if value else "false"
    return value if isinstance(value, str) else repr(value)


def _parsed(cells: List[str]) -> NDArray[Any]:
    words = {"true": 1.0, "false": 0.0, "": np.nan}
    try:
        return np.array([words[cell] if cell in words else float(cell) for cell in cells])
    except ValueError:
        return np.array(cells, dtype=object)
