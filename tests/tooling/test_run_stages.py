"""tools/run_stages.py keeps the last result of each stage in a table and goes on after a failure."""

import re
import subprocess
import sys
from pathlib import Path

TOOL = Path(__file__).resolve().parents[2] / "tools/run_stages.py"


def stages(folder, *words):
    """Exit code of the tool, and the rows of its table by stage: result, commit."""
    done = subprocess.run([sys.executable, TOOL, "--times", "times", "--record", "docs/table.md", *words], cwd=folder, capture_output=True, text=True)
    rows = re.findall(r"^\| `(\w+)` \| (\w+) \| \S+ \| (\S+) \|", (folder / "docs/table.md").read_text(encoding="utf-8"), re.M)
    assert len({row[0] for row in rows}) == len(rows), "a stage has two rows"
    return done.returncode, {name: rest for name, *rest in rows}


def test_a_failure_is_recorded_and_the_rest_runs(tmp_path):
    (tmp_path / "docs").mkdir()
    (tmp_path / "Makefile").write_text("good:\n\t@true\nbad:\n\t@test -f mended\nlast:\n\t@true\n")
    git = ["git", "-c", "user.name=a", "-c", "user.email=a@b"]
    for words in (["init", "-q"], ["add", "."], ["commit", "-qm", "start"]):
        subprocess.run([*git, *words], cwd=tmp_path, check=True)
    head = subprocess.run(["git", "rev-parse", "--short=8", "HEAD"], cwd=tmp_path, capture_output=True, text=True, check=True).stdout.strip()
    code, rows = stages(tmp_path, "good", "bad", "last")
    assert code != 0 and {name: row[0] for name, row in rows.items()} == {"good": "passed", "bad": "failed"}
    code, rows = stages(tmp_path, "--keep-going", "bad", "last")
    assert code != 0 and {name: row[0] for name, row in rows.items()} == {"good": "passed", "bad": "failed", "last": "passed"}
    # a later run replaces the row; files outside `docs` that differ from the commit are marked
    (tmp_path / "mended").touch()
    (tmp_path / "Makefile").write_text((tmp_path / "Makefile").read_text() + "# changed\n")
    code, rows = stages(tmp_path, "bad")
    assert code == 0 and rows["bad"] == ["passed", head + "+"] and rows["good"] == ["passed", head]
