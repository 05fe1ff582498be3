"""Runs the command `foldwing` as `python -m foldwing`."""

import sys

from .command import main

sys.exit(main())
