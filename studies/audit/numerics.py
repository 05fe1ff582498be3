"""Steps, latch crossings, outputs between steps, real time (D4, D5, D15)."""

import random

import numpy as np
from machine import PLATE, folding_wing, run


def chain(seed: int, solver: str = "") -> str:
    """A random chain of 1 to 7 folds that unfold and latch."""
    rng = random.Random(seed)
    bodies, elements = rng.randint(2, 8), rng.choice([1, 2, 3, 4])
    gravity = [rng.choice([0.0, 0.0, rng.uniform(-9.8, 9.8)]) for _ in range(3)]
    lines = [f'name = "Chain"\ngravity_m_s2 = {gravity}', PLATE.replace("0.002", f"{10 ** rng.uniform(-3, -2.3):.5f}")]
    for i in range(bodies):
        lines.append(
            f'[body.b{i}]\nlength_m = {rng.uniform(0.05, 0.4):.4f}\nsection = "plate"\nelements = {elements}\n'
            f"mass_damping_1_s = {rng.choice([0, 2.5])}\nstiffness_damping_s = {rng.choice([0, 0, 1e-5])}"
        )
    lines.append('[joint.mount]\ntype = "clamped"\nparent = "root"\nchild = "b0"')
    for i in range(1, bodies):
        side, stiffness, torque = rng.choice([1, -1]), 10 ** rng.uniform(-2, 0.5), 10 ** rng.uniform(-2, 0.3)
        lines.append(
            f'[joint.f{i}]\ntype = "revolute"\nparent = "b{i - 1}"\nchild = "b{i}"\naxis = [0.0, 1.0, 0.0]\n'
            f"start_angle_deg = {side * rng.uniform(20, 170):.3f}\n[joint.f{i}.motor]\nstiffness_N_m_rad = {stiffness:.5f}\n"
            f"damping_N_m_s_rad = {10 ** rng.uniform(-4, -1.5):.6f}\nconstant_torque_N_m = {side * torque:.5f}\n"
            f"[joint.f{i}.latch]\nstiffness_ratio = {10 ** rng.uniform(2, 6):.2f}"
        )
    lines.append(f"[solver]\n{solver}\n[simulation]\nstop_time_s = 1.0\nstep_s = 1e-3\n")
    return "\n".join(lines)


def crossings(count: int = 250) -> None:
    """D4: chains whose simulation stops."""
    outcomes = [run(chain(seed), outputs=["f1.angle"]) for seed in range(count)]
    stopped = [seed for seed, outcome in enumerate(outcomes) if not outcome.ended]
    print(f"D4: {len(stopped)} of {count} random chains stop, at seeds {stopped}; right: none")


def between_steps() -> None:
    """D5: stiff coordinates within steps."""
    for ratio in (1e4, 1e6, 1e8):
        for tolerance in (1e-4, 1e-6):
            outcome = run(
                folding_wing(stiffness_ratio=ratio, solver=f"tolerance = {tolerance}"),
                outputs=["fold.latch_torque", "energy.total", "energy.work", "energy.dissipated", "energy.kinetic"],
            )
            columns = outcome.columns
            account = columns["energy.total"] - columns["energy.work"] + columns["energy.dissipated"]
            print(
                f"D5: latch ratio {ratio:g}, tolerance {tolerance:g}: largest latch torque "
                f"{abs(columns['fold.latch_torque']).max():.4g} N·m (right: 0.229), energy account off by "
                f"{np.ptp(account):.2e} J of {columns['energy.kinetic'].max():.2e} J"
            )


def real_time(count: int = 120) -> None:
    """D15: chains in real-time mode."""
    ended, named, blown = 0, 0, 0
    for seed in range(count):
        outcome = run(chain(seed, 'mode = "real_time"'), outputs=["f1.angle"])
        angle = outcome.columns.get("f1.angle")
        if angle is not None and abs(angle).max() > 50.0:
            blown += 1
        elif outcome.ended:
            ended += 1
        else:
            named += "in real time" in outcome.message
    print(f"D15: of {count} chains at 1 ms {ended} end, {named} stop by name, {blown} go on beyond 50 rad; right: none do")


if __name__ == "__main__":
    crossings()
    between_steps()
    real_time()
