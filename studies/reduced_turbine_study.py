#!/usr/bin/env python3
"""The reduced turbine of the paper compared with the full one: its errors, and the terms that cause them.

Usage: reduced_turbine_study.py --foldwing target/release/foldwing [--output DIR] [--table OUT.md]

The full turbine is `examples/turbine/nrel_5mw_wind.toml` with locked pitch and AeroDyn's conventions, as in the comparison with
OpenFAST. Each term that the reduced model omits is an edit of its text; all edits together give `nrel_5mw_reduced.toml`, which is
checked. Then each term is added alone to the reduced model, and removed alone from the full one.
"""

import argparse
import csv
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
FOLDER = ROOT / "examples/turbine"
WHOLE, REDUCED = FOLDER / "nrel_5mw_wind.toml", FOLDER / "nrel_5mw_reduced.toml"
UP = "mount_rotation_deg = [127.27922061357854, 0.0, 127.27922061357854]"  # x up, z downwind
STEADY_S = 30.0  # by then the transient of the initially straight blades has decayed to the steady oscillation, except the tower side-side
KICKED_S, WINDOW_S = 15.0, 9.0  # all but the side-side oscillation has decayed after the kick; three periods

SIDE = "tower side-side"
# the compared quantities, with factors: in the frames of blades and tower, y points to the left when looking downwind, with blade 1 up
QUANTITIES = {
    "tip out of plane, m": ("body.blade1.deflection.z", 1.0),
    "tip in plane, m": ("body.blade1.deflection.y", -1.0),
    "tower fore-aft, m": ("body.tower.deflection.z", 1.0),
    f"{SIDE}, m": ("body.tower.deflection.y", -1.0),
    "thrust, kN": ("rotor.thrust", 1e-3),
    "torque, kN m": ("rotor.torque", 1e-3),
    "blade root moment out of plane, kN m": ("body.blade1.root_moment.y", 1e-3),
    "tower base moment fore-aft, kN m": ("base.reaction_moment.y", -1e-3),
}


def replaced(text, pattern, by, count=1):
    """The text after an edit whose pattern must be found."""
    text, found = re.subn(pattern, lambda match: match.expand(by), text, flags=re.M | re.S)
    if found != count:
        raise SystemExit(f"{pattern!r} found {found} times")
    return text


def in_body(text, body, line):
    """The text with one more line in a modal body."""
    return replaced(text, rf"^\[modal_body\.{body}\]\n", rf"\g<0>{line}\n")


def without_tower_rotation(text):
    return in_body(text, "tower", "section_rotation = false")


def without_blade_rotation(text):
    return in_body(text, "blade", "section_rotation = false")


def without_shortening(text):
    for body in ("tower", "blade"):
        text = in_body(text, body, "axial_shortening = false")
    return text


def on_the_axis(text):
    """The text with all masses on the tower's axis."""
    text = replaced(text, r"^centre_of_mass_m = .*?$", "centre_of_mass_m = [0.0, 0.0, 0.0]")
    return replaced(text, r"^position_m = \[-5\.0[^,]*,", "position_m = [0.0,")


def without_tilt_and_cone(text):
    text = replaced(text, r"^rotation_deg = \[0\.0, 5\.0, 0\.0\]$", "rotation_deg = [0.0, 0.0, 0.0]")
    text = replaced(text, r"^parent_offset_m = \[-0\.065.*?$", "parent_offset_m = [0.0, 0.0, 1.5]")
    text = replaced(text, r"^axis = \[0\.0436.*?$", "axis = [0.0, 0.0, -1.0]")
    return replaced(text, r"^mount_rotation_deg = \[124\.47.*?$", UP)


def without_yaw(text):
    by = rf'[joint.yaw]\ntype = "clamped"\nparent = "tower"\nchild = "nacelle"\n{UP}\n\n'
    return replaced(text, r"^\[joint\.yaw\].*?(?=^# The shaft's end)", by)


def at_constant_speed(text):
    """The text without generator and drive train: the shaft keeps its initial speed."""
    text = replaced(text, r"^\[joint\.shaft\.motor\].*?(?=^\[rigid_body\.hub\])", "")
    text = replaced(text, r"^start_rate_deg_s = 72\.6.*?$", 'motion = "prescribed"\npolynomial_deg = [0.0, 72.6]')
    text = replaced(text, r"^\[joint\.drive_train\.spring\].*?(?=^# Blade: x)", "")
    return replaced(text, r'(^\[joint\.drive_train\]\n)type = "revolute"(.*?)^axis = [^\n]*\n', r'\1type = "clamped"\2')


def first_shapes_alone(text):
    for shape in (r"\[-70\.53", r"\[-121\.21", r"\[-0\.5809"):
        text = replaced(text, rf"^ *{shape}.*?$", "")
    text = replaced(text, r"_damping_ratios = \[0\.01, 0\.01\]", "_damping_ratios = [0.01]", 2)
    return replaced(text, r"= \[0\.00477465, 0\.00477465\]", "= [0.00477465]")


def without_twist(text):
    return replaced(text, r"^twist_deg = \[.*?^\]\n", "")


TERMS = {
    "tower top turns with the slope of the tower": without_tower_rotation,
    "generator and drive train: speed free": at_constant_speed,
    "sections of the blades turn": without_blade_rotation,
    "axial shortening": without_shortening,
    "masses where they are": on_the_axis,
    "tilt and cone": without_tilt_and_cone,
    "yaw": without_yaw,
    "second shapes": first_shapes_alone,
    "structural twist": without_twist,
}
TOGETHER = {"the first two": set(list(TERMS)[:2]), "the first three": set(list(TERMS)[:3])}


def whole():
    """The full turbine as it is compared with OpenFAST: locked pitch, AeroDyn's conventions."""
    text = WHOLE.read_text(encoding="utf-8")
    text = replaced(text, r"^\[joint\.pitch\.motor\].*?(?=^# The air)", "")
    text = replaced(text, r"(^\[joint\.pitch\]\n.*?)(?=^# The deck)", r'\1motion = "locked"\n\n')
    return replaced(text, r'^model = "bem"$', 'model = "bem"\nend_loads = "full_induction"\naerodyn_compatible = true')


def with_terms(terms):
    """The turbine's text with some of the terms."""
    text = whole()
    for name, leave_out in TERMS.items():
        if name not in terms:
            text = leave_out(text)
    return text


def run(foldwing, text):
    """Runs a model text; returns histories by name."""
    text = text.replace('"polars/', f'"{FOLDER.as_posix()}/polars/')
    with tempfile.TemporaryDirectory() as folder:
        model, rows = Path(folder) / "turbine.toml", Path(folder) / "turbine.csv"
        model.write_text(text, encoding="utf-8")
        done = subprocess.run([str(foldwing), "simulate", str(model), "--csv", str(rows)], capture_output=True, text=True, check=False)
        if done.returncode:
            raise SystemExit(done.stderr)
        with open(rows, encoding="utf-8") as file:
            read = csv.reader(file)
            names = next(read)
            wanted = ["time", "energy.total", "energy.work", "energy.dissipated", *(column for column, _ in QUANTITIES.values())]
            columns = [names.index(name) for name in wanted]
            table = np.array([[float(row[column]) for column in columns] for row in read])
    histories = dict(zip(wanted, table.T))
    for name, (column, factor) in QUANTITIES.items():
        histories[name] = factor * histories[column]
    return histories


def run_twice(foldwing, text):
    """Histories, with frequency, damping ratio and scatter of the fit of the side-side oscillation."""
    histories = run(foldwing, text)
    histories["swing"] = swing(histories, run(foldwing, kicked(text)))
    return histories


def kicked(text):
    """The turbine with its tower deflected sideways at the start; damping is determined from the difference from the run without this
    deflection."""
    shapes = 2 if "-121.21" in text else 1
    return in_body(text, "tower", f"edge_start_m = [{', '.join(['0.02', '0.0'][:shapes])}]")


def swing(histories, other):
    """Frequency in Hz and damping ratio of the tower's side-side oscillation, which is the difference of two runs: sines are fitted in
    windows, and lines to the logarithms of their amplitudes and to their phases."""
    t, y = histories["time"], other[f"{SIDE}, m"] - histories[f"{SIDE}, m"]
    omega = 2.0 * np.pi * 0.33
    for _ in range(4):  # iterates until the frequency of the sines gives a constant phase
        found = []
        for begin in np.arange(KICKED_S, t[-1] - WINDOW_S + 1e-9, 0.5 * WINDOW_S):
            own = (t >= begin) & (t <= begin + WINDOW_S)
            basis = np.column_stack([np.cos(omega * t[own]), np.sin(omega * t[own])]) * np.hanning(own.sum())[:, None]
            cosine, sine = np.linalg.lstsq(basis, y[own] * np.hanning(own.sum()), rcond=None)[0]
            found.append([begin + 0.5 * WINDOW_S, np.hypot(cosine, sine), np.arctan2(-sine, cosine)])
        middle, size, phase = np.array(found).T
        rate, drift = -np.polyfit(middle, np.log(size), 1)[0], np.polyfit(middle, np.unwrap(phase), 1)[0]
        omega += drift
    spread = np.std(np.log(size) + rate * middle)
    return omega / (2.0 * np.pi), rate / omega, spread


def steady(histories, name):
    """Mean of a quantity in its steady oscillation."""
    return histories[name][histories["time"] >= STEADY_S].mean()


def check_reduced(foldwing, composed):
    """Checks that the full turbine without all terms is the shipped reduced one."""
    text = replaced(REDUCED.read_text(encoding="utf-8"), r'^model = "bem"$', 'model = "bem"\nend_loads = "full_induction"\naerodyn_compatible = true')
    shipped = run(foldwing, text)
    for name in QUANTITIES:
        off = np.abs(shipped[name] - composed[name]).max() / np.ptp(composed[name])
        if off > 1e-6:
            raise SystemExit(f"nrel_5mw_reduced.toml differs in {name} by {off:.1e} of peak to peak")


def print_minus(text):
    """Numbers with a typographic minus sign."""
    return text.replace("-", "−")


def tables(full, reduced, put_back, taken_out):
    """The tables in Markdown."""
    lines = ["| quantity | mean from 30 s, whole | reduced | off | peak to peak to 20 s, whole | reduced | from 40 s, whole | reduced | left of it, whole | reduced |",
             "|---|---|---|---|---|---|---|---|---|---|"]
    for name in QUANTITIES:
        means = [steady(histories, name) for histories in (full, reduced)]
        time_s = full["time"]
        first, last = ([np.ptp(histories[name][part]) for histories in (full, reduced)] for part in (time_s <= 20.0, time_s >= 40.0))
        left = [f"{100.0 * late / early:.1f} %" for early, late in zip(first, last)]
        cells = [*(f"{mean:.5g}" for mean in means), f"{100.0 * (means[1] / means[0] - 1.0):+.1f} %", *(f"{span:.4g}" for span in first + last), *left]
        lines.append(f"| {name} | {' | '.join(print_minus(cell) for cell in cells)} |")

    def row(name, histories):
        frequency, ratio, spread = histories["swing"]
        if spread > 0.05:
            raise SystemExit(f"{name}: amplitudes of the side-side swing are off their line by {spread:.2f}")
        side, *others = (steady(histories, quantity) for quantity in (f"{SIDE}, m", *list(QUANTITIES)[:3]))
        cells = [f"{1e3 * side:.2f}", f"{100.0 * ratio:.2f}", f"{frequency:.4f}", *(f"{mean:.4g}" for mean in others)]
        return f"| {name} | {' | '.join(print_minus(cell) for cell in cells)} |"

    head = "side-side mean, mm | damping ratio, % | frequency, Hz | mean tip out of plane, m | in plane, m | fore-aft, m |"
    lines += ["", f"| reduced, and put back | {head}", "|---|---|---|---|---|---|---|", row("nothing", reduced)]
    lines += [row(name, histories) for name, histories in put_back.items()]
    lines += ["", f"| whole, and left out | {head}", "|---|---|---|---|---|---|---|", row("nothing", full)]
    lines += [row(name, histories) for name, histories in taken_out.items()]
    return "\n".join(lines) + "\n"


def draw(full, reduced, most_back, folder):
    """Draws the tower's side-side motion, as in the paper's Fig. 12, and the fore-aft motion."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    sys.path.insert(0, str(ROOT / "examples"))
    from house_style import BLUE, GREEN, VERMILION, label_ends, save, use

    use()
    figure, axes = plt.subplots(2, 1, figsize=(8.2, 5.6), sharex=True)
    figure.subplots_adjust(left=0.1, right=0.8, top=0.94, bottom=0.09, hspace=0.14)
    for axis, name, factor, label in ((axes[0], f"{SIDE}, m", 1e3, "tower top\nside-side (mm)"), (axes[1], "tower fore-aft, m", 1.0, "tower top\nfore-aft (m)")):
        for histories, colour, words, width in ((reduced, VERMILION, "reduced", 1.1), (most_back, GREEN, "reduced, with three\nterms put back", 1.1),
                                                (full, BLUE, "whole turbine", 1.8)):
            axis.plot(histories["time"], factor * histories[name], color=colour, label=words, linewidth=width)
        axis.set_ylabel(label)
    axes[0].set_title("Error of the reduced model: NREL 5 MW turbine at 11.4 m/s")
    axes[-1].set(xlabel="time (s)", xlim=(0.0, full["time"][-1]))
    label_ends(axes[0])
    figure.align_ylabels()
    folder.mkdir(parents=True, exist_ok=True)
    save(figure, folder / "reduced_turbine.png")


HEAD = """# The reduced turbine compared with the whole one

`examples/turbine/nrel_5mw_wind.toml` at 11.4 m/s with locked pitch and AeroDyn's rules, 60 s from straight blades, and the same machine without the terms that
the paper's reduced model leaves out. The damping ratio is that of the tower's side-side swing, from the difference of two runs, one of them
with the tower 20 mm aside at the start.
"""


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--foldwing", required=True, help="the command `foldwing`")
    parser.add_argument("--output", type=Path, help="folder for the picture")
    parser.add_argument("--table", type=Path, help="file for the tables")
    arguments = parser.parse_args()
    every = set(TERMS)
    full, reduced = (run_twice(arguments.foldwing, with_terms(terms)) for terms in (every, set()))
    check_reduced(arguments.foldwing, reduced)
    alone = {name: {name} for name in TERMS}
    put_back = {name: run_twice(arguments.foldwing, with_terms(terms)) for name, terms in {**alone, **TOGETHER}.items()}
    taken_out = {name: run_twice(arguments.foldwing, with_terms(every - terms)) for name, terms in {**alone, **TOGETHER}.items()}
    text = tables(full, reduced, put_back, taken_out)
    print(text, end="")
    for name, histories in (("whole", full), ("reduced", reduced)):
        balance = histories["energy.total"] - histories["energy.work"] + histories["energy.dissipated"]
        print(f"energy account, {name}: within {np.abs(balance - balance[0]).max():.3g} J of {np.ptp(histories['energy.work']):.3g} J")
    if arguments.table:
        arguments.table.write_text(f"{HEAD}Written by `make turbine`, {time.strftime('%Y-%m-%d')}.\n\n{text}", encoding="utf-8")
    if arguments.output:
        draw(full, reduced, put_back["the first three"], arguments.output)


if __name__ == "__main__":
    main()
