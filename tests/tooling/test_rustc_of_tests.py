"""The compiler of `make test` changes the level of unit tests of some packages, and of nothing else."""

import re
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SCRIPT = ROOT / "tools/rustc_of_tests.sh"


def level(crate, *options):
    """Optimisation level with which a crate is compiled that Cargo compiles at level 3; the other arguments have to stay, in order."""
    given = ["--crate-name", crate, "lib.rs", "-C", "opt-level=3", *options, "--cfg", 'feature="a b"']
    passed = subprocess.run(["sh", SCRIPT, "printf", "%s\n", *given], capture_output=True, text=True, check=True).stdout.splitlines()
    assert [word for word in passed if not word.startswith("opt-level=")] == [word for word in given if word != "opt-level=3"]
    return next(word for word in passed if word.startswith("opt-level="))


def test_only_unit_tests_of_the_listed_packages_change():
    assert level("foldwing_file", "--test") == "opt-level=0"
    # what ships, and programs that compute or draw
    assert level("foldwing_file", "--crate-type", "lib") == "opt-level=3"
    for crate in ("foldwing_engine", "foldwing_command", "foldwing", "verification", "command", "serde"):
        assert level(crate, "--test") == "opt-level=3", crate


def test_the_listed_packages_exist():
    listed = re.findall(r"--crate-name foldwing_(\w+) ", SCRIPT.read_text(encoding="utf-8"))
    assert len(listed) == 6
    assert all((ROOT / "crates" / name / "Cargo.toml").is_file() for name in listed)
