"""Parameter sweeps: variants and result table."""

from __future__ import annotations

import itertools
from typing import Any, Dict, Iterator, List, Mapping, Optional, Sequence, Tuple, Union

import numpy as np
from numpy.typing import NDArray

from .errors import UsageError
from .optional import needed
from .page import table
from .style import curve, panels, shown, style


class SweepResult(Mapping[str, NDArray[Any]]):
    """Results of a sweep: columns by name, each of shape (variants,); numbers as float64, missing values as NaN, otherwise text."""

    def __init__(self, columns: List[str], cells: List[List[str]], units: Optional[Mapping[str, str]] = None) -> None:
        self._columns: Dict[str, NDArray[Any]] = {
            name: _parsed([row[place] for row in cells]) for place, name in enumerate(columns)
        }
        self._units = dict(units or {})

    def __getitem__(self, name: str) -> NDArray[Any]:
        return self._columns[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    def __repr__(self) -> str:
        return f"<foldwing.SweepResult: {len(self['variant'])} variants, columns {', '.join(self)}>"

    def _ipython_key_completions_(self) -> List[str]:
        return list(self._columns)

    def _repr_html_(self) -> str:
        rows = zip(*(column.tolist() for column in self._columns.values()))
        return table(f"{len(self['variant'])} variants, {int(self.failed.sum())} failed", list(self._columns), rows)

    def plot(self, x: str, names: Union[None, str, Sequence[str]] = None, *, axes: Any = None) -> Any:
        """Plot columns over a key, one panel for each column: angles in degrees, strains in µm/m. Variants that failed are left out.

        Args:
            x: column of the horizontal axis.
            names: columns; default: the outputs, those between `end_time` and the solver statistics.
            axes: matplotlib axes, one for all columns or one for each; default: a new figure.

        Returns:
            The figure.
        """
        every = list(self._columns)
        if names is None:
            chosen = [name for name in every[every.index("end_time") + 1 : every.index("steps")] if self[name].dtype != object]
        else:
            chosen = [names] if isinstance(names, str) else list(names)
        for name in [x, *chosen]:
            if name not in self._columns or self[name].dtype == object:
                kind = "is not a column" if name not in self._columns else "has no numbers"
                raise UsageError(f"plot: {name} {kind}; columns are {', '.join(every)}")
        if not chosen:
            raise UsageError("plot: the sweep has no outputs; give outputs= to Model.sweep, or names=")
        good = ~self.failed
        order = np.argsort(self[x][good], kind="stable")
        with style() as pyplot:
            figure, places = panels(pyplot, len(chosen), axes)
            across, along = self._shown(x)
            for place, name in zip(places, chosen):
                up, factor = self._shown(name)
                curve(place, self[x][good][order] * along, self[name][good][order] * factor, name, marker="o", markersize=4, linestyle="")
                place.set_ylabel(f"{name}{up}")
            places[-1].set_xlabel(f"{x}{across}")
        return figure

    def _shown(self, name: str) -> Tuple[str, float]:
        """Unit of a column in figures, in brackets, and the factor; nothing for keys of the model file, whose names end in their unit."""
        if name.endswith((".first_latch_time", "end_time")):
            return " (s)", 1.0
        if name.endswith(".strain.peak"):
            name, unit = name[: -len(".peak")], "1"
        elif name in self._units:
            unit = self._units[name]
        else:
            return "", 1.0
        text, factor = shown(name, unit)
        return f" ({text})", factor

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
        raise UsageError(f"variants: {', '.join(str(len(axis)) for axis in axes)} values for the keys; without a grid all keys need the same number of values")
    rows = itertools.product(*axes) if grid else zip(*axes)
    return [str(key) for key in variants], [[written(value) for value in row] for row in rows]


def written(value: Any) -> str:
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
