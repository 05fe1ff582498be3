"""Pictures of the aircraft that carries two FMUs, for aircraft_study.py."""

import matplotlib

matplotlib.use("Agg")  # files only, no display

import matplotlib.pyplot as plt
import numpy as np

INK, RUST, SKY, PALE = "#0f3557", "#b3541e", "#4d8fc4", "#dfe6ec"


def draw_flight(result, shapes, gust_s, path):
    """Shapes from behind by time, fold angles and turning rates; the gust is shaded."""
    figure = plt.figure(figsize=(7.2, 6.2), dpi=150, layout="constrained")
    grid = figure.add_gridspec(3, len(shapes), height_ratios=(1.2, 1, 1))
    for column, (time_s, points) in enumerate(shapes.items()):
        axes = figure.add_subplot(grid[0, column])
        axes.plot(1e3 * points[:, 0], 1e3 * points[:, 2], color=INK, linewidth=1.8)
        axes.plot(0, 0, "o", color=RUST, markersize=5)
        axes.set(aspect="equal", xlim=(-330, 330), ylim=(-330, 330), xticks=[-200, 0, 200], yticks=[-200, 0, 200])
        axes.tick_params(labelsize=7, labelleft=column == 0)
        axes.set_title(f"{1e3 * time_s:.0f} ms", fontsize=9, color=INK)
        axes.grid(True, color=PALE, linewidth=0.7)
        if column == 0:
            axes.set_ylabel("up (mm)")
        if column == len(shapes) // 2:
            axes.set_xlabel("to the right (mm)", fontsize=9)
    upper, lower = (figure.add_subplot(grid[row, :]) for row in (1, 2))
    for side, color in (("right", INK), ("left", SKY)):
        upper.plot(1e3 * result["time"], np.degrees(result[f"{side}.fold.angle"]), color=color, label=f"{side} wing")
        upper.axvline(1e3 * result[f"{side}.fold.latch_time"][-1], color=RUST, linestyle="--", linewidth=1.0)
    upper.set_ylabel("fold angle (deg)")
    for axis, name, color in (("y", "roll", INK), ("x", "pitch", RUST), ("z", "yaw", SKY)):
        lower.plot(1e3 * result["time"], np.degrees(result[f"spin.{axis}"]), color=color, linewidth=1.2, label=name)
    lower.set(xlabel="time (ms)", ylabel="fuselage (deg/s)")
    for axes, place in ((upper, "upper right"), (lower, "upper left")):
        axes.axvspan(*(1e3 * np.array(gust_s)), color="#eef3f7", zorder=0)
        axes.set_xlim(0, 1e3 * result["time"][-1])
        axes.grid(True, color=PALE, linewidth=0.7)
        axes.spines[["top", "right"]].set_visible(False)
        axes.legend(frameon=False, loc=place)
    figure.suptitle("A falling aircraft unfolds its right wing, 50 ms later its left one", fontsize=11, color=INK)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, metadata={"Software": None})
    plt.close(figure)


def draw_convergence(steps_s, errors, drifts, path):
    """Distance from the aircraft in one piece over the step by solver, and momentum lost by tolerance.

    First solver: first order, second solver: second order.
    """
    figure, (left, right) = plt.subplots(1, 2, figsize=(7.2, 3.4), dpi=150, layout="constrained")
    steps_ms = 1e3 * np.array(steps_s)
    for (solver, found), order, color in zip(errors.items(), (1, 2), (SKY, INK)):
        off = found[:, 0]
        left.loglog(steps_ms, off[-1] * (steps_ms / steps_ms[-1]) ** order, color=PALE, linewidth=5, zorder=0)
        left.loglog(
            steps_ms, off, "o-", color=color, linewidth=1.2, markersize=4, label=f"{solver} (order {order} shaded)"
        )
    left.set_xticks(steps_ms, [f"{step_ms:g}" for step_ms in steps_ms])
    left.set_xticks([], minor=True)
    left.set(xlabel="communication step (ms)", ylabel="fuselage off its place (m)")
    left.set_title("Against the aircraft in one piece, at 90 ms", loc="left", fontsize=9, color=INK)
    tolerances = np.array(list(drifts))
    parts = np.array(list(drifts.values()))
    right.loglog(tolerances, parts[0, 0] * tolerances / tolerances[0], color=PALE, linewidth=5, zorder=0)
    for column, label, color in ((0, "linear (N·s)", INK), (1, "angular (N·m·s)", RUST)):
        right.loglog(tolerances, parts[:, column], "o-", color=color, linewidth=1.2, markersize=4, label=label)
    right.set(xlabel="coupling tolerance", ylabel="momentum lost to the tolerance")
    right.set_title("What the tolerance of the iteration costs", loc="left", fontsize=9, color=INK)
    for axes in (left, right):
        axes.grid(True, which="major", color=PALE, linewidth=0.7)
        axes.spines[["top", "right"]].set_visible(False)
        axes.legend(frameon=False, fontsize=8)
    figure.savefig(path, metadata={"Software": None})
    plt.close(figure)
