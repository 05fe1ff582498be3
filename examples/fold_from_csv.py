#!/usr/bin/env python3
"""Fold commands from a CSV file: the FMU in FMPy compared with `foldwing simulate --inputs`.

Usage: fold_from_csv.py --foldwing target/release/foldwing --fmu target/fmu/FoldingWing.fmu --picture OUT.png

The file (`--inputs`, default `fold_command.csv` in the folder of this script) has a column `time` (s) and one per input. Both
programs interpolate Reals linearly between rows and hold Booleans (here 0 and 1) from their row on. FMPy also ends a step at
every row with a change of a Boolean or a repeated time; here such rows coincide with communication points.
"""

import argparse
import subprocess
import tempfile
from contextlib import redirect_stdout
from pathlib import Path

import numpy as np
from fmpy import simulate_fmu

HERE = Path(__file__).parent
ANGLE, GAUGE, LATCH_TIME = "fold.angle", "gauge.root.strain", "fold.latch_time"
OUTPUTS = [ANGLE, "fold.latched", LATCH_TIME, GAUGE, "tip.position.x", "tip.position.z"]
STOP_S, STEP_S = 3.0, 1e-3


def read_table(path):
    """A CSV file as a structured array; lines starting with `#` are comments."""
    lines = [line for line in Path(path).read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    # unchanged names: NumPy would remove dots and brackets
    return np.genfromtxt(lines, delimiter=",", names=True, autostrip=True, deletechars="", dtype=float)


def through_fmpy(fmu, inputs, stop_s=STOP_S, step_s=STEP_S):
    """Simulate the FMU with the table as FMPy's `input`."""
    with redirect_stdout(None):  # FMPy warns of every input missing in the table: they keep their start values
        return simulate_fmu(str(fmu), input=inputs, output=OUTPUTS, stop_time=stop_s, output_interval=step_s)


def through_command(foldwing, model, inputs_path, stop_s=STOP_S, step_s=STEP_S):
    """Simulate with the command and the same file."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "result.csv"
        command = [str(foldwing), "simulate", str(model), "--inputs", str(inputs_path), "--csv", str(path), "--quiet",
                   "--stop", str(stop_s), "--step", str(step_s)]
        for name in OUTPUTS:
            command += ["--variables", name]
        subprocess.run(command, check=True)
        return read_table(path)


def difference(one, other):
    """Largest difference of two results over all outputs and times, relative to the largest value of each output."""
    return max(np.abs(one[name] - other[name]).max() / np.abs(one[name]).max() for name in OUTPUTS)


def draw(inputs, result, path):
    """Plot command, fold angle and strain over time."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    from house_style import BLUE, FAINT, ORANGE, SMALL, save, use

    use()
    figure, (upper, lower) = plt.subplots(2, 1, figsize=(7.6, 5.2), sharex=True, layout="constrained")
    upper.plot(inputs["time"], np.degrees(inputs["fold.angle_command"]), "o--", color=ORANGE, markersize=4, linewidth=1.0,
               label="fold.angle_command, rows of the CSV file")
    upper.plot(result["time"], np.degrees(result[ANGLE]), color=BLUE, label="fold.angle")
    upper.set(ylabel="angle (°)", yticks=range(0, 271, 45), title="Fold commands from a CSV file")
    upper.legend(loc="upper center")
    lower.plot(result["time"], 1e3 * result[GAUGE], color=BLUE, linewidth=1.0)
    lower.set(xlabel="time (s)", ylabel="strain at the root gauge (10⁻³)", xlim=(0.0, result["time"][-1]))
    latched = result["fold.latched"] > 0
    for axes in (upper, lower):
        axes.fill_between(result["time"], 0, 1, where=latched, transform=axes.get_xaxis_transform(), color=FAINT,
                          alpha=0.16, linewidth=0)
    middle_s = result["time"][latched].mean()
    upper.annotate("latched", (middle_s, 0.6), xycoords=("data", "axes fraction"), ha="center", va="center", fontsize=SMALL, color=FAINT)
    path.parent.mkdir(parents=True, exist_ok=True)
    save(figure, path)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--foldwing", required=True, help="the command `foldwing`")
    parser.add_argument("--fmu", required=True, help="FMU of the model")
    parser.add_argument("--model", default=HERE / "models/folding_wing.toml", help="model file (default: the folding wing)")
    parser.add_argument("--inputs", default=HERE / "fold_command.csv", help="CSV file with inputs over time")
    parser.add_argument("--picture", type=Path, help="output file of the plot")
    arguments = parser.parse_args()

    inputs = read_table(arguments.inputs)
    result = through_fmpy(arguments.fmu, inputs)
    twin = through_command(arguments.foldwing, arguments.model, arguments.inputs)
    for name, run in (("FMPy", result), ("foldwing simulate", twin)):
        row = np.abs(run[GAUGE]).argmax()
        print(f"{name:19}latched at {run[LATCH_TIME][-1]:.4f} s, "
              f"largest strain {abs(run[GAUGE][row]):.3e} at {run['time'][row]:.3f} s")
    print(f"{'largest difference':19}{difference(result, twin):.1e}")
    if arguments.picture:
        draw(inputs, result, arguments.picture)


if __name__ == "__main__":
    main()
