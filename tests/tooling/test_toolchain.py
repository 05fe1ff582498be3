"""Output of `make` if something is missing or too old: one line to type for each."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SCRIPT = ROOT / "tools/check_toolchain.sh"
SYSTEM_TOOLS = ["sh", "awk", "printf", "sed"]
GOOD = {
    "cargo": "echo cargo 1.95.0",
    "rustc": "echo 'rustc 1.95.0-nightly (abc 2026-01-01)'",
    "cc": "exit 0",
    "python3": "echo 3.11",
    "apt-get": "exit 0",
}


@pytest.fixture
def check(tmp_path):
    """Runs the check on a computer that has only the given commands, as shell one-liners."""

    def run(commands, make_version="4.3"):
        folder = tmp_path / "bin"
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir()
        for tool in SYSTEM_TOOLS:
            os.symlink(shutil.which(tool), folder / tool)
        for name, line in commands.items():
            (folder / name).write_text(f"#!/bin/sh\n{line}\n")
            (folder / name).chmod(0o755)
        return subprocess.run(
            [folder / "sh", SCRIPT, "1.89", "3.9", make_version], env={"PATH": str(folder)}, capture_output=True, text=True
        )

    return run


def without(*names):
    """A complete computer except for some commands."""
    return {name: line for name, line in GOOD.items() if name not in names}


def test_t10_complete_machine_passes_in_silence(check):
    """T-10. Nothing is printed if nothing is missing; 1.95 is newer than 1.89 and 3.11 newer than 3.9."""
    outcome = check(GOOD)
    assert (outcome.returncode, outcome.stdout, outcome.stderr) == (0, "", "")


@pytest.mark.parametrize(
    "commands, words, line",
    [
        (without("cargo"), "cargo (Rust 1.89 or newer) is missing", "sh.rustup.rs"),
        ({**GOOD, "rustc": "echo rustc 1.75.0"}, "Rust 1.75.0 is too old", "sh.rustup.rs"),
        ({**GOOD, "rustc": "echo rustc 1.75.0", "rustup": "exit 0"}, "Rust 1.75.0 is too old", "rustup update stable"),
        (without("cc"), "a C compiler (cc) is missing", "sudo apt-get install -y build-essential"),
        (without("python3"), "python3 (3.9 or newer) is missing", "sudo apt-get install -y python3"),
        ({**GOOD, "python3": "echo 3.6"}, "Python 3.6; 3.9 or newer", "sudo apt-get install -y python3"),
        ({**without("cc", "apt-get"), "dnf": "exit 0"}, "C compiler", "sudo dnf install -y gcc"),
        (without("cc", "apt-get"), "C compiler", "your system's package manager"),
    ],
)
def test_t11_each_gap_is_named_with_the_line_to_type(check, commands, words, line):
    """T-11. Everything missing or too old is named, followed by one line that remedies it; the check fails."""
    outcome = check(commands)
    assert outcome.returncode != 0
    complaint, remedy = outcome.stderr.splitlines()
    assert words in complaint
    assert remedy.strip().startswith("type: ") or "package manager" in remedy
    assert line in remedy


def test_t12_old_make_is_named(check):
    """T-12. GNU make before 3.81 is named."""
    assert "GNU make 3.80 is too old" in check(GOOD, make_version="3.80").stderr


def test_t13_all_gaps_are_named_at_once(check):
    """T-13. On an empty computer everything missing is named at once, not one item per attempt."""
    outcome = check({})
    assert [word in outcome.stderr for word in ("cargo", "C compiler", "python3")] == [True] * 3
