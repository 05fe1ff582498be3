"""Run the command `foldwing` by `python -m foldwing`."""

import sys

from .command import main

sys.exit(main())
