#!/usr/bin/env python3
"""Damping of the latched wing in the wind tunnel: LQG controller from the linear model of wing and vortex lattice, tested on the FMU.

Usage: damp_wing_in_tunnel.py --foldwing target/release/foldwing --fmu target/fmu/folding_wing_in_tunnel.fmu --picture OUT.png

`foldwing linearize --lattice` writes an aeroelastic model in discrete time, with one aerodynamic step per sample and 1204 states. Balanced
truncation (`--reduce 20`) distributes 20 states over all frequencies up to half the sampling rate, 400 Hz. The controller only needs
frequencies up to 50 Hz, so the script balances the Gramians of that band (Gawronski and Juang, Int. J. Systems Science 21, 1990). The feedback
minimises the squares of tip deflection and moment. A stationary Kalman filter estimates the states from one strain gauge; vertical wind is the
disturbance. Actuator and sensor are those of damp_latched_wing.py.
"""

import argparse
import json
import subprocess
import tempfile
from pathlib import Path

import numpy as np
import scipy.linalg
from damp_latched_wing import ACTUATOR, GAUGE, LARGEST_MOMENT_N_M, TIP, riccati
from fmpy import read_model_description, simulate_fmu

MODEL = Path(__file__).parent / "models/folding_wing_in_tunnel.toml"
WIND = "wind.velocity.z"
ORDER, BAND_HZ = 20, 50.0
TIP_WEIGHT_M, MOMENT_WEIGHT_N_M = 0.02, 0.1  # 20 mm at the tip costs as much as 0.1 N·m; with 10 mm, motions above the band become unstable
WIND_NOISE_M_S, STRAIN_NOISE = 0.3, 1e-4
GUST_M_S, GUST_FROM_S, GUST_S = 1.0, 1.2, 0.1  # a bump of the vertical wind after the wing has latched


def linear_model(foldwing):
    """A, B, C, D, step in s and equilibrium strain."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "wing.npz"
        subprocess.run([str(foldwing), "linearize", str(MODEL), "--lattice", "--inputs", f"{ACTUATOR},{WIND}", "--outputs",
                        f"{GAUGE},{TIP}", "--output", str(path)], check=True, stdout=subprocess.DEVNULL)
        with np.load(path) as file:
            matrices = [file[name] for name in "ABCD"]
            return (*matrices, float(file["step_s"]), float(file["y0"][0]))


def answers(a, b, c, d, step_s, frequencies_Hz):
    """Frequency responses, shape (frequencies, outputs, inputs)."""
    eye = np.eye(len(a))
    return np.array([c @ np.linalg.solve(np.exp(2j * np.pi * f * step_s) * eye - a, b) + d for f in frequencies_Hz])


def reduced(a, b, c, d, step_s, order=ORDER):
    """The stable model with the maximum number of states up to `order`, balanced in the band: dynamics outside the band can make a
    model with more states unstable."""
    eye, reach, observe = np.eye(len(a)), [], []
    for f in np.linspace(0.0, 1.1 * BAND_HZ, 45):
        factors = scipy.linalg.lu_factor(np.exp(2j * np.pi * f * step_s) * eye - a)
        by_input = scipy.linalg.lu_solve(factors, b)
        by_output = scipy.linalg.lu_solve(factors, c.T, trans=2)
        reach += [by_input.real, by_input.imag]
        observe += [by_output.real, by_output.imag]
    gains = np.abs(answers(a, b, c, d, step_s, np.linspace(0.0, BAND_HZ, 11))).max(axis=(0, 2))
    reach, observe = np.hstack(reach), np.hstack([part / gains for part in observe])
    left, values, right = np.linalg.svd(observe.T @ reach, full_matrices=False)
    for fewer in range(order, 0, -1):
        root = np.sqrt(values[:fewer])
        out, into = reach @ right[:fewer].T / root, observe @ left[:, :fewer] / root
        small = into.T @ a @ out
        if np.abs(np.linalg.eigvals(small)).max() < 1.0:
            break
    return small, into.T @ b, c @ out, d


class Damper:
    """LQG controller: strain in, moment out, at every sample."""

    def __init__(self, a, b, c, d, rest_strain):
        self.a, self.b, self.c, self.d = a, b[:, :1], c[:1], d[:1, :1]
        cost, price = c[1:].T @ c[1:] / TIP_WEIGHT_M**2, np.eye(1) / MOMENT_WEIGHT_N_M**2
        x = riccati(a, self.b, cost, price)
        self.feedback = np.linalg.solve(price + self.b.T @ x @ self.b, self.b.T @ x @ a)
        noise = np.eye(1) * STRAIN_NOISE**2
        wind = b[:, 1:] * WIND_NOISE_M_S
        x = riccati(a.T, self.c.T, wind @ wind.T, noise)
        self.correction = x @ self.c.T @ np.linalg.inv(self.c @ x @ self.c.T + noise)
        self.rest_strain = rest_strain
        self.prediction, self.last = np.zeros((len(a), 1)), np.zeros((1, 1))

    def moment(self, strain):
        """Moment in N·m to hold until the next sample."""
        surprise = strain - self.rest_strain - self.c @ self.prediction - self.d @ self.last
        state = self.prediction + self.correction @ surprise
        self.last = np.clip(-self.feedback @ state, -LARGEST_MOMENT_N_M, LARGEST_MOMENT_N_M)
        self.prediction = self.a @ state + self.b @ self.last
        return self.last.item()

    def poles(self, a, b, c, step_s):
        """Eigenvalues in 1/s of the closed loop of this feedback and the full linear model."""
        b, c, keep = b[:, :1], c[:1], np.eye(len(self.a)) - self.correction @ self.c
        of_wing, of_filter = -self.feedback @ self.correction @ c, -self.feedback @ keep
        inner = self.a - self.b @ self.feedback
        loop = np.block([[a + b @ of_wing, b @ of_filter], [inner @ self.correction @ c, inner @ keep]])
        values = np.linalg.eigvals(loop).astype(complex)
        return np.log(values[np.abs(values) > 1e-6]) / step_s


def ring(fmu, step_s, damper=None, stop_s=2.2):
    """Simulate unfolding, latching, vibration and a gust; the damper, if any, is active after latching."""
    reference = {v.name: [v.valueReference] for v in read_model_description(str(fmu)).modelVariables}

    def control(time, recorder):
        inside = 0.0 <= time - GUST_FROM_S < GUST_S
        gust = 0.5 * GUST_M_S * (1 - np.cos(2 * np.pi * (time - GUST_FROM_S) / GUST_S)) if inside else 0.0
        recorder.fmu.setReal(reference[WIND], [gust])
        if damper and recorder.fmu.getBoolean(reference["fold.latched"])[0]:
            strain = recorder.fmu.getReal(reference[GAUGE])[0]
            recorder.fmu.setReal(reference[ACTUATOR], [damper.moment(strain)])
        return True

    outputs = [GAUGE, "fold.latched", "fold.latch_time", TIP, ACTUATOR, WIND]
    return simulate_fmu(str(fmu), stop_time=stop_s, output_interval=step_s, output=outputs, step_finished=control)


def swings(result, rest_strain):
    """Root mean squares of the strain about equilibrium: from 50 ms after latching to the gust, and during one second from the start of the
    gust."""
    time, off = result["time"], result[GAUGE] - rest_strain
    latch_s = result["fold.latch_time"][-1]
    parts = [(latch_s + 0.05, GUST_FROM_S), (GUST_FROM_S, GUST_FROM_S + 1.0)]
    return [float(np.sqrt(np.mean(off[(time >= begin) & (time < end)] ** 2))) for begin, end in parts]


def draw(free, damped, states, path):
    """Plot root strain with and without feedback, and the moment."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    from house_style import BLUE, FAINT, VERMILION, mark, save, use

    use()
    figure, (upper, lower) = plt.subplots(2, 1, figsize=(7.6, 5.2), sharex=True, height_ratios=(2, 1), layout="constrained")
    upper.plot(free["time"], 1e3 * free[GAUGE], color=FAINT, linewidth=1.0, label="uncontrolled")
    upper.plot(damped["time"], 1e3 * damped[GAUGE], color=BLUE, linewidth=1.4, label=f"LQG on {states} states")
    upper.set(ylabel="strain at the root gauge (10⁻³)", title="Unfolding in the wind tunnel, latching, gust\n")
    upper.legend(loc="lower right")
    lower.plot(damped["time"], 1e3 * damped[ACTUATOR], color=BLUE, linewidth=1.0, drawstyle="steps-post")
    lower.set(xlabel="time (s)", ylabel="moment (mN·m)", xlim=(0, 2.2))
    latch_s = free["fold.latch_time"][-1]
    for axes, latch, gust in ((upper, f"latch closes, {latch_s:.4f} s", f"gust of {GUST_M_S:g} m/s"), (lower, "", "")):
        mark(axes, latch_s, latch, VERMILION)
        mark(axes, GUST_FROM_S, gust, VERMILION)
    path.parent.mkdir(parents=True, exist_ok=True)
    save(figure, path)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--foldwing", required=True, help="the command `foldwing`")
    parser.add_argument("--fmu", required=True, help="FMU of examples/models/folding_wing_in_tunnel.toml")
    parser.add_argument("--picture", type=Path, help="output file of the plot")
    arguments = parser.parse_args()

    *whole, step_s, rest_strain = linear_model(arguments.foldwing)
    small = reduced(*whole, step_s)
    # frequencies between those of the design
    frequencies_Hz = np.linspace(0.0, BAND_HZ, 84)
    expected, found = (answers(*model, step_s, frequencies_Hz) for model in (whole, small))
    off = np.abs(found - expected)
    report = {
        "states": [len(whole[0]), len(small[0])],
        "slowest_decay_reduced_1_s": float(-np.log(np.abs(np.linalg.eigvals(small[0])).max()) / step_s),
        "largest_error_of_gain": (off.max(axis=0) / np.abs(expected).max(axis=0)).tolist(),
        "largest_error_at_a_frequency": (off / np.abs(expected)).max(axis=0).tolist(),
    }
    damper = Damper(*small, rest_strain)
    poles = damper.poles(*whole[:3], step_s)
    report["slowest_decay_1_s"] = -float(poles.real.max())
    free, damped = ring(arguments.fmu, step_s), ring(arguments.fmu, step_s, damper)
    report["swing_left_alone"], report["swing_damped"] = swings(free, rest_strain), swings(damped, rest_strain)
    report["largest_moment_N_m"] = float(np.abs(damped[ACTUATOR]).max())
    print(json.dumps(report, indent=2))
    if arguments.picture:
        draw(free, damped, len(small[0]), arguments.picture)


if __name__ == "__main__":
    main()
