"""Runs the shipped models as FMUs in importers of other projects, compares them with `foldwing simulate`, and writes the table; `make
importers`.

  python studies/importers.py --foldwing COMMAND --second-importer PROGRAM --python PYTHON [--table FILE] [--only MODEL] [--importers NAME ...]

fmi-rs runs every model in all four forms (`second_importer.py`). The importers of `importer_runs.py`, in the environment of PYTHON, run
every model in co-simulation over `STOP_S`, and those with Model Exchange the models `EXCHANGED`. Co-simulation has to give the numbers of
`foldwing simulate` at the same communication points, Model Exchange those at a tolerance of 1e-12, over the range of each output, within
the bounds of `ALLOWED`. Fails if a form that the importer has does not run, or if a bound is exceeded.
"""

import argparse
import ast
import math
import re
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Dict, List, NamedTuple, Optional, Tuple

from second_importer import MODELS, MOTION, columns, largest_difference, run, table

ROOT = Path(__file__).resolve().parents[1]
RUNS = ROOT / "studies/importer_runs.py"
STOP_S = {"cs": 0.1, "me": 0.02}
STEPS = {"cs": 50, "me": 20}
# one joint with a latch ahead, one with rigid bodies, a loop, and several joints; without strips, whose co-simulation takes aerodynamic steps
EXCHANGED = ("branched", "folding_wing_as_printed", "four_bar", "roll_fold")
# cs: equal calls give equal bits, but importers sum up their times whereas the times here are multiples of the step: the last bits of 50
# steps, which are 1e-9 of the range of a nearly constant energy, and 5e-7 of loads of strips, which contain differences of velocities over
# a step. me: integrators at 1e-8 whose errors of 20 ms are measured below 1e-5 of the motion
ALLOWED = {"cs": 1e-6, "me": 1e-4}
FORMS = {"2 cs": "FMI 2.0, co-simulation", "3 cs": "FMI 3.0, co-simulation", "2 me": "FMI 2.0, Model Exchange", "3 me": "FMI 3.0, Model Exchange"}


class Importer(NamedTuple):
    """An importer of `importer_runs.py`: forms that it supports, reasons why it does not support the others, and advice for its users."""

    title: str
    name: str
    forms: Tuple[str, ...]
    without: str
    workaround: str
    scalars: bool = False  # FMI 3.0 with `package --scalars`


IMPORTERS = [
    Importer("FMPy", "fmpy", ("2 cs", "3 cs", "2 me", "3 me"), "",
             "in Model Exchange an `output_interval` of 0.05 ms: its CVode is allowed 500 steps per interval"),
    Importer("CasADi `DaeBuilder`, CVODES", "casadi", ("2 me", "3 me"), "no co-simulation",
             "FMI 3.0 with `package --scalars`; no Boolean outputs; no events", True),
    Importer("libcosim", "libcosim", ("2 cs",), "no Model Exchange; FMI 3.0 ends its Python process with a segmentation fault", "none"),
    Importer("Ecos", "ecos", ("2 cs", "3 cs"), "no Model Exchange", "`pip install tbb`, and load `libtbb.so.12` first: its package names no dependencies"),
    Importer("PathSim, `pathsim-fmi`", "pathsim", ("2 cs", "3 cs"),
             "Model Exchange exchanges states and derivatives in its Jacobian, which the FMU refuses; with that mended 10 s of the processor do not reach 2 ms",
             "its block reads and sets all variables as one Real, and sets inputs to 0 at first: keep Real scalars only (`run_pathsim`)"),
    Importer("fmuloader; Assimulo's CVode", "fmuloader", ("2 cs", "3 cs", "2 me", "3 me"), "", "none: it passes on calls; the loop is `run_fmuloader`"),
    Importer("FMU Manipulation Toolbox, FMU in a container", "container", ("2 cs", "3 cs"), "no Model Exchange; no arrays of FMI 3.0 in its CSV", "none"),
]

# tried, and not available from a package registry
ABSENT = [
    ("OMSimulator 3.0.0.post198", "PyPI has a source archive alone, whose installation downloads the program from the project's own server; not reached"),
    ("PyFMI 2.5", "PyPI ends in 2018: the source needs FMI Library, which no registry has, and Cython of that time; `assimulo` 3.0 fails in its `setup.py`"),
    ("FMI4j, Vico, JavaFMI, Femyou, FMI.jl, FMI4R, Scilab's toolbox", "in registries that were not reached, or downloaded from the project's own server"),
    ("OpenMDAO 3.45.1", "installs; no component for FMUs is known to us, and its sources were not searched for one"),
    ("GEMSEO-FMU 3.1.1", "installs; it runs FMUs by FMPy 0.3.19, so that it is no importer of its own"),
    ("fmusim, FMU Check, OpenModelica, Dymola, Simulink", "in none of the registries"),
]

# one run by hand, not repeated by this script
BY_OTHERS = """
## Tried by an engineer who had not seen the project

On 2026-11-29, from the FMUs and their pages alone: importers found by search ran all 15 FMUs for 50 steps each, and the folding wing to 0.4 s through its latch, with inputs and parameters changed
before and during the run. Largest difference from FMPy 0.3.32 with the same calls, relative to the range of each output.

| importer | co-simulation | Model Exchange, folding wing | workaround |
|---|---|---|---|
| FMI++ 2.1.0 (PyPI `fmipp`, from its source with SWIG and Boost) | 0, with FMPy at a tolerance of 1e-9: it passes its time resolution as tolerance | Dormand–Prince: angle 6.5e-8, strain 3.7e-5; Rosenbrock diverges, as it does with a transposed Jacobian; its `RollbackFMU` sets times before events | built without SUNDIALS (3.1.2 needed) |
| rust-fmi (crate `fmi` 0.8.0) | 0, FMI 2.0 and 3.0, also with states restored from bytes and in 4 threads | its own Runge–Kutta method: angle 3.4e-7, strain 8.4e-5; both versions bit-identical | FMI 3.0: it rejects `nominal` of Float64 |
| fmi-sim 0.7.0 (the command of rust-fmi) | 0; the reference experiments of the FMU within 5e-14 | forward Euler alone: unstable | FMI 3.0 with `package --scalars` |
| fmu-runner 0.4.4 (crate) | 0, also with a state restored from bytes | – | none |

Defects of Foldwing that this revealed, now corrected: all FMUs had the `modelIdentifier` "foldwing". FMI++ stores libraries by this name, and ran the first model in place of the second one of a process, without
a message; the name is now that of the model. `fmi2SetTime` accepted times before the last event; they are now discarded. `fmi2SetupExperiment` replaced a tolerance that had been set as a parameter; the parameter
now has priority. The FMU's page now states that forces and accelerations are not converged at the default tolerance.
"""


class Finding(NamedTuple):
    """The runs of one form in one importer: models compared, largest difference and where, failures."""

    models: int
    worst: float
    where: str
    failures: List[str]

    def cell(self) -> str:
        if self.failures:
            return "; ".join(self.failures)
        return f"{self.models}: {self.worst:.1e} (`{self.where}`)"


def package(foldwing: str, model: Path, form: str, scalars: bool, folder: Path) -> Optional[Path]:
    """The FMU, or None for a model with a lattice, for which Model Exchange is not available."""
    version, kind = form.split()
    more = ["--scalars"] if scalars and version == "3" else []
    archive = folder / f"{model.stem}{version}{kind}{len(more)}.fmu"
    if not archive.exists():
        command = [foldwing, "package", str(model), "--fmi", version, "--interface", kind, "--no-reference", "-q", "-o", str(archive), *more]
        refusal = run(command)
        if refusal is not None:
            if kind == "me" and "lattice" in refusal:
                return None
            raise SystemExit(f"{model.stem}, {form}: {refusal}")
    return archive


def expected(foldwing: str, model: Path, kind: str, folder: Path) -> Dict[str, List[float]]:
    """Columns of `foldwing simulate` at the communication points."""
    file = folder / f"{model.stem}-{kind}.csv"
    if not file.exists():
        command = [foldwing, "simulate", str(model), "--stop", repr(STOP_S[kind]), "--step", repr(STOP_S[kind] / STEPS[kind]), "--csv", str(file)]
        if kind == "me":
            command += ["--set", "solver.tolerance=1e-12"]
        failure = run(command)
        if failure is not None:
            raise SystemExit(f"{model.stem}: {failure}")
    return columns(file)


def compare(importer: Importer, form: str, models: List[Path], arguments: argparse.Namespace, folder: Path) -> Finding:
    """Runs all models of a form in the importer."""
    kind = form.split()[1]
    worst, where, count, failures = 0.0, "", 0, []
    for model in models:
        archive = package(arguments.foldwing, model, form, importer.scalars, folder)
        if archive is None:
            continue
        theirs = folder / f"{model.stem}-{importer.name}.csv"
        command = [arguments.python, str(RUNS), importer.name, str(archive), kind, repr(STOP_S[kind]), repr(STOP_S[kind] / STEPS[kind]), str(theirs)]
        failure = run(command)
        if failure is not None:
            failures.append(f"**{model.stem}: {failure[-200:]}**")
            continue
        apart = largest_difference(expected(arguments.foldwing, model, kind, folder), columns(theirs))
        if kind == "me":
            apart = {name: value for name, value in apart.items() if name.endswith(MOTION)}
        if not apart:
            failures.append(f"**{model.stem}: no output in common**")
            continue
        own = max(apart, key=lambda name: apart[name])
        count += 1
        if apart[own] >= worst:
            worst, where = apart[own], f"{model.stem}: {own}"
    if worst > ALLOWED[kind]:
        failures.append(f"**{worst:.1e} (`{where}`): more than {ALLOWED[kind]:g}**")
    return Finding(count, worst, where, failures)


def matrix(arguments: argparse.Namespace, folder: Path) -> Tuple[List[str], bool]:
    """The table of importers and forms, and whether something failed."""
    lines = ["| importer | " + " | ".join(FORMS.values()) + " | workaround |", "|---" * (len(FORMS) + 2) + "|"]
    wrong = False
    for importer in IMPORTERS:
        if arguments.importers and importer.name not in arguments.importers:
            continue
        version = subprocess.run([arguments.python, RUNS, importer.name, "--version"], capture_output=True, text=True, check=True).stdout.strip()
        cells = []
        for form in FORMS:
            if form not in importer.forms:
                cells.append("–")
                continue
            models = [model for model in MODELS if not arguments.only or arguments.only in model.stem]
            if form.endswith("me"):
                models = [model for model in models if model.stem in EXCHANGED]
            found = compare(importer, form, models, arguments, folder)
            wrong |= bool(found.failures)
            cells.append(found.cell())
            print(importer.title, form, cells[-1], flush=True)
        note = "; ".join(text for text in (importer.workaround, importer.without) if text and text != "none")
        lines.append(f"| {importer.title} ({version}) | " + " | ".join(cells) + f" | {note} |")
    return lines, wrong


SYSTEM = ROOT / "examples/controlled_wing_ssp.py"
# start angle in degrees, run in s, steps in s
START_DEG, SYSTEM_STOP_S, SYSTEM_STEPS_S = 120.0, 0.05, (5e-4, 2.5e-4, 1.25e-4)
# the controller has a delay of one or two steps: the error is of first order, and halves with the step
ORDER = (1.85, 2.15)


def systems(arguments: argparse.Namespace, folder: Path) -> Tuple[List[str], bool]:
    """The controller beside the wing as an SSP file in four importers: difference from one model with that motor, by step."""
    text = (ROOT / "examples/models/folding_wing.toml").read_text(encoding="utf-8").partition("[joint.fold.motor]")[2]
    motor = {key: float(value) for key, value in re.findall(r"^(\w+) = ([\d.e-]+)$", text.partition("\n[")[0], re.MULTILINE)}
    law = ast.literal_eval(re.search(r"^CONTROLLER = (.*)$", SYSTEM.read_text(encoding="utf-8"), re.MULTILINE)[1])
    csv_file = folder / "single.csv"
    stiffness, damping = motor["stiffness_N_m_rad"] + law["stiffness"], motor["damping_N_m_s_rad"] + law["damping"]
    command = [arguments.foldwing, "simulate", str(ROOT / "examples/models/folding_wing.toml"), "--set", f"fold.start_angle={START_DEG} deg", "--set",
               f"fold.motor_stiffness={stiffness!r}", "--set", f"fold.motor_damping={damping!r}",
               "--set", "solver.tolerance=1e-8", "--stop", repr(SYSTEM_STOP_S), "--step", repr(SYSTEM_STOP_S), "--csv", str(csv_file)]
    failure = run(command)
    if failure is not None:
        raise SystemExit(failure)
    single_deg = math.degrees(columns(csv_file)["fold.angle"][-1])
    found: Dict[str, List[float]] = {}
    for step_s in SYSTEM_STEPS_S:
        script = [arguments.python, str(SYSTEM), "--foldwing", arguments.foldwing, "--output", str(folder / "system.ssp"), "--start", repr(START_DEG),
                  "--stop", repr(SYSTEM_STOP_S), "--step", repr(step_s)]
        done = subprocess.run(script, capture_output=True, text=True)
        if done.returncode:
            raise SystemExit(done.stdout + done.stderr)
        for name, angle in re.findall(r"^(\w+(?: \w+)?) +fold angle after [\d.]+ s: ([-\d.]+) degrees$", done.stdout, re.MULTILINE):
            found.setdefault(name, []).append(float(angle) - single_deg)
    lines = ["| importer | " + " | ".join(f"{1e3 * step_s:g} ms" for step_s in SYSTEM_STEPS_S) + " | order |", "|---" * (len(SYSTEM_STEPS_S) + 2) + "|"]
    wrong = len(found) != 4
    for name, off in found.items():
        ratios = [first / second for first, second in zip(off, off[1:])]
        bad = len(off) != len(SYSTEM_STEPS_S) or not all(ORDER[0] < ratio < ORDER[1] for ratio in ratios)
        wrong |= bad
        order = " and ".join(f"{math.log2(ratio):.2f}" if ratio > 0.0 else "none" for ratio in ratios)
        lines.append(f"| {name} | " + " | ".join(f"{value:.2e}" for value in off) + f" | {'**' if bad else ''}{order}{'**' if bad else ''} |")
        print(lines[-1], flush=True)
    return lines, wrong


FARM = ROOT / "examples/turbine/two_turbines_ssp.py"
FARM_STOP_S = 60.0
# equal calls give equal bits, but importers sum up their times: round-off, which the controllers' limits do not amplify
FARM_ALLOWED = 1e-9


def farm(arguments: argparse.Namespace, folder: Path) -> Tuple[List[str], bool]:
    """Two turbines with a farm controller as an SSP file in four importers, beside the turbines as single models."""
    script = [arguments.python, str(FARM), "--foldwing", arguments.foldwing, "--output", str(folder / "farm.ssp"), "--stop", repr(FARM_STOP_S)]
    done = subprocess.run(script, capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(done.stdout + done.stderr)
    number = r"([-+\d.e]+)"
    pattern = rf"^(\w+(?: \w+)?) +after [\d.]+ s: wind at the back {number} m/s, power {number} and {number} MW, pitch .*off the single models: {number}$"
    lines = ["| importer | wind at the back, m/s | power of the front, MW | of the back | off the single models |", "|---|---|---|---|---|"]
    found = re.findall(pattern, done.stdout, re.MULTILINE)
    wrong = len(found) != 4
    for name, *numbers, off in found:
        bad = float(off) > FARM_ALLOWED
        wrong |= bad
        lines.append(f"| {name} | " + " | ".join(numbers) + f" | {'**' if bad else ''}{off}{'**' if bad else ''} |")
        print(lines[-1], flush=True)
    return lines, wrong


HEAD = """\
# Importers

Made by `make importers` in environments with pinned versions (`python/requirements-importers.txt`, `tools/second_importer`): FMUs of the
shipped models in importers that are not ours, beside `foldwing simulate`. A cell has the number of models and the largest difference of an
output over its range in the run (of a vector: over the largest range of its components). Co-simulation: all models, 0.1 s in 50 steps. Model
Exchange: {exchanged}, 20 ms at a tolerance of 1e-8; angles, positions
and energies. `–`: the importer has no such form, or the last column names the reason.

"""


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--foldwing", required=True)
    parser.add_argument("--second-importer", help="program of tools/second_importer; without it fmi-rs is left out")
    parser.add_argument("--python", default=sys.executable, help="Python of the environment with the importers")
    parser.add_argument("--table", type=Path, help="Markdown file to write the tables to")
    parser.add_argument("--only", help="a part of the names of models")
    parser.add_argument("--importers", nargs="*", help="names of importers [default: all]")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        lines, wrong = matrix(arguments, Path(folder))
        rows, bad = systems(arguments, Path(folder))
        turbines, worse = farm(arguments, Path(folder))
        wrong |= bad or worse
    text = HEAD.format(exchanged=", ".join(f"`{name}`" for name in EXCHANGED)) + "\n".join(lines) + "\n"
    text += "\nNot to be had from the package registries, or without an importer in it:\n\n| importer | tried |\n|---|---|\n"
    text += "".join(f"| {name} | {tried} |\n" for name, tried in ABSENT)
    text += ("\n## A system with parameters\n\n`examples/controlled_wing_ssp.py`: a controller beside the wing in the SSP file of `package --ssp`, its start angle and"
             " gains in SSV files. Difference of the fold angle in degrees after 50 ms from one model whose motor has the controller's spring too, by"
             " communication step.\n\n" + "\n".join(rows) + "\n")
    text += ("\n## Two turbines\n\n`examples/turbine/two_turbines_ssp.py`: two turbines in a row, the wake of the front one and a controller that shares 8 MW"
             f" between them, {FARM_STOP_S:g} s in steps of 20 ms. Largest difference of twelve results from the turbines as single models by direct calls in"
             " the importer's order, over the largest value of each. The importers differ in the values that components take in the first step, and in"
             " their order.\n\n" + "\n".join(turbines) + "\n")
    text += BY_OTHERS
    if arguments.second_importer:
        rows, bad = table(arguments.foldwing, arguments.second_importer, arguments.only)
        wrong |= bad
        text += ("\n## fmi-rs\n\nfmi-rs 0.3.4, every model in all four forms. In Model Exchange a fourth-order Runge–Kutta method with located events"
                 " integrates; in strips co-simulation takes aerodynamic steps, which the integrator outside does not.\n\n" + "\n".join(rows) + "\n")
    if arguments.table:
        arguments.table.write_text(text, encoding="utf-8")
    return int(wrong)


if __name__ == "__main__":
    sys.exit(main())
