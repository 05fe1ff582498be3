"""Every step of `docs/WALKTHROUGH.md` quotes code that occurs exactly once in its file. Started as a program, this file prints the steps with
the current line numbers."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs/WALKTHROUGH.md"
WALKS = ["A load", "A key", "A lift"]
# [path](../path) `fragment` — sentences
STEP = re.compile(r"\d+\. \[([^\]]+)\]\(\.\./([^)]+)\) `([^`]+)` — (\S.*[.])")


def walks(text):
    """Sections of the page: title and numbered lines."""
    for section in re.split(r"^## ", text, flags=re.MULTILINE)[1:]:
        title, _, body = section.partition("\n")
        yield title, [line for line in body.splitlines() if re.match(r"\d+\.", line)]


def steps(text):
    """Path and fragment of each step; fails for a numbered line of another form."""
    for title, lines in walks(text):
        for number, line in enumerate(lines, 1):
            match = STEP.fullmatch(line)
            assert match and line.startswith(f"{number}. "), f"{title}: not of the form of a step: {line}"
            assert match[1] == match[2], f"{title}, step {number}: the link shows {match[1]} and leads to {match[2]}"
            yield match[1], match[3]


def fault(path, fragment, root=ROOT):
    """The reason why a step is out of date; `None` if it is not."""
    file = root / path
    if not file.is_file():
        return f"{path}: no such file, for the fragment: {fragment}"
    count = file.read_text(encoding="utf-8").count(fragment)
    return None if count == 1 else f"{path}: {count} occurrences instead of 1 of the fragment: {fragment}"


def test_every_fragment_occurs_once_in_its_file():
    found = list(steps(PAGE.read_text(encoding="utf-8")))
    faults = [text for text in (fault(*step) for step in found) if text]
    assert not faults, "\n".join(faults)
    assert len(set(found)) == len(found), "a step is repeated"


def test_each_walk_has_at_least_eight_steps():
    counts = {title: len(lines) for title, lines in walks(PAGE.read_text(encoding="utf-8"))}
    assert list(counts) == WALKS and min(counts.values()) >= 8, counts


def test_links_resolve():
    """Also those that are not steps; paths in code spans are checked by `tests/documents/architecture.rs`."""
    text = re.sub(r"`[^`]*`", "", PAGE.read_text(encoding="utf-8"))
    links = re.findall(r"\]\(([^)#]+)", text)
    missing = [link for link in links if not (PAGE.parent / link).is_file()]
    assert len(links) > 24 and not missing, missing


def test_the_equations_of_the_steps_exist():
    known = set(re.findall(r"^\*\*\(([A-Z]\d+)\)\*\*", (ROOT / "docs/NOTATION.md").read_text(encoding="utf-8"), flags=re.MULTILINE))
    cited = set(re.findall(r"\(([A-Z]\d+)\)", re.sub(r"`[^`]*`", "", PAGE.read_text(encoding="utf-8"))))
    assert len(cited) > 20 and cited <= known, cited - known


def test_the_page_is_found():
    for page in ("docs/ARCHITECTURE.md", "CONTRIBUTING.md"):
        assert "WALKTHROUGH.md)" in (ROOT / page).read_text(encoding="utf-8"), page


def test_a_step_out_of_date_is_reported(tmp_path):
    """A fragment that has vanished, one that occurs twice, a file that has moved, a line of another form."""
    (tmp_path / "some.rs").write_text("let a = 1;\nlet b = 2;\nlet b = 2;\n", encoding="utf-8")
    assert fault("some.rs", "let a = 1;", tmp_path) is None
    assert fault("some.rs", "let c = 3;", tmp_path) == "some.rs: 0 occurrences instead of 1 of the fragment: let c = 3;"
    assert fault("some.rs", "let b = 2;", tmp_path) == "some.rs: 2 occurrences instead of 1 of the fragment: let b = 2;"
    assert fault("other.rs", "let a = 1;", tmp_path) == "other.rs: no such file, for the fragment: let a = 1;"
    for line in ("1. some.rs `let a = 1;` — Text.", "2. [some.rs](../some.rs) `let a = 1;` — Text.", "1. [other.rs](../some.rs) `let a = 1;` — Text.",
                 "1. [some.rs](../some.rs) `let a = 1;`"):
        with pytest.raises(AssertionError):
            list(steps(f"## A load\n\n{line}\n"))


def main():
    for path, fragment in steps(PAGE.read_text(encoding="utf-8")):
        text = (ROOT / path).read_text(encoding="utf-8")
        print(fault(path, fragment) or f"{path}:{text[:text.index(fragment)].count(chr(10)) + 1}: {fragment}")


if __name__ == "__main__":
    main()
