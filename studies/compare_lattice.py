#!/usr/bin/env python3
"""Compares cost and lift of the vortex lattice with Ptera Software on the same case, in one run on one machine.

  pip install pterasoftware
  python studies/compare_lattice.py [--runs 2]

Runs `studies/ptera_uvlm.py` and `cargo bench -p foldwing-benches --bench lattice` alternately (fastest run of each) for the prescribed
and the free wake, and prints times, their ratio and the difference of the lift coefficients over the distance travelled. One thread
each.
"""
import argparse
import csv
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent


def ptera(wake: str, folder: pathlib.Path) -> float:
    """Seconds of the solver; the history goes to `folder`."""
    script = [sys.executable, str(ROOT / "studies" / "ptera_uvlm.py"), "--wake", wake, "--csv", str(folder / f"ptera_{wake}.csv")]
    text = subprocess.run(script, check=True, capture_output=True, text=True).stdout
    return float(re.search(r"solve_wall_s=([\d.]+)", text).group(1))


def lattice(folder: pathlib.Path) -> dict[str, float]:
    """Seconds by wake model, one thread."""
    bench = ["cargo", "bench", "--locked", "-p", "foldwing-benches", "--bench", "lattice", "--", str(folder)]
    text = subprocess.run(bench, check=True, capture_output=True, text=True, cwd=ROOT).stdout
    return {wake: float(seconds) for wake, seconds in re.findall(r"wake=(\w+) threads=1 seconds=([\d.]+)", text)}


def history(path: pathlib.Path) -> dict[float, float]:
    """Lift coefficient by distance travelled in chords."""
    with path.open() as file:
        return {round(float(row["t_V_over_c"]), 4): float(row["CL"]) for row in csv.DictReader(file)}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=2)
    runs = parser.parse_args().runs
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        theirs: dict[str, list[float]] = {"prescribed": [], "free": []}
        ours: dict[str, list[float]] = {"prescribed": [], "free": []}
        for _ in range(runs):
            for wake, seconds in lattice(folder).items():
                ours[wake].append(seconds)
            for wake in theirs:
                theirs[wake].append(ptera(wake, folder))
        for wake in theirs:
            other, own = min(theirs[wake]), min(ours[wake])
            print(f"{wake}: Ptera Software {other:.2f} s, lattice {own:.3f} s, {other / own:.0f} times faster")
            left, right = history(folder / f"ptera_{wake}.csv"), history(folder / f"lattice_{wake}.csv")
            for way in sorted(left.keys() & right.keys()):
                if way in (1.0, 2.0, 4.0, 8.0, 12.0):
                    difference = right[way] / left[way] - 1
                    print(f"  {way:4.0f} chords: {left[way]:.5f} {right[way]:.5f} ({difference:+.2%})")


if __name__ == "__main__":
    main()
