"""Step-by-step simulation."""

from __future__ import annotations

from typing import TYPE_CHECKING, List, Tuple, Union

from . import _native

if TYPE_CHECKING:
    from .model import Model


class Simulation(_native.Simulation):
    """Step-by-step simulation: set inputs, step, read outputs, save and restore states. Created by `Model.start`.

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
        """Create a simulation without starting it."""
        return super().__new__(cls, model._native, settings)

    def __init__(self, model: Model, settings: List[Tuple[str, Union[float, int, bool]]]) -> None:
        self.model = model
        """Simulated model."""

    def __repr__(self) -> str:
        return f"<foldwing.Simulation of {self.model.name} at {self.time:g} s>"
