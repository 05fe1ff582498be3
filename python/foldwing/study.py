"""What statics, modes, flutter and trim give."""

from __future__ import annotations

from typing import Any, Dict, List, Mapping, Optional, Sequence

import numpy as np
from numpy.typing import NDArray

from .variable import Start


_VERDICTS = {True: "stable", False: "UNSTABLE", None: "stability not judged"}


class Equilibrium:
    """The machine at rest. `data` has everything that `foldwing static --json` prints."""

    def __init__(self, data: Dict[str, Any]) -> None:
        self.data = data
        """As the command prints it."""
        self.joints: Dict[str, Dict[str, Any]] = {joint["name"]: joint for joint in data["joints"]}
        """Joints by name: `angle_rad`, `applied_torque_N_m`, `latch_torque_N_m`, `latched`."""
        self.gauges: Dict[str, float] = {gauge["name"]: gauge["strain"] for gauge in data["gauges"]}
        """Strains of the gauges by name."""
        self.root_force_N: NDArray[np.float64] = np.array(data["root"]["force_N"])
        """Force of the machine on the root in N, root frame, shape (3,)."""
        self.root_moment_N_m: NDArray[np.float64] = np.array(data["root"]["moment_N_m"])
        """Moment of the machine on the root in N·m, root frame, shape (3,)."""

    @property
    def stable(self) -> Optional[bool]:
        """The machine, with its air, stays there by itself; `None` where that is not judged, for the reason
        `data["stability"]["not_judged"]`."""
        stable: Optional[bool] = self.data["stability"]["stable"]
        return stable

    def shape(self, body: str) -> NDArray[np.float64]:
        """Positions in m of the sections of a body, root frame, from the inner end on, shape (sections, 3)."""
        return np.array([section["position_m"] for section in _named(self.data["bodies"], body)["sections"]])

    def strain(self, body: str) -> NDArray[np.float64]:
        """Strains `(εx, κx, κy, κz)` in 1 and 1/m at the sections of a body, shape (sections, 4)."""
        return np.array([section["strain"] for section in _named(self.data["bodies"], body)["sections"]])

    def __repr__(self) -> str:
        joints = ", ".join(f"{name} at {next(v for k, v in joint.items() if k != 'name'):.4f}" for name, joint in self.joints.items())
        return f"<foldwing.Equilibrium of {self.data['name']}: {joints or 'no joints'}; {_VERDICTS[self.stable]}>"


class Modes:
    """Natural modes, lowest frequency first. `data` has everything that `foldwing modes --json` prints."""

    def __init__(self, data: Dict[str, Any]) -> None:
        self.data = data
        """As the command prints it."""
        modes = data["modes"]
        self.eigenvalues_1_s: NDArray[np.complex128] = np.array([complex(*mode["eigenvalue_1_s"]) for mode in modes])
        """Eigenvalues in 1/s, of pairs the one with positive imaginary part, shape (modes,)."""
        self.frequency_Hz: NDArray[np.float64] = _numbers([mode["frequency_Hz"] for mode in modes])
        """`|λ|/2π` in Hz, NaN where a mode does not oscillate, shape (modes,)."""
        self.damping_ratio: NDArray[np.float64] = _numbers([mode["damping_ratio"] for mode in modes])
        """`−Re λ/|λ|`, NaN where a mode does not oscillate, shape (modes,)."""

    def __len__(self) -> int:
        return len(self.eigenvalues_1_s)

    def shape(self, mode: int, body: str) -> NDArray[np.complex128]:
        """Displacements of the sections of a body in a mode, root frame, shape (sections, 3); the largest motion is 1 in all."""
        parts = [_named(self.data["modes"][mode][part], body)["sections"] for part in ("shape", "shape_imaginary")]
        real, imaginary = (np.array([section["displacement_m"] for section in part]) for part in parts)
        return np.asarray(real + 1j * imaginary)

    def __repr__(self) -> str:
        return f"<foldwing.Modes of {self.data['name']}: {', '.join(f'{f:.4g}' for f in self.frequency_Hz)} Hz>"


class Flutter:
    """Modes over the speed of the wind. `data` has an entry of `results` of what `foldwing flutter --json` prints."""

    def __init__(self, name: str, data: Dict[str, Any]) -> None:
        self.name = name
        """Name of the machine."""
        self.data = data
        """As the command prints it."""
        self.speed_m_s: NDArray[np.float64] = np.array([place["speed_m_s"] for place in data["modes"]])
        """Speeds in m/s, those asked for and those between that the modes needed, shape (speeds,)."""
        nowhere = complex(np.nan, np.nan)
        eigenvalues = [[nowhere if mode is None else complex(*mode) for mode in place["eigenvalues_1_s"]] for place in data["modes"]]
        self.eigenvalues_1_s: NDArray[np.complex128] = np.array(eigenvalues)
        """Eigenvalues in 1/s of each mode over the speed, NaN where it was not found, shape (speeds, modes)."""
        self.flutter_m_s: NDArray[np.float64] = np.array([found["speed_m_s"] for found in data["flutter"] if found["begins"]])
        """Speeds in m/s at which an oscillation begins to grow, shape (found,)."""
        self.flutter_Hz: NDArray[np.float64] = np.array([found["frequency_Hz"] for found in data["flutter"] if found["begins"]])
        """Their frequencies in Hz, shape (found,)."""
        self.divergence_m_s: NDArray[np.float64] = np.array(data["divergence_m_s"], dtype=np.float64)
        """Speeds of divergence in m/s, shape (found,)."""
        self.changes: List[Dict[str, Any]] = list(data["changes"])
        """What else happens between two speeds: `kind` ("latch", "jump" of the equilibrium, "unstable": a mode that grows, "divergence":
        a change of sign whose speed is not found), `between_m_s`, `text`."""
        self.modes_tracked: int = int(data["modes_tracked"])
        """Number of modes tracked."""

    @property
    def frequency_Hz(self) -> NDArray[np.float64]:
        """`|λ|/2π` in Hz, NaN where a mode does not oscillate, shape (speeds, modes)."""
        size = np.abs(self.eigenvalues_1_s)
        return np.where(self.eigenvalues_1_s.imag == 0.0, np.nan, size / (2.0 * np.pi))

    @property
    def damping_ratio(self) -> NDArray[np.float64]:
        """`−Re λ/|λ|`, NaN where a mode does not oscillate, negative where it grows, shape (speeds, modes)."""
        size = np.abs(self.eigenvalues_1_s)
        oscillates = (self.eigenvalues_1_s.imag != 0.0) & (size > 0.0)
        return np.where(oscillates, -self.eigenvalues_1_s.real / np.where(size > 0.0, size, 1.0), np.nan)

    def __repr__(self) -> str:
        flutter = ", ".join(f"flutter at {speed:.6g} m/s with {hertz:.6g} Hz" for speed, hertz in zip(self.flutter_m_s, self.flutter_Hz))
        divergence = ", ".join(f"divergence at {speed:.6g} m/s" for speed in self.divergence_m_s)
        changes = "; ".join("between {:g} and {:g} m/s: {}".format(*change["between_m_s"], change["text"]) for change in self.changes)
        first = f"unstable from {self.speed_m_s[0]:g} m/s on" if self.data["unstable_from_first"] else ""
        none = f"neither flutter nor divergence up to {self.speed_m_s[-1]:g} m/s, {self.modes_tracked} modes tracked"
        ended = f"; ended: {self.data['ended']['message']}" if self.data["ended"] else ""
        return f"<foldwing.Flutter of {self.name}: {'; '.join(filter(None, [first, flutter, divergence, changes])) or none}{ended}>"


class FlutterMap:
    """Speeds of flutter and divergence over a quantity."""

    def __init__(self, name: str, over: str, values: Sequence[Any], results: Sequence[Flutter]) -> None:
        self.name = name
        """Name of the machine."""
        self.over = over
        """Key of the quantity."""
        self.values = list(values)
        """Its values."""
        self.results = list(results)
        """What was found at each of them."""
        self.flutter_m_s: NDArray[np.float64] = _numbers([_first(found.flutter_m_s) for found in results])
        """Lowest speeds of flutter in m/s, NaN where there is none, shape (values,)."""
        self.flutter_Hz: NDArray[np.float64] = _numbers([_first(found.flutter_Hz) for found in results])
        """Their frequencies in Hz, shape (values,)."""
        self.divergence_m_s: NDArray[np.float64] = _numbers([_first(found.divergence_m_s) for found in results])
        """Lowest speeds of divergence in m/s, NaN where there is none, shape (values,)."""

    def __repr__(self) -> str:
        return f"<foldwing.FlutterMap of {self.name} over {self.over}: {len(self.values)} values>"


class Trim:
    """A trim. `data` has everything that `foldwing trim --json` prints."""

    def __init__(self, data: Dict[str, Any], settings: Mapping[str, Start]) -> None:
        self.data = data
        """As the command prints it."""
        self.free: Dict[str, float] = dict(data["free"])
        """Values found, by name."""
        self.balances: Dict[str, float] = dict(data["balances"])
        """What the outputs are at rest, by name."""
        self.settings: Dict[str, Start] = {**settings, **data["settings"]}
        """The start values given with those found: `settings=` of other studies and runs."""

    def __repr__(self) -> str:
        found = ", ".join(f"{name} = {value:.6g}" for name, value in self.free.items())
        return f"<foldwing.Trim of {self.data['name']}: {found}>"


def _first(speeds: NDArray[np.float64]) -> Optional[float]:
    return float(speeds[0]) if len(speeds) else None


def _named(entries: List[Dict[str, Any]], name: str) -> Dict[str, Any]:
    for entry in entries:
        if entry["name"] == name:
            return entry
    raise KeyError(f"no body is named {name}; there are {', '.join(entry['name'] for entry in entries)}")


def _numbers(values: List[Any]) -> NDArray[np.float64]:
    return np.array([np.nan if value is None else value for value in values], dtype=np.float64)
