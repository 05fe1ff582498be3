#!/usr/bin/env python3
"""Builds the shared library for other platforms than that of this machine, into one folder each.

    linux64         Linux on x86-64 with glibc 2.17 (2012) or newer
    win64           Windows 10 or newer on x86-64
    aarch64-linux   Linux on ARM64 with glibc 2.17 or newer
    darwin64        macOS 10.12 or newer on Intel processors
    aarch64-darwin  macOS 11 or newer on Apple's processors

Without names it builds the first two. With `--wheels` it also builds the Python module and writes the wheel of the package for each of
these two.

Zig, from packages pinned in python/platforms.txt, links for Linux and Windows (no root, no system packages). Libraries for macOS are
linked by LLVM's lld (that of the Rust toolchain, or of Debian) with Zig's list of the functions of macOS, because Zig's own linker exports
every Rust symbol (ziglang/zig#24662). lld adds the ad-hoc signature that macOS needs on ARM64.

Other platforms than linux64 also need a Rust standard library; the first available of these routes is taken:

    rustup   `rustup target add TARGET`
    source   a Rust compiler with the sources of its standard library (Debian: rustc-web, rust-web-src), which is
             built together with the crate

Only Python packages in the given environment and the target of rustup are installed. If something is missing, the message gives the
command that installs it. The libraries contain no path of this machine.
"""

import argparse
import base64
import hashlib
import os
import re
import shutil
import subprocess
import sys
import zipfile
from dataclasses import dataclass
from pathlib import Path

from create_venv import interpreter

ROOT = Path(__file__).resolve().parents[1]
GLIBC = "2.17"
LINUX = "x86_64-unknown-linux-gnu"
WINDOWS = "x86_64-pc-windows-gnu"
LINUX_ARM64 = "aarch64-unknown-linux-gnu"
RUSTUP_LIMIT_S = 10  # a target took 7 s to install once; without access to its server, rustup may wait without end

@dataclass(frozen=True)
class Platform:
    """Build products for a platform."""

    target: str
    library: str  # the library that goes into FMUs
    module: str  # the Python module, as cargo names it
    inside: str = ""  # path of the module in the wheel
    tag: str = ""  # platform tag of the wheel: PEP 600 (manylinux2014 is glibc 2.17) and PEP 425; empty if no wheel is made


PLATFORMS = {
    "linux64": Platform(LINUX, "libfoldwing_fmu.so", "libfoldwing_python.so", "_native.abi3.so", "manylinux_2_17_x86_64.manylinux2014_x86_64"),
    "win64": Platform(WINDOWS, "foldwing_fmu.dll", "foldwing_python.dll", "_native.pyd", "win_amd64"),
    "aarch64-linux": Platform(LINUX_ARM64, "libfoldwing_fmu.so", "libfoldwing_python.so"),
    "darwin64": Platform("x86_64-apple-darwin", "libfoldwing_fmu.dylib", "libfoldwing_python.dylib"),
    "aarch64-darwin": Platform("aarch64-apple-darwin", "libfoldwing_fmu.dylib", "libfoldwing_python.dylib"),
}
USUAL = ("linux64", "win64")
TO_TYPE = """\
    with rustup:          rustup target add {target}
    on Debian or Ubuntu:  sudo apt-get install -y rustc-web rust-web-src"""
LINKERS = """\
    with rustup:          rustup toolchain install stable (contains rust-lld)
    on Debian or Ubuntu:  sudo apt-get install -y lld"""


class Missing(Exception):
    """A tool is missing; the message gives the command that installs it."""


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("platforms", nargs="*", help=f"{', '.join(PLATFORMS)} [default: {' '.join(USUAL)}]")
    parser.add_argument("--venv", type=Path, required=True, help="environment made from python/platforms.txt")
    parser.add_argument("--output", type=Path, required=True, help="folder for the libraries, one folder per platform")
    parser.add_argument("--wheels", type=Path, metavar="WHEEL", help="a wheel of the package for this machine; those for the platforms are written too")
    parser.add_argument("--routes", action="store_true", help="say what would be done and do nothing")
    arguments = parser.parse_args()
    platforms = arguments.platforms or list(USUAL)
    unknown = sorted(set(platforms) - set(PLATFORMS))
    if unknown:
        parser.error(f"unknown platform {', '.join(unknown)}; allowed: {', '.join(PLATFORMS)}")
    without = [platform for platform in platforms if arguments.wheels and not PLATFORMS[platform].tag]
    if without:
        parser.error(f"no wheel is made for {', '.join(without)}; allowed with --wheels: {', '.join(USUAL)}")
    missing = []
    for platform in platforms:
        try:
            linker = linker_for_macos() if is_macos(platform) else None
            compiler, route = (None, "this Rust compiler") if platform == "linux64" else route_to(PLATFORMS[platform].target, arguments.routes)
        except Missing as error:
            missing.append(f"{platform}: {error}")
            continue
        if is_macos(platform):
            route += f", linked by {Path(linker).name}"
        print(f"{platform}: by {route}", flush=True)
        if not arguments.routes:
            folder = arguments.output.resolve()
            library = build(platform, "foldwing-fmu", compiler, arguments.venv.resolve(), folder, linker)
            print(f"{platform}: {library} ({library.stat().st_size / 1e6:.2f} MB)", flush=True)
            if arguments.wheels:
                module = build(platform, "foldwing-python", compiler, arguments.venv.resolve(), folder)
                wheel = write_wheel(PLATFORMS[platform], arguments.wheels, library, module, folder)
                print(f"{platform}: {wheel} ({wheel.stat().st_size / 1e6:.2f} MB)", flush=True)
    if missing:
        sys.exit("build_platforms: not everything can be built here\n" + "\n".join(missing))


def route_to(target, only_look):
    """Returns a compiler that must build its standard library, or None, and a text that describes the route."""
    rustup = shutil.which("rustup")
    if rustup:
        if target in output(rustup, "target", "list", "--installed").split():
            return None, "rustup's target"
        if not only_look and added(rustup, target):
            return None, "rustup's target, added just now"
    for compiler in compilers():
        sysroot = output(compiler, "--print", "sysroot")
        if (Path(sysroot) / "lib/rustlib/src/rust/library/std/Cargo.toml").is_file():
            return compiler, f"the standard library built from the sources of {output(compiler, '--version')}"
    raise Missing(f"no standard library for {target}, neither by rustup nor as sources; one of\n{TO_TYPE.format(target=target)}")


def added(rustup, target):
    """Lets rustup install a target, for a few seconds at most: without access to its server, it may wait without end."""
    try:
        return subprocess.run([rustup, "target", "add", target], stderr=subprocess.DEVNULL, timeout=RUSTUP_LIMIT_S).returncode == 0
    except subprocess.TimeoutExpired:
        print(f"rustup did not install {target} within {RUSTUP_LIMIT_S} s", flush=True)
        return False


def is_macos(platform):
    """Whether a library of the platform is Mach-O."""
    return PLATFORMS[platform].target.endswith("-apple-darwin")


def linker_for_macos():
    """LLVM's lld: that of a Rust toolchain, otherwise the newest on the path."""
    folders = os.environ["PATH"].split(os.pathsep)
    for compiler in dict.fromkeys(filter(None, (shutil.which("rustc", path=folder) for folder in folders))):
        sysroot = output(compiler, "--print", "sysroot")
        found = sorted(Path(sysroot).glob("lib/rustlib/*/bin/rust-lld")) if sysroot else []
        if found:
            return str(found[0])
    found = [path for folder in folders for path in Path(folder).glob("lld*") if re.fullmatch(r"lld(-\d+)?", path.name)]
    if not found:
        raise Missing(f"no linker for macOS; one of\n{LINKERS}")
    return str(max(found, key=lambda path: int(path.name[4:] or 0)))


def compilers():
    """Rust compilers on this machine that are recent enough, with the active one first."""
    wanted = version(re.search(r'^rust-version = "(.*)"', (ROOT / "Cargo.toml").read_text(), re.M)[1])
    found = [shutil.which("rustc", path=folder) for folder in os.environ["PATH"].split(os.pathsep)]
    return [path for path in dict.fromkeys(filter(None, found)) if version(output(path, "--version")) >= wanted]


def version(text):
    """Numbers of a version, for comparisons."""
    return tuple(map(int, re.search(r"\d+(\.\d+)+", text)[0].split("."))) if re.search(r"\d+\.\d+", text) else ()


def output(*command):
    """Output of a command; empty if it fails."""
    return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True).stdout.strip()


def build(platform, package, compiler, venv, folder, linker=None):
    """Builds the library of one package and puts it into the platform's folder; `linker` is that for macOS."""
    target, library = PLATFORMS[platform].target, package == "foldwing-fmu"
    name = PLATFORMS[platform].library if library else PLATFORMS[platform].module
    folder = folder / platform
    work = folder / "build"
    stubs = work / "stubs"
    stubs.mkdir(parents=True, exist_ok=True)
    environment = dict(os.environ, CARGO_TARGET_DIR=str(work))
    environment["PATH"] = f"{interpreter(venv).parent}{os.pathsep}{environment['PATH']}"
    if subprocess.run(["cargo", "fetch", "--locked"], cwd=ROOT).returncode:  # the folders to hide must exist before the build
        sys.exit("build_platforms: the dependencies could not be fetched; Cargo's message stands above")
    flags = [f"--remap-path-prefix={path}={shown}" for path, shown in hidden_paths(compiler)]
    command = ["cargo" if linker else interpreter(venv).parent / "cargo-zigbuild", "rustc", "--release", "--locked", "--package", package, "--lib"]
    command += ["--crate-type", "cdylib", "--target", f"{target}.{GLIBC}" if target in (LINUX, LINUX_ARM64) else target]
    environment["SOURCE_DATE_EPOCH"] = "315532800"  # 1980-01-01, the date inside the archive, instead of today
    # the stable ABI does not depend on an interpreter, and an extension module is not linked to one
    environment.update(PYO3_NO_PYTHON="1", PYO3_BUILD_EXTENSION_MODULE="1")
    # Paths after -Clink-arg are relative to the root, where the compiler runs: flags affect the bytes of the library.
    if compiler:
        for stub in ("libssp.a", "libssp_nonshared.a"):  # Debian's compiler names them, but does not use them
            (stubs / stub).write_bytes(b"!<arch>\n")
        flags += [f"-Clink-arg=-L{os.path.relpath(stubs, ROOT)}"]
        command += ["-Zbuild-std=std,panic_unwind"]
        environment.update(RUSTC=compiler, RUSTC_BOOTSTRAP="1")
    if linker:
        environment[f"CARGO_TARGET_{target.upper().replace('-', '_')}_LINKER"] = linker
        environment["SDKROOT"] = str(write_sdk(venv, work))
        environment["CARGO_PROFILE_RELEASE_STRIP"] = "none"  # the linker leaves local symbols out; a later change would break the signature
        flags += ["-Clinker-flavor=ld64.lld"]
        command += ["--"]
        command += [f"-Clink-arg={word}" for word in ("-install_name", f"@rpath/{name}", "-x", "-S", "-adhoc_codesign")]
    if target == WINDOWS:
        exports = work / f"{package}.def"  # Zig ignores the compiler's list and would export every symbol
        exports.write_text("EXPORTS\n" + "".join(f"    {name}\n" for name in (functions() if library else ["PyInit__native"])))
        command += ["--", f"-Clink-arg={os.path.relpath(exports, ROOT)}"]  # for this link only: the dependencies are shared
    environment["CARGO_ENCODED_RUSTFLAGS"] = "\x1f".join(flags)
    if subprocess.run(command, cwd=ROOT, env=environment).returncode:
        sys.exit(f"build_platforms: {platform}: the build failed; its messages stand above")
    shutil.copyfile(work / target / "release" / name, folder / name)
    return folder / name


def write_sdk(venv, work):
    """A folder that serves lld as an SDK of macOS: the system's functions, from the list that Zig has of them.

    The list names the ARM64 processors of Apple's own programs (arm64e, arm64e.x1); programs of others are arm64, of which lld expects a
    list of its own.
    """
    source = next(interpreter(venv).parents[1].glob("lib/python3*/site-packages/ziglang/lib/libc/darwin"))
    text = (source / "libSystem.tbd").read_text()
    text = re.sub(r",\s*arm64e\.x1-\w+", "", text)
    documents = text.split("--- !tapi-tbd\n")
    text = "--- !tapi-tbd\n".join(part if "arm64-macos" in part else part.replace("arm64e-", "arm64-") for part in documents)
    libraries = work / "sdk/usr/lib"
    libraries.mkdir(parents=True, exist_ok=True)
    for name in ("System", "c", "m", "iconv"):  # c and m are other names of the first; iconv is named by the crate `libc` and not called
        (libraries / f"lib{name}.tbd").write_text(text)
    shutil.copyfile(source / "SDKSettings.json", work / "sdk/SDKSettings.json")
    return work / "sdk"


def write_wheel(platform, native, library, module, folder):
    """The wheel for a platform: the wheel of this machine with other native files and another tag. Equal files give equal bytes."""
    with zipfile.ZipFile(native) as archive:
        parts = {info.filename: archive.read(info) for info in archive.infolist()}
    parts = {name: content for name, content in parts.items() if not re.fullmatch(r"foldwing/(_native\.(?!pyi).*|(lib)?foldwing_fmu\..*)", name)}
    for name in parts:  # maturin's list of the components of the module names the source folder
        if "/sboms/" in name:
            parts[name] = parts[name].replace(str(ROOT).encode(), b"foldwing")
    parts[f"foldwing/{platform.inside}"] = module.read_bytes()
    parts[f"foldwing/{platform.library}"] = library.read_bytes()
    record = next(name for name in parts if name.endswith(".dist-info/RECORD"))
    about = record.replace("RECORD", "WHEEL")
    version = record.split(".dist-info")[0]
    tags = "".join(f"Tag: cp39-abi3-{tag}\n" for tag in platform.tag.split("."))
    kept = [line for line in parts[about].decode().splitlines() if line and not line.startswith("Tag:")]
    parts[about] = ("\n".join(kept) + f"\n{tags}").encode()
    del parts[record]
    rows = []
    for name, content in parts.items():
        digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
        rows.append(f"{name},sha256={digest},{len(content)}\n")
    parts[record] = "".join([*rows, f"{record},,\n"]).encode()
    path = folder / f"{version}-cp39-abi3-{platform.tag}.whl"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for name, content in parts.items():
            info = zipfile.ZipInfo(name)  # its date is 1980-01-01
            info.external_attr = (0o755 if name.endswith((".so", ".pyd", ".dll")) else 0o644) << 16
            info.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(info, content)
    return path


def functions():
    """Names of the functions that an FMU exports in both versions, from the lists with which packaging checks libraries."""
    texts = [(ROOT / "crates/fmi/src" / path).read_text() for path in ("fmi2/mod.rs", "fmi3/life_cycle.rs")]
    return [name for text in texts for name in dict.fromkeys(re.findall(r'"(fmi[23]\w+)"(?:,$| )', text, re.M))]


def hidden_paths(compiler):
    """Folders of this machine, and the names that replace them in messages of the library."""
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
