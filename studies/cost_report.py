"""Report of `compare_exudyn.py`: runs with cost and error, comparison with the targets, table and picture.

To draw the picture again from the CSV of all runs: cost_report.py target/compare_exudyn.csv docs/pictures/cost_against_error.png
"""
import csv
import datetime
import math
import os
import platform
import statistics
import sys
from dataclasses import dataclass, field
from importlib.metadata import version
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.ticker import NullFormatter

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "examples"))

from house_style import BLUE, FAINT, GREEN, INK, ORANGE, SMALL, VERMILION, save, use  # noqa: E402

METHOD_NAMES = {"esdirk4": "ESDIRK4", "esdirk3": "ESDIRK3", "tr_bdf2": "TR-BDF2", "generalized_alpha": "generalised-α"}
MARKERS = {"esdirk4": "o", "esdirk3": "s", "tr_bdf2": "^", "generalized_alpha": "D", "dense": "x", "sparse": "+"}
FAMILIES = {
    ("Foldwing", "linear"): (BLUE, "Foldwing, pairs"),
    ("Foldwing", "constant"): (GREEN, "Foldwing, constant elements"),
    ("Exudyn", "ge"): (VERMILION, "Exudyn, geometrically exact"),
    ("Exudyn", "cable"): (ORANGE, "Exudyn, ANCF cable"),
}
FRONTS = (
    'Fronts: no other setting of the family is cheaper and as sure. "Sure" is the largest first error of the setting and '
    "all finer ones; the last two columns are its own errors."
)


@dataclass
class Run:
    """One setting of one program: `step` is the step of Exudyn, or the longest step of Foldwing."""

    case: str
    program: str
    kind: str
    method: str
    elements: int
    step_s: float
    tolerance: float
    output_s: float
    measure: object
    label: str = ""
    times_s: list = field(default_factory=list)
    errors: dict = field(default_factory=dict)
    steps: int = 0
    gave_up: bool = False

    @property
    def cost_s(self):
        """Smallest processor time in s."""
        return min(self.times_s)

    def meets(self, limits):
        """Whether the errors in `limits` are within their limits."""
        return not self.gave_up and all(self.errors[name] <= limit for name, limit in limits.items())

    def family(self):
        """Settings that differ in mesh, step and tolerance only; dense and sparse algebra give the same result."""
        return (self.case, self.program, self.kind, self.method if self.program == "Foldwing" else "")

    def refines(self, other):
        """Whether both runs belong to one family and no discretisation parameter is coarser than in the other."""
        return (
            self.family() == other.family()
            and (self.program == "Exudyn" or self.output_s == other.output_s)
            and self.elements >= other.elements
            and self.step_s <= other.step_s
            and self.tolerance <= other.tolerance
        )

    def what(self):
        """The setting as text."""
        mesh = {"linear": "pair", "constant": "constant element", "ge": "exact element", "cable": "cable"}[self.kind]
        mesh = f"{self.elements} {mesh}{'s' if self.elements != 1 else ''}"
        if self.program == "Foldwing":
            return f"{mesh}, {METHOD_NAMES[self.method]}, {self.tolerance:.0e}, to {1e3 * self.step_s:g} ms"
        return f"{mesh}, {1e3 * self.step_s:g} ms, Newton {self.tolerance:.0e}, {self.method}"


def machine_state():
    """Processor, system, load and time of day."""
    model = platform.processor() or platform.machine()
    try:
        with open("/proc/cpuinfo") as file:
            model = next(line.partition(":")[2].strip() for line in file if line.startswith("model name"))
    except (OSError, StopIteration):
        pass
    load = f"{os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else "unknown"
    now = datetime.datetime.now(datetime.timezone.utc)
    return {"model": model, "cores": os.cpu_count(), "load": load, "time": now, "system": platform.system()}


def cheapest(runs, limits, reliable=True):
    """The cheapest run within the limits; with `reliable`, every finer run must meet them too, so that the result is not a coincidence."""
    good = [run for run in runs if run.meets(limits)]
    if reliable:
        bad = [run for run in runs if not run.meets(limits)]
        good = [run for run in good if not any(worse.refines(run) for worse in bad)]
    return min(good, key=lambda run: run.cost_s, default=None)


def sure_errors(runs, error):
    """For each completed run, the largest error of this run and all finer ones: the reliable error of its setting."""
    raw = [math.inf if run.gave_up else run.errors[error] for run in runs]
    sure = [max(value for finer, value in zip(runs, raw) if finer.refines(run)) for run in runs]
    return [(run, value) for run, value in zip(runs, sure) if not run.gave_up]


def front(runs, error):
    """Runs that no other run beats in both cost and reliable error, with this error, in order of decreasing error."""
    best, chosen = math.inf, []
    for run, value in sorted(sure_errors(runs, error), key=lambda pair: (pair[0].cost_s, pair[1])):
        if value < best:
            best = value
            chosen.append((run, value))
    return chosen


def select(runs, case, program, output_s=None, kinds=None):
    """Measured and failed runs of a case; Exudyn runs with finer outputs also count for coarser ones."""
    return [
        run
        for run in runs
        if run.case == case
        and run.program == program
        and (output_s is None or run.output_s == output_s or program == "Exudyn" and run.output_s <= output_s)
        and (kinds is None or run.kind in kinds)
    ]


def ms(seconds):
    """Time in ms with three digits."""
    return f"{1e3 * seconds:.3g}" if seconds < 1 else f"{1e3 * seconds:.0f}"


def comparison(name, theirs, ours, reach):
    """A row of the table: both runs, times, ratio, and whether the target ratio is reached."""
    if theirs is None or ours is None:
        missing = "Exudyn" if theirs is None else "Foldwing"
        return f"| {name} | no run of {missing} meets it | | | | ≥ {reach} | **no** |"
    ratio = theirs.cost_s / ours.cost_s
    verdict = "yes" if ratio >= reach else "**no**"
    left, right = f"{theirs.what()}: {ms(theirs.cost_s)}", f"{ours.label or ours.what()}: {ms(ours.cost_s)}"
    medians = f"{statistics.median(theirs.times_s) / statistics.median(ours.times_s):.0f}"
    return f"| {name} | {left} | {right} | **{ratio:.0f}** | {medians} | ≥ {reach} | {verdict} |"


def targets(runs):
    """Rows of the comparison with the targets."""
    limits = {"latch": 5e-3, "peak": 1e-2}
    theirs, ours = select(runs, "deployment", "Exudyn"), select(runs, "deployment", "Foldwing")
    shipped = [run for run in runs if run.case == "shipped"]
    # at Exudyn's output times
    pairs, constant = (run for run in shipped if run.output_s == ours[0].output_s)
    own_times = [run for run in shipped if run.output_s != ours[0].output_s]
    at_step = [run for run in theirs if run.step_s == 5e-5]
    # as the script for this design ran it
    paper_mesh = [run for run in at_step if run.elements == 15 and run.tolerance == 1e-6]
    for run in shipped:
        assert run.meets(limits), f"{run.label} misses latch time or peak strain: {run.errors}"
    rows = [
        comparison("deployment: Exudyn with 15 elements, 0.05 ms, Newton 1e-6; shipped model", cheapest(paper_mesh, limits),
                   pairs, 150),
        comparison("deployment: the paper's mesh, 15 elements here and there", cheapest(paper_mesh, limits), constant, 150),
        comparison("deployment: Exudyn at 0.05 ms, any mesh", cheapest(at_step, limits), cheapest(ours, limits), 150),
        comparison("deployment: cheapest of each, any step", cheapest(theirs, limits), cheapest(ours, limits), 150),
        comparison(
            "deployment: cheapest of each, any step, luck allowed",
            cheapest(theirs, limits, reliable=False),
            cheapest(ours, limits, reliable=False),
            150,
        ),
    ]
    for error, words in (("RMS", "RMS"), ("path", "path")):
        for output_s in (0.01, 0.04):
            left, right = select(runs, "two_body", "Exudyn", output_s), select(runs, "two_body", "Foldwing", output_s)
            name = f"two-body, {words} to 1e-3, outputs every {1e3 * output_s:g} ms"
            rows.append(comparison(name, cheapest(left, {error: 1e-3}), cheapest(right, {error: 1e-3}), 10))
    limits_ms = []
    for run, reach_ms in zip(own_times, (10, 40)):
        verdict = "yes" if 1e3 * run.cost_s <= reach_ms else "**no**"
        errors = f"latch {run.errors['latch']:.2%}, peak {run.errors['peak']:.2%}"
        median = ms(statistics.median(run.times_s))
        limits_ms.append(f"| `{run.label}.toml` | {ms(run.cost_s)} | {median} | {errors} | ≤ {reach_ms} | {verdict} |")
    return rows, limits_ms


def curve(runs, case, program, kind, errors, output_s):
    """Rows for the front of one family in its first error."""
    for run, sure in front(select(runs, case, program, output_s, (kind,)), errors[0]):
        figures = " | ".join(f"{run.errors[name]:.1e}" for name in errors)
        median = ms(statistics.median(run.times_s))
        yield (
            f"| {FAMILIES[program, kind][1]} | {run.what()} | {ms(run.cost_s)} | {median} | {run.steps} "
            f"| {1e6 * run.cost_s / run.steps:.1f} | {sure:.1e} | {figures} |"
        )


def write_table(runs, path, states, rounds, apart, deployment):
    """Writes the page and returns its text."""
    begin, end = states
    runs = [run for run in runs if run.gave_up or run.times_s]
    target_rows, limit_rows = targets(runs)
    ours, theirs = deployment["foldwing"], deployment["exudyn"]
    gave_up = sum(run.gave_up for run in runs)
    lines = [
        "# Cost over error: Foldwing and Exudyn",
        "",
        f"Written by `make bench-peers` (`studies/compare_exudyn.py`), {begin['time']:%Y-%m-%d %H:%M} UTC, on one core of "
        f"{begin['cores']} of an {begin['model']}, {begin['system']}; load of the machine {begin['load']} before, {end['load']} "
        f"after. Exudyn {version('exudyn')} and Foldwing in turn, one thread each, {len(runs)} settings, "
        f"up to {rounds} round{'s' if rounds > 1 else ''}.",
        "",
        "Cost is processor time of the solution alone in ms, the least of the rounds (median beside it): `SolveDynamic` there, "
        "initialisation, steps and rows of output here. Foldwing is three-dimensional, Exudyn's beams here are planar. Both "
        "write one to three outputs, at the same times. "
        "Foldwing's steps are accepted ones; tolerance and longest step are stated. Some settings are wasteful on either "
        f"side: that is what the fronts are for. {gave_up} settings gave up. Exudyn's knobs here: elements, step, tolerance of "
        "Newton's iteration, dense or sparse algebra. Its latch is a Python function before each step, a tenth of the cost of "
        "its cheaper runs.",
        "",
        "Errors are against each program's own converged solution of its own physics (Exudyn: geometrically exact with "
        "shear, or cables without rotary inertia; Foldwing: rotary inertia, no shear). These lie apart by "
        f"{apart['RMS']:.0e} in RMS and {apart['path']:.0e} in path on the two-body system; the wing latches at {ours[0]:.6f} s "
        f"(Exudyn {theirs[0]:.6f} s) with a peak of {1e3 * ours[1]:.4f}e-3 (Exudyn {1e3 * theirs[1]:.4f}e-3).",
        "",
        "## Targets",
        "",
        "Latch time within 0.5 % and peak strain within 1 %. A run counts if it meets the limits and so does every finer one "
        "that was tried (more elements, shorter steps, tighter tolerance): no strokes of luck, but where the row allows them.",
        "",
        "| what | Exudyn, ms | Foldwing, ms | ratio | of medians | reach | met |",
        "|---|---|---|---|---|---|---|",
        *target_rows,
        "",
        "| shipped model, own settings, outputs every 0.5 ms | least, ms | median, ms | errors | reach, ms | met |",
        "|---|---|---|---|---|---|",
        *limit_rows,
        "",
        "![cost against error](../pictures/cost_against_error.png)",
    ]
    head = "| | setting, per body | ms | median | steps | µs per step |"
    for title, case, errors, output_s, words in (
        ("Two-body system, 5 s, outputs every 10 ms", "two_body", ("RMS", "path"), 0.01, "error of RMS(Z) | of the path"),
        ("Deployment without air, 0.4 s, outputs every 0.8 ms", "deployment", ("latch", "peak"), None, "latch | peak"),
    ):
        lines += ["", f"## {title}", "", FRONTS]
        lines += ["", f"{head} sure | {words} |", "|---|---|---|---|---|---|---|---|---|"]
        for program, kind in FAMILIES:
            lines += curve(runs, case, program, kind, errors, output_s)
    text = "\n".join(lines) + "\n"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    return text


def write_runs(runs, path):
    """All runs as CSV."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", newline="") as file:
        table = csv.writer(file)
        names = ("RMS", "path", "latch", "peak")
        keys = ("case", "program", "kind", "method", "elements", "step_s", "tolerance", "output_s", "label", "steps", "gave_up")
        table.writerow([*keys, "least_s", "median_s", "times", *names])
        for run in runs:
            times = [run.cost_s, statistics.median(run.times_s), len(run.times_s)] if run.times_s else ["", "", 0]
            table.writerow([*(getattr(run, key) for key in keys), *times, *(run.errors.get(name, "") for name in names)])


def read_runs(path):
    """The runs of a CSV written by `write_runs`, to draw the picture again without new measurements."""
    runs = []
    with path.open(newline="") as file:
        for row in csv.DictReader(file):
            words = {name: row[name] for name in ("case", "program", "kind", "method", "label")}
            run = Run(**words, elements=int(row["elements"]), step_s=float(row["step_s"]), tolerance=float(row["tolerance"]),
                      output_s=float(row["output_s"]), measure=None)
            run.steps, run.gave_up = int(row["steps"]), row["gave_up"] == "True"
            run.times_s = [float(row["least_s"])] if row["least_s"] else []
            run.errors = {name: float(row[name]) for name in ("RMS", "path", "latch", "peak") if row[name]}
            runs.append(run)
    return runs


def draw(runs, path):
    """Draws cost over error: all runs as points, the fronts as lines."""
    use()
    figure, grid = plt.subplots(2, 2, figsize=(12.5, 8.6))
    figure.subplots_adjust(left=0.065, right=0.985, top=0.875, bottom=0.15, wspace=0.16, hspace=0.34)
    panels = (
        (grid[0, 0], "two_body", "RMS", 0.01, "Two-body system, 5 s: RMS(Z)", 1e-3),
        (grid[0, 1], "two_body", "path", 0.01, "Two-body system, 5 s: path of the free end", 1e-3),
        (grid[1, 0], "deployment", "latch", None, "Deployment, 0.4 s: latch time", 5e-3),
        (grid[1, 1], "deployment", "peak", None, "Deployment, 0.4 s: peak strain", 1e-2),
    )
    for axes, case, error, output_s, title, limit in panels:
        for (program, kind), (color, label) in FAMILIES.items():
            chosen = [run for run in select(runs, case, program, output_s, (kind,)) if run.times_s and not run.gave_up]
            if not chosen:
                continue
            for method in sorted({run.method for run in chosen}):
                part = [run for run in chosen if run.method == method]
                axes.plot(
                    [1e3 * run.cost_s for run in part], [run.errors[error] for run in part], MARKERS[method],
                    color=color, alpha=0.22, markersize=3.5, markeredgewidth=0.7, fillstyle="none",
                )
            best = front(select(runs, case, program, output_s, (kind,)), error)
            axes.plot([1e3 * run.cost_s for run, _ in best], [sure for _, sure in best], "-", color=color, label=label)
            for run, sure in best:
                axes.plot(1e3 * run.cost_s, sure, MARKERS[run.method], color=color, markersize=5)
        axes.axhline(limit, color=FAINT, linewidth=1.0, linestyle=(0, (4, 3)))
        axes.annotate("target", (1.0, limit), xycoords=("axes fraction", "data"), xytext=(0, 2), textcoords="offset points", ha="right",
                      va="bottom", color=FAINT, fontsize=SMALL)
        axes.set(xscale="log", yscale="log", title=title, xlabel="processor time (ms)", ylabel="relative error (–)")
        axes.xaxis.set_minor_formatter(NullFormatter())
        axes.set_ylim(bottom=max(1e-6, axes.get_ylim()[0]))
    names = {**METHOD_NAMES, "dense": "generalised-α, dense (Exudyn)", "sparse": "generalised-α, sparse (Exudyn)"}
    lines = [plt.Line2D([], [], color=color, label=label) for color, label in FAMILIES.values()]
    marks = [plt.Line2D([], [], color=INK, linestyle="", marker=MARKERS[method], markersize=5, label=name) for method, name in names.items()]
    figure.legend(handles=lines, loc="lower left", bbox_to_anchor=(0.05, 0.045), ncols=4)
    figure.legend(handles=marks, loc="lower left", bbox_to_anchor=(0.05, 0.01), ncols=6)
    figure.text(0.015, 0.955, "Cost against error: Foldwing and Exudyn", fontsize=13.5, color=INK, weight="bold")
    words = "lines: the cheapest setting for each error that it and all finer ones keep; pale: every setting tried"
    figure.text(0.015, 0.925, words, fontsize=SMALL + 0.5, color=FAINT)
    path.parent.mkdir(parents=True, exist_ok=True)
    save(figure, path)


if __name__ == "__main__":
    draw(read_runs(Path(sys.argv[1])), Path(sys.argv[2]))
