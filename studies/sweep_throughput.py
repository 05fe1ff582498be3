"""Variants per second of `foldwing sweep` with one thread and with two, alternately: `make bench-sweep`.

Runs alternate because other programs on the computer disturb them; the smallest wall-clock times are compared. Needs only Python's
standard library.
"""

import argparse
import os
import subprocess
import tempfile
import time
from pathlib import Path

MODEL = Path(__file__).resolve().parent.parent / "examples" / "models" / "folding_wing.toml"


def sweep_s(foldwing: str, variants: int, threads: int, folder: Path) -> float:
    """Wall-clock time in s of a sweep over start angles with a deployment of 0.4 s each."""
    out = folder / f"{threads}.csv"
    for path in (out, Path(f"{out}.sweep")):
        path.unlink(missing_ok=True)
    begin = time.perf_counter()
    subprocess.run(
        [foldwing, "sweep", MODEL, "--vary", f"fold.start_angle=0.5:2.9:{variants}", "--output", out]
        + ["--variables", "tip.position.z", "--threads", str(threads), "--quiet"],
        check=True,
    )
    return time.perf_counter() - begin


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--foldwing", default="target/release/foldwing", help="the command")
    parser.add_argument("--variants", type=int, default=400)
    parser.add_argument("--rounds", type=int, default=5)
    arguments = parser.parse_args()
    times = {1: [], 2: []}
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(arguments.rounds):
            for threads, taken in times.items():
                taken.append(sweep_s(arguments.foldwing, arguments.variants, threads, Path(folder)))
        one, two = ((Path(folder) / f"{threads}.csv").read_bytes() for threads in times)
    if one != two:
        raise SystemExit("one thread and two give different results")
    load = f", load {os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else ""
    print(f"{arguments.variants} deployments of 0.4 s, {arguments.rounds} rounds, {os.cpu_count()} processors{load}")
    for threads, taken in times.items():
        print(f"{threads} thread{'s' * (threads > 1)}: {arguments.variants / min(taken):.1f} variants/s, least {min(taken):.3f} s")
    print(f"two threads over one: {min(times[1]) / min(times[2]):.2f}")


if __name__ == "__main__":
    main()
