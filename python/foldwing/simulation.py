"""A machine stepped by its owner."""

from __future__ import annotations

from typing import TYPE_CHECKING, List, Tuple, Union

from . import _native

if TYPE_CHECKING:
    from .model import Model


class Simulation(_native.Simulation):
    """A run in steps: set inputs, step, read outputs; save a state and go back to it. `Model.start` makes one.

    >>> import foldwing as fw
    >>> sim = fw.load("examples/models/folding_wing.toml").start()
    >>> state = sim.save()
    >>> sim.step(0.05)
    >>> first = sim["fold.angle"]
    >>> sim.restore(state)
    >>> sim.step(0.05)
    >>> sim["fold.angle"] == first
    True
    >>> sim["tip.position"].shape
    (3,)
    """

    def __new__(cls, model: Model, settings: List[Tuple[str, Union[float, int, bool]]]) -> Simulation:
        """Not started yet."""
        return super().__new__(cls, model._native, settings)

    def __init__(self, model: Model, settings: List[Tuple[str, Union[float, int, bool]]]) -> None:
        self.model = model
        """The machine."""

    def __repr__(self) -> str:
        return f"<foldwing.Simulation of {self.model.name} at {self.time:g} s>"
