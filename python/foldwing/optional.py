"""Packages that are asked for only by what needs them: `pip install foldwing[all]` brings all of them."""

from __future__ import annotations

import importlib
from typing import Any

_EXTRAS = {"pandas": "pandas", "xarray": "xarray", "matplotlib.pyplot": "plot", "control": "control", "tqdm.auto": "progress"}


def needed(module: str) -> Any:
    """The module, or an ImportError that says how to get it."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        package = module.split(".")[0]
        raise ImportError(f'{package} is not installed; type: pip install "foldwing[{_EXTRAS[module]}]"') from error
