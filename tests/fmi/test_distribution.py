"""The archive of a release: reproducible bytes, and a wing simulated from it in an empty folder with an empty environment."""

import csv
import os
import re
import shutil
import subprocess
import sys
import tarfile
from pathlib import Path

import pytest
from conftest import ROOT
from fmpy import read_model_description, simulate_fmu

TOOL = ROOT / "tools/make_distribution.py"


def distribute(foldwing, fmus, output, **environment):
    """Creates the archive and returns its path."""
    command = [sys.executable, TOOL, "--foldwing", foldwing, "--fmus", fmus, "--output", output]
    done = subprocess.run(command, capture_output=True, text=True, env={**os.environ, **environment})
    assert done.returncode == 0, done.stderr
    return Path(done.stdout.strip())


@pytest.fixture(scope="module")
def folder_of_fmus(tmp_path_factory):
    """Two FMUs are sufficient and quick to package."""
    folder = tmp_path_factory.mktemp("fmus")
    for name in ["FoldingWing", "three_bodies"]:
        shutil.copy(Path(os.environ["FOLDWING_FMUS"]) / f"{name}.fmu", folder)
    return folder


@pytest.fixture(scope="module")
def archive(foldwing, folder_of_fmus, tmp_path_factory):
    return distribute(foldwing, folder_of_fmus, tmp_path_factory.mktemp("dist"))


@pytest.fixture(scope="module")
def unpacked(archive, tmp_path_factory):
    """The only folder in the archive, unpacked."""
    place = tmp_path_factory.mktemp("unpacked")
    with tarfile.open(archive) as tar:
        tar.extractall(place)
    (folder,) = place.iterdir()
    return folder


def test_f250_the_archive_has_the_same_bytes_twice(foldwing, folder_of_fmus, archive, tmp_path):
    """F-250. Created again later, from files with other times and permissions and another umask: the same bytes."""
    again = tmp_path / "fmus"
    shutil.copytree(folder_of_fmus, again)
    for fmu in again.iterdir():
        os.utime(fmu, (1e9, 1e9))
        fmu.chmod(0o600)
    shutil.copy(again / "FoldingWing.fmu", again / "forgotten.fmu")
    mask = os.umask(0o077)
    try:
        second = distribute(foldwing, again, tmp_path / "dist")
    finally:
        os.umask(mask)
    assert second.read_bytes() == archive.read_bytes(), "and no FMU of a model that is gone"
    later = distribute(foldwing, again, tmp_path / "later", SOURCE_DATE_EPOCH="1000000000")
    assert later.read_bytes() != archive.read_bytes(), "the time of the files is the one that is given"


def test_f251_the_archive_holds_what_a_user_needs(archive, unpacked):
    """F-251. One folder, named like the file; command, library, FMUs, models, documents, licences; no user names and no times."""
    assert unpacked.name == archive.name.removesuffix(".tar.gz")
    assert re.fullmatch(r"foldwing-\d+\.\d+\.\d+-[\w.-]+", unpacked.name), unpacked.name
    for name in ["foldwing", "README.md", "CHANGELOG.md", "LICENSE", "LICENSE-MIT", "LICENSE-APACHE", "licenses/THIRD_PARTY.txt",
                 "docs/guide/README.md", "docs/MODEL_FILE.md", "examples/models/folding_wing.toml",
                 "examples/models/foldwing.schema.json", "examples/fmpy_ten_lines.py", "fmus/FoldingWing.fmu"]:
        assert (unpacked / name).is_file(), name
    with tarfile.open(archive) as tar:
        members = tar.getmembers()
    assert [member.name for member in members] == sorted(member.name for member in members)
    assert {(member.uid, member.gid, member.uname, member.gname, member.mtime) for member in members} == {
        (0, 0, "", "", 315532800)
    }
    assert not [member.name for member in members if "__pycache__" in member.name or not member.isfile()]


def test_f252_links_of_the_unpacked_documents_lead_somewhere(unpacked):
    """F-252. Links in pages of the archive lead to pages, pictures and sections in it."""
    count = 0
    for page in unpacked.rglob("*.md"):
        for link in re.findall(r"\]\(([^)\s]+)\)", page.read_text(encoding="utf-8")):
            path = link.split("#")[0]
            if path and "://" not in path:
                count += 1
                assert (page.parent / path).exists(), f"{page.relative_to(unpacked)} links to {link}"
    assert count > 40, count


@pytest.mark.skipif(os.name == "nt", reason="an empty environment starts no program on Windows")
def test_f253_the_unpacked_command_works_in_an_empty_folder_with_an_empty_environment(unpacked, tmp_path):
    """F-253. The command checks, simulates and packages a model; the FMU has the same bytes as the shipped one and unfolds in FMPy."""
    model = unpacked / "examples/models/folding_wing.toml"

    def run(*arguments):
        done = subprocess.run([unpacked / "foldwing", *arguments], cwd=tmp_path, env={}, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return done.stdout

    assert "joints" in run("check", model)
    run("simulate", model, "--csv", "wing.csv", "--plot", "figures", "--view", "wing.html", "--quiet")
    with (tmp_path / "wing.csv").open(newline="") as file:
        last = list(csv.DictReader(file))[-1]
    assert float(last["fold.latch_time"]) == pytest.approx(0.1222, rel=5e-3)  # the tolerance of F-11
    run("package", model, "-o", "Wing.fmu")
    assert (tmp_path / "Wing.fmu").read_bytes() == (unpacked / "fmus/FoldingWing.fmu").read_bytes()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["Wing.fmu", "figures", "wing.csv", "wing.html"]

    result = simulate_fmu(tmp_path / "Wing.fmu", stop_time=0.2, output=["fold.latch_time"])
    assert result["fold.latch_time"][-1] == pytest.approx(0.1222, rel=5e-3)
    version = unpacked.name.split("-")[1]
    assert read_model_description(tmp_path / "Wing.fmu").generationTool == f"foldwing {version}"


def test_f254_what_is_missing_is_said(foldwing, tmp_path):
    """F-254. Missing FMUs, a missing command, an invalid time: one line that names it, no archive, no traceback."""
    empty = tmp_path / "empty"
    empty.mkdir()
    for arguments, words, environment in [
        ([foldwing, empty], "holds no FMU", {}),
        ([tmp_path / "foldwing", empty], "is missing; `make build`", {}),
        ([foldwing, empty], "SOURCE_DATE_EPOCH is 'soon'", {"SOURCE_DATE_EPOCH": "soon"}),
    ]:
        command = [sys.executable, TOOL, "--foldwing", arguments[0], "--fmus", arguments[1], "--output", tmp_path / "out"]
        done = subprocess.run(command, capture_output=True, text=True, env={**os.environ, **environment})
        assert done.returncode == 1 and words in done.stderr and "Traceback" not in done.stderr, done.stderr
    assert not (tmp_path / "out").exists()
