"""The command `foldwing`, from the extension module."""

from __future__ import annotations

import signal
import sys
from pathlib import Path

from . import _native
from .errors import FilesError


def main() -> int:
    """Run the command with the arguments of this process; returns the exit code."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # Ctrl-C ends the command directly
    if hasattr(signal, "SIGPIPE"):
        signal.signal(signal.SIGPIPE, signal.SIG_IGN)
    return _native.run_command(["foldwing", *sys.argv[1:]], library())


def library() -> str:
    """Path of the shared library that is packaged into FMUs."""
    folder = Path(__file__).parent
    for name in ["libfoldwing_fmu.so", "foldwing_fmu.dll", "libfoldwing_fmu.dylib"]:
        if (folder / name).is_file():
            return str(folder / name)
    raise FilesError(f"{folder}: contains no library for FMUs; install the wheel, or give libraries")


if __name__ == "__main__":
    sys.exit(main())
