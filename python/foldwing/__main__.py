"""`python -m foldwing` is the command `foldwing`."""

import sys

from .command import main

sys.exit(main())
