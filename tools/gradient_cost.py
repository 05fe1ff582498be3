#!/usr/bin/env python3
"""Counts the instructions of gradients of the shipped wing's run to 0.4 s, and compares forward and adjoint.

  make gradient-cost
  python tools/gradient_cost.py --program target/release/examples/gradient_cost

Each figure is the difference between a run with one call and one with none, under valgrind's callgrind. Counts do not depend on the load of the
computer. Needs valgrind (Debian: valgrind).
"""
import argparse
import pathlib
import re
import subprocess
import sys
import tempfile

ROWS = (
    ("run", "run"),
    ("run on a tape", "tape"),
    ("one direction: a motor's torque", "forward 1"),
    ("twelve directions: of joint, bodies and section", "forward 12"),
    ("adjoint, one parameter", "adjoint 1"),
    ("adjoint, twelve parameters", "adjoint 12"),
)


def counted(program, *words):
    """Instructions of a run of the program, and the numbers that it prints."""
    with tempfile.TemporaryDirectory() as folder:
        command = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={pathlib.Path(folder) / 'out'}", program, *words]
        done = subprocess.run(command, capture_output=True, text=True)
    count = re.search(r"Collected : (\d+)", done.stderr)
    if done.returncode or not count:
        sys.exit(done.stderr + done.stdout)
    return int(count[1]), [float(line) for line in done.stdout.split()]


def main():
    """Runs the command."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", required=True, help="the example `gradient_cost` of the engine")
    program = parser.parse_args().program
    print("| work | million instructions | runs |\n|---|---|---|")
    run, results = None, {}
    for name, work in ROWS:
        (without, _), (with_one, results[work]) = (counted(program, *work.split(), calls) for calls in ("0", "1"))
        cost = with_one - without
        run = run or cost
        print(f"| {name} | {cost / 1e6:.1f} | {cost / run:.2f} |", flush=True)
    # the first result of the forward mode is that of the adjoint one
    forward, adjoint = results["forward 12"][:12], results["adjoint 12"]
    largest = max(map(abs, adjoint))
    print(f"\nforward against adjoint: {max(abs(a - b) for a, b in zip(forward, adjoint)) / largest:.1e} of the largest derivative")


if __name__ == "__main__":
    main()
