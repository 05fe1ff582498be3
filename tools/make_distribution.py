"""Creates the archive of a release: foldwing-VERSION-TARGET.tar.gz with the command, its library, FMUs, models, examples,
documents and licences.

    make_distribution.py --foldwing target/release/foldwing --fmus target/fmu --output target/dist

The same files give the same bytes: names are sorted, the owner is nobody, times are SOURCE_DATE_EPOCH or, without it, 1
January 1980, as in the FMUs. The archive is written completely or not at all; its path is printed.
"""

import argparse
import gzip
import io
import os
import re
import subprocess
import sys
import tarfile
from pathlib import Path

from build_site import without_sources

ROOT = Path(__file__).resolve().parents[1]
FIRST_OF_1980 = 315532800

# Parts of the repository that a user of the command needs. Folders are included completely.
KEPT = ["README.md", "CHANGELOG.md", "CITATION.cff", "CONTRIBUTING.md", "SECURITY.md", "LICENSE", "LICENSE-APACHE",
        "LICENSE-MIT", "licenses", "docs", "examples", "python/requirements.txt"]
LEFT_OUT = {"__pycache__", ".ipynb_checkpoints"}
LIBRARIES = ["libfoldwing_fmu.so", "foldwing_fmu.dll", "libfoldwing_fmu.dylib"]


def built_version(command):
    """Version and target reported by the command: those of the archive's content, not of the current sources."""
    text = subprocess.run([command, "--version"], capture_output=True, text=True, check=True).stdout
    match = re.fullmatch(r"foldwing (\S+) \((?:\w+, )?([\w.-]+)\)\s*", text)
    if not match:
        sys.exit(f"{command} --version says {text!r}, which names no version and target")
    return match[1], match[2]


def library_beside(command):
    """The shared library that Cargo built together with the command."""
    found = [command.with_name(name) for name in LIBRARIES if command.with_name(name).is_file()]
    if len(found) != 1:
        sys.exit(f"{command.parent}: {len(found)} of {', '.join(LIBRARIES)} beside the command; exactly one is needed")
    return found[0]


def contents(command, fmus):
    """Paths on the disk by their names in the archive."""
    files = {command.name: command, library_beside(command).name: library_beside(command)}
    for name in KEPT:
        path = ROOT / name
        if not path.exists():
            sys.exit(f"{path} is missing")
        for file in [path] if path.is_file() else path.rglob("*"):
            if file.is_file() and not LEFT_OUT & set(file.parts):
                files[file.relative_to(ROOT).as_posix()] = file
    # the folder may contain FMUs of models that no longer exist
    shipped = {model.stem for model in (ROOT / "examples/models").glob("*.toml")} | {"FoldingWing"}
    found = [fmu for fmu in sorted(fmus.glob("*.fmu")) if fmu.stem in shipped]
    for fmu in set(fmus.glob("*.fmu")) - set(found):
        print(f"{fmu} is left out: no model of that name is shipped", file=sys.stderr)
    if not found:
        sys.exit(f"{fmus} holds no FMU of a shipped model; `make package` makes them")
    files.update({f"fmus/{fmu.name}": fmu for fmu in found})
    return files


def archive(folder, files, programs, seconds):
    """Bytes of the archive."""
    tar_bytes = io.BytesIO()
    with tarfile.open(fileobj=tar_bytes, mode="w", format=tarfile.PAX_FORMAT) as tar:
        for name in sorted(files):
            data = files[name].read_bytes()
            if name.endswith(".md"):  # the archive has no sources
                data = without_sources(data.decode()).encode()
            member = tarfile.TarInfo(f"{folder}/{name}")
            member.size = len(data)
            member.mtime = seconds
            member.mode = 0o755 if name in programs else 0o644
            tar.addfile(member, io.BytesIO(data))
    packed = io.BytesIO()
    with gzip.GzipFile(filename="", fileobj=packed, mode="wb", compresslevel=9, mtime=seconds) as stream:
        stream.write(tar_bytes.getvalue())
    return packed.getvalue()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--foldwing", type=Path, required=True, help="the command, with its library beside it")
    parser.add_argument("--fmus", type=Path, required=True, help="folder of the FMUs")
    parser.add_argument("--output", type=Path, required=True, help="folder for the archive")
    arguments = parser.parse_args()

    epoch = os.environ.get("SOURCE_DATE_EPOCH", str(FIRST_OF_1980))
    if not epoch.isdecimal():
        sys.exit(f"SOURCE_DATE_EPOCH is {epoch!r}: it must be a number of seconds since 1970")
    command = arguments.foldwing.resolve()
    if not command.is_file():
        sys.exit(f"{command} is missing; `make build` makes it")
    version, target = built_version(command)
    folder = f"foldwing-{version}-{target}"
    files = contents(command, arguments.fmus)
    data = archive(folder, files, {command.name, library_beside(command).name}, int(epoch))

    arguments.output.mkdir(parents=True, exist_ok=True)
    path = arguments.output / f"{folder}.tar.gz"
    unfinished = path.with_name(f".{path.name}.{os.getpid()}")
    unfinished.write_bytes(data)
    unfinished.replace(path)
    print(path)


if __name__ == "__main__":
    main()
