#!/usr/bin/env python3
"""Checks the archives of a release: crates within the limit of crates.io and with all their files, wheels that contain the command.

    check_release.py --crates target/release-check/package --wheels target/wheels [more.whl …]

Prints a line with the size of each; exit code 1 and the reasons if something is wrong.
"""

import argparse
import re
import sys
import tarfile
import zipfile
from pathlib import Path, PurePosixPath

LARGEST_CRATE = 10 << 20  # bytes, the limit of crates.io
LARGEST_WHEEL = 100 << 20  # bytes, the limit of PyPI
INCLUDES = re.compile(r'include_(?:str|bytes)!\(\s*"([^"]+)"\s*\)')
# files that a wheel must contain, in addition to the extension module and the library for FMUs
NEEDED = ["foldwing/__init__.py", "foldwing/py.typed", "foldwing/_native.pyi"]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--crates", type=Path, required=True, help="folder of the packaged crates")
    parser.add_argument("--wheels", type=Path, required=True, help="folder of the wheels")
    parser.add_argument("more", type=Path, nargs="*", help="further wheels")
    arguments = parser.parse_args()
    crates = sorted(arguments.crates.glob("*.crate"))
    wheels = sorted(arguments.wheels.glob("*.whl")) + arguments.more
    problems = [f"{folder}: holds no {what}" for folder, found, what in
                [(arguments.crates, crates, "crate"), (arguments.wheels, wheels, "wheel")] if not found]
    for path in crates:
        problems += [f"{path.name}: {problem}" for problem in crate_problems(path)]
    for path in wheels:
        problems += [f"{path.name}: {problem}" for problem in wheel_problems(path)]
    for path in crates + wheels:
        print(f"{path.name:60} {path.stat().st_size / 1e6:8.3f} MB")
    if problems:
        sys.exit("\n".join(problems))


def crate_problems(path):
    """Problems of the archive of a crate."""
    problems = []
    if path.stat().st_size > LARGEST_CRATE:
        problems.append(f"{path.stat().st_size} bytes are more than the {LARGEST_CRATE} of crates.io")
    with tarfile.open(path) as archive:
        names = {member.name for member in archive.getmembers()}
        for name in sorted(names):
            # tests are not compiled from an archive
            if not re.search(r"/src/.*\.rs$", name) or name.endswith(("tests.rs", "/mutants.rs")):
                continue
            text = archive.extractfile(name).read().decode("utf-8").split("#[cfg(test)]\nmod tests")[0]
            for included in INCLUDES.findall(text):
                target = normalised(PurePosixPath(name).parent / included)
                if target not in names:
                    problems.append(f"{name} includes {included}, which is not in the archive")
    return problems


def wheel_problems(path):
    """Problems of a wheel."""
    problems = []
    if path.stat().st_size > LARGEST_WHEEL:
        problems.append(f"{path.stat().st_size} bytes are more than the {LARGEST_WHEEL} of PyPI")
    with zipfile.ZipFile(path) as archive:
        names = archive.namelist()
        entries = [archive.read(name).decode("utf-8") for name in names if name.endswith(".dist-info/entry_points.txt")]
    problems += [f"{name} is missing" for name in NEEDED if name not in names]
    if not any(re.fullmatch(r"foldwing/_native\..*(so|pyd)", name) for name in names):
        problems.append("the extension module is missing")
    if not any(re.fullmatch(r"foldwing/(lib)?foldwing_fmu\.(so|dll|dylib)", name) for name in names):
        problems.append("the library for FMUs is missing")
    if not any("foldwing=foldwing.command:main" in entry.replace(" ", "") for entry in entries):
        problems.append("the command foldwing is missing")
    return problems


def normalised(path):
    """A path without `..`."""
    parts = []
    for part in path.parts:
        if part == "..":
            parts.pop()
        else:
            parts.append(part)
    return "/".join(parts)


if __name__ == "__main__":
    main()
