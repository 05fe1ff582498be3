"""Each id of the validation pages belongs to one page, and is used by one kind of test."""
import collections
import pathlib
import re

ROOT = pathlib.Path(__file__).resolve().parents[2]
# These pages name the tests of other pages, in addition to rows of their own.
TABLES_OF_TESTS = {"audit.md", "corrections.md"}
ID = r"[A-Z]{1,2}-\d{2,3}"


def first_cells(text):
    """Ids in the first cells of table rows, with ranges expanded."""
    for line in text.splitlines():
        cell = re.match(r"\|([^|]*)\|", line)
        if cell is None:
            continue
        for first, last in re.findall(rf"({ID})(?: to ({ID}))?", cell[1]):
            if not last:
                yield first
                continue
            prefix, begin = first.split("-")
            yield from (f"{prefix}-{number:0{len(begin)}d}" for number in range(int(begin), int(last.split("-")[1]) + 1))


def test_ids_are_used_once():
    """With the same id on two pages, a test could be looked up on the wrong page."""
    pages = collections.defaultdict(set)
    for page in sorted((ROOT / "docs/validation").glob("*.md")):
        if page.name not in TABLES_OF_TESTS:
            for name in first_cells(page.read_text(encoding="utf-8")):
                pages[name].add(page.name)
    assert len(pages) > 500, len(pages)
    twice = {name: sorted(names) for name, names in pages.items() if len(names) > 1}
    assert not twice, twice


def mentioned(text):
    """All ids in a text, with ranges expanded."""
    return set(first_cells("\n".join(f"| {line.replace('|', ' ')} |" for line in text.splitlines())))


def test_ids_of_tests_are_on_a_page():
    """A test whose comment begins with an id has its row, or is named in the text of a page: what it allows can be looked up."""
    known = set()
    for page in (ROOT / "docs/validation").glob("*.md"):
        text = page.read_text(encoding="utf-8")
        known |= set(first_cells(text)) if page.name == "corrections.md" else mentioned(text)
    missing = {}
    for folder in ("tests", "crates"):
        for path in (ROOT / folder).rglob("*.rs"):
            for ids in re.findall(rf"^ *///? ?((?:{ID}(?:, | to | and )?)+)[.:]", path.read_text(encoding="utf-8"), re.M):
                missing.update((name, path.name) for name in mentioned(ids) - known)
    for path in (*(ROOT / "tests/fmi").glob("test_*.py"), *(ROOT / "tests/python").glob("test_*.py")):
        for name in re.findall(rf'^    """({ID})[.:]', path.read_text(encoding="utf-8"), re.M):
            missing.update({name: path.name} if name not in known else {})
    assert not missing, missing


def test_faults_that_no_test_finds_are_on_their_page():
    faults = (ROOT / "tests/mutants/faults.toml").read_text(encoding="utf-8").split("[[fault]]\n")[1:]
    survivors = {re.search(r"^number = (\d+)", fault, re.M)[1] for fault in faults if re.search(r"^(reason|pending) = ", fault, re.M)}
    page = (ROOT / "docs/validation/robustness.md").read_text(encoding="utf-8").partition("Survivors, equivalent to the correct code:")[2]
    assert survivors == set(re.findall(r"^\|? ?(\d+)[:,]", page.partition("\n## ")[0], re.M))


def test_a_range_is_written_out():
    """A row for several tests has the id of each."""
    text = "| F-09 to F-11, Q-7 | a |\n| id | b |\ntext | C-01 |\n"
    assert list(first_cells(text)) == ["F-09", "F-10", "F-11"]
