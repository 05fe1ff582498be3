"""Declared dependencies of the Model Exchange FMUs of the shipped models beside those found by differences: `docs/tables/dependences.md`.

    python studies/dependences.py --foldwing COMMAND [--table OUT.md] [--models NAME ...]

Blocks of the Jacobian: derivatives of coordinates, of rates and of the lag states of strips, and Real outputs, with respect to coordinates,
rates, lag states and Real inputs. Counted are all entries, those declared in `ModelStructure`, and those that are not zero: central
differences of the importer at `POINTS` states off the start, an entry above `ROUND_OFF` of those of its column with the same quantity. A declared entry may be zero at
those states; one that is not declared must be zero, or the study ends with an error.
"""

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Model, fmi2Real

ROOT = Path(__file__).resolve().parents[1]
MODELS = sorted(path.stem for path in (ROOT / "examples/models").glob("*.toml"))
POINTS, SEED = 3, 7
# distance of the states from the start over nominal values; rates of stretch have the nominal value of the
# shortest waves, far above those of slow motions
AWAY, LARGEST_NOMINAL = 1e-4, 10.0
# steps over nominal values: derivatives are quadratic in rates and linear in lag states, and long steps have little round-off
STEPS = {"coordinates": 1e-4, "rates": 0.1, "lag states": 0.1}
# steps of inputs in SI units, or relative
INPUT_STEP, LOAD_STEP = 0.1, 100.0
# an entry counts if it exceeds this part of the largest entry of its column among unknowns of the same quantity, and the round-off of the
# largest value of this quantity over the step
ROUND_OFF, DIGITS = 1e-8, 3e-12
KINDS = ("coordinates", "rates", "lag states")
HEAD = """\
# Dependencies of Model Exchange

Made by `python studies/dependences.py --foldwing COMMAND --table docs/tables/dependences.md` (`make validate`): blocks of the Jacobian of the shipped models
with Model Exchange (FMI 2.0). Each cell has three numbers: all entries of the block, those declared in the model description, and those that are not zero by central
differences at {points} states away from the start (above {round_off:g} of the largest entry of their column of the same quantity, and
above round-off of the values, {digits:g} of the largest: a third of that bound counts 2 % more entries). Entries that are declared and zero cost an importer columns
of its Jacobian; an entry that is not declared and not zero would be an error, and there is none. Rows: derivatives of the coordinates, of the rates
(accelerations), of the lag states of strips, and Real outputs. The lists do not contain tunable parameters, because FMI regards them as constant during
the integration.

"""


class Equations:
    """A Model Exchange FMU off its start: values of unknowns for states and inputs."""

    def __init__(self, path, rng):
        self.description = fmpy.read_model_description(str(path), validate=False)
        self.rows = self.description.modelVariables
        self.fmu = FMU2Model(guid=self.description.guid, unzipDirectory=fmpy.extract(str(path)), instanceName="machine",
                             modelIdentifier=self.description.modelExchange.modelIdentifier)
        self.fmu.instantiate()
        self.fmu.setupExperiment(startTime=0.0)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()
        self.fmu.newDiscreteStates()
        self.fmu.enterContinuousTimeMode()
        self.derivatives = [unknown.variable for unknown in self.description.derivatives]
        self.states = [row.derivative for row in self.derivatives]
        self.inputs = [row for row in self.rows if row.causality == "input" and row.type == "Real"]
        self.outputs = [unknown.variable for unknown in self.description.outputs if unknown.variable.type == "Real"]
        self.input_steps = np.array([LOAD_STEP if row.declaredType and row.declaredType.unit in ("N", "N.m") else INPUT_STEP for row in self.inputs])
        # rows of equal kind and quantity: a slope of a position is small beside one of an acceleration
        kinds = [(kind_of(state.name), row.declaredType and row.declaredType.name) for state, row in zip(self.states, self.derivatives)]
        kinds += [("outputs", row.declaredType and row.declaredType.name) for row in self.outputs]
        self.groups = [[k for k, own in enumerate(kinds) if own == kind] for kind in dict.fromkeys(kinds)]
        n = len(self.states)
        self.start, nominal = ((fmi2Real * n)() for _ in range(2))
        self.fmu.getContinuousStates(self.start, n)
        self.fmu.getNominalsOfContinuousStates(nominal, n)
        self.nominal = np.minimum(np.array(nominal), LARGEST_NOMINAL)
        self.x = np.array(self.start) + AWAY * self.nominal * rng.standard_normal(n)
        self.u = np.array(self.fmu.getReal([row.valueReference for row in self.inputs])) if self.inputs else np.zeros(0)

    def __call__(self, x, u):
        """Derivatives of the states, then outputs."""
        n = len(x)
        self.fmu.setContinuousStates((fmi2Real * n)(*x), n)
        if self.inputs:
            self.fmu.setReal([row.valueReference for row in self.inputs], list(u))
        slopes = (fmi2Real * n)()
        self.fmu.getDerivatives(slopes, n)
        return np.r_[np.array(slopes), self.fmu.getReal([row.valueReference for row in self.outputs])]

    def differences(self):
        """Whether each unknown changes with each state and each input."""
        known = np.r_[self.x, self.u]
        steps = np.r_[[STEPS[kind_of(state.name)] for state in self.states] * self.nominal, self.input_steps * np.maximum(1.0, np.abs(self.u))]
        n, base = len(self.x), np.abs(self(self.x, self.u))
        found = []
        for k, step in enumerate(steps):
            there = [known + sign * step * (np.arange(len(known)) == k) for sign in (1.0, -1.0)]
            slope = (self(there[0][:n], there[0][n:]) - self(there[1][:n], there[1][n:])) / (2.0 * step)
            bound = np.zeros(len(slope))
            for group in self.groups:
                bound[group] = ROUND_OFF * np.abs(slope[group]).max() + DIGITS * base[group].max() / step
            found.append(np.abs(slope) > bound)
        self(self.x, self.u)
        return np.array(found).T

    def close(self):
        self.fmu.freeInstance()


def kind_of(name):
    """Block of a state by its name."""
    return "lag states" if "lag" in name else "rates" if name.startswith("state_rate.") else "coordinates"


def declared(equations):
    """Whether the description declares each unknown to depend on each state and each input."""
    known = {id(row): k for k, row in enumerate([*equations.states, *equations.inputs])}
    unknowns = [*equations.description.derivatives, *(unknown for unknown in equations.description.outputs if unknown.variable.type == "Real")]
    found = np.zeros((len(unknowns), len(known)), dtype=bool)
    for k, unknown in enumerate(unknowns):
        if unknown.dependencies is None:
            found[k] = True
            continue
        for row in unknown.dependencies:
            if id(row) in known:
                found[k, known[id(row)]] = True
    return found


def study(path, points=POINTS):
    """Blocks of rows and columns with (entries, declared, not zero), and the names of entries that are not zero and not declared."""
    rng = np.random.default_rng(SEED)
    changes = None
    for _ in range(points):
        equations = Equations(path, rng)
        found = equations.differences()
        changes = found if changes is None else changes | found
        lists = declared(equations)
        equations.close()
    rows = [kind_of(state.name) for state in equations.states] + ["outputs"] * len(equations.outputs)
    columns = [kind_of(state.name) for state in equations.states] + ["inputs"] * len(equations.inputs)
    names = [row.name for row in [*equations.derivatives, *equations.outputs]], [row.name for row in [*equations.states, *equations.inputs]]
    false_zeros = [f"{names[0][i]} by {names[1][j]}" for i, j in np.argwhere(changes & ~lists)]
    blocks = {}
    for row in (*KINDS, "outputs"):
        for column in (*KINDS, "inputs"):
            part = np.ix_([name == row for name in rows], [name == column for name in columns])
            if lists[part].size:
                blocks[row, column] = lists[part].size, int(lists[part].sum()), int(changes[part].sum())
    return blocks, false_zeros


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--foldwing", type=Path, required=True, help="the command")
    parser.add_argument("--table", type=Path, help="file for the table")
    parser.add_argument("--models", nargs="*", default=MODELS, help="names of model files [default: all]")
    arguments = parser.parse_args()
    lines = ["| model | rows | by coordinates | by rates | by lag states | by inputs |", "|---|---|---|---|---|---|"]
    wrong = []
    sums = np.zeros(3, dtype=int)
    with tempfile.TemporaryDirectory() as folder:
        for model in arguments.models:
            path = Path(folder) / f"{model}.fmu"
            command = [arguments.foldwing, "package", ROOT / f"examples/models/{model}.toml", "-o", path, "--interface", "me", "--no-reference", "-q"]
            made = subprocess.run(command, capture_output=True, text=True)
            if made.returncode:
                if "lattice" in made.stderr:
                    continue
                raise SystemExit(made.stderr)
            blocks, false_zeros = study(path)
            wrong += [f"{model}: {name}" for name in false_zeros]
            for row in (*KINDS, "outputs"):
                cells = []
                for column in (*KINDS, "inputs"):
                    block = blocks.get((row, column))
                    sums += block or 0
                    cells.append("–" if block is None else " / ".join(map(str, block)))
                if any(cell != "–" for cell in cells):
                    title = row if row == "outputs" else f"derivatives of {row}"
                    lines.append(f"| `{model}` | {title} | " + " | ".join(cells) + " |")
                    print(lines[-1], flush=True)
    total = f"All models: {sums[0]} entries, {sums[1]} declared, {sums[2]} not zero; not declared and not zero: {len(wrong)}."
    print(total)
    if wrong:
        print("\n".join(wrong[:20]))
        return 1
    if arguments.table:
        arguments.table.write_text(HEAD.format(points=POINTS, round_off=ROUND_OFF, digits=DIGITS) + "\n".join([*lines, "", total, ""]), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
