"""Pictures of the aircraft that carries two FMUs, for aircraft_study.py."""

import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")  # files only, no display

import matplotlib.pyplot as plt
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "examples"))

from house_style import BLUE, FAINT, GREEN, GRID, SMALL, VERMILION, label_ends, mark, save, use  # noqa: E402


def draw_flight(result, shapes, gust_s, path):
    """Draws shapes from behind by time, fold angles and angular rates; the gust is shaded."""
    use()
    figure = plt.figure(figsize=(8.4, 7.0))
    grid = figure.add_gridspec(3, len(shapes), height_ratios=(1.2, 1, 1), left=0.09, right=0.88, top=0.9, bottom=0.07, hspace=0.42, wspace=0.12)
    for column, (time_s, points) in enumerate(shapes.items()):
        axes = figure.add_subplot(grid[0, column])
        axes.plot(1e3 * points[:, 0], 1e3 * points[:, 2], color=BLUE, linewidth=2.2, solid_capstyle="round")
        axes.plot(0, 0, "o", color=VERMILION, markersize=5)
        axes.set(aspect="equal", xlim=(-330, 330), ylim=(-330, 330), xticks=[-200, 0, 200], yticks=[-200, 0, 200])
        axes.tick_params(labelleft=column == 0)
        axes.set_title(f"{1e3 * time_s:.0f} ms", fontsize=SMALL)
        if column == 0:
            axes.set_ylabel("up (mm)")
        if column == len(shapes) // 2:
            axes.set_xlabel("to the right (mm)")
    upper, lower = (figure.add_subplot(grid[row, :]) for row in (1, 2))
    for side, color, at in (("right", BLUE, 0.97), ("left", GREEN, 0.97)):
        latch_ms = 1e3 * result[f"{side}.fold.latch_time"][-1]
        upper.plot(1e3 * result["time"], np.degrees(result[f"{side}.fold.angle"]), color=color, label=f"{side} wing")
        mark(upper, latch_ms, f"latched,\n{latch_ms:.1f} ms", color, at)
    upper.set_ylabel("fold angle (°)")
    for axis, name, color in (("y", "roll", BLUE), ("x", "pitch", VERMILION), ("z", "yaw", GREEN)):
        lower.plot(1e3 * result["time"], np.degrees(result[f"spin.{axis}"]), color=color, linewidth=1.2, label=name)
    lower.set(xlabel="time (ms)", ylabel="rate of the fuselage (°/s)")
    for axes in (upper, lower):
        axes.axvspan(*(1e3 * np.array(gust_s)), color=FAINT, alpha=0.16, linewidth=0)
        axes.set_xlim(0, 1e3 * result["time"][-1])
        label_ends(axes)
    lower.annotate("gust", (5e2 * (gust_s[0] + gust_s[1]), 0.97), xycoords=("data", "axes fraction"), ha="center", va="top", fontsize=SMALL, color=FAINT)
    figure.suptitle("A falling aircraft unfolds its right wing, 50 ms later its left one", x=0.09, ha="left")
    path.parent.mkdir(parents=True, exist_ok=True)
    save(figure, path)


def draw_convergence(steps_s, errors, drifts, path):
    """Draws the distance from the aircraft as one model over the step, by solver, and the loss of momentum by tolerance.

    The first solver is of first order, the second of second order.
    """
    use()
    figure, (left, right) = plt.subplots(1, 2, figsize=(9.6, 4.0), layout="constrained")
    steps_ms = 1e3 * np.array(steps_s)
    for (solver, found), order, color in zip(errors.items(), (1, 2), (GREEN, BLUE)):
        off = found[:, 0]
        left.loglog(steps_ms, off[-1] * (steps_ms / steps_ms[-1]) ** order, color=GRID, linewidth=5, zorder=0)
        left.loglog(steps_ms, off, "o-", color=color, markersize=4, label=f"{solver} (order {order} shaded)")
    left.set_xticks(steps_ms, [f"{step_ms:g}" for step_ms in steps_ms])
    left.set_xticks([], minor=True)
    left.set(
        xlabel="communication step (ms)", ylabel="position error of the fuselage (m)",
        title="Compared with the aircraft in one piece, at 90 ms"
    )
    tolerances = np.array(list(drifts))
    parts = np.array(list(drifts.values()))
    right.loglog(tolerances, parts[0, 0] * tolerances / tolerances[0], color=GRID, linewidth=5, zorder=0)
    for column, label, color in ((0, "linear (N·s)", BLUE), (1, "angular (N·m·s)", VERMILION)):
        right.loglog(tolerances, parts[:, column], "o-", color=color, markersize=4, label=label)
    right.set(
        xlabel="tolerance of the coupling (–)", ylabel="momentum lost (N·s, N·m·s)",
        title="Momentum error over the coupling tolerance"
    )
    for axes in (left, right):
        axes.legend()
    save(figure, path)
