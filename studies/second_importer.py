"""Validates and runs every shipped model in all four forms with an importer that is neither ours nor FMPy, the crate fmi-rs;
`studies/importers.py` calls `table`.

FMI 2.0 and 3.0, co-simulation and Model Exchange. Co-simulation is compared with `foldwing simulate` at the same communication points,
Model Exchange, integrated by the importer with the fourth-order Runge–Kutta method and located events, with `foldwing simulate` at a
tolerance of 1e-12. The difference of an output is divided by its range in the run, that of a vector by the largest range of its
components. In Model Exchange only positions, angles and energies are compared: velocities, accelerations and loads contain waves in the
beams whose phase changes with the last bits of a latch time. Fails if a form that the model supports does not run, a finding is printed,
or a bound of `ALLOWED` is exceeded.
"""

import csv
import math
import subprocess
import tempfile
from pathlib import Path
from typing import Dict, List, Optional, Tuple

ROOT = Path(__file__).resolve().parents[1]
MODELS = sorted((ROOT / "examples/models").glob("*.toml"))
FORMS = [(2, "cs"), (3, "cs"), (2, "me"), (3, "me")]
STEPS = 60
# outputs compared in Model Exchange
MOTION = (".angle", ".position.x", ".position.y", ".position.z", "energy.kinetic", "energy.gravity")
# relative variation below which an output counts as constant
STILL = 1e-5
# magnitude in SI units below which an output is zero except for round-off
ZERO = 1e-6
# equal times give equal bits; fmi-rs sums up its times while ours are multiples of the step, so that they differ by round-off
ALLOWED = {"cs": 1e-9, "me": 1e-5}
# co-simulation with strips uses aerodynamic steps, whose second-order error the importer's integrator does not have
ALLOWED_STRIPS = 2e-2
# difference in s between latch times of the importer's integrator and ours at 1e-12
ALLOWED_LATCH_S = 1e-6
# Runge–Kutta step below the stability limit of the stiffest strain
STEP_S = 4e-6
SHORTER_S = {"flared_wing_tip": 5e-7, "roll_fold": 1e-7, "three_bodies": 1e-6}
STOP_S = {"cs": 0.3, "me": 0.15}
# models with many strips and a short step
SHORTER_RUN_S = {"flared_wing_tip": 0.015, "roll_fold": 0.006, "slender_wing": 0.06}


def columns(path: Path) -> Dict[str, List[float]]:
    """Numerical columns of a CSV file by name; arrays of three elements become `.x`, `.y` and `.z`, other arrays and text are omitted."""
    with open(path, newline="", encoding="utf-8") as stream:
        head, *rows = list(csv.reader(stream))
    found = {}
    for name, cells in zip(head, zip(*rows)):
        parts = [cell.split() for cell in cells]
        axes = {1: [""], 3: [".x", ".y", ".z"]}.get(len(parts[0]), [])
        for place, axis in enumerate(axes):
            try:
                found[name + axis] = [float({"true": "1", "false": "0"}.get(row[place], row[place])) for row in parts]
            except ValueError:
                continue
    return found


def largest_difference(ours: Dict[str, List[float]], theirs: Dict[str, List[float]]) -> Dict[str, float]:
    """Largest differences relative to the range in the run, by output, at the times that both have; the last row of a time counts."""
    last = {round(time, 12): row for row, time in enumerate(theirs["time"])}
    rows = [(row, last[round(time, 12)]) for row, time in enumerate(ours["time"]) if round(time, 12) in last]
    found = {}
    if not rows:
        raise SystemExit("the importer has no row at a time of ours")
    for name in ours.keys() & theirs.keys() - {"time"}:
        stem = name[:-2] if name[-2:] in (".x", ".y", ".z") else None
        kin = [stem + axis for axis in (".x", ".y", ".z") if stem + axis in ours] if stem else [name]
        scale = max(max(ours[other]) - min(ours[other]) for other in kin)
        size = max(abs(value) for other in kin for value in ours[other])
        # a constant output is compared relative to its magnitude
        scale = scale if scale > STILL * size else size
        differences = [abs(ours[name][i] - theirs[name][j]) for i, j in rows]
        # max() ignores NaN
        apart = max(differences) if all(map(math.isfinite, differences)) else math.inf
        if scale > ZERO:
            found[name] = apart / scale
    return found


def run(command: List[str]) -> Optional[str]:
    """Runs a command; returns its error message, if any."""
    done = subprocess.run(command, capture_output=True, text=True)
    return None if done.returncode == 0 else " ".join((done.stdout + done.stderr).split())


def check(model: Path, version: int, kind: str, foldwing: str, importer: str, folder: Path) -> List[str]:
    """One row of the table: model, form, outputs compared, largest difference with its output, latch times, error."""
    archive, theirs, ours = folder / f"{model.stem}{version}{kind}.fmu", folder / f"{model.stem}{version}{kind}-theirs.csv", folder / f"{model.stem}{version}{kind}-ours.csv"
    form = f"FMI {version}.0, {'co-simulation' if kind == 'cs' else 'Model Exchange'}"
    package = [foldwing, "package", str(model), "--fmi", str(version), "--interface", kind, "--no-reference", "-o", str(archive)]
    refusal = run(package)
    if refusal is not None:
        if kind == "me" and "lattice" in refusal:
            return [model.stem, form, "", "", "", "refused: a lattice is sampled"]
        raise SystemExit(f"{model.stem}, {form}: {refusal}")
    stop_s = SHORTER_RUN_S.get(model.stem, STOP_S["me"]) if kind == "me" else STOP_S["cs"]
    step_s = stop_s / STEPS
    finding = run([importer, str(archive), kind, repr(stop_s), repr(step_s), repr(SHORTER_S.get(model.stem, STEP_S)), str(theirs)])
    if finding is not None:
        return [model.stem, form, "", "", "", f"**{finding}**"]
    command = [foldwing, "simulate", str(model), "--stop", repr(stop_s), "--step", repr(step_s), "--csv", str(ours)]
    if kind == "me":
        command += ["--set", "solver.tolerance=1e-12"]
    failure = run(command)
    if failure is not None:
        raise SystemExit(f"{model.stem}: {failure}")
    mine, other = columns(ours), columns(theirs)
    missing = [] if version == 3 else sorted(mine.keys() - other.keys())
    if missing:
        raise SystemExit(f"{model.stem}, {form}: the importer does not have {', '.join(missing)}")
    apart = largest_difference(mine, other)
    if kind == "me":
        apart = {name: value for name, value in apart.items() if name.endswith((*MOTION, ".latch_time"))}
    latches = [name for name in apart if name.endswith(".latch_time") and mine[name][-1] >= 0.0]
    late_s = max((abs(mine[name][-1] - other[name][-1]) for name in latches), default=None)
    compared = {name: value for name, value in apart.items() if name not in latches}
    worst = max(compared, key=lambda name: compared[name])
    wrong = []
    in_strips = kind == "me" and 'model = "strip"' in model.read_text(encoding="utf-8")
    allowed = ALLOWED_STRIPS if in_strips else ALLOWED[kind]
    if compared[worst] > allowed:
        wrong.append(f"**more than {allowed:g}**")
    if late_s is not None and late_s > ALLOWED_LATCH_S:
        wrong.append(f"**latch later by more than {ALLOWED_LATCH_S:g} s**")
    latch = "" if late_s is None else f"{late_s:.1e}"
    return [model.stem, form, str(len(apart)), f"{compared[worst]:.1e} (`{worst}`)", latch, "; ".join(wrong) or "runs"]


def table(foldwing: str, importer: str, only: Optional[str] = None) -> Tuple[List[str], bool]:
    """Lines of the table of all models in all forms, and whether a row is wrong."""
    lines = ["| model | form | outputs | largest difference | latch, s | |", "|---|---|---|---|---|---|"]
    wrong = False
    with tempfile.TemporaryDirectory() as folder:
        for model in MODELS:
            if only and only not in model.stem:
                continue
            for version, kind in FORMS:
                row = check(model, version, kind, foldwing, importer, Path(folder))
                wrong |= "**" in row[-1]
                lines.append("| " + " | ".join(row) + " |")
                print(lines[-1], flush=True)
    return lines, wrong
