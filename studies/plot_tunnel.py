#!/usr/bin/env python3
"""Figures 9 to 12 of Otsuka et al., the deployment in the wind tunnel, with our results.

Usage: plot_tunnel.py --foldwing COMMAND --output docs/pictures [--model MODEL.toml]

Writes tunnel_views.png (3-D views with the wake at 10 m/s and the wing's axis over time), tunnel_histories.png (fold angle
and strain over time at 0, 10 and 20 m/s) and tunnel_speeds.png (latch time and peak strain against the speed). The paper's
numbers are those of its text; its curves are not copied.
"""

import argparse
import csv
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import TwoSlopeNorm, to_rgba
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "examples"))

from deploy import ACCENT, INK, LATCH, STYLE, latch_time, peak, save, shape  # noqa: E402

VIEW_TIMES_S = (0.0, 0.10, 0.15, 0.20)
SPEEDS_M_S = (0, 5, 10, 15, 20)
PAPER_LATCH_S = {0: 0.120, 10: 0.166, 20: 0.198}  # section 5 and Fig. 10
PAPER_TIP_M, PAPER_TIP_TIME_S = 0.056, 0.2  # section 5, at 10 m/s
STILL, SLOW, FAST = "#7a8b99", "#2f78b7", "#0f3557"
COLOURS = {0: STILL, 10: SLOW, 20: FAST}
WAKE_SHOWN_M = 0.22  # behind the trailing edge
VIEW_DEG = (42, -118)  # elevation and azimuth: from upstream, from the folded side


def simulate(foldwing, model, folder, speed_m_s):
    """All outputs at one wind as a structured array, and the lattices at the times of the views."""
    table, lattices = folder / f"{speed_m_s}.csv", folder / f"{speed_m_s}.json"
    command = [str(foldwing), "simulate", str(model), "-q", "--csv", str(table), "--lattice", str(lattices)]
    command += ["--set", f"wind.velocity.y={-speed_m_s}"]
    command += [part for time_s in VIEW_TIMES_S for part in ("--lattice-at", str(time_s))]
    subprocess.run(command, check=True)
    with open(table) as file:
        names, *rows = csv.reader(file)
    result = np.array([tuple(map(float, row)) for row in rows], dtype=[(name, float) for name in names])
    return result, json.loads(lattices.read_text())


def to_view(points):
    """Root frame to the axes of the view: downstream (−y), out of the plane (z), along the wing (x) upwards."""
    points = np.asarray(points)
    return np.stack([-points[..., 1], points[..., 2], points[..., 0]], axis=-1)


def quads(nodes):
    """Corners of the cells of a net of nodes, row by row."""
    return np.stack([nodes[:-1, :-1], nodes[:-1, 1:], nodes[1:, 1:], nodes[1:, :-1]], axis=2).reshape(-1, 4, 3)


def draw_view(axes, lattice, norm, colours):
    """Wall, wing and wake in one collection, so that what is near hides what is far."""
    wall = np.array([[[-0.06, -0.19, 0.0], [0.28, -0.19, 0.0], [0.28, 0.11, 0.0], [-0.06, 0.11, 0.0]]])
    axes.add_collection3d(Poly3DCollection(wall, facecolors="#eef2f5", edgecolors="#c3ced8", linewidths=0.6, clip_on=False))
    cells, faces, edges = [], [], []
    for surface in lattice["surfaces"]:
        wing, wake = (to_view(surface[key]) for key in ("corner_m", "wake_node_m"))
        rows = int(np.sum(wake[:, 0, 0] - wake[0, 0, 0] < WAKE_SHOWN_M))  # the last row of the start is very long
        strength = np.array(surface["wake_circulation_m2_s"])[: rows - 1].ravel()
        cells += [quads(wake[:rows]), quads(wing)]
        faces += [colours(norm(strength)), np.tile(to_rgba(INK), (len(cells[-1]), 1))]
        edges += [np.tile(to_rgba("#9fb2c3"), (len(strength), 1)), np.tile(to_rgba("#c9d6e2"), (len(cells[-1]), 1))]
    parts = (np.concatenate(part) for part in (cells, faces, edges))
    cells, faces, edges = parts
    net = Poly3DCollection(cells, facecolors=faces, edgecolors=edges, linewidths=0.25, clip_on=False, zorder=2)
    axes.add_collection3d(net)
    axes.set(xlim=(-0.06, 0.28), ylim=(-0.19, 0.11), zlim=(0, 0.31))
    axes.set_box_aspect((0.34, 0.30, 0.31), zoom=1.13)
    axes.set_proj_type("ortho")
    axes.computed_zorder = False  # the wall lies below everything
    axes.view_init(elev=VIEW_DEG[0], azim=VIEW_DEG[1])
    axes.patch.set_alpha(0.0)
    axes.set_axis_off()
    axes.text2D(0.03, 0.86, f"{lattice['time_s']:.2f} s", transform=axes.transAxes, fontsize=11, color=INK)


def plot_views(result, lattices, path):
    """Figure 9: four 3-D views and the wing's axis."""
    strongest = max(np.abs(s["wake_circulation_m2_s"]).max() for lattice in lattices for s in lattice["surfaces"])
    norm, colours = TwoSlopeNorm(0.0, -strongest, strongest), plt.get_cmap("RdBu_r")
    figure = plt.figure(figsize=(12.0, 6.0))
    for index, lattice in enumerate(lattices):
        place = [0.31 * (index % 2), 0.52 - 0.43 * (index // 2), 0.31, 0.46]
        draw_view(figure.add_axes(place, projection="3d"), lattice, norm, colours)
    bar = figure.add_axes([0.1, 0.035, 0.4, 0.016])
    figure.colorbar(plt.cm.ScalarMappable(norm, colours), cax=bar, orientation="horizontal")
    bar.set_title("circulation of the wake's rings (m²/s)", fontsize=8, loc="left")
    bar.tick_params(labelsize=8)

    axes = figure.add_axes([0.68, 0.08, 0.31, 0.82])
    times = np.arange(0.0, PAPER_TIP_TIME_S + 1e-9, 0.02)
    for time_s, colour in zip(times, plt.get_cmap("viridis")(np.linspace(0.0, 0.92, len(times)))):
        x, z = 1e3 * shape(result, time_s)
        axes.plot(z, x, color=colour, linewidth=1.5)
        axes.annotate(f"{time_s:.2f}", (z[-1], x[-1]), fontsize=7, color=colour, xytext=(3, 3), textcoords="offset points")
    z_mm, x_mm = (1e3 * value_at(result, f"tip.position.{axis}", PAPER_TIP_TIME_S) for axis in "zx")
    axes.plot(z_mm, x_mm, "o", color=INK, label=f"tip at 0.2 s: {z_mm:.1f} mm")
    axes.axvline(1e3 * PAPER_TIP_M, color=LATCH, linestyle="--", linewidth=1.1, label=f"the paper's text: {1e3 * PAPER_TIP_M:.0f} mm")
    axes.set(xlabel="z (mm)", ylabel="x (mm)")
    axes.set_title("Wing axis, every 0.02 s (label: s)", loc="left", fontsize=10, color=INK)
    axes.set_aspect("equal")
    axes.set(xlim=(-190, 80), ylim=(-45, 320))
    axes.legend(fontsize=8, loc="lower left")
    figure.suptitle("Deployment at 10 m/s with its wake", x=0.01, ha="left", fontsize=12, color=INK)
    save(figure, path)


def value_at(result, name, time_s):
    """A column at the nearest row."""
    return result[name][int(np.argmin(np.abs(result["time"] - time_s)))]


def plot_histories(runs, path):
    """Figures 10 and 11: fold angle and strain over time at three speeds."""
    figure, grid = plt.subplots(2, len(PAPER_LATCH_S), figsize=(11, 5.6), sharex=True, sharey="row", layout="constrained")
    for (upper, lower), (speed_m_s, paper_s) in zip(grid.T, PAPER_LATCH_S.items()):
        result, colour = runs[speed_m_s][0], COLOURS[speed_m_s]
        latch_s = latch_time(result)
        upper.plot(result["time"], np.degrees(result["fold.angle"]), color=colour)
        upper.plot(latch_s, 0.0, "o", color=colour, label=f"latch at {latch_s:.4f} s")
        upper.axvline(paper_s, color=LATCH, linestyle="--", linewidth=1.1, label=f"paper: {paper_s:.3f} s")
        upper.set_title(f"{speed_m_s} m/s", loc="left", fontsize=11, color=INK)
        upper.legend(fontsize=8)
        time_s, strain = peak(result)
        lower.plot(result["time"], 1e3 * result["gauge.root.strain"], color=colour, linewidth=1.1)
        lower.plot(time_s, 1e3 * strain, "o", color=ACCENT, label=f"peak {1e3 * abs(strain):.2f}·10⁻³ at {time_s:.3f} s")
        lower.axvline(latch_s, color=colour, linestyle=":", linewidth=1.0)
        lower.set(xlabel="time (s)", xlim=(0.0, 0.4))
        lower.legend(fontsize=8, loc="lower right")
    grid[0, 0].set(ylabel="fold angle (deg)", yticks=np.arange(0, 181, 30))
    # room for the legend below the deepest peak; the axes share it
    grid[1, 0].set(ylabel="strain at the root gauge (10⁻³)", ylim=(-6.2, 4.8))
    save(figure, path)


def plot_speeds(runs, path):
    """Figure 12 and the latch times beside it."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(9.6, 3.9), layout="constrained")
    speeds = list(runs)
    left.plot(speeds, [latch_time(runs[speed][0]) for speed in speeds], "o-", color=SLOW, label="ours")
    left.errorbar(list(PAPER_LATCH_S), list(PAPER_LATCH_S.values()), yerr=[0.03 * value for value in PAPER_LATCH_S.values()],
                  fmt="D", color=LATCH, capsize=4, label="paper's simulation, ± 3 %")
    left.set(xlabel="flow speed (m/s)", xticks=speeds, ylabel="latch time (s)", ylim=(0.1, 0.215))
    left.legend()
    peaks = [1e3 * abs(peak(runs[speed][0])[1]) for speed in speeds]
    right.plot(speeds, peaks, "o-", color=SLOW, label="ours")
    for speed, value in zip(speeds, peaks):
        right.annotate(f"{value:.2f}", (speed, value), xytext=(4, 6), textcoords="offset points", fontsize=8, color=INK)
    right.set(xlabel="flow speed (m/s)", xticks=speeds, ylabel="peak strain (10⁻³)", ylim=(0.0, 6.2))
    right.legend()
    save(figure, path)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--foldwing", type=Path, required=True, help="the command")
    parser.add_argument("--output", type=Path, required=True, help="folder of the pictures")
    parser.add_argument("--model", type=Path, default=ROOT / "examples/models/folding_wing_in_tunnel.toml")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        runs = {speed: simulate(arguments.foldwing.resolve(), arguments.model, Path(folder), speed) for speed in SPEEDS_M_S}
    plt.rcParams.update({**STYLE, "figure.dpi": 110})
    arguments.output.mkdir(parents=True, exist_ok=True)
    plot_views(*runs[10], arguments.output / "tunnel_views.png")
    plot_histories(runs, arguments.output / "tunnel_histories.png")
    plot_speeds(runs, arguments.output / "tunnel_speeds.png")
    for speed, (result, _) in runs.items():
        print(f"{speed:2} m/s: latch at {latch_time(result):.4f} s, peak strain {abs(peak(result)[1]):.3e}, "
              f"tip at 0.2 s {1e3 * value_at(result, 'tip.position.z', PAPER_TIP_TIME_S):.1f} mm")


if __name__ == "__main__":
    main()
