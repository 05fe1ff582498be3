"""The build of the wheel: the library that goes into FMUs by cargo, then everything by maturin.

`FOLDWING_LIBRARY` names a library that is built already, e.g. one for older systems.
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
    """The wheel, with the library beside the modules while it is made."""
    copy = PACKAGE / library().name
    shutil.copyfile(library(), copy)
    try:
        return maturin.build_wheel(wheel_directory, config_settings, metadata_directory)
    finally:
        copy.unlink()


def library():
    """The library that goes into FMUs, built where it is not given."""
    given = os.environ.get("FOLDWING_LIBRARY")
    if given:
        return Path(given)
    cargo = os.environ.get("CARGO", "cargo")
    # together with the module, so that what both need is compiled once
    packages = ["--package", "foldwing-fmu", "--package", "foldwing-python"]
    subprocess.run([cargo, "build", "--release", "--locked", *packages], cwd=ROOT, check=True)
    folder = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release"
    found = [folder / name for name in NAMES if (folder / name).is_file()]
    if not found:
        raise FileNotFoundError(f"{folder}: cargo has built no library")
    return found[0]
