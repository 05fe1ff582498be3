"""Builds the wheel: first the library that goes into FMUs with cargo, then the package with
maturin.

`FOLDWING_LIBRARY` names a library that is already built, e.g. one for older systems.
"""

import os
import shutil
import subprocess
from pathlib import Path

from maturin import *  # noqa: F403  the other hooks
import maturin

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "python/foldwing"
NAMES = ["libfoldwing_fmu.so", "libfoldwing_fmu.dylib", "foldwing_fmu.dll"]


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    """Build the wheel, with the library next to the modules during the build."""
    copy = PACKAGE / library().name
    shutil.copyfile(library(), copy)
    try:
        return maturin.build_wheel(wheel_directory, config_settings, metadata_directory)
    finally:
        copy.unlink()


def library():
    """Path of the library that goes into FMUs, which is built if none is given."""
    given = os.environ.get("FOLDWING_LIBRARY")
    if given:
        return Path(given)
    cargo = os.environ.get("CARGO", "cargo")
    # built together with the module, so that common dependencies are compiled once
    packages = ["--package", "foldwing-fmu", "--package", "foldwing-python"]
    subprocess.run([cargo, "build", "--release", "--locked", *packages], cwd=ROOT, check=True)
    folder = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release"
    found = [folder / name for name in NAMES if (folder / name).is_file()]
    if not found:
        raise FileNotFoundError(f"{folder}: cargo has built no library")
    return found[0]
