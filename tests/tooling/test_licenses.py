"""The licence notices of packages linked into the library."""

import os
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
COLLECT = ROOT / "tools/collect_licenses.py"
NOTICES = ROOT / "licenses/THIRD_PARTY.txt"


def test_notices_fit_the_lock_file():
    """The committed notices are those the tool generates from the current Cargo.lock: run `make licenses` after a change of
    dependencies."""
    done = subprocess.run([sys.executable, COLLECT, "--check"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_every_linked_package_has_a_notice():
    """Independent check of completeness: all packages linked according to `cargo tree`, except procedural macros, are listed, and each
    listed package is above a text that contains a copyright line or is a complete licence.
    """
    command = [os.environ.get("CARGO", "cargo"), "tree", "--locked", "--edges", "normal", "--prefix", "none"]
    tree = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    packages = set()
    for line in tree.splitlines():
        match = re.match(r"(\S+) v(\S+)(.*)", line)
        if match and not match[1].startswith("foldwing") and "(proc-macro)" not in match[3]:
            packages.add(f"{match[1]} {match[2]}")
    text = NOTICES.read_text(encoding="utf-8")
    listing, *blocks = text.split("=" * 100 + "\n")
    listed = set(re.findall(r"^(\S+ \d\S*): ", listing, flags=re.MULTILINE))
    # dependencies of macros are not linked into the library either
    macros = {"proc-macro2", "quote", "syn", "unicode-ident", "serde_derive_internals", "heck"}
    missing = {package for package in packages - listed if package.split()[0] not in macros}
    assert not missing, missing
    owned = set()
    for block in blocks:
        titles, notice = block.split("-" * 100 + "\n")
        owned.update(titles.strip().split(", "))
        assert ("opyright" in notice or "(C)" in notice) and len(notice) > 500, titles
    assert owned == listed | {"rust-std"}


def test_vendored_libraries_have_their_notices():
    """The JavaScript in the page that plays a run: name, version and licence are in the notices and, as a comment, in the page; the page
    uses only the bundled code.
    """
    folder = ROOT / "crates/command/src/report/viewer"
    notices = NOTICES.read_text(encoding="utf-8")
    lines = (folder / "vendor/versions.txt").read_text(encoding="utf-8").splitlines()
    assert [line.split()[0] for line in lines] == ["three", "uplot"]
    for line in lines:
        assert line in notices.splitlines()
        name, version = line.split(":")[0].split()
        notice = (folder / f"vendor/{name}.LICENSE.txt").read_text(encoding="utf-8").strip()
        script = (folder / f"vendor/{name}.js").read_text(encoding="utf-8")
        assert script.startswith(f"/*! {name} {version}, ") and "opyright" in notice and notice in script.split("*/")[0]
        assert f'"{version}"' in (ROOT / "tools/vendor_viewer.py").read_text(encoding="utf-8")
    used = {word for script in folder.glob("*.js") for word in re.findall(r"THREE\.([A-Z]\w+)", script.read_text(encoding="utf-8"))}
    tool = (ROOT / "tools/vendor_viewer.py").read_text(encoding="utf-8")
    assert used == set(re.search(r'USED = """(.*?)"""', tool, re.DOTALL)[1].split())
