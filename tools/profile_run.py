#!/usr/bin/env python3
"""Counts the instructions of a run of `foldwing simulate` under valgrind's callgrind, by part of the program.

  make profile
  python tools/profile_run.py --foldwing COMMAND [--model MODEL.toml] [--output NAME]... [--step S]

The command must contain symbols (`make profile` builds one in target/profile). Counts do not depend on the load of
the computer. Only the work after the model has been read is counted: initialisation, steps, outputs, rows. Needs
valgrind (Debian: valgrind).
"""
import argparse
import collections
import pathlib
import re
import subprocess
import sys
import tempfile

# Functions that are reported, in order; their callees are included unless they are in the list themselves.
PARTS = {
    "residual beside its sweep": r"multibody::dynamics::residual$",
    "forces for outputs beside their sweep": r"multibody::dynamics::wrenches$",
    "sweep of poses, velocities, accelerations": r"multibody::kinematics::sweep_(poses|motion)$",
    "factorisation": r"multibody::factor::factorize$",
    "solution": r"multibody::factor::solve$",
    "error norm": r"multibody::norm::kinematic_norm$",
    "powers of the energy account": r"Equations as foldwing_engine::solve::EquationsOfMotion>::powers$",
    "outputs beside sweep and forces": r"Plant>::evaluate_some$",
    "dense output": r"solve::continuation::Taken::fill$",
    "attitudes": r"remember_attitudes$",
    "predictors, sums of stages, step control": r"Plant>::(step|attempt|advance|march)$",
    "start": r"Plant>::initialize$",
    "rows": r"cli::simulate::Run<W>::through$",
}


def read(path):
    """Instructions of each function without its callees, and per call from one function to another."""
    names, own, calls = {}, collections.Counter(), collections.Counter()

    def name(text):
        number, known = re.match(r"\((\d+)\)(?: (.*))?", text).groups()
        if known:
            names[number] = re.sub(r"'\d+$", "", known)
        return names[number]

    function = callee = None
    for line in path.read_text().splitlines():
        if line.startswith("fn="):
            function = name(line[3:])
        elif line.startswith("cfn="):
            callee = name(line[4:])
        elif re.match(r"[0-9+*-]\S* \d", line):
            count = int(line.split()[1])
            if callee:
                calls[function, callee] += count
                callee = None
            else:
                own[function] += count
    return own, calls


def shares(own, calls):
    """Instructions per part: those of its function, including callees that are not parts, one level of nesting after
    the other; a callee of several parts is divided in proportion to the instructions that each spends in it."""
    inclusive = collections.Counter(own)
    callers = collections.defaultdict(list)
    for (caller, callee), count in calls.items():
        if caller != callee:
            inclusive[caller] += count
            callers[callee].append((caller, count))
    part_of = {function: part for function in inclusive for part, pattern in PARTS.items() if re.search(pattern, function)}
    weights = {function: {part: 1.0} for function, part in part_of.items()}
    # callers have more instructions than their callees: weights are passed on from the largest to the smallest
    for function in sorted(inclusive, key=inclusive.get, reverse=True):
        known = [(weights[caller], count) for caller, count in callers[function] if caller in weights]
        spent = sum(count for _, count in known)
        if function not in weights and spent:
            weights[function] = collections.Counter()
            for shared, count in known:
                for part, weight in shared.items():
                    weights[function][part] += weight * count / spent
    total = collections.Counter()
    for function, count in own.items():
        for part, weight in weights.get(function, {}).items():
            total[part] += weight * count
    return total


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--foldwing", required=True, help="the command, with symbols")
    parser.add_argument("--model", default="examples/models/folding_wing.toml")
    parser.add_argument("--output", action="append", default=[], help="columns; default: all")
    parser.add_argument("--step", help="communication step in s; default: the model's")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        profile = pathlib.Path(folder) / "callgrind.out"
        command = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={profile}", "--dump-instr=no",
                   arguments.foldwing, "simulate", arguments.model, "--csv", "/dev/null", "--quiet"]
        command += [word for name in arguments.output for word in ("--variables", name)]
        command += ["--step", arguments.step] if arguments.step else []
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode:
            sys.exit(done.stderr)
        own, calls = read(profile)
    found = shares(own, calls)
    whole = sum(found.values())
    if not found["residual beside its sweep"]:
        sys.exit(f"{arguments.foldwing} has no symbols: build it with `make profile`")
    print(f"{arguments.model}: {whole / 1e6:.1f} million instructions\n\n| part | million | share |\n|---|---|---|")
    for part in sorted(found, key=found.get, reverse=True):
        print(f"| {part} | {found[part] / 1e6:.2f} | {100 * found[part] / whole:.1f} % |")


if __name__ == "__main__":
    main()
