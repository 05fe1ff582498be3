#!/usr/bin/env python3
"""Influences on the deployment in the wind tunnel: runs the shipped model with one choice changed at a time, and writes a table.

Usage: tunnel_study.py --foldwing COMMAND --table docs/tables/tunnel.md [--model MODEL.toml] [--jobs N] [--only TEXT]

Every row is a run of `foldwing simulate` at 10 and one at 20 m/s with the model text changed as given in the row. Nothing is fitted: the
paper's values are listed next to ours and are not used in any run.
"""

import argparse
import csv
import datetime
import re
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

MODEL = Path(__file__).resolve().parents[1] / "examples/models/folding_wing_in_tunnel.toml"
PAPER_LATCH_S = {0: 0.120, 10: 0.166, 20: 0.198}  # Otsuka et al., section 5, Fig. 10
PAPER_TIP_M = 0.056  # likewise, at 10 m/s and TIP_TIME_S
TIP_TIME_S = 0.2
COMMUNICATION_STEP_S = 5e-4
BODIES = ("inner", "outer")
AIR = "aerodynamics"
WITHOUT = None  # as a value: the key is removed


@dataclass
class Variant:
    """A row of the table: the changes, as (table, key, value in TOML), and text to add."""

    label: str
    changes: tuple = ()
    added: str = ""
    without: tuple = ()  # tables to be removed
    tip: str = "tip"


@dataclass
class Outcome:
    """Results of a run."""

    latch_s: float
    peak_strain: float
    tip_m: float
    wall_s: float


def change(text, table, key, value):
    """Model text with one key of a table set or removed."""
    begin = text.index(f"[{table}]\n") + len(f"[{table}]\n")
    end = text.find("\n[", begin)
    end = len(text) if end < 0 else end
    body = re.sub(rf"(?m)^{key} = .*\n?", "", text[begin:end])
    line = "" if value is WITHOUT else f"{key} = {value}\n"
    return text[:begin] + line + body + text[end:]


def take_out(text, table):
    """Model text without a table."""
    return re.sub(rf"(?ms)^\[{re.escape(table)}\]\n.*?(?=^\[|\Z)", "", text)


def of_bodies(prefix, **keys):
    """The same change for both bodies."""
    return tuple((f"{prefix}.{body}", key, value) for body in BODIES for key, value in keys.items())


def air(**keys):
    """Changes of the aerodynamics."""
    return tuple((AIR, key, value) for key, value in keys.items())


def lattice(chord, span):
    """Number of panels of each body."""
    return of_bodies("surface", chord_panels=chord, strips=span)


def strips(**keys):
    """Strips instead of the lattice, without its keys."""
    return air(model='"strip"', mirror_normal=WITHOUT, wake_rows=WITHOUT, **keys) + of_bodies("surface", chord_panels=WITHOUT)


def solver(**keys):
    """Settings of the structure's integrator."""
    return "\n[solver]\n" + "".join(f"{key} = {value}\n" for key, value in keys.items())


# The actuator as a short, stiff, heavy stub at the joint, so that the mass-proportional damping α can act on its mass.
STUB = """
[section.stub]
shape = "rectangle"
width_m = 0.01
height_m = 0.01
density_kg_m3 = 101500.0
youngs_modulus_Pa = 1e11
poisson_ratio = 0.3

[body.stub]
length_m = 0.002
section = "stub"
elements = 1
load_stations = 0
mass_damping_1_s = {damping}

[joint.stub]
type = "clamped"
parent = "inner"
child = "stub"
mount_rotation_deg = [0.0, 0.0, 90.0]
"""

CONVERGENCE = [
    Variant("panels per body 4 × 5 (chord × span)", lattice(4, 5)),
    Variant("panels 4 × 20", lattice(4, 20)),
    Variant("panels 2 × 10", lattice(2, 10)),
    Variant("panels 8 × 10", lattice(8, 10)),
    Variant("aerodynamic step 2.5 ms", air(step_s=2.5e-3, wake_rows=15)),
    Variant("aerodynamic step 0.625 ms", air(step_s=6.25e-4, wake_rows=60)),
    Variant("aerodynamic step 0.3125 ms", air(step_s=3.125e-4, wake_rows=120)),
    Variant("panels 8 × 10 and step 0.625 ms", lattice(8, 10) + air(step_s=6.25e-4, wake_rows=60)),
    Variant("wake of 10 rows (2.5 chords at 10 m/s)", air(wake_rows=10)),
    Variant("wake of 20 rows", air(wake_rows=20)),
    Variant("wake of 60 rows", air(wake_rows=60)),
    Variant("wake of 120 rows", air(wake_rows=120)),
    Variant("two pairs of elements per body", of_bodies("body", elements=2)),
    Variant("eight pairs of elements per body", of_bodies("body", elements=8)),
    Variant("15 constant elements per body, the paper's", of_bodies("body", elements=15, element='"constant"')),
    Variant("structure's tolerance 1e-3", added=solver(tolerance=1e-3)),
    Variant("structure's tolerance 1e-6", added=solver(tolerance=1e-6)),
    Variant("structure's longest step 0.25 ms", added=solver(max_step_s=2.5e-4)),
    Variant("coupling tolerance 1e-2", air(coupling_tolerance=1e-2)),
    Variant("coupling tolerance 1e-7", air(coupling_tolerance=1e-7)),
    Variant("staggered coupling", air(coupling='"staggered"')),
    Variant(
        "all finer: panels 8 × 20, step 0.625 ms, wake of 120 rows, tolerances 1e-5 and 1e-6",
        lattice(8, 20) + air(step_s=6.25e-4, wake_rows=120, coupling_tolerance=1e-6),
        solver(tolerance=1e-5),
    ),
]

PHYSICS = [
    Variant("no wall (no mirror plane)", air(mirror_normal=WITHOUT)),
    Variant("rigid in torsion (GJ × 1000)", (("section.plate", "torsional_rigidity_N_m2", 180.0),)),
    Variant("neither wall nor torsion", air(mirror_normal=WITHOUT) + (("section.plate", "torsional_rigidity_N_m2", 180.0),)),
    Variant("free wake", air(free_wake="true")),
    Variant("core radius 1.25e-5 m (a tenth)", air(core_radius_m=1.25e-5)),
    Variant("core radius 6.25e-4 m (5 times)", air(core_radius_m=6.25e-4)),
    Variant("core radius 2.5e-3 m (20 times, a fifth of a panel)", air(core_radius_m=2.5e-3)),
    Variant("forces by Kutta–Joukowski, with suction", air(leading_edge_suction="true")),
    Variant("sudden start of the wind", air(steady_initial_flow="false")),
    Variant("drive stiffness 0.0265 N·m/rad", (("joint.fold.motor", "stiffness_N_m_rad", 0.0265),)),
    Variant("drive stiffness 0.027 N·m/rad", (("joint.fold.motor", "stiffness_N_m_rad", 0.027),)),
    Variant("actuator as a stub, α not on it (check of the next row)", added=STUB.format(damping=0.0), without=("mass.actuator",), tip="tip_outer"),
    Variant("actuator as a stub, α = 2.5 1/s on it too", added=STUB.format(damping=2.5), without=("mass.actuator",), tip="tip_outer"),
    Variant("density 1.225 kg/m³", air(density_kg_m3=1.225)),
    Variant("strips instead of the lattice", strips()),
    Variant("strips without apparent mass", strips(apparent_mass="false")),
    Variant("strips without apparent mass and lag", strips(apparent_mass="false", quasi_steady="true")),
    Variant("strips with a lift slope of 4.7 1/rad", strips() + of_bodies("surface", lift_slope_1_rad=4.7)),
]

SHIPPED = Variant("shipped model")
STILL = [
    (Variant("shipped model, air at rest"), 0),
    (Variant("no air", without=(AIR, "surface.inner", "surface.outer")), 0),
]


class Study:
    """Runs variants with the command in a separate folder."""

    def __init__(self, foldwing, model, folder):
        self.foldwing, self.folder = str(foldwing.resolve()), Path(folder)
        self.text = model.read_text()

    def model_text(self, variant, wind_m_s):
        """The variant's model file. The aerodynamic step is a key of the model, so that it does not depend on the wind."""
        text = self.text
        for change_ in variant.changes:
            text = change(text, *change_)
        if AIR not in variant.without:
            text = change(text, AIR, "wind_m_s", f"[0.0, {-float(wind_m_s)}, 0.0]")
        for table in variant.without:
            text = take_out(text, table)
        return text + variant.added

    def run(self, variant, wind_m_s):
        """Outcome at one wind speed; `None`, with a message, if the run fails."""
        stem = re.sub(r"\W+", "_", variant.label) + f"_{wind_m_s}"
        model, table = self.folder / f"{stem}.toml", self.folder / f"{stem}.csv"
        model.write_text(self.model_text(variant, wind_m_s))
        outputs = ["fold.latch_time", "gauge.root.strain", f"{variant.tip}.position.z"]
        command = [self.foldwing, "simulate", str(model), "--csv", str(table), "--step", str(COMMUNICATION_STEP_S)]
        command += [part for name in outputs for part in ("--variables", name)]
        clock = time.perf_counter()
        done = subprocess.run(command, capture_output=True, text=True)
        wall_s = time.perf_counter() - clock
        if done.returncode:
            print(f"{variant.label}, {wind_m_s} m/s: {done.stderr.strip()}", file=sys.stderr)
            return None
        with open(table) as file:
            rows = list(csv.DictReader(file))
        return Outcome(
            latch_s=float(rows[-1]["fold.latch_time"]),
            peak_strain=max(abs(float(row["gauge.root.strain"])) for row in rows),
            tip_m=next(float(row[outputs[2]]) for row in rows if abs(float(row["time"]) - TIP_TIME_S) < 1e-9),
            wall_s=wall_s,
        )


def percent(value, reference):
    """Change in percent with a sign."""
    return f"{100.0 * (value / reference - 1.0):+.2f}".replace("-", "−")


def row(variant, outcomes, base):
    """One row: latch times with their change from the shipped model, peak strains, tip, time of the run at 10 m/s."""
    cells = [variant.label]
    for wind_m_s in (10, 20):
        outcome = outcomes[wind_m_s]
        if outcome is None:
            cells += ["failed", "", ""]
        else:
            cells += [
                f"{outcome.latch_s:.5f}" if outcome.latch_s >= 0.0 else "none",
                percent(outcome.latch_s, base[wind_m_s].latch_s),
                f"{1e3 * outcome.peak_strain:.3f}",
            ]
    at_ten = outcomes[10]
    cells += [f"{1e3 * at_ten.tip_m:.1f}", f"{at_ten.wall_s:.1f}"] if at_ten else ["", ""]
    return "| " + " | ".join(cells) + " |"


HEAD = [
    "| changed | latch 10 m/s, s | % | peak strain 10 m/s, 1e-3 | latch 20 m/s, s | % | peak strain 20 m/s, 1e-3 "
    "| tip at 0.2 s and 10 m/s, mm | run at 10 m/s, s |",
    "|---|---|---|---|---|---|---|---|---|",
]


def document(results, still):
    """Text of the page."""
    base = results[SHIPPED.label]
    text = [
        "# The deployment in the wind tunnel: influences on the result",
        "",
        f"Written by `make tunnel` (`studies/tunnel_study.py`), {datetime.date.today().isoformat()}. Every row is the shipped model",
        "`examples/models/folding_wing_in_tunnel.toml` with one choice changed; nothing is fitted. \"%\" is the change of the latch",
        "time against the shipped model. Times of runs are wall-clock times beside other runs: a comparison, no benchmark.",
        "",
        "## Against the paper",
        "",
        "| wind, m/s | latch, s: paper | ours | off, % | tip at 0.2 s, mm: paper | ours | off, % | peak strain, ours, 1e-3 |",
        "|---|---|---|---|---|---|---|---|",
    ]
    at_rest = still[STILL[0][0].label]
    for wind_m_s, outcome in ((0, at_rest), (10, base[10]), (20, base[20])):
        tip = [f"{1e3 * PAPER_TIP_M:.0f}", f"{1e3 * outcome.tip_m:.1f}", percent(outcome.tip_m, PAPER_TIP_M)]
        cells = [
            f"{wind_m_s}",
            f"{PAPER_LATCH_S[wind_m_s]:.3f}",
            f"{outcome.latch_s:.5f}",
            percent(outcome.latch_s, PAPER_LATCH_S[wind_m_s]),
            *(tip if wind_m_s == 10 else ["", f"{1e3 * outcome.tip_m:.1f}", ""]),
            f"{1e3 * outcome.peak_strain:.3f}",
        ]
        text.append("| " + " | ".join(cells) + " |")
    airless = still[STILL[1][0].label]
    text += [
        "",
        f"Without air the wing latches at {airless.latch_s:.5f} s with a peak strain of {1e3 * airless.peak_strain:.3f}e-3. Air at rest moves",
        f"that by {percent(at_rest.latch_s, airless.latch_s)} %: apparent mass, and the wake that the trailing edge leaves where it moves.",
        "",
    ]
    for title, variants in (("Convergence", CONVERGENCE), ("Influences on the result", PHYSICS)):
        text += [f"## {title}", "", *HEAD, row(SHIPPED, base, base)]
        text += [row(variant, results[variant.label], base) for variant in variants if variant.label in results]
        text.append("")
    return "\n".join(text + NOTES)


NOTES = [
    "The lattice cannot be run without its impulsive load, hence the row of strips without apparent mass. The stub is a body of",
    "2 mm with the actuator's mass, across the chord at the joint.",
    "",
]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--foldwing", type=Path, required=True, help="the command")
    parser.add_argument("--table", type=Path, required=True, help="Markdown file to write")
    parser.add_argument("--model", type=Path, default=MODEL, help="model file")
    parser.add_argument("--jobs", type=int, default=1, help="runs at a time")
    parser.add_argument("--only", default="", help="rows whose label contains this")
    arguments = parser.parse_args()
    variants = [SHIPPED] + [v for v in CONVERGENCE + PHYSICS if arguments.only in v.label]
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(arguments.jobs) as pool:
        study = Study(arguments.foldwing, arguments.model, folder)
        pending = {(v.label, w): pool.submit(study.run, v, w) for v in variants for w in (10, 20)}
        pending_still = {v.label: pool.submit(study.run, v, w) for v, w in STILL}
        results = {}
        for (label, wind_m_s), future in pending.items():
            results.setdefault(label, {})[wind_m_s] = future.result()
            print(f"{label}, {wind_m_s} m/s: {future.result()}", flush=True)
        still = {label: future.result() for label, future in pending_still.items()}
    arguments.table.write_text(document(results, still))


if __name__ == "__main__":
    main()
