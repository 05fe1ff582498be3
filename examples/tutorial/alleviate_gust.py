"""Gust alleviation: the aileron follows the root strain with a gain designed on a linear model, in a simulation with large deflections."""

import sys

import numpy as np

import foldwing as fw

AILERON, GAUGE = "aero.control_surface.aileron.angle_command", "gauge.root.strain"
FLIGHT = {"fold1.start_angle": 0.0, "fold2.start_angle": 0.0, "wind.velocity.y": -17.4}  # deployed, at the speed of level flight
LAG_S, STEP_S, ON_S = 0.01, 0.01, 2.0  # lag of filter and servo; controller period; switch-on time

wing = fw.load(sys.argv[1] if len(sys.argv) > 1 else "sketch.toml")
linear = wing.linearize(inputs=AILERON, outputs=GAUGE, settings=FLIGHT)


def growth(gain):
    """Largest real part of the eigenvalues, in 1/s, of the wing with `angle = gain · strain` and the lag."""
    loop = np.block([[linear.A, gain * linear.B], [linear.C / LAG_S, (gain * linear.D - 1.0) / LAG_S]])
    return np.linalg.eigvals(loop).real.max()


limit = next(gain for gain in range(50, 5000, 50) if growth(gain) > 0.0)
gain = limit / 2  # a gain margin of 6 dB


def fly(gain):
    filtered = reference = 0.0

    def controller(time, sim):
        nonlocal filtered, reference
        filtered += (sim[GAUGE] - filtered) * (1.0 - np.exp(-STEP_S / LAG_S))
        if time < ON_S:
            reference = filtered
        return {AILERON: float(np.clip(gain * (filtered - reference), -0.4, 0.4))}

    return wing.simulate(stop=4.0, step=STEP_S, inputs=controller, settings=FLIGHT, outputs=[GAUGE, AILERON])


if __name__ == "__main__":
    free, damped = fly(0.0), fly(gain)
    rise = [np.abs(run[GAUGE] - run[GAUGE][run.time < ON_S][-1])[run.time >= ON_S].max() for run in (free, damped)]
    print(f"unstable from a gain of {limit}; with {gain:.0f} the strain rises by {1e6 * rise[1]:.0f} instead of {1e6 * rise[0]:.0f} µm/m")
