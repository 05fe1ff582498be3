#!/usr/bin/env python3
"""Counts the instructions of two builds of the command for typical tasks, and prints their ratio.

  make instructions
  python tools/count_instructions.py --foldwing COMMAND --baseline OTHER_COMMAND [--case NAME]...

Counts do not depend on the load of the machine (valgrind, `cachegrind` without its caches; lattices use vectors of 256 bits, which
valgrind supports). Each figure is the difference between a longer and a shorter run of the same task, so that reading the model,
writing and loading the library are not included. Needs valgrind (Debian: valgrind).
"""
import argparse
import pathlib
import re
import subprocess
import sys
import tempfile
import zipfile

from old_names import Command

ROOT = pathlib.Path(__file__).resolve().parents[1]

# Tasks by kind: model, unit of the figure, shorter and longer run (s of the simulation, or calls).
SIMULATIONS = {
    "deployment, shipped wing": ("examples/models/folding_wing.toml", 0.1, 0.4),
    "deployment, 15 constant elements": ("examples/models/folding_wing_constant.toml", 0.1, 0.4),
    "wing on strips": ("examples/models/goland_wing.toml", 0.05, 0.15),
    "wing in the tunnel, lattice": ("examples/models/folding_wing_in_tunnel.toml", 0.02, 0.04),
    "turbine without air": ("examples/turbine/nrel_5mw.toml", 0.5, 1.5),
    "turbine in wind": ("examples/turbine/nrel_5mw_wind.toml", 0.5, 1.5),
    "turbine of beams": ("examples/turbine/nrel_5mw_strain.toml", 0.1, 0.3),
}
DERIVATIVES = {"fmi2GetDerivatives": "examples/models/folding_wing.toml", "the same, on strips": "examples/models/goland_wing.toml"}
CALLS = (100, 300)
VARIANTS = (2, 6)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--foldwing", type=pathlib.Path, required=True)
    parser.add_argument("--baseline", type=pathlib.Path, required=True, help="the command to compare with")
    parser.add_argument("--case", action="append", default=[], help="only cases whose name contains this")
    arguments = parser.parse_args()
    builds = Command(arguments.baseline.resolve()), Command(arguments.foldwing.resolve())
    print("| work | unit | million instructions: baseline | now | ratio |\n|---|---|---|---|---|")
    for name, (unit, count) in cases().items():
        if arguments.case and not any(part in name for part in arguments.case):
            continue
        before, now = (count(command) for command in builds)
        print(f"| {name} | {unit} | {before / 1e6:.4g} | {now / 1e6:.4g} | {now / before:.4f} |", flush=True)


def cases():
    """All cases: unit, and the function that counts the instructions of a command."""
    found = {}
    for name, (model, shorter, longer) in SIMULATIONS.items():
        found[name] = "second", lambda command, model=model, ends=(shorter, longer): simulation(command, model, *ends)
    for name, model in DERIVATIVES.items():
        found[name] = "call", lambda command, model=model: derivatives(command, model)
    found["sweep of the shipped wing"] = "variant", sweep
    return found


def simulation(command, model, shorter, longer):
    """Instructions per simulated second."""
    with command.model(ROOT / model) as file:
        call = [command.path, "simulate", file, "--csv", "/dev/null", "--quiet", "--stop"]
        counts = [counted([*call, str(stop)]) for stop in (shorter, longer)]
    return (counts[1] - counts[0]) / (longer - shorter)


def sweep(command):
    """Instructions per variant of a deployment, on one thread."""
    counts = []
    for variants in VARIANTS:
        vary = f"fold.{'stiffness' if command.is_old else 'motor_stiffness'}=0.02:0.03:{variants}"
        with tempfile.TemporaryDirectory() as folder, command.model(ROOT / "examples/models/folding_wing.toml") as file:
            counts.append(counted([command.path, "sweep", file, "--vary", vary, "--threads", "1", "--stop", "0.2",
                                   command.option("--output"), f"{folder}/sweep.csv", "--quiet"]))
    return (counts[1] - counts[0]) / (VARIANTS[1] - VARIANTS[0])


def derivatives(command, model):
    """Instructions per call of `fmi2GetDerivatives`, with states that vary from call to call."""
    with tempfile.TemporaryDirectory() as folder:
        fmu = pathlib.Path(folder) / "model.fmu"
        with command.model(ROOT / model) as file:
            call = [command.path, "package", file, command.option("--interface"), "cs,me", "-o", fmu]
            subprocess.run(call, cwd=ROOT, check=True, capture_output=True)
        with zipfile.ZipFile(fmu) as archive:
            archive.extractall(folder)
        caller = [sys.executable, ROOT / "tools/call_derivatives.py", folder]
        counts = [counted([*caller, str(calls)]) for calls in CALLS]
    return (counts[1] - counts[0]) / (CALLS[1] - CALLS[0])


def counted(command):
    """Instructions of a command."""
    tool = ["valgrind", "--tool=cachegrind", "--cache-sim=no", "--cachegrind-out-file=/dev/null"]
    done = subprocess.run([*tool, *command], cwd=ROOT, capture_output=True, text=True)
    found = re.search(r"I\s+refs:\s+([\d,]+)", done.stderr)
    if done.returncode or not found:
        sys.exit(f"{' '.join(map(str, command))}\n{done.stdout}{done.stderr}")
    return int(found[1].replace(",", ""))


if __name__ == "__main__":
    main()
