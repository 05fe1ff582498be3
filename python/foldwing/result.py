"""Simulation results: arrays by name, export to pandas and xarray."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, Dict, Iterator, List, Mapping, Optional, Sequence, Tuple, Union

import numpy as np
from numpy.typing import NDArray

from . import _native
from .arguments import checked_methods
from .errors import UsageError
from .film import Video, write
from .optional import needed
from .page import table
from .style import curve, labelled, mark, panels, quantity, shown, style
from .viewed import show_page

if TYPE_CHECKING:
    from .inputs import Columns
    from .model import Model


@checked_methods
class Result(Mapping[str, NDArray[np.float64]]):
    """Simulation results over time. `run["fold.angle"]` has the shape (points,), `run["tip.position"]` the shape (points, 3) if all its
    components were recorded. Booleans are 0 and 1.
    """

    def __init__(
        self,
        model: Model,
        names: List[str],
        values: NDArray[np.float64],
        settings: Sequence[Tuple[str, Any]],
        inputs: Columns,
    ) -> None:
        self.model = model
        """Simulated model."""
        self.time: NDArray[np.float64] = values[0]
        """Communication points in s, shape (points,)."""
        self.inputs = inputs
        """Inputs over time as given: times in s and values by name; None without inputs."""
        self._rows: Dict[str, NDArray[np.float64]] = dict(zip(names, values[1:]))
        self._settings = list(settings)

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        if name in self._rows:
            return self._rows[name]
        if name == "time":
            return self.time
        vector = self.model._vectors.get(name)
        if vector is not None:
            first, count = vector
            parts = list(self.model.variables)[first : first + count]
            if all(part in self._rows for part in parts):
                return np.stack([self._rows[part] for part in parts], axis=1)
        raise KeyError(f"{name} was not recorded; recorded are {', '.join(list(self._rows)[:8])}{', …' * (len(self) > 8)}")

    def __iter__(self) -> Iterator[str]:
        return iter(self._rows)

    def __len__(self) -> int:
        return len(self._rows)

    def __repr__(self) -> str:
        end = f"{self.time[-1]:g} s" if len(self.time) else "nothing"
        return f"<foldwing.Result of {self.model.name}: {len(self)} variables, {len(self.time)} points to {end}>"

    def _ipython_key_completions_(self) -> List[str]:
        vectors = [name for name, (first, _) in self.model._vectors.items() if list(self.model.variables)[first] in self._rows]
        return ["time", *self._rows, *vectors]

    def _repr_html_(self) -> str:
        rows = [(name, self.unit(name), values[0], values[-1], values.min(), values.max()) for name, values in self._rows.items() if len(values)]
        latched = "latched at " + ", ".join(f"{moment:.6g} s" for moment in self.latch_times()) if self.latch_times() else ""
        return table(repr(self)[1:-1], ("variable", "unit", "first", "last", "minimum", "maximum"), rows, latched)

    def unit(self, name: str) -> str:
        """Unit of a variable; `1` or empty if dimensionless."""
        return "s" if name == "time" else self.model.variables[name].unit

    def to_pandas(self) -> Any:
        """Convert to a DataFrame: index time in s, one column for each variable, units in `attrs["units"]`."""
        pandas = needed("pandas")
        frame = pandas.DataFrame(dict(self._rows), index=pandas.Index(self.time, name="time"))
        frame.attrs["units"] = {name: self.unit(name) for name in self}
        return frame

    def to_xarray(self) -> Any:
        """Convert to a Dataset over `time`, with `units` and `long_name` for each variable."""
        xarray = needed("xarray")
        rows = self.model.variables
        variables = {
            name: ("time", values, {"units": self.unit(name), "long_name": rows[name].description})
            for name, values in self._rows.items()
        }
        coordinates = {"time": ("time", self.time, {"units": "s", "long_name": "simulation time"})}
        return xarray.Dataset(variables, coordinates, {"model": self.model.name})

    def plot(self, names: Union[None, str, Sequence[str]] = None, *, axes: Any = None) -> Any:
        """Plot variables over time, one panel for each unit, with latch times as dashed lines: angles in degrees, strains in µm/m.

        Args:
            names: names and patterns of recorded variables; default: all.
            axes: matplotlib axes, one for all units or one for each; default: a new figure.

        Returns:
            The figure.
        """
        chosen = list(self)
        if names is not None:
            wanted = set(self.model.match(names))
            chosen = [name for name in chosen if name in wanted]
        if not chosen:
            raise UsageError(f"plot: none of {names!r} was recorded; recorded are {', '.join(list(self)[:8])}")
        groups: Dict[str, List[str]] = {}
        for name in chosen:
            groups.setdefault(shown(name, self.unit(name))[0], []).append(name)
        with style() as pyplot:
            figure, places = panels(pyplot, len(groups), axes)
            for place, (unit, members) in zip(places, groups.items()):
                for name in members:
                    curve(place, self.time, self._rows[name] * shown(name, self.unit(name))[1], name)
                place.set_ylabel(quantity(members, unit))
                for moment in self.latch_times():
                    mark(place, moment)
                labelled(place)
            if axes is None:
                places[0].set_title(self.model.name)
            places[-1].set_xlabel("time (s)")
        return figure

    def latch_times(self) -> List[float]:
        """Times in s at which latches closed, from the recorded `latch_time` variables."""
        moments = set()
        for name, values in self._rows.items():
            if name.endswith(".latch_time"):
                moments.update(values[values > 0.0].tolist())
        return sorted(moments)

    def page(self) -> str:
        """Animated HTML page of the run. The simulation is repeated with the same inputs."""
        simulation = _native.Simulation(self.model._native, self._settings)
        table: Optional[_native.InputTable] = None
        if self.inputs is not None and len(self.inputs[0]):
            times, columns = self.inputs
            table = _native.InputTable(self.model._native, times, list(columns.items()))
        _, _, _, page = simulation.run(np.ascontiguousarray(self.time), [], table, True, None)
        return page or ""

    def view(self, output: Union[None, str, os.PathLike[str]] = None, *, show: bool = True) -> Any:
        """Animate the run: in a notebook as the output of the cell, otherwise in the browser.

        Args:
            output: HTML file to write; default: a temporary file.
            show: if false, only write the file.

        Returns:
            In notebooks the displayed HTML object, otherwise the path of the file.
        """
        return show_page(self.page(), "run.html", output, show)

    def video(
        self,
        output: Union[None, str, os.PathLike[str]] = None,
        *,
        size: Optional[Tuple[int, int]] = None,
        fps: Optional[float] = None,
        speed: Optional[float] = None,
        camera: Union[str, Sequence[str]] = (),
        start: Optional[float] = None,
        stop: Optional[float] = None,
        force: bool = False,
        progress: Optional[bool] = None,
    ) -> Video:
        """Write a video of the run, as `foldwing render` does: no browser and no display are needed. The simulation is repeated with the same
        inputs.

        Args:
            output: file to write: .mp4, .gif, or .png for one numbered file for each frame; default: a temporary .mp4.
            size: width and height in pixels; default: (1280, 720); GIF: (800, 450).
            fps: frames per second; default: 30; GIF: 25.
            speed: seconds of the run per second of the video; default: the video lasts about 8 s.
            camera: "follow" or "fixed", and one of "iso", "front", "side", "top", such as "follow,side"; default: "iso", following a model
                that flies.
            start: first time in s; default: that of the run.
            stop: last time in s; default: that of the run.
            force: overwrite a file that was not written by Foldwing.
            progress: show a progress bar; default: in notebooks with tqdm.

        Returns:
            The video, which notebooks play in the cell; its `path` is the file.

        Raises:
            UsageError: for a format that is not supported, or a setting out of its range.
        """
        return write(self.page(), output, size, fps, speed, camera, (start, stop), force, progress)
