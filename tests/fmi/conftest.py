"""Fixtures of the FMI tests: the packaged FMUs and instances of them, all through FMPy.

`make pytest` sets the paths: FOLDWING is the command, FOLDWING_FMUS the folder with the FMU of every shipped model.
"""

import os
import re
from pathlib import Path

import lark
import pytest
from browser import Browser
from driving import Fmu

ROOT = Path(__file__).resolve().parents[2]
MODELS = sorted(path.stem for path in (ROOT / "examples/models").glob("*.toml"))
# Whether studies run in full, as in `make validate`; `make test` runs a short version of each.
WHOLE = "FOLDWING_WHOLE" in os.environ
whole = pytest.mark.skipif(not WHOLE, reason="long: `make validate` runs it")


class Remembering(lark.Lark):
    """FMPy's parser of variable names with a cache: names already accepted by its grammar are not parsed again, nor names that differ only
    in a number, which the grammar does not distinguish. The same result in a tenth of the time."""

    accepted = set()

    def parse(self, text, *arguments, **options):
        key = self.source_grammar, re.sub(r"[0-9]+", "1", text)
        if key not in self.accepted:
            super().parse(text, *arguments, **options)
            self.accepted.add(key)


lark.Lark = Remembering


class Unpacked(dict):
    """Every shipped model's FMU by the name of its model file, unpacked at its first use."""

    def __init__(self, archives, unpack):
        super().__init__()
        self.archives, self.unpack = archives, unpack

    def __missing__(self, model):
        self[model] = Fmu(self.archives / f"{model}.fmu", self.unpack(model))
        return self[model]


def from_environment(name):
    """A path set by `make pytest`."""
    if name not in os.environ:
        pytest.exit(f"{name} is not set; run the tests with `make pytest`", returncode=2)
    return Path(os.environ[name])


@pytest.fixture(scope="session")
def foldwing():
    """Path of the command."""
    return from_environment("FOLDWING")


@pytest.fixture(scope="session")
def browser():
    """One browser for all pages."""
    with Browser() as opened:
        yield opened


@pytest.fixture(scope="session")
def fmus(tmp_path_factory):
    """Every shipped model's FMU by the name of its model file, unpacked once."""
    return Unpacked(from_environment("FOLDWING_FMUS"), tmp_path_factory.mktemp)


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
