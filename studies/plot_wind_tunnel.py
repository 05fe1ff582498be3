#!/usr/bin/env python3
"""Pictures of the wind tunnel study from its points.json: our results compared with the measurements and the other programs.

Usage: plot_wind_tunnel.py --points target/wind_tunnel/points.json --output docs/pictures

Writes wind_tunnel.png (the picture of the README: four wings), wind_tunnel_sideslip.png, wind_tunnel_pazy.png and wind_tunnel_hump.png.
"""

import argparse
import json
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "examples"))

from house_style import BLUE, FAINT, ORANGE, PURPLE, SKY, VERMILION, label_ends, save, use  # noqa: E402

UNCERTAINTY_DEG = 0.5  # of a digitised point, tests/reference/folding_wingtips/README.md
# colour, line, width and label; the lattice is wide, since strips with the lifting line often lie on it
OURS = {"lattice": (BLUE, "-", 3.2, "Foldwing, vortex lattice"), "line": (SKY, "-", 1.4, "Foldwing, strips with lifting line"),
        "strips": (SKY, ":", 1.6, "Foldwing, strips without lifting line")}


def find(series, case, air, quantity=None, source=None, variant=""):
    """The first series that matches this description."""
    for one in series:
        same = one["case"] == case and one["air"] == air and one["variant"] == variant
        if same and quantity in (None, one["quantity"]) and source in (None, one["source"]):
            return one
    return None


def panel(axes, series, case, title, x_label, y_label="fold angle, tip up (°)", airs=("lattice", "line", "strips"), other=None,
          quantity=None, source="experiment", variant="", band=True, uncertainty=UNCERTAINTY_DEG):
    """Draws the measured points, the results of the other program, and ours."""
    one = find(series, case, "lattice", quantity, source, variant)
    if band:
        near = [s for s in series if s["case"] == case and s["air"] == "lattice" and s["variant"] in ("tip 1 deg nose down", "tip 1 deg nose up")]
        if len(near) == 2:
            low, high = near
            axes.fill_between(low["x"], low["ours"], high["ours"], color=BLUE, alpha=0.12, linewidth=0, label="lattice, tip set ±1°")
    if other and (theirs := find(series, case, other[0], quantity, source)):
        axes.plot(theirs["x"], theirs["ours"], color=FAINT, linestyle="--", linewidth=1.4, label=other[1], zorder=4)
    for air in airs:
        ours = find(series, case, air, quantity, source, variant)
        if ours:
            colour, line, width, label = OURS[air]
            axes.plot(ours["x"], ours["ours"], color=colour, linestyle=line, linewidth=width, label=label)
    if stalling := find(series, case, "lattice", quantity, source, "published polar"):
        axes.plot(stalling["x"], stalling["ours"], color=BLUE, linestyle="--", linewidth=1.6, label="Foldwing, vortex lattice with the profile's polar")
    what = "measured" if source == "experiment" else source
    axes.errorbar(one["x"], one["theirs"], yerr=uncertainty, fmt="o", markersize=4, color=VERMILION, capsize=2, linewidth=1, label=what)
    axes.set_title(title)
    axes.set_xlabel(x_label)
    axes.set_ylabel(y_label)


def legend(figure, axes, columns):
    """Draws one legend below all panels, with each label once."""
    known = {}
    for one in axes:
        handles, labels = one.get_legend_handles_labels()
        for handle, label in zip(handles, labels):
            known.setdefault(label, handle)
    figure.legend(known.values(), known.keys(), loc="lower left", bbox_to_anchor=(0.01, 0.0), ncol=min(len(known), columns), frameon=False)


def front(series, output):
    figure, grid = plt.subplots(2, 2, figsize=(9.5, 7.4))
    axes = list(grid.flat)
    panel(axes[0], series, "LCO wing over speed, pitch 5", "LCO wing, flare 10°, pitch 5°", "airspeed (m/s)", other=("Healy's computation", "Healy's programs"))
    panel(axes[1], series, "LCO wing over speed, pitch 10", "LCO wing, flare 10°, pitch 10°", "airspeed (m/s)", other=("Healy's computation", "Healy's programs"))
    panel(axes[2], series, "sideslip wing over sideslip, twist 0", "sideslip wing, flare 20°, pitch 3°, 22 m/s", "sideslip (°)", other=("Healy's lattice", "Healy's programs"))
    panel(axes[3], series, "sideslip wing over speed, flare 20, pitch 10", "sideslip wing, flare 20°, pitch 10°", "airspeed (m/s)", other=("Healy's lattice", "Healy's programs"))
    figure.suptitle("Folding wing tips in the wind tunnel: equilibrium fold angles. Nothing is fitted.", x=0.01, ha="left", weight="bold")
    legend(figure, axes, 3)
    figure.tight_layout(rect=(0, 0.08, 1, 0.98))
    save(figure, output / "wind_tunnel.png")


def sideslip(series, output):
    """Draws a row for each flare and pitch, as built at the left, with the tip 2 deg nose down at the right."""
    figure, grid = plt.subplots(4, 2, figsize=(7.8, 11.6))
    for row, (flare, pitch) in enumerate(((20, 0), (20, 10), (10, 5), (30, 5))):
        case = f"sideslip wing over speed, flare {flare}, pitch {pitch}"
        for column, variant in enumerate(("", "tip 2 deg nose down")):
            title = f"flare {flare}°, pitch {pitch}°" + (", tip 2° nose down" if variant else "")
            panel(grid[row][column], series, case, title, "airspeed (m/s)", other=("Healy's lattice", "Healy's lattice"), variant=variant, band=False)
    legend(figure, list(grid.flat), 3)
    figure.tight_layout(rect=(0, 0.045, 1, 1), h_pad=1.6)
    save(figure, output / "wind_tunnel_sideslip.png")


def pazy(series, output):
    figure, grid = plt.subplots(2, 2, figsize=(7.8, 6.6))
    axes = list(grid.flat)
    deflection, twist = "deflection of the tip, % of the length", "twist of the tip, deg"  # names in the data
    percent, degrees = "deflection of the tip (% of the length)", "twist of the tip (°)"
    panel(axes[0], series, "Pazy wing, bending test", "bending test", "tip mass (kg)", percent, other=("UM/NAST", "UM/NAST"), quantity=deflection, airs=("lattice",), uncertainty=0.5)
    panel(axes[1], series, "Pazy wing, torsion test", "torsion test", "tip mass (kg)", degrees, other=("UM/NAST", "UM/NAST"), quantity=twist, airs=("lattice",), uncertainty=0.1)
    wind = "Pazy wing in the wind, pitch 5"
    panel(axes[2], series, wind, "in the wind, pitch 5°", "airspeed (m/s)", percent, quantity="tip_deflection_percent_of_span", uncertainty=0.5)
    theirs = find(series, wind, "lattice", "tip_deflection_percent_of_span", "UM/NAST")
    if theirs:
        axes[2].plot(theirs["x"], theirs["theirs"], color=FAINT, linestyle="--", linewidth=1.2, label="UM/NAST")
    panel(axes[3], series, wind, "in the wind, pitch 5°", "airspeed (m/s)", degrees, quantity="tip_twist_deg", uncertainty=0.1)
    legend(figure, axes, 3)
    figure.tight_layout(rect=(0, 0.08, 1, 1), h_pad=1.6)
    save(figure, output / "wind_tunnel_pazy.png")


def hump(series, output):
    """Draws the damping of the hump mode of the Pazy wing over the speed, for the range of its structural damping."""
    curves = [("line", "0.0", PURPLE, "-", "no damping"), ("line", "5e-05", ORANGE, "-", "5e-5 s"), ("line", "0.0001", SKY, "-", "1e-4 s, as in the file"),
              ("line", "0.0002", FAINT, "-", "2e-4 s"), ("lattice", "0.0001", BLUE, "none", "_")]
    figure, axes = plt.subplots(figsize=(8.2, 4.6))
    for air, damping, colour, line, label in curves:
        one = next((s for s in series if s["case"] == "Pazy wing, hump" and s["quantity"] == "damping ratio" and s["air"] == air and s["variant"] == damping), None)
        if one:
            percent = [100.0 * value for value in one["ours"]]
            axes.plot(one["x"], percent, color=colour, linestyle=line, marker="o" if air == "lattice" else "", markersize=4, label=label, zorder=3)
            if air == "lattice":
                axes.annotate("vortex lattice, 1e-4 s", (one["x"][0], percent[0]), xytext=(-8, -22), textcoords="offset points", ha="right", color=colour, fontsize=8.5)
    axes.axhline(0.0, color=FAINT, linewidth=1.0)
    axes.axvspan(43.0, 51.0, color=VERMILION, alpha=0.1, linewidth=0)
    axes.annotate("measured: limit cycle\nwith rising speed", (47.0, 0.97), xycoords=("data", "axes fraction"), va="top", ha="center", color=VERMILION, fontsize=8.5)
    axes.set_xlim(30.0, 60.0)
    axes.set_ylim(-2.0, 6.0)
    axes.set_xlabel("airspeed (m/s)")
    axes.set_ylabel("damping of the least damped mode from 16 to 40 Hz (%)")
    axes.set_title("Pazy wing at 5°: hump mode, by the stiffness-proportional structural damping")
    figure.tight_layout()
    figure.subplots_adjust(right=0.78)
    label_ends(axes)
    save(figure, output / "wind_tunnel_hump.png")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--points", type=Path, required=True)
    parser.add_argument("--output", type=Path, required=True)
    arguments = parser.parse_args()
    series = json.loads(arguments.points.read_text())
    arguments.output.mkdir(parents=True, exist_ok=True)
    use()
    front(series, arguments.output)
    sideslip(series, arguments.output)
    pazy(series, arguments.output)
    hump(series, arguments.output)


if __name__ == "__main__":
    main()
