#!/usr/bin/env python3
"""Draws the cost of the vortex lattice over its number of panels, compared with Ptera Software 5.1 (pip install pterasoftware).

  python studies/plot_lattice_cost.py --foldwing COMMAND [--python PYTHON_WITH_PTERA] [--runs 1] [--strips 5 10 20 40]

The case of `studies/ptera_uvlm.py`: flat wing of aspect ratio 6 with 8 panels along the chord, sudden start at 5 degrees, 100 steps, the
whole wake kept. In Foldwing it is a complete simulation: a stiff body on the wall, one solution of structure and lattice per step.
Compares processor seconds, the smallest of several alternating runs; prints a table and writes docs/pictures/lattice_cost.png.
"""
import argparse
import json
import pathlib
import re
import subprocess
import sys
import tempfile

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "examples"))

import house_style  # noqa: E402, a file of the examples

CHORD_PANELS = 8
STEPS = 100
STEP_S = 0.0125
WAKES = ["prescribed", "free"]
MODEL = """
name = "FlatWing"
[section.stiff]
shape = "rectangle"
width_m = 1.0
height_m = 0.1
density_kg_m3 = 1000.0
youngs_modulus_Pa = 1e13
poisson_ratio = 0.3
[body.wing]
length_m = 6.0
section = "stiff"
elements = 2
[joint.wall]
type = "clamped"
parent = "root"
child = "wing"
[aerodynamics]
model = "uvlm"
density_kg_m3 = 1.225
wind_m_s = [0.0, -9.961946981, 0.871557427]
steady_initial_flow = false
coupling = "staggered"
leading_edge_suction = true
core_radius_m = 1e-3
step_s = {step_s}
wake_rows = {steps}
free_wake = {free}
[surface.wing]
body = "wing"
elastic_axis_fraction = 0.25
strips = {strips}
chord_panels = {chord_panels}
[solver]
fixed_step_s = {step_s}
"""


def ours(command: str, wake: str, strips: int, folder: pathlib.Path) -> float:
    """Processor seconds of 100 steps."""
    model, timing = folder / "wing.toml", folder / "timing.json"
    free = "true" if wake == "free" else "false"
    model.write_text(MODEL.format(step_s=STEP_S, steps=STEPS, free=free, strips=strips, chord_panels=CHORD_PANELS))
    run = [command, "simulate", str(model), "--stop", str(STEPS * STEP_S), "--step", str(STEP_S), "--variables", "root.force.z"]
    subprocess.run([*run, "--csv", str(folder / "wing.csv"), "--profile", str(timing), "--force", "--quiet"], check=True, capture_output=True)
    return json.loads(timing.read_text())["processor_s"]


def theirs(python: str, wake: str, strips: int) -> float:
    """Processor seconds of the other program's solver for the same steps, without compilation."""
    script = [python, str(ROOT / "studies" / "ptera_uvlm.py"), "--wake", wake, "--ns", str(strips)]
    text = subprocess.run(script, check=True, capture_output=True, text=True).stdout
    return float(re.search(r"solve_cpu_s=([\d.]+)", text).group(1))


def draw(panels: list[int], seconds: dict[str, dict[str, list[float]]], path: pathlib.Path) -> None:
    """Draws processor seconds over panels on logarithmic scales: one colour per wake model, dashed for the other program."""
    house_style.use()
    figure, axes = plt.subplots(figsize=(7.0, 4.5), layout="constrained")
    for wake, colour in zip(WAKES, house_style.PALETTE):
        for program, style in (("Ptera Software", "s--"), ("Foldwing", "o-")):
            axes.loglog(panels, seconds[program][wake], style, color=colour, markersize=5)
            axes.annotate(f"{program} 5.1, {wake} wake" if program.startswith("Ptera") else f"{program}, {wake} wake", (panels[-1], seconds[program][wake][-1]), xytext=(8, 0), textcoords="offset points", color=colour, va="center", fontsize=house_style.SMALL)
    axes.set_xticks(panels, [str(count) for count in panels])
    axes.minorticks_off()
    axes.set_title("Cost of 100 steps of a flat wing")
    axes.set_xlabel("panels, 8 along the chord")
    axes.set_ylabel("processor time (s)")
    figure.savefig(path)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--foldwing", required=True)
    parser.add_argument("--python", default=sys.executable)
    parser.add_argument("--runs", type=int, default=1)
    parser.add_argument("--strips", type=int, nargs="+", default=[5, 10, 20, 40])
    arguments = parser.parse_args()
    seconds: dict[str, dict[str, list[float]]] = {name: {wake: [] for wake in WAKES} for name in ["Foldwing", "Ptera Software"]}
    print("panels  wake        Foldwing, s  Ptera Software, s  ratio")
    with tempfile.TemporaryDirectory() as name:
        for strips in arguments.strips:
            for wake in WAKES:
                pairs = [(ours(arguments.foldwing, wake, strips, pathlib.Path(name)), theirs(arguments.python, wake, strips)) for _ in range(arguments.runs)]
                own, other = [min(times) for times in zip(*pairs)]
                seconds["Foldwing"][wake].append(own)
                seconds["Ptera Software"][wake].append(other)
                print(f"{CHORD_PANELS * strips:6d}  {wake:10s} {own:12.4f} {other:18.3f} {other / own:6.1f}", flush=True)
    draw([CHORD_PANELS * strips for strips in arguments.strips], seconds, ROOT / "docs" / "pictures" / "lattice_cost.png")


if __name__ == "__main__":
    main()
