"""Statics and stability: equilibria, unstable ones, and damping of free-flying machines (D10, D12)."""

from __future__ import annotations

import json
import math

import machine

ROD = """
name = "Rod"
gravity_m_s2 = [0.0, 0.0, -9.81]
{plate}
[body.rod]
length_m = 0.3
section = "plate"
elements = {elements}
load_station_positions_m = [0.3]
{body}
[joint.h]
parent = "root"
child = "rod"
{joint}
{rest}
[simulation]
stop_time_s = 1.0
step_s = 1e-2
"""
BENDING_N_M2 = 2.83e9 * 0.05 * 0.002**3 / 12.0
CLAMPED, HINGED = 'type = "clamped"', 'type = "revolute"\naxis = [0.0, 1.0, 0.0]\nstart_angle_deg = '


def rod(joint: str, rest: str = "", body: str = "", elements: int = 8) -> str:
    return ROD.format(plate=machine.PLATE, joint=joint, rest=rest, body=body, elements=elements)


def arch(force_n: float) -> str:
    """Two plates of 0.25 m, clamped at 6 degrees to the line between their supports and joined at the crown."""
    span_m = 0.5 * math.cos(math.radians(6.0))
    text = f'name = "Arch"\n{machine.PLATE}'
    for name in "ab":
        text += f'[body.{name}]\nlength_m = 0.25\nsection = "plate"\nelements = 4\nload_station_positions_m = [0.25]\n'
    return text + (
        '[joint.a]\ntype = "clamped"\nparent = "root"\nchild = "a"\nmount_rotation_deg = [0.0, -6.0, 0.0]\n'
        f'[joint.b]\ntype = "revolute"\nparent = "root"\nchild = "b"\nroot_position_m = [{span_m}, 0.0, 0.0]\n'
        'axis = [0.0, 1.0, 0.0]\nstart_angle_deg = 186.0\nmotion = "locked"\n'
        '[loop.c]\nbodies = ["a", "b"]\nstiffness_N_m = 1e6\n'
        f'[load.p]\nbody = "a"\nstation = 1\nforce_N = [0.0, 0.0, {-force_n}]\n'
        "[simulation]\nstop_time_s = 1.0\nstep_s = 1e-3\n"
    )


def at_rest(text: str, *options: str) -> tuple[list[float], str]:
    """Tip of the first body in m, and the statement of the command about stability."""
    found = machine.command("static", text, "--json", *options)
    if not found.ended:
        return [math.nan] * 3, found.message[-100:]
    answer = json.loads(found.printed)
    stability = answer.get("stability")
    word = "nothing said" if stability is None else f"unstable in {stability['unstable_directions']}"
    return answer["tips"][0]["position_m"], word


def stability() -> None:
    print("rod on a free hinge under gravity: right is a tip at z = -0.3 m from every start")
    for start in (0.0, -10.0, -30.0, -45.0, -80.0, 1.0, 90.0, 135.0):
        tip, word = at_rest(rod(f"{HINGED}{start}"))
        print(f"  from {start:6.1f} deg: z = {tip[2]:8.5f} m, {word}")
    upright = machine.command("modes", rod(f"{HINGED}-30.0"), "--count", "1")
    print(f"  modes about the state on the load path: {upright.printed.splitlines()[2].strip()}  (right: +7.00 1/s, real)")
    force_n = math.pi**2 * BENDING_N_M2 / 0.3**2
    column = f'[load.p]\nbody = "rod"\nstation = 1\nforce_N = [{-force_n}, 0.0, 1e-6]'
    tip, word = at_rest(rod(CLAMPED, column).replace("-9.81", "0.0"))
    print(f"column at 4 times Euler's load: tip z = {tip[2]:.4f} m, {word}  (right: buckled, 0.19 m)")
    print("shallow arch, crown z in mm (dynamics snap through at 6 N)")
    for force_n in (5.0, 6.0, 7.0, 7.5, 8.0, 9.0, 10.0, 15.0):
        tip, word = at_rest(arch(force_n))
        print(f"  {force_n:4.1f} N: {1e3 * tip[2]:7.2f}, {word}  (right: {'+26' if force_n < 6 else '-21 to -23'})")
    steep = f'[load.p]\nbody = "rod"\nstation = 1\nforce_N = [0.0, 0.0, {1e5 * BENDING_N_M2 / 0.09}]'
    said = machine.command("static", rod(CLAMPED, steep, elements=16).replace("-9.81", "0.0")).printed
    print(f"elastica at 1e5 on 16 elements: hint {'given' if 'mesh is coarse' in said else 'missing'}  (right: given)")


def damping() -> None:
    def flight(start: str) -> machine.Run:
        body, joint = "mass_damping_1_s = 2.5", f'type = "free"\n{start}'
        return machine.run(rod(joint, body=body, elements=2).replace("-9.81", "0.0"))

    speed = flight("start_velocity_m_s = [0.0, 12.0, 0.0]").columns["tip.velocity.y"]
    spin = flight("start_angular_velocity_deg_s = [0.0, 0.0, 100.0]").columns["h.angular_velocity.z"]
    print(f"damped free body in vacuum after 1 s: {speed[-1]:.4f} m/s  (right: 12)")
    print(f"  and {spin[-1] / spin[0]:.6f} of its spin  (right: 1)")
    still = machine.folding_wing(gravity="[0.0, 0.0, 0.0]")
    clamped = machine.run(still, outputs=["fold.latch_time"]).columns["fold.latch_time"][-1]
    heavy = '[mass.carrier]\nbody = "inner"\nposition_m = 0.0\nmass_kg = 1e6\ninertia_kg_m2 = [1e6, 1e6, 1e6, 0.0, 0.0, 0.0]\n'
    for speed in (0.0, 20.0):
        flying = still.replace(
            '[joint.mount]\ntype = "clamped"', f'[joint.mount]\ntype = "free"\nstart_velocity_m_s = [0.0, 0.0, {speed}]'
        ).replace("[gauge.root]", f"{heavy}[gauge.root]")
        time_s = machine.run(flying, outputs=["fold.latch_time"]).columns["fold.latch_time"][-1]
        print(f"fold on a carrier at {speed:4.1f} m/s latches at {time_s:.6f} s, clamped {clamped:.6f} s  (right: the same)")


if __name__ == "__main__":
    stability()
    damping()
