"""Ensemble Kalman filter on the nonlinear model: an unknown load on the wing tip, and the deflection, from one noisy strain gauge.

The load changes slowly and is not known to the model; it is estimated as a random walk. Each member of the ensemble is a saved state of
the simulation with its load. In each window of 50 ms all members run, the samples of the gauge correct their loads (Kalman gain from the
covariances of the ensemble, with perturbed measurements), and the window is repeated from the saved states with the corrected loads: the
states follow from the simulation and are not corrected directly, so that every member is a motion of the model. The filter only needs
`Simulation.save` and `restore`, and the number of states does not matter.

    python examples/kalman_wing.py [--members 24] [--plot kalman.png]
"""

from __future__ import annotations

import argparse
from typing import Callable, List, NamedTuple, Tuple

import numpy as np
from numpy.typing import NDArray

import foldwing as fw

MODEL = "examples/models/folding_wing.toml"
LOAD, GAUGE, TIP = "load.outer[4].force.z", "gauge.root.strain", "tip.position.z"
SAMPLE_S = 5e-3
SAMPLES = 10
WINDOWS = 40
NOISE = 5e-5
WALK_N = 0.06
START_N = 0.2


class Estimate(NamedTuple):
    """History over the samples: true values, estimates of the filter, and values of the model without measurements."""

    time_s: NDArray[np.float64]
    load_N: NDArray[np.float64]
    load_estimate_N: NDArray[np.float64]
    load_deviation_N: NDArray[np.float64]
    tip_m: NDArray[np.float64]
    tip_estimate_m: NDArray[np.float64]
    tip_deviation_m: NDArray[np.float64]

    def tip_error(self) -> float:
        """Root mean square error of the estimated deflection, relative to that of a model without load."""
        return float(np.sqrt(np.mean((self.tip_estimate_m - self.tip_m) ** 2) / np.mean(self.tip_m**2)))

    def load_error_N(self) -> float:
        """Root mean square error of the load in N."""
        return float(np.sqrt(np.mean((self.load_estimate_N - self.load_N) ** 2)))

    def covered(self) -> float:
        """Fraction of the samples whose deflection lies within two standard deviations of the ensemble."""
        return float(np.mean(np.abs(self.tip_estimate_m - self.tip_m) <= 2.0 * self.tip_deviation_m))


def gust_N(time_s: float) -> float:
    """The load: two bumps of opposite sign, the first with a flat top."""
    return float(0.4 * np.clip(2.0 * np.sin(np.pi * time_s) ** 3, -0.5, 1.0))


def run(sim: fw.Simulation, state: fw.State, load_N: float) -> Tuple[NDArray[np.float64], NDArray[np.float64], fw.State]:
    """Strains and deflections at the samples of a window with a constant load, and the state at its end."""
    sim.restore(state)
    sim[LOAD] = load_N
    rows = []
    for _ in range(SAMPLES):
        sim.step(SAMPLE_S)
        rows.append((sim[GAUGE], sim[TIP]))
    strains, tips = np.array(rows).T
    return strains, tips, sim.save()


def estimate(members: int = 24, seed: int = 1, load_N: Callable[[float], float] = gust_N) -> Estimate:
    """Simulates the wing with a load in N over the time in s, measures the strain, and filters it."""
    wing = fw.load(MODEL)
    settings = {"fold.start_angle": 0.0, "gravity": [0.0, 0.0, 0.0]}  # latched, straight
    truth, sim = wing.start(settings=settings), wing.start(settings=settings)
    random = np.random.default_rng(seed)
    states: List[fw.State] = [sim.save()] * members
    loads = random.normal(0.0, START_N, members)
    history = []
    for window in range(WINDOWS):
        measured, actual = [], []
        for sample in range(SAMPLES):
            truth[LOAD] = load_N((window * SAMPLES + sample + 0.5) * SAMPLE_S)
            truth.step(SAMPLE_S)
            measured.append(truth[GAUGE] + random.normal(0.0, NOISE))
            actual.append((truth.time, load_N(truth.time), truth[TIP]))
        loads = loads + random.normal(0.0, WALK_N, members)
        predicted = np.array([run(sim, state, load)[0] for state, load in zip(states, loads)])
        # Kalman gain from the covariances of load and strains in the ensemble
        load_parts, strain_parts = loads - loads.mean(), predicted - predicted.mean(axis=0)
        covariance = strain_parts.T @ strain_parts / (members - 1) + NOISE**2 * np.eye(SAMPLES)
        gain = np.linalg.solve(covariance, strain_parts.T @ load_parts / (members - 1))
        perturbed = np.array(measured) + random.normal(0.0, NOISE, predicted.shape)
        loads = loads + (perturbed - predicted) @ gain
        again = [run(sim, state, load) for state, load in zip(states, loads)]
        states = [state for _, _, state in again]
        tips = np.array([tip for _, tip, _ in again])
        for sample, (time_s, actual_N, tip_m) in enumerate(actual):
            history.append((time_s, actual_N, loads.mean(), loads.std(ddof=1), tip_m, tips[:, sample].mean(), tips[:, sample].std(ddof=1)))
    return Estimate(*np.array(history).T)


def plot(found: Estimate, path: str) -> None:
    """Draws load and deflection with their estimates and two standard deviations."""
    from foldwing.style import PALETTE, curve, labelled, panels, style

    with style() as pyplot:
        figure, places = panels(pyplot, 2, None)
        rows = [
            (found.load_N, found.load_estimate_N, found.load_deviation_N, "load on the tip (N)"),
            (1e3 * found.tip_m, 1e3 * found.tip_estimate_m, 1e3 * found.tip_deviation_m, "deflection of the tip (mm)"),
        ]
        for place, (actual, mean, deviation, label) in zip(places, rows):
            place.fill_between(found.time_s, mean - 2.0 * deviation, mean + 2.0 * deviation, color=PALETTE[1], alpha=0.2, linewidth=0.0)
            curve(place, found.time_s, actual, "actual")
            curve(place, found.time_s, mean, "estimate")
            place.set_ylabel(label)
            labelled(place)
        places[0].set_title("Load and deflection from one strain gauge")
        places[-1].set_xlabel("time (s)")
        figure.savefig(path, dpi=130, metadata={"Software": None})


def main() -> None:
    """Prints the errors, and draws the figure if a file is given."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--members", type=int, default=24, help="size of the ensemble")
    parser.add_argument("--plot", metavar="FILE.png", help="file for a figure")
    arguments = parser.parse_args()
    found = estimate(arguments.members)
    print(
        f"{arguments.members} members, {len(found.time_s)} samples: tip deflection off by {100.0 * found.tip_error():.1f} % of its root mean square "
        f"({1e3 * np.sqrt(np.mean(found.tip_m ** 2)):.1f} mm), load by {found.load_error_N():.3f} N of up to {np.abs(found.load_N).max():.2f} N; "
        f"{100.0 * found.covered():.0f} % within two standard deviations"
    )
    if arguments.plot:
        plot(found, arguments.plot)


if __name__ == "__main__":
    main()
