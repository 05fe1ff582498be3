"""Results of statics, modes, flutter and trim."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Dict, List, Mapping, Optional, Sequence, Tuple

import numpy as np
from numpy.typing import NDArray

from .page import table
from .style import PALETTE, curve, labelled, mark, panels, style
from .variable import Start
from .viewed import Shapes

if TYPE_CHECKING:
    from .model import Model


_VERDICTS = {True: "stable", False: "UNSTABLE", None: "stability not determined"}


class Equilibrium:
    """Static equilibrium. `data` contains the output of `foldwing static --json`."""

    def __init__(self, data: Dict[str, Any]) -> None:
        self.data = data
        """Data as printed by the command."""
        self.joints: Dict[str, Dict[str, Any]] = {joint["name"]: joint for joint in data["joints"]}
        """Joints by name: `angle_rad`, `applied_torque_N_m`, `latch_torque_N_m`, `latched`."""
        self.gauges: Dict[str, float] = {gauge["name"]: gauge["strain"] for gauge in data["gauges"]}
        """Strains of the gauges by name."""
        self.root_force_N: NDArray[np.float64] = np.array(data["root"]["force_N"])
        """Force of the model on the root in N, root frame, shape (3,)."""
        self.root_moment_N_m: NDArray[np.float64] = np.array(data["root"]["moment_N_m"])
        """Moment of the model on the root in N·m, root frame, shape (3,)."""
        self.warnings: List[str] = list(data["warnings"])
        """Warnings: assumptions of the aerodynamic models that are not met, and joints whose positions may not be the
        intended ones: open latches, hinges that have rotated by more than half a revolution."""

    @property
    def stable(self) -> Optional[bool]:
        """Stability of the equilibrium, including aerodynamics; `None` if it was not assessed, for the reason in
        `data["stability"]["not_judged"]`."""
        stable: Optional[bool] = self.data["stability"]["stable"]
        return stable

    def shape(self, body: str) -> NDArray[np.float64]:
        """Positions of the sections of a body in m, root frame, starting at the inner end, shape (sections, 3)."""
        return np.array([section["position_m"] for section in _named(self.data["bodies"], body)["sections"]])

    def strain(self, body: str) -> NDArray[np.float64]:
        """Strains `(εx, κx, κy, κz)` in 1 and 1/m at the sections of a body, shape (sections, 4)."""
        return np.array([section["strain"] for section in _named(self.data["bodies"], body)["sections"]])

    def plot(self, *, axes: Any = None) -> Any:
        """Plot the deflected shape: z over x and y over x of every body in m, root frame. Returns the figure."""
        with style() as pyplot:
            figure, places = panels(pyplot, 2, axes)
            for place, axis, name in zip(places, (2, 1), ("z (m)", "y (m)")):
                for body in self.data["bodies"]:
                    shape = self.shape(body["name"])
                    curve(place, shape[:, 0], shape[:, axis], body["name"], marker="o", markersize=3)
                place.set_ylabel(name)
                labelled(place)
            if axes is None:
                places[0].set_title(f"{self.data['name']}: static equilibrium")
            places[-1].set_xlabel("x (m)")
        return figure

    def _repr_html_(self) -> str:
        angles = []
        for name, joint in self.joints.items():
            key, value = next((key, value) for key, value in joint.items() if key != "name")
            effort = next((value for key, value in joint.items() if key.startswith("applied")), None)
            angle, unit = (np.degrees(value), "deg") if key.endswith("_rad") else (value, "m")
            angles.append((name, angle, unit, effort, "latched" if joint["latched"] else ""))
        return table(f"{self.data['name']}: static equilibrium, {_VERDICTS[self.stable]}", ("joint", "position", "unit", "effort", ""), angles)

    def __repr__(self) -> str:
        joints = ", ".join(f"{name} at {next(v for k, v in joint.items() if k != 'name'):.4f}" for name, joint in self.joints.items())
        return f"<foldwing.Equilibrium of {self.data['name']}: {joints or 'no joints'}; {_VERDICTS[self.stable]}>"


class Modes(Shapes):
    """Natural modes, lowest frequency first. `data` contains the output of `foldwing modes --json`; `view()` animates the shapes."""

    def __init__(self, data: Dict[str, Any], source: Optional[Tuple[Model, str, Tuple[Any, ...]]] = None) -> None:
        self._source = source
        self.data = data
        """Data as printed by the command."""
        modes = data["modes"]
        self.eigenvalues_1_s: NDArray[np.complex128] = np.array([complex(*mode["eigenvalue_1_s"]) for mode in modes])
        """Eigenvalues in 1/s, one of each conjugate pair (positive imaginary part), shape (modes,)."""
        self.frequency_Hz: NDArray[np.float64] = _numbers([mode["frequency_Hz"] for mode in modes])
        """`|λ|/2π` in Hz, NaN for non-oscillatory modes, shape (modes,)."""
        self.damping_ratio: NDArray[np.float64] = _numbers([mode["damping_ratio"] for mode in modes])
        """`−Re λ/|λ|`, NaN for non-oscillatory modes, shape (modes,)."""

    def __len__(self) -> int:
        return len(self.eigenvalues_1_s)

    def shape(self, mode: int, body: str) -> NDArray[np.complex128]:
        """Mode shape: displacements of the sections of a body, root frame, shape (sections, 3); the largest motion of the model is 1."""
        parts = [_named(self.data["modes"][mode][part], body)["sections"] for part in ("shape", "shape_imaginary")]
        real, imaginary = (np.array([section["displacement_m"] for section in part]) for part in parts)
        return np.asarray(real + 1j * imaginary)

    def plot(self, *, axes: Any = None) -> Any:
        """Plot the eigenvalues: damping ratio in % over frequency in Hz of the oscillating modes. Returns the figure."""
        with style() as pyplot:
            figure, (place,) = panels(pyplot, 1, axes)
            for number, (frequency, damping) in enumerate(zip(self.frequency_Hz, self.damping_ratio), start=1):
                if np.isfinite(frequency):
                    place.plot(frequency, 100.0 * damping, "o", color=PALETTE[0] if damping >= 0.0 else PALETTE[1])
                    place.annotate(str(number), (frequency, 100.0 * damping), xytext=(4, 4), textcoords="offset points", fontsize=8.5)
            if axes is None:
                place.set_title(f"{self.data['name']}: modes")
            place.set_xlabel("frequency (Hz)")
            place.set_ylabel("damping ratio (%)")
        return figure

    def _repr_html_(self) -> str:
        rows = []
        for number, (mode, value) in enumerate(zip(self.data["modes"], self.eigenvalues_1_s), start=1):
            shares = sorted(((share, name) for name, share in mode["energy_shares"].items() if share > 5e-3), reverse=True)
            motion = ", ".join(f"{name} {100.0 * share:.0f} %" for share, name in shares)
            rows.append((number, mode["frequency_Hz"], mode["damping_ratio"], value.real, "grows" if mode["grows"] else "", motion))
        header = ("mode", "frequency (Hz)", "damping ratio", "real part (1/s)", "", "elastic energy")
        return table(f"{self.data['name']}: modes", header, rows)

    def __repr__(self) -> str:
        return f"<foldwing.Modes of {self.data['name']}: {', '.join(f'{f:.4g}' for f in self.frequency_Hz)} Hz>"


class Flutter(Shapes):
    """Modes as functions of wind speed. `data` contains one entry of `results` in the output of `foldwing flutter --json`; `view()`
    animates the shapes."""

    def __init__(self, name: str, data: Dict[str, Any], source: Optional[Tuple[Model, str, Tuple[Any, ...]]] = None) -> None:
        self._source = source
        self.name = name
        """Name of the model."""
        self.data = data
        """Data as printed by the command."""
        self.speed_m_s: NDArray[np.float64] = np.array([place["speed_m_s"] for place in data["modes"]])
        """Wind speeds in m/s, both given and inserted for mode tracking, shape (speeds,)."""
        nowhere = complex(np.nan, np.nan)
        eigenvalues = [[nowhere if mode is None else complex(*mode) for mode in place["eigenvalues_1_s"]] for place in data["modes"]]
        self.eigenvalues_1_s: NDArray[np.complex128] = np.array(eigenvalues)
        """Eigenvalues of each mode in 1/s as a function of wind speed, NaN where the mode was not found, shape (speeds, modes)."""
        self.flutter_m_s: NDArray[np.float64] = np.array([found["speed_m_s"] for found in data["flutter"] if found["begins"]])
        """Flutter speeds in m/s (onset of a growing oscillation), shape (found,)."""
        self.flutter_Hz: NDArray[np.float64] = np.array([found["frequency_Hz"] for found in data["flutter"] if found["begins"]])
        """Flutter frequencies in Hz, shape (found,)."""
        self.divergence_m_s: NDArray[np.float64] = np.array(data["divergence_m_s"], dtype=np.float64)
        """Divergence speeds in m/s, shape (found,)."""
        self.changes: List[Dict[str, Any]] = list(data["changes"])
        """Other events between two speeds: `kind` ("latch", "jump" of the equilibrium, "unstable": a growing mode, "divergence": a change of
        sign without a converged speed), `between_m_s`, `text`."""
        self.warnings: List[str] = list(data["warnings"])
        """Warnings: assumptions of the aerodynamic models that are not met at one of the speeds."""
        self.modes_tracked: int = int(data["modes_tracked"])
        """Number of modes tracked."""

    @property
    def frequency_Hz(self) -> NDArray[np.float64]:
        """`|λ|/2π` in Hz, NaN for non-oscillatory modes, shape (speeds, modes)."""
        size = np.abs(self.eigenvalues_1_s)
        return np.where(self.eigenvalues_1_s.imag == 0.0, np.nan, size / (2.0 * np.pi))

    @property
    def damping_ratio(self) -> NDArray[np.float64]:
        """`−Re λ/|λ|`, NaN for non-oscillatory modes, negative for growing modes, shape (speeds, modes)."""
        size = np.abs(self.eigenvalues_1_s)
        oscillates = (self.eigenvalues_1_s.imag != 0.0) & (size > 0.0)
        return np.where(oscillates, -self.eigenvalues_1_s.real / np.where(size > 0.0, size, 1.0), np.nan)

    def plot(self, *, axes: Any = None) -> Any:
        """Plot damping ratio in % and frequency in Hz of each mode versus wind speed, with flutter and divergence marked. Returns the
        figure."""
        with style() as pyplot:
            figure, places = panels(pyplot, 2, axes)
            for place, values, label in zip(places, (100.0 * self.damping_ratio, self.frequency_Hz), ("damping ratio (%)", "frequency (Hz)")):
                for mode in range(values.shape[1]):
                    curve(place, self.speed_m_s, values[:, mode], f"mode {mode + 1}")
                for kind, speeds in (("flutter", self.flutter_m_s), ("divergence", self.divergence_m_s)):
                    for speed in speeds:
                        mark(place, float(speed), f"{kind} {speed:.4g} m/s" if place is places[0] else "")
                place.set_ylabel(label)
                labelled(place)
            if axes is None:
                figure.suptitle(f"{self.name}: modes versus wind speed", x=0.01, ha="left", fontsize=11.5)
            places[-1].set_xlabel("wind speed (m/s)")
        return figure

    def _repr_html_(self) -> str:
        rows = [("flutter", speed, hertz) for speed, hertz in zip(self.flutter_m_s, self.flutter_Hz)]
        rows += [("divergence", speed, None) for speed in self.divergence_m_s]
        rows += [(change["text"], "{:g} to {:g}".format(*change["between_m_s"]), None) for change in self.changes]
        return table(self.name, ("", "wind speed (m/s)", "frequency (Hz)"), rows, repr(self)[1:-1])

    def __repr__(self) -> str:
        flutter = ", ".join(f"flutter at {speed:.6g} m/s with {hertz:.6g} Hz" for speed, hertz in zip(self.flutter_m_s, self.flutter_Hz))
        divergence = ", ".join(f"divergence at {speed:.6g} m/s" for speed in self.divergence_m_s)
        changes = "; ".join("between {:g} and {:g} m/s: {}".format(*change["between_m_s"], change["text"]) for change in self.changes)
        first = f"unstable from {self.speed_m_s[0]:g} m/s on" if self.data["unstable_from_first"] else ""
        none = f"neither flutter nor divergence up to {self.speed_m_s[-1]:g} m/s, {self.modes_tracked} modes tracked"
        ended = f"; ended: {self.data['ended']['message']}" if self.data["ended"] else ""
        return f"<foldwing.Flutter of {self.name}: {'; '.join(filter(None, [first, flutter, divergence, changes])) or none}{ended}>"


class FlutterMap:
    """Flutter and divergence speeds as functions of a quantity."""

    def __init__(self, name: str, over: str, values: Sequence[Any], results: Sequence[Flutter]) -> None:
        self.name = name
        """Name of the model."""
        self.over = over
        """Name of the quantity."""
        self.values = list(values)
        """Values of the quantity."""
        self.results = list(results)
        """Results for each value."""
        self.flutter_m_s: NDArray[np.float64] = _numbers([_first(found.flutter_m_s) for found in results])
        """Lowest flutter speeds in m/s, NaN if none, shape (values,)."""
        self.flutter_Hz: NDArray[np.float64] = _numbers([_first(found.flutter_Hz) for found in results])
        """Their frequencies in Hz, NaN if none, shape (values,)."""
        self.divergence_m_s: NDArray[np.float64] = _numbers([_first(found.divergence_m_s) for found in results])
        """Lowest divergence speeds in m/s, NaN if none, shape (values,)."""

    def plot(self, *, axes: Any = None) -> Any:
        """Plot the lowest flutter and divergence speeds in m/s over the quantity; values that are not numbers are numbered in their order.
        Returns the figure."""
        numbers = all(isinstance(value, (int, float, np.number)) for value in self.values)
        at = np.array(self.values, dtype=np.float64) if numbers else np.arange(len(self.values), dtype=np.float64)
        with style() as pyplot:
            figure, (place,) = panels(pyplot, 1, axes)
            for name, speeds in (("flutter", self.flutter_m_s), ("divergence", self.divergence_m_s)):
                if np.isfinite(speeds).any():
                    curve(place, at, speeds, name, marker="o", markersize=4)
            labelled(place)
            if axes is None:
                place.set_title(f"{self.name}: speeds of flutter and divergence")
            if not numbers:
                place.set_xticks(at, [str(value) for value in self.values])
            place.set_xlabel(self.over)
            place.set_ylabel("wind speed (m/s)")
        return figure

    def _repr_html_(self) -> str:
        rows = zip(self.values, self.flutter_m_s, self.flutter_Hz, self.divergence_m_s)
        return table(self.name, (self.over, "flutter (m/s)", "flutter (Hz)", "divergence (m/s)"), rows)

    def __repr__(self) -> str:
        return f"<foldwing.FlutterMap of {self.name} over {self.over}: {len(self.values)} values>"


class Trim:
    """Trim solution. `data` contains the output of `foldwing trim --json`."""

    def __init__(self, data: Dict[str, Any], settings: Mapping[str, Start]) -> None:
        self.data = data
        """Data as printed by the command."""
        self.free: Dict[str, float] = dict(data["free"])
        """Solved values by name."""
        self.balances: Dict[str, float] = dict(data["balances"])
        """Values of the target outputs at equilibrium, by name."""
        self.settings: Dict[str, Start] = {**settings, **data["settings"]}
        """Given start values merged with the solution: pass as `settings=` to other analyses and runs."""
        self.warnings: List[str] = list(data["warnings"])
        """Warnings as in `Equilibrium.warnings`, at the solution."""

    def _repr_html_(self) -> str:
        rows = [("solved", name, value) for name, value in self.free.items()]
        rows += [("target", name, value) for name, value in self.balances.items()]
        return table(f"{self.data['name']}: trim", ("", "variable", "value (SI)"), rows)

    def __repr__(self) -> str:
        found = ", ".join(f"{name} = {value:.6g}" for name, value in self.free.items())
        return f"<foldwing.Trim of {self.data['name']}: {found}>"


def _first(speeds: NDArray[np.float64]) -> Optional[float]:
    return float(speeds[0]) if len(speeds) else None


def _named(entries: List[Dict[str, Any]], name: str) -> Dict[str, Any]:
    for entry in entries:
        if entry["name"] == name:
            return entry
    raise KeyError(f"no body is named {name}; available are {', '.join(entry['name'] for entry in entries)}")


def _numbers(values: List[Any]) -> NDArray[np.float64]:
    return np.array([np.nan if value is None else value for value in values], dtype=np.float64)
