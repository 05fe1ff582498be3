"""The documentation site: built from the unchanged documents, complete, and independent of a network."""

import fcntl
import importlib
import json
import os
import re
import subprocess
import sys
import urllib.parse
from html.parser import HTMLParser
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/fmi"))
browser = importlib.import_module("browser")

# Elements and attributes by which a page loads files; a plain hyperlink (`a href`) may lead anywhere.
LOADS = {("link", "href"), ("script", "src"), ("img", "src"), ("iframe", "src"), ("source", "src"), ("object", "data")}


class Page(HTMLParser):
    """Links, loads and anchors of a page."""

    def __init__(self, path):
        super().__init__()
        self.links, self.loads, self.anchors = [], [], set()
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attributes):
        for name, value in attributes:
            if name == "id":
                self.anchors.add(value)
            elif (tag, name) in LOADS:
                self.loads.append(value)
            elif (tag, name) == ("a", "href"):
                self.links.append(value)


def test_every_model_of_the_gallery_has_a_picture():
    """The pages of models name only pictures that are in the repository, and no picture is left of a model that went."""
    rows = json.loads((ROOT / "crates/web/page/gallery.json").read_text(encoding="utf-8"))
    pictures = {path.stem for path in (ROOT / "docs/pictures/models").glob("*.png")}
    assert {row["name"] for row in rows} == pictures


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """Folder of the site, built once with the environment of `make site-venv`."""
    python = Path(os.environ.get("FOLDWING_SITE", ROOT / "target/venv-site")) / "bin/python"
    if not python.exists():
        pytest.skip("no environment with Sphinx, MyST and Furo: `make site-venv` creates it")
    base = tmp_path_factory.getbasetemp()
    base = base.parent if "PYTEST_XDIST_WORKER" in os.environ else base
    output = base / "site"
    with (base / "site.lock").open("w") as lock:  # the first worker builds, the others wait for it
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not (output / "index.html").exists():
            done = subprocess.run([python, ROOT / "tools/build_site.py", "--output", output], capture_output=True, text=True)
            assert done.returncode == 0, done.stderr
    return output


@pytest.fixture(scope="module")
def pages(site):
    """Every page by its path."""
    return {path.resolve(): Page(path) for path in site.rglob("*.html")}


def test_nothing_comes_from_a_network(site, pages):
    """Neither a page nor a style sheet loads external files: `data:` and relative addresses only."""
    foreign = [(path.name, load) for path, page in pages.items() for load in page.loads if re.match(r"(?!data:)[a-z]+:|//", load)]
    assert len(pages) > 50 and not foreign, foreign
    for sheet in site.rglob("*.css"):
        text = re.sub(r"/\*.*?\*/", "", sheet.read_text(encoding="utf-8"), flags=re.DOTALL)
        assert not re.findall(r"@import[^;]*//|url\(\s*[\"']?(?:https?:)?//[^)]*", text), sheet


def test_internal_links_resolve(pages):
    """Every relative address names a file of the site, every fragment an element of its page."""
    broken, seen = [], 0
    for path, page in pages.items():
        for address in page.links + page.loads:
            parts = urllib.parse.urlsplit(address)
            if parts.scheme or parts.netloc:
                continue
            target = (path.parent / urllib.parse.unquote(parts.path)).resolve() if parts.path else path
            anchor = urllib.parse.unquote(parts.fragment)
            seen += 1
            if not target.is_file() or (anchor and target in pages and anchor not in pages[target].anchors):
                broken.append((path.name, address))
    assert seen > 3000 and not broken, broken


def test_every_document_is_in_the_navigation(site, pages):
    """The side bar of the first page leads to every Markdown page of docs/."""
    front = site.resolve() / "index.html"
    reached = {(front.parent / urllib.parse.urlsplit(link).path).resolve() for link in pages[front].links}
    documents = {path.relative_to(ROOT) for path in (ROOT / "docs").rglob("*.md")}
    missing = {str(path) for path in documents if (site / path.with_suffix(".html")).resolve() not in reached}
    assert len(documents) > 40 and not missing, missing


def test_the_navigation_is_in_the_order_of_learning(pages, site):
    """Sections in the order for newcomers; links in text have titles, not file names."""
    sidebar = (site / "index.html").read_text(encoding="utf-8")
    captions = re.findall(r'caption-text">([^<]+)<', sidebar)
    wanted = ["Install", "Tutorial", "How to", "Reference", "Models", "Theory", "What agrees", "Development"]
    assert list(dict.fromkeys(captions)) == wanted, captions
    named = [(path.name, text) for path in pages for text in re.findall(r'<a class="reference internal"[^>]*>(?:<span[^>]*>)?([\w/.-]+\.md)<',
                                                                        path.read_text(encoding="utf-8"))]
    assert not named, named[:10]


def test_the_search_finds_a_hollow_tube(site):
    """The index of Sphinx's search leads from both words to the page of sections."""
    index = json.loads(re.search(r"Search\.setIndex\((\{.*\})\)", (site / "searchindex.js").read_text(encoding="utf-8"), flags=re.DOTALL)[1])

    def documents(word):
        found = index["terms"].get(word, [])
        return {index["docnames"][number] for number in (found if isinstance(found, list) else [found])}

    assert "docs/guide/sections" in documents("hollow") & documents("tube")
    assert not documents("nosuchword")


def test_equations_are_typeset(site):
    """In a browser, from disk: all numbers are present, KaTeX accepted every equation, and only files were requested."""
    source = (ROOT / "docs/NOTATION.md").read_text(encoding="utf-8")
    numbers = re.findall(r"^\*\*(\([A-Z]\d+\))\*\*", source, flags=re.MULTILINE)
    written = len(re.findall(r"\$\$\n.*?\n\$\$|\$[^$]+\$", source, flags=re.DOTALL))
    with browser.Browser() as page:
        page.open(site / "docs/NOTATION.html")
        shown = page.value("[...document.querySelectorAll('strong')].map(e => e.textContent)")
        equations = page.value("document.querySelectorAll('.equation').length")
        typeset = page.value("[...document.querySelectorAll('.equation')].filter(e => e.querySelector('.katex-html')).length")
        wrong = page.value("[...document.querySelectorAll('.katex-error')].map(e => e.title)")
        font = page.value("document.fonts.ready.then(() => 1), document.fonts.check('16px KaTeX_Math')")
        assert not page.complaints() and {url.split(":")[0] for url in page.requests()} <= {"file", "data"}
    assert len(numbers) > 100 and set(numbers) <= set(shown), set(numbers) - set(shown)
    assert not wrong and (equations, typeset) == (written, written), wrong
    assert font


def test_vendored_katex_has_its_notice():
    """Name, version and licence are next to the library and in it; the tool that updates it has the same version."""
    folder = ROOT / "tools/site/vendor"
    name, version = re.fullmatch(r"(katex) (\S+): MIT\n", (folder / "versions.txt").read_text(encoding="utf-8")).groups()
    notice = (folder / "katex.LICENSE.txt").read_text(encoding="utf-8").strip()
    assert "opyright" in notice and f'KATEX = "{version}"' in (ROOT / "tools/vendor_site.py").read_text(encoding="utf-8")
    for file in ("katex.min.js", "katex.min.css"):
        text = (folder / file).read_text(encoding="utf-8")
        assert text.startswith(f"/*! {name} {version}, ") and notice in text.split("*/")[0]
