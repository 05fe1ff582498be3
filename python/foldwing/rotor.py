"""Rotor analyses: periodic steady state, operating points."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Dict, Iterable, List, Mapping, Optional, Sequence, Tuple, Union

import numpy as np
from numpy.typing import NDArray

from . import _native
from .errors import UsageError
from .variable import Start
from .viewed import Shapes

if TYPE_CHECKING:
    from .model import Model

Values = Union[float, Iterable[float]]


class RotorStudies:
    """Methods of `Model` for rotors."""

    _native: _native.Model

    def periodic(
        self,
        speed_rpm: Optional[float] = None,
        *,
        shaft: Optional[str] = None,
        outputs: Union[None, str, Sequence[str]] = None,
        settings: Optional[Mapping[str, Start]] = None,
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
            tolerance: periodicity tolerance: rotation in rad, or displacement over the model's length.
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
        chosen = list((settings or {}).items())
        data = self._native.periodic(speed_rpm, shaft, chosen, names, counts, float(tolerance))
        # of the same class as Model, which inherits this one
        model: Any = self
        return Periodic(data, (model, "periodic_page", (speed_rpm, shaft, chosen, counts, float(tolerance))))

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
        settings: Optional[Mapping[str, Start]] = None,
        steps: int = 720,
        tolerance: float = 1e-6,
    ) -> OperatingPoints:
        """Compute power, thrust and loads of a rotor over wind, speed and pitch, as `foldwing operating-points`.

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

        >>> from foldwing import load
        >>> turbine = load("examples/turbine/nrel_5mw_wind.toml")
        >>> table = turbine.operating_points(8.0, speed_rpm=9.16, pitch_deg=0.0, settings={"gravity.z": 0.0})
        >>> table.state, f"{table['rotor.power_coefficient'][0]:.2f}"
        (['periodic'], '0.48')
        """
        names = [] if outputs is None else [outputs] if isinstance(outputs, str) else list(outputs)
        if (solve_for is None) != (target is None):
            raise UsageError("solve_for= and target= are needed together")
        if solve_for is not None and (len(solve_for) != 3 or solve_for[0] not in ("pitch_deg", "speed_rpm")):
            raise UsageError(f'solve_for={solve_for!r}: must be ("pitch_deg", begin, end) or ("speed_rpm", begin, end)')
        data = self._native.operating_points(
            (_list(wind_m_s) or [], _list(speed_rpm), _list(pitch_deg)),
            tip_speed_ratio,
            paired,
            None if solve_for is None else (solve_for[0], float(solve_for[1]), float(solve_for[2])),
            None if target is None else (target[0], float(target[1])),
            (shaft, list(pitch_joints) or None),
            list((settings or {}).items()),
            names,
            steps,
            float(tolerance),
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

    @property
    def stable(self) -> bool:
        """True if no computed mode grows; also `True` without modes, when stability is unknown."""
        return bool(np.all(np.abs(self.multipliers) <= 1.0 + 1e-4))

    def _place(self, name: str) -> int:
        if name not in self._places:
            raise KeyError(f"{name}: not among the outputs of this motion; there are {', '.join(list(self._places)[:8])}, …")
        return self._places[name]

    def __repr__(self) -> str:
        data = self.data
        return f"<foldwing.Periodic of {data['name']} at {data['rotor_speed_rpm']:.6g} rpm: {len(self._places)} outputs, {len(self.motions)} modes>"


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

    def _column(self, name: str, part: str) -> NDArray[np.float64]:
        if name not in self._places:
            raise KeyError(f"{name}: not among the outputs of these points; there are {', '.join(list(self._places)[:8])}, …")
        place = self._places[name]
        return _numbers([point[part][place] if point[part] else None for point in self.data["points"]])

    def __repr__(self) -> str:
        return f"<foldwing.OperatingPoints of {self.data['name']}: {len(self)} points, {len(self._places)} outputs>"


def _list(values: Optional[Values]) -> Optional[List[float]]:
    return None if values is None else np.atleast_1d(np.asarray(values, dtype=np.float64)).tolist()


def _numbers(values: List[Any]) -> NDArray[np.float64]:
    return np.array([np.nan if value is None else value for value in values], dtype=np.float64)
