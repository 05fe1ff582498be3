#!/usr/bin/env python3
"""Renews the pinned Python requirements: exact versions with hashes, for every supported Python at once.

Usage: lock_python.py requirements.in requirements.txt [OLDEST PYTHON, default 3.9]

Runs uv's resolver, which is installed into a temporary environment that is removed afterwards.
"""

import subprocess
import sys
import tempfile
import venv
from pathlib import Path

UV = "uv>=0.8"
HEADER = "# Written by `make python-lock` from {source}: exact versions with hashes, for Python {oldest} and later.\n"
OPTIONS = ["--universal", "--generate-hashes", "--fork-strategy", "requires-python"]


def main():
    source, target = map(Path, sys.argv[1:3])
    oldest = sys.argv[3] if len(sys.argv) > 3 else "3.9"
    with tempfile.TemporaryDirectory() as scratch:
        venv.create(scratch, with_pip=True)
        python = Path(scratch) / "bin/python"
        subprocess.run([python, "-m", "pip", "install", "--quiet", UV], check=True)
        command = [Path(scratch) / "bin/uv", "pip", "compile", "--quiet", "--no-header", *OPTIONS, "--python-version", oldest, source]
        lines = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout
    target.write_text(HEADER.format(source=source.name, oldest=oldest) + lines)


if __name__ == "__main__":
    main()
