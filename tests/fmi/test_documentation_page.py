"""The documentation page as shown by a browser."""

import re
from pathlib import Path

import pytest
from conftest import MODELS

WIDTHS = {"desktop": 1280, "phone": 390}

DRAWING = """(() => {
  const svg = document.querySelector('figure svg'), box = svg.getBoundingClientRect();
  const wing = [...svg.querySelectorAll('.deployed')].map(path => path.getBoundingClientRect());
  const style = getComputedStyle(svg.querySelector('.deployed'));
  const inside = [...svg.children].every(shape => {
    const own = shape.getBoundingClientRect();
    return own.left >= box.left - 1 && own.right <= box.right + 1 && own.top >= box.top - 1 && own.bottom <= box.bottom + 1;
  });
  return {width: box.width, height: box.height, bodies: wing.length, inside, fill: style.fill, stroke: style.stroke,
          extent: Math.max(...wing.map(w => w.right)) - Math.min(...wing.map(w => w.left)) +
                  Math.max(...wing.map(w => w.bottom)) - Math.min(...wing.map(w => w.top))};
})()"""

NAMES = """Object.fromEntries(['inputs', 'outputs', 'parameters'].map(id => {
  const table = document.getElementById(id).nextElementSibling.querySelector('tbody');
  return [id, [...table.rows].map(row => [...row.cells].map(cell => cell.innerText))];
}))"""


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
@pytest.mark.parametrize("width", WIDTHS)
def test_f150_page_shows_in_a_browser(browser, fmus, width, dark):
    """F-150. Every shipped model's page in Chromium: no console messages, no requests beyond the page, the drawing is visible and complete,
    no text extends beyond the window, and the page follows the reader's colour scheme.
    """
    for model in MODELS:
        page = Path(fmus[model].folder) / "documentation/index.html"
        browser.open(page, WIDTHS[width], 900, dark)
        assert browser.complaints() == [], model
        assert {url for url in browser.requests() if not url.startswith("data:")} == {page.resolve().as_uri()}, model
        drawing = browser.value(DRAWING)
        assert drawing["bodies"] > 0 and drawing["inside"], (model, drawing)
        assert drawing["width"] > 0.85 * min(WIDTHS[width], 1056) and drawing["extent"] > 0.3 * drawing["width"], model
        assert drawing["height"] < 900, (model, drawing)
        assert drawing["fill"] != "none" and drawing["stroke"] == ("rgb(169, 205, 238)" if dark else "rgb(15, 53, 87)")
        assert browser.value("document.documentElement.scrollWidth") <= WIDTHS[width], f"{model} is too wide"
        paper = [int(part) for part in re.findall(r"\d+", browser.value("getComputedStyle(document.body).backgroundColor"))]
        assert (max(paper[:3]) < 64) == dark, (model, paper)


def test_f151_page_names_every_variable(browser, fmus):
    """F-151. The tables shown by the browser list every input, output and parameter of the description with its unit."""
    for model in MODELS:
        fmu = fmus[model]
        browser.open(Path(fmu.folder) / "documentation/index.html")
        shown = browser.value(NAMES)
        for table, causality in [("inputs", "input"), ("outputs", "output"), ("parameters", "parameter")]:
            expected = [v for v in fmu.description.modelVariables if v.causality == causality]
            assert [row[0] for row in shown[table]] == [variable.name for variable in expected], model
            for row, variable in zip(shown[table], expected):
                unit = (variable.declaredType.unit if variable.declaredType else None) or ""
                assert row[2].split(" (")[0] == unit, (model, row)
                assert row[-1] == variable.description, (model, row)


def test_f152_links_lead_to_files_of_the_archive(browser, fmus):
    """F-152. Every link of every page leads to a heading of the page or to a file of the archive."""
    for model in MODELS:
        folder = Path(fmus[model].folder)
        browser.open(folder / "documentation/index.html")
        links = browser.value("[...document.querySelectorAll('a')].map(link => link.getAttribute('href'))")
        assert len(links) > 10
        for link in links:
            if link.startswith("#"):
                assert browser.value(f"document.getElementById({link[1:]!r}) !== null"), (model, link)
            else:
                assert (folder / "documentation" / link).is_file(), (model, link)
