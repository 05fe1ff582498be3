#!/usr/bin/env python3
"""Runs stages of `make test` or `make validate` one after the other and prints the time of each, and the slowest tests.

  python tools/run_stages.py --times FOLDER [--keep-going] [--record TABLE] STAGE...

A stage is a target of the Makefile, or several joined by `+` that run at the same time. `stages.csv` is written to FOLDER, in
which the stages leave their times: `*.csv` with rows of seconds and test, `*.xml` of pytest. A stage that fails ends the run, as
in make, unless `--keep-going` is given; the exit code is that of the last failure. `--record` replaces the rows of these stages in
a Markdown table, right after each stage, so that an interrupted run leaves its complete stages.
"""
import argparse
import csv
import datetime
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
    parser.add_argument("--keep-going", action="store_true", help="run the remaining stages after a failure")
    parser.add_argument("--record", type=pathlib.Path, help="Markdown table of the last run of each stage")
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
        failure = subprocess.run([os.environ.get("MAKE", "make"), "--no-print-directory", *beside, *targets]).returncode
        rows.append((stage, time.monotonic() - began, processor_s() - spent))
        if arguments.record:
            record(arguments.record, rows[-1], "failed" if failure else "passed")
        code = failure or code
        if code and not arguments.keep_going:
            break
    report(arguments.times, rows)
    sys.exit(code)


TABLE = """# Last results of `make validate`

Written by `make validate`, stage by stage: date of the end, commit ("+": with changes), times on the clock and of the processor.

| stage | result | date | commit | seconds | processor s |
|---|---|---|---|---|---|
"""


def record(table, row, result):
    """Replaces the row of a stage in the table, or appends it."""
    stage, seconds, processor = row
    text = table.read_text(encoding="utf-8") if table.exists() else TABLE
    kept = [line for line in text.splitlines() if not line.startswith(f"| `{stage}` |")]
    date = datetime.date.today().isoformat()
    kept.append(f"| `{stage}` | {result} | {date} | {commit(table)} | {seconds:.0f} | {processor:.0f} |")
    table.write_text("\n".join(kept) + "\n", encoding="utf-8")


def commit(table):
    """Short hash of the commit, with "+" if files outside `docs`, in which the stages write, have changed."""
    def git(*words):
        return subprocess.run(["git", *words], cwd=table.parent, stdout=subprocess.PIPE, text=True).stdout.strip()

    changed = git("status", "--porcelain", "--untracked-files=no", "--", ":/", ":!/docs")
    return (git("rev-parse", "--short=8", "HEAD") or "none") + ("+" if changed else "")


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
