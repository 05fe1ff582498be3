"""Machines of the audit and functions to run them, used by every script in this folder.

`FOLDWING` names the command (default: target/release/foldwing of this checkout). Two commands can be compared by
running a script twice. Files are written to a temporary folder that is removed.
"""

from __future__ import annotations

import csv
import json
import os
import subprocess
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

CHECKOUT = Path(__file__).resolve().parents[2]
FOLDWING = os.environ.get("FOLDWING", str(CHECKOUT / "target/release/foldwing"))
_FOLDER = tempfile.TemporaryDirectory(prefix="foldwing-audit-")
WORK = Path(_FOLDER.name)

PLATE = """
[section.plate]
shape = "rectangle"
width_m = 0.05
height_m = 0.002
density_kg_m3 = 1425.0
youngs_modulus_Pa = 2.83e9
torsional_rigidity_N_m2 = 0.18
"""


@dataclass
class Run:
    """Results of one run of the command: exit code, messages, columns of the CSV by name, counters of `--profile`."""

    code: int
    message: str
    printed: str
    wall_s: float
    columns: dict[str, np.ndarray] = field(default_factory=dict)
    timing: dict[str, float] = field(default_factory=dict)

    @property
    def ended(self) -> bool:
        return self.code == 0


def folding_wing(
    *,
    start_deg: float = 170.0,
    stiffness_n_m_rad: float = 0.026,
    damping_n_m_s_rad: float = 0.0008,
    torque_n_m: float = 0.043,
    latch: bool = True,
    stiffness_ratio: float = 1e4,
    latch_keys: str = "",
    drive_keys: str = "",
    joint_keys: str = "",
    body_keys: str = "",
    length_m: float = 0.15,
    elements: int = 4,
    element: str = "linear",
    mass_damping_1_s: float = 2.5,
    stiffness_damping_s: float = 0.0,
    section: str = PLATE,
    actuator: bool = True,
    gravity: str = "[-9.8, 0.0, 0.0]",
    air: str = "",
    solver: str = "",
    experiment: str = "stop_time_s = 0.4\nstep_s = 5e-4",
) -> str:
    """The shipped folding wing as text, with the changes of an audit as arguments; keys are lines of the model file."""
    bodies = "".join(
        f'[body.{name}]\nlength_m = {length_m}\nsection = "plate"\nelement = "{element}"\nelements = {elements}\n'
        f"mass_damping_1_s = {mass_damping_1_s}\nstiffness_damping_s = {stiffness_damping_s}\n{body_keys}\n"
        for name in ("inner", "outer")
    )
    return "\n".join(
        [
            f'name = "Wing"\ngravity_m_s2 = {gravity}\n{section}{bodies}',
            '[joint.mount]\ntype = "clamped"\nparent = "root"\nchild = "inner"',
            '[joint.fold]\ntype = "revolute"\nparent = "inner"\nchild = "outer"\naxis = [0.0, 1.0, 0.0]',
            f"start_angle_deg = {start_deg}\n{joint_keys}",
            f"[joint.fold.motor]\nstiffness_N_m_rad = {stiffness_n_m_rad}\ndamping_N_m_s_rad = {damping_n_m_s_rad}",
            f"constant_torque_N_m = {torque_n_m}\n{drive_keys}",
            f"[joint.fold.latch]\nangle_deg = 0.0\nstiffness_ratio = {stiffness_ratio}\n{latch_keys}" if latch else "",
            f'[mass.actuator]\nbody = "inner"\nposition_m = {length_m}\nmass_kg = 0.0203' if actuator else "",
            '[gauge.root]\nbody = "inner"\nposition_m = 0.02',
            air,
            f"[solver]\n{solver}" if solver else "",
            f"[simulation]\n{experiment}\n",
        ]
    )


def run(text: str, *arguments: str, outputs: list[str] | tuple[str, ...] = (), limit_s: float = 300.0) -> Run:
    """Runs `foldwing simulate` on a model given as text. Without `outputs`, all are written."""
    model, results, timing = WORK / "model.toml", WORK / "run.csv", WORK / "timing.json"
    model.write_text(text)
    for file in (results, timing):
        file.unlink(missing_ok=True)
    command = [FOLDWING, "simulate", str(model), "--csv", str(results), "--profile", str(timing), *arguments]
    for name in outputs:
        command += ["--variables", name]
    begin = time.monotonic()
    try:
        process = subprocess.run(command, capture_output=True, text=True, timeout=limit_s)
    except subprocess.TimeoutExpired:
        return Run(-9, f"not finished after {limit_s:g} s", "", time.monotonic() - begin)
    outcome = Run(process.returncode, process.stderr.strip(), process.stdout, time.monotonic() - begin)
    if timing.exists():
        outcome.timing = json.loads(timing.read_text())
    if results.exists():
        outcome.columns = read_csv(results)
    return outcome


def command(name: str, text: str, *arguments: str, limit_s: float = 300.0) -> Run:
    """Runs another command of `foldwing` (static, modes, linearize, check …) on a model given as text."""
    model = WORK / "model.toml"
    model.write_text(text)
    begin = time.monotonic()
    try:
        process = subprocess.run(
            [FOLDWING, name, str(model), *arguments], capture_output=True, text=True, timeout=limit_s
        )
    except subprocess.TimeoutExpired:
        return Run(-9, f"not finished after {limit_s:g} s", "", time.monotonic() - begin)
    return Run(process.returncode, process.stderr.strip(), process.stdout, time.monotonic() - begin)


def inputs(rows: str) -> str:
    """Writes an input table and returns its path, for `--inputs`."""
    path = WORK / "inputs.csv"
    path.write_text(rows)
    return str(path)


def read_csv(path: Path) -> dict[str, np.ndarray]:
    """Columns of a result file by name; Booleans are converted to 0 and 1."""
    with path.open() as file:
        rows = csv.reader(line for line in file if not line.startswith("#"))
        names = next(rows, [])
        flags = {"true": 1.0, "false": 0.0}
        values = np.array([[flags[cell] if cell in flags else float(cell) for cell in row] for row in rows])
    return {name: values[:, i] for i, name in enumerate(names)} if values.size else {}
