#!/usr/bin/env python3
"""Figures 9 to 12 of Otsuka et al., the deployment in the wind tunnel, with our results.

Usage: plot_tunnel.py --foldwing COMMAND --output docs/pictures [--model MODEL.toml]

Writes tunnel_views.png (3-D views with the wake at 10 m/s and the wing's axis over time), tunnel_histories.png (fold angle
and strain over time at 0, 10 and 20 m/s) and tunnel_speeds.png (latch time and peak strain against the speed). The paper's values are
taken from its text; its curves are not reproduced.
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

from deploy import latch_time, peak, shape  # noqa: E402
from house_style import BLUE, GREEN, INK, SKY, SMALL, VERMILION, mark, number, save, use  # noqa: E402

VIEW_TIMES_S = (0.0, 0.10, 0.15, 0.20)
SPEEDS_M_S = (0, 5, 10, 15, 20)
PAPER_LATCH_S = {0: 0.120, 10: 0.166, 20: 0.198}  # section 5 and Fig. 10
PAPER_TIP_M, PAPER_TIP_TIME_S = 0.056, 0.2  # section 5, at 10 m/s
COLOURS = {0: SKY, 10: BLUE, 20: GREEN}
PAPER = VERMILION  # values of the paper, in all pictures
WING = "#3b4754"  # a colour that does not occur in the scale of the circulation
WAKE_SHOWN_M = 0.22  # behind the trailing edge
VIEW_DEG = (42, -118)  # elevation and azimuth: from upstream, from the folded side


def simulate(foldwing, model, folder, speed_m_s):
    """All outputs at one wind speed as a structured array, and the lattices at the times of the views."""
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
    """Transforms points from the root frame to the axes of the view: downstream (−y), out of the plane (z), along the wing (x) upwards."""
    points = np.asarray(points)
    return np.stack([-points[..., 1], points[..., 2], points[..., 0]], axis=-1)


def quads(nodes):
    """Corners of the cells of a grid of nodes, row by row."""
    return np.stack([nodes[:-1, :-1], nodes[:-1, 1:], nodes[1:, 1:], nodes[1:, :-1]], axis=2).reshape(-1, 4, 3)


def draw_view(axes, lattice, norm, colours):
    """Draws wall, wing and wake in one collection, so that near parts hide far ones."""
    wall = np.array([[[-0.06, -0.19, 0.0], [0.28, -0.19, 0.0], [0.28, 0.11, 0.0], [-0.06, 0.11, 0.0]]])
    axes.add_collection3d(Poly3DCollection(wall, facecolors="#eef2f5", edgecolors="#c3ced8", linewidths=0.6, clip_on=False))
    cells, faces, edges = [], [], []
    for surface in lattice["surfaces"]:
        wing, wake = (to_view(surface[key]) for key in ("corner_m", "wake_node_m"))
        rows = int(np.sum(wake[:, 0, 0] - wake[0, 0, 0] < WAKE_SHOWN_M))  # the last row, shed at the start, is very long
        strength = np.array(surface["wake_circulation_m2_s"])[: rows - 1].ravel()
        cells += [quads(wake[:rows]), quads(wing)]
        faces += [colours(norm(strength)), np.tile(to_rgba(WING), (len(cells[-1]), 1))]
        edges += [np.tile(to_rgba("#8d9aa6"), (len(strength), 1)), np.tile(to_rgba("#ffffff"), (len(cells[-1]), 1))]
    parts = (np.concatenate(part) for part in (cells, faces, edges))
    cells, faces, edges = parts
    net = Poly3DCollection(cells, facecolors=faces, edgecolors=edges, linewidths=0.25, clip_on=False, zorder=2)
    axes.add_collection3d(net)
    axes.set(xlim=(-0.06, 0.28), ylim=(-0.19, 0.11), zlim=(0, 0.31))
    axes.set_box_aspect((0.34, 0.30, 0.31), zoom=1.13)
    axes.set_proj_type("ortho")
    axes.computed_zorder = False  # the wall is drawn below everything else
    axes.view_init(elev=VIEW_DEG[0], azim=VIEW_DEG[1])
    axes.patch.set_alpha(0.0)
    axes.set_axis_off()
    axes.text2D(0.03, 0.86, f"{lattice['time_s']:.2f} s", transform=axes.transAxes, fontsize=11, color=INK)


def plot_views(result, lattices, path):
    """Draws figure 9: four 3-D views and the wing's axis."""
    strongest = max(np.abs(s["wake_circulation_m2_s"]).max() for lattice in lattices for s in lattice["surfaces"])
    norm, colours = TwoSlopeNorm(0.0, -strongest, strongest), plt.get_cmap("RdBu_r")
    figure = plt.figure(figsize=(12.0, 6.0))
    for index, lattice in enumerate(lattices):
        place = [0.31 * (index % 2), 0.50 - 0.41 * (index // 2), 0.31, 0.46]
        draw_view(figure.add_axes(place, projection="3d"), lattice, norm, colours)
    bar = figure.add_axes([0.1, 0.028, 0.4, 0.016])
    figure.colorbar(plt.cm.ScalarMappable(norm, colours), cax=bar, orientation="horizontal").outline.set_visible(False)
    bar.set_title("circulation of the wake's rings (m²/s); the wing is grey", fontsize=SMALL, loc="left")
    bar.tick_params(labelsize=SMALL)

    axes = figure.add_axes([0.70, 0.09, 0.285, 0.78])
    times = np.arange(0.0, PAPER_TIP_TIME_S + 1e-9, 0.02)
    shades = plt.get_cmap("YlGnBu")(np.linspace(0.3, 0.98, len(times)))
    axes.axvline(1e3 * PAPER_TIP_M, color=PAPER, linestyle=(0, (4, 3)), linewidth=1.0)
    for time_s, colour in zip(times, shades):
        x, z = 1e3 * shape(result, time_s)
        axes.plot(z, x, color=colour, linewidth=2.0, solid_capstyle="round")
        along = np.array([z[-1] - z[-2], x[-1] - x[-2]])
        along /= np.linalg.norm(along)
        if 0.01 < time_s < 0.19:  # the first two shapes end close to each other, and the last one is labelled separately
            axes.annotate(f"{time_s:.2f}", (z[-1], x[-1]), fontsize=SMALL, color=INK, xytext=14 * along, textcoords="offset points",
                          ha="center", va="center")
    z, x = (1e3 * result[f"tip.position.{axis}"][0] for axis in "zx")
    axes.annotate("0 s", (z, x), fontsize=SMALL, color=INK, xytext=(3, -13), textcoords="offset points")
    z_mm, x_mm = (1e3 * value_at(result, f"tip.position.{axis}", PAPER_TIP_TIME_S) for axis in "zx")
    axes.plot(z_mm, x_mm, "o", color=INK, markersize=4.5, zorder=5)
    axes.annotate(f"tip at 0.20 s:\n{z_mm:.1f} mm", (z_mm, x_mm), fontsize=SMALL, color=INK, xytext=(6, -24), textcoords="offset points")
    axes.annotate(f"the paper's text:\n{1e3 * PAPER_TIP_M:.0f} mm", (1e3 * PAPER_TIP_M, 120), fontsize=SMALL, color=PAPER,
                  xytext=(5, 0), textcoords="offset points")
    axes.set(xlabel="z (mm)", ylabel="x (mm)", title="Wing axis, every 0.02 s")
    axes.set_aspect("equal")
    axes.set(xlim=(-205, 140), ylim=(-25, 330))
    figure.text(0.015, 0.945, "Deployment in a wind of 10 m/s, with the wake", fontsize=13.5, color=INK, weight="bold")
    save(figure, path)


def value_at(result, name, time_s):
    """Value of a column at the nearest row."""
    return result[name][int(np.argmin(np.abs(result["time"] - time_s)))]


def plot_histories(runs, path):
    """Draws figures 10 and 11: fold angle and strain over time at three speeds."""
    figure, grid = plt.subplots(2, len(PAPER_LATCH_S), figsize=(12, 5.8), sharex=True, sharey="row", layout="constrained")
    for (upper, lower), (speed_m_s, paper_s) in zip(grid.T, PAPER_LATCH_S.items()):
        result, colour = runs[speed_m_s][0], COLOURS[speed_m_s]
        latch_s = latch_time(result)
        upper.plot(result["time"], np.degrees(result["fold.angle"]), color=colour)
        upper.plot(latch_s, 0.0, "o", color=colour, markersize=5)
        upper.annotate(f"ours, {latch_s:.4f} s", (latch_s, 0.0), xytext=(8, 12), textcoords="offset points", color=colour, fontsize=SMALL)
        mark(upper, paper_s, f"paper, {paper_s:.3f} s", PAPER, 0.97)
        air = "in air at rest; README's 0.1222 s is without air" if speed_m_s == 0 else f"wind of {speed_m_s} m/s"
        upper.set_title(air, fontsize=10.5)
        time_s, strain = peak(result)
        lower.plot(result["time"], 1e3 * result["gauge.root.strain"], color=colour, linewidth=1.1)
        lower.plot(time_s, 1e3 * strain, "o", color=colour, markersize=5)
        below = strain < 0
        lower.annotate(number(f"peak {1e3 * strain:.2f}·10⁻³\nat {time_s:.3f} s"), (time_s, 1e3 * strain), xytext=(0 if below else -12, -7 if below else 6),
                       textcoords="offset points", ha="center", va="top" if below else "bottom", color=colour, fontsize=SMALL)
        mark(lower, latch_s, "latch" if speed_m_s == 0 else "", colour, 0.97)
        lower.set(xlabel="time (s)", xlim=(0.0, 0.4))
    grid[0, 0].set(ylabel="fold angle (°)", yticks=np.arange(0, 181, 30))
    grid[1, 0].set(ylabel="strain at the root gauge (10⁻³)", ylim=(-7.0, 5.4))  # space for the label at the deepest peak
    save(figure, path)


def plot_speeds(runs, path):
    """Draws figure 12 and next to it the latch times."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(10.4, 4.0), layout="constrained")
    speeds = list(runs)
    times_s = [latch_time(runs[speed][0]) for speed in speeds]
    left.plot(speeds, times_s, "o-", color=BLUE, markersize=5)
    left.annotate("ours", (speeds[1], times_s[1]), xytext=(6, -11), textcoords="offset points", color=BLUE, fontsize=SMALL)
    left.errorbar(list(PAPER_LATCH_S), list(PAPER_LATCH_S.values()), yerr=[0.03 * value for value in PAPER_LATCH_S.values()],
                  fmt="D", color=PAPER, capsize=4, markersize=5)
    left.annotate("paper's simulation;\nbars: ± 3 %, what we allow", (10, PAPER_LATCH_S[10]), xytext=(-12, 22),
                  textcoords="offset points", ha="right", color=PAPER, fontsize=SMALL)
    left.set(xlabel="wind (m/s)", xticks=speeds, ylabel="latch time (s)", ylim=(0.1, 0.215))
    peaks = [1e3 * abs(peak(runs[speed][0])[1]) for speed in speeds]
    right.plot(speeds, peaks, "o-", color=BLUE, markersize=5)
    for speed, value in zip(speeds, peaks):
        right.annotate(f"{value:.2f}", (speed, value), xytext=(4, 6), textcoords="offset points", fontsize=SMALL, color=INK)
    right.set(xlabel="wind (m/s)", xticks=speeds, ylabel="maximum strain at the root (10⁻³)", ylim=(0.0, 6.2))
    save(figure, path)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--foldwing", type=Path, required=True, help="the command")
    parser.add_argument("--output", type=Path, required=True, help="folder of the pictures")
    parser.add_argument("--model", type=Path, default=ROOT / "examples/models/folding_wing_in_tunnel.toml")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        runs = {speed: simulate(arguments.foldwing.resolve(), arguments.model, Path(folder), speed) for speed in SPEEDS_M_S}
    use()
    arguments.output.mkdir(parents=True, exist_ok=True)
    plot_views(*runs[10], arguments.output / "tunnel_views.png")
    plot_histories(runs, arguments.output / "tunnel_histories.png")
    plot_speeds(runs, arguments.output / "tunnel_speeds.png")
    for speed, (result, _) in runs.items():
        print(f"{speed:2} m/s: latch at {latch_time(result):.4f} s, peak strain {abs(peak(result)[1]):.3e}, "
              f"tip at 0.2 s {1e3 * value_at(result, 'tip.position.z', PAPER_TIP_TIME_S):.1f} mm")


if __name__ == "__main__":
    main()
