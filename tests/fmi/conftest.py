"""Fixtures of the FMI tests: the packaged FMUs and instances of them, all through FMPy.

`make pytest` says where things are: FOLDWING is the command, FOLDWING_FMUS the folder with the FMU of every shipped model.
"""

import os
from pathlib import Path

import pytest
from driving import Fmu

ROOT = Path(__file__).resolve().parents[2]
MODELS = sorted(path.stem for path in (ROOT / "examples/models").glob("*.toml"))


def from_environment(name):
    """A path that `make pytest` hands over."""
    if name not in os.environ:
        pytest.exit(f"{name} is not set; run the tests with `make pytest`", returncode=2)
    return Path(os.environ[name])


@pytest.fixture(scope="session")
def foldwing():
    """Path of the command."""
    return from_environment("FOLDWING")


@pytest.fixture(scope="session")
def fmus(tmp_path_factory):
    """Every shipped model's FMU by the name of its model file, unpacked once."""
    folder = from_environment("FOLDWING_FMUS")
    return {model: Fmu(folder / f"{model}.fmu", tmp_path_factory.mktemp(model)) for model in MODELS}


@pytest.fixture(scope="session")
def wing(fmus):
    """FMU of the folding wing with linear elements, the one that `make` unfolds."""
    return fmus["folding_wing"]


@pytest.fixture(scope="session", params=["folding_wing", "folding_wing_constant"])
def either_wing(request, fmus):
    """FMU of the folding wing, with either kind of element."""
    return fmus[request.param]


@pytest.fixture(scope="session", params=MODELS)
def shipped(request, fmus):
    """FMU of each shipped model in turn."""
    return fmus[request.param]
