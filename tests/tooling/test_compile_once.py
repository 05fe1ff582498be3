"""Every build compiles the shared packages with the same features, so that `make test` reuses the packages that `make` has compiled."""

import os
import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]

# the builds of `make test` in addition to `cargo build`, by the arguments that select packages and features; build scripts and macros are
# excluded, because they have separate features
BUILDS = {
    "tests": ["--edges", "normal,dev"],
    "foldwing run": ["--edges", "normal", "--features", "import"],
    "documents": ["--edges", "normal,dev", "--features", "import"],
    "engine of pages": ["--edges", "normal,dev", "--package", "foldwing-web"],
    "Python package": ["--edges", "normal", "--package", "foldwing-python"],
}


def features(arguments):
    """Feature sets of every registry package, by name and version; a package also used by macros may have two."""
    cargo = os.environ.get("CARGO", "cargo")
    command = [cargo, "tree", "--locked", "--prefix", "none", "--format", "{p} [{f}]", *arguments]
    tree = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    lines = (re.sub(r" \((\*|proc-macro)\)", "", line) for line in tree.splitlines())
    sets = {}
    for name, chosen in (line.rsplit(" [", 1) for line in lines if " [" in line and not line.startswith("foldwing")):
        sets.setdefault(name, set()).add(chosen)
    return sets


@pytest.mark.parametrize("build", BUILDS)
def test_features_are_those_of_the_library_that_ships(build):
    ships, other = features(["--edges", "normal"]), features(BUILDS[build])
    assert len(ships) > 100
    differ = {name: (ships[name], other[name]) for name in ships.keys() & other.keys() if not ships[name] <= other[name]}
    assert not differ, f"{build}: name these features in crates/command/Cargo.toml, or the packages compile again: {differ}"
