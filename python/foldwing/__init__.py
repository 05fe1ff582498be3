"""Flexible multibody dynamics with joints and aerodynamics: folding wings, with results as NumPy arrays.

>>> import foldwing as fw
>>> model = fw.load("examples/models/folding_wing.toml")
>>> run = model.simulate(stop=0.4, outputs=["fold.*", "tip.position"])
>>> round(float(run["fold.latch_time"][-1]), 4)
0.1222
>>> run["tip.position"].shape == (len(run.time), 3)
True

Names, units and signs are those of the FMU's variables: SI units, angles in rad, root frame; see `docs/guide/variables.md` and
`Model.variables`. Long calls release the GIL and can be interrupted by Ctrl-C.
"""

from ._native import State, __version__, schema
from .builder import Builder
from .differentiable import jax_function, torch_function
from .errors import ArgumentError, FilesError, FoldwingError, ModelError, SimulationError, StaticsError, UsageError
from .film import Video
from .fit import Fit
from .gradient import Gradient
from .linear import LinearModel
from .live import Live
from .model import Model, load
from .optimum import Optimum
from .result import Result
from .rotor import Campbell, OperatingPoints, Periodic
from .simulation import Simulation
from .study import Flutter, FlutterMap, Modes, Equilibrium, Trim
from .table import SweepResult
from .variable import Variable

__all__ = [
    "Builder",
    "Campbell",
    "FilesError",
    "Fit",
    "Flutter",
    "FlutterMap",
    "FoldwingError",
    "Gradient",
    "LinearModel",
    "Live",
    "Model",
    "ModelError",
    "Modes",
    "OperatingPoints",
    "Optimum",
    "Periodic",
    "Equilibrium",
    "Result",
    "Simulation",
    "SimulationError",
    "State",
    "StaticsError",
    "SweepResult",
    "Trim",
    "ArgumentError",
    "UsageError",
    "Variable",
    "Video",
    "__version__",
    "jax_function",
    "load",
    "schema",
    "torch_function",
]
