"""`make msrv` compiles with the declared Rust version if rustup has it, and otherwise reports this and fails."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SCRIPT = ROOT / "tools/check_minimum_rust.sh"
INSTALL = "rustup toolchain install 1.89 --profile minimal"


@pytest.fixture
def check(tmp_path):
    """Runs the script with a rustup that lists the given toolchains (`None`: no rustup) and prints the commands it is given."""

    def run(toolchains):
        folder = tmp_path / "bin"
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir()
        for tool in ["sh", "sed", "head", "printf"]:
            os.symlink(shutil.which(tool), folder / tool)
        if toolchains is not None:
            listed = "\n".join(toolchains)
            rustup = folder / "rustup"
            rustup.write_text(f"#!/bin/sh\nif [ $1 = toolchain ]; then echo '{listed}'; else echo \"ran $*\"; fi\n")
            rustup.chmod(0o755)
        return subprocess.run(
            [folder / "sh", SCRIPT, "1.89", "out"], env={"PATH": str(folder)}, capture_output=True, text=True
        )

    return run


@pytest.mark.parametrize("toolchain", ["1.89-x86_64-unknown-linux-gnu", "1.89.1-x86_64-unknown-linux-gnu (default)"])
def test_t40_the_declared_toolchain_compiles(check, toolchain):
    """T-40. The toolchain is selected by its full name, with or without a patch number."""
    outcome = check(["stable-x86_64-unknown-linux-gnu", toolchain])
    assert outcome.returncode == 0, outcome.stderr
    assert f"ran run {toolchain.split()[0]} cargo check --locked --workspace --exclude foldwing-import --lib --bins --target-dir out" in outcome.stdout


@pytest.mark.parametrize(
    "toolchains",
    [
        ["stable-x86_64-unknown-linux-gnu", "1.95.0-x86_64-unknown-linux-gnu"],
        ["1.890-x86_64"],
        ["no installed toolchains"],
    ],
)
def test_t41_another_toolchain_is_no_substitute(check, toolchains):
    """T-41. Newer toolchains prove nothing: rejected with the line that installs the right one."""
    outcome = check(toolchains)
    assert outcome.returncode == 1 and "ran" not in outcome.stdout
    assert "Rust 1.89, the oldest that Cargo.toml declares, is not installed" in outcome.stderr
    assert INSTALL in outcome.stderr


def test_t42_without_rustup(check):
    """T-42. A Rust from the system's packages cannot be selected by version."""
    outcome = check(None)
    assert outcome.returncode == 1 and "rustup is missing" in outcome.stderr and INSTALL in outcome.stderr
