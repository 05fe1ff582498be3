"""What Python costs beside the command and the engine. The figures go to docs/BENCHMARKS.md by hand."""

import json
import os
import subprocess
import time

import numpy as np
import pytest

MODEL = "examples/models/folding_wing.toml"
FEW = ["gauge.root.strain", "fold.latch_time"]

# times are no matter of every run: FOLDWING_COST=1 make python
pytestmark = pytest.mark.skipif("FOLDWING_COST" not in os.environ, reason="times; FOLDWING_COST=1 asks for them")


def best(work, times):
    """Shortest of so many processor times in s: what the machine's other work adds only makes longer."""
    spans = []
    for _ in range(times):
        begin = time.process_time()
        work()
        spans.append(time.process_time() - begin)
    return min(spans)


def test_a_run_costs_what_it_costs_the_command(wing, command, tmp_path):
    """At most 5 % over the run of the command, both in processor time and without start and file."""
    timing, out = tmp_path / "timing.json", tmp_path / "out.csv"
    named = [word for name in FEW for word in ("--output", name)]
    spans = []
    for _ in range(8):
        subprocess.run([command, "simulate", MODEL, "--csv", out, "--timing", timing, "-q", "--stop", "4", *named], check=True)
        spans.append(json.loads(timing.read_text())["processor_s"])
    theirs = min(spans)
    ours = best(lambda: wing.simulate(until=4.0, outputs=FEW), 8)
    print(f"4 s of the wing: {1e3 * ours:.2f} ms from Python, {1e3 * theirs:.2f} ms by the command, {ours / theirs - 1:+.1%}")
    assert ours < 1.05 * theirs


def test_a_step_costs_little_beyond_the_engine(wing):
    """Steps far below those of the integrator, with an input set and an output read: at most 3 µs each."""
    sim = wing.start(set={"fold.release": False})
    sim.step(0.5)
    count = 20_000

    def steps():
        for _ in range(count):
            sim.step(1e-9)

    def reads():
        for _ in range(count):
            sim["fold.angle"]

    step, read = best(steps, 5) / count, best(reads, 5) / count
    print(f"a step within the integrator's own: {1e6 * step:.2f} µs, a reading {1e6 * read:.2f} µs")
    assert step < 3e-6


@pytest.mark.skipif(len(os.sched_getaffinity(0)) < 2, reason="two cores")
def test_a_sweep_uses_two_cores(wing):
    """1000 variants: the wall time falls by 1.8 on two quiet cores. On a busy machine the share of the processor is held against
    it: what two threads could use at all is measured with two runs that share nothing."""
    variants = {"fold.start_angle": np.linspace(1.5, 2.9, 1000)}

    def wall(threads):
        begin, used = time.perf_counter(), time.process_time()
        wing.sweep(variants, until=0.2, threads=threads)
        return time.perf_counter() - begin, time.process_time() - used

    (one, one_used), (two, two_used) = wall(1), wall(2)
    print(f"1000 variants: {one:.2f} s on one core, {two:.2f} s on two: {one / two:.2f} times")
    # the work itself must not grow; where the other core is taken, the wall cannot fall
    assert two_used < 1.1 * one_used
    if one_used > 0.95 * one and two_used > 1.9 * two:
        assert one / two > 1.8
