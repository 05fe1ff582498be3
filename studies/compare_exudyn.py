#!/usr/bin/env python3
"""Compares cost and error of Foldwing and Exudyn on the two-body system and the deployment, alternately in one run.

  make bench-peers
  python studies/compare_exudyn.py --foldwing target/release/foldwing [--rounds 5] [--quick]

Both programs run with various meshes, steps and tolerances, one thread each, in the same process tree and alternately: each setting once
per round. Cost is processor time of the solution alone: Exudyn's `SolveDynamic`, Foldwing's initialisation, steps and rows (`foldwing
simulate --profile`). Errors are relative to the converged solution of each program with its physics; the table lists the difference
between these solutions. Needs the packages of `python/requirements-peers.txt`.
"""
import argparse
import csv
import itertools
import json
import math
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "benches" / "peers"))

import exudyn
import exudyn_folding_wing
import exudyn_two_body
from cost_report import Run, draw, machine_state, write_runs, write_table

METHODS = ("esdirk4", "esdirk3", "tr_bdf2", "generalized_alpha")
TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
NEWTON_TOLERANCES = (1e-4, 1e-6)
TWO_BODY_OUTPUTS_S = (0.01, 0.04)
DEPLOYMENT_OUTPUT_S = 8e-4
# Runs that take longer than this are repeated less often.
DEAR_S = 0.15


class GaveUp(Exception):
    """A run of Foldwing failed."""


class Foldwing:
    """The Foldwing command, with model files derived from the shipped ones."""

    def __init__(self, command, folder):
        self.command, self.folder = command, folder
        self.texts = {
            "two_body": (ROOT / "examples/two_body.toml").read_text(),
            "deployment": (ROOT / "examples/models/folding_wing.toml").read_text(),
        }

    def model(self, case, kind, elements, method, tolerance, max_step_s):
        """Path of the model file of a setting."""
        mesh = f'element = "{kind}"\nelements = {elements}\nload_stations = 0'
        text = self.texts[case]
        assert text.count("elements = 4") == 2, f"{case}: the mesh is not where it was"
        text = re.sub(r"#:schema .*", "", text.replace("elements = 4", mesh))
        text += f'\n[solver]\nmethod = "{method}"\ntolerance = {tolerance}\nmax_step_s = {max_step_s}\n'
        path = self.folder / "model.toml"
        path.write_text(text)
        return path

    def simulate(self, model, outputs, step_s=None):
        """Figures of `--profile` and columns of outputs at the communication points."""
        table, figures = self.folder / "run.csv", self.folder / "run.json"
        command = [self.command, "simulate", model, "--csv", table, "--profile", figures, "--force"]
        command += [argument for output in outputs for argument in ("--output", output)]
        command += ["--step", repr(step_s)] if step_s else []
        done = subprocess.run(list(map(str, command)), capture_output=True, text=True)
        if done.returncode != 0:
            raise GaveUp(done.stderr)
        with table.open() as file:
            rows = list(csv.DictReader(file))
        timing = json.loads(figures.read_text())
        if timing["processor_s"] is None:
            timing["processor_s"] = timing["initialization_s"] + timing["steps_s"] + timing["rows_s"]
        return timing, *([float(row[output]) for row in rows] for output in outputs)

    def two_body(self, output_s, **setting):
        """Timing and Z of the free end in m."""
        return self.simulate(self.model("two_body", **setting), ["tip.position.z"], output_s)

    def deployment(self, output_s, **setting):
        """Timing, latch time in s and peak strain."""
        return self.deploy(self.model("deployment", **setting), output_s)

    def deploy(self, model, output_s):
        """Timing, latch time in s and peak strain of a model file without changes."""
        timing, strain, latch_s = self.simulate(model, ["gauge.root.strain", "fold.latch_time"], output_s)
        return timing, latch_s[-1] if latch_s[-1] >= 0 else None, max(map(abs, strain))


class TwoBody:
    """Errors of the Z coordinate of the free end relative to converged paths, with samples every 10 ms from 0."""

    def __init__(self, foldwing):
        reference = {name: self.read(f"two_body_exudyn_{file}.csv") for name, file in
                     (("ge", "shear_rotary"), ("cable", "no_rotary"))}
        fine = dict(kind="linear", elements=16, method="esdirk4", tolerance=1e-9, max_step_s=0.005)
        reference["foldwing"] = foldwing.two_body(0.01, **fine)[1]
        self.reference = reference

    @staticmethod
    def read(name):
        with (ROOT / "tests/reference" / name).open() as file:
            return [float(row["tip_Z_m"]) for row in csv.DictReader(file)]

    def errors(self, physics, path, output_s):
        """Relative errors of the RMS (eqs. 23, 24 of the paper) and of the path, both divided by the RMS, over the samples after 0."""
        stride = round(output_s / 0.01)
        truth = self.reference[physics][::stride][1:]
        assert len(path) == len(truth) + 1, f"{len(path)} samples instead of {len(truth) + 1}"
        rms = math.sqrt(sum(z * z for z in truth) / len(truth))
        own = math.sqrt(sum(z * z for z in path[1:]) / len(truth))
        miss = math.sqrt(sum((z - true) ** 2 for z, true in zip(path[1:], truth)) / len(truth))
        return {"RMS": abs(own / rms - 1), "path": miss / rms}

    def apart(self):
        """Difference between Foldwing's converged path and that of Exudyn's geometrically exact elements."""
        return self.errors("ge", self.reference["foldwing"], 0.01)


class Deployment:
    """Errors of latch time and peak strain."""

    def __init__(self, foldwing):
        fine = dict(kind="linear", elements=16, method="esdirk4", tolerance=1e-7, max_step_s=0.005)
        _, latch_s, peak = foldwing.deployment(5e-5, **fine)
        theirs = exudyn_folding_wing.solve(8, output_s=5e-5, step_s=1.25e-5, tolerance=1e-8)
        self.reference = {"foldwing": (latch_s, peak), "exudyn": (theirs["latch_s"], theirs["peak_strain"])}

    def errors(self, program, latch_s, peak):
        true_latch_s, true_peak = self.reference[program]
        latch = math.inf if latch_s is None else abs(latch_s / true_latch_s - 1)
        return {"latch": latch, "peak": abs(peak / true_peak - 1)}


def foldwing_runs(foldwing, two_body, deployment, quick):
    """Foldwing's settings of both cases."""
    pairs, constant = ((1, 2, 4), (4, 8)) if quick else ((1, 2, 4, 8), (2, 4, 8, 16, 32))
    tolerances = TOLERANCES[:3] if quick else TOLERANCES
    meshes = [("linear", n) for n in pairs] + [("constant", n) for n in constant]
    for output_s, (kind, n), method, tolerance in itertools.product(TWO_BODY_OUTPUTS_S, meshes, METHODS, tolerances):
        setting = dict(kind=kind, elements=n, method=method, tolerance=tolerance, max_step_s=0.1)

        def measure(setting=setting, output_s=output_s):
            timing, path = foldwing.two_body(output_s, **setting)
            return timing["processor_s"], timing["steps"], two_body.errors("foldwing", path, output_s)

        yield Run("two_body", "Foldwing", kind, method, n, 0.1, tolerance, output_s, measure)

    pairs, constant = ((1, 2, 4), (4, 15)) if quick else ((1, 2, 3, 4, 8), (4, 8, 15, 30))
    meshes = [("linear", n) for n in pairs] + [("constant", n) for n in constant]
    for (kind, n), method, tolerance in itertools.product(meshes, METHODS, tolerances):
        # a longer step than in the shipped models is tried if the tolerance permits it
        for max_step_s in (0.01, 0.005) if tolerance >= 1e-3 else (0.005,):
            setting = dict(kind=kind, elements=n, method=method, tolerance=tolerance, max_step_s=max_step_s)

            def measure(setting=setting):
                timing, latch_s, peak = foldwing.deployment(DEPLOYMENT_OUTPUT_S, **setting)
                return timing["processor_s"], timing["steps"], deployment.errors("foldwing", latch_s, peak)

            yield Run("deployment", "Foldwing", kind, method, n, max_step_s, tolerance, DEPLOYMENT_OUTPUT_S, measure)

    shipped = (("folding_wing", "linear", 4), ("folding_wing_constant", "constant", 15))
    # at Exudyn's output times, and at those of the models
    for (name, kind, n), output_s in itertools.product(shipped, (DEPLOYMENT_OUTPUT_S, 5e-4)):

        def measure(path=ROOT / f"examples/models/{name}.toml", output_s=output_s):
            timing, latch_s, peak = foldwing.deploy(path, output_s)
            return timing["processor_s"], timing["steps"], deployment.errors("foldwing", latch_s, peak)

        yield Run("shipped", "Foldwing", kind, "esdirk4", n, 0.005, 1e-4, output_s, measure, name)


def exudyn_runs(two_body, deployment, quick):
    """Exudyn's settings of both cases; dense algebra where it may be faster."""
    elements = (1, 2, 4) if quick else (1, 2, 4, 8, 16, 32)
    steps_s = (0.04, 0.01) if quick else (0.04, 0.02, 0.01, 0.005)
    for beam, n, step_s, tolerance in itertools.product(("ge", "cable"), elements, steps_s, NEWTON_TOLERANCES):
        for solver in solvers(n):
            output_s = 0.01 if step_s <= 0.01 else 0.04
            setting = dict(beam=beam, step_s=step_s, tolerance=tolerance, solver=solver, output_s=output_s)

            def measure(n=n, setting=setting):
                result = exudyn_two_body.solve(n, **setting)
                path = list(result["tip_z_m"])
                errors = two_body.errors(setting["beam"], path, setting["output_s"])
                return result["processor_s"], result["steps"], errors

            yield Run("two_body", "Exudyn", beam, solver, n, step_s, tolerance, output_s, measure)

    elements = (2, 4) if quick else (1, 2, 4, 8, 15)
    steps_s = (8e-4, 2e-4, 1e-4, 5e-5) if quick else (8e-4, 4e-4, 2e-4, 1e-4, 5e-5, 2.5e-5)
    for n, step_s, tolerance in itertools.product(elements, steps_s, (1e-3, 1e-6)):
        for solver in solvers(n):
            setting = dict(step_s=step_s, tolerance=tolerance, solver=solver, output_s=DEPLOYMENT_OUTPUT_S)

            def measure(n=n, setting=setting):
                result = exudyn_folding_wing.solve(n, **setting)
                errors = deployment.errors("exudyn", result["latch_s"], result["peak_strain"])
                return result["processor_s"], result["steps"], errors

            yield Run("deployment", "Exudyn", "ge", solver, n, step_s, tolerance, DEPLOYMENT_OUTPUT_S, measure)


def solvers(elements):
    """Linear algebra to try: dense is faster up to two elements per body, sparse from eight on; in between both are tried."""
    return ("dense",) if elements <= 2 else ("dense", "sparse") if elements <= 4 else ("sparse",)


def in_turn(ours, theirs):
    """Both lists interleaved evenly, so that a change of the computer's load affects both."""
    keyed = [(i / len(runs), run) for runs in (ours, theirs) for i, run in enumerate(runs)]
    return [run for _, run in sorted(keyed, key=lambda pair: pair[0])]


def measure_all(runs, rounds):
    """Each run once per round; expensive ones in two rounds at most. A failed run is not repeated."""
    for number in range(rounds):
        for run in runs:
            if run.gave_up or (number >= 2 and min(run.times_s) > DEAR_S):
                continue
            try:
                processor_s, run.steps, run.errors = run.measure()
                run.times_s.append(processor_s)
            except (exudyn.SolverError, GaveUp):
                run.gave_up = True
        print(f"round {number + 1} of {rounds}", flush=True)


def main():
    """Runs the measurements, prints the table, and writes it with the picture and all runs."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--foldwing", type=pathlib.Path, default=ROOT / "target/release/foldwing", help="the command")
    parser.add_argument("--rounds", type=int, default=5, help="times that each setting is measured")
    parser.add_argument("--quick", action="store_true", help="few settings, to try the tool")
    parser.add_argument("--table", type=pathlib.Path, default=ROOT / "docs/tables/exudyn.md")
    parser.add_argument("--picture", type=pathlib.Path, default=ROOT / "docs/pictures/cost_against_error.png")
    parser.add_argument("--runs", type=pathlib.Path, default=ROOT / "target/compare_exudyn.csv", help="CSV of all runs")
    given = parser.parse_args()
    exudyn.config.suppressWarnings = True
    exudyn.SetWriteToConsole(False)
    begin = machine_state()
    with tempfile.TemporaryDirectory() as name:
        foldwing = Foldwing(given.foldwing.resolve(), pathlib.Path(name))
        two_body, deployment = TwoBody(foldwing), Deployment(foldwing)
        ours = list(foldwing_runs(foldwing, two_body, deployment, given.quick))
        theirs = list(exudyn_runs(two_body, deployment, given.quick))
        runs = in_turn(ours, theirs)
        print(f"{len(ours)} settings of Foldwing, {len(theirs)} of Exudyn", flush=True)
        measure_all(runs, given.rounds)
    write_runs(runs, given.runs)
    states = (begin, machine_state())
    print(write_table(runs, given.table, states, given.rounds, two_body.apart(), deployment.reference))
    draw(runs, given.picture)


if __name__ == "__main__":
    main()
