"""A machine: read, checked, run, studied, packaged."""

from __future__ import annotations

import fnmatch
import json
import os
from pathlib import Path
from typing import Any, Callable, Dict, Iterable, List, Mapping, Optional, Sequence, Tuple, Union

import numpy as np
from numpy.typing import NDArray

from . import _native
from .command import library
from .errors import FilesError, SimulationError, UsageError
from .inputs import Inputs, Stimulus, table_of
from .linear import LinearModel
from .progress import bar
from .result import Result
from .rotor import RotorStudies
from .simulation import Simulation
from .study import Flutter, FlutterMap, Modes, Equilibrium, Trim
from .table import SweepResult, grid_of
from .variable import Start, Summary, Variable

Patterns = Union[str, Sequence[str]]


def load(path: Union[str, "os.PathLike[str]"]) -> Model:
    """Reads a model file, and the files of polars, sections, axes and wind that it names, from its own folder.

    >>> load("examples/models/folding_wing.toml").name
    'FoldingWing'

    Raises:
        ModelError: with every problem of the file: line, key, value, what is allowed.
        FilesError: if it cannot be read.
    """
    file = os.fspath(path)
    try:
        content = Path(file).read_bytes()
    except OSError as error:
        raise FilesError(f"{file}: cannot be read: {error}") from error
    if content.startswith(b"PK\x03\x04"):
        raise UsageError(f"{file}: is an archive, as FMUs are, not a model file; `foldwing run` runs FMUs")
    try:
        text = content.decode("utf-8")
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        raise UsageError(f"{file}:{line}: a model file is UTF-8 text; this line is not") from error
    return Model(_native.Model.text_with_files(text, file), file)


class Model(RotorStudies):
    """A machine that does not change.

    Args:
        text: text of a model file that names no other files; `load` reads those that do.
        file: name of the file in messages, and the file that `package` never overwrites.
    """

    def __init__(self, text: str, file: str = "model") -> None:
        self._native = _native.Model(text, file)
        self.file = file
        """Name of the file."""
        self.variables: Dict[str, Variable] = {
            fields["name"]: Variable(**fields) for fields in self._native.variables()
        }
        """Variables by name, in the order of the FMU's value references."""
        self._references = {name: reference for reference, name in enumerate(self.variables)}
        self._vectors = {name: (first, count) for name, first, count in self._native.vectors()}

    @classmethod
    def from_dict(cls, tree: Mapping[str, Any], name: str = "model") -> Model:
        """A model of a mapping with the keys of a model file; NumPy numbers and arrays are allowed.

        >>> spar = dict(shape="rectangle", width_m=0.1, height_m=0.004, density_kg_m3=1600, youngs_modulus_Pa=60e9, poisson_ratio=0.3)
        >>> beam = Model.from_dict({
        ...     "name": "Beam",
        ...     "section": {"spar": spar},
        ...     "body": {"beam": {"length_m": 0.5, "section": "spar", "elements": 2}},
        ...     "joint": {"mount": {"type": "clamped", "parent": "root", "child": "beam"}},
        ... })
        >>> print(f"{beam.modes(1).frequency_Hz[0]:.1f} Hz")
        15.8 Hz
        """
        text = _native.Model.text_of_json(json.dumps(tree, default=_plain, allow_nan=False))
        return cls(text, name)

    @property
    def name(self) -> str:
        """Name of the machine."""
        return self._native.name

    @property
    def description(self) -> str:
        """Description in the model file."""
        return self._native.description

    @property
    def text(self) -> str:
        """Text of the model file, with what it takes from other files in it."""
        return self._native.text

    @property
    def simulation_times(self) -> Tuple[float, float, float]:
        """Start, stop and communication step of the model's own simulation in s."""
        return self._native.experiment

    def __repr__(self) -> str:
        return f"<foldwing.Model {self.name}: {len(self.variables)} variables>"

    def __reduce__(self) -> Tuple[Any, ...]:
        return Model, (self.text, self.file)

    def check(self, variables: bool = False) -> Summary:
        """What Foldwing has understood of the model, as `foldwing check` prints it.

        >>> print(load("examples/models/folding_wing.toml").check())  # doctest: +ELLIPSIS
        FoldingWing...
        """
        return Summary(self._native.check(variables), json.loads(self._native.check_json()))

    def match(self, patterns: Patterns, causality: Optional[str] = None) -> List[str]:
        """Names that patterns choose, in the order of the patterns: whole names, names of vectors, `fold.*`, `load.` for all that
        begins so. `causality` restricts what patterns choose, not names.

        >>> load("examples/models/folding_wing.toml").match(["tip.position", "fold.angle"])
        ['tip.position.x', 'tip.position.y', 'tip.position.z', 'fold.angle']
        """
        chosen: List[str] = []
        names = [name for name, row in self.variables.items() if causality in (None, row.causality)]
        for pattern in [patterns] if isinstance(patterns, str) else patterns:
            if pattern in self.variables:
                found = [pattern]
            elif pattern in self._vectors:
                first, count = self._vectors[pattern]
                found = list(self.variables)[first : first + count]
            elif pattern.endswith("."):
                found = [name for name in names if name.startswith(pattern)]
            else:
                found = fnmatch.filter(names, pattern.replace("[", "[[]"))  # brackets are part of names
            if not found:
                self._native.find(pattern)
            chosen.extend(found)
        return list(dict.fromkeys(chosen))

    def simulate(
        self,
        stop: Optional[float] = None,
        *,
        inputs: Stimulus = None,
        outputs: Optional[Patterns] = None,
        step: Optional[float] = None,
        start: Optional[float] = None,
        settings: Optional[Mapping[str, Start]] = None,
        progress: Optional[bool] = None,
    ) -> Result:
        """Runs the machine and records variables.

        Args:
            stop: stop time in s; by default that of the model's simulation.
            inputs: a mapping of names to numbers, to functions of the time in s, or with an entry `time` to arrays; a
                DataFrame whose column `time` or index is the time in s; or a function of the time and the running
                `Simulation` that returns a mapping; its first call sees the machine as it starts. They act from the start of
                each step on; arrays run linearly between their rows, Booleans are held.
            outputs: names, vectors, patterns of outputs as `fold.*`; by default all outputs.
            step: communication step in s. Latch times and accuracy do not depend on it.
            start: start time in s.
            settings: start values of inputs and parameters.
            progress: a bar for runs that last (needs tqdm); by default in notebooks.

        Raises:
            SimulationError: if the run gives up; its `result` has what was computed.
            KeyboardInterrupt: at Ctrl-C.

        >>> import numpy as np
        >>> wing = load("examples/models/folding_wing.toml")
        >>> pull = {"time": np.array([0.0, 0.1]), "load.outer[4].force.z": np.array([0.0, 0.05])}
        >>> run = wing.simulate(stop=0.1, inputs=pull, outputs="gauge.root.strain")
        >>> run["gauge.root.strain"].shape == run.time.shape
        True
        """
        chosen = list((settings or {}).items())
        times = self._native.points(start, stop, step)
        names = self.match(outputs, "output") if outputs is not None else self._outputs()
        given = Inputs(self, inputs, times)
        simulation = Simulation(self, chosen)
        if given.function is not None:
            return self._drive(simulation, times, names, given.function, chosen)
        references = [self._references[name] for name in names]
        with bar(progress) as told:
            values, reached, error, _ = simulation.run(times, references, given.table, False, told)
        result = Result(self, names, values[:, :reached], chosen, given.columns)
        if error is not None:
            if isinstance(error, SimulationError):
                error.result = result
            raise error
        return result

    def _parts(self, name: str, value: Any) -> List[Tuple[str, Any]]:
        """Components of a vector with their values, or the variable itself."""
        if name not in self._vectors:
            return [(name, value)]
        first, count = self._vectors[name]
        return list(zip(list(self.variables)[first : first + count], value))

    def _outputs(self) -> List[str]:
        return [name for name, row in self.variables.items() if row.causality == "output"]

    def _drive(
        self,
        simulation: Simulation,
        times: NDArray[np.float64],
        names: List[str],
        function: Callable[[float, Simulation], Optional[Mapping[str, Start]]],
        settings: List[Tuple[str, Start]],
    ) -> Result:
        """A run whose inputs a function gives at the start and after every step, as a loop over `Simulation.step_to` would."""
        references = np.array([self._references[name] for name in names], dtype=np.uint32)
        applied: Dict[str, List[float]] = {}
        values = np.empty((len(names) + 1, len(times)))
        reached = 0

        def feed(point: int) -> None:
            for name, value in (function(float(times[point]), simulation) or {}).items():
                simulation[name] = value
                for part, number in self._parts(name, value):
                    column = applied.setdefault(part, [float(self.variables[part].start)] * point)
                    column[point:] = [float(number)]
            for column in applied.values():
                column.extend(column[-1:] * (point + 1 - len(column)))

        def record(point: int) -> None:
            values[0, point] = simulation.time
            values[1:, point] = simulation.values(references)

        def result() -> Result:
            columns = {name: np.array((column + column[-1:])[:reached]) for name, column in applied.items()}
            return Result(self, names, values[:, :reached], settings, (times[:reached], columns))

        simulation.start(float(times[0]))
        feed(0)  # after the start, so that the function reads the machine as it starts
        record(0)
        reached = 1
        try:
            for point, time in enumerate(times[1:].tolist(), start=1):
                if point > 1:
                    feed(point - 1)
                simulation.step_to(time)
                record(point)
                reached = point + 1
        except SimulationError as error:
            error.result = result()
            raise
        return result()

    def start(self, *, time: Optional[float] = None, settings: Optional[Mapping[str, Start]] = None) -> Simulation:
        """A run in steps, for controllers and learning: see `Simulation`.

        Args:
            time: start time in s.
            settings: start values of inputs and parameters, fixed ones included.

        >>> sim = load("examples/models/folding_wing.toml").start()
        >>> sim["fold.external_torque"] = 0.01
        >>> sim.step(1e-3)
        >>> sim.time
        0.001
        """
        simulation = Simulation(self, list((settings or {}).items()))
        simulation.start(self.simulation_times[0] if time is None else time)
        return simulation

    def static(
        self,
        *,
        settings: Optional[Mapping[str, Start]] = None,
        path: str = "load",
        branch: str = "stable",
    ) -> Equilibrium:
        """The machine at rest under its loads, as `foldwing static` finds it.

        Args:
            settings: start values, e.g. a load, or `{"fold.release": False}`.
            path: `load`, or `arc-length` for the path of equilibria through limit points.
            branch: `stable` for a stable equilibrium, judged with the air; `path` for the one on the path even if it is unstable, in a
                lattice without a verdict.

        >>> rest = load("examples/models/folding_wing.toml").static(settings={"fold.release": False})
        >>> rest.joints["fold"]["angle_rad"] > 2.9
        True
        """
        for option, value, allowed in [("path", path, ("load", "arc-length")), ("branch", branch, ("stable", "path"))]:
            if value not in allowed:
                raise UsageError(f"{option}={value!r}: allowed are {' and '.join(allowed)}")
        text = self._native.rest_json(list((settings or {}).items()), path == "arc-length", branch)
        return Equilibrium(json.loads(text))

    def modes(
        self,
        count: int = 10,
        *,
        state: str = "equilibrium",
        settings: Optional[Mapping[str, Start]] = None,
        lattice: bool = False,
    ) -> Modes:
        """Natural modes of lowest frequency, as `foldwing modes` finds them.

        Args:
            count: number of modes.
            state: `equilibrium`, or `undeformed` without loads, gravity and root motion.
            settings: start values.
            lattice: include the air of a vortex lattice, whose loads are otherwise held constant. Motions that only decay or only
                grow are among the modes; there are fewer than `count` where the aerodynamic step shows no more.

        >>> modes = load("examples/models/folding_wing.toml").modes(3, settings={"fold.release": False})
        >>> modes.frequency_Hz.shape
        (3,)
        """
        if state not in ("equilibrium", "undeformed"):
            raise UsageError(f"state={state!r}: allowed are equilibrium and undeformed")
        if lattice and state == "undeformed":
            raise UsageError("lattice=True: the undeformed state has no loads, nor air; use state='equilibrium', or leave lattice out")
        return Modes(json.loads(self._native.modes_json(list((settings or {}).items()), state == "undeformed", count, lattice)))

    def flutter(self, wind_m_s: Iterable[float], count: int = 6, *, settings: Optional[Mapping[str, Start]] = None) -> Flutter:
        """Modes in air over the speed of the wind, with flutter and divergence, as `foldwing flutter` finds them: in the air of
        strips or of a vortex lattice.

        Args:
            wind_m_s: speeds of the wind, ascending; more are inserted where following the modes requires it. The direction is that of the
                model's wind.
            count: number of modes to follow, of lowest frequency.
            settings: start values.

        >>> found = load("examples/models/goland_wing.toml").flutter([130.0, 140.0], count=2)
        >>> print(f"{found.flutter_m_s[0]:.2f} m/s")
        137.41 m/s
        """
        wanted = np.ascontiguousarray(np.fromiter(wind_m_s, dtype=np.float64))
        return Flutter(self.name, json.loads(self._native.flutter_json(list((settings or {}).items()), wanted, count)))

    def flutter_map(
        self,
        vary: str,
        values: Iterable[Any],
        wind_m_s: Iterable[float],
        count: int = 6,
        *,
        settings: Optional[Mapping[str, Start]] = None,
    ) -> FlutterMap:
        """Speeds of flutter and divergence over another quantity, as `foldwing flutter --vary` finds them.

        Args:
            vary: a start value, a parameter, or `file:` and a key of the model file (`file:section.wing.flap_stiffness_N_m2`).
            values: of that quantity.
            wind_m_s: as in `flutter`.
            count: number of modes to follow, of lowest frequency.
            settings: start values.

        >>> wing = load("examples/models/goland_wing.toml")
        >>> found = wing.flutter_map("aero.density", [1.0, 1.225], [120.0, 160.0], count=2)
        >>> print(" ".join(f"{speed:.1f}" for speed in found.flutter_m_s))
        148.1 137.4
        """
        choices = list(values)
        keys, rows = grid_of({**{name: [value] for name, value in (settings or {}).items()}, vary: choices}, True)
        wanted = np.ascontiguousarray(np.fromiter(wind_m_s, dtype=np.float64))
        found = self._native.flutter_over_json(keys, rows, wanted, count)
        return FlutterMap(self.name, vary, choices, [Flutter(self.name, json.loads(data)) for data in found])

    def trim(
        self,
        solve_for: Union[str, Sequence[str]],
        target: Optional[Mapping[str, float]] = None,
        *,
        settings: Optional[Mapping[str, Start]] = None,
    ) -> Trim:
        """Values of inputs and parameters for which outputs at rest are what they should be, as `foldwing trim` finds them.

        Args:
            solve_for: names of inputs and parameters whose values are sought, as many as there are targets. Names joined by commas
                share a value, and `-name` takes its negative. `attitude.roll`, `attitude.pitch` and `attitude.yaw` turn the machine
                relative to gravity and wind; `turn.rate` is the rate of a steady turn to the right.
            target: outputs and the values that they must have at rest, in SI units. Forces and moments on free joints are
                always balanced too; they are not named here.
            settings: start values, also of the attitude in rad and of `turn.rate` in rad/s; for free values the first guess.

        >>> wing = load("examples/models/flared_wing_tip.toml")
        >>> trim = wing.trim("wind.velocity.z", {"root.force.z": 0.0})
        >>> rest = wing.static(settings=trim.settings)
        >>> bool(abs(rest.root_force_N[2]) < 1e-6)
        True
        """
        names = [solve_for] if isinstance(solve_for, str) else list(solve_for)
        own = ("attitude.roll", "attitude.pitch", "attitude.yaw", "turn.rate")
        plain = {name: value for name, value in (settings or {}).items() if name not in own}
        turns = [(name, float(np.asarray(value))) for name, value in (settings or {}).items() if name in own]
        targets = [(name, float(value)) for name, value in (target or {}).items()]
        return Trim(json.loads(self._native.trim_json(list(plain.items()), names, targets, turns)), plain)

    def linearize(
        self,
        state: Union[str, float, Simulation] = "equilibrium",
        *,
        inputs: Patterns = (),
        outputs: Patterns = (),
        settings: Optional[Mapping[str, Start]] = None,
        lattice: bool = False,
    ) -> LinearModel:
        """The linear model about a state, between real inputs and outputs.

        Args:
            state: `start`, `equilibrium`, a time in s up to which the machine is simulated, or a simulation of this machine at its
                present state.
            inputs: names and patterns; by default all real inputs.
            outputs: names and patterns; by default all real outputs.
            settings: start values; not with a simulation, which has its own.
            lattice: include the air of a vortex lattice. The model is then in discrete time, `dt` is the aerodynamic step, and wind,
                flaps and the velocities `gust.x`, `gust.y`, `gust.z` of a gust that travels with the wind are possible inputs.

        >>> wing = load("examples/models/folding_wing.toml")
        >>> model = wing.linearize(inputs="fold.external_torque", outputs="gauge.root.strain", settings={"fold.release": False})
        >>> model.B.shape == (len(model.states), 1)
        True
        """
        simulation = self._at(state, settings)
        gusts: List[int] = []
        if lattice:
            inputs = [inputs] if isinstance(inputs, str) else list(inputs)
            names = ("gust.x", "gust.y", "gust.z")
            every = ("gust.", "gust.*")
            gusts = [axis for axis, name in enumerate(names) if name in inputs or any(other in inputs for other in every)]
            inputs = [name for name in inputs if name not in names + every]
        read, moved = self._real(outputs, "output"), self._real(inputs, "input")
        return LinearModel._of(_native.LinearModel(simulation, moved, read, lattice, gusts))

    def _at(self, state: Union[str, float, Simulation], settings: Optional[Mapping[str, Start]]) -> Simulation:
        """A simulation at a state that `linearize` takes."""
        if isinstance(state, Simulation):
            if settings:
                raise UsageError("settings: a simulation has its own; set its inputs and parameters before it starts")
            return state
        simulation = Simulation(self, list((settings or {}).items()))
        begin = self.simulation_times[0]
        if state == "start":
            simulation.start(begin)
        elif state == "equilibrium":
            simulation.settle(begin)
        elif isinstance(state, str) or not begin <= state < float("inf"):
            raise UsageError(f"state={state!r}: must be start, equilibrium, a time from {begin} s, the start of the simulation, or a Simulation")
        else:
            simulation.start(begin)
            if state > begin:
                simulation.step_to(state)
        return simulation

    def _real(self, patterns: Patterns, causality: str) -> List[str]:
        if len(patterns) == 0:
            return []
        return [name for name in self.match(patterns, causality) if self.variables[name].type == "Real"]

    def sweep(
        self,
        variants: Union[Mapping[str, Iterable[Any]], Any],
        *,
        outputs: Patterns = (),
        stop: Optional[float] = None,
        step: Optional[float] = None,
        start: Optional[float] = None,
        inputs: Stimulus = None,
        grid: bool = True,
        threads: Optional[int] = None,
        progress: Optional[bool] = None,
    ) -> SweepResult:
        """Runs many variants on all cores, and keeps the last values of `outputs` of each.

        Args:
            variants: values by key; a key is an input, a parameter, or `file:` and a key of the model file
                (`file:body.inner.length_m`). A DataFrame has a row for each variant.
            outputs: names and patterns.
            stop, step, start: as in `simulate`.
            inputs: over time, in all variants; functions must be functions of the time alone.
            grid: all combinations, the last key fastest; if false the values of the keys belong together row by row.
            threads: by default one for each processor.

        Returns:
            A row for each variant: its values, `status` (`done` or `failed`), `end_time`, `outputs`, first latch times,
            peak strains of gauges, counts, `message`.

        >>> wing = load("examples/models/folding_wing.toml")
        >>> table = wing.sweep({"fold.start_angle": [1.0, 2.0]}, stop=0.2, outputs="fold.angle")
        >>> table["status"].tolist()
        ['done', 'done']
        """
        keys, rows = grid_of(variants, grid)
        names = self.match(outputs, "output") if len(outputs) else []
        table, _ = table_of(self, inputs, self._native.points(start, stop, step))
        with bar(progress) as told:
            columns, cells = _native.sweep(
                self._native, keys, rows,
                times=(start, stop, step),
                inputs=table,
                outputs=names,
                threads=threads or 0,
                progress=told,
            )
        return SweepResult(columns, cells)

    def package(
        self,
        output: Union[str, "os.PathLike[str]"],
        *,
        linear: Union[None, str, float] = None,
        reference: bool = True,
        libraries: Sequence[Union[str, "os.PathLike[str]"]] = (),
        force: bool = False,
    ) -> Path:
        """Writes the FMU, the same bytes as `foldwing package`.

        Args:
            output: the file, which ends in `.fmu`.
            linear: state about which to add a linear model: `start`, `equilibrium`, or a time in s.
            reference: simulate the default experiment for the reference results in the FMU.
            libraries: shared libraries, one for each platform; by default the one in this package.
            force: replace a file that something else wrote.
        """
        self._native.package(
            os.fspath(output),
            model=self.file if os.path.exists(self.file) else None,
            libraries=[os.fspath(path) for path in libraries] or [library()],
            linear=None if linear is None else str(linear),
            without_reference=not reference,
            force=force,
        )
        return Path(output)


def _plain(value: Any) -> Any:
    """NumPy numbers and arrays for JSON."""
    if isinstance(value, (np.generic, np.ndarray)):
        return value.tolist()
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    raise UsageError(f"from_dict: {value!r} is no value of a model file")
