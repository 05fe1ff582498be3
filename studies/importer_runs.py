"""Runs an FMU in one importer that is installed in this environment, and writes its scalar outputs over time; `studies/importers.py` starts it.

  python studies/importer_runs.py IMPORTER FMU cs|me STOP_S INTERVAL_S CSV

Columns of the CSV are `time` and the Real and Boolean outputs, vectors in space as three columns with the names of FMI 2.0. Co-simulation
steps from one row to the next. In Model Exchange the importer's own integrator runs at the tolerance `TOLERANCE`. `IMPORTER --version`
prints the versions of the packages.
"""

import csv
import ctypes
import importlib.metadata
import logging
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Callable, Dict, List, NamedTuple, Tuple

from fmpy import read_model_description, simulate_fmu

# smaller than the defaults of importers (1e-4 to 1e-6), so that the remaining differences are due to the integrators, not to this choice
TOLERANCE = 1e-8
# number of output intervals of FMPy in an output interval of this script, in Model Exchange
PARTS = 20
NUMBERS = ("Real", "Float64", "Boolean")


class Task(NamedTuple):
    """A run of an FMU by an importer."""

    fmu: str
    kind: str
    stop_s: float
    interval_s: float

    @property
    def steps(self) -> int:
        return round(self.stop_s / self.interval_s)


class Output(NamedTuple):
    """A scalar output, or one element of an output that is an array."""

    name: str
    reference: int
    boolean: bool


Rows = Tuple[List[str], List[List[float]]]


def outputs(task: Task) -> list:
    """The output variables that have numbers and no array of more than three elements."""
    description = read_model_description(task.fmu)
    found = [row for row in description.modelVariables if row.causality == "output" and row.type in NUMBERS]
    return [row for row in found if not row.dimensions or (len(row.dimensions) == 1 and row.dimensions[0].start == "3")]


def scalars(task: Task) -> List[Output]:
    return [Output(row.name, row.valueReference, row.type == "Boolean") for row in outputs(task) if not row.dimensions]


def run_fmpy(task: Task) -> Rows:
    """FMPy's `simulate_fmu`; CVode in Model Exchange, which is allowed 500 steps per output interval."""
    names = [row.name for row in outputs(task)]
    kind = {"cs": "CoSimulation", "me": "ModelExchange"}[task.kind]
    parts = {"cs": 1, "me": PARTS}[task.kind]
    found = simulate_fmu(task.fmu, fmi_type=kind, stop_time=task.stop_s, output_interval=task.interval_s / parts, output=names,
                         record_events=False, relative_tolerance=TOLERANCE if task.kind == "me" else None)[::parts]
    head, columns = ["time"], [found["time"]]
    for name in names:
        column = found[name].astype(float)
        if column.ndim == 1:
            head.append(name)
            columns.append(column)
        else:
            head += [f"{name}.{axis}" for axis in "xyz"]
            columns += list(column.T)
    return head, [list(row) for row in zip(*columns)]


def run_casadi(task: Task) -> Rows:
    """CasADi's DaeBuilder, integrated by CVODES; without events."""
    import casadi
    import numpy as np

    os.chdir(Path(task.fmu).parent)  # it unpacks into the current folder
    builder = casadi.DaeBuilder("model", task.fmu)
    # Boolean outputs are read as Real and fail
    names = [row.name for row in scalars(task) if not row.boolean]
    builder.set_y(names)
    function = builder.create("f", ["t", "x", "u", "p"], ["ode", "y"])
    x0, u, p = (np.array([builder.start(name) for name in names]).ravel() for names in (builder.x(), builder.u(), builder.p()))
    nominal = np.array([builder.nominal(name) for name in builder.x()]).ravel()
    x, t = casadi.MX.sym("x", len(x0)), casadi.MX.sym("t")
    # CasADi has one absolute tolerance for all states: they are scaled
    problem = {"x": x, "t": t, "ode": function(t, x * nominal, u, p)[0] / nominal}
    times = [task.interval_s * k for k in range(task.steps + 1)]
    options = {"reltol": TOLERANCE, "abstol": TOLERANCE, "max_num_steps": 1_000_000}
    march = casadi.integrator("march", "cvodes", problem, 0.0, times, options)
    states = np.array(march(x0=x0 / nominal)["xf"]) * nominal[:, None]
    rows = [[time_s, *np.array(function(time_s, states[:, k], u, p)[1]).ravel()] for k, time_s in enumerate(times)]
    return ["time", *names], rows


def run_libcosim(task: Task) -> Rows:
    """libcosim's fixed-step algorithm."""
    from libcosimpy.CosimEnums import CosimVariableCausality, CosimVariableType
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    execution = CosimExecution.from_step_size(round(task.interval_s * 1e9))
    slave = execution.add_local_slave(CosimLocalSlave(fmu_path=task.fmu, instance_name="model"))
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)
    found = [row for row in execution.slave_variables(slave) if row.causality == CosimVariableCausality.OUTPUT.value]
    real = [row for row in found if row.type == CosimVariableType.REAL.value]
    boolean = [row for row in found if row.type == CosimVariableType.BOOLEAN.value]
    rows = []
    for k in range(1, task.steps + 1):
        if not execution.step():
            raise RuntimeError("cosim_execution_step failed")
        values = list(observer.last_real_values(slave, [row.reference for row in real]))
        if boolean:
            values += [float(value) for value in observer.last_boolean_values(slave, [row.reference for row in boolean])]
        rows.append([k * task.interval_s, *values])
    return ["time", *(row.name.decode() for row in real + boolean)], rows


def run_ecos(task: Task) -> Rows:
    """Ecos with its fixed-step master; its library needs Intel's TBB, which the package does not name."""
    tbb = Path(sys.prefix) / "lib/libtbb.so.12"
    if tbb.exists():
        ctypes.CDLL(str(tbb), mode=ctypes.RTLD_GLOBAL)
    from ecospy.EcosSimulation import EcosSimulation
    from ecospy.EcosSimulationStructure import EcosSimulationStructure

    variables = scalars(task)
    with EcosSimulationStructure() as structure:
        structure.add_model("model", task.fmu)
        with EcosSimulation(structure=structure, step_size=task.interval_s) as simulation:
            simulation.init()
            rows = []
            for k in range(1, task.steps + 1):
                simulation.step(1)
                rows.append([k * task.interval_s, *(float((simulation.get_bool if row.boolean else simulation.get_real)(f"model::{row.name}"))
                                                    for row in variables)])
            simulation.terminate()
    return ["time", *(row.name for row in variables)], rows


def run_pathsim(task: Task) -> Rows:
    """A PathSim simulation with one block: its FMU block of either kind; the implicit ESDIRK43 in Model Exchange."""
    from pathsim import Simulation
    from pathsim.solvers import ESDIRK43, RKF45
    from pathsim_fmi import CoSimulationFMU, FMUWrapper, ModelExchangeFMU

    # the blocks of PathSim read and set every variable, even Booleans and arrays, as one Real, and set inputs to 0 instead of their start
    # values
    def real_outputs(wrapper):
        wrapper.variable_map = {row.name: row for row in wrapper.model_description.modelVariables}
        wrapper.input_refs = {}
        wrapper.output_refs = {row.name: row.reference for row in scalars(task) if not row.boolean}

    # PathSim also interchanges states and derivatives
    def states_of(wrapper):
        rates = [row for row in wrapper.model_description.modelVariables if row.derivative is not None]
        wrapper._derivative_refs = [row.valueReference for row in rates]
        wrapper._state_refs = [row.derivative.valueReference for row in rates]

    FMUWrapper._build_variable_maps, FMUWrapper._build_state_derivative_maps = real_outputs, states_of
    if task.kind == "cs":
        block, solver, options = CoSimulationFMU(task.fmu, dt=task.interval_s), RKF45, {}
    else:
        block, solver, options = ModelExchangeFMU(task.fmu), ESDIRK43, {"tolerance_lte_rel": TOLERANCE, "tolerance_lte_abs": TOLERANCE}
    simulation = Simulation([block], [], dt=task.interval_s if task.kind == "cs" else 1e-6, Solver=solver, log=False, **options)
    names = list(block.fmu_wrapper.output_refs)
    rows = []
    for k in range(1, task.steps + 1):
        if task.kind == "cs":
            simulation.timestep(task.interval_s, adaptive=False)
        else:
            simulation.run(task.interval_s, reset=False, adaptive=True)
        rows.append([k * task.interval_s, *block.outputs.to_array()])
    return ["time", *names], rows


def run_container(task: Task) -> Rows:
    """A container FMU of FMU Manipulation Toolbox, whose C library loads and steps the FMU inside; FMPy runs the container."""
    variables = scalars(task)
    folder = Path(tempfile.mkdtemp())
    inner = shutil.copy(task.fmu, folder / "model.fmu")
    # names within the container are its own, without brackets and dots
    rows = [f"OUTPUT;model.fmu;{row.name};;out{k}" for k, row in enumerate(variables)]
    (folder / "box.csv").write_text("\n".join(["rule;from_fmu;from_port;to_fmu;to_port", "FMU;model.fmu;;;", *rows, ""]), encoding="utf-8")
    version = read_model_description(str(inner)).fmiVersion[0]
    command = [str(Path(sys.prefix) / "bin/fmucontainer"), "-fmu-directory", str(folder), "-container", f"box.csv:{task.interval_s!r}", "-fmi", version,
               "-no-auto-input", "-no-auto-output", "-no-auto-link"]
    subprocess.run(command, check=True, capture_output=True)
    names = [f"out{k}" for k in range(len(variables))]
    found = simulate_fmu(str(folder / "box.fmu"), fmi_type="CoSimulation", stop_time=task.stop_s, output_interval=task.interval_s, output=names,
                         record_events=False)
    shutil.rmtree(folder)
    return ["time", *(row.name for row in variables)], [[float(value) for value in row] for row in zip(found["time"], *(found[name] for name in names))]


def loaded(task: Task):
    """Instance of fmuloader, initialised, with the reader of its outputs."""
    description = read_model_description(task.fmu)
    part = description.coSimulation if task.kind == "cs" else description.modelExchange
    if description.fmiVersion.startswith("2"):
        from fmuloader.fmi2 import Fmi2Slave, Fmi2Type

        slave = Fmi2Slave(task.fmu, model_identifier=part.modelIdentifier)
        slave.instantiate("model", Fmi2Type.CO_SIMULATION if task.kind == "cs" else Fmi2Type.MODEL_EXCHANGE, guid=description.guid)
        slave.setup_experiment(0.0, task.stop_s)
        slave.enter_initialization_mode()
        read = slave.get_real
    else:
        from fmuloader.fmi3 import Fmi3Slave

        slave = Fmi3Slave(task.fmu, model_identifier=part.modelIdentifier)
        instantiate = slave.instantiate_co_simulation if task.kind == "cs" else slave.instantiate_model_exchange
        instantiate("model", instantiation_token=description.guid)
        slave.enter_initialization_mode(0.0, task.stop_s)
        read = slave.get_float64
    slave.exit_initialization_mode()
    variables = scalars(task)
    real, boolean = ([row for row in variables if row.boolean == wanted] for wanted in (False, True))

    def values() -> List[float]:
        logical = [float(value) for value in slave.get_boolean([row.reference for row in boolean])] if boolean else []
        return read([row.reference for row in real]) + logical

    return slave, values, [row.name for row in real + boolean], description


def run_fmuloader(task: Task) -> Rows:
    """fmuloader's direct calls; in Model Exchange Assimulo's CVode with located events."""
    slave, values, names, description = loaded(task)
    if task.kind == "me":
        return exchange(task, slave, values, names, description)
    rows = [[0.0, *values()]]
    for k in range(task.steps):
        slave.do_step(k * task.interval_s, task.interval_s)
        rows.append([(k + 1) * task.interval_s, *values()])
    slave.terminate()
    slave.free_instance()
    return ["time", *names], rows


def exchange(task: Task, slave, values: Callable[[], List[float]], names: List[str], description) -> Rows:
    import numpy as np
    from assimulo.problem import Explicit_Problem
    from assimulo.solvers import CVode

    second = description.fmiVersion.startswith("2")
    n, indicators = description.numberOfContinuousStates, description.numberOfEventIndicators
    if not second:
        n, indicators = slave.get_number_of_continuous_states(), slave.get_number_of_event_indicators()
    derivatives = slave.get_derivatives if second else slave.get_continuous_state_derivatives

    def settle():
        while True:
            info = slave.new_discrete_states() if second else slave.update_discrete_states()
            needed = info.newDiscreteStatesNeeded if second else info.discrete_states_need_update
            if not needed:
                break
        slave.enter_continuous_time_mode()

    settle()
    start, nominal = np.array(slave.get_continuous_states(n)), np.array(slave.get_nominals_of_continuous_states(n))

    def at(time_s, states):
        slave.set_time(time_s)
        slave.set_continuous_states(states)

    def rates(time_s, states, _switches=None):
        at(time_s, states)
        return np.array(derivatives(n))

    problem = Explicit_Problem(rates, start, 0.0, sw0=[True] * indicators) if indicators else Explicit_Problem(rates, start, 0.0)
    if indicators:

        def state_events(time_s, states, _switches):
            at(time_s, states)
            return np.array(slave.get_event_indicators(indicators))

        def handle_event(solver, _info):
            at(solver.t, solver.y)
            slave.enter_event_mode()
            settle()
            solver.y = np.array(slave.get_continuous_states(n))

        problem.state_events, problem.handle_event = state_events, handle_event
    solver = CVode(problem)
    solver.verbosity, solver.rtol, solver.atol, solver.maxsteps = 50, TOLERANCE, TOLERANCE * nominal, 10_000_000
    # the times of rows are reached exactly, and their states read there
    rows = [[0.0, *values()]]
    for k in range(1, task.steps + 1):
        solver.simulate(k * task.interval_s)
        at(solver.t, solver.y)
        rows.append([k * task.interval_s, *values()])
    slave.free_instance()
    return ["time", *names], rows


IMPORTERS: Dict[str, Callable[[Task], Rows]] = {"fmpy": run_fmpy, "casadi": run_casadi, "libcosim": run_libcosim, "ecos": run_ecos,
                                                "pathsim": run_pathsim, "fmuloader": run_fmuloader, "container": run_container}
PACKAGES = {"fmpy": ["fmpy"], "casadi": ["casadi"], "libcosim": ["libcosimpy"], "ecos": ["ecospy"], "pathsim": ["pathsim", "pathsim-fmi"],
            "fmuloader": ["fmuloader", "assimulo-testing"], "container": ["fmu-manipulation-toolbox"]}


def main() -> None:
    logging.disable(logging.WARNING)
    if sys.argv[2:] == ["--version"]:
        print(" with ".join(f"{package} {importlib.metadata.version(package)}" for package in PACKAGES[sys.argv[1]]))
        return
    importer, fmu, kind, stop_s, interval_s, target = sys.argv[1:]
    head, rows = IMPORTERS[importer](Task(fmu, kind, float(stop_s), float(interval_s)))
    with open(target, "w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream)
        writer.writerow(head)
        writer.writerows([[repr(float(value)) for value in row] for row in rows])


if __name__ == "__main__":
    main()
