"""Files of a user (AF-1 to AF-4): whether a model, its inputs and measurements survive if a result is written to their path.

Expected: they are never overwritten; other files are overwritten only with --force; after a full disk or a signal the old file remains.
"""

from __future__ import annotations

import resource
import shutil
import signal
import subprocess
import time

from machine import CHECKOUT, FOLDWING, WORK

MODEL = CHECKOUT / "examples/models/folding_wing_in_tunnel.toml"
INPUTS = b"time,fold.angle_command\n0,0\n0.4,0.1\n"
FOREIGN = b"three weeks of measurements\n"
RUN = ["simulate", "wing.toml", "--inputs", "in.csv", "--stop", "1e-3", "-q"]
LINEAR = ["linearize", "wing.toml", "--state", "start", "--inputs", "fold.external_torque", "--outputs", "fold.angle", "-o"]
CASES = {
    "simulate --csv": ([*RUN, "--csv"], "x.csv"),
    "simulate --view": ([*RUN, "--view"], "x.html"),
    "simulate --strains": ([*RUN, "--csv", "-", "--strains"], "x.csv"),
    "simulate --profile": ([*RUN, "--csv", "-", "--profile"], "x.json"),
    "simulate --lattice": ([*RUN, "--csv", "-", "--lattice-at", "0", "--lattice"], "x.json"),
    "package -o": (["package", "wing.toml", "--no-reference", "-o"], "x.fmu"),
    "check --draw": (["check", "wing.toml", "--draw"], "x.svg"),
    "linearize -o x.npz": (LINEAR, "x.npz"),
    "linearize -o x.mat": (LINEAR, "x.mat"),
    "linearize -o x.json": (LINEAR, "x.json"),
    "sweep --output": (["sweep", *RUN[1:], "--vary", "fold.external_torque=0,1", "--output"], "x.csv"),
}


def lay_out() -> None:
    """Restores the model and its inputs."""
    shutil.copy(MODEL, WORK / "wing.toml")
    (WORK / "in.csv").write_bytes(INPUTS)


def call(*arguments: str, **options) -> subprocess.CompletedProcess:
    return subprocess.run([FOLDWING, *arguments], cwd=WORK, capture_output=True, **options)


def destroyed(arguments: list[str], target: str, source: str) -> bool:
    """Whether a command that writes to `target` changes `source`; links are created again for each command."""
    lay_out()
    before = (WORK / source).read_bytes()
    (WORK / target).unlink(missing_ok=True)
    (WORK / target).symlink_to(source)
    call(*arguments, target)
    return (WORK / source).read_bytes() != before


def main() -> None:
    own, foreign = [], []
    for name, (arguments, target) in CASES.items():
        for source in ("wing.toml", "in.csv"):
            if source in arguments and destroyed(arguments, target, source):
                own.append(f"{name} onto {source}")
        lay_out()
        (WORK / target).unlink(missing_ok=True)
        (WORK / target).write_bytes(FOREIGN)
        call(*arguments, target)
        if (WORK / target).read_bytes() != FOREIGN:
            foreign.append(name)
    print(f"own model or inputs destroyed through a link: {len(own)} (right: 0)", *own, sep="\n  ")
    print(f"somebody's file replaced without a question: {len(foreign)} (right: 0)", *foreign, sep="\n  ")

    lay_out()
    table = WORK / "run.csv"
    table.unlink(missing_ok=True)
    call("simulate", "wing.toml", "--stop", "0.02", "-q", "--csv", "run.csv")
    before = table.read_bytes()
    limit = {"preexec_fn": lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (8192, 8192))}
    full = call("simulate", "wing.toml", "--stop", "0.02", "-q", "--csv", "run.csv", **limit)
    print(f"full disk: exit code {full.returncode}, old table whole: {table.read_bytes() == before} (right: 4, True)")
    for number in (signal.SIGINT, signal.SIGKILL):
        table.write_bytes(before)
        process = subprocess.Popen([FOLDWING, "simulate", "wing.toml", "--stop", "1000", "-q", "--csv", "run.csv"], cwd=WORK)
        time.sleep(2.0)
        process.send_signal(number)
        process.wait()
        print(f"{number.name}: old table whole: {table.read_bytes() == before} (right: True)")


if __name__ == "__main__":
    main()
