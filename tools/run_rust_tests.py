#!/usr/bin/env python3
"""Builds the Rust test programs of a profile and runs them one after the other, and records the time of every test.

  python tools/run_rust_tests.py --times target/test-times/rust.csv --release --locked [CARGO ARGUMENTS] [-- TEST ARGUMENTS]
  python tools/run_rust_tests.py --long --times target/test-times/long.csv --release --locked [CARGO ARGUMENTS]
  python tools/run_rust_tests.py --long-follows --times target/test-times/rust.csv --release --locked [CARGO ARGUMENTS]

`cargo test` runs the same programs but does not report times. The programs report them with an option that the standard test
harness of a stable compiler offers only if RUSTC_BOOTSTRAP is set; it is set for the programs alone, never for the compiler. All
programs run even if one fails; the exit code is the worst of all programs. Documentation tests are left to `cargo test --doc`.
Unit tests of some packages are compiled without optimisation (tools/rustc_of_tests.sh), unless RUSTC_WRAPPER is set already.
With `--long` only the tests run that are ignored because they are long, and those of which `make test` runs a share of the cases.
With `--long-follows` the latter are left to the run with `--long`.
"""
import csv
import json
import os
import pathlib
import re
import subprocess
import sys

CARGO = os.environ.get("CARGO", "cargo")
ROOT = pathlib.Path(__file__).resolve().parent.parent
LONG = re.compile(r"^ *#\[ignore = \"long; `make long` runs it\"\]\n *fn (\w+)\(", re.M)
# Tests over many similar cases: `make test` sets FOLDWING_SHARE, the tests take one case in that many (tests/verification/share.rs).
SHARED = {
    "gr82_gradients_are_those_of_runs_with_the_same_steps",
    "m01_mutated_models",
    "me21_declared_dependencies_have_no_false_zero",
    "mutated_bytes_never_panic",
    "nasty_values_never_panic",
    "p94_forged_snapshots_give_no_nan",
    "rc01_random_calls",
    "strange_machines_are_taken_or_refused",
    "v03_residual_equals_dense_form",
    "v04_solve_equals_dense_cholesky",
    "x02_turned_machines_move_alike",
    "x03_mirror_images_move_alike",
    "x04_energy_accounts_are_closed",
    "x05_states_are_whole",
    "x06_communication_steps_do_not_matter",
    "x07_files_give_one_machine",
    "x08_frames_that_move_along_see_one_motion",
    "x09_exchanged_derivatives_are_those_of_the_motion",
    "x11_rows_of_linear_models_are_those_of_the_machine",
    "x13_gradients_are_the_same_both_ways",
    "x16_skates_and_wheels_do_not_slip",
    "x17_machines_with_several_airs",
    "x18_machines_with_electrical_motors",
    "x19_machines_with_cylindrical_joints",
    "x20_machines_with_rotors_in_model_exchange",
    "x21_derivatives_in_co_simulation_are_those_of_the_shown_outputs",
}
LINE = re.compile(r"test (?P<name>\S+)(?: - should panic)? \.\.\. ok <(?P<seconds>[\d.]+)s>$")


def programs(arguments):
    """Name, file and folder of each test program; builds the programs first."""
    command = [CARGO, "test", "--no-run", "--message-format=json-render-diagnostics", *arguments]
    environment = dict(os.environ)
    if "--release" in arguments:
        environment.setdefault("RUSTC_WRAPPER", str(ROOT / "tools/rustc_of_tests.sh"))
    built = subprocess.run(command, stdout=subprocess.PIPE, text=True, env=environment)
    if built.returncode:
        sys.exit(built.returncode)
    for line in built.stdout.splitlines():
        message = json.loads(line)
        if message.get("reason") == "compiler-artifact" and message["profile"]["test"] and message["executable"]:
            folder = pathlib.Path(message["manifest_path"]).parent
            kind = "" if "test" in message["target"]["kind"] else " (unit tests)"
            yield message["target"]["name"] + kind, message["executable"], folder


def long_tests():
    """Names of the test functions that are ignored because they are long."""
    sources = [path for folder in ("tests", "crates") for path in (ROOT / folder).rglob("*.rs")]
    return {name for path in sources for name in LONG.findall(path.read_text(encoding="utf-8"))}


def listed_tests(executable, folder):
    """Paths of the tests of a program."""
    listed = subprocess.run([executable, "--list"], cwd=folder, stdout=subprocess.PIPE, text=True, check=True)
    return [line.removesuffix(": test") for line in listed.stdout.splitlines() if line.endswith(": test")]


def run(executable, folder, arguments):
    """Exit code of a program and the seconds of each of its tests; its output is passed on."""
    environment = {**os.environ, "RUSTC_BOOTSTRAP": "1", "CARGO_MANIFEST_DIR": str(folder)}
    options = ["-Z", "unstable-options", "--report-time"]
    times = []
    with subprocess.Popen(
        [executable, *options, *arguments], cwd=folder, env=environment, stdout=subprocess.PIPE, text=True
    ) as process:
        for line in process.stdout:
            passed = LINE.match(line.strip())
            if passed:
                times.append((passed["name"], float(passed["seconds"])))
            else:
                print(line, end="", flush=True)
    return process.returncode, times


def main():
    arguments = sys.argv[1:]
    table, long, long_follows = None, arguments[:1] == ["--long"], arguments[:1] == ["--long-follows"]
    arguments = arguments[long or long_follows :]
    if arguments[:1] == ["--times"]:
        table, arguments = pathlib.Path(arguments[1]), arguments[2:]
    split = arguments.index("--") if "--" in arguments else len(arguments)
    for_cargo, for_tests = arguments[:split], arguments[split + 1 :]
    if long_follows:
        for_tests += [word for test in sorted(SHARED) for word in ("--skip", test)]
    worst, rows, left = 0, [], long_tests() | SHARED if long else set()
    for name, executable, folder in programs(for_cargo):
        chosen = for_tests
        if long:
            chosen = [path for path in listed_tests(executable, folder) if path.rsplit("::", 1)[-1] in left]
            left -= {path.rsplit("::", 1)[-1] for path in chosen}
            if not chosen:
                continue
            chosen = ["--include-ignored", "--exact", *chosen]
        print(f"== {name}", flush=True)
        code, times = run(executable, folder, chosen)
        worst = max(worst, abs(code))
        rows += [(seconds, f"{name}::{test}") for test, seconds in times]
    if table:
        table.parent.mkdir(parents=True, exist_ok=True)
        with table.open("w", newline="") as file:
            csv.writer(file).writerows(sorted(rows, reverse=True))
    if left:
        sys.exit(f"no program has the long tests {', '.join(sorted(left))}")
    sys.exit(worst)


if __name__ == "__main__":
    main()
