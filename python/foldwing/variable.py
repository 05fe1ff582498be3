"""Variables of a model, and the summary of `Model.check`."""

from __future__ import annotations

from typing import Any, Dict, List, Mapping, NamedTuple, Optional, Tuple, Union

Start = Union[float, int, bool]
# `Any`: a number or Boolean, or a sequence or array for a vector
Settings = Optional[Mapping[str, Any]]
"""Start values by name; the name of a vector (`gravity`) sets all its components."""


class Variable(NamedTuple):
    """Variable of the FMU."""

    name: str
    """Name, e.g. `fold.angle`."""
    causality: str
    """`input`, `output`, `parameter`, `local` or `independent`."""
    variability: str
    """`fixed`, `tunable`, `discrete` or `continuous`."""
    type: str
    """`Real`, `Integer` or `Boolean`."""
    unit: str
    """Unit, e.g. `N.m`; `1` or empty if dimensionless."""
    start: Start
    """Start value of inputs and parameters."""
    range: Optional[Tuple[float, float]]
    """Minimum and maximum value allowed."""
    description: str
    """Description: meaning, frame and sign."""


class Summary(str):
    """Summary of `Model.check`: a string, with the data of `foldwing check --json` in `data`."""

    data: Dict[str, Any]

    def __new__(cls, text: str, data: Dict[str, Any]) -> Summary:
        summary = super().__new__(cls, text)
        summary.data = data
        return summary

    @property
    def notes(self) -> List[str]:
        """Remarks about a valid model."""
        return list(self.data["notes"])

    @property
    def warnings(self) -> List[str]:
        """Warnings about the model: wind from behind, a latch that cannot be reached, implausible sizes."""
        return list(self.data["assessment"]["warnings"])

    def __repr__(self) -> str:
        return str(self)
