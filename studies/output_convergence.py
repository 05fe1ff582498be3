#!/usr/bin/env python3
"""Errors of every output of the shipped models by tolerance, against tolerance 1e-9: docs/tables/outputs.md.

  python studies/output_convergence.py --foldwing COMMAND --table docs/tables/outputs.md [--csv ALL.csv] [--model NAME]...

The error of an output is the largest deviation from the run at 1e-9 over all communication points, divided by the range of the output in
that run, or for `energy.total` by that of the kinetic energy. With aerodynamics `coupling_tolerance` follows the tolerance; the
aerodynamic steps are not changed, so that the errors are those of the structure and of its coupling with the aerodynamics. Needs NumPy.
"""
import argparse
import csv
import pathlib
import re
import subprocess
import tempfile

import numpy as np

TOLERANCES = ["1e-4", "1e-5", "1e-6", "1e-7", "1e-8"]
REFERENCE = "1e-9"
FALL = 10.0
# Changes with which the errors of every output decrease: stiffness-proportional damping in s against waves along the bodies; if
# this is not enough, more of it (undamped bending), or a longer maximum step, so that the tolerance determines the step.
DAMPING_S = 1e-5
CURES = {
    "curved_blade": {"max_step_s": 1.0},
    "double_pendulum": {"stiffness_damping_s": 1e-3, "max_step_s": 0.1},
    "roll_fold": {"max_step_s": 0.1},
}
# Errors below this fraction of the range at 1e-5 need not decrease: round-off of the CSV and of the reference.
SMALL = 1e-5
# Models that are excluded, and why.
LEFT_OUT = {
    "folding_wing_in_tunnel": "at 1e-9 the trial marches of one aerodynamic step take more than the 2·10⁵ iterations that a "
    "communication step may cost, with internal steps of 1e-7 s"
}
# Outputs whose range is below this fraction of the largest of their kind count as constant: symmetry or a free joint keeps them
# at zero.
NOTHING = SMALL


def with_tolerance(text, tolerance):
    """The model with a given tolerance of the solver and of the aerodynamic coupling."""
    text = re.sub(r"^tolerance *=.*$", "", text, flags=re.M)
    text = text.replace("[aerodynamics]", f"[aerodynamics]\ncoupling_tolerance = {tolerance}")
    if "[solver]" in text:
        return text.replace("[solver]", f"[solver]\ntolerance = {tolerance}")
    return text.replace("[simulation]", f"[solver]\ntolerance = {tolerance}\n[simulation]")


def cured(name, text):
    """The model with the change in `CURES`, otherwise with stiffness-proportional damping on every body that has none."""
    cure = CURES.get(name, {"stiffness_damping_s": DAMPING_S})
    if "max_step_s" in cure:
        text = re.sub(r"^max_step_s *=.*$", "", text, flags=re.M)
        line = f"[solver]\nmax_step_s = {cure['max_step_s']}"
        text = text.replace("[solver]", line) if "[solver]" in text else text.replace("[simulation]", f"{line}\n[simulation]")
    return damped(text, cure["stiffness_damping_s"]) if "stiffness_damping_s" in cure else text


def damped(text, damping_s):
    """The model with stiffness-proportional damping on every body that has none."""
    parts = re.split(r"^(?=\[)", text, flags=re.M)
    key = f"stiffness_damping_s = {damping_s}\n"
    return "".join(
        part.replace("]\n", "]\n" + key, 1) if part.startswith("[body.") and "stiffness_damping_s" not in part else part
        for part in parts
    )


def run(command, text, folder):
    """Columns of a run with all outputs."""
    (folder / "model.toml").write_text(text)
    result = folder / "run.csv"
    result.unlink(missing_ok=True)
    subprocess.run([command, "simulate", folder / "model.toml", "--csv", result], check=True, capture_output=True)
    with result.open() as file:
        rows = csv.reader(line for line in file if not line.startswith("#"))
        names = next(rows)
        values = [[{"true": "1", "false": "0"}.get(cell, cell) for cell in row] for row in rows]
    return dict(zip(names, np.array(values, float).T))


def errors(command, text, folder):
    """Error divided by the range of every output that is not constant, by tolerance."""
    reference = run(command, with_tolerance(text, REFERENCE), folder)
    runs = [run(command, with_tolerance(text, tolerance), folder) for tolerance in TOLERANCES]
    found = {}
    scales = {}
    for name, right in reference.items():
        scales[kind(name)] = max(scales.get(kind(name), 0.0), np.ptp(right))
    for name, right in reference.items():
        span = np.ptp(right)
        discrete = set(np.unique(right)) <= {-1.0, 0.0, 1.0, 2.0}
        if name == "time" or name.endswith((".latch_time", ".latch_count")) or discrete or span <= NOTHING * scales[kind(name)]:
            continue
        if name == "energy.total":
            span = max(span, np.ptp(reference["energy.kinetic"]))
        found[name] = [abs(own[name] - right).max() / span for own in runs]
    return found


def kind(name):
    """Quantity of an output: its name without location and direction. Energies are one kind; moments count with forces, 1 N·m as 1 N, so
    that moments about a ball joint, and the work at a fixed root, count as zero.
    """
    measured = re.sub(r"\.[xyzw]$", "", name).split(".")[-1]
    return "energy" if name.startswith("energy.") else "force" if measured == "moment" else measured


def falls(row):
    """Whether an error decreases by a factor of ten from 1e-5 to 1e-7."""
    return row[1] < SMALL or row[3] <= row[1] / FALL


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--foldwing", required=True)
    parser.add_argument("--table", type=pathlib.Path)
    parser.add_argument("--csv", type=pathlib.Path)
    parser.add_argument("--model", action="append", help="name of a shipped model; all if left out")
    arguments = parser.parse_args()
    models = pathlib.Path(__file__).resolve().parents[1] / "examples/models"
    chosen = [
        path
        for path in sorted(models.glob("*.toml"))
        if path.stem not in LEFT_OUT and (not arguments.model or path.stem in arguments.model)
    ]
    summary, exceptions, everything = [], [], []
    with tempfile.TemporaryDirectory() as folder:
        for path in chosen:
            text = path.read_text()
            found = errors(arguments.foldwing, text, pathlib.Path(folder))
            calm = "–"
            if "[aerodynamics]" not in text:
                calm = errors(arguments.foldwing, cured(path.stem, text), pathlib.Path(folder)).values()
                calm = f"{sum(map(falls, calm))} of {len(calm)}"
            everything += [[path.stem, name, *row] for name, row in found.items()]
            stuck = {name: row for name, row in found.items() if not falls(row)}
            exceptions += [[path.stem, name, *row] for name, row in stuck.items()]
            columns = np.array(list(found.values()))
            summary.append([path.stem, f"{len(found) - len(stuck)} of {len(found)}", calm, *np.median(columns, axis=0), *columns.max(axis=0)])
            print(path.stem, f"{len(found) - len(stuck)} of {len(found)} fall, cured {calm}", flush=True)
    if arguments.csv:
        with arguments.csv.open("w", newline="") as file:
            csv.writer(file).writerows([["model", "output", *TOLERANCES], *everything])
    if arguments.table:
        arguments.table.write_text(page(summary, exceptions))


# The exceptions by group, as described in the page.
WHAT_DOES_NOT_FALL = """\
Errors that do not fall, by group:

| models | outputs | cause | cure |
|---|---|---|---|
| `folding_wing`, `folding_wing_as_printed`, `folding_wing_constant`, `branched`, `four_bar` | accelerations, velocities and rates of inner stations, root forces, a few strains and angles | waves along the bodies and the highest bending modes, which a release and a latch strike and nothing damps: no step resolves them above 1e-8 and the method damps them, the undamped equations keep them | `stiffness_damping_s`, 1e-5 s and more |
| `double_pendulum` | rates, forces, strain, accelerations | bending of 1 % of the rates that the sudden start leaves and nothing damps; beside it the longest step, which binds at 1e-4 and 1e-5 | `stiffness_damping_s = 1e-3` |
| `curved_blade`, `roll_fold` | most outputs; heights of the outer stations | the longest step binds at 1e-4 and 1e-5, where the errors are already below those of the tolerance: they are small, not stuck | none needed; with a larger `max_step_s` the tolerance decides, and every output falls |
| `flared_wing_tip`, `goland_wing`, `slender_wing` | accelerations, root forces and moments, velocities and rates of the stations | the structure takes at least one step per aerodynamic step, and down to 1e-7 mostly no more: the errors are the same at 1e-4 and 1e-7. The largest are those of waves that the loads strike at the start of every aerodynamic step | a smaller `aerodynamics.step_s`, whose own error is larger and of second order (Q-01) |""".splitlines()


def settings(cure):
    """A change as lines of a model file."""
    return " and ".join(f"`{key} = {value:g}`" for key, value in cure.items())


def page(summary, exceptions):
    """The page in Markdown."""
    number = lambda value: f"{value:.1e}"
    lines = [
        "# Errors of the outputs by tolerance",
        "",
        "Largest departure from the run at tolerance 1e-9 over all communication points, as a share of the output's range there;",
        "method ESDIRK4, every output that moves, of every shipped model. In air `coupling_tolerance` goes with the tolerance, the",
        "aerodynamic steps stay. Left out: " + "; ".join(f"`{name}` ({why})" for name, why in LEFT_OUT.items()) + ". Written by",
        "`python studies/output_convergence.py --foldwing COMMAND --table docs/tables/outputs.md` (`make validate`).",
        f"An output *falls* where its error at 1e-7 is at most a tenth of that at 1e-5, or that is below {SMALL:g};",
        f"*cured*: with `stiffness_damping_s = {DAMPING_S:g}` on every body that has none; "
        + "; ".join(f"`{name}` with {settings(cure)} instead" for name, cure in CURES.items()) + ".",
        "",
        *WHAT_DOES_NOT_FALL,
        "",
        f"| model | fall | fall, cured | median " + " | ".join(TOLERANCES) + " | largest " + " | ".join(TOLERANCES) + " |",
        "|---" * (3 + 2 * len(TOLERANCES)) + "|",
    ]
    lines += ["| " + " | ".join([str(cell) for cell in row[:3]] + [number(v) for v in row[3:]]) + " |" for row in summary]
    lines += ["", "## Outputs that do not fall", "", "| model | output | " + " | ".join(TOLERANCES) + " |", "|---" * (2 + len(TOLERANCES)) + "|"]
    lines += ["| " + " | ".join([row[0], f"`{row[1]}`"] + [number(v) for v in row[2:]]) + " |" for row in exceptions]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    main()
