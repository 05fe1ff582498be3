"""What statics and modes give."""

from __future__ import annotations

from typing import Any, Dict, List

import numpy as np
from numpy.typing import NDArray


class Rest:
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
    def stable(self) -> bool:
        """The machine stays there by itself."""
        return bool(self.data["stability"]["stable"])

    def shape(self, body: str) -> NDArray[np.float64]:
        """Positions in m of the sections of a body, root frame, from the inner end on, shape (sections, 3)."""
        return np.array([section["position_m"] for section in _named(self.data["bodies"], body)["sections"]])

    def strain(self, body: str) -> NDArray[np.float64]:
        """Strains `(εx, κx, κy, κz)` in 1 and 1/m at the sections of a body, shape (sections, 4)."""
        return np.array([section["strain"] for section in _named(self.data["bodies"], body)["sections"]])

    def __repr__(self) -> str:
        joints = ", ".join(f"{name} at {next(v for k, v in joint.items() if k != 'name'):.4f}" for name, joint in self.joints.items())
        return f"<foldwing.Rest of {self.data['name']}: {joints or 'no joints'}; {'stable' if self.stable else 'UNSTABLE'}>"


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


def _named(entries: List[Dict[str, Any]], name: str) -> Dict[str, Any]:
    for entry in entries:
        if entry["name"] == name:
            return entry
    raise KeyError(f"no body is named {name}; there are {', '.join(entry['name'] for entry in entries)}")


def _numbers(values: List[Any]) -> NDArray[np.float64]:
    return np.array([np.nan if value is None else value for value in values], dtype=np.float64)
