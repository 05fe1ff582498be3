"""Measures the overhead of Python: a run compared with the command, a step compared with the engine, a sweep on one core and on two; `make
bench-python`.

  python studies/python_cost.py --foldwing COMMAND [--rounds 20] [--variants 1000]

Needs a Python with the package `foldwing`, built from the same sources as the command. Prints a table with the targets. Runs alternate,
and the smallest time of each counts: processor time of runs and steps, wall-clock time of sweeps. Run nothing else: another program on
the second core affects the last row, where the processor time shows whether the work itself has increased.
"""

import argparse
import json
import os
import subprocess
import tempfile
import time
from pathlib import Path
from typing import Callable, Dict, List, Tuple

import numpy as np

import foldwing as fw

MODEL = Path(__file__).resolve().parents[1] / "examples/models/folding_wing.toml"
FEW = ["gauge.root.strain", "fold.latch_time"]
MAXIMUM_OVER_COMMAND, MAXIMUM_STEP_S, MINIMUM_GAIN = 0.05, 3e-6, 1.8
STOP_S, STEP_S = 4.0, 5e-4


def processor_s(work: Callable[[], object]) -> float:
    """Processor time in s of a piece of work."""
    begin = time.process_time()
    work()
    return time.process_time() - begin


def run_beside_command(wing: fw.Model, command: str, rounds: int) -> Tuple[float, float]:
    """Processor times in s of the same run from Python and from the command; for the command without program start and file output."""
    ours, theirs = [], []
    with tempfile.TemporaryDirectory() as folder:
        timing, table = Path(folder) / "timing.json", Path(folder) / "run.csv"
        named = [word for name in FEW for word in ("--variables", name)]
        words = [command, "simulate", str(MODEL), "--csv", str(table), "--profile", str(timing), "--quiet", "--force", "--stop", str(STOP_S), *named]
        for _ in range(rounds):
            subprocess.run(words, check=True)
            theirs.append(json.loads(timing.read_text())["processor_s"])
            ours.append(processor_s(lambda: wing.simulate(stop=STOP_S, outputs=FEW)))
    return min(ours), min(theirs)


def steps(wing: fw.Model, rounds: int) -> Tuple[float, float, float]:
    """Processor times in s of a communication step: in a loop in Python, in the same run inside the engine, and in the loop with an input
    set and an output read in each step."""
    count = round(STOP_S / STEP_S)

    def loop(work: Callable[[fw.Simulation], None]) -> float:
        sim = wing.start()
        return processor_s(lambda: work(sim)) / count

    def bare(sim: fw.Simulation) -> None:
        for point in range(1, count + 1):
            sim.step_to(point * STEP_S)

    def driven(sim: fw.Simulation) -> None:
        for point in range(1, count + 1):
            sim["fold.external_torque"] = 0.0
            sim.step_to(point * STEP_S)
            sim["fold.angle"]

    # stop time and step of the run are those of the loops; its single output is computed at every point
    inside = [processor_s(lambda: wing.simulate(stop=STOP_S, step=STEP_S, outputs="fold.angle")) / count for _ in range(rounds)]
    start = min(processor_s(lambda: wing.start()) for _ in range(rounds)) / count
    taken = [(loop(bare), loop(driven)) for _ in range(rounds)]
    return min(pair[0] for pair in taken), min(inside) - start, min(pair[1] for pair in taken)


def sweeps(wing: fw.Model, variants: int, rounds: int) -> Tuple[List[float], List[float], float]:
    """Wall-clock times in s of a sweep with one thread and with two, alternately; ratio of the processor time with two threads to that with
    one."""
    varied = {"fold.start_angle": np.linspace(0.5, 2.9, variants)}
    tables: Dict[int, fw.SweepResult] = {}
    times: Dict[int, List[float]] = {1: [], 2: []}
    used: Dict[int, List[float]] = {1: [], 2: []}
    for _ in range(rounds):
        for threads, taken in times.items():
            begin = time.perf_counter()
            used[threads].append(processor_s(lambda: tables.update({threads: wing.sweep(varied, stop=0.4, threads=threads, progress=False)})))
            taken.append(time.perf_counter() - begin)
    if not np.array_equal(tables[1]["gauge.root.strain.peak"], tables[2]["gauge.root.strain.peak"]):
        raise SystemExit("one thread and two give different results")
    return times[1], times[2], min(used[2]) / min(used[1])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--foldwing", default="target/release/foldwing", help="the command")
    parser.add_argument("--rounds", type=int, default=20, help="times that runs and steps are measured; sweeps a fifth of it")
    parser.add_argument("--variants", type=int, default=1000)
    arguments = parser.parse_args()
    wing = fw.load(MODEL)
    load = f", load {os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else ""
    print(f"package {fw.__version__}, {len(os.sched_getaffinity(0))} processors{load}\n")
    print("| what | target | measured | met |\n|---|---|---|---|")

    def row(what: str, target: str, measured: str, met: bool) -> None:
        print(f"| {what} | {target} | {measured} | {'yes' if met else '**no**'} |", flush=True)

    ours, theirs = run_beside_command(wing, arguments.foldwing, arguments.rounds)
    over = ours / theirs - 1.0
    row(f"`model.simulate` over `foldwing simulate`, {STOP_S:g} s of the wing", f"≤ {MAXIMUM_OVER_COMMAND:.0%}",
        f"{over:+.1%} ({1e3 * ours:.2f} over {1e3 * theirs:.2f} ms)", over <= MAXIMUM_OVER_COMMAND)
    bare, inside, driven = steps(wing, arguments.rounds)
    row(f"`sim.step_to` of {1e3 * STEP_S:g} ms beyond the same step inside the engine", f"≤ {1e6 * MAXIMUM_STEP_S:g} µs",
        f"{1e6 * (bare - inside):+.2f} µs ({1e6 * bare:.2f} over {1e6 * inside:.2f} µs)", bare - inside <= MAXIMUM_STEP_S)
    row("the same with an input set and an output read in each step", f"≤ {1e6 * MAXIMUM_STEP_S:g} µs",
        f"{1e6 * (driven - inside):+.2f} µs", driven - inside <= MAXIMUM_STEP_S)
    one, two, work = sweeps(wing, arguments.variants, max(1, arguments.rounds // 5))
    gain = min(one) / min(two)
    row(f"`model.sweep`, {arguments.variants} variants, two threads over one", f"≥ {MINIMUM_GAIN:g} ×",
        f"{gain:.2f} × ({min(one):.2f} over {min(two):.2f} s; processor time {work:.2f} ×)", gain >= MINIMUM_GAIN)


if __name__ == "__main__":
    main()
