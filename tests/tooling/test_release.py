"""Contents of a release: crates that contain the files they include, and the checks of `make release-check`."""

import io
import json
import os
import re
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
CHECK = ROOT / "tools/check_release.py"
CARGO = os.environ.get("CARGO", "cargo")
INCLUDES = re.compile(r'include_(?:str|bytes)!\(\s*"([^"]+)"\s*\)')


def metadata():
    command = [CARGO, "metadata", "--no-deps", "--format-version", "1", "--offline"]
    return json.loads(subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout)


def published():
    """Folders of the crates that are published, by name."""
    return {package["name"]: Path(package["manifest_path"]).parent for package in metadata()["packages"] if package["publish"] is None}


@pytest.mark.parametrize("name", sorted(published()))
def test_crates_hold_what_they_include(name):
    """Every file that a crate includes at compile time, its build script among them, is in the archive for crates.io."""
    folder = published()[name]
    command = [CARGO, "package", "--list", "--offline", "--allow-dirty", "--package", name]
    listed = set(subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout.split("\n"))
    sources = [path for path in sorted((folder / "src").rglob("*.rs")) if not path.name.endswith("tests.rs")]
    assert sources
    for source in sources:
        for included in INCLUDES.findall(source.read_text(encoding="utf-8").split("#[cfg(test)]\nmod tests")[0]):
            target = Path(os.path.normpath(source.parent / included)).relative_to(folder).as_posix()
            assert target in listed, f"{source}: {included}"
    if name == "foldwing-command":
        assert {"build.rs", "shipped/examples/turbine/polars/du21_a17.csv"} <= listed
        assert not any(file.endswith(".ipynb") for file in listed)
    if name == "foldwing":
        assert not any(file.startswith(("docs/", "tests/")) for file in listed)


def test_dependencies_have_versions():
    """crates.io does not accept dependencies by path only, except for tests."""
    for package in metadata()["packages"]:
        for dependency in package["dependencies"]:
            if dependency["name"].startswith("foldwing") and package["publish"] is None:
                assert dependency["req"] != "*", (package["name"], dependency["name"])


def crate(path, files):
    with tarfile.open(path, "w:gz") as archive:
        for name, text in files.items():
            member = tarfile.TarInfo(f"x-0.1.0/{name}")
            member.size = len(text)
            archive.addfile(member, io.BytesIO(text.encode()))


def wheel(path, files):
    with zipfile.ZipFile(path, "w") as archive:
        for name, text in files.items():
            archive.writestr(name, text)


GOOD = {
    "foldwing/__init__.py": "", "foldwing/py.typed": "", "foldwing/_native.pyi": "", "foldwing/_native.abi3.so": "",
    "foldwing/libfoldwing_fmu.so": "", "x.dist-info/entry_points.txt": "[console_scripts]\nfoldwing=foldwing.command:main\n",
}  # fmt: skip


@pytest.mark.parametrize(
    ("sources", "left_out", "reason"),
    [
        ({"src/lib.rs": 'const A: &str = include_str!("../a.txt");', "a.txt": ""}, None, None),
        ({"src/lib.rs": 'const A: &str = include_str!("../../a.txt");'}, None, "src/lib.rs includes ../../a.txt"),
        ({"src/lib.rs": '#[cfg(test)]\nmod tests { const A: &str = include_str!("../../a.txt"); }'}, None, None),
        ({"src/lib.rs": ""}, "foldwing/libfoldwing_fmu.so", "the library for FMUs is missing"),
        ({"src/lib.rs": ""}, "foldwing/_native.abi3.so", "the extension module is missing"),
        ({"src/lib.rs": ""}, "x.dist-info/entry_points.txt", "the command foldwing is missing"),
        (None, None, "holds no crate"),
    ],
)
def test_archives_are_checked(tmp_path, sources, left_out, reason):
    if sources is not None:
        crate(tmp_path / "x-0.1.0.crate", sources)
    wheel(tmp_path / "foldwing-0.1.0-cp39-abi3-linux_x86_64.whl", {name: text for name, text in GOOD.items() if name != left_out})
    done = subprocess.run([sys.executable, CHECK, "--crates", tmp_path, "--wheels", tmp_path], capture_output=True, text=True)
    assert done.returncode == (0 if reason is None else 1) and (reason or "") in done.stderr, done.stderr
    assert "foldwing-0.1.0-cp39-abi3-linux_x86_64.whl" in done.stdout


def test_the_target_runs_both_checks():
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    rule = makefile.split("release-check: wheel")[1].split("\n\n")[0]
    assert "package --workspace --locked" in rule and "twine check --strict" in rule and "check_release.py" in rule


def test_the_copy_with_faults_has_the_folders_that_are_links(tmp_path):
    """`make mutants` compiles a copy of the files listed by git: the examples in the command are a link to their folder."""
    sys.path.insert(0, str(ROOT / "tools"))
    from mutants import copy_tree

    for _ in range(2):  # the second time onto itself
        copy_tree(tmp_path, {})
        link = tmp_path / "crates/command/shipped/examples"
        assert link.is_symlink() and (link / "turbine/polars/du21_a17.csv").is_file()
        assert (tmp_path / "crates/command/shipped/THIRD_PARTY.txt").read_bytes() == (ROOT / "licenses/THIRD_PARTY.txt").read_bytes()
