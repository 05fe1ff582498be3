#!/usr/bin/env python3
"""Identification of nine numbers of the folding wing from noisy gauges and a camera's track of the tip, for many seeds of the noise.

Usage: identify_wing.py [--seeds 100] [--model examples/models/folding_wing.toml]

For each seed the deployment of the true wing is measured with noise, and `Model.fit` identifies motor, damping, density and stiffness from starts
that are 10 % off. The actuator's mass is known, as by weighing: motion alone does not determine a factor of all masses, stiffnesses and torques. If the covariance is right, the true numbers are within its 95 % region in 95 of 100 seeds: in 89 to 99 by chance (two-sided
98 % of a binomial distribution).
"""

import argparse
import time

import numpy as np
from scipy.stats import chi2

import foldwing as fw

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
]
SIGMA = {"fold.angle": 2e-3, "gauge.root.strain": 2e-5, "tip.position.x": 2e-4, "tip.position.z": 2e-4, "fold.latch_time": 2e-5}
TIMES_S = np.round(np.arange(0.005, 0.2501, 0.005), 4)


def clean(model):
    """Measured values without noise, by name."""
    names = [name for name in SIGMA if name != "fold.latch_time"]
    found = model.gradient([f"{name}@{float(time_s)!r}" for name in names for time_s in TIMES_S] + ["fold.latch_time"], stop=0.4)
    columns = found.values[:-1].reshape(len(names), -1)
    return {**dict(zip(names, columns)), "fold.latch_time": found.values[-1]}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--model", default="examples/models/folding_wing.toml")
    parser.add_argument("--seeds", type=int, default=100)
    parser.add_argument("--first", type=int, default=0, help="first seed")
    arguments = parser.parse_args()

    model = fw.load(arguments.model)
    truth = model.gradient("fold.latch_time", FREE, stop=0.4).numbers
    measured = clean(model)
    inside, runs, seconds = 0, [], []
    limit = chi2.ppf(0.95, len(FREE))
    for seed in range(arguments.first, arguments.first + arguments.seeds):
        random = np.random.default_rng(seed)
        data = {name: value + SIGMA[name] * random.standard_normal(np.shape(value)) for name, value in measured.items()}
        start = dict(zip(FREE, truth * (1.0 + 0.1 * random.choice([-1.0, 1.0], len(FREE)))))
        begun = time.process_time()
        found = model.fit({"time": TIMES_S, **data}, FREE, start=start, sigma=SIGMA)
        seconds.append(time.process_time() - begun)
        off = found.values - truth
        distance = float(off @ np.linalg.solve(found.covariance, off))
        inside += distance < limit
        runs.append(found.runs)
        if seed == arguments.first:
            for name, value, error, own in zip(FREE, found.values, found.standard_errors, truth):
                print(f"{name:42} {value:12.6g} ± {error:8.2g}, true {own:.6g}")
        if not found.converged or distance > 3.0 * limit:
            print(f"seed {seed}: {found}, distance {distance:.1f}")
    print(f"{inside} of {arguments.seeds} seeds within the 95 % region; {np.median(runs):.0f} runs and {np.median(seconds):.2f} s of the processor per fit")


if __name__ == "__main__":
    main()
