"""Type checks of arguments against the annotations of a function."""

from __future__ import annotations

import collections.abc
import functools
import inspect
import os
import reprlib
import sys
from difflib import get_close_matches
from typing import Any, Callable, Dict, Iterator, List, Tuple, Type, TypeVar, Union, get_args, get_origin

import numpy as np

from .errors import ArgumentError

C = TypeVar("C")
F = TypeVar("F", bound=Callable[..., Any])

_WORDS: Dict[Any, str] = {float: "a number", int: "an integer", bool: "True or False", str: "text", type(None): "None", os.PathLike: "a path"}


def checked_methods(cls: Type[C]) -> Type[C]:
    """Check the arguments of all public methods of a class, as `checked` does."""
    for name, member in list(vars(cls).items()):
        if name.startswith("_"):
            continue
        if isinstance(member, classmethod):
            setattr(cls, name, classmethod(checked(member.__func__)))
        elif inspect.isfunction(member):
            setattr(cls, name, checked(member))
    return cls


def checked(function: F) -> F:
    """Check the types of a function's arguments against its annotations before it runs.

    A number is any object that converts to one (also scalars of NumPy and other libraries), except text and Booleans. Items of lists and
    tuples are checked too; those of other iterables are not, as a check could exhaust them. Annotations of other types, and of types
    that are imported only for type checkers, are not checked.

    The function raises `ArgumentError`, with the name of the argument, its value and the allowed ones.
    """
    signature = inspect.signature(function)
    hints: Dict[str, Any] = {}

    @functools.wraps(function)
    def wrapper(*args: Any, **kwargs: Any) -> Any:
        if not hints:
            hints.update((name, _resolved(parameter.annotation, function)) for name, parameter in signature.parameters.items())
        try:
            bound = signature.bind(*args, **kwargs)
        except TypeError as error:
            raise ArgumentError(f"{function.__name__}: {_mismatch(str(error), kwargs, list(signature.parameters))}") from None
        for name, value in bound.arguments.items():
            kind = signature.parameters[name].kind
            if kind not in (inspect.Parameter.VAR_POSITIONAL, inspect.Parameter.VAR_KEYWORD) and not _fits(value, hints[name]):
                raise ArgumentError(f"{name}={reprlib.repr(value)}: must be {_described(hints[name])}")
        return function(*args, **kwargs)

    return wrapper  # type: ignore[return-value]


def _mismatch(text: str, given: Dict[str, Any], allowed: List[str]) -> str:
    """Message about arguments that do not match a signature, with the name that is closest to an unknown one."""
    named = [name for name in allowed if name not in ("self", "cls")]
    unknown = next((name for name in given if name not in named), None)
    if unknown is None:
        return text
    close = get_close_matches(unknown, named, 1)
    others = ", ".join(named)
    return f"no argument is named {unknown!r}; " + (f"did you mean {close[0]!r}?" if close else f"its arguments are {others}")


def _resolved(annotation: Any, function: Callable[..., Any]) -> Any:
    """Type of an annotation; `Any` if it is missing or names a type that is not imported at run time."""
    if annotation is inspect.Parameter.empty:
        return Any
    if not isinstance(annotation, str):
        return annotation
    try:
        return eval(annotation, sys.modules[function.__module__].__dict__)
    except NameError:
        return Any


def _parts(hint: Any) -> Iterator[Any]:
    """Members of a union, or the type itself."""
    if get_origin(hint) is Union:
        for part in get_args(hint):
            yield from _parts(part)
    else:
        yield type(None) if hint is None else hint


def _fits(value: Any, hint: Any) -> bool:
    return any(_fits_one(value, part) for part in _parts(hint))


def _fits_one(value: Any, hint: Any) -> bool:
    origin = get_origin(hint) or hint
    if hint is Any or isinstance(origin, str) or getattr(origin, "_is_protocol", False):
        # strings are forward references inside a union
        return True
    if origin is float:
        return hasattr(value, "__float__") and not isinstance(value, (bool, np.bool_)) and np.ndim(value) == 0
    if origin is int:
        return hasattr(value, "__index__") and not isinstance(value, (bool, np.bool_)) and np.ndim(value) == 0
    if origin is bool:
        return isinstance(value, (bool, np.bool_))
    if origin in (collections.abc.Iterable, collections.abc.Sequence):
        items: Tuple[Any, ...] = get_args(hint) or (Any,)
        if isinstance(value, (str, bytes)) or not isinstance(value, (collections.abc.Iterable, np.ndarray)):
            return False
        return not isinstance(value, (list, tuple)) or all(_fits(item, items[0]) for item in value)
    return not isinstance(origin, type) or isinstance(value, origin)


def _described(hint: Any) -> str:
    """Text for the allowed types: `a number, or None`."""
    words: List[str] = []
    for part in _parts(hint):
        origin = get_origin(part) or part
        if origin in (collections.abc.Iterable, collections.abc.Sequence):
            item = _WORDS.get((get_args(part) or (Any,))[0], "values").split(" ")[-1]
            word = "several texts" if item == "text" else f"several {item}s" if item in ("number", "integer") else "several values"
        elif origin is collections.abc.Callable:
            word = "a function"
        elif origin is collections.abc.Mapping:
            word = "a mapping"
        else:
            word = _WORDS.get(origin, getattr(origin, "__name__", str(origin)))
        if word not in words:
            words.append(word)
    words.sort(key=lambda word: word == "None")
    return " or ".join(words)
