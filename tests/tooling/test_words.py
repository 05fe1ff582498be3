"""The pages to be read through (front page, tutorial, how-to, theory in brief) have at most 30 000 words; reference pages are excluded. Rows
of tables have the cells of their header."""

import importlib.util
import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SPEC = importlib.util.spec_from_file_location("build_site", ROOT / "tools/build_site.py")
build_site = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(build_site)
MOST = 30_000
# reference pages in the folder of the guide
REFERENCE = {"commands.md", "variables.md", "names.md", "messages.md", "glossary.md"}


def words(path):
    """Number of words of a page without its code, which is read where it is used."""
    return len(re.sub(r"```.*?```", "", path.read_text(encoding="utf-8"), flags=re.DOTALL).split())


def test_what_is_read_has_at_most_30000_words():
    pages = [ROOT / "README.md", ROOT / "docs/PLATFORMS.md", *(path for path in (ROOT / "docs/guide").glob("*.md") if path.name not in REFERENCE)]
    count = sum(words(path) for path in pages)
    print(f"{count} words on {len(pages)} pages")
    assert 10_000 < count <= MOST, count
    assert words(ROOT / "README.md") <= 500, "one screen"
    assert words(ROOT / "docs/VALIDATION.md") <= 2000, "one page"


def test_the_pages_are_those_of_the_navigation():
    read = [name for section in ("Install", "Tutorial", "How to", "Theory") for name in build_site.NAVIGATION[section]]
    looked_up = build_site.NAVIGATION["Reference"]
    assert {f"docs/guide/{name[:-3]}" for name in REFERENCE} <= set(looked_up)
    assert not {f"docs/guide/{name[:-3]}" for name in REFERENCE} & set(read)


def test_every_picture_to_read_says_what_to_see():
    pages = [ROOT / "README.md", *(path for path in (ROOT / "docs/guide").glob("*.md") if path.name not in REFERENCE), ROOT / "docs/VALIDATION.md"]
    pictures, silent = 0, []
    for path in pages:
        for found in re.finditer(r"^!\[[^\]]*\]\(([^)]+)\)\n\n(.*)", path.read_text(encoding="utf-8"), flags=re.MULTILINE):
            pictures += 1
            silent += [] if found[2].startswith("*What to see: ") else [f"{path.name}: {found[1]}"]
    assert pictures >= 20 and not silent, silent


def uneven_rows(text):
    """Numbers of the rows that have another number of cells than the header of their table; renderers drop additional cells."""
    found, cells, fenced = [], None, False
    for number, line in enumerate(text.splitlines(), 1):
        fenced ^= line.lstrip().startswith("```")
        own = len(re.findall(r"(?<!\\)\|", line)) if line.startswith("|") and not fenced else None
        found += [number] if own and cells and own != cells else []
        cells = cells if own and cells else own
    return found


def test_rows_of_tables_have_the_cells_of_their_header():
    assert uneven_rows("| a | b |\n|---|---|\n| 1 | 2 | | 3 |\n| x \\| y | 2 |\n\n| a |\n") == [3]
    pages = [path for path in ROOT.glob("*.md")] + sorted((ROOT / "docs").rglob("*.md"))
    uneven = [f"{path.relative_to(ROOT)}:{number}" for path in pages for number in uneven_rows(path.read_text(encoding="utf-8"))]
    assert len(pages) > 100 and not uneven, uneven
