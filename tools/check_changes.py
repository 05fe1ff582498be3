#!/usr/bin/env python3
"""Checks the changes since a commit, for use before the next one: `make check`.

  python tools/check_changes.py [--since COMMIT] [--list]
  python tools/check_changes.py --renew target/test-times

The checks are the format of all files; clippy and the quick tests of the crates whose sources changed and of those that depend
on them, in the development build; the tests of the tools and the list of planted faults if these changed. Quick tests are those
not listed in `tests/slow_tests.txt`, which `--renew` writes from the times recorded by `make test`. `make test` runs all tests.
"""
import argparse
import csv
import os
import pathlib
import subprocess
import sys
import time

from run_rust_tests import programs, run

ROOT = pathlib.Path(__file__).resolve().parents[1]
CARGO = os.environ.get("CARGO", "cargo")
SLOW = ROOT / "tests/slow_tests.txt"
SLOW_S = 0.1

# Source folders, and the packages whose tests a change in them may break.
PACKAGES = {
    "crates/engine/": ["foldwing-engine", "foldwing-file", "foldwing-fmi", "foldwing-study", "foldwing-command", "foldwing"],
    "crates/file/": ["foldwing-file", "foldwing-fmi", "foldwing-study", "foldwing-command", "foldwing"],
    "crates/fmi/": ["foldwing-fmi", "foldwing-study", "foldwing-command", "foldwing"],
    "crates/fmu/": ["foldwing-fmu"],
    "crates/study/": ["foldwing-study", "foldwing-command", "foldwing"],
    "crates/command/": ["foldwing-command", "foldwing"],
    "crates/recording/": ["foldwing-recording", "foldwing-web", "foldwing-command", "foldwing"],
    "crates/web/": ["foldwing-web"],
    "Cargo.": ["foldwing-engine", "foldwing-file", "foldwing-fmi", "foldwing-study", "foldwing-command", "foldwing"],
    "src/": ["foldwing"],
}
# Folders, and the test programs of the package `foldwing` that read them.
PROGRAMS = {
    "crates/engine/": ["verification", "random", "robustness", "command"],
    "crates/file/": ["verification", "random", "robustness", "documents", "command"],
    "crates/fmi/": ["robustness", "command"],
    "crates/fmu/": ["robustness"],
    "crates/study/": ["documents", "command"],
    "crates/command/": ["documents", "command"],
    "crates/recording/": ["command"],
    "tests/machines/": ["random", "robustness"],
    "tests/verification/": ["verification"],
    "tests/random/": ["random"],
    "tests/robustness/": ["robustness"],
    "tests/documents/": ["documents"],
    "tests/command/": ["command"],
    "tests/reference/": ["verification"],
    "examples/": ["documents", "command", "robustness"],
    "modelDescription/": ["robustness"],
    "docs/": ["documents"],
    "README.md": ["documents"],
    "CHANGELOG.md": ["documents"],
    "CONTRIBUTING.md": ["documents"],
}
OTHERS = {
    "tools/": "tests/tooling",
    "tests/tooling/": "tests/tooling",
    "Makefile": "tests/tooling",
    "python/requirements": "tests/tooling",
}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--since", default="HEAD", help="commit; without it what is not committed counts, or else the last commit")
    parser.add_argument("--list", action="store_true", help="print what would run")
    parser.add_argument("--renew", type=pathlib.Path, metavar="FOLDER", help="write the list of slow tests from the times in this folder")
    given = parser.parse_args()
    if given.renew:
        SLOW.write_text(slow_tests(given.renew), encoding="utf-8")
        return
    began = time.monotonic()
    files = changed(given.since) or changed("HEAD~1")
    packages, tests, others = (chosen(files, table) for table in (PACKAGES, PROGRAMS, OTHERS))
    print(f"{len(files)} changed files; packages: {said(packages)}; test programs: {said(tests)}; Python tests: {said(others)}")
    if given.list:
        return
    failures = [name for name, work in steps(packages, tests, others, files) if not work()]
    print(f"make check: {'failed: ' + ', '.join(failures) if failures else 'passed'}, {time.monotonic() - began:.0f} s")
    left = [folder for folder in ("crates/python/", "python/", "tests/python/", "tests/fmi/") if any(file.startswith(folder) for file in files)]
    if left:
        print(f"not checked here: {', '.join(left)}: `make python`, `make pytest`")
    sys.exit(bool(failures))


def said(names):
    return ", ".join(names) or "none"


def changed(since):
    """Files that differ from a commit or are not tracked by git."""
    def lines(*command):
        return subprocess.run(["git", *command], cwd=ROOT, check=True, capture_output=True, text=True).stdout.splitlines()

    return sorted({*lines("diff", "--name-only", since), *lines("ls-files", "--others", "--exclude-standard")})


def chosen(files, table):
    """Entries of a table for some files, each once, in the order of the table."""
    names = (name for begin, names in table.items() if any(file.startswith(begin) for file in files)
             for name in (names if isinstance(names, list) else [names]))
    return list(dict.fromkeys(names))


def steps(packages, tests, others, files):
    """Name and action of each step."""
    def command(*words):
        return lambda: subprocess.run(words, cwd=ROOT).returncode == 0

    yield "format", command(CARGO, "fmt", "--check")
    if packages or tests:
        lints = [word for package in dict.fromkeys([*packages, "foldwing"]) for word in ("--package", package)]
        yield "lint", command(CARGO, "clippy", "--locked", "--all-targets", "--quiet", *lints, "--", "-D", "warnings")
        units = [word for package in packages if package != "foldwing" for word in ("--package", package)]
        if units:
            yield "unit tests", lambda: quick(["--lib", *units])
        if tests:
            yield "tests", lambda: quick([word for name in tests for word in ("--test", name)])
    if others:
        yield "tests of the tools", command(sys.executable, "-m", "pytest", "-q", *others)
    if any(file.startswith(("crates/", "tests/mutants/")) for file in files):
        yield "planted faults", command(sys.executable, "tools/mutants.py", "--check")


def slow_tests(folder):
    """Text of the list of slow tests: tests above the limit, by program and name."""
    names = []
    for table in ("rust.csv", "documents.csv"):
        with (folder / table).open(newline="", encoding="utf-8") as file:
            names += [name.replace(" (unit tests)", "") for seconds, name in csv.reader(file) if float(seconds) > SLOW_S]
    head = f"# Tests that take more than {SLOW_S} s in the release build; `make check` leaves them out. tools/check_changes.py --renew writes this."
    return "\n".join([head, *sorted(names)]) + "\n"


def quick(arguments):
    """Runs the quick tests of the programs that these arguments of `cargo test` build."""
    slow = [line for line in SLOW.read_text(encoding="utf-8").splitlines() if line and not line.startswith("#")]
    worst = 0
    for name, executable, folder in programs(["--profile", "dev", "--locked", *arguments]):
        skipped = [line.split("::", 1)[1] for line in slow if line.split("::", 1)[0] == name.split(" ")[0]]
        print(f"== {name}, without {len(skipped)} slow tests", flush=True)
        options = ["--exact", *(word for test in skipped for word in ("--skip", test))]
        worst = max(worst, abs(run(executable, folder, options)[0]))
    return not worst


if __name__ == "__main__":
    main()
