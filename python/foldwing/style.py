"""Figures in the style of `foldwing simulate --plot`: colours, sizes and display units.

Colours are those of Okabe and Ito, suitable for colour-blind readers. Angles are in degrees, strains in µm/m.
"""

from __future__ import annotations

from contextlib import contextmanager
from typing import Any, Dict, Iterator, List, Sequence, Tuple

import numpy as np
from numpy.typing import NDArray

from .errors import UsageError
from .optional import needed

PALETTE = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#3c3c3c")
"""Colours of the curves, in their order; further curves are dashed."""
INK, FAINT, GRID = "#1b2733", "#6e7a86", "#dee3e8"
_SMALL, _TEXT, _TITLE = 8.5, 9.5, 11.5
_UNITS: Dict[str, Tuple[str, float]] = {
    "rad": ("deg", 180.0 / np.pi),
    "rad/s": ("deg/s", 180.0 / np.pi),
    "rad/s2": ("deg/s²", 180.0 / np.pi),
    "N.m": ("N·m", 1.0),
    "m/s2": ("m/s²", 1.0),
    "1": ("1", 1.0),
    "": ("1", 1.0),
}
"""Units in figures and their factors, by the units of the variables; other units are unchanged."""
_STYLE: Dict[str, Any] = {
    "figure.dpi": 110,
    "font.family": ["DejaVu Sans"],
    "font.size": _TEXT,
    "text.color": INK,
    "axes.titlesize": _TITLE,
    "axes.titlelocation": "left",
    "axes.titlecolor": INK,
    "axes.labelsize": _TEXT,
    "axes.labelcolor": INK,
    "axes.edgecolor": FAINT,
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.formatter.use_mathtext": True,
    "grid.color": GRID,
    "grid.linewidth": 0.7,
    "xtick.color": INK,
    "ytick.color": INK,
    "xtick.labelsize": _SMALL,
    "ytick.labelsize": _SMALL,
    "lines.linewidth": 1.6,
    "legend.frameon": False,
    "legend.fontsize": _SMALL,
}
MAXIMUM_LABELS = 14
"""Maximum number of labelled curves in a panel."""


def shown(name: str, unit: str) -> Tuple[str, float]:
    """Unit of a variable in figures, and the factor from the unit of the variable.

    >>> shown("fold.angle", "rad")[0], shown("gauge.root.strain", "1"), shown("root.force.z", "N")
    ('deg', ('µm/m', 1000000.0), ('N', 1.0))
    """
    if name.startswith("gauge.") and name.endswith(".strain"):
        return "µm/m", 1e6
    return _UNITS.get(unit, (unit, 1.0))


@contextmanager
def style() -> Iterator[Any]:
    """Context with the style of figures; yields `matplotlib.pyplot`."""
    pyplot = needed("matplotlib.pyplot")
    cycle = needed("matplotlib").cycler(linestyle=["-", "--"]) * needed("matplotlib").cycler(color=PALETTE)
    with pyplot.rc_context({**_STYLE, "axes.prop_cycle": cycle}):
        yield pyplot


def panels(pyplot: Any, count: int, axes: Any, *, share: bool = True) -> Tuple[Any, List[Any]]:
    """A new figure with panels one below the other, or the given axes for each panel: one, or as many as there are panels."""
    if axes is not None:
        given = list(np.ravel(np.array(axes, dtype=object)))
        places = given * count if len(given) == 1 else given
        if len(places) != count:
            raise UsageError(f"axes: {len(given)} axes for {count} panels; give one for all, or {count}")
        return places[0].figure, places
    figure, grid = pyplot.subplots(
        max(1, count), sharex=share, squeeze=False, layout="constrained", figsize=(7.5, 1.2 + 2.2 * max(1, count))
    )
    return figure, list(grid[:, 0])


def curve(axes: Any, x: NDArray[np.float64], y: NDArray[np.float64], label: str, **keywords: Any) -> None:
    """Draw a curve, with its label in the same colour at its last finite value."""
    (line,) = axes.plot(x, y, label=label, **keywords)
    line.set_gid("curve")


def labelled(axes: Any) -> None:
    """Label every curve drawn by `curve` at its end, shifted apart if the ends are close; a legend if there are many."""
    lines = [line for line in axes.get_lines() if line.get_gid() == "curve" and np.isfinite(np.asarray(line.get_ydata(), float)).any()]
    if not 1 < len(lines) <= MAXIMUM_LABELS:
        return
    low, high = axes.get_ylim()
    height = axes.get_position().height * axes.figure.get_figheight() * 72.0
    apart = 1.3 * _SMALL / height
    ends = []
    for line in lines:
        y = np.asarray(line.get_ydata(), float)
        ends.append([float(np.clip((y[np.isfinite(y)][-1] - low) / (high - low), 0.0, 1.0)), line])
    ends.sort(key=lambda end: end[0])
    places = [end[0] for end in ends]
    for _ in range(200):
        for i in range(len(places) - 1):
            lack = apart - (places[i + 1] - places[i])
            if lack > 1e-6:
                places[i] -= lack / 2.0
                places[i + 1] += lack / 2.0
    for place, (_, line) in zip(places, ends):
        axes.annotate(
            line.get_label(), (1.0, place), xycoords="axes fraction", xytext=(5, 0), textcoords="offset points",
            va="center", ha="left", color=line.get_color(), fontsize=_SMALL, annotation_clip=False,
        )


def mark(axes: Any, x: float, text: str = "") -> None:
    """Draw a dashed vertical line, with a text at its top."""
    axes.axvline(x, color=FAINT, linestyle=(0, (4, 3)), linewidth=1.0, zorder=1)
    if text:
        axes.annotate(
            text, (x, 1.0), xycoords=("data", "axes fraction"), xytext=(3, 2), textcoords="offset points",
            va="bottom", ha="left", color=FAINT, fontsize=_SMALL,
        )


def quantity(members: Sequence[str], unit: str) -> str:
    """Label of an axis: the quantity that the variables have in common, and the unit.

    >>> quantity(["fold.angle"], "deg"), quantity(["left.angle", "right.angle"], "deg"), quantity(["a.x", "b.y"], "m")
    ('fold.angle (deg)', 'angle (deg)', '(m)')
    """
    if len(members) == 1:
        return f"{members[0]} ({unit})"
    last = {name.rsplit(".", 1)[-1] for name in members}
    if last <= {"x", "y", "z"}:
        last = {name.rsplit(".", 2)[-2] if name.count(".") > 1 else name.split(".")[0] for name in members}
    return f"{last.pop()} ({unit})" if len(last) == 1 else f"({unit})"


def heat_map(values: NDArray[np.float64], rows: Sequence[str], columns: Sequence[str], axes: Any = None) -> Any:
    """Draw relative sensitivities as a heat map, as in the figure of `foldwing gradient --plot`; the depth of a colour is the square
    root of the magnitude. Returns the figure."""
    with style() as pyplot:
        if axes is None:
            size = (3.5 + 1.4 * len(columns), 1.4 + 0.42 * len(rows))
            figure, axes = pyplot.subplots(layout="constrained", figsize=size)
        figure = axes.figure
        finite = np.abs(values[np.isfinite(values)])
        largest = float(finite.max(initial=0.0)) or 1.0
        colours = needed("matplotlib.colors")
        depth = colours.FuncNorm((lambda x: np.sign(x) * np.sqrt(np.abs(x)), lambda y: np.sign(y) * y**2), vmin=-largest, vmax=largest)
        between = colours.LinearSegmentedColormap.from_list("relative", [PALETTE[0], "white", PALETTE[1]]).with_extremes(bad=GRID)
        edges = (np.arange(len(columns) + 1) - 0.5, np.arange(len(rows) + 1) - 0.5)
        cells = axes.pcolormesh(*edges, np.ma.masked_invalid(values), norm=depth, cmap=between, edgecolors=GRID, linewidth=0.7)
        for (row, column), value in np.ndenumerate(values):
            dark = np.isfinite(value) and abs(value) > 0.5625 * largest
            text = f"{value:.2g}".replace("-", "\N{MINUS SIGN}") if np.isfinite(value) else "\N{EN DASH}"
            axes.text(column, row, text, ha="center", va="center", fontsize=_SMALL, color="white" if dark else INK)
        axes.set_xticks(range(len(columns)), columns)
        axes.set_yticks(range(len(rows)), rows)
        axes.invert_yaxis()
        axes.grid(False)
        axes.tick_params(length=0, top=True, labeltop=True, bottom=False, labelbottom=False)
        axes.spines[:].set_visible(False)
        scale = figure.colorbar(cells, ax=axes, ticks=[-largest, 0.0, largest], format="%.2g")
        scale.set_label("change in % for 1 %")
    return figure
