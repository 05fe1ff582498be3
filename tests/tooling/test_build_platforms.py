"""How `make fmu-all` builds libraries for other platforms, and its message if there is no way."""

import importlib
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

SCRIPT = Path(__file__).resolve().parents[2] / "tools/build_platforms.py"
TARGET = "x86_64-pc-windows-gnu"
sys.path.insert(0, str(SCRIPT.parent))


@pytest.fixture
def routes(tmp_path):
    """Output and exit code of the script on a computer that has only the given commands, as shell lines."""

    def run(commands, *platforms, look=True, options=()):
        folder = tmp_path / "bin"
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir()
        for name, line in commands.items():
            (folder / name).write_text(f"#!/bin/sh\n{line}\n")
            (folder / name).chmod(0o755)
        command = [sys.executable, SCRIPT, "--venv", tmp_path / "venv", "--output", tmp_path / "out", *platforms, *options]
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
    assert f"no standard library for {TARGET}" in outcome.stderr


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
    assert "unknown platform windows; allowed: linux64, win64, aarch64-linux, darwin64, aarch64-darwin" in outcome.stderr


def test_n16_other_platforms_are_built_on_request_alone(routes, sources):
    """N-16. Without names Linux and Windows; ARM64 Linux by the sources of the standard library, with the target in the message if neither
    these nor rustup's target are present; no wheels for platforms that have none."""
    rustc = compiler("1.96.0", sources)
    outcome = routes({"rustup": f"echo {TARGET}", "rustc": rustc})
    assert [line.split(":")[0] for line in outcome.stdout.splitlines()] == ["linux64", "win64"]
    outcome = routes({"rustup": f"echo {TARGET}", "rustc": rustc}, "aarch64-linux")
    assert "aarch64-linux: by the standard library built from the sources of rustc 1.96.0" in outcome.stdout
    outcome = routes({"rustup": f"echo {TARGET}", "rustc": "exit 1"}, "aarch64-linux")
    assert outcome.returncode != 0 and "rustup target add aarch64-unknown-linux-gnu" in outcome.stderr
    outcome = routes({}, "linux64", "darwin64", options=["--wheels", "x.whl"])
    assert outcome.returncode == 2 and "no wheel is made for darwin64; allowed with --wheels: linux64, win64" in outcome.stderr


def test_n17_macos_needs_a_linker_that_leaves_rust_symbols_out(routes, sources, tmp_path):
    """N-17. Libraries for macOS are linked by the lld of a Rust toolchain, otherwise by the newest on the path, and not without one."""
    rustup = "echo aarch64-apple-darwin"
    rustc = compiler("1.96.0", sources)
    outcome = routes({"rustup": rustup, "rustc": rustc}, "aarch64-darwin")
    assert outcome.returncode != 0 and "no linker for macOS" in outcome.stderr and "sudo apt-get install -y lld" in outcome.stderr
    outcome = routes({"rustup": rustup, "rustc": rustc, "lld-9": "", "lld-22": "", "lld-link-30": ""}, "aarch64-darwin")
    assert outcome.stdout == "aarch64-darwin: by rustup's target, linked by lld-22\n"
    own = sources / "lib/rustlib/x86_64-unknown-linux-gnu/bin/rust-lld"
    own.parent.mkdir(parents=True)
    own.touch()
    outcome = routes({"rustup": rustup, "rustc": rustc}, "darwin64")
    assert outcome.stdout.startswith("darwin64: by the standard library built from the sources of rustc 1.96.0")
    assert outcome.stdout.endswith(", linked by rust-lld\n")


def test_n18_a_server_that_does_not_answer_is_given_up(tmp_path, monkeypatch, capsys):
    """N-18. Where rustup waits for its server without end, it is stopped after the limit, and the next route is taken."""
    build_platforms = importlib.import_module("build_platforms")
    monkeypatch.setattr(build_platforms, "RUSTUP_LIMIT_S", 0.5)
    waiting = tmp_path / "rustup"
    waiting.write_text("#!/bin/sh\nexec sleep 60\n")
    waiting.chmod(0o755)
    begin_s = time.monotonic()
    assert not build_platforms.added(str(waiting), TARGET)
    assert time.monotonic() - begin_s < 20
    assert f"rustup did not install {TARGET} within 0.5 s" in capsys.readouterr().out
