#!/usr/bin/env python3
"""Identification of twelve numbers of the folding wing from noisy strain gauges and a camera track of the tip, for many seeds of the noise.

Usage: identify_wing.py [--seeds 100] [--differences 3] [--model examples/models/folding_wing.toml] [--table FILE.md]

For each seed the deployment of the true wing is measured with noise, and `Model.fit` identifies motor, damping, plate, length and gauge
from start values with errors of 5 %. The actuator's mass is known from weighing: motion alone does not determine a common factor of all
masses, stiffnesses and torques. If the covariance is correct, the true numbers are expected within its 95 % region for 95 of 100 seeds,
with scatter from 89 to 99 (two-sided 98 % interval of a binomial distribution). The first seeds are identified again by the same search
with central differences of runs, with steps of 1e-3 of each number, and the processor times are compared.
"""

import argparse
import time

import numpy as np
from scipy.stats import chi2

import foldwing as fw
from foldwing import _native
from foldwing.fit import Measured
from foldwing.trials import Trials

FREE = [
    "fold.motor_stiffness",
    "fold.motor_damping",
    "fold.motor_constant_torque",
    "fold.start_angle",
    "file:body.inner.mass_damping_1_s",
    "file:body.outer.mass_damping_1_s",
    "file:section.plate.youngs_modulus_Pa",
    "file:section.plate.density_kg_m3",
    "file:joint.fold.latch.stiffness_ratio",
    "file:section.plate.height_m",
    "file:body.outer.length_m",
    "file:gauge.root.position_m",
]
SIGMA = {"fold.angle": 2e-3, "gauge.root.strain": 2e-5, "tip.position.x": 2e-4, "tip.position.z": 2e-4, "fold.latch_time": 2e-5}
TIMES_S = np.round(np.arange(0.005, 0.2501, 0.005), 4)


def clean(model):
    """Measured values without noise, by name."""
    names = [name for name in SIGMA if name != "fold.latch_time"]
    found = model.gradient([f"{name}@{float(time_s)!r}" for name in names for time_s in TIMES_S] + ["fold.latch_time"], stop=0.4)
    columns = found.values[:-1].reshape(len(names), -1)
    return {**dict(zip(names, columns)), "fold.latch_time": found.values[-1]}


def by_differences(model, data, start):
    """The numbers found by the same search with central differences of runs, and its number of runs."""
    measured = Measured(data, SIGMA)
    trials = Trials(model, FREE, option="free", results=measured.names, stop=None, settings=None, inputs=None)
    first = trials.first(start)
    runs = 0

    def residuals(x):
        nonlocal runs
        runs += 1
        try:
            return (trials.gradient(x, measured.names).values - measured.values) / measured.scales
        except fw.FoldwingError:
            return None

    def jacobian(x):
        columns = []
        for place in range(len(x)):
            shift = np.zeros(len(x))
            shift[place] = 1e-3 * abs(x[place])
            columns.append((residuals(x + shift) - residuals(x - shift)) / (2.0 * shift[place]))
        return np.ascontiguousarray(np.array(columns).T)

    bounds = [(float(low), float(high)) for low, high in trials.allowed]
    found = _native.least_squares(residuals, jacobian, first.tolist(), bounds, "linear", 50, True)
    return np.array(found["x"]), np.array(found["covariance"]), runs, found["converged"]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--model", default="examples/models/folding_wing.toml")
    parser.add_argument("--seeds", type=int, default=100)
    parser.add_argument("--first", type=int, default=0, help="first seed")
    parser.add_argument("--differences", type=int, default=3, help="seeds that are identified by differences too")
    parser.add_argument("--table", help="table to write, Markdown")
    arguments = parser.parse_args()

    model = fw.load(arguments.model)
    truth = model.gradient("fold.latch_time", FREE, stop=0.4).numbers
    measured = clean(model)
    inside, converged, runs, seconds, times, lines = 0, 0, [], [], [], []
    limit = chi2.ppf(0.95, len(FREE))
    for seed in range(arguments.first, arguments.first + arguments.seeds):
        random = np.random.default_rng(seed)
        data = {name: value + SIGMA[name] * random.standard_normal(np.shape(value)) for name, value in measured.items()}
        data = {"time": TIMES_S, **data}
        start = dict(zip(FREE, truth * (1.0 + 0.05 * random.choice([-1.0, 1.0], len(FREE)))))
        begun = time.process_time()
        found = model.fit(data, FREE, start=start, sigma=SIGMA)
        seconds.append(time.process_time() - begun)
        off = found.values - truth
        distance = float(off @ np.linalg.solve(found.covariance, off))
        inside += distance < limit
        converged += found.converged
        runs.append(found.runs)
        if seed == arguments.first:
            for name, value, error, own in zip(FREE, found.values, found.standard_errors, truth):
                lines.append(f"| `{name}` | {own:.6g} | {value:.6g} | {error:.2g} |")
                print(f"{name:42} {value:12.6g} ± {error:8.2g}, true {own:.6g}")
        if not found.converged or distance > 3.0 * limit:
            print(f"seed {seed}: {found}, distance {distance:.1f}")
        if seed < arguments.first + arguments.differences:
            begun = time.process_time()
            values, _, count, ended = by_differences(model, data, start)
            times.append(time.process_time() - begun)
            apart = np.abs((values - found.values) / found.standard_errors).max()
            print(f"seed {seed}: {seconds[-1]:.1f} s; by differences {times[-1]:.1f} s, {count} runs, converged: {ended}, {apart:.2g} standard errors apart", flush=True)
    median = np.median(seconds)
    share = f"{median / np.median(times):.2f} of the time of differences" if times else "not compared with differences"
    outcome = f"{inside} of {arguments.seeds} seeds within the 95 % region, {converged} converged; {np.median(runs):.0f} runs and {median:.2f} s of the processor per fit, {share}"
    print(outcome)
    if arguments.table:
        head = "| number | true | found, first seed | standard error |\n|---|---|---|---|\n"
        with open(arguments.table, "w", encoding="utf-8") as file:
            file.write(f"# Identification of twelve numbers\n\n`studies/identify_wing.py`: {outcome}.\n\n{head}" + "\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
