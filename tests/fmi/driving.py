"""FMUs and their instances for the tests: thin wrappers around FMPy, with results as exact bits."""

import struct
from contextlib import contextmanager
from queue import Empty

from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave
from fmpy.simulation import simulate_fmu

GETTERS = {"Real": "getReal", "Integer": "getInteger", "Boolean": "getBoolean"}
SETTERS = {"Real": "setReal", "Integer": "setInteger", "Boolean": "setBoolean"}


class Fmu:
    """An FMU file, unpacked, with its description and its variables by name."""

    def __init__(self, path, folder):
        self.path = str(path)
        self.folder = str(folder)
        extract(self.path, self.folder)
        self.description = read_model_description(self.path)
        self.variables = {variable.name: variable for variable in self.description.modelVariables}
        self.outputs = [v for v in self.description.modelVariables if v.causality == "output"]

    def simulate(self, **arguments):
        """FMPy's own simulation, recording every output."""
        arguments.setdefault("output", [variable.name for variable in self.outputs])
        return simulate_fmu(self.path, validate=False, **arguments)


class Instance:
    """One instance between instantiation and release."""

    def __init__(self, fmu, name="wing", callbacks=None, logging=False):
        self.fmu = fmu
        description = fmu.description
        self.slave = FMU2Slave(
            guid=description.guid,
            unzipDirectory=fmu.folder,
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName=name,
        )
        self.slave.instantiate(callbacks=callbacks, loggingOn=logging)

    def initialize(self, start_s=0.0, **values):
        """Set-up and Initialization Mode, with values by name (dots written as double underscores)."""
        self.time_s = start_s
        self.slave.setupExperiment(startTime=start_s)
        for name, value in values.items():
            self.set(name.replace("__", "."), value)
        self.slave.enterInitializationMode()
        self.slave.exitInitializationMode()
        return self

    def set(self, name, value):
        """Sets one variable."""
        variable = self.fmu.variables[name]
        getattr(self.slave, SETTERS[variable.type])([variable.valueReference], [value])

    def get(self, name):
        """Value of one variable."""
        variable = self.fmu.variables[name]
        return getattr(self.slave, GETTERS[variable.type])([variable.valueReference])[0]

    def step(self, step_s):
        """One communication step."""
        self.slave.doStep(self.time_s, step_s)
        self.time_s += step_s

    def advance(self, steps, step_s):
        """A number of equal communication steps.

        Counted, not run up to a time: results are bit-identical only between runs that make exactly the same calls.
        """
        for _ in range(steps):
            self.step(step_s)
        return self

    def bits(self):
        """Every output as bits: equality of two of these excludes differences by round-off or signed zeros."""
        reals = [v.valueReference for v in self.fmu.outputs if v.type == "Real"]
        integers = [v.valueReference for v in self.fmu.outputs if v.type == "Integer"]
        booleans = [v.valueReference for v in self.fmu.outputs if v.type == "Boolean"]
        return (
            struct.pack(f"{len(reals)}d", *self.slave.getReal(reals)),
            tuple(self.slave.getInteger(integers)),
            tuple(self.slave.getBoolean(booleans)),
        )

    def history(self, steps, step_s):
        """Output bits after each of a number of equal steps."""
        return [self.advance(1, step_s).bits() for _ in range(steps)]


def answer_of(process, queue):
    """Result that a child process puts into its queue, however long it takes; an error if it ends without one."""
    while True:
        alive = process.is_alive()
        try:
            answer = queue.get(timeout=1.0)
        except Empty:
            assert alive, f"the process has ended with {process.exitcode} and without an answer"
        else:
            process.join()
            return answer


@contextmanager
def instance(fmu, **arguments):
    """An instance that is freed in any case."""
    made = Instance(fmu, **arguments)
    try:
        yield made
    finally:
        made.slave.freeInstance()
