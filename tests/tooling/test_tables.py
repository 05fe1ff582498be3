"""Tables of the documents: every row has as many cells as the head of its table."""

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BAR = re.compile(r"(?<!\\)\|")


def wrong_rows(text):
    """Line, cells and cells of the head of each row that differs from the head of its table."""
    code, width = False, None
    for number, line in enumerate(text.splitlines(), 1):
        row = line.strip()
        code ^= row.startswith("```")
        if code or not row.startswith("|"):
            width = None
            continue
        cells = len(BAR.findall(row)) - 1
        width = width or cells
        if cells != width:
            yield number, cells, width


def test_rows_have_the_cells_of_their_head():
    pages = [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), *(ROOT / "examples").rglob("*.md")]
    rows = sum(page.read_text(encoding="utf-8").count("\n|") for page in pages)
    assert len(pages) > 100 and rows > 3000, (len(pages), rows)
    wrong = [f"{page.relative_to(ROOT)}:{number}: {cells} cells, {width} in the head"
             for page in pages for number, cells, width in wrong_rows(page.read_text(encoding="utf-8"))]
    assert wrong == [], wrong


def test_a_bar_too_many_is_found():
    assert list(wrong_rows("| a | b |\n|---|---|\n| 1 \\| 2 | 3 |\n| 1 | | 3 |\n\n| c |\n")) == [(4, 3, 2)]
