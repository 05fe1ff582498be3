"""Step-by-step simulation."""

from __future__ import annotations

import time as clock
from typing import TYPE_CHECKING, List, Optional, Sequence, Tuple, Union

from . import _native, live
from .errors import UsageError

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
        self.late_s = 0.0
        """Wall-clock delay in s at the end of the last paced step; 0 if it was on time."""
        self._pace: Optional[Tuple[float, float, float, float]] = None

    def _ipython_key_completions_(self) -> List[str]:
        return [*self.model.variables, *self.model._vectors]

    def step(self, step: float, *, speed: Optional[float] = None) -> None:
        """Advance by `step` s with the current inputs. Latch events inside the step occur at their exact time.

        Args:
            step: length of the step in s.
            speed: simulated seconds per second of wall-clock time: the call returns when the wall clock has reached the end of the step.
                1 is real time, as on a test rig or for a human operator in the loop. The schedule starts with the first of consecutive
                paced steps, so that the next steps make up for a single late one; `late_s` is the delay at the end of this step. Default:
                as fast as possible.
        """
        if speed is None:
            super().step(step)
            self._pace = None
            return
        if not 0.0 < speed < float("inf"):
            raise UsageError(f"speed={speed}: must be a positive, finite number of simulated seconds per second")
        if self._pace is None or self._pace[:2] != (speed, self.time):
            self._pace = (speed, self.time, clock.monotonic(), self.time)
        _, _, began_s, from_s = self._pace
        super().step(step)
        self._pace = (speed, self.time, began_s, from_s)
        left_s = began_s + (self.time - from_s) / speed - clock.monotonic()
        self.late_s = max(0.0, -left_s)
        if left_s > 0.0:
            clock.sleep(left_s)

    def view(self, *, compare: Union[Simulation, Sequence[Simulation]] = (), port: int = 0, speed: float = 1.0, show: bool = True) -> live.Live:
        """Show the model live in the browser, starting from its current state and paced by the wall clock; on the page one can run and pause
        it, roll back, set inputs and parameters, and pull on it with a spring. The command `foldwing live` serves the page in a
        separate process: this simulation is not changed. Other simulations can run in step with it: one clock, drawn together, shared sliders.

        >>> import foldwing as fw
        >>> sim = fw.load("examples/models/folding_wing.toml").start()
        >>> sim.step(0.05)
        >>> with sim.view(show=False) as shown:
        ...     shown.running
        True
        >>> shown.running
        False

        Args:
            compare: another simulation, or up to three, with the same `time`.
            port: port of this computer's loopback address; 0 takes any free one.
            speed: simulated seconds per second of wall-clock time; the page can change it.
            show: if false, start no browser; `Live.address` is the address of the page.

        Returns:
            The live simulation; it ends when its page is closed.

        Raises:
            FilesError: if the port is in use.
            UsageError: if a simulation in `compare` has a different time, or there are more than three.
        """
        others = [compare] if isinstance(compare, Simulation) else list(compare)
        if len(others) > 3:
            raise UsageError(f"compare: {len(others)} simulations; at most 3 can be shown besides this one")
        for number, other in enumerate(others):
            if other.time != self.time:
                raise UsageError(f"compare[{number}]: is at {other.time} s and this simulation at {self.time} s, but they have one clock: step to one time")
        return live.start([(one.model.text, one.save().to_bytes()) for one in (self, *others)], port, speed, show)

    def __repr__(self) -> str:
        return f"<foldwing.Simulation of {self.model.name} at {self.time:g} s>"
