"""What the package raises. The messages are those of the command: place, value, what is allowed, the cure."""

from __future__ import annotations

from typing import TYPE_CHECKING, List, Optional, Tuple

if TYPE_CHECKING:
    from .result import Result


class FoldwingError(Exception):
    """All that Foldwing refuses or gives up; the kinds below are those of the command's exit codes."""


class ModelError(FoldwingError, ValueError):
    """A refused model file.

    Attributes:
        problems: line from 1, path of the key (`body.inner.length_m`) and text of everything that is wrong.
    """

    problems: List[Tuple[int, str, str]] = []


class UsageError(FoldwingError, ValueError):
    """A name that does not exist, or a value that is not allowed."""


class SimulationError(FoldwingError, RuntimeError):
    """A simulation that gave up.

    Attributes:
        result: the run up to the last good time, where there was one.
    """

    result: Optional[Result] = None


class StaticsError(FoldwingError, RuntimeError):
    """Statics, modes or a linear model that gave up."""


class FilesError(FoldwingError, OSError):
    """A file that cannot be read or written, or that is not overwritten."""
