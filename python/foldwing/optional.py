"""Packages that are asked for only by what needs them: `pip install ".[all]"` in a clone brings all of them."""

from __future__ import annotations

import importlib
from typing import Any


def needed(module: str) -> Any:
    """The module, or an ImportError that says how to get it: here a package has the name of its outermost module."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        package = module.split(".")[0]
        raise ImportError(f"{package} is not installed; type: pip install {package}") from error
