#!/usr/bin/env python3
"""Latched wing in a 1-cos gust: gust of the model file compared with the wind inputs of the FMU.

Usage: gust.py --foldwing target/release/foldwing --picture OUT.png

`gust.toml` in the folder of this script describes both: the gust `[gust.upwash]` travels with the wind and reaches the leading
edge before the trailing edge. The second FMU is built from the same file without that table; its input `wind.velocity.z` is
the gust velocity at the wing's axis, uniform in space. The difference decreases with the ratio of gust length to chord.
"""

import argparse
import re
import subprocess
import tempfile
from contextlib import redirect_stdout
from pathlib import Path

import numpy as np
from fmpy import simulate_fmu

try:
    import tomllib
except ImportError:  # before Python 3.11
    import tomli as tomllib

MODEL = Path(__file__).parent / "gust.toml"
GAUGE, TIP, LIFT, WIND = "gauge.root.strain", "tip.position.z", "aero.force.z", "wind.velocity.z"
TABLE_STEP_S = 1e-3  # between two rows of the wind time history


def package(foldwing, text, folder, name):
    """Build an FMU from a model text."""
    model, fmu = Path(folder) / f"{name}.toml", Path(folder) / f"{name}.fmu"
    model.write_text(text, encoding="utf-8")
    subprocess.run([str(foldwing), "package", str(model), "-o", str(fmu)], check=True, stdout=subprocess.DEVNULL)
    return fmu


def without_gusts(text):
    """The model text without its tables `[gust.…]`."""
    return re.sub(r"^\[gust\..*?(?=^\[|\Z)", "", text, flags=re.MULTILINE | re.DOTALL)


def upwash(text):
    """Upwash of the model's gust at the wing's axis over time, in the input format of FMPy."""
    model = tomllib.loads(text)
    gust, stop_s = model["gust"]["upwash"], model["simulation"]["stop_time_s"]
    duration_s = gust["length_m"] / np.linalg.norm(model["aerodynamics"]["wind_m_s"])
    time_s = np.arange(0.0, stop_s + TABLE_STEP_S, TABLE_STEP_S)
    share = np.clip((time_s - gust["start_s"]) / duration_s, 0.0, 1.0)
    upwash_m_s = 0.5 * gust["velocity_m_s"][2] * (1.0 - np.cos(2.0 * np.pi * share))
    return np.rec.fromarrays([time_s, upwash_m_s], names=["time", WIND])


def fly(foldwing, model=MODEL):
    """Simulate with the model file's gust and with the wind inputs; returns both results and the input table."""
    text = Path(model).read_text(encoding="utf-8")
    wind, outputs = upwash(text), [GAUGE, TIP, LIFT, "fold.latched"]
    with tempfile.TemporaryDirectory() as folder:
        by_file = simulate_fmu(str(package(foldwing, text, folder, "gust")), output=outputs)
        fmu = package(foldwing, without_gusts(text), folder, "even")
        with redirect_stdout(None):  # FMPy warns of every input missing in the table: they keep their start values
            by_inputs = simulate_fmu(str(fmu), output=outputs, input=wind)
    return by_file, by_inputs, wind


def peak(result, name):
    """Time in s and value of largest magnitude of an output."""
    row = np.abs(result[name]).argmax()
    return result["time"][row], result[name][row]


def draw(by_file, by_inputs, wind, path):
    """Plot upwash, lift, strain and tip deflection over time."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    from house_style import BLUE, FAINT, VERMILION, label_ends, save, use

    use()
    figure, axes = plt.subplots(4, 1, figsize=(8.2, 7.4), sharex=True, height_ratios=(1, 1, 1.6, 1.6))
    figure.subplots_adjust(left=0.11, right=0.8, top=0.95, bottom=0.07, hspace=0.14)
    axes[0].plot(wind["time"], wind[WIND], color=FAINT)
    axes[0].set(ylabel="upwash (m/s)", title="The latched wing in a 1-cos gust")
    labels = (LIFT, 1.0, "force of the air,\nz (N)"), (GAUGE, 1e3, "strain at the root\ngauge (10⁻³)"), (TIP, 1e3, "tip z (mm)")
    for row, (name, factor, label) in zip(axes[1:], labels):
        row.plot(by_file["time"], factor * by_file[name], color=BLUE, label="[gust.upwash] of\nthe model file")
        row.plot(by_inputs["time"], factor * by_inputs[name], color=VERMILION, linestyle="--", linewidth=1.2, label="input\nwind.velocity.z")
        row.set_ylabel(label)
    axes[3].set(xlabel="time (s)", xlim=(0.0, by_file["time"][-1]))
    label_ends(axes[2])
    figure.align_ylabels()
    path.parent.mkdir(parents=True, exist_ok=True)
    save(figure, path)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--foldwing", required=True, help="the command `foldwing`")
    parser.add_argument("--model", default=MODEL, help="model file with a gust `upwash` (default: gust.toml)")
    parser.add_argument("--picture", type=Path, help="output file of the plot")
    arguments = parser.parse_args()

    by_file, by_inputs, wind = fly(arguments.foldwing, arguments.model)
    for name, result in (("model file", by_file), ("wind inputs", by_inputs)):
        (strain_s, strain), (tip_s, tip_m) = peak(result, GAUGE), peak(result, TIP)
        print(f"{name:12} peak root strain {abs(strain):.3e} at {strain_s:.4f} s, "
              f"tip {1e3 * tip_m:.1f} mm at {tip_s:.4f} s, largest force {result[LIFT].max():.3f} N")
    off = np.abs(by_file[GAUGE] - by_inputs[GAUGE]).max() / abs(peak(by_file, GAUGE)[1])
    print(f"{'difference':12} {off:.2%} of the peak strain at most")
    if arguments.picture:
        draw(by_file, by_inputs, wind, arguments.picture)


if __name__ == "__main__":
    main()
