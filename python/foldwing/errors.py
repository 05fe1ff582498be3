"""Exceptions. Messages are those of the command: location, value, allowed values, remedy."""

from __future__ import annotations

from typing import TYPE_CHECKING, List, Optional, Tuple

if TYPE_CHECKING:
    from .result import Result


class FoldwingError(Exception):
    """Base class of all Foldwing errors; the subclasses correspond to the exit codes of the command."""


class ModelError(FoldwingError, ValueError):
    """Invalid model file.

    Attributes:
        problems: line (from 1), path of the key (`body.inner.length_m`) and message of every problem.
    """

    problems: List[Tuple[int, str, str]] = []


class UsageError(FoldwingError, ValueError):
    """Unknown name, or value that is not allowed."""


class ArgumentError(UsageError, TypeError):
    """Argument of a wrong type, or an unknown or missing argument."""


class SimulationError(FoldwingError, RuntimeError):
    """Failed simulation.

    Attributes:
        result: results up to the last valid time, if any.
    """

    result: Optional[Result] = None


class StaticsError(FoldwingError, RuntimeError):
    """Failed computation of an equilibrium, modes or a linear model."""


class FilesError(FoldwingError, OSError):
    """File that cannot be read or written, or must not be overwritten."""
