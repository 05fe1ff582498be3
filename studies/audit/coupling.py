"""Coupling of aerodynamics and structure: light tips, schemes that diverge, fixed steps, hinges held only by aerodynamics, linear models
with aerodynamics."""

from __future__ import annotations

import re

import numpy as np
from machine import CHECKOUT, WORK, command, run

BASELINE = """
name = "Baseline"
[section.spar]
shape = "explicit"
axial_stiffness_N = 2.316e7
torsional_rigidity_N_m2 = 48.731
flap_stiffness_N_m2 = 34.431
edge_stiffness_N_m2 = 1962.8
mass_kg_m = 0.96
second_moments_kg_m = [7.2e-5, 0.0, 1.28e-6]
[section.tip]
shape = "explicit"
axial_stiffness_N = 2.316e7
torsional_rigidity_N_m2 = 48.731
flap_stiffness_N_m2 = 34.431
edge_stiffness_N_m2 = 1962.8
mass_kg_m = 0.0096
second_moments_kg_m = [1e-9, 0.0, 1e-9]
[body.inner]
length_m = 0.805895
section = "spar"
elements = 5
stiffness_damping_s = 1e-6
[body.tip]
length_m = 0.194105
section = "tip"
elements = 1
stiffness_damping_s = 1e-6
[joint.mount]
type = "clamped"
parent = "root"
child = "inner"
[joint.fold]
type = "revolute"
parent = "inner"
child = "tip"
axis = [0.25881904510252074, 0.9659258262890683, 0.0]
start_angle_deg = -2.0
[joint.fold.motor]
[surface.inner]
body = "inner"
chord_m = 0.12
elastic_axis_fraction = 0.25
strips = 14
[surface.tip]
body = "tip"
chord_m = 0.12
elastic_axis_fraction = 0.25
strips = 5
"""


def baseline(air: str, stop_s: float) -> str:
    """The Bristol baseline wing as published (F. Healy, PhD thesis, 2023): the mass of the tip beam is smaller than the apparent mass of
    the air."""
    places = [(0.07, 0.075), (0.21, 0.075), (0.35, 0.075), (0.49, 0.075), (0.63, 0.075), (0.767, 0.056)]
    inertia = "[73e-6, 82e-6, 151e-6, 0.0, 0.0, 0.0]"
    masses = "".join(
        f'[mass.point{i}]\nbody = "inner"\nposition_m = {place}\nmass_kg = {mass}\noffset_m = [0.0, -0.021, 0.0]\n'
        f"inertia_kg_m2 = {inertia}\n"
        for i, (place, mass) in enumerate(places)
    )
    masses += (
        '[mass.tip]\nbody = "tip"\nposition_m = 0.081105\nmass_kg = 0.167\noffset_m = [0.0, -0.022, 0.0]\n'
        "inertia_kg_m2 = [122e-6, 942e-6, 1057e-6, 0.0, 0.0, 0.0]\n"
    )
    return (
        f"{BASELINE}{masses}[aerodynamics]\ndensity_kg_m3 = 1.225\nwind_m_s = [0.0, -20.0, 0.0]\n{air}\n"
        f'[simulation]\nstop_time_s = {stop_s}\nstep_s = 5e-3\nstart = "equilibrium"\n'
    )


def light_tips() -> None:
    """The iteration between aerodynamics and structure converges in every step."""
    print("tip beam of 0.0096 kg/m in 0.0139 kg/m of air; right: every run ends")
    for air, stop_s in [
        ('model = "strip"', 2.0),
        ('model = "strip"\nstep_s = 3e-3', 2.0),
        ('model = "strip"\nstep_s = 7e-4', 1.0),
        ('model = "uvlm"\nwake_rows = 40', 2.0),
    ]:
        outcome = run(baseline(air, stop_s), outputs=["fold.angle"])
        last = f"ended after {outcome.timing.get('iterations', 0):.0f} iterations" if outcome.ended else outcome.message
        print(f"  {air!r}: {last}")


def staggered() -> None:
    """A scheme that diverges stops with an error that names it."""
    text = (CHECKOUT / "examples/models/flared_wing_tip.toml").read_text()
    text = text.replace('model = "strip"', 'model = "strip"\ncoupling = "staggered"')
    outcome = run(text, outputs=["fold.angle"], limit_s=60.0)
    largest_deg = np.degrees(np.abs(outcome.columns["fold.angle"]).max()) if outcome.columns else 0.0
    print("staggered on the shipped flared tip; right: an error that names the scheme, and no spin")
    print(f"  exit code {outcome.code}, largest angle {largest_deg:.1f} deg; {outcome.message.splitlines()[-1:]}")


def fixed_steps() -> None:
    """The latch time does not depend on the communication step."""
    text = (CHECKOUT / "examples/models/folding_wing_in_tunnel.toml").read_text()
    print("tunnel with fixed steps, communication steps of 0.1 to 9 ms; right: one latch time, one number of steps")
    for solver in ("fixed_step_s = 2.5e-4", "fixed_step_s = 1e-3", 'fixed_step_s = 1e-3\nmethod = "tr_bdf2"'):
        model = text.replace("[simulation]", f"[solver]\n{solver}\n[simulation]")
        outcomes = [
            run(model, "--step", step, "--stop", "0.2", outputs=["fold.latch_time"])
            for step in ("5e-4", "1e-4", "2e-3", "9e-3")
        ]
        times = [f"{outcome.columns['fold.latch_time'][-1]:.9f}" if outcome.ended else "-" for outcome in outcomes]
        print(f"  {solver!r}: {times} s, steps {[int(outcome.timing['steps']) for outcome in outcomes if outcome.ended]}")


def coasting() -> None:
    """`static` finds the equilibrium angle of a free tip."""
    text = (CHECKOUT / "examples/models/flared_wing_tip.toml").read_text()
    text = re.sub(r"\[gust\.bump\].*?(?=\[gauge)", "", text, flags=re.S)
    damped = text.replace("damping_N_m_s_rad = 0.02", "damping_N_m_s_rad = 0.3")
    end = run(damped, "--stop", "3.0", "--step", "0.05", outputs=["fold.angle"])
    print(f"flared tip; right: the end of a damped run, {np.degrees(end.columns['fold.angle'][-1]):.4f} deg")
    outcome = command("static", text)
    found = re.findall(r"fold: angle (-?\d+\.\d+) deg", outcome.printed)
    print(f"  static: exit code {outcome.code}, {found or outcome.message}")


def linear_models() -> None:
    """Linear models and modes with strips include the aerodynamics, with wind among the inputs."""
    text = (CHECKOUT / "examples/models/goland_wing.toml").read_text()
    outcome = command("linearize", text, "--state", "start", "-o", str(WORK / "goland.json"))
    written = (WORK / "goland.json").read_text() if outcome.ended else ""
    print("linear model of Goland's wing 5 % below its flutter; right: wind among the inputs, 'in air'")
    print(f"  wind among the inputs: {'wind.velocity' in written}; {outcome.printed.strip()}")
    print(f"  modes: {command('modes', text).printed.splitlines()[:1]}")


if __name__ == "__main__":
    light_tips()
    staggered()
    fixed_steps()
    coasting()
    linear_models()
