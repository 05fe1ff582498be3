"""Gymnasium environment of the latched wing: an agent damps the vibration after an impulse, with the moment of a piezo patch on the inner wing.

Usage: python examples/gymnasium_wing.py [EPISODES]

Needs `pip install foldwing gymnasium`. An episode starts from the saved equilibrium, with an impulse of random strength; a step is
2 ms. Observations are the root strain and its previous value, the fold angle and its rate. A reset restores the saved state, in a
tenth of a millisecond. The agent here is a simple damper, to demonstrate the environment.
"""

from __future__ import annotations

import sys
from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

import foldwing as fw

STEP_S = 2e-3
MOMENT_N_M = 0.1
GAIN = -0.5
ACTUATOR, GUST = "load.inner[2].moment.y", "load.outer[4].force.z"
SCALE = np.array([1e-3, 1e-3, 0.05, 2.0])
Observation = NDArray[np.float64]


class LatchedWing(gymnasium.Env[Observation, Observation]):
    """Environment: observations are strains, angle and rate, action is the moment; all scaled to about 1."""

    def __init__(self, model: str = "examples/models/folding_wing.toml", blow_N: float = 0.3) -> None:
        self.observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (4,), np.float64)
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (1,), np.float64)
        self.blow_N = blow_N
        self.sim = fw.load(model).start(settings={"fold.start_angle": 0.0})
        for _ in range(400):  # until the latched wing is in equilibrium
            self.sim.step(5e-3)
        self.rest = self.sim.save()
        self.rest_strain = float(self.sim["gauge.root.strain"])
        self.end_s = 0.0
        self.last = 0.0

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Observation, dict[str, Any]]:
        super().reset(seed=seed)
        self.sim.restore(self.rest)
        self.sim[GUST] = self.blow_N * self.np_random.uniform(-1.0, 1.0)
        self.sim.step(0.02)
        self.sim[GUST] = 0.0
        self.end_s = self.sim.time + 0.5
        self.last = self.sim["gauge.root.strain"] - self.rest_strain
        return self.observed(), {}

    def step(self, action: Observation) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        self.last = self.sim["gauge.root.strain"] - self.rest_strain
        self.sim[ACTUATOR] = MOMENT_N_M * float(np.clip(action[0], -1.0, 1.0))
        self.sim.step(STEP_S)
        seen = self.observed()
        reward = -float(seen[0] ** 2 + 0.01 * action[0] ** 2)
        return seen, reward, False, bool(self.sim.time >= self.end_s), {}

    def observed(self) -> Observation:
        strain = self.sim["gauge.root.strain"] - self.rest_strain
        return np.asarray([strain, self.last, self.sim["fold.angle"], self.sim["fold.angular_velocity"]] / SCALE)


def returned(environment: LatchedWing, gain: float, seed: int) -> float:
    """Return of an episode with a moment opposing the strain rate."""
    seen, _ = environment.reset(seed=seed)
    total, over = 0.0, False
    while not over:
        seen, reward, _, over, _ = environment.step(np.array([gain * (seen[0] - seen[1])]))
        total += reward
    return total


def main() -> None:
    episodes = int(sys.argv[1]) if len(sys.argv) > 1 else 5
    environment = LatchedWing()
    alone, damped = (np.mean([returned(environment, gain, seed) for seed in range(episodes)]) for gain in (0.0, GAIN))
    print(f"mean return left alone {alone:.2f}, with a damper {damped:.2f}")


if __name__ == "__main__":
    main()
