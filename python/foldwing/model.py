"""Models: read, check, simulate, analyse, export as FMU."""

from __future__ import annotations

import fnmatch
import json
import math
import os
from pathlib import Path
from typing import Any, Callable, Dict, Iterable, List, Mapping, Optional, Sequence, Tuple, Union, cast

import numpy as np
from numpy.typing import NDArray

from . import _native, page
from .arguments import checked, checked_methods
from .command import library
from .errors import FilesError, SimulationError, UsageError
from .gradient import GradientStudies
from .inputs import Inputs, Stimulus, table_of
from .linear import LinearModel
from .progress import bar
from .result import Result
from .rotor import RotorStudies
from .simulation import Simulation
from .study import Flutter, FlutterMap, Modes, Equilibrium, Trim
from .table import SweepResult, grid_of, written
from .variable import Settings, Start, Summary, Variable

Patterns = Union[str, Sequence[str]]


@checked
def load(path: Union[str, os.PathLike[str]]) -> Model:
    """Read a model file, with the files of polars, sections, axes and wind that it references relative to its folder.

    >>> load("examples/models/folding_wing.toml").name
    'FoldingWing'

    Raises:
        ModelError: with all problems of the file: line, key, value, allowed values.
        FilesError: if it cannot be read.
    """
    file = os.fspath(path)
    try:
        content = Path(file).read_bytes()
    except OSError as error:
        raise FilesError(f"{file}: cannot be read: {error}") from error
    if content.startswith(b"PK\x03\x04"):
        raise UsageError(f"{file}: is a ZIP archive such as an FMU, not a model file; `foldwing run` runs FMUs")
    try:
        text = content.decode("utf-8")
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        raise UsageError(f"{file}:{line}: a model file is UTF-8 text; this line is not") from error
    return Model(_native.Model.text_with_files(text, file), file)


@checked_methods
class Model(RotorStudies, GradientStudies):
    """Immutable model.

    Args:
        text: text of a model file without references to other files; use `load` otherwise.
        file: file name for messages; `package` never overwrites this file.
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
        """Create a model from a mapping with the keys of a model file; NumPy numbers and arrays are allowed.

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
        """Name of the model."""
        return self._native.name

    @property
    def description(self) -> str:
        """Description in the model file."""
        return self._native.description

    @property
    def text(self) -> str:
        """Text of the model file, with the contents of referenced files embedded."""
        return self._native.text

    @property
    def simulation_times(self) -> Tuple[float, float, float]:
        """Start time, stop time and communication step of the default simulation in s."""
        return self._native.experiment

    def _repr_html_(self) -> str:
        rows = [(name, row.causality, row.start, row.unit, row.description) for name, row in self.variables.items() if row.causality != "independent"]
        return page.table(repr(self)[1:-1], ("variable", "causality", "start", "unit", "description"), rows, self.description)

    def __repr__(self) -> str:
        return f"<foldwing.Model {self.name}: {len(self.variables)} variables>"

    def __reduce__(self) -> Tuple[Any, ...]:
        return Model, (self.text, self.file)

    def check(self, variables: bool = False) -> Summary:
        """Summary of the model as interpreted by Foldwing, as printed by `foldwing check`, with its warnings at the end.

        >>> print(load("examples/models/folding_wing.toml").check())  # doctest: +ELLIPSIS
        FoldingWing...
        """
        data = json.loads(self._native.check_json())
        warnings = "".join(f"warning: {warning}\n" for warning in data["assessment"]["warnings"])
        return Summary(self._native.check(variables) + warnings, data)

    @property
    def sections(self) -> Dict[str, List[Dict[str, Any]]]:
        """Sections of each beam by its name, at its ends and at the rows of tables along it (one if it is uniform): stiffness, shear stiffness,
        mass and inertia per length, and the centres from the beam axis, in SI under the keys of `foldwing check --json`. Shear stiffness and
        shear centre are `None` for sections given by their stiffness.

        >>> spar = dict(shape="tube", diameter_m=0.025, wall_m=0.0015, material="aluminium 7075-T6")
        >>> wing = Model.from_dict({
        ...     "name": "Wing",
        ...     "section": {"spar": spar},
        ...     "body": {"wing": {"length_m": 2.4, "section": "spar", "elements": 4}},
        ...     "joint": {"mount": {"type": "clamped", "parent": "root", "child": "wing"}},
        ... })
        >>> round(wing.sections["wing"][0]["flap_stiffness_N_m2"])
        545
        """
        return {beam["body"]: beam["sections"] for beam in self._native.sections()}

    def match(self, patterns: Patterns, causality: Optional[str] = None) -> List[str]:
        """Names of variables that match patterns, in the order of the patterns: full names, names of vectors, wildcards (`fold.*`), prefixes
        (`load.`). `causality` restricts wildcards and prefixes, not names.

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
        settings: Settings = None,
        progress: Optional[bool] = None,
    ) -> Result:
        """Simulate the model and record variables.

        Args:
            stop: stop time in s; default: that of the model.
            inputs: a mapping of names to numbers, to functions of the time in s, or with an entry `time` to arrays; a
                DataFrame whose column `time` or index is the time in s; or a function of the time and the running
                `Simulation` that returns a mapping, first called with the initial state. Inputs act from the start of each
                step on; arrays are interpolated linearly between their rows, Booleans are held.
            outputs: names, vectors or patterns of outputs such as `fold.*`; default: all outputs.
            step: communication step in s. Latch times and accuracy do not depend on it.
            start: start time in s.
            settings: start values of inputs and parameters in their units, angles also as `"60 deg"`; a vector takes all its components:
                `{"gravity": [0, 0, -1.62]}`. To change keys of the model file, use `with_values`.
            progress: show a progress bar (needs tqdm); default: in notebooks.

        Raises:
            SimulationError: if the run fails; its `result` contains the results up to then.
            KeyboardInterrupt: at Ctrl-C.

        >>> import numpy as np
        >>> wing = load("examples/models/folding_wing.toml")
        >>> pull = {"time": np.array([0.0, 0.1]), "load.outer[4].force.z": np.array([0.0, 0.05])}
        >>> run = wing.simulate(stop=0.1, inputs=pull, outputs="gauge.root.strain")
        >>> run["gauge.root.strain"].shape == run.time.shape
        True
        """
        chosen = self._settings(settings)
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

    def _settings(self, settings: Settings) -> List[Tuple[str, Start]]:
        """Start values with the components of vectors in place of the vectors."""
        chosen: List[Tuple[str, Start]] = []
        for name, value in (settings or {}).items():
            if name not in self.variables and name in self._vectors:
                first, count = self._vectors[name]
                parts = list(self.variables)[first : first + count]
                try:
                    values = np.asarray(value, dtype=np.float64)
                except (TypeError, ValueError):
                    raise UsageError(f"settings: {name}: {value!r} is not a sequence of numbers") from None
                if values.shape != (count,):
                    given = "one number" if values.ndim == 0 else f"an array of shape {values.shape}"
                    raise UsageError(f"settings: {name}: {given} for {count} components; give {', '.join(part.rsplit('.', 1)[-1] for part in parts)}")
                chosen.extend(zip(parts, values.tolist()))
            elif name.startswith("file:"):
                raise UsageError(f"settings: {name} is a key of the model file, not a variable; use model.with_values({{{name!r}: {value!r}}})")
            else:
                chosen.append((name, cast(Start, self._in_own_unit(name, value))))
        return chosen

    def _in_own_unit(self, name: str, value: Any) -> Any:
        """A value in the unit of its variable: text such as "60 deg" is converted, as by the command; other values are returned
        unchanged."""
        row = self.variables.get(name)
        if row is None or row.type != "Real" or not isinstance(value, str):
            return value
        number, _, unit = value.strip().partition(" ")
        unit = unit.strip() or row.unit
        degrees = row.unit.replace("rad", "deg") if row.unit.startswith("rad") else row.unit
        if unit not in (row.unit, degrees):
            allowed = row.unit if degrees == row.unit else f"{row.unit} and {degrees}"
            raise UsageError(f"settings: {name}: {unit!r} is not one of its units; allowed: {allowed}")
        try:
            amount = float(number)
        except ValueError:
            raise UsageError(f"settings: {name}: {value!r} is not a number") from None
        return amount if unit == row.unit else amount / math.degrees(1.0)

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
        """Run with inputs from a function, called at the start and after every step, like a loop over `Simulation.step_to`."""
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
        feed(0)  # after the start, so that the function reads the initial state
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

    def start(self, *, time: Optional[float] = None, settings: Settings = None) -> Simulation:
        """Start a step-by-step simulation, for controllers and reinforcement learning: see `Simulation`.

        Args:
            time: start time in s.
            settings: start values of inputs and parameters, fixed ones included.

        >>> sim = load("examples/models/folding_wing.toml").start()
        >>> sim["fold.external_torque"] = 0.01
        >>> sim.step(1e-3)
        >>> sim.time
        0.001
        """
        simulation = Simulation(self, self._settings(settings))
        simulation.start(self.simulation_times[0] if time is None else time)
        return simulation

    def static(
        self,
        *,
        settings: Settings = None,
        path: str = "load",
        branch: str = "stable",
    ) -> Equilibrium:
        """Compute the static equilibrium, as `foldwing static`.

        Args:
            settings: start values, e.g. a load, or `{"fold.release": False}`.
            path: `load`, or `arc-length` for the path of equilibria through limit points.
            branch: `stable` for a stable equilibrium, including the aerodynamics; `path` for the equilibrium on the path even if it is
                unstable; with a vortex lattice, `path` does not assess stability.

        >>> rest = load("examples/models/folding_wing.toml").static(settings={"fold.release": False})
        >>> rest.joints["fold"]["angle_rad"] > 2.9
        True
        """
        for option, value, allowed in [("path", path, ("load", "arc-length")), ("branch", branch, ("stable", "path"))]:
            if value not in allowed:
                raise UsageError(f"{option}={value!r}: allowed are {' and '.join(allowed)}")
        return Equilibrium(self._native.rest(self._settings(settings), path == "arc-length", branch))

    def modes(
        self,
        count: int = 10,
        *,
        state: str = "equilibrium",
        settings: Settings = None,
        lattice: bool = False,
    ) -> Modes:
        """Compute the natural modes of lowest frequency, as `foldwing modes`.

        Args:
            count: number of modes.
            state: `equilibrium`, or `undeformed` without loads, gravity and root motion.
            settings: start values.
            lattice: include the vortex lattice, whose loads are otherwise constant. The modes then include real eigenvalues; there
                are fewer than `count` if the aerodynamic step resolves no more.

        >>> modes = load("examples/models/folding_wing.toml").modes(3, settings={"fold.release": False})
        >>> modes.frequency_Hz.shape
        (3,)
        """
        if state not in ("equilibrium", "undeformed"):
            raise UsageError(f"state={state!r}: allowed are equilibrium and undeformed")
        if lattice and state == "undeformed":
            raise UsageError("lattice=True: the undeformed state has no loads and no aerodynamics; use state='equilibrium' or omit lattice")
        arguments = (self._settings(settings), state == "undeformed", count, lattice)
        return Modes(self._native.modes(*arguments), (self, "modes_page", arguments))

    def flutter(
        self,
        wind_m_s: Iterable[float],
        count: int = 6,
        *,
        settings: Settings = None,
        progress: Optional[bool] = None,
    ) -> Flutter:
        """Compute aeroelastic modes over wind speed, with flutter and divergence, as `foldwing flutter`: with strip theory or a
        vortex lattice.

        Args:
            wind_m_s: wind speeds, ascending; more are inserted where mode tracking requires it. The direction is that of the model's
                wind.
            count: number of modes of lowest frequency to track.
            settings: start values.
            progress: show a progress bar (needs tqdm); default: in notebooks.

        >>> found = load("examples/models/goland_wing.toml").flutter([130.0, 140.0], count=2)
        >>> print(f"{found.flutter_m_s[0]:.2f} m/s")
        137.41 m/s
        """
        wanted = np.ascontiguousarray(np.fromiter(wind_m_s, dtype=np.float64))
        arguments = (self._settings(settings), wanted, count)
        with bar(progress) as told:
            found = self._native.flutter(*arguments, told)
        return Flutter(self.name, {"value": None, **found}, (self, "flutter_page", arguments))

    def flutter_map(
        self,
        vary: str,
        values: Iterable[Any],
        wind_m_s: Iterable[float],
        count: int = 6,
        *,
        settings: Settings = None,
        progress: Optional[bool] = None,
    ) -> FlutterMap:
        """Compute flutter and divergence speeds as functions of another quantity, as `foldwing flutter --vary`.

        Args:
            vary: name of an input or parameter, or `file:` and a key of the model file (`file:section.wing.flap_stiffness_N_m2`).
            values: values of that quantity.
            wind_m_s: as in `flutter`.
            count: number of modes of lowest frequency to track.
            settings: start values.
            progress: show a progress bar (needs tqdm); default: in notebooks.

        >>> wing = load("examples/models/goland_wing.toml")
        >>> found = wing.flutter_map("aero.density", [1.0, 1.225], [120.0, 160.0], count=2)
        >>> print(" ".join(f"{speed:.1f}" for speed in found.flutter_m_s))
        148.1 137.4
        """
        choices = list(values)
        keys, rows = grid_of({**{name: [value] for name, value in self._settings(settings)}, vary: choices}, True)
        wanted = np.ascontiguousarray(np.fromiter(wind_m_s, dtype=np.float64))
        with bar(progress) as told:
            found = self._native.flutter_over(keys, rows, wanted, count, told)
        return FlutterMap(self.name, vary, choices, [Flutter(self.name, {"value": None, **data}) for data in found])

    def trim(
        self,
        solve_for: Union[str, Sequence[str]],
        target: Optional[Mapping[str, float]] = None,
        *,
        settings: Settings = None,
    ) -> Trim:
        """Trim: solve for inputs or parameters that give outputs target values at equilibrium, as `foldwing trim`.

        Args:
            solve_for: names of the unknown inputs and parameters, as many as targets. Names joined by commas have the same value,
                `-name` its negative. `attitude.roll`, `attitude.pitch` and `attitude.yaw` rotate the model relative to gravity and wind;
                `turn.rate` is the rate of a steady turn to the right.
            target: target values of outputs at equilibrium, in SI units. Forces and moments on free joints are always balanced too
                and are not listed here.
            settings: start values, also of the attitude in rad and of `turn.rate` in rad/s; for unknowns the initial guess.

        >>> wing = load("examples/models/flared_wing_tip.toml")
        >>> trim = wing.trim("wind.velocity.z", {"root.force.z": 0.0})
        >>> rest = wing.static(settings=trim.settings)
        >>> bool(abs(rest.root_force_N[2]) < 1e-6)
        True
        """
        names = [solve_for] if isinstance(solve_for, str) else list(solve_for)
        own = ("attitude.roll", "attitude.pitch", "attitude.yaw", "turn.rate")
        plain = dict(self._settings({name: value for name, value in (settings or {}).items() if name not in own}))
        turns = [(name, float(cast(Any, value))) for name, value in (settings or {}).items() if name in own]
        targets = [(name, float(value)) for name, value in (target or {}).items()]
        return Trim(self._native.trim(list(plain.items()), names, targets, turns), plain)

    def linearize(
        self,
        state: Union[str, float, Simulation] = "equilibrium",
        *,
        inputs: Patterns = (),
        outputs: Patterns = (),
        settings: Settings = None,
        lattice: bool = False,
    ) -> LinearModel:
        """Linearize about an operating point, from real inputs to real outputs.

        Args:
            state: `start`, `equilibrium`, a time in s up to which the model is simulated, or a simulation of this model in its
                current state.
            inputs: names and patterns; default: all real inputs. `gust.x`, `gust.y`, `gust.z` in m/s are the velocities of a gust: with
                strips and rotors uniform in space, with a lattice travelling with the wind.
            outputs: names and patterns; default: all real outputs.
            settings: start values; not with a simulation, which is already started.
            lattice: include the vortex lattice. The linear model is then in discrete time with the aerodynamic step as `dt`, and wind
                and control surfaces are possible inputs.

        >>> wing = load("examples/models/folding_wing.toml")
        >>> model = wing.linearize(inputs="fold.external_torque", outputs="gauge.root.strain", settings={"fold.release": False})
        >>> model.B.shape == (len(model.states), 1)
        True
        """
        simulation = self._at(state, settings)
        inputs = [inputs] if isinstance(inputs, str) else list(inputs)
        names, every = ("gust.x", "gust.y", "gust.z"), ("gust.", "gust.*")
        gusts = [axis for axis, name in enumerate(names) if name in inputs or any(other in inputs for other in every)]
        inputs = [name for name in inputs if name not in names + every]
        read, moved = self._real(outputs, "output"), self._real(inputs, "input")
        return LinearModel._of(_native.LinearModel(simulation, moved, read, lattice, gusts))

    def _at(self, state: Union[str, float, Simulation], settings: Settings) -> Simulation:
        """Simulation at an operating point of `linearize`."""
        if isinstance(state, Simulation):
            if settings:
                raise UsageError("settings: a simulation has its own settings; set its inputs and parameters before it starts")
            return state
        simulation = Simulation(self, self._settings(settings))
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
        settings: Settings = None,
        grid: bool = True,
        threads: Optional[int] = None,
        progress: Optional[bool] = None,
    ) -> SweepResult:
        """Simulate many variants in parallel and record the final values of `outputs` of each.

        Args:
            variants: values by key; a key is an input, a parameter, or `file:` and a key of the model file
                (`file:body.inner.length_m`). A DataFrame has one row for each variant.
            outputs: names and patterns.
            stop, step, start: as in `simulate`.
            inputs: inputs over time, the same in all variants; functions must be functions of time only.
            settings: start values of all variants; a key of the variants has precedence.
            grid: all combinations, the last key varies fastest; if false, values of the keys are combined row by row.
            threads: number of threads; default: one for each processor.

        Returns:
            One row for each variant: its values, `status` (`done` or `failed`), `end_time`, `outputs`, first latch times,
            peak strains of gauges, solver statistics, `message`.

        >>> wing = load("examples/models/folding_wing.toml")
        >>> table = wing.sweep({"fold.start_angle": [1.0, 2.0]}, stop=0.2, outputs="fold.angle")
        >>> table["status"].tolist()
        ['done', 'done']
        """
        keys, rows = grid_of(variants, grid)
        names = self.match(outputs, "output") if len(outputs) else []
        table, _ = table_of(self, inputs, self._native.points(start, stop, step))
        common = [f"{name}={written(value)}" for name, value in self._settings(settings) if name not in keys]
        with bar(progress) as told:
            columns, cells = _native.sweep(
                self._native, keys, rows,
                times=(start, stop, step),
                inputs=table,
                outputs=names,
                settings=common,
                threads=threads or 0,
                progress=told,
            )
        return SweepResult(columns, cells, {name: row.unit for name, row in self.variables.items()})

    def package(
        self,
        output: Union[str, os.PathLike[str]],
        *,
        ssp: Union[None, str, os.PathLike[str]] = None,
        linear: Union[None, str, float] = None,
        fmi: int = 2,
        interface: Union[str, Sequence[str]] = "cs",
        scalars: bool = False,
        accounts: bool = False,
        real_outputs_only: bool = False,
        reference: bool = True,
        libraries: Sequence[Union[str, os.PathLike[str]]] = (),
        force: bool = False,
    ) -> Path:
        """Export the FMU, bytewise identical to that of `foldwing package`.

        Args:
            output: output file, ending in `.fmu`.
            ssp: second output file, ending in `.ssp`: a system of this FMU alone (SSP 1.0) with its parameters in files of their own, values with
                angles in degrees (SSV) and their mapping onto the variables of the FMU (SSM). With `fmi=3` it needs `scalars=True`.
            linear: operating point of a linear model to include: `start`, `equilibrium`, or a time in s.
            fmi: version of FMI, 2 or 3; with 3, stations and vectors are arrays, latch closings are events, and reference results are omitted.
            interface: `cs` (co-simulation), `me` (Model Exchange), or both: `("cs", "me")`.
            scalars: with `fmi=3`, scalars under the names of FMI 2.0 instead of arrays.
            accounts: with `interface="me"`, the work of the inputs and the dissipated energy as continuous states, and as outputs.
            real_outputs_only: outputs that are not Real as local variables, for importers that take every output for Real (CasADi).
            reference: run the default simulation for the reference results in the FMU.
            libraries: shared libraries, one for each platform; default: the one in this package.
            force: overwrite a file that was not written by Foldwing.
        """
        if fmi not in (2, 3) or isinstance(fmi, bool):
            raise UsageError(f"fmi={fmi!r}: allowed are 2 and 3")
        types = [interface] if isinstance(interface, str) else list(interface)
        if not types or not set(types) <= {"cs", "me"}:
            raise UsageError(f"interface={interface!r}: allowed are 'cs', 'me' and ('cs', 'me')")
        self._native.package(
            os.fspath(output),
            ssp=None if ssp is None else os.fspath(ssp),
            model=self.file if os.path.exists(self.file) else None,
            libraries=[os.fspath(path) for path in libraries] or [library()],
            linear=None if linear is None else str(linear),
            kinds=(int(fmi), "cs" in types, "me" in types, [scalars, accounts, real_outputs_only]),
            without_reference=not reference,
            force=force,
        )
        return Path(output)


def _plain(value: Any) -> Any:
    """Convert NumPy numbers and arrays for JSON."""
    if isinstance(value, (np.generic, np.ndarray)):
        return value.tolist()
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    raise UsageError(f"from_dict: {value!r} is not a value of a model file")
