#!/usr/bin/env python3
"""Builds the shared library for every platform that this machine can build for, into one folder each.

    linux64  needs nothing newer than glibc 2.17 (2012) where it runs
    win64    needs nothing but Windows 10

Zig links both, from packages pinned in python/platforms.txt (no root, no system packages). For Windows the Rust
standard library must be there too; the first of these routes is taken:

    rustup   `rustup target add x86_64-pc-windows-gnu`
    source   a Rust compiler with the sources of its own standard library (Debian: rustc-web, rust-web-src), from
             which the standard library is built along

Nothing is installed but Python packages into the environment that is named, and the target of rustup. What is missing
is said with the line to type. No path of this machine stands in the libraries.
"""

import argparse
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

from create_venv import interpreter

ROOT = Path(__file__).resolve().parents[1]
GLIBC = "2.17"
LINUX = "x86_64-unknown-linux-gnu"
WINDOWS = "x86_64-pc-windows-gnu"
FILES = {"linux64": (LINUX, "libfoldwing_fmu.so"), "win64": (WINDOWS, "foldwing_fmu.dll")}
TO_TYPE = """\
    with rustup:          rustup target add x86_64-pc-windows-gnu
    on Debian or Ubuntu:  sudo apt-get install -y rustc-web rust-web-src"""


class Missing(Exception):
    """A tool that is not there, with the line to type."""


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("platforms", nargs="*", help="linux64, win64 [default: both]")
    parser.add_argument("--venv", type=Path, required=True, help="environment made from python/platforms.txt")
    parser.add_argument("--output", type=Path, required=True, help="folder for the libraries, one folder per platform")
    parser.add_argument("--routes", action="store_true", help="say what would be done and do nothing")
    arguments = parser.parse_args()
    platforms = arguments.platforms or list(FILES)
    unknown = sorted(set(platforms) - set(FILES))
    if unknown:
        parser.error(f"unknown platform {', '.join(unknown)}; allowed: {', '.join(FILES)}")
    missing = []
    for platform in platforms:
        try:
            compiler, route = (None, "this Rust compiler") if platform == "linux64" else windows_route(arguments.routes)
        except Missing as error:
            missing.append(f"{platform}: {error}")
            continue
        print(f"{platform}: by {route}", flush=True)
        if not arguments.routes:
            library = build(platform, compiler, arguments.venv.resolve(), arguments.output.resolve())
            print(f"{platform}: {library} ({library.stat().st_size / 1e6:.2f} MB)", flush=True)
    if missing:
        sys.exit("build_platforms: not everything can be built here\n" + "\n".join(missing))


def windows_route(only_look):
    """A compiler that must build its standard library, or None, and the route in words."""
    rustup = shutil.which("rustup")
    if rustup:
        if WINDOWS in output(rustup, "target", "list", "--installed").split():
            return None, "rustup's target"
        if not only_look and subprocess.run([rustup, "target", "add", WINDOWS], stderr=subprocess.DEVNULL).returncode == 0:
            return None, "rustup's target, added just now"
    for compiler in compilers():
        sysroot = output(compiler, "--print", "sysroot")
        if (Path(sysroot) / "lib/rustlib/src/rust/library/std/Cargo.toml").is_file():
            return compiler, f"the standard library built from the sources of {output(compiler, '--version')}"
    raise Missing(f"no standard library for Windows, neither by rustup nor as sources; one of\n{TO_TYPE}")


def compilers():
    """Rust compilers on this machine that are new enough, the one in use first."""
    wanted = version(re.search(r'^rust-version = "(.*)"', (ROOT / "Cargo.toml").read_text(), re.M)[1])
    found = [shutil.which("rustc", path=folder) for folder in os.environ["PATH"].split(os.pathsep)]
    return [path for path in dict.fromkeys(filter(None, found)) if version(output(path, "--version")) >= wanted]


def version(text):
    """Numbers of a version, for comparison."""
    return tuple(map(int, re.search(r"\d+(\.\d+)+", text)[0].split("."))) if re.search(r"\d+\.\d+", text) else ()


def output(*command):
    """What a command prints; nothing where it fails."""
    return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True).stdout.strip()


def build(platform, compiler, venv, folder):
    """Builds one library and puts it into its folder."""
    target, name = FILES[platform]
    folder = folder / platform
    work = folder / "build"
    stubs = work / "stubs"
    stubs.mkdir(parents=True, exist_ok=True)
    environment = dict(os.environ, CARGO_TARGET_DIR=str(work))
    environment["PATH"] = f"{interpreter(venv).parent}{os.pathsep}{environment['PATH']}"
    if subprocess.run(["cargo", "fetch", "--locked"], cwd=ROOT).returncode:  # the folders to hide exist from here on
        sys.exit("build_platforms: the dependencies could not be fetched; Cargo's message stands above")
    flags = [f"--remap-path-prefix={path}={shown}" for path, shown in hidden_paths(compiler)]
    command = [interpreter(venv).parent / "cargo-zigbuild", "rustc", "--release", "--locked", "--package", "foldwing-fmu", "--lib"]
    command += ["--crate-type", "cdylib", "--target", f"{target}.{GLIBC}" if target == LINUX else target]
    environment["SOURCE_DATE_EPOCH"] = "315532800"  # 1980-01-01, the date inside the archive, instead of today
    # Paths behind -Clink-arg are relative to the root, where the compiler runs: flags are part of what decides the bytes.
    if target == WINDOWS:
        exports = work / "foldwing.def"  # Zig ignores the compiler's list and would export every symbol
        exports.write_text("EXPORTS\n" + "".join(f"    {name}\n" for name in functions()))
        flags += [f"-Clink-arg={os.path.relpath(exports, ROOT)}"]
    if compiler:
        for library in ("libssp.a", "libssp_nonshared.a"):  # Debian's compiler names them, nothing in them is used
            (stubs / library).write_bytes(b"!<arch>\n")
        flags += [f"-Clink-arg=-L{os.path.relpath(stubs, ROOT)}"]
        command += ["-Zbuild-std=std,panic_unwind"]
        environment.update(RUSTC=compiler, RUSTC_BOOTSTRAP="1")
    environment["CARGO_ENCODED_RUSTFLAGS"] = "\x1f".join(flags)
    if subprocess.run(command, cwd=ROOT, env=environment).returncode:
        sys.exit(f"build_platforms: {platform}: the build failed; its messages stand above")
    shutil.copyfile(work / target / "release" / name, folder / name)
    return folder / name


def functions():
    """Names of the functions that an FMU exports, from the list that packaging checks libraries with."""
    text = (ROOT / "crates/fmi/src/fmi2/mod.rs").read_text()
    return re.findall(r'^ +"(fmi2\w+)",$', text, re.M)


def hidden_paths(compiler):
    """Folders of this machine and what stands for them in messages of the library."""
    cargo_home = Path(os.environ.get("CARGO_HOME", Path.home() / ".cargo"))
    yield ROOT, "foldwing"
    for registry in sorted((cargo_home / "registry/src").glob("*")):
        yield registry, "crates"
    if compiler:
        sources = Path(output(compiler, "--print", "sysroot")) / "lib/rustlib/src/rust"
        for path in dict.fromkeys([sources, sources.resolve()]):
            yield path, "rust"


if __name__ == "__main__":
    main()
