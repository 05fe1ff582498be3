"""Paths of the models, and the command with which the package is compared."""

import os
import shutil
from pathlib import Path

import pytest

import foldwing as fw

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(autouse=True)
def at_the_root(monkeypatch):
    """Paths in examples are relative to the root of the repository."""
    monkeypatch.chdir(ROOT)


@pytest.fixture(scope="session")
def wing():
    """The shipped wing."""
    return fw.load(ROOT / "examples/models/folding_wing.toml")


@pytest.fixture(scope="session")
def command():
    """The command built by `make`."""
    path = os.environ.get("FOLDWING") or shutil.which("foldwing")
    assert path, "set FOLDWING to the command"
    return path
