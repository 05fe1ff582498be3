"""Collects the licences of third-party code: in licenses/THIRD_PARTY.txt for the library, in licenses/PYTHON_PACKAGE.txt for Python.

`collect_licenses.py` rewrites the file, `collect_licenses.py --check` reports whether it is up to date (exit code 1 if
not). The packages are those that `cargo metadata` resolves for the library on the platforms below: normal dependencies with
default features, without those of builds and tests and without procedural macros, whose code is not part of the library.
The list includes the two libraries of the page that plays a run (tools/vendor_viewer.py). Of the licences that a package
offers, the shortest is taken (MIT before the others). The texts come from the packages themselves, with their copyright
notices.
"""

import argparse
import json
import os
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
TARGET = ROOT / "licenses/THIRD_PARTY.txt"
PACKAGE = ROOT / "licenses/PYTHON_PACKAGE.txt"
# the member that is only part of the Python package
PYTHON = "foldwing-python"
NOT_SHIPPED = "foldwing-import"  # `make runner` alone builds with it
# JavaScript in the page of `foldwing simulate --view`: `versions.txt` and one text per library.
VENDORED = ROOT / "crates/command/src/report/viewer/vendor"
PLATFORMS = ["x86_64-unknown-linux-gnu", "x86_64-pc-windows-gnu", "x86_64-pc-windows-msvc", "x86_64-apple-darwin",
             "aarch64-apple-darwin"]

# The licence chosen if a package offers several, best first, and the name of its file.
PREFERENCE = {
    "MIT": r"mit",
    "Zlib": r"zlib",
    "BSD-2-Clause": r"bsd",
    "BSD-3-Clause": r"bsd",
    "0BSD": r"0?bsd",
    "ISC": r"isc",
    "Unicode-3.0": r"unicode",
    "BSL-1.0": r"bsl|boost",
    "Apache-2.0": r"apache",
    "Unlicense": r"unlicense",
}

# The library also contains the Rust standard library, which no package list names.
STANDARD_LIBRARY = "rust-std (the Rust standard library, The Rust Project Developers): MIT"

# Packages without a licence file; their notice is written from their metadata.
MIT_TEXT = """Permission is hereby granted, free of charge, to any person obtaining a copy of this software and associated
documentation files (the "Software"), to deal in the Software without restriction, including without limitation the
rights to use, copy, modify, merge, publish, distribute, sublicense, and/or sell copies of the Software, and to permit
persons to whom the Software is furnished to do so, subject to the following conditions:

The above copyright notice and this permission notice shall be included in all copies or substantial portions of the
Software.

THE SOFTWARE IS PROVIDED "AS IS", WITHOUT WARRANTY OF ANY KIND, EXPRESS OR IMPLIED, INCLUDING BUT NOT LIMITED TO THE
WARRANTIES OF MERCHANTABILITY, FITNESS FOR A PARTICULAR PURPOSE AND NONINFRINGEMENT. IN NO EVENT SHALL THE AUTHORS OR
COPYRIGHT HOLDERS BE LIABLE FOR ANY CLAIM, DAMAGES OR OTHER LIABILITY, WHETHER IN AN ACTION OF CONTRACT, TORT OR
OTHERWISE, ARISING FROM, OUT OF OR IN CONNECTION WITH THE SOFTWARE OR THE USE OR OTHER DEALINGS IN THE SOFTWARE."""

HEADER = """Licences of what is linked into the library of this FMU and into the command `foldwing`

Made by tools/collect_licenses.py from Cargo.lock; `make licenses` renews it. The libraries three and uplot are in the command, and
in the pages that it writes, alone.

"""

PACKAGE_HEADER = """Licences of what is linked into the module of the Python package `foldwing`, beside those of THIRD_PARTY.txt

Made by tools/collect_licenses.py from Cargo.lock; `make licenses` renews it.

"""


class Trouble(Exception):
    """A package whose licence must be examined by a person."""


def metadata():
    """Packages that Cargo resolves for the platforms."""
    command = [os.environ.get("CARGO", "cargo"), "metadata", "--locked", "--format-version", "1"]
    for platform in PLATFORMS:
        command += ["--filter-platform", platform]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    if done.returncode:
        raise Trouble(f"cargo metadata failed: {done.stderr.strip()}")
    return json.loads(done.stdout)


def linked(resolved, python=False):
    """Packages whose code may be in the library or, with `python`, in the Python package, by name and version."""
    packages = {package["id"]: package for package in resolved["packages"]}
    nodes = {node["id"]: node for node in resolved["resolve"]["nodes"]}
    own = set(resolved["workspace_members"])
    found, waiting = set(), sorted(member for member in own if packages[member]["name"] not in ((NOT_SHIPPED,) if python else (NOT_SHIPPED, PYTHON)))
    while waiting:
        identity = waiting.pop()
        if identity in found:
            continue
        found.add(identity)
        for dependency in nodes[identity]["deps"]:
            macro = any("proc-macro" in target["kind"] for target in packages[dependency["pkg"]]["targets"])
            if not macro and any(kind["kind"] is None for kind in dependency["dep_kinds"]):
                waiting.append(dependency["pkg"])
    return sorted((packages[identity] for identity in found - own), key=lambda p: (p["name"], p["version"]))


def chosen(package):
    """The licences of a package to be included: all that are joined by `AND`, and the preferred one of those joined by `OR`."""
    expression = (package["license"] or "").replace("/", " OR ")
    needed = []
    for part in re.split(r"\bAND\b", expression):
        offered = [word for word in re.findall(r"[\w.+-]+", part) if word not in {"OR", "WITH", "LLVM-exception"}]
        known = [licence for licence in PREFERENCE if licence in offered]
        if not known:
            raise Trouble(f"{package['name']} {package['version']}: licence {package['license']!r} is not in PREFERENCE")
        needed.append(known[0])
    return needed


def text_of(package, licence):
    """The text of a package's licence, from the package."""
    folder = Path(package["manifest_path"]).parent
    files = sorted(file for file in folder.iterdir() if re.match(r"(licen[cs]e|copying|unlicense)", file.name.lower())
                   and file.is_file())
    named = [file for file in files if re.search(PREFERENCE[licence], file.name.lower())]
    plain = [file for file in files if re.fullmatch(r"(licen[cs]e|copying)(\.(txt|md))?", file.name.lower())]
    for file in [*named, *plain]:
        text = file.read_text(encoding="utf-8").replace("\r\n", "\n")
        # a package created where symbolic links are files contains the link's path instead of the text
        if not re.fullmatch(r"(\.\./)+\S+", text.strip()):
            return text
    if licence == "MIT":
        authors = ", ".join(package["authors"]) or f"the authors of {package['name']}"
        return f"Copyright (c) {authors}\n\n{MIT_TEXT}"
    raise Trouble(f"{package['name']} {package['version']}: no file with the text of {licence} in {folder.name}")


def tidy(text):
    """Text without trailing blanks and surrounding empty lines, so that equal texts are merged."""
    return "\n".join(line.rstrip() for line in text.strip("\n\ufeff").split("\n")).strip()


def compose(packages, header=HEADER, vendored=True):
    """The whole file: a list of packages, followed by every text once, under the names of the packages to which it applies."""
    owners, lines = {}, []
    for package in packages:
        licences = chosen(package)
        title = f"{package['name']} {package['version']}"
        lines.append(f"{title}: {' AND '.join(licences)}")
        for licence in licences:
            owners.setdefault(tidy(text_of(package, licence)), []).append(title)
    for line in (VENDORED / "versions.txt").read_text(encoding="utf-8").splitlines() if vendored else []:
        title = line.split(":")[0]
        lines.append(line)
        owners.setdefault(tidy((VENDORED / f"{title.split()[0]}.LICENSE.txt").read_text(encoding="utf-8")), []).append(title)
    if vendored:
        rust = f"Copyright (c) The Rust Project Contributors\n\n{MIT_TEXT}"
        owners.setdefault(tidy(rust), []).append("rust-std")
        lines.append(STANDARD_LIBRARY)
    parts = [header + "\n".join(lines)]
    for text, titles in owners.items():
        parts.append(f"{'=' * 100}\n{', '.join(titles)}\n{'-' * 100}\n{text}")
    return "\n\n".join(parts) + "\n"


def main():
    """Runs the command."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="write nothing; fail if the file is not up to date")
    arguments = parser.parse_args()
    try:
        resolved = metadata()
        library = linked(resolved)
        beside = [package for package in linked(resolved, python=True) if package not in library]
        texts = {TARGET: compose(library), PACKAGE: compose(beside, PACKAGE_HEADER, vendored=False)}
    except Trouble as trouble:
        sys.exit(f"{trouble}")
    for target, text in texts.items():
        if not arguments.check:
            target.write_text(text, encoding="utf-8", newline="\n")
        elif not target.exists() or target.read_text(encoding="utf-8") != text:
            sys.exit(f"{target.relative_to(ROOT)} does not fit Cargo.lock; `make licenses` renews it")


if __name__ == "__main__":
    main()
