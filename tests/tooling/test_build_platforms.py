"""How `make fmu-all` builds the Windows library, and its message if there is no way."""

import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = Path(__file__).resolve().parents[2] / "tools/build_platforms.py"
TARGET = "x86_64-pc-windows-gnu"


@pytest.fixture
def routes(tmp_path):
    """Output and exit code of the script on a computer that has only the given commands, as shell lines."""

    def run(commands, *platforms, look=True):
        folder = tmp_path / "bin"
        folder.mkdir()
        for name, line in commands.items():
            (folder / name).write_text(f"#!/bin/sh\n{line}\n")
            (folder / name).chmod(0o755)
        command = [sys.executable, SCRIPT, "--venv", tmp_path / "venv", "--output", tmp_path / "out", *platforms]
        command += ["--routes"] * look
        return subprocess.run(command, env={"PATH": str(folder)}, capture_output=True, text=True)

    return run


def compiler(version, sysroot):
    """A Rust compiler in one shell line."""
    return f"case $1 in --print) echo {sysroot};; *) echo 'rustc {version} (abc 2026-01-01)';; esac"


@pytest.fixture
def sources(tmp_path):
    """Root of a compiler with the sources of its standard library."""
    manifest = tmp_path / "root/lib/rustlib/src/rust/library/std/Cargo.toml"
    manifest.parent.mkdir(parents=True)
    manifest.touch()
    return tmp_path / "root"


def test_t20_target_of_rustup_is_taken_first(routes, sources):
    """T-20. If rustup has the target, nothing else is checked."""
    outcome = routes({"rustup": f"echo {TARGET}", "rustc": compiler("1.96.0", sources)})
    assert outcome.returncode == 0, outcome.stderr
    assert "win64: by rustup's target" in outcome.stdout
    assert "linux64: by this Rust compiler" in outcome.stdout


def test_t21_sources_are_the_second_route(routes, sources):
    """T-21. If rustup lacks the target, a compiler with its standard library's sources is used, and named."""
    outcome = routes({"rustup": "exit 1", "rustc": compiler("1.96.0", sources)}, "win64")
    assert outcome.returncode == 0, outcome.stderr
    assert "win64: by the standard library built from the sources of rustc 1.96.0" in outcome.stdout
    assert "linux64" not in outcome.stdout


@pytest.mark.parametrize("version", ["1.85.0", ""])
def test_t22_compiler_that_is_too_old_is_no_route(routes, sources, version):
    """T-22. Debian's older compiler (1.85) cannot build this package; a compiler without a version is not used either."""
    outcome = routes({"rustc": compiler(version, sources)}, "win64")
    assert outcome.returncode != 0
    assert "no standard library for Windows" in outcome.stderr


def test_t23_what_is_missing_is_said_with_the_line_to_type(routes):
    """T-23. Without any way to build, both lines that remedy this are printed, and nothing is installed."""
    outcome = routes({"rustup": "exit 1", "apt-get": "echo installed"}, "win64", look=False)
    assert outcome.returncode != 0
    assert f"rustup target add {TARGET}" in outcome.stderr
    assert "sudo apt-get install -y rustc-web rust-web-src" in outcome.stderr
    assert "installed" not in outcome.stdout


def test_t24_unknown_platform_is_refused_with_the_known_ones(routes):
    """T-24. A misspelt platform name."""
    outcome = routes({}, "windows")
    assert outcome.returncode == 2
    assert "unknown platform windows; allowed: linux64, win64" in outcome.stderr
