"""The command `foldwing`, out of the native part."""

from __future__ import annotations

import signal
import sys

from . import _native
from .model import library


def main() -> int:
    """Runs the command with this process's arguments; returns its exit code."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # the command ends at Ctrl-C by itself
    if hasattr(signal, "SIGPIPE"):
        signal.signal(signal.SIGPIPE, signal.SIG_IGN)
    return _native.run_command(["foldwing", *sys.argv[1:]], library())


if __name__ == "__main__":
    sys.exit(main())
