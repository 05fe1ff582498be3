#!/usr/bin/env python3
"""Counts the instructions of an element with shear beside one without, in three parts of the work on a hinged beam of 32 pairs.

  make shear-cost
  python tools/shear_cost.py --program target/release/examples/shear_cost

Each figure is the difference between runs with more and fewer calls, divided by calls and by elements (halves of pairs), under valgrind's
callgrind. Counts do not depend on the load of the computer. Needs valgrind (Debian: valgrind).
"""
import argparse
import pathlib
import re
import subprocess
import sys
import tempfile

BEAMS = ("plain", "sheared", "coupled")
PARTS = ("residual", "factorisation", "solution")
CALLS = (20, 120)
# two bodies of 16 pairs
ELEMENTS = 64


def instructions(program, *words):
    """Instructions of a run of the program."""
    with tempfile.TemporaryDirectory() as folder:
        command = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={pathlib.Path(folder) / 'out'}", program, *words]
        done = subprocess.run(command, capture_output=True, text=True)
    count = re.search(r"Collected : (\d+)", done.stderr)
    if done.returncode or not count or "no factors" in done.stdout:
        sys.exit(done.stderr + done.stdout)
    return int(count[1])


def main():
    """Runs the command."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", required=True, help="the example `shear_cost` of the engine")
    program = parser.parse_args().program
    print("| part | without shear | with shear | ratio | full stiffness matrix | ratio |\n|---|---|---|---|---|---|")
    for part in PARTS:
        fewer, more = ([instructions(program, beam, part, str(calls)) for beam in BEAMS] for calls in CALLS)
        plain, sheared, coupled = ((b - a) / (CALLS[1] - CALLS[0]) / ELEMENTS for a, b in zip(fewer, more))
        print(f"| {part} | {plain:.0f} | {sheared:.0f} | {sheared / plain:.2f} | {coupled:.0f} | {coupled / plain:.2f} |", flush=True)


if __name__ == "__main__":
    main()
