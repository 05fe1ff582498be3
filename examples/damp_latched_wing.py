#!/usr/bin/env python3
"""Damping of the vibration of the latched wing: state feedback designed on `foldwing linearize`, tested on the FMU.

Usage: damp_latched_wing.py --foldwing target/release/foldwing --fmu target/fmu/FoldingWing.fmu --picture OUT.png

The actuator is a piezo patch bonded to the inner wing from the root to station 2 (56 mm): it exerts opposite moments at
its two ends; the one on the clamp does no work, the other is the input `load.inner[2].moment.y`. The hinge motor is
unsuitable: against the closed latch, a hundred times stiffer than the spar, its torque excites the first mode five
hundred times less. The only sensor is the strain gauge at the root. For other models and actuators change the names below.

The design is in discrete time, because the FMU holds its inputs during a communication step: the linear model is reduced
to its slow flapwise modes and discretized with zero-order hold, an LQR minimises tip deflection and moment, and a
stationary Kalman filter estimates the modes from the strain.
"""

import argparse
import subprocess
import tempfile
from pathlib import Path

import numpy as np
from fmpy import read_model_description, simulate_fmu

MODEL = Path(__file__).parent / "models/folding_wing.toml"
ACTUATOR, GUST = "load.inner[2].moment.y", "load.outer[4].force.z"
GAUGE, TIP = "gauge.root.strain", "tip.position.z"

PERIOD_S = 1e-3  # sampling period and communication step
MODES_BELOW_HZ = 200.0  # well below half the sampling frequency
LARGEST_MOMENT_N_M = 0.1  # limit of the patch
TIP_WEIGHT_M, MOMENT_WEIGHT_N_M = 0.05, 0.1  # 50 mm at the tip have the same cost as 0.1 N·m
GUST_NOISE_N, STRAIN_NOISE = 0.05, 1e-4  # less strain noise, 1e-5, gives a filter that excites the truncated modes


def linear_model(foldwing, model=MODEL):
    """A, B, C of the latched wing in equilibrium, B for moment and gust, C for gauge and tip, and the equilibrium strain."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "latched.npz"
        subprocess.run([str(foldwing), "linearize", str(model), "--state", "equilibrium", "--inputs", f"{ACTUATOR},{GUST}",
                        "--outputs", f"{GAUGE},{TIP}", "--output", str(path)], check=True, stdout=subprocess.DEVNULL)
        with np.load(path) as file:
            return file["A"], file["B"], file["C"], float(file["y0"][0])


def flap_modes(a, b, c):
    """Model in real modal coordinates of the controllable and observable modes below the frequency limit."""
    values, right = np.linalg.eig(a)
    left = np.linalg.inv(right)
    effect = np.abs(c[0] @ right) * np.abs(left @ b[:, 0])
    band = (values.imag > 0) & (values.imag < 2 * np.pi * MODES_BELOW_HZ)
    kept = band & (effect > 1e-6 * effect[band].max())
    out = 2 * np.hstack([right[:, kept].real, -right[:, kept].imag])
    into = np.vstack([left[kept].real, left[kept].imag])
    return into @ a @ out, into @ b, c @ out


def sampled(a, b, period_s=PERIOD_S):
    """Discretized system with zero-order hold."""
    values, vectors = np.linalg.eig(a)
    growth = np.exp(values * period_s)
    inputs = np.linalg.solve(vectors, b.astype(complex))
    return (
        (vectors @ np.diag(growth) @ np.linalg.inv(vectors)).real,
        (vectors @ (((growth - 1) / values)[:, None] * inputs)).real,
    )


def riccati(a, b, q, r):
    """X = AᵀXA − AᵀXB (R + BᵀXB)⁻¹ BᵀXA + Q by doubling: each iteration doubles the horizon."""
    g, x = b @ np.linalg.solve(r, b.T), q
    for _ in range(60):
        w = np.linalg.inv(np.eye(len(a)) + g @ x)
        step = a.T @ x @ w @ a
        g, x, a = g + a @ w @ g @ a.T, x + step, a @ w @ a
        if np.abs(step).max() <= 1e-14 * np.abs(x).max():
            return x
    raise ArithmeticError("the Riccati equation did not converge: is every mode moved and seen?")


class Damper:
    """State feedback with a Kalman filter: strain in, moment out, at every sample."""

    def __init__(self, a, b, c, rest_strain):
        self.a, inputs = sampled(a, b)
        self.b, gust, self.c = inputs[:, :1], inputs[:, 1:], c[:1]
        cost, price = c[1:].T @ c[1:] / TIP_WEIGHT_M**2, np.eye(1) / MOMENT_WEIGHT_N_M**2
        x = riccati(self.a, self.b, cost, price)
        self.feedback = np.linalg.solve(price + self.b.T @ x @ self.b, self.b.T @ x @ self.a)
        noise = np.eye(1) * STRAIN_NOISE**2
        x = riccati(self.a.T, self.c.T, gust @ gust.T * GUST_NOISE_N**2, noise)
        self.correction = x @ self.c.T @ np.linalg.inv(self.c @ x @ self.c.T + noise)
        self.rest_strain = rest_strain
        self.prediction = np.zeros((len(a), 1))

    def moment(self, strain):
        """Moment in N·m to hold until the next sample."""
        surprise = strain - self.rest_strain - self.c @ self.prediction
        state = self.prediction + self.correction @ surprise
        moment = np.clip(-self.feedback @ state, -LARGEST_MOMENT_N_M, LARGEST_MOMENT_N_M)
        self.prediction = self.a @ state + self.b @ moment
        return moment.item()

    def designed_poles(self):
        """Closed-loop eigenvalues in 1/s of the design model (unchanged by the filter)."""
        return np.log(np.linalg.eigvals(self.a - self.b @ self.feedback).astype(complex)) / PERIOD_S

    def poles(self, a, b, c):
        """Closed-loop eigenvalues in 1/s with a full linear model, not only the modes of the design."""
        a, b = sampled(a, b[:, :1])
        c, keep = c[:1], np.eye(len(self.a)) - self.correction @ self.c
        of_wing, of_filter = -self.feedback @ self.correction @ c, -self.feedback @ keep
        inner = self.a - self.b @ self.feedback
        loop = np.block([[a + b @ of_wing, b @ of_filter], [inner @ self.correction @ c, inner @ keep]])
        return np.log(np.linalg.eigvals(loop).astype(complex)) / PERIOD_S


def ring(fmu, damper=None, push=None, stop_s=4.0, **start):
    """Simulate unfolding, latching and vibration; the damper, if any, is active after latching.

    `push`: force in N on the outer end, in z, as a function of time in s; `start`: start values of the FMU.
    """
    reference = {v.name: [v.valueReference] for v in read_model_description(str(fmu)).modelVariables}

    def control(time, recorder):
        if push:
            recorder.fmu.setReal(reference[GUST], [push(time)])
        if damper and recorder.fmu.getBoolean(reference["fold.latched"])[0]:
            strain = recorder.fmu.getReal(reference[GAUGE])[0]
            recorder.fmu.setReal(reference[ACTUATOR], [damper.moment(strain)])
        return True

    outputs = [GAUGE, "fold.latched", "fold.latch_time", TIP, "energy.kinetic", "energy.total",
               "energy.work", "energy.dissipated", ACTUATOR]
    return simulate_fmu(str(fmu), stop_time=stop_s, output_interval=PERIOD_S, output=outputs, step_finished=control,
                        start_values=start)


def settling(result, rest_strain, share=0.05):
    """Settling time in s after latching: the strain stays within a fraction of its largest value."""
    after = result[result["time"] >= result["fold.latch_time"][-1]]
    swing = np.abs(after[GAUGE] - rest_strain)
    last = np.flatnonzero(swing > share * swing.max())[-1]
    return after["time"][last] - result["fold.latch_time"][-1]


def draw(free, damped, path):
    """Plot root strain with and without feedback, and the moment."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    from house_style import BLUE, FAINT, VERMILION, mark, save, use

    use()
    figure, (upper, lower) = plt.subplots(2, 1, figsize=(7.6, 5.2), sharex=True, height_ratios=(2, 1), layout="constrained")
    upper.plot(free["time"], 1e3 * free[GAUGE], color=FAINT, linewidth=1.0, label="uncontrolled")
    upper.plot(damped["time"], 1e3 * damped[GAUGE], color=BLUE, linewidth=1.4, label="state feedback")
    upper.set(ylabel="strain at the root gauge (10⁻³)", title="Unfolding, latching and vibration of the wing\n")
    upper.legend(loc="lower right")
    lower.plot(damped["time"], 1e3 * damped[ACTUATOR], color=BLUE, linewidth=1.0, drawstyle="steps-post")
    lower.set(xlabel="time (s)", ylabel="moment (mN·m)", xlim=(0, 2))
    latch_s = free["fold.latch_time"][-1]
    mark(upper, latch_s, f"latch closes, {latch_s:.4f} s", VERMILION)
    mark(lower, latch_s, "", VERMILION)
    path.parent.mkdir(parents=True, exist_ok=True)
    save(figure, path)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--foldwing", required=True, help="the command `foldwing`")
    parser.add_argument("--fmu", required=True, help="FMU of examples/models/folding_wing.toml")
    parser.add_argument("--picture", type=Path, help="output file of the plot")
    arguments = parser.parse_args()

    a, b, c, rest_strain = linear_model(arguments.foldwing)
    modes = flap_modes(a, b, c)
    damper = Damper(*modes, rest_strain)
    for name, poles in (("left alone", np.linalg.eigvals(modes[0])), ("state feedback", damper.designed_poles())):
        pairs = sorted(poles[poles.imag > 0], key=abs)
        listed = ", ".join(f"{abs(p) / 2 / np.pi:.1f} Hz {-p.real / abs(p):.3f}" for p in pairs)
        print(f"{name + ', modes and damping ratios':52}{listed}")
    print(f"{'state feedback, slowest decay of all states':52}{-damper.poles(a, b, c).real.max():.2f} 1/s")
    free, damped = ring(arguments.fmu), ring(arguments.fmu, damper)
    for name, result in (("left alone", free), ("state feedback", damped)):
        print(f"{name + ', strain below 5 % of its peak after':52}{settling(result, rest_strain):.3f} s")
    print(f"{'largest moment':52}{np.abs(damped[ACTUATOR]).max():.3f} N.m")
    if arguments.picture:
        draw(free, damped, arguments.picture)


if __name__ == "__main__":
    main()
