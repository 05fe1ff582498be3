"""The WebAssembly component of FMUs in the runtime wasmtime, compared with the native library in the same FMU: `make wasm-fmu`.

    python studies/wasm_component.py --foldwing COMMAND --python PYTHON [--models NAME ...] [--table FILE]

PYTHON is an environment with the packages `wasmtime` and `fmpy`. Each model is packaged with `tools/wasm_fmu.py` for co-simulation and for
Model Exchange. Co-simulation: `STOP_S` in `STEPS` steps, every output over its range in the run; early return at events; state saved and
restored, also as bytes of the other implementation. Model Exchange: derivatives and event indicators at states off the start. Fails if a
bound of `ALLOWED` is exceeded. The last digits differ: the C library of the native one computes sines and powers, Rust's that of the component.
Outputs of one unit may also differ by as much as those of the native library do if one parameter is changed by its last digit: a wing at rest has
no motion, and its rates are errors of round-off and of the iteration, which the last digits determine.
"""

import argparse
import ctypes
import json
import math
import subprocess
import sys
import tempfile
import time
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
STOP_S, STEPS = 0.1, 50
# differences of the last digit of sines grow by the error control of the steps (tolerance 1e-8) and with the motion itself; derivatives
# have them over the largest stiffness
ALLOWED = {"cs": 1e-6, "state": 1e-6, "me": 1e-9}
NOISE = 0.1  # round-off out of the plane of a mechanism grows with the stiffness of its loops (1e-7 N of 9 N in `four_bar`)
LEAST = 1e-4  # in SI units: a wing at rest has accelerations of 4e-9, which are round-off
AFTER = 10  # steps before the state is saved, and as many after it
MODELS = sorted(path.stem for path in (ROOT / "examples/models").glob("*.toml"))


class Component:
    """Instance of a component in wasmtime; methods are the functions of the standard without their prefix."""

    PACKAGE = "fmi:fmi3/{}@3.0.0"

    def __init__(self, fmu, description, kind, early_return=False):
        import wasmtime
        from wasmtime.component import Component as Code, Linker

        engine = wasmtime.Engine()
        identifier = (description.coSimulation or description.modelExchange).modelIdentifier
        with zipfile.ZipFile(fmu) as archive:
            code = Code(engine, archive.read(f"binaries/wasm32-wasip2/{identifier}.wasm"))
        linker = Linker(engine)
        self.messages, self.updates = [], []
        with linker.root() as root:
            with root.add_instance(self.PACKAGE.format("callbacks")) as callbacks:
                callbacks.add_func("log-message", lambda _store, *arguments: self.messages.append(arguments))
                for name in ("clock-update", "lock-preemption", "unlock-preemption"):
                    callbacks.add_func(name, lambda _store: None)
            if kind == "cs":
                with root.add_instance(self.PACKAGE.format("intermediate-update-callbacks")) as callbacks:
                    callbacks.add_func("intermediate-update", self.update)
        self.store = wasmtime.Store(engine)
        self.world = linker.instantiate(self.store, code)
        self.kind = {"cs": "co-simulation", "me": "model-exchange"}[kind]
        self.interface = self.world.get_export_index(self.store, self.PACKAGE.format(self.kind))
        more = (False, False, early_return, early_return, []) if kind == "cs" else (False, False)
        self.handle = None
        self.handle = self.function(f"[static]{self.kind}-instance.instantiate-{self.kind}")(self.store, "wing", description.guid, *more)
        if self.handle is None:
            raise RuntimeError(f"no instance: {self.messages}")

    def update(self, _store, time_s, *_flags):
        self.updates.append(time_s)
        return (False, 0.0)

    def function(self, name):
        found = self.world.get_func(self.store, self.world.get_export_index(self.store, name, self.interface))
        if found is None:
            raise AttributeError(name)
        return found

    def __call__(self, name, *arguments):
        """Result of a method; an error for a status other than ok."""
        found = self.function(f"[method]{self.kind}-instance.{name}")(self.store, self.handle, *arguments)
        if isinstance(found, str) and found != "ok":
            raise RuntimeError(f"{name}: {found}: {self.messages}")
        return found

    def begin(self):
        self("enter-initialization-mode", None, 0.0, None)
        self("exit-initialization-mode")

    def get(self, references):
        return list(self("get-float64", references))

    def step(self, time_s, step_s):
        found = self("do-step", time_s, step_s, True)
        return found.__dict__["last-successful-time"], found.__dict__["event-handling-needed"]

    def event(self):
        self("enter-event-mode")
        self("update-discrete-states")
        self("enter-step-mode")

    def leave_event(self):
        self("update-discrete-states")
        self("enter-step-mode")

    def save(self):
        return bytes(self("get-fmu-state"))

    def restore(self, state):
        self("set-fmu-state", state)

    def rates(self, states):
        """Derivatives and indicators at states."""
        self("set-continuous-states", states)
        return list(self("get-continuous-state-derivatives")) + list(self("get-event-indicators"))

    def start_exchange(self):
        self.begin()
        self("update-discrete-states")
        self("enter-continuous-time-mode")
        return list(self("get-continuous-states")), list(self("get-nominals-of-continuous-states"))

    def close(self):
        self.handle.drop(self.store)


class Native:
    """Instance of the native library through FMPy, with the methods of [`Component`]."""

    def __init__(self, fmu, description, kind, early_return=False):
        import fmpy
        from fmpy.fmi3 import FMU3Model, FMU3Slave

        part = description.coSimulation or description.modelExchange
        arguments = {"guid": description.guid, "unzipDirectory": fmpy.extract(str(fmu)), "instanceName": "wing", "modelIdentifier": part.modelIdentifier}
        self.fmu = FMU3Slave(**arguments) if kind == "cs" else FMU3Model(**arguments)
        self.counts = (description.numberOfContinuousStates, description.numberOfEventIndicators)
        self.sizes = {row.valueReference: size(row) for row in description.modelVariables}
        if kind == "cs":
            self.fmu.instantiate(eventModeUsed=early_return, earlyReturnAllowed=early_return)
        else:
            self.fmu.instantiate()

    def set(self, reference, values):
        self.fmu.setFloat64([reference], values)

    def begin(self):
        self.fmu.enterInitializationMode(startTime=0.0)
        self.fmu.exitInitializationMode()

    def get(self, references):
        return list(self.fmu.getFloat64(references, nValues=sum(self.sizes[reference] for reference in references)))

    def step(self, time_s, step_s):
        event, _, _, last_s = self.fmu.doStep(time_s, step_s)
        return last_s, event

    def event(self):
        self.fmu.enterEventMode()
        self.fmu.updateDiscreteStates()
        self.fmu.enterStepMode()

    def leave_event(self):
        self.fmu.updateDiscreteStates()
        self.fmu.enterStepMode()

    def save(self):
        state = self.fmu.getFMUState()
        return bytes(self.fmu.serializeFMUState(state))

    def restore(self, state):
        self.fmu.setFMUState(self.fmu.deserializeFMUState(state))

    def rates(self, states):
        self.fmu.setContinuousStates((ctypes.c_double * len(states))(*states), len(states))
        rates, indicators = ((ctypes.c_double * n)() for n in self.sizes_of_vectors)
        self.fmu.getContinuousStateDerivatives(rates, len(rates))
        self.fmu.getEventIndicators(indicators, len(indicators))
        return [*rates, *indicators]

    def start_exchange(self):
        self.begin()
        self.fmu.updateDiscreteStates()
        self.fmu.enterContinuousTimeMode()
        n, m = ctypes.c_size_t(), ctypes.c_size_t()
        self.fmu.fmi3GetNumberOfContinuousStates(self.fmu.component, ctypes.byref(n))
        self.fmu.fmi3GetNumberOfEventIndicators(self.fmu.component, ctypes.byref(m))
        self.sizes_of_vectors = (n.value, m.value)
        states, nominals = ((ctypes.c_double * n.value)() for _ in range(2))
        self.fmu.getContinuousStates(states, n.value)
        self.fmu.getNominalsOfContinuousStates(nominals, n.value)
        return list(states), list(nominals)

    def close(self):
        self.fmu.freeInstance()


def size(row):
    """Number of values of a variable."""
    count = 1
    for dimension in row.dimensions:
        count *= int(dimension.start)
    return count


def march(instance, references, begin, steps, events=False):
    """Rows of outputs after each step, and the times of events."""
    step_s, rows, found = STOP_S / STEPS, [], []
    for k in range(begin, begin + steps):
        now_s, end_s = k * step_s, (k + 1) * step_s
        while True:
            last_s, event = instance.step(now_s, end_s - now_s)
            if event:
                found.append(last_s)
                instance.event()
            if last_s >= end_s - 1e-12:
                break
            now_s = last_s
        rows.append(instance.get(references))
    return rows, found


def largest_of_units(values, units):
    """Largest of the values of each unit."""
    found = {}
    for value, unit in zip(values, units):
        found[unit] = max(found.get(unit, 0.0), value)
    return found


def differences(first, second):
    """Largest difference of each column of two lists of rows."""
    return [max(abs(a - b) for a, b in zip(one, other)) for one, other in zip(zip(*first), zip(*second))]


def sizes(rows, units):
    """Size of each column: its largest value, `NOISE` times the largest of its unit, or `LEAST`."""
    own = [max(map(abs, column)) for column in zip(*rows)]
    of_unit = largest_of_units(own, units)
    return [max(size, NOISE * of_unit[unit], LEAST) for size, unit in zip(own, units)]


def apart(first, second, units):
    """Largest difference of two lists of rows over the size of each column."""
    return max(difference / size for difference, size in zip(differences(first, second), sizes(first, units)))


def excess(first, second, changed, units, allowed):
    """Largest difference over its bound: the allowed part of a column's size, or the largest change of its unit in the lists of rows `changed`."""
    changes = [max(column) for column in zip(*(differences(first, rows) for rows in changed))]
    of_unit = largest_of_units(changes, units)
    bounds = [max(allowed * size, of_unit[unit]) for size, unit in zip(sizes(first, units), units)]
    return max(difference / bound for difference, bound in zip(differences(first, second), bounds))


def last_digits(fmu, description, references):
    """Rows of outputs of the native library, with each parameter of the model in turn changed to the next larger number."""
    found = []
    for row in description.modelVariables:
        if row.causality != "parameter" or row.type != "Float64" or row.name.startswith("solver."):
            continue
        values = [float(word) for word in str(row.start).split()]
        changed = [math.nextafter(value, math.inf) if value else value for value in values]
        if changed == values:
            continue
        instance = Native(fmu, description, "cs")
        instance.set(row.valueReference, changed)
        instance.begin()
        found.append(march(instance, references, 0, STEPS)[0])
        instance.close()
    return found


def compare(fmu, kind):
    """Numbers of a table row: one model, one interface type."""
    from fmpy import read_model_description

    description = read_model_description(str(fmu))
    rows = [row for row in description.modelVariables if row.causality == "output" and row.type == "Float64"]
    references = [row.valueReference for row in rows]
    # each value of an array is a column
    units = [row.unit or row.declaredType for row in rows for _ in range(size(row))]
    if kind == "me":
        found = []
        for made in (Native, Component):
            instance = made(fmu, description, kind)
            states, nominals = instance.start_exchange()
            found.append([instance.rates(states)])
            for scale in (1e-3, -2e-3):
                found[-1].append(instance.rates([x + scale * n * (1 + k % 3) for k, (x, n) in enumerate(zip(states, nominals))]))
            instance.close()
        # at rest the derivatives of the start are round-off: the largest of the three states
        largest = max(abs(rate) for rates in found[0] for rate in rates)
        return {"me": max(abs(a - b) for pair in zip(*found) for a, b in zip(*pair)) / largest}
    results, clock_s, states = [], [], []
    for made in (Native, Component):
        instance = made(fmu, description, kind)
        instance.begin()
        begin_s = time.process_time()
        results.append(march(instance, references, 0, STEPS)[0])
        clock_s.append(time.process_time() - begin_s)
        instance.close()
    # a state of one continues in the other
    continued = []
    instances = [made(fmu, description, kind) for made in (Native, Component)]
    for instance in instances:
        instance.begin()
        march(instance, references, 0, AFTER)
        states.append(instance.save())
        continued.append(march(instance, references, AFTER, AFTER)[0])
    for instance, state, expected in zip(instances, states, continued):
        instance.restore(state)
        if march(instance, references, AFTER, AFTER)[0] != expected:
            raise SystemExit(f"{fmu}: {type(instance).__name__}: a restored state does not give the same bits")
    crossed = 0.0
    for instance, state, expected in zip(instances, reversed(states), reversed(continued)):
        instance.restore(state)
        crossed = max(crossed, apart(expected, march(instance, references, AFTER, AFTER)[0], units))
    for instance in instances:
        instance.close()
    # events
    times = []
    for made in (Native, Component):
        instance = made(fmu, description, kind, True)
        instance.begin()
        instance.leave_event()
        times.append(march(instance, references, 0, STEPS, True)[1])
        instance.close()
    if len(times[0]) != len(times[1]):
        raise SystemExit(f"{fmu}: events at {times[0]} and {times[1]}")
    late = max((abs(a - b) for a, b in zip(*times)), default=0.0)
    changed = last_digits(fmu, description, references)
    return {"cs": apart(*results, units), "digits": max(apart(results[0], rows, units) for rows in changed),
            "excess": excess(*results, changed, units, ALLOWED["cs"]), "state": crossed, "events": len(times[0]), "late_s": late, "ratio": clock_s[1] / max(clock_s[0], 1e-9)}


def one(fmu, kind):
    """Prints the numbers of one FMU, for the process that collects them."""
    print(json.dumps(compare(Path(fmu), kind)))


def main():
    """Packages, runs and writes the table."""
    if sys.argv[1:2] == ["--one"]:
        return one(*sys.argv[2:4])
    sys.path.insert(0, str(ROOT / "tools"))
    import wasm_fmu

    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--foldwing", required=True, help="the command")
    parser.add_argument("--python", default=sys.executable, help="Python with wasmtime and fmpy")
    parser.add_argument("--models", nargs="*", default=MODELS, help="names of model files [default: all]")
    parser.add_argument("--target", type=Path, default=ROOT / "target/wasm_fmu", help="folder of the compilation")
    parser.add_argument("--cargo", default="cargo", help="the cargo to call")
    parser.add_argument("--table", type=Path, help="Markdown file for the table")
    arguments = parser.parse_args()
    target = arguments.target.resolve()
    cores = {kind: wasm_fmu.core_module(arguments.cargo, kind, "current", target) for kind in wasm_fmu.WORLDS}
    encode = wasm_fmu.encoder(arguments.cargo, target)
    lines = ["| model | component, bytes | outputs | the same by last digits | over the bound | state of the other | events | times of events, s | derivatives |"
             " time of the processor |", "|---" * 10 + "|"]
    wrong = False
    with tempfile.TemporaryDirectory() as folder:
        for model in arguments.models:
            found, size = {}, 0
            for kind, core in cores.items():
                fmu = Path(folder) / f"{model}-{kind}.fmu"
                made = subprocess.run([arguments.foldwing, "package", ROOT / f"examples/models/{model}.toml", "--fmi", "3", "--interface", kind, "-q",
                                       "--no-reference", "-o", fmu], capture_output=True, text=True)
                if made.returncode:
                    if kind == "me" and "lattice" in made.stderr:
                        continue
                    raise SystemExit(made.stderr)
                size = max(size, wasm_fmu.add_component(fmu, core, encode))
                done = subprocess.run([arguments.python, __file__, "--one", fmu, kind], capture_output=True, text=True)
                if done.returncode:
                    raise SystemExit(f"{model}, {kind}: {done.stdout}{done.stderr}")
                found.update(json.loads(done.stdout.strip().splitlines()[-1]))
            wrong |= found["excess"] > 1.0 or any(found.get(name, 0.0) > allowed for name, allowed in ALLOWED.items() if name != "cs")
            rates = f"{found['me']:.1e}" if "me" in found else "–"
            lines.append(f"| `{model}` | {size} | {found['cs']:.1e} | {found['digits']:.1e} | {found['excess']:.1e} | {found['state']:.1e} | {found['events']} | {found['late_s']:.1e} | {rates} |"
                         f" {found['ratio']:.1f} |")
            print(lines[-1], flush=True)
    if arguments.table:
        version = subprocess.run([arguments.python, "-c", "import importlib.metadata as m; print(m.version('wasmtime'))"], capture_output=True,
                                 text=True, check=True).stdout.strip()
        arguments.table.write_text(HEAD.format(version=version) + "\n".join(lines) + "\n", encoding="utf-8")
    return int(wrong)


HEAD = """\
# The WebAssembly component beside the native library

Made by `make wasm-fmu`: FMUs of FMI 3.0 with the component of `tools/wasm_fmu.py`, in wasmtime {version} (Python), compared with the native library of
the same FMU in FMPy, 0.1 s in 50 steps. Outputs: largest difference over the largest value of a column, a tenth of the largest of its unit, or 1e-4
in SI units. By last digits: the same difference of the native library from itself with one parameter changed by its last digit, the largest of all
parameters. Over the bound: the largest ratio of a difference of the component to its bound, which is 1e-6 of the size or the change of an output of
the same unit by last digits. State of the other: the state that one implementation has saved as bytes after ten steps is restored in the other one; difference over the next ten steps.
Derivatives: of Model Exchange, with the event indicators, at three states, over the largest. The last column is the ratio of the component's time to
the native one's, with FMPy's and wasmtime's own.

"""


if __name__ == "__main__":
    sys.exit(main())
