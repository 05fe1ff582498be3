"""Wake, frames and edges: the same relative flow must give the same loads (D1, D2, D3, D6, default aerodynamic step).

Cases: wings that fly through still air compared with wings fixed in the wind; the unfolding in still air in several frames; two half
wings compared with a mirror and with one body; aerodynamic steps that are too long for the motion.
"""

from __future__ import annotations

import re

import numpy as np
from machine import CHECKOUT, Run, run

STIFF = """
[section.plate]
shape = "explicit"
axial_stiffness_N = 1e9
torsional_rigidity_N_m2 = 1e6
flap_stiffness_N_m2 = 1e6
edge_stiffness_N_m2 = 1e6
mass_kg_m = 1e12
second_moments_kg_m = [1e10, 0.0, 1e10]
half_width_m = 0.1
half_height_m = 0.01
"""
FORCE = ["aero.force.x", "aero.force.y", "aero.force.z"]
TUNNEL = (CHECKOUT / "examples/models/folding_wing_in_tunnel.toml").read_text()


def fail(result: Run) -> str:
    return f"stops: {result.message[-120:]}"


def wing(joint: str, wind_m_s: list[float], air: str) -> str:
    """A heavy wing of aspect ratio 6 at 5 degrees."""
    panels = "" if "strip" in air else "chord_panels = 4\n"
    return (
        f'name = "Wing"\n{STIFF}[body.wing]\nlength_m = 1.2\nsection = "plate"\nelements = 1\n'
        f'[joint.mount]\nparent = "root"\nchild = "wing"\n{joint}\n'
        f"[aerodynamics]\ndensity_kg_m3 = 1.2\nwind_m_s = {wind_m_s}\nstep_s = 5e-3\n{air}\n"
        '[surface.wing]\nbody = "wing"\nchord_m = 0.2\nelastic_axis_fraction = 0.25\nincidence_deg = 5.0\nstrips = 12\n'
        f"{panels}[simulation]\nstop_time_s = 0.3\nstep_s = 0.03\n"
    )


def flight() -> None:
    print("wing at 10 m/s of relative flow: lift at the start and after 0.3 s, N; off the wing fixed in the wind")
    cases = [
        ("clamped", [0.0, -10.0, 0.0], None),
        ("flies, air at rest", [0.0, 0.0, 0.0], [0.0, 10.0, 0.0]),
        ("flies in slow wind from behind", [0.0, 0.1, 0.0], [0.0, 10.1, 0.0]),
        ("flies in slow wind from below", [0.0, 0.0, 0.1], [0.0, 10.0, 0.1]),
    ]
    for air in ('model = "strip"', 'model = "uvlm"', 'model = "uvlm"\nfree_wake = true\nwake_rows = 30'):
        for established in ("true", "false"):
            fixed = None
            for name, wind, velocity in cases:
                joint = 'type = "clamped"' if velocity is None else f'type = "free"\nstart_velocity_m_s = {velocity}'
                result = run(wing(joint, wind, f"{air}\nsteady_initial_flow = {established}"), outputs=FORCE)
                if not result.ended:
                    print(f"  {name}: {fail(result)}")
                    continue
                force = np.array([result.columns[key] for key in FORCE])
                fixed = force if fixed is None else fixed
                off = np.abs(force - fixed).max() / np.abs(fixed).max()
                label = f"{air.splitlines()[0]}{' free wake' if 'free_wake' in air else ''}, established {established}"
                print(f"  {label:45s} {name:30s} {force[2][0]:8.4f} {force[2][-1]:8.4f}  off {off:.0e} (right: 0)")


def unfolding(text: str) -> str:
    result = run(text, "--stop", "0.25", outputs=["fold.latch_time", "gauge.root.strain"])
    if not result.ended:
        return fail(result)
    peak = np.abs(result.columns["gauge.root.strain"]).max()
    return f"latch {result.columns['fold.latch_time'][-1]:.6f} s, peak strain {1e3 * peak:.4f}e-3"


def wind(text: str, speed_m_s: float) -> str:
    return text.replace("wind_m_s = [0.0, -10.0, 0.0]", f"wind_m_s = [0.0, {-speed_m_s}, 0.0]")


def carried(text: str, speed_m_s: float) -> str:
    """The wing on a carrier of 1000 t that moves with the air."""
    held = 'type = "clamped"\nparent = "root"'
    free = f'type = "free"\nstart_velocity_m_s = [0.0, {-speed_m_s}, 0.0]\nparent = "root"'
    mass = '[mass.carrier]\nbody = "inner"\nposition_m = 0.0\nmass_kg = 1e6\ninertia_kg_m2 = [1e6, 1e6, 1e6, 0.0, 0.0, 0.0]\n'
    return wind(text.replace(held, free), speed_m_s) + mass


def still() -> None:
    print("the shipped wing unfolds in the tunnel's air, gravity and mass damping off (right: one answer)")
    free = TUNNEL.replace("gravity_m_s2 = [-9.8, 0.0, 0.0]", "gravity_m_s2 = [0.0, 0.0, 0.0]")
    free = free.replace("mass_damping_1_s = 2.5", "stiffness_damping_s = 1e-4")
    print(f"  root at rest             {unfolding(wind(free, 0.0))}")
    for speed in (1.0, 5.0, 20.0):
        print(f"  root and air at {speed:4.0f} m/s {unfolding(carried(free, speed))}")
    print("the shipped wing as it is, wind along the chord (right: slow wind leads to air at rest)")
    for speed in (0.0, 0.01, 0.1, 1.0, 10.0, 20.0):
        for established in ("true", "false"):
            text = wind(TUNNEL, speed).replace("[aerodynamics]", f"[aerodynamics]\nsteady_initial_flow = {established}")
            print(f"  {speed:5.2f} m/s, established {established:5s}: {unfolding(text)}")


def slit() -> None:
    print("lift of half a wing at 5 deg, N: at a mirror, half of one body, half of two on the root (right: the same)")
    for strips in (6, 12, 24):
        lifts = []
        for kind in ("mirror", "one", "two"):
            length, root = (2.0, "\nroot_position_m = [-1.0, 0.0, 0.0]") if kind == "one" else (1.0, "")
            bodies = f'[body.r]\nlength_m = {length}\nsection = "plate"\nelements = 1\n'
            bodies += f'[joint.r]\ntype = "clamped"\nparent = "root"\nchild = "r"{root}\n'
            surfaces = f'[surface.r]\nbody = "r"\nchord_m = 0.2\nstrips = {2 * strips if kind == "one" else strips}\n'
            if kind == "two":
                bodies += '[body.l]\nlength_m = 1.0\nsection = "plate"\nelements = 1\n[joint.l]\ntype = "clamped"\n'
                bodies += 'parent = "root"\nchild = "l"\nmount_rotation_deg = [0.0, 0.0, 180.0]\n'
                surfaces += f'[surface.l]\nbody = "l"\nleading_edge = "-y"\nchord_m = 0.2\nstrips = {strips}\n'
            mirror = "mirror_normal = [1.0, 0.0, 0.0]\n" if kind == "mirror" else ""
            air = '[aerodynamics]\nmodel = "uvlm"\nwind_m_s = [0.0, -9.962, 0.8716]\nwake_rows = 10\n' + mirror
            text = f'name = "Wing"\n{STIFF}{bodies}{air}{surfaces}[simulation]\nstop_time_s = 0.01\nstep_s = 0.01\n'
            result = run(text, outputs=FORCE)
            lift = result.columns["aero.force.z"][0] if result.ended else np.nan
            lifts.append(lift if kind == "mirror" else lift / 2)
        print(f"  {strips:2d} strips: {lifts[0]:.5f} {lifts[1]:.5f} {lifts[2]:.5f}, off {100 * (lifts[2] / lifts[0] - 1):+.2f} %")


def steps() -> None:
    print("the shipped wing at 0.5 m/s, aerodynamic steps (right: the short one, or a warning)")
    for step in ("", "step_s = 2.5e-2", "step_s = 5e-3", "step_s = 1.25e-3"):
        text = wind(TUNNEL, 0.5).replace("step_s = 1.25e-3 # the wind", f"{step} # the wind")
        text = text.replace("wake_rows = 30", "wake_rows = 200")
        result = run(text, "--stop", "0.25", outputs=["fold.latch_time"])
        told = [line for line in (result.printed + result.message).splitlines() if line.startswith("warning")]
        latch = result.columns["fold.latch_time"][-1] if result.ended else np.nan
        print(f"  {step or 'default':18s} latch {latch:.5f} s; {told[0] if told else 'no warning'}")


def slow() -> None:
    """Whether an effect of slow wind is physical or due to discretisation: panels, aerodynamic step, rows of the wake, tolerances,
    strips."""
    print("the shipped wing in slow wind that sets in at the start: latch at rest, later at 0.01 and 0.1 m/s, s")
    whole = "coupling_tolerance = 1e-7\n"
    for chord, span, step, rows, more, tolerance in (
        (4, 10, 1.25e-3, 30, "", 1e-4),
        (4, 10, 1.25e-3, 120, "", 1e-4),
        (4, 10, 1.25e-3, 120, whole, 1e-6),
        (4, 10, 6.25e-4, 240, "", 1e-4),
        (6, 15, 8.3333e-4, 180, "", 1e-4),
        (8, 20, 6.25e-4, 240, "", 1e-4),
        (0, 10, 1.25e-3, 0, "", 1e-4),
        (0, 20, 6.25e-4, 0, "", 1e-4),
        (0, 10, 1.25e-3, 0, "quasi_steady = true\n", 1e-4),
    ):
        text = TUNNEL.replace("[aerodynamics]\n", f"[aerodynamics]\nsteady_initial_flow = false\n{more}")
        text = text.replace("step_s = 1.25e-3", f"step_s = {step}").replace("strips = 10", f"strips = {span}")
        text = text.replace("wake_rows = 30", f"wake_rows = {rows}").replace("chord_panels = 4", f"chord_panels = {chord}")
        if not chord:
            text = text.replace('"uvlm"', '"strip"')
            text = re.sub(r"(?m)^(mirror_normal|wake_rows|chord_panels) = .*\n", "", text)
        text += f"\n[solver]\ntolerance = {tolerance}\n"
        runs = [run(wind(text, speed), "--stop", "0.14", outputs=["fold.latch_time"]) for speed in (0.0, 0.01, 0.1)]
        latch = [result.columns["fold.latch_time"][-1] if result.ended else np.nan for result in runs]
        name = f"{chord} x {span}, {rows} rows" if chord else f"{span} strips"
        name += f", {1e3 * step:.3g} ms, tolerance {tolerance:g} {more.strip()}"
        print(f"  {name:70s} {latch[0]:.6f} {latch[1] - latch[0]:.2e} {latch[2] - latch[0]:.2e}")


if __name__ == "__main__":
    flight()
    still()
    slow()
    slit()
    steps()
