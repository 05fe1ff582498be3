#!/usr/bin/env python3
"""Identification of two damping coefficients from a strain record: least squares with simulations of the FMU.

Usage: identify_damping.py --fmu FoldingWing.fmu [--record RECORD.csv] [--picture OUT.png]

Otsuka et al. fitted `α`, the mass-proportional damping of the wing, and `c`, the damping of the fold joint, to the largest
strain that they measured. A single value does not determine two coefficients; the time history does: `c` slows the
unfolding, `α` damps the latched wing. A record is a CSV file with the columns `time` (s, equally spaced from 0) and
`strain`. Without a record the script generates one from the FMU, with other coefficients and noise, and recovers them.

Levenberg-Marquardt on the logarithms of both coefficients; derivatives by finite differences of simulations. The
confidence bounds are those of the linearised problem for white noise: they do not include model errors.
"""

import argparse
import atexit
import shutil
from pathlib import Path
from typing import NamedTuple

import numpy as np
from fmpy import extract, instantiate_fmu, read_model_description, simulate_fmu

GAUGE = "gauge.root.strain"
NAMES = "alpha", "c"
UNITS = "1/s", "N.m.s/rad"
GUESS = 2.5, 0.0008  # the model file's values
TRUTH = 4.0, 0.0015  # coefficients of the generated record
NOISE = 0.02  # as a fraction of the peak of the record
STOP_S, STEP_S = 1.0, 1e-3
TOLERANCE = 1e-5  # solver tolerance of the FMU: a tenth of its default, so that finite differences are not dominated by errors
DIFFERENCE = 0.02  # relative, central
BOUND = 1.96  # standard deviations: 95 %


class Wing:
    """FMU as a function from the coefficients to the strain."""

    def __init__(self, fmu, stop_s=STOP_S, step_s=STEP_S, tolerance=TOLERANCE):
        self.description = read_model_description(str(fmu))
        self.folder = extract(str(fmu))
        atexit.register(shutil.rmtree, self.folder, ignore_errors=True)
        self.instance = instantiate_fmu(self.folder, self.description, "CoSimulation")
        self.experiment = {"stop_time": stop_s, "output_interval": step_s, "relative_tolerance": tolerance}

    def strain(self, coefficients):
        """Strain at the root from the start, one value per step."""
        alpha, c = map(float, coefficients)
        start = {"body.inner.mass_damping": alpha, "body.outer.mass_damping": alpha, "fold.motor_damping": c}
        self.instance.reset()
        result = simulate_fmu(self.folder, model_description=self.description, fmu_instance=self.instance,
                              start_values=start, output=[GAUGE], validate=False, **self.experiment)
        return np.array(result[GAUGE])


class Fit(NamedTuple):
    """Result of the identification."""

    coefficients: np.ndarray
    bounds: np.ndarray  # half widths of the 95 % intervals
    noise: float  # standard deviation of the residual
    strain: np.ndarray  # strain of the wing with these coefficients
    runs: int


def identify(wing, record, guess=GUESS, iterations=20):
    """Identify the coefficients by least squares of the strain."""
    logarithms, damping, runs = np.log(guess), 1e-3, 1
    strain = wing.strain(guess)
    for _ in range(iterations):
        slopes = [wing.strain(np.exp(logarithms + step)) - wing.strain(np.exp(logarithms - step))
                  for step in DIFFERENCE * np.eye(2)]
        jacobian = np.transpose(slopes) / (2 * DIFFERENCE)
        normal, gradient = jacobian.T @ jacobian, jacobian.T @ (record - strain)
        runs += 4
        while damping < 1e6:
            step = np.linalg.solve(normal + damping * np.diag(np.diag(normal)), gradient)
            trial = wing.strain(np.exp(logarithms + step.clip(-1, 1)))
            runs += 1
            if np.sum((record - trial) ** 2) < np.sum((record - strain) ** 2):
                logarithms, strain, damping = logarithms + step.clip(-1, 1), trial, damping / 10
                break
            damping *= 10
        if np.abs(step).max() < 1e-3:
            noise = np.sqrt(np.sum((record - strain) ** 2) / (len(record) - 2))
            deviations = noise * np.sqrt(np.diag(np.linalg.inv(normal)))
            return Fit(np.exp(logarithms), BOUND * deviations * np.exp(logarithms), noise, strain, runs)
    raise ArithmeticError(f"no fit after {iterations} iterations: the last step was {np.abs(step).max():.1e}")


def noisy_record(wing, coefficients=TRUTH, noise=NOISE, seed=1):
    """Synthetic record of the wing, with white noise as a fraction of its peak."""
    strain = wing.strain(coefficients)
    return strain + np.random.default_rng(seed).normal(0.0, noise * np.abs(strain).max(), len(strain))


def read_record(path):
    """Strains of a record and the sampling period in s."""
    table = np.genfromtxt(path, delimiter=",", names=True)
    steps = np.diff(table["time"])
    if table["time"][0] != 0.0 or np.ptp(steps) > 1e-6 * steps.mean():
        raise SystemExit(f"{path}: `time` must start at 0 and go on in equal steps")
    return table["strain"], steps.mean()


def draw(record, fit, step_s, path):
    """Plot record, fitted strain and residual."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    from house_style import BLUE, FAINT, SKY, SMALL, VERMILION, save, use

    use()
    figure, (upper, lower) = plt.subplots(2, 1, figsize=(7.6, 5.2), sharex=True, height_ratios=(3, 1), layout="constrained")
    time_s = step_s * np.arange(len(record))
    found = "\n".join(f"{name} = {value:.4g} ± {bound:.1g} {unit}".replace("alpha", "α") for name, value, bound, unit
                      in zip(NAMES, fit.coefficients, fit.bounds, ("1/s", "N·m·s/rad")))
    upper.plot(time_s, 1e3 * record, ".", color=SKY, markersize=3, label="record")
    upper.plot(time_s, 1e3 * fit.strain, color=BLUE, linewidth=1.2, label="fitted model")
    upper.set(ylabel="strain at the root gauge (10⁻³)", title="Damping identification from a strain record")
    upper.annotate(found, (0.985, 0.3), xycoords="axes fraction", ha="right", va="top", fontsize=SMALL, color=BLUE)
    upper.legend(loc="lower right")
    lower.axhline(0.0, color=FAINT, linewidth=0.8)
    lower.plot(time_s, 1e3 * (record - fit.strain), ".", color=VERMILION, markersize=2)
    lower.set(xlabel="time (s)", ylabel="residual (10⁻³)", xlim=(0.0, time_s[-1]))
    path.parent.mkdir(parents=True, exist_ok=True)
    save(figure, path)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--fmu", required=True, help="FMU of examples/models/folding_wing.toml")
    parser.add_argument("--record", help="CSV file with the columns time and strain; default: generated from the FMU")
    parser.add_argument("--picture", type=Path, help="output file of the plot")
    arguments = parser.parse_args()

    if arguments.record:
        record, step_s = read_record(arguments.record)
        wing = Wing(arguments.fmu, stop_s=step_s * (len(record) - 1), step_s=step_s)
    else:
        wing, step_s = Wing(arguments.fmu), STEP_S
        record = noisy_record(wing)
        print(f"record   made with alpha = {TRUTH[0]} 1/s, c = {TRUTH[1]} N.m.s/rad, noise {NOISE:.0%} of the peak")
    fit = identify(wing, record)
    for name, value, bound, unit in zip(NAMES, fit.coefficients, fit.bounds, UNITS):
        print(f"{name:8} {value:.5g} ± {bound:.1g} {unit} (95 %, {bound / value:.2%})")
    print(f"left     {fit.noise:.2e}, {fit.noise / np.abs(record).max():.2%} of the record's peak, after {fit.runs} runs")
    if arguments.picture:
        draw(record, fit, step_s, arguments.picture)


if __name__ == "__main__":
    main()
