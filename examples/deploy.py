#!/usr/bin/env python3
"""Unfolds the wing: drives the FMU through FMPy, prints latch time and peak strain, writes CSV and plots.

Usage: deploy.py --fmu FoldingWing.fmu --output FOLDER [--tunnel folding_wing_in_tunnel.fmu]

The start values of the inputs release the wing and enable its latch, so nothing needs to be set. The plots show fold
angle, root strain, the path of the tip, and the shape of the wing over time. With `--tunnel`, an FMU with air, the same
at the flow speeds of the wind tunnel as well: its input `wind.velocity.y` gets another start value.
"""

import argparse
import csv
import re
from pathlib import Path

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
from fmpy import read_model_description, simulate_fmu

INK, LATCH, ACCENT = "#0f3557", "#b3541e", "#4d8fc4"
STYLE = {
    "figure.figsize": (7.2, 4.2),
    "figure.dpi": 150,
    "savefig.bbox": "tight",
    "font.size": 10,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#dfe6ec",
    "grid.linewidth": 0.7,
    "axes.axisbelow": True,
    "lines.linewidth": 1.6,
    "legend.frameon": False,
}
SHAPES = 12  # wing shapes drawn before the latch closes
SPEEDS_M_S = (0, 10, 20)  # flow speeds in the wind tunnel, along the chord


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--fmu", required=True, help="FMU of a folding wing with a joint `fold` and a gauge `root`")
    parser.add_argument("--tunnel", help="FMU of the same wing with air")
    parser.add_argument("--output", type=Path, required=True, help="folder for CSV and plots")
    arguments = parser.parse_args()
    matplotlib.use("Agg")  # files only, no display

    result = deploy(arguments.fmu)
    arguments.output.mkdir(parents=True, exist_ok=True)
    write_csv(result, arguments.output / "deployment.csv")
    plt.rcParams.update(STYLE)
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
    """All outputs over the default experiment, as FMPy's structured array."""
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
    """Writes every column with enough digits to read the same numbers back."""
    with open(path, "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(result.dtype.names)
        writer.writerows([[repr(value.item()) for value in row] for row in result])


def figure(xlabel, ylabel, title):
    """A figure with one labelled pair of axes."""
    fig, axes = plt.subplots()
    axes.set(xlabel=xlabel, ylabel=ylabel)
    axes.set_title(title, loc="left", fontsize=11, color=INK)
    return fig, axes


def mark_latch(axes, result):
    """A dashed line where the latch closes."""
    latch_s = latch_time(result)
    if latch_s is not None:
        axes.axvline(latch_s, color=LATCH, linestyle="--", linewidth=1.2, label=f"latch closes at {latch_s:.4f} s")


def save(fig, path):
    """Writes the figure; without the version text, so that equal results give equal files."""
    fig.savefig(path, metadata={"Software": None})
    plt.close(fig)


def plot_fold_angle(result, path):
    fig, axes = figure("time (s)", "fold angle (deg)", "Fold angle")
    axes.plot(result["time"], np.degrees(result["fold.angle"]), color=INK)
    mark_latch(axes, result)
    axes.set_xlim(result["time"][0], result["time"][-1])
    axes.set_yticks(np.arange(0, 181, 30))
    axes.legend()
    save(fig, path)


def plot_root_strain(result, path):
    fig, axes = figure("time (s)", "surface strain (10⁻³)", "Strain at the root gauge")
    axes.plot(result["time"], 1e3 * result["gauge.root.strain"], color=INK, linewidth=1.2)
    mark_latch(axes, result)
    time_s, strain = peak(result)
    axes.plot(time_s, 1e3 * strain, "o", color=ACCENT, label=f"peak {1e3 * strain:.2f}·10⁻³ at {time_s:.4f} s".replace("-", "−", 1))
    axes.set_xlim(result["time"][0], result["time"][-1])
    axes.legend()
    save(fig, path)


def plot_speeds(runs, path):
    """Fold angle and strain of several runs, by what the legend calls them."""
    fig, (upper, lower) = plt.subplots(2, 1, figsize=(7.2, 6.0), sharex=True)
    for (label, result), colour in zip(runs.items(), ("#b9c4cc", "#7a8b99", ACCENT, INK)):
        latch_s = latch_time(result)
        latch = "" if latch_s is None else f", latch at {latch_s:.4f} s"
        upper.plot(result["time"], np.degrees(result["fold.angle"]), color=colour, label=label + latch)
        strain = 1e3 * result["gauge.root.strain"]
        lower.plot(result["time"], strain, color=colour, linewidth=1.2, label=f"{label}, peak {np.abs(strain).max():.2f}·10⁻³")
    upper.set(ylabel="fold angle (deg)", yticks=np.arange(0, 181, 30))
    upper.set_title("Unfolding without air, in air at rest and in wind", loc="left", fontsize=11, color=INK)
    lower.set(xlabel="time (s)", ylabel="strain at the root gauge (10⁻³)", xlim=(0.0, result["time"][-1]))
    upper.legend()
    lower.legend(fontsize=8, loc="lower right")
    save(fig, path)


def plot_tip_path(result, path):
    fig, axes = figure("tip x (mm)", "tip z (mm)", "Path of the tip, root frame")
    x, z = (1e3 * result[f"tip.position.{axis}"] for axis in "xz")
    axes.plot(x, z, color="#9fb0bf", linewidth=0.9)
    points = axes.scatter(x, z, c=result["time"], s=7, cmap="viridis", zorder=3)
    fig.colorbar(points, ax=axes, label="time (s)", shrink=0.85)
    latch_s = latch_time(result)
    if latch_s is not None:
        at = [np.interp(latch_s, result["time"], axis) for axis in (x, z)]
        axes.plot(*at, "D", color=LATCH, markersize=6, zorder=4, label=f"latch closes at {latch_s:.4f} s")
        axes.legend()
    axes.set_aspect("equal", adjustable="datalim")
    save(fig, path)


def plot_shapes(result, path):
    fig, axes = figure("x (mm)", "z (mm)", "Shape of the wing axis, root frame")
    latch_s = latch_time(result) or float(result["time"][-1])
    times = np.concatenate([np.linspace(result["time"][0], latch_s, SHAPES), [peak(result)[0]]])
    colours = plt.get_cmap("viridis")(np.linspace(0.0, 0.92, SHAPES))
    for time_s, colour in zip(times, colours):
        x, z = 1e3 * shape(result, time_s)
        last = time_s == times[SHAPES - 1]
        axes.plot(x, z, color=LATCH if last else colour, linewidth=2.0 if last else 1.4,
                  label=f"{time_s:.4f} s" + (" (latch closes)" if last else ""))
    x, z = 1e3 * shape(result, times[-1])
    axes.plot(x, z, color=INK, linestyle="--", label=f"{times[-1]:.4f} s (largest root strain)")
    axes.plot(0, 0, "s", color=INK, markersize=7)
    axes.set_aspect("equal", adjustable="datalim")
    axes.legend(fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.5))
    save(fig, path)


def shape(result, time_s):
    """Wing axis in the x–z plane at the row nearest to a time: cubic curves through stations with their tangents.

    Stations stand at the centres of equal strips, so each body begins and ends half a strip beyond them.
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
