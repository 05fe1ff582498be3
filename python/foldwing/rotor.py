"""Studies of rotors that turn: the motion that every turn repeats, operating points."""

from __future__ import annotations

import json
from numbers import Integral
from typing import Any, Dict, Iterable, List, Mapping, Optional, Sequence, Tuple, Union

import numpy as np
from numpy.typing import NDArray

from . import _native
from .variable import Start

Values = Union[float, Iterable[float]]


class RotorStudies:
    """What `Model` can be asked where a shaft turns in it."""

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
        """The motion that every turn of a rotor repeats, and the modes beside it, as `foldwing periodic` finds them.

        Args:
            speed_rpm: speed of the shaft; by default that at which it is prescribed or starts.
            shaft: joint that is the shaft; by default the only one that turns without limit and carries a hub.
            outputs: names and patterns of outputs; by default all.
            settings: start values.
            count: number of modes; 0 leaves them out, and their cost.
            harmonics: harmonics of the speed in `data`.
            steps: steps of a turn, rounded up to a multiple of 144.
            tolerance: distance of the ends of the turn: rotation in rad, or displacement over the machine's length.
            perturbations: maximum number of perturbations integrated for the modes.

        >>> from foldwing import load
        >>> turbine = load("examples/turbine/nrel_5mw.toml")
        >>> turn = turbine.periodic(12.1, outputs="body.blade1.deflection.*", count=0)
        >>> turn["body.blade1.deflection.y"].shape
        (145,)
        >>> f"{turn.amplitude('body.blade1.deflection.y', 1):.3f} m"
        '0.475 m'
        """
        names = [] if outputs is None else [outputs] if isinstance(outputs, str) else list(outputs)
        text = self._native.periodic_json(
            speed_rpm, shaft, _texts(settings), names, (steps, harmonics, count, perturbations), float(tolerance)
        )
        return Periodic(json.loads(text))

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
        """Power, thrust and loads of a rotor over wind, speed and pitch, as `foldwing operating-points` finds them.

        Args:
            wind_m_s: speeds of the wind, along the wind of the model.
            speed_rpm: speeds of the rotor; by default that of the model.
            tip_speed_ratio: gives the speed of the rotor; `speed_rpm` is then one value that is not exceeded.
            pitch_deg: pitch of all blades, positive as the pitch joints turn; by default that of the model.
            paired: values of the lists go together; else each goes with each of the others.
            solve_for: `("pitch_deg", begin, end)` or `("speed_rpm", begin, end)`: sought in this range.
            target: name and mean of the output for which it is sought, e.g. `("rotor.power", 5.3e6)`. Where the output is
                below that at `begin`, `begin` is kept.
            shaft: joint that is the shaft.
            pitch_joints: joints that pitch the blades; by default those that bear them on the hub.
            outputs: names and patterns of outputs; by default the rotor's, deflections, root loads, holding torques.
            settings: start values.
            steps: steps of a turn where the state is a periodic motion.
            tolerance: distance of the ends of such a turn.

        >>> from foldwing import load
        >>> turbine = load("examples/turbine/nrel_5mw_wind.toml")
        >>> table = turbine.operating_points(8.0, speed_rpm=9.16, pitch_deg=0.0, settings={"gravity.z": 0.0})
        >>> table.state, f"{table['rotor.power_coefficient'][0]:.2f}"
        (['periodic'], '0.48')
        """
        names = [] if outputs is None else [outputs] if isinstance(outputs, str) else list(outputs)
        text = self._native.operating_points_json(
            (_list(wind_m_s), _list(speed_rpm), _list(pitch_deg)),
            tip_speed_ratio,
            paired,
            None if solve_for is None else f"{solve_for[0]}={float(solve_for[1])!r}:{float(solve_for[2])!r}",
            None if target is None else f"{target[0]}={float(target[1])!r}",
            (shaft, ",".join(pitch_joints) or None),
            _texts(settings),
            names,
            steps,
            float(tolerance),
        )
        return OperatingPoints(json.loads(text))


class Periodic:
    """A motion that every turn repeats. `data` has everything that `foldwing periodic --json` prints, and the outputs over the turn."""

    def __init__(self, data: Dict[str, Any]) -> None:
        self.data = data
        """As the command prints it, with `turn_deg` and `values`."""
        self.turn_deg: NDArray[np.float64] = np.array(data["turn_deg"])
        """Turn of the shaft from the begin in degrees, its end included, shape (145,)."""
        self._places = {output["name"]: place for place, output in enumerate(data["outputs"])}
        modes = data.get("floquet", {}).get("modes", [])
        self.multipliers: NDArray[np.complex128] = np.array([complex(*mode["multiplier"]) for mode in modes], dtype=complex)
        """What a turn multiplies each mode by, shape (modes,)."""
        self.eigenvalues_1_s: NDArray[np.complex128] = np.array([complex(*mode["exponent_1_s"]) for mode in modes], dtype=complex)
        """Exponents in 1/s with the frequency that the ground sees, shape (modes,)."""
        self.motions: List[str] = [mode["motion"][0]["part"] if mode["motion"] else "" for mode in modes]
        """What moves most in each mode."""

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        """An output over the turn, shape (145,)."""
        return np.array(self.data["values"][self._place(name)])

    def mean(self, name: str) -> float:
        """Mean of an output over the turn."""
        return float(self.data["outputs"][self._place(name)]["mean"])

    def amplitude(self, name: str, harmonic: int) -> float:
        """Amplitude of a harmonic of the shaft's speed, from 1 on."""
        return float(self.data["outputs"][self._place(name)]["amplitudes"][harmonic - 1])

    @property
    def stable(self) -> bool:
        """No mode that was found grows; without modes nothing is known, and it is `True`."""
        return bool(np.all(np.abs(self.multipliers) <= 1.0 + 1e-4))

    def _place(self, name: str) -> int:
        if name not in self._places:
            raise KeyError(f"{name}: not among the outputs of this motion; there are {', '.join(list(self._places)[:8])}, …")
        return self._places[name]

    def __repr__(self) -> str:
        data = self.data
        return f"<foldwing.Periodic of {data['name']} at {data['rotor_speed_rpm']:.6g} rpm: {len(self._places)} outputs, {len(self.motions)} modes>"


class OperatingPoints:
    """Operating points of a rotor. `data` has everything that `foldwing operating-points --json` prints."""

    def __init__(self, data: Dict[str, Any]) -> None:
        self.data = data
        """As the command prints it."""
        points = data["points"]
        self.wind_m_s: NDArray[np.float64] = _numbers([point["wind_m_s"] for point in points])
        """Wind in m/s, shape (points,)."""
        self.speed_rpm: NDArray[np.float64] = _numbers([point["rotor_speed_rpm"] for point in points])
        """Speed of the rotor in rpm, shape (points,)."""
        self.pitch_deg: NDArray[np.float64] = _numbers([point["pitch_deg"] for point in points])
        """Pitch in degrees, shape (points,)."""
        self.state: List[str] = [point["state"] for point in points]
        """`steady`, `periodic`, or `none` where no state was found, of which `data` has the message."""
        self.held: List[Optional[str]] = [point["hold"] for point in points]
        """`held`, or `below` where the output is less than asked at the begin of the range; `None` if nothing was to be held."""
        self._places = {output["name"]: place for place, output in enumerate(data["outputs"])}

    def __len__(self) -> int:
        return len(self.wind_m_s)

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        """Mean of an output at each point, shape (points,)."""
        return self._column(name, "mean")

    def peak_to_peak(self, name: str) -> NDArray[np.float64]:
        """Range of an output over a turn at each point, shape (points,); 0 where the state is steady."""
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


def _texts(settings: Optional[Mapping[str, Start]]) -> List[str]:
    """Start values as the command line has them."""

    def text(value: Start) -> str:
        return str(int(value)) if isinstance(value, (bool, np.bool_, Integral)) else repr(float(value))

    return [f"{name}={text(value)}" for name, value in (settings or {}).items()]


def _list(values: Optional[Values]) -> Optional[List[float]]:
    return None if values is None else np.atleast_1d(np.asarray(values, dtype=np.float64)).tolist()


def _numbers(values: List[Any]) -> NDArray[np.float64]:
    return np.array([np.nan if value is None else value for value in values], dtype=np.float64)
