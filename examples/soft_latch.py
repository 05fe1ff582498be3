"""Optimal control through a latch event: a torque over time that closes the latch at a given time with minimum peak strain at the root.

The torque has 40 values with linear interpolation between them. The adjoint of the run gives the exact derivatives of peak strain and
latch time with respect to all of them for SciPy's SLSQP. Without the torque the motor drives the wing into its latch at full speed.

    python examples/soft_latch.py [--knots 40] [--plot soft_latch.png]
"""

from __future__ import annotations

import argparse
import time
from typing import NamedTuple

import numpy as np

import foldwing as fw

MODEL = "examples/models/folding_wing.toml"
TORQUE, GAUGE, LATCH, ANGLE = "fold.external_torque", "gauge.root.strain", "fold.latch_time", "fold.angle"
LATCH_S, STOP_S = 0.18, 0.3
LIMIT_N_M = 0.06
# the torque ends shortly after the latch has closed
PUSH_S = 0.2


class Landing(NamedTuple):
    """The optimum, latch time and peak strain without the torque, and processor time."""

    found: fw.Optimum
    own_latch_s: float
    own_peak: float
    processor_s: float


def land(knots: int = 40, latch_s: float = LATCH_S, max_runs: int = 400) -> Landing:
    """Finds the optimal torque."""
    wing = fw.load(MODEL)
    times_s = np.linspace(0.0, PUSH_S, knots)
    peak = f"peak({GAUGE})"
    own = wing.gradient([LATCH, peak], stop=STOP_S)
    begin_s = time.process_time()
    found = wing.optimize(
        peak,
        {f"{TORQUE}@*": (-LIMIT_N_M, LIMIT_N_M)},
        constraints={LATCH: latch_s},
        inputs={"time": times_s, TORQUE: np.zeros(knots)},
        stop=STOP_S,
        tolerance=1e-4,
        max_runs=max_runs,
    )
    return Landing(found, own.value(LATCH), own.value(peak), time.process_time() - begin_s)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--knots", type=int, default=40, help="values of the torque [default: 40]")
    parser.add_argument("--plot", help="picture of torque, angle and strain")
    arguments = parser.parse_args()
    landing = land(arguments.knots)
    found = landing.found
    print(f"{arguments.knots} values: latch at {found.results[LATCH]:.4f} s ({landing.own_latch_s:.4f} s without the torque)")
    ratio = abs(found.objective / landing.own_peak)
    print(f"peak strain {found.objective:.3e} ({landing.own_peak:.3e} without the torque, {100.0 * ratio:.0f} % left)")
    print(f"{found.runs} runs, {found.gradients} of them differentiated, {landing.processor_s:.1f} s of the processor; converged: {found.converged}")
    if arguments.plot:
        draw(landing, arguments.plot)


def draw(landing: Landing, path: str) -> None:
    """Draws torque, fold angle and strain over time, without and with the torque."""
    import matplotlib.pyplot as plt

    wing, inputs = fw.load(MODEL), landing.found.inputs
    assert inputs is not None
    runs = [wing.simulate(stop=STOP_S, step=5e-4, inputs=given, outputs=[ANGLE, GAUGE]) for given in (None, inputs)]
    figure, axes = plt.subplots(3, 1, sharex=True, figsize=(6.4, 6.4))
    axes[0].plot(inputs["time"], inputs[TORQUE], color="#d55e00")
    axes[0].set_ylabel("torque [N·m]")
    for run, color, label in zip(runs, ("#6e7a86", "#d55e00"), ("without", "with the torque")):
        axes[1].plot(run.time, np.degrees(run[ANGLE]), color=color)
        axes[2].plot(run.time, 1e3 * run[GAUGE], color=color, label=label)
    axes[1].set_ylabel("fold angle [°]")
    axes[2].set_ylabel("root strain [10⁻³]")
    axes[2].set_xlabel("time [s]")
    axes[2].legend(frameon=False)
    figure.tight_layout()
    figure.savefig(path, dpi=130)


if __name__ == "__main__":
    main()
