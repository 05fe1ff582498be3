#!/usr/bin/env python3
"""Runs stages of `make test` one after the other and prints the time of each, and the slowest tests.

  python tools/run_stages.py --times FOLDER STAGE...

A stage is a target of the Makefile, or several joined by `+` that run at the same time. `stages.csv` is written to FOLDER, in
which the stages leave their times: `*.csv` with rows of seconds and test, `*.xml` of pytest. A stage that fails ends the run, as
in make.
"""
import argparse
import csv
import os
import pathlib
import resource
import subprocess
import sys
import time
import xml.etree.ElementTree as xml

SLOWEST = 50


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--times", type=pathlib.Path, required=True, help="folder of the tables")
    parser.add_argument("stages", nargs="+")
    arguments = parser.parse_args()
    arguments.times.mkdir(parents=True, exist_ok=True)
    for old in arguments.times.iterdir():
        old.unlink()
    rows, code = [], 0
    for stage in arguments.stages:
        print(f"== {stage}", flush=True)
        began, spent = time.monotonic(), processor_s()
        targets = stage.split("+")
        beside = [f"-j{len(targets)}", "--output-sync=target"] if len(targets) > 1 else []
        code = subprocess.run([os.environ.get("MAKE", "make"), "--no-print-directory", *beside, *targets]).returncode
        rows.append((stage, time.monotonic() - began, processor_s() - spent))
        if code:
            break
    report(arguments.times, rows)
    sys.exit(code)


def processor_s():
    """Processor time of all child processes that have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def report(folder, rows):
    """Prints the tables and saves that of the stages."""
    with (folder / "stages.csv").open("w", newline="") as file:
        csv.writer(file).writerows([("stage", "seconds", "processor_s"), *rows])
    tests = sorted(measured(folder), reverse=True)[:SLOWEST]
    print(f"\nslowest {len(tests)} tests, seconds on the clock, several at a time:")
    for seconds, name in tests:
        print(f"  {seconds:7.2f}  {name}")
    print("\nstage                     seconds  processor s")
    for stage, seconds, processor in [*rows, ("sum", *(sum(row[i] for row in rows) for i in (1, 2)))]:
        print(f"{stage:<24} {seconds:8.0f} {processor:12.0f}")


def measured(folder):
    """Seconds and name of each test recorded by a stage."""
    for table in folder.glob("*.csv"):
        if table.name != "stages.csv":
            with table.open(newline="") as file:
                yield from ((float(row[0]), row[1]) for row in csv.reader(file))
    for table in folder.glob("*.xml"):
        for case in xml.parse(table).iter("testcase"):
            yield float(case.get("time", 0.0)), f"{case.get('classname')}::{case.get('name')}"


if __name__ == "__main__":
    main()
