"""Common style of all figures, as in `foldwing simulate --plot`: colours, font sizes, labels at the curves.

Colours are those of Okabe and Ito, suitable for colour-blind readers, in the order of `--plot`. Curves are labelled at their
ends, in their colour; legends are used where that is not possible. Every axis is labelled with quantity and unit.
"""

import matplotlib.pyplot as plt
import numpy as np

BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY, BLACK = "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#3c3c3c"
PALETTE = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY, BLACK)
INK, FAINT, GRID = "#1b2733", "#6e7a86", "#dee3e8"
SMALL, TEXT, TITLE = 8.5, 9.5, 11.5  # in points, in all pictures
STYLE = {
    "figure.dpi": 130,
    "savefig.bbox": "tight",
    "savefig.pad_inches": 0.12,
    "font.family": "DejaVu Sans",
    "font.size": TEXT,
    "text.color": INK,
    "axes.titlesize": TITLE,
    "axes.titlelocation": "left",
    "axes.titlecolor": INK,
    "axes.labelsize": TEXT,
    "axes.labelcolor": INK,
    "axes.edgecolor": FAINT,
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.prop_cycle": plt.cycler(color=PALETTE),
    "axes.unicode_minus": True,
    "axes.formatter.use_mathtext": True,
    "grid.color": GRID,
    "grid.linewidth": 0.7,
    "xtick.color": INK,
    "ytick.color": INK,
    "xtick.labelsize": SMALL,
    "ytick.labelsize": SMALL,
    "lines.linewidth": 1.6,
    "legend.frameon": False,
    "legend.fontsize": SMALL,
    "figure.titlesize": TITLE + 1,
}


def use():
    """Apply the style to all following figures."""
    plt.rcParams.update(STYLE)


def number(text):
    """Format a number with a typographic minus sign."""
    return str(text).replace("-", "−")


def label_ends(axes):
    """Label every curve at its end, in its colour, without overlap: leave room at the right."""
    left, right = axes.get_xlim()
    axes.set_xlim(left, right)
    low, high = axes.get_ylim()
    logarithmic = axes.get_yscale() == "log"
    share = (lambda y: np.log(y / low) / np.log(high / low)) if logarithmic else (lambda y: (y - low) / (high - low))
    ends = []
    for line in axes.get_lines():
        if line.get_label().startswith("_") or not len(line.get_xdata()):
            continue
        x, y = (np.asarray(data, float) for data in line.get_data())
        seen = np.isfinite(x) & np.isfinite(y) & (x <= right + 1e-12)
        ends.append([float(np.clip(share(y[seen][-1]), 0.0, 1.0)), line])
    ends.sort(key=lambda end: end[0])
    box = axes.get_position()
    height = box.height * axes.figure.get_figheight() * 72.0  # in points
    apart = 1.25 * SMALL / height
    places = [end[0] for end in ends]
    lines = [1 + line.get_label().count("\n") for _, line in ends]
    for _ in range(200):  # shift neighbours apart until all fit
        for i in range(len(places) - 1):
            lack = 0.5 * (lines[i] + lines[i + 1]) * apart - (places[i + 1] - places[i])
            if lack > 1e-6:
                places[i] -= lack / 2
                places[i + 1] += lack / 2
    for place, (_, line) in zip(places, ends):
        axes.annotate(line.get_label(), (1.0, place), xycoords="axes fraction", xytext=(5, 0), textcoords="offset points",
                      va="center", ha="left", color=line.get_color(), fontsize=SMALL, annotation_clip=False)


def mark(axes, time_s, text, colour=FAINT, at=1.0):
    """Draw a dashed line at a time, labelled above the chart, or at a fraction of its height."""
    axes.axvline(time_s, color=colour, linestyle=(0, (4, 3)), linewidth=1.0, zorder=1)
    if text:
        axes.annotate(text, (time_s, at), xycoords=("data", "axes fraction"), xytext=(3, -2 if at < 1.0 else 2),
                      textcoords="offset points", va="top" if at < 1.0 else "bottom", ha="left", color=colour, fontsize=SMALL)


def save(figure, path):
    """Save the figure without version metadata, so that equal results give equal files."""
    figure.savefig(path, metadata={"Software": None})
    plt.close(figure)
