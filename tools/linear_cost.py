#!/usr/bin/env python3
"""Counts the instructions per Newton iteration of random machines with a given number of elements, and with twice and four times as many.

  make linear-cost
  python tools/linear_cost.py --foldwing COMMAND --models FOLDER [--machines N]

If the cost is linear in the number of elements, the second doubling adds twice as much as the first one; if it is quadratic, four times
as much. A ratio above 2.5 is an error: 2 with a margin of a quarter, since factorisations are renewed in some steps only. Instructions
are counted with valgrind (`cachegrind` without its caches), so the load of the computer does not matter; no clock is read. The number of
iterations is printed by the command. Machines with aerodynamics are excluded, since the cost of aerodynamics depends on strips and
panels, not on elements. So are explicit methods, which become unstable with shorter elements. Needs valgrind (Debian: valgrind).
"""
import argparse
import pathlib
import re
import subprocess
import sys
import tempfile

# Shorter and longer run, as fractions of the run specified in the model.
SHARES = (0.25, 0.75)
FACTORS = (1, 2, 4)
# Initial factor on the number of elements of the model: the cost of a few elements is small compared with the fixed cost of a machine.
BEGIN = 8
BOUND = 2.5


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--foldwing", type=lambda path: pathlib.Path(path).resolve(), required=True)
    parser.add_argument("--models", type=pathlib.Path, required=True, help="folder of model files")
    parser.add_argument("--machines", type=int, default=6, help="how many of those that have beams (default %(default)s)")
    arguments = parser.parse_args()
    models = [path for path in sorted(arguments.models.glob("*.toml")) if is_suitable(path.read_text(encoding="utf-8"))]
    if not models:
        sys.exit(f"no suitable model in {arguments.models}")
    print("| model | instructions per iteration | second doubling over the first |\n|---|---|---|")
    missed = []
    for model in models[: arguments.machines]:
        costs = [cost(arguments.foldwing, model.read_text(encoding="utf-8"), BEGIN * factor) for factor in FACTORS]
        ratio = (costs[2] - costs[1]) / (costs[1] - costs[0])
        print(f"| {model.name} | {', '.join(f'{value:.4g}' for value in costs)} | {ratio:.2f} |", flush=True)
        if not 0.0 < ratio <= BOUND:
            missed.append(model.name)
    if missed:
        sys.exit(f"the cost of {', '.join(missed)} is not linear in the number of elements")


def is_suitable(text):
    """Whether a model has beams, no aerodynamics, and a method that remains stable with more elements."""
    without = ("[aerodynamics]", 'method = "rk4"', 'mode = "real_time"')
    return "[body." in text and not any(word in text for word in without)


def cost(command, text, factor):
    """Instructions per Newton iteration with `factor` times as many elements."""
    text = re.sub(r"^elements = (\d+)", lambda found: f"elements = {factor * int(found[1])}", text, flags=re.M)
    begin_s, end_s = (float(found[1]) if (found := re.search(rf"^{key} = (.*)$", text, re.M)) else 0.0 for key in ("start_time_s", "stop_time_s"))
    counts = [counted(command, text, begin_s + share * (end_s - begin_s)) for share in SHARES]
    instructions, iterations = (after - before for before, after in zip(*counts))
    return instructions / iterations


def counted(command, text, stop_s):
    """Instructions of a run, and its number of iterations."""
    with tempfile.TemporaryDirectory() as folder:
        model = pathlib.Path(folder) / "machine.toml"
        model.write_text(text, encoding="utf-8")
        tool = ["valgrind", "--tool=cachegrind", "--cache-sim=no", "--cachegrind-out-file=/dev/null"]
        run = [command, "simulate", model, "--csv", "/dev/null", "--force", "--stop", str(stop_s)]
        done = subprocess.run([*tool, *run], capture_output=True, text=True)
    printed = done.stdout + done.stderr
    instructions, iterations = re.search(r"I\s+refs:\s+([\d,]+)", printed), re.search(r"(\d+) iterations", printed)
    if done.returncode or not instructions or not iterations:
        sys.exit(f"{text}\n{printed}")
    return int(instructions[1].replace(",", "")), int(iterations[1])


if __name__ == "__main__":
    main()
