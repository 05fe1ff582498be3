"""Rotor analyses: periodic steady state, operating points."""

from __future__ import annotations

import fnmatch
from typing import TYPE_CHECKING, Any, Dict, Iterable, List, Optional, Sequence, Tuple, Union

import numpy as np
from numpy.typing import NDArray

from . import _native
from .arguments import checked_methods
from .errors import UsageError
from .page import table
from .progress import bar
from .style import FAINT, MAXIMUM_LABELS, curve, labelled, panels, quantity, shown, style
from .variable import Settings, Start
from .viewed import Shapes

if TYPE_CHECKING:
    from .model import Model

Values = Union[float, Iterable[float]]


@checked_methods
class RotorStudies:
    """Methods of `Model` for rotors."""

    _native: _native.Model

    def _settings(self, settings: Settings) -> List[Tuple[str, Start]]:
        raise NotImplementedError

    def periodic(
        self,
        speed_rpm: Optional[float] = None,
        *,
        shaft: Optional[str] = None,
        outputs: Union[None, str, Sequence[str]] = None,
        settings: Settings = None,
        count: int = 10,
        harmonics: int = 3,
        steps: int = 720,
        tolerance: float = 1e-8,
        perturbations: int = 120,
    ) -> Periodic:
        """Compute the periodic steady state of a rotor and its Floquet modes, as `foldwing periodic`.

        Args:
            speed_rpm: speed of the shaft; default: its prescribed or initial speed.
            shaft: joint of the shaft; default: the only joint with unlimited rotation that carries a hub.
            outputs: names and patterns of outputs; default: all.
            settings: start values.
            count: number of modes; 0 omits them and their computing time.
            harmonics: number of harmonics of the rotor speed in `data`.
            steps: steps per revolution, rounded up to a multiple of 144.
            tolerance: periodicity tolerance: rotation in rad, or displacement relative to the model's length.
            perturbations: maximum number of perturbations integrated for the Floquet modes.

        >>> from foldwing import load
        >>> turbine = load("examples/turbine/nrel_5mw.toml")
        >>> turn = turbine.periodic(12.1, outputs="body.blade1.deflection.*", count=0)
        >>> turn["body.blade1.deflection.y"].shape
        (145,)
        >>> f"{turn.amplitude('body.blade1.deflection.y', 1):.3f} m"
        '0.475 m'
        """
        names = [] if outputs is None else [outputs] if isinstance(outputs, str) else list(outputs)
        counts = (steps, harmonics, count, perturbations)
        chosen = self._settings(settings)
        data = self._native.periodic(speed_rpm, shaft, chosen, names, counts, float(tolerance))
        # self is always a Model, which inherits from this class
        model: Any = self
        return Periodic(data, (model, "periodic_page", (speed_rpm, shaft, chosen, counts, float(tolerance))))

    def campbell(
        self,
        speed_rpm: Iterable[float],
        *,
        shaft: Optional[str] = None,
        undeformed: bool = False,
        count: int = 10,
        settings: Settings = None,
        progress: Optional[bool] = None,
    ) -> Campbell:
        """Compute the modes of a rotor as functions of its speed, in the fixed frame, as `foldwing modes --vary rotor_speed_rpm=…`.

        Args:
            speed_rpm: speeds, rising or falling; more are inserted where mode tracking requires it.
            shaft: joint of the shaft; default: the only joint with unlimited rotation that carries a hub.
            undeformed: without gravity, loads, root motion and aerodynamics; otherwise, if any of these acts, the modes are those of
                the periodic steady state, which takes a search at each speed.
            count: number of modes of lowest frequency.
            settings: start values.
            progress: show a progress bar (needs tqdm); default: in notebooks.

        >>> from foldwing import load
        >>> diagram = load("examples/turbine/nrel_5mw.toml").campbell([0.0, 6.0, 12.1], undeformed=True, count=4)
        >>> diagram.frequency_Hz.shape, diagram.motions[1]
        ((3, 4), 'tower edge 1')
        """
        speeds = np.atleast_1d(np.asarray(list(speed_rpm), dtype=np.float64)).tolist()
        with bar(progress) as told:
            return Campbell(self._native.campbell(speeds, shaft, undeformed, count, self._settings(settings), told))

    def operating_points(
        self,
        wind_m_s: Values,
        *,
        speed_rpm: Optional[Values] = None,
        tip_speed_ratio: Optional[float] = None,
        pitch_deg: Optional[Values] = None,
        paired: bool = False,
        solve_for: Optional[Tuple[str, float, float]] = None,
        target: Optional[Tuple[str, float]] = None,
        shaft: Optional[str] = None,
        pitch_joints: Sequence[str] = (),
        outputs: Union[None, str, Sequence[str]] = None,
        settings: Settings = None,
        steps: int = 720,
        tolerance: float = 1e-6,
        progress: Optional[bool] = None,
    ) -> OperatingPoints:
        """Compute power, thrust and loads of a rotor as functions of wind, speed and pitch, as `foldwing operating-points`.

        Args:
            wind_m_s: wind speeds, in the wind direction of the model.
            speed_rpm: rotor speeds; default: that of the model.
            tip_speed_ratio: determines the rotor speed; `speed_rpm` is then a single value, the upper limit.
            pitch_deg: collective pitch, positive as the angles of the pitch joints; default: that of the model.
            paired: combine the lists element by element; otherwise all combinations.
            solve_for: unknown and its range: `("pitch_deg", begin, end)` or `("speed_rpm", begin, end)`.
            target: output and its target mean, e.g. `("rotor.power", 5.3e6)`. If the output is below the target at `begin`, the
                value `begin` is used.
            shaft: joint of the shaft.
            pitch_joints: pitch joints of the blades; default: those between the blades and the hub.
            outputs: names and patterns of outputs; default: rotor outputs, deflections, root loads, holding torques.
            settings: start values.
            steps: steps per revolution if the state is periodic.
            tolerance: periodicity tolerance of such a state.
            progress: show a progress bar (needs tqdm); default: in notebooks.

        >>> from foldwing import load
        >>> turbine = load("examples/turbine/nrel_5mw_wind.toml")
        >>> table = turbine.operating_points(8.0, speed_rpm=9.16, pitch_deg=0.0, settings={"gravity.z": 0.0})
        >>> table.state, f"{table['rotor.power_coefficient'][0]:.2f}"
        (['periodic'], '0.48')
        """
        names = [] if outputs is None else [outputs] if isinstance(outputs, str) else list(outputs)
        if (solve_for is None) != (target is None):
            raise UsageError("solve_for= and target= must be given together")
        if solve_for is not None and (len(solve_for) != 3 or solve_for[0] not in ("pitch_deg", "speed_rpm")):
            raise UsageError(f'solve_for={solve_for!r}: must be ("pitch_deg", begin, end) or ("speed_rpm", begin, end)')
        with bar(progress) as told:
            data = self._native.operating_points(
                (_list(wind_m_s) or [], _list(speed_rpm), _list(pitch_deg)),
                tip_speed_ratio,
                paired,
                None if solve_for is None else (solve_for[0], float(solve_for[1]), float(solve_for[2])),
                None if target is None else (target[0], float(target[1])),
                (shaft, list(pitch_joints) or None),
                self._settings(settings),
                names,
                steps,
                float(tolerance),
                told,
            )
        return OperatingPoints(data)


class Periodic(Shapes):
    """Periodic steady state. `data` contains the output of `foldwing periodic --json`, and the outputs over one revolution; `view()` animates
    the Floquet modes."""

    def __init__(self, data: Dict[str, Any], source: Optional[Tuple[Model, str, Tuple[Any, ...]]] = None) -> None:
        self._source = source
        self.data = data
        """Data as printed by the command, with `turn_deg` and `values`."""
        self.turn_deg: NDArray[np.float64] = np.array(data["turn_deg"])
        """Rotation of the shaft from the start of the revolution in degrees, end included, shape (145,)."""
        self._places = {output["name"]: place for place, output in enumerate(data["outputs"])}
        modes = data.get("floquet", {}).get("modes", [])
        self.multipliers: NDArray[np.complex128] = np.array([complex(*mode["multiplier"]) for mode in modes], dtype=complex)
        """Floquet multipliers, shape (modes,)."""
        self.eigenvalues_1_s: NDArray[np.complex128] = np.array([complex(*mode["exponent_1_s"]) for mode in modes], dtype=complex)
        """Floquet exponents in 1/s with the frequency in the fixed frame, shape (modes,)."""
        self.motions: List[str] = [mode["motion"][0]["part"] if mode["motion"] else "" for mode in modes]
        """Dominant motion of each mode."""

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        """Values of an output over one revolution, shape (145,)."""
        return np.array(self.data["values"][self._place(name)])

    def mean(self, name: str) -> float:
        """Mean of an output over one revolution."""
        return float(self.data["outputs"][self._place(name)]["mean"])

    def amplitude(self, name: str, harmonic: int) -> float:
        """Amplitude of an output at a harmonic of the rotor speed, counted from 1."""
        return float(self.data["outputs"][self._place(name)]["amplitudes"][harmonic - 1])

    def _ipython_key_completions_(self) -> List[str]:
        return list(self._places)

    def _repr_html_(self) -> str:
        outputs = self.data["outputs"]
        count = max((len(output["amplitudes"] or []) for output in outputs), default=0)
        rows = [(output["name"], output["unit"], output["mean"], *(output["amplitudes"] or [])) for output in outputs]
        return table(repr(self)[1:-1], ("output", "unit", "mean", *(f"{n}P" for n in range(1, count + 1))), rows)

    def plot(self, names: Union[None, str, Sequence[str]] = None, *, axes: Any = None) -> Any:
        """Plot outputs over one revolution in degrees, one panel for each unit: angles in degrees.

        Args:
            names: names and patterns; default: all outputs that vary, at most 14.
            axes: matplotlib axes, one for all units or one for each; default: a new figure.

        Returns:
            The figure.
        """
        if names is None:
            chosen = [name for name in self._places if np.ptp(self[name]) > 0.0][:MAXIMUM_LABELS]
        else:
            patterns = [names] if isinstance(names, str) else list(names)
            chosen = [name for name in self._places if any(fnmatch.fnmatchcase(name, pattern.replace("[", "[[]")) for pattern in patterns)]
        if not chosen:
            raise UsageError(f"plot: none of the outputs matches {names!r}; available are {', '.join(list(self._places)[:8])}, …")
        units = {output["name"]: output["unit"] for output in self.data["outputs"]}
        groups: Dict[str, List[str]] = {}
        for name in chosen:
            groups.setdefault(shown(name, units[name])[0], []).append(name)
        with style() as pyplot:
            figure, places = panels(pyplot, len(groups), axes)
            for place, (unit, members) in zip(places, groups.items()):
                for name in members:
                    curve(place, self.turn_deg, self[name] * shown(name, units[name])[1], name)
                place.set_ylabel(quantity(members, unit))
                labelled(place)
            if axes is None:
                places[0].set_title(f"{self.data['name']} at {self.data['rotor_speed_rpm']:.6g} rpm")
            places[-1].set_xlabel("rotation of the shaft (deg)")
        return figure

    @property
    def stable(self) -> bool:
        """True if no computed mode grows; also `True` without modes, when stability is unknown."""
        return bool(np.all(np.abs(self.multipliers) <= 1.0 + 1e-4))

    def _place(self, name: str) -> int:
        if name not in self._places:
            raise KeyError(f"{name}: not among the outputs of this motion; available are {', '.join(list(self._places)[:8])}, …")
        return self._places[name]

    def __repr__(self) -> str:
        data = self.data
        return f"<foldwing.Periodic of {data['name']} at {data['rotor_speed_rpm']:.6g} rpm: {len(self._places)} outputs, {len(self.motions)} modes>"


class Campbell:
    """Modes of a rotor as functions of its speed, in the fixed frame. `data` contains the output of `foldwing modes --vary
    rotor_speed_rpm=… --json`."""

    def __init__(self, data: Dict[str, Any]) -> None:
        self.data = data
        """Data as printed by the command."""
        places = data["modes"]
        self.speed_rpm: NDArray[np.float64] = np.array([place["value"] for place in places])
        """Rotor speeds in rpm, shape (speeds,)."""
        self.frequency_Hz: NDArray[np.float64] = np.array([_numbers(place["frequency_Hz"]) for place in places])
        """`|λ|/2π` in Hz, NaN where a mode does not oscillate or was not found, shape (speeds, modes)."""
        self.damping_ratio: NDArray[np.float64] = np.array([_numbers(place["damping_ratio"]) for place in places])
        """`−Re λ/|λ|`, NaN as in `frequency_Hz`, shape (speeds, modes)."""
        nowhere = complex(np.nan, np.nan)
        values = [[nowhere if value is None else complex(*value) for value in place["eigenvalues_1_s"]] for place in places]
        self.eigenvalues_1_s: NDArray[np.complex128] = np.array(values)
        """Eigenvalues in 1/s, shape (speeds, modes)."""
        motions = [[place["motion"][mode] for place in places if place["motion"][mode]] for mode in range(self.frequency_Hz.shape[1])]
        self.motions: List[str] = [max(set(names), key=names.count) if names else "" for names in motions]
        """Dominant motion of each mode at the majority of the speeds, e.g. `tower side-side`, `blade1 flap, backward`."""

    def plot(self, *, axes: Any = None) -> Any:
        """Plot the Campbell diagram: frequencies in Hz versus rotor speed in rpm, with the multiples 1P, 3P and 6P. Returns the figure."""
        with style() as pyplot:
            figure, (place,) = panels(pyplot, 1, axes)
            for mode, motion in enumerate(self.motions):
                curve(place, self.speed_rpm, self.frequency_Hz[:, mode], motion or f"mode {mode + 1}")
            highest = float(np.nanmax(self.frequency_Hz))
            for multiple in (1, 3, 6):
                ends = np.array([self.speed_rpm.min(), min(self.speed_rpm.max(), 60.0 * highest / multiple)])
                place.plot(ends, multiple * ends / 60.0, color=FAINT, linestyle=(0, (4, 3)), linewidth=1.0)
                place.annotate(f"{multiple}P", (ends[1], multiple * ends[1] / 60.0), color=FAINT, fontsize=8.5, ha="right", va="bottom")
            labelled(place)
            if axes is None:
                place.set_title(f"{self.data['name']}: Campbell diagram")
                figure.set_size_inches(7.5, 5.0)
            place.set_xlabel("rotor speed (rpm)")
            place.set_ylabel("frequency (Hz)")
        return figure

    def _repr_html_(self) -> str:
        header = ("rotor speed (rpm)", *(motion or f"mode {mode + 1}" for mode, motion in enumerate(self.motions)))
        return table(f"{self.data['name']}: frequencies in Hz", header, ((speed, *row) for speed, row in zip(self.speed_rpm, self.frequency_Hz)))

    def __repr__(self) -> str:
        return f"<foldwing.Campbell of {self.data['name']}: {len(self.motions)} modes from {self.speed_rpm[0]:g} to {self.speed_rpm[-1]:g} rpm>"


class OperatingPoints:
    """Operating points of a rotor. `data` contains the output of `foldwing operating-points --json`."""

    def __init__(self, data: Dict[str, Any]) -> None:
        self.data = data
        """Data as printed by the command."""
        points = data["points"]
        self.wind_m_s: NDArray[np.float64] = _numbers([point["wind_m_s"] for point in points])
        """Wind speed in m/s, shape (points,)."""
        self.speed_rpm: NDArray[np.float64] = _numbers([point["rotor_speed_rpm"] for point in points])
        """Rotor speed in rpm, shape (points,)."""
        self.pitch_deg: NDArray[np.float64] = _numbers([point["pitch_deg"] for point in points])
        """Pitch in degrees, shape (points,)."""
        self.state: List[str] = [point["state"] for point in points]
        """`steady`, `periodic`, or `none` if no state was found (message in `data`)."""
        self.held: List[Optional[str]] = [point["hold"] for point in points]
        """`held`, or `below` if the output is below the target at the start of the range; `None` without a target."""
        self._places = {output["name"]: place for place, output in enumerate(data["outputs"])}

    def __len__(self) -> int:
        return len(self.wind_m_s)

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        """Mean of an output at each point, shape (points,)."""
        return self._column(name, "mean")

    def peak_to_peak(self, name: str) -> NDArray[np.float64]:
        """Peak-to-peak range of an output over one revolution at each point, shape (points,); 0 for steady states."""
        return self._column(name, "peak_to_peak")

    def names(self) -> List[str]:
        """Names of the outputs."""
        return list(self._places)

    def _ipython_key_completions_(self) -> List[str]:
        return list(self._places)

    def _repr_html_(self) -> str:
        names = self.names()[:MAXIMUM_LABELS]
        columns = [self[name] for name in names]
        rows = zip(self.wind_m_s, self.speed_rpm, self.pitch_deg, self.state, *columns)
        return table(repr(self)[1:-1], ("wind (m/s)", "speed (rpm)", "pitch (deg)", "state", *names), rows)

    def plot(self, names: Union[None, str, Sequence[str]] = None, *, axes: Any = None) -> Any:
        """Plot means of outputs versus wind speed, one panel for each, with bars from the peak-to-peak values of periodic states.

        Args:
            names: names of outputs; default: power, thrust and torque of the rotor if there are any, else the first three.
            axes: matplotlib axes, one for all outputs or one for each; default: a new figure.

        Returns:
            The figure.
        """
        usual = [name for name in ("rotor.power", "rotor.thrust", "rotor.torque") if name in self._places] or self.names()[:3]
        chosen = usual if names is None else [names] if isinstance(names, str) else list(names)
        units = {output["name"]: output["unit"] for output in self.data["outputs"]}
        with style() as pyplot:
            figure, places = panels(pyplot, len(chosen), axes)
            for place, name in zip(places, chosen):
                mean, range_ = self[name], self.peak_to_peak(name)
                unit, factor = shown(name, units[name])
                place.errorbar(self.wind_m_s, mean * factor, yerr=0.5 * np.nan_to_num(range_) * factor, fmt="o", capsize=3, markersize=4)
                place.set_ylabel(f"{name} ({unit})")
            if axes is None:
                places[0].set_title(f"{self.data['name']}: operating points")
            places[-1].set_xlabel("wind speed (m/s)")
        return figure

    def _column(self, name: str, part: str) -> NDArray[np.float64]:
        if name not in self._places:
            raise KeyError(f"{name}: not among the outputs of these points; available are {', '.join(list(self._places)[:8])}, …")
        place = self._places[name]
        return _numbers([point[part][place] if point[part] else None for point in self.data["points"]])

    def __repr__(self) -> str:
        return f"<foldwing.OperatingPoints of {self.data['name']}: {len(self)} points, {len(self._places)} outputs>"


def _list(values: Optional[Values]) -> Optional[List[float]]:
    return None if values is None else np.atleast_1d(np.asarray(values, dtype=np.float64)).tolist()


def _numbers(values: List[Any]) -> NDArray[np.float64]:
    return np.array([np.nan if value is None else value for value in values], dtype=np.float64)
