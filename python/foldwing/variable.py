"""What a model says of itself: its variables, and what `check` has understood."""

from __future__ import annotations

from typing import Any, Dict, List, NamedTuple, Optional, Tuple, Union

Start = Union[float, int, bool]


class Variable(NamedTuple):
    """A variable as the FMU has it."""

    name: str
    """Name, e.g. `fold.angle`."""
    causality: str
    """`input`, `output`, `parameter`, `local` or `independent`."""
    variability: str
    """`fixed`, `tunable`, `discrete` or `continuous`."""
    type: str
    """`Real`, `Integer` or `Boolean`."""
    unit: str
    """Unit, e.g. `N.m`; `1` or empty without one."""
    start: Start
    """Start value of inputs and parameters."""
    range: Optional[Tuple[float, float]]
    """Smallest and largest value allowed."""
    description: str
    """One sentence: meaning, frame, sign."""


class Summary(str):
    """What `Model.check` says: a text, with the same in `data` as `foldwing check --json` has it."""

    data: Dict[str, Any]

    def __new__(cls, text: str, data: Dict[str, Any]) -> Summary:
        summary = super().__new__(cls, text)
        summary.data = data
        return summary

    @property
    def notes(self) -> List[str]:
        """What to know of the model although it is valid."""
        return list(self.data["notes"])

    def __repr__(self) -> str:
        return str(self)
