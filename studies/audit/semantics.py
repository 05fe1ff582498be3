"""Torques about a hinge: torque limit, latch, release (D8, D9, D11, D14)."""

from __future__ import annotations

import numpy as np
from machine import Run, command, folding_wing, inputs, run

LATCH = ["fold.angle", "fold.angular_velocity", "fold.latched", "fold.latch_time"]
ENERGY = ["energy.total", "energy.work", "energy.dissipated", "energy.kinetic"]


def say(what: str, found: str, right: str) -> None:
    print(f"{what:62s} {found:58s} right: {right}", flush=True)


def closing(outcome: Run) -> str:
    if not outcome.columns:
        return outcome.message[-80:]
    angle = np.degrees(outcome.columns["fold.angle"])
    state = "latched" if outcome.columns["fold.latched"][-1] else "open"
    return f"{state}, {outcome.columns['fold.latch_time'][-1]:.6f} s, {angle.min():.3f} to {angle.max():.3f} deg"


def drift(outcome: Run) -> float:
    """Largest change of total − work + dissipated, relative to the largest kinetic energy."""
    columns = outcome.columns
    balance = columns["energy.total"] - columns["energy.work"] + columns["energy.dissipated"]
    return float(np.ptp(balance) / columns["energy.kinetic"].max())


def limit_and_external_torque() -> None:
    text = folding_wing(
        stiffness_n_m_rad=0.0, damping_n_m_s_rad=0.0, torque_n_m=0.0, latch=False, gravity="[0, 0, 0]",
        drive_keys="torque_limit_N_m = 0.02",
    )  # fmt: skip
    outcome = run(text, "--set", "fold.external_torque=-1.0", "--stop", "0.02", outputs=["fold.total_torque"])
    say("D9 external torque -1 N.m, motor limited to 0.02 N.m", f"{outcome.columns['fold.total_torque'][1]:g} N.m", "-1")


def latch() -> None:
    held = inputs("time,fold.release\n0,0\n0.1,1\n")
    cases = {
        "D11 starts at the latch angle": (folding_wing(start_deg=0.0), []),
        "D11 starts there, held for 0.1 s": (folding_wing(start_deg=0.0), ["--inputs", held]),
        "D11 starts 0.5 deg off, capture 1 deg": (folding_wing(start_deg=0.5, latch_keys="capture_deg = 1.0"), []),
    }
    for what, (text, arguments) in cases.items():
        say(what, closing(run(text, *arguments, outputs=LATCH)), "latched at the start")
    creeps = folding_wing(
        start_deg=30.0, torque_n_m=0.0, stiffness_n_m_rad=0.3, damping_n_m_s_rad=0.2, gravity="[0, 0, 0]",
        simulation="stop_time_s = 20.0\nstep_s = 1e-2",
    )  # fmt: skip
    say("D11 creeps to the latch angle", closing(run(creeps, outputs=LATCH)), "8.8 s: c/k ln(start/capture)")
    say("    the shipped wing", closing(run(folding_wing(), outputs=LATCH)), "0.1222 s, 1e-6 rad over the rate, 1.06e-7 s, before 0.1.0")
    text = command("static", folding_wing(start_deg=0.0)).printed
    say("D11 `static` at the latch angle", "latched" if ", latched" in text else "open", "latched")


def release() -> None:
    back = inputs("time,fold.release\n0,1\n0.06,0\n")
    outcome = run(folding_wing(), "--inputs", back, outputs=["fold.angle", *ENERGY])
    angle = np.degrees(outcome.columns["fold.angle"])
    at = int(round(0.0605 / 5e-4))
    say("D14 released, held again at 60 ms: turns on by", f"{np.ptp(angle[at:]):.3g} deg", "0")
    say("    energy", f"drift {drift(outcome):.1e} of the kinetic energy", "0")


def limits() -> None:
    for name, keys in {
        "k = 20, c = 0.5": dict(stiffness_n_m_rad=20.0, damping_n_m_s_rad=0.5, torque_n_m=0.0, start_deg=60.0),
        "k = 50, c = 1": dict(stiffness_n_m_rad=50.0, damping_n_m_s_rad=1.0, torque_n_m=0.0, start_deg=60.0),
        "friction, c = 100": dict(stiffness_n_m_rad=0.0, damping_n_m_s_rad=100.0, torque_n_m=0.05),
    }.items():
        for method in ("esdirk4", "esdirk3", "tr_bdf2", "sdirk2", "generalized_alpha"):
            spent = []
            for limit in ("", "torque_limit_N_m = 0.02"):
                text = folding_wing(latch=False, drive_keys=limit, solver=f'method = "{method}"', **keys)
                outcome = run(text, "--stop", "1", "--step", "1e-3", outputs=ENERGY, limit_s=120)
                spent.append(outcome.timing.get("iterations", float("nan")))
            found = f"{spent[1]:.0f} against {spent[0]:.0f} residuals, drift {drift(outcome) if outcome.ended else 1:.1e}"
            say(f"D8 {name}, limit 0.02 N.m, {method}", found, "at most 3 times")


if __name__ == "__main__":
    limit_and_external_torque()
    latch()
    release()
    limits()
