#!/usr/bin/env python3
"""Deployment of the wing: simulates the FMU with FMPy, prints latch time and peak strain, writes CSV and plots.

Usage: deploy.py --fmu FoldingWing.fmu --output FOLDER [--tunnel folding_wing_in_tunnel.fmu]

By default the wing is released and its latch enabled, so no inputs need to be set. The plots show fold angle, root
strain, the path of the tip, and the shape of the wing over time. With `--tunnel` (an FMU with aerodynamics) the
deployment is also simulated at the flow speeds of the wind tunnel, set by the start value of `wind.velocity.y`.
"""

import argparse
import csv
import re
from pathlib import Path

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
from fmpy import read_model_description, simulate_fmu
from house_style import BLACK, BLUE, FAINT, INK, SKY, SMALL, STYLE, VERMILION, label_ends, mark, number, save, use

LATCH, ACCENT = VERMILION, BLUE
SHAPES = 12  # wing shapes drawn before the latch closes
SPEEDS_M_S = (0, 10, 20)  # flow speeds in the wind tunnel, along the chord


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--fmu", required=True, help="FMU of a folding wing with a joint `fold` and a gauge `root`")
    parser.add_argument("--tunnel", help="FMU of the same wing with aerodynamics")
    parser.add_argument("--output", type=Path, required=True, help="folder for CSV and plots")
    arguments = parser.parse_args()
    matplotlib.use("Agg")  # files only, no display

    result = deploy(arguments.fmu)
    arguments.output.mkdir(parents=True, exist_ok=True)
    write_csv(result, arguments.output / "deployment.csv")
    use()
    plot_fold_angle(result, arguments.output / "fold_angle.png")
    plot_root_strain(result, arguments.output / "root_strain.png")
    plot_tip_path(result, arguments.output / "tip_path.png")
    plot_shapes(result, arguments.output / "wing_shapes.png")

    time_s, strain = peak(result)
    latch_s = latch_time(result)
    print(f"fold.latch_time   {'did not latch' if latch_s is None else f'{latch_s:.4f} s'} without air")
    print(f"peak root strain  {abs(strain):.3e} (gauge.root.strain = {strain:.3e} at {time_s:.4f} s)")
    if arguments.tunnel:
        runs = {"without air": result}
        for speed_m_s in SPEEDS_M_S:
            label = f"at {speed_m_s} m/s" if speed_m_s else "in air at rest"
            runs[label] = in_wind = deploy(arguments.tunnel, {"wind.velocity.y": -float(speed_m_s)})
            latch_s, strain = latch_time(in_wind), abs(peak(in_wind)[1])
            latch = "does not latch" if latch_s is None else f"latches at {latch_s:.4f} s"
            print(f"{label:<17} {latch}, peak root strain {strain:.3e}")
        plot_speeds(runs, arguments.output / "flow_speeds.png")
    print(f"CSV and plots     {arguments.output}")


def deploy(fmu, start_values=None):
    """Simulate the run of the model's settings; returns all outputs as FMPy's structured array."""
    outputs = [v.name for v in read_model_description(str(fmu)).modelVariables if v.causality == "output"]
    return simulate_fmu(str(fmu), output=outputs, start_values=start_values or {})


def latch_time(result):
    """Time of the first closing of the latch in s, or None."""
    closed = result["fold.latch_time"][result["fold.latch_count"] > 0]
    return float(closed[0]) if closed.size else None


def peak(result):
    """Time in s and value of the root strain of largest magnitude."""
    row = int(np.argmax(np.abs(result["gauge.root.strain"])))
    return float(result["time"][row]), float(result["gauge.root.strain"][row])


def write_csv(result, path):
    """Write all columns with round-trip precision."""
    with open(path, "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(result.dtype.names)
        writer.writerows([[repr(value.item()) for value in row] for row in result])


def figure(xlabel, ylabel, title):
    """Figure with labelled axes."""
    fig, axes = plt.subplots(figsize=(7.2, 4.2), layout="constrained")
    axes.set(xlabel=xlabel, ylabel=ylabel, title=title)
    return fig, axes


def mark_latch(axes, result, at=1.0):
    """Mark the latch time with a dashed line."""
    latch_s = latch_time(result)
    if latch_s is not None:
        mark(axes, latch_s, f"latch closes, {latch_s:.4f} s", LATCH, at)


def plot_fold_angle(result, path):
    fig, axes = figure("time (s)", "fold angle (°)", "Fold angle\n")
    axes.plot(result["time"], np.degrees(result["fold.angle"]), color=BLUE)
    mark_latch(axes, result)
    axes.set_xlim(result["time"][0], result["time"][-1])
    axes.set_yticks(np.arange(0, 181, 30))
    save(fig, path)


def plot_root_strain(result, path):
    fig, axes = figure("time (s)", "surface strain (10⁻³)", "Strain at the root gauge\n")
    axes.plot(result["time"], 1e3 * result["gauge.root.strain"], color=BLUE, linewidth=1.2)
    mark_latch(axes, result)
    name_peak(axes, result)
    axes.set_xlim(result["time"][0], result["time"][-1])
    save(fig, path)


def name_peak(axes, result):
    """Mark the peak strain with a dot and its value."""
    time_s, strain = peak(result)
    axes.plot(time_s, 1e3 * strain, "o", color=VERMILION, markersize=5)
    axes.annotate(number(f"{1e3 * strain:.2f}·10⁻³ at {time_s:.4f} s"), (time_s, 1e3 * strain), xytext=(8, -1),
                  textcoords="offset points", va="center", color=VERMILION, fontsize=SMALL)


def plot_speeds(runs, path):
    """Plot fold angle and strain of several runs, labelled at their ends."""
    fig, (upper, lower) = plt.subplots(2, 1, figsize=(7.8, 6.4), sharex=True)
    fig.subplots_adjust(left=0.09, right=0.76, top=0.93, bottom=0.09, hspace=0.12)
    for (label, result), colour in zip(runs.items(), (BLACK, SKY, BLUE, VERMILION)):
        latch_s = latch_time(result)
        latch = "no latch" if latch_s is None else f"latch {latch_s:.4f} s"
        upper.plot(result["time"], np.degrees(result["fold.angle"]), color=colour, label=f"{label}: {latch}")
        strain = 1e3 * result["gauge.root.strain"]
        lower.plot(result["time"], strain, color=colour, linewidth=1.2, label=f"{label}: peak {np.abs(strain).max():.2f}")
    upper.set(ylabel="fold angle (°)", yticks=np.arange(0, 181, 30), title="Unfolding without air, in air at rest and in wind")
    lower.set(xlabel="time (s)", ylabel="strain at the root gauge (10⁻³)", xlim=(0.0, result["time"][-1]))
    label_ends(upper)
    label_ends(lower)
    save(fig, path)


def plot_tip_path(result, path):
    fig, axes = figure("tip x (mm)", "tip z (mm)", "Path of the tip, root frame")
    x, z = (1e3 * result[f"tip.position.{axis}"] for axis in "xz")
    axes.plot(x, z, color=FAINT, linewidth=0.9)
    points = axes.scatter(x, z, c=result["time"], s=7, cmap="viridis", zorder=3)
    fig.colorbar(points, ax=axes, label="time (s)", shrink=0.85)
    latch_s = latch_time(result)
    if latch_s is not None:
        at = [np.interp(latch_s, result["time"], axis) for axis in (x, z)]
        axes.plot(*at, "D", color=LATCH, markersize=6, zorder=4)
        axes.annotate(f"latch closes, {latch_s:.4f} s", at, xytext=(9, -3), textcoords="offset points", color=LATCH, fontsize=SMALL)
    axes.set_aspect("equal", adjustable="datalim")
    save(fig, path)


def plot_shapes(result, path):
    """Plot snapshots of the wing shape, and fold angle and strain over the same time."""
    fig = plt.figure(figsize=(10.4, 5.2))
    axes = fig.add_axes([0.0, 0.0, 0.64, 0.92])
    upper, lower = fig.add_axes([0.69, 0.56, 0.29, 0.31]), fig.add_axes([0.69, 0.115, 0.29, 0.31])
    latch_s = latch_time(result) or float(result["time"][-1])
    peak_s = peak(result)[0]
    times = np.linspace(result["time"][0], latch_s, SHAPES)
    colours = plt.get_cmap("YlGnBu")(np.linspace(0.28, 0.95, SHAPES))
    x, z = (1e3 * result[f"tip.position.{axis}"] for axis in "xz")
    seen = result["time"] <= peak_s
    axes.plot(x[seen], z[seen], color=FAINT, linewidth=0.8, linestyle=(0, (1, 2.5)), zorder=1)
    for index, (time_s, colour) in enumerate(zip(times, colours)):
        last = index == SHAPES - 1
        draw_wing(axes, result, time_s, LATCH if last else colour, 4.0 if last else 2.8, 3 + index)
        words = f"{1e3 * time_s:.1f} ms" + ("\nlatch closes" if last else "")
        if index == 0:
            words += "\nfolded by 170°"
        if index != 1:  # it coincides with the first one
            name_tip(axes, result, time_s, words, LATCH if last else FAINT if index < 3 else colour)
    draw_wing(axes, result, peak_s, INK, 4.0, 2)
    name_tip(axes, result, peak_s, f"{1e3 * peak_s:.1f} ms\nlargest strain", INK)
    axes.add_patch(plt.Rectangle((-12, -17), 10, 34, facecolor="#d5dbe1", edgecolor="none", zorder=0))
    axes.plot([-2, -2], [-17, 17], color=FAINT, linewidth=1.2)
    axes.plot([-95, 5], [-182, -182], color=INK, linewidth=1.6, solid_capstyle="butt")
    axes.text(-45, -179, "100 mm", ha="center", va="bottom", fontsize=SMALL)
    axes.set(xlim=(-110, 360), ylim=(-195, 160))
    axes.set_aspect("equal")
    axes.set_anchor("W")
    axes.set_axis_off()
    fig.text(0.015, 0.945, "Deployment of a folding wing: unfolding, latching, overshoot", fontsize=13.5, color=INK, weight="bold")
    fig.text(0.015, 0.905, "two flexible plates of 150 mm, one fold with motor and latch, in gravity; axis true to scale", fontsize=SMALL, color=FAINT)

    upper.plot(result["time"], np.degrees(result["fold.angle"]), color=BLUE)
    upper.set(title="fold angle (°)", yticks=(0, 90, 180), ylim=(-12, 185), xticklabels=[])
    mark_latch(upper, result, 0.97)
    lower.plot(result["time"], 1e3 * result["gauge.root.strain"], color=BLUE, linewidth=1.2)
    lower.set(title="strain at the root (10⁻³)", xlabel="time (s)")
    mark(lower, latch_s, "", LATCH)
    name_peak(lower, result)
    for chart in (upper, lower):
        chart.set_xlim(result["time"][0], result["time"][-1])
        chart.title.set_fontsize(10)
    save(fig, path)


def draw_wing(axes, result, time_s, colour, width, order):
    """Draw the axis of the wing with its fold joint."""
    row = int(np.argmin(np.abs(result["time"] - time_s)))
    pieces = [1e3 * body_curve(result, row, body, count) for body, count in station_counts(result)]
    for x, z in pieces:
        axes.plot(x, z, color=colour, linewidth=width, solid_capstyle="round", zorder=order)
    for x, z in pieces[:-1]:
        axes.plot(x[-1], z[-1], "o", color="white", markeredgecolor=colour, markersize=0.9 * width + 1.2, zorder=order)


def name_tip(axes, result, time_s, words, colour):
    """Label beyond the tip, in the direction of the wing's end."""
    x, z = 1e3 * shape(result, time_s)
    along = np.array([x[-1] - x[-2], z[-1] - z[-2]])
    along /= np.linalg.norm(along)
    ha = "left" if along[0] > 0.25 else "right" if along[0] < -0.25 else "center"
    va = "bottom" if along[1] > 0.6 else "top" if along[1] < -0.6 else "center"
    axes.annotate(words, (x[-1], z[-1]), xytext=7 * along, textcoords="offset points", ha=ha, va=va, color=colour, fontsize=SMALL)


def shape(result, time_s):
    """Wing axis in the x–z plane at the row nearest to a time: cubic curves through stations with their tangents.

    Stations are at the centres of equal segments, so each body extends half a segment beyond them.
    """
    row = int(np.argmin(np.abs(result["time"] - time_s)))
    curves = [body_curve(result, row, body, count) for body, count in station_counts(result)]
    return np.concatenate(curves, axis=1)


def station_counts(result):
    """Names of the bodies in the order of the outputs, with their numbers of stations."""
    pattern = re.compile(r"station\.(\w+)\[(\d+)\]\.position\.x")
    counts = {}
    for name in result.dtype.names:
        match = pattern.fullmatch(name)
        if match:
            counts[match[1]] = int(match[2])
    return counts.items()


def body_curve(result, row, body, count):
    """One body: extrapolated along the tangent to its ends, cubic Hermite curves between stations."""
    stations = [f"station.{body}[{i + 1}]" for i in range(count)]
    points = np.array([[result[f"{s}.position.{axis}"][row] for axis in "xz"] for s in stations])
    tangents = np.array([tangent(result, row, s) for s in stations])
    spacing = np.linalg.norm(np.diff(points, axis=0), axis=1).mean() if count > 1 else np.linalg.norm(points[0])
    pieces = [[points[0] - 0.5 * spacing * tangents[0]]]
    share = np.linspace(0.0, 1.0, 12)[:, None]
    for a, b, u, v in zip(points, points[1:], tangents, tangents[1:]):
        cubic = (1 + 2 * share) * (1 - share) ** 2 * a + share**2 * (3 - 2 * share) * b
        pieces.append(cubic + spacing * share * (1 - share) * ((1 - share) * u - share * v))
    pieces.append([points[-1] + 0.5 * spacing * tangents[-1]])
    return np.concatenate(pieces).T


def tangent(result, row, station):
    """Beam axis of a station in the x–z plane, from its quaternion root ← section."""
    w, x, y, z = (result[f"{station}.rotation.{part}"][row] for part in "wxyz")
    return np.array([1 - 2 * (y * y + z * z), 2 * (x * z - w * y)])


if __name__ == "__main__":
    main()
