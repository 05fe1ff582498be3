"""Optional dependencies, imported on first use: `pip install ".[all]"` in a clone installs all of them."""

from __future__ import annotations

import importlib
from typing import Any


def needed(module: str) -> Any:
    """Import an optional module; the ImportError gives the install command (package name = top-level module)."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        package = module.split(".")[0]
        raise ImportError(f"{package} is not installed; type: pip install {package}") from error
