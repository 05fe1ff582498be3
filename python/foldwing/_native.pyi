"""Native extension module, used by the package `foldwing`."""

import os
from typing import Any, Callable, Dict, List, Optional, Sequence, Tuple, Union

import numpy as np
from numpy.typing import NDArray
from typing_extensions import Self

__version__: str

_Array = NDArray[np.float64]
_Start = Union[float, int, bool]
_Settings = Sequence[Tuple[str, _Start]]
_Tell = Optional[Callable[[float], None]]

class Model:
    def __new__(cls, text: str, file: str) -> Model: ...
    @staticmethod
    def text_of_json(json: str) -> str: ...
    @staticmethod
    def text_with_files(text: str, file: str) -> str: ...
    @property
    def name(self) -> str: ...
    @property
    def description(self) -> str: ...
    @property
    def text(self) -> str: ...
    @property
    def experiment(self) -> Tuple[float, float, float]: ...
    def variables(self) -> List[Dict[str, Any]]: ...
    def vectors(self) -> List[Tuple[str, int, int]]: ...
    def find(self, name: str) -> int: ...
    def check(self, variables: bool) -> str: ...
    def check_json(self) -> str: ...
    def sections(self) -> List[Dict[str, Any]]: ...
    def gradient(
        self,
        of: Sequence[str],
        by: Sequence[str],
        stop_s: Optional[float],
        settings: Sequence[str],
        mode: str,
        inputs: Optional[InputTable],
    ) -> Dict[str, Any]: ...
    def text_with_values(self, values: Sequence[Tuple[str, str]]) -> str: ...
    def rest(self, settings: _Settings, arc_length: bool, branch: str) -> Dict[str, Any]: ...
    def modes(self, settings: _Settings, undeformed: bool, count: int, lattice: bool) -> Dict[str, Any]: ...
    def modes_page(self, settings: _Settings, undeformed: bool, count: int, lattice: bool) -> str: ...
    def flutter(self, settings: _Settings, wind_m_s: _Array, count: int, progress: _Tell) -> Dict[str, Any]: ...
    def flutter_page(self, settings: _Settings, wind_m_s: _Array, count: int) -> str: ...
    def flutter_over(
        self, keys: Sequence[str], rows: Sequence[Sequence[str]], wind_m_s: _Array, count: int, progress: _Tell
    ) -> List[Dict[str, Any]]: ...
    def campbell(
        self,
        speed_rpm: Sequence[float],
        shaft: Optional[str],
        undeformed: bool,
        count: int,
        settings: _Settings,
        progress: _Tell,
    ) -> Dict[str, Any]: ...
    def trim(
        self,
        settings: _Settings,
        solve_for: Sequence[str],
        targets: Sequence[Tuple[str, float]],
        turns: Sequence[Tuple[str, float]],
    ) -> Dict[str, Any]: ...
    def periodic(
        self,
        speed_rpm: Optional[float],
        shaft: Optional[str],
        settings: _Settings,
        outputs: Sequence[str],
        counts: Tuple[int, int, int, int],
        tolerance: float,
    ) -> Dict[str, Any]: ...
    def periodic_page(
        self,
        speed_rpm: Optional[float],
        shaft: Optional[str],
        settings: _Settings,
        counts: Tuple[int, int, int, int],
        tolerance: float,
    ) -> str: ...
    def operating_points(
        self,
        lists: Tuple[Sequence[float], Optional[Sequence[float]], Optional[Sequence[float]]],
        tip_speed_ratio: Optional[float],
        paired: bool,
        solve_for: Optional[Tuple[str, float, float]],
        target: Optional[Tuple[str, float]],
        joints: Tuple[Optional[str], Optional[Sequence[str]]],
        settings: _Settings,
        outputs: Sequence[str],
        steps: int,
        tolerance: float,
        progress: _Tell,
    ) -> Dict[str, Any]: ...
    def package(
        self,
        output: Union[str, os.PathLike[str]],
        *,
        ssp: Union[None, str, os.PathLike[str]],
        model: Union[None, str, os.PathLike[str]],
        libraries: Sequence[Union[str, os.PathLike[str]]],
        linear: Optional[str],
        kinds: Tuple[int, bool, bool, Sequence[bool]],
        without_reference: bool,
        force: bool,
    ) -> None: ...
    def points(self, start_s: Optional[float], stop_s: Optional[float], step_s: Optional[float]) -> _Array: ...

class InputTable:
    def __new__(cls, model: Model, times_s: _Array, columns: Sequence[Tuple[str, _Array]]) -> InputTable: ...

class Simulation:
    def __new__(cls, model: Model, settings: _Settings) -> Self: ...
    def start(self, time_s: float) -> None:
        """Compute the initial state at `time_s`; called by `Model.start`."""
    def settle(self, time_s: float) -> None:
        """Compute the static equilibrium at `time_s`."""
    @property
    def time(self) -> float:
        """Current time in s."""
    def step(self, step: float) -> None:
        """Advance by `step` s with the current inputs. Latch events inside the step occur at their exact time."""
    def step_to(self, time: float) -> None:
        """Advance to `time` s with the current inputs."""
    def __getitem__(self, name: str) -> Any:
        """Value of a variable: float, int or bool; array of shape (3,) for a vector, (4,) for a quaternion (w first)."""
    def __setitem__(self, name: str, value: Union[float, bool, Sequence[float], _Array]) -> None:
        """Set an input or a tunable parameter; all components if a vector is named."""
    def values(self, references: NDArray[np.uint32]) -> _Array:
        """Values of variables by value reference, shape (references,); Booleans as 0 and 1."""
    def save(self) -> State:
        """Save the complete state of the simulation."""
    def restore(self, state: State) -> None:
        """Restore a saved state of the same model, bit for bit."""
    def statistics(self) -> Dict[str, int]:
        """Solver statistics since the start: steps, rejections, failures, iterations, factorizations, events."""
    def run(
        self, times_s: _Array, references: Sequence[int], inputs: Optional[InputTable], view: bool, progress: _Tell
    ) -> Tuple[_Array, int, Optional[BaseException], Optional[str]]:
        """Run from the first to the last of `times_s`; called by `Model.simulate`."""

class State:
    """Saved simulation state."""

    @staticmethod
    def from_bytes(model: Model, bytes: bytes) -> State:
        """Create a state from the bytes of `to_bytes`, in any process with the same version and model."""
    def to_bytes(self) -> bytes:
        """Serialize the state to bytes."""

class LinearModel:
    def __new__(
        cls, simulation: Simulation, inputs: Sequence[str], outputs: Sequence[str], lattice: bool, gusts: Sequence[int]
    ) -> LinearModel: ...
    def matrices(self) -> List[_Array]: ...
    def describe(self) -> str: ...
    def about(self) -> str: ...

def least_squares(
    residuals: Callable[[NDArray[np.float64]], Optional[NDArray[np.float64]]],
    jacobian: Callable[[NDArray[np.float64]], NDArray[np.float64]],
    first: Sequence[float],
    bounds: Sequence[Tuple[float, float]],
    loss: str,
    max_runs: int,
    is_noise_known: bool,
) -> Dict[str, Any]: ...
def sweep(
    model: Model,
    keys: Sequence[str],
    rows: Sequence[Sequence[str]],
    *,
    times: Tuple[Optional[float], Optional[float], Optional[float]],
    inputs: Optional[InputTable],
    outputs: Sequence[str],
    settings: Sequence[str],
    threads: int,
    progress: _Tell,
) -> Tuple[List[str], List[List[str]]]: ...
def run_command(arguments: Sequence[str], library: Optional[str]) -> int: ...
def write_page(page: str, output: str, force: bool) -> None: ...
def film(
    page: str,
    output: str,
    size: Optional[Tuple[int, int]],
    fps: Optional[float],
    speed: Optional[float],
    camera: Sequence[str],
    span: Tuple[Optional[float], Optional[float]],
    force: bool,
    progress: _Tell,
) -> Dict[str, Any]: ...
def schema() -> str:
    """JSON schema of model files."""

def discretized(a: _Array, b: _Array, dt: float) -> List[_Array]: ...
def reduced(
    a: _Array, b: _Array, c: _Array, d: _Array, order: int, modal: bool, dt: Optional[float], up_to_hz: Optional[float]
) -> Tuple[
    _Array, _Array, _Array, _Array, Optional[float], _Array, Optional[Tuple[float, _Array, List[Tuple[float, float]], List[float]]]
]: ...
