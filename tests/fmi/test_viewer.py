"""The page that plays a run, as a browser shows it."""

import base64
import csv
import re
import subprocess
import time

import pytest
from browser import Browser
from conftest import ROOT

VIEWED = ["folding_wing", "folding_wing_in_tunnel", "branched", "curved_blade", "four_bar", "double_pendulum"]
MOST_BYTES = 9_000_000
PATIENCE_S = 20.0

# Colours of the drawing: how many pixels of the canvas are not transparent, and how many colours they have.
PIXELS = """(() => {
  const data = pen.getImageData(0, 0, canvas.width, canvas.height).data, colours = new Set();
  let drawn = 0;
  for (let i = 0; i < data.length; i += 4) if (data[i + 3]) { drawn++; colours.add(data[i] << 16 | data[i + 1] << 8 | data[i + 2]); }
  return { share: drawn / (data.length / 4), colours: colours.size };
})()"""

UNLABELLED = """[...document.querySelectorAll('button, input, select')].filter(control =>
  !control.innerText.trim() && !control.getAttribute('aria-label') && !control.closest('label')).length"""


@pytest.fixture(scope="module")
def browser():
    """One browser for all pages."""
    with Browser() as opened:
        yield opened


@pytest.fixture(scope="module")
def pages(foldwing, tmp_path_factory):
    """Page and CSV of every viewed model."""
    folder = tmp_path_factory.mktemp("pages")
    for model in VIEWED:
        subprocess.run([foldwing, "simulate", ROOT / f"examples/models/{model}.toml", "--quiet",
                        "--csv", folder / f"{model}.csv", "--view", folder / f"{model}.html"], check=True)
    return folder


def picture(browser):
    """The canvas as PNG, when what was asked for is drawn."""
    browser.call("Runtime.evaluate", expression="new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))",
                 awaitPromise=True)
    return base64.b64decode(browser.value("canvas.toDataURL()").split(",")[1])


def press(browser, key, code=None, modifiers=0):
    """A key pressed and released."""
    for kind in ("keyDown", "keyUp"):
        text = {"text": key} if len(key) == 1 and kind == "keyDown" else {}
        browser.call("Input.dispatchKeyEvent", type=kind, key=key, code=code or key, modifiers=modifiers, **text)


def mouse(browser, kind, x, y, **more):
    """A mouse event at a place of the window."""
    browser.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, **more)


def centre(browser, selector):
    """Middle of an element in the window."""
    box = browser.value(f"(b => [b.x + b.width / 2, b.y + b.height / 2])(document.querySelector('{selector}').getBoundingClientRect())")
    return box


def drag(browser, start, by, **more):
    """Drags with the left button, in two moves."""
    (x, y), (dx, dy) = start, by
    mouse(browser, "mousePressed", x, y, button="left", buttons=1, clickCount=1, **more)
    for share in (0.5, 1.0):
        mouse(browser, "mouseMoved", x + share * dx, y + share * dy, button="left", buttons=1, **more)
    mouse(browser, "mouseReleased", x + dx, y + dy, button="left", buttons=0, clickCount=1, **more)


def click(browser, selector):
    """Clicks an element."""
    drag(browser, centre(browser, selector), (0, 0))


def clock_s(browser):
    """Time that the page shows."""
    picture(browser)
    return float(re.fullmatch(r"t = (.*) s", browser.value("document.getElementById('clock').textContent"))[1])


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
@pytest.mark.parametrize("width", [1280, 390])
def test_f190_page_plays_without_complaint(browser, pages, width, dark):
    """F-190. The pages of still air, tunnel with wake, branches, curved blade, closed loop and pendulum: no complaint, no
    request beyond the page, a drawing of more than a few colours, labels on all controls, nothing wider than the window.
    """
    for model in VIEWED:
        page = pages / f"{model}.html"
        assert page.stat().st_size < MOST_BYTES, model
        browser.open(page, width, 900, dark)
        browser.value("seek(0.4 * frameCount), true")
        assert len(picture(browser)) > 1000
        assert browser.complaints() == [], model
        assert {url for url in browser.requests() if not url.startswith("data:")} == {page.resolve().as_uri()}, model
        pixels = browser.value(PIXELS)
        assert pixels["share"] > 0.02 and pixels["colours"] > 10, (model, pixels)
        assert browser.value(UNLABELLED) == 0, model
        assert browser.value("document.documentElement.scrollWidth") <= width, model
        paper = [int(part) for part in re.findall(r"\d+", browser.value("getComputedStyle(document.body).backgroundColor"))]
        assert (max(paper[:3]) < 64) == dark, (model, paper)


def test_f191_play_moves_the_wing(browser, pages):
    """F-191. Button and space bar play and pause: time goes on, pixels change, and both stand still afterwards."""
    browser.open(pages / "folding_wing.html")
    begin = picture(browser)
    assert clock_s(browser) == 0.0
    for start, stop in [(lambda: click(browser, "#play"), lambda: click(browser, "#play")),
                        (lambda: press(browser, " ", "Space"), lambda: press(browser, " ", "Space"))]:
        before_s = clock_s(browser)
        browser.value("document.activeElement.blur(), true")
        start()
        assert browser.value("document.getElementById('play').getAttribute('aria-pressed')") == "true"
        limit = time.monotonic() + PATIENCE_S
        while clock_s(browser) < before_s + 0.005 and time.monotonic() < limit:
            pass
        stop_picture, _ = picture(browser), stop()
        assert clock_s(browser) >= before_s + 0.005 and stop_picture != begin
        assert browser.value("document.getElementById('play').getAttribute('aria-pressed')") == "false"
        stood = clock_s(browser)
        assert clock_s(browser) == stood
    assert browser.complaints() == []


def test_f192_slider_and_keys_set_the_time(browser, pages):
    """F-192. Arrows, Home, End, the slider and the strip below the wing set the time; the values are the CSV's.

    The page shows hundredths of a degree, whole µm/m and tenths of a mJ of single-precision numbers.
    """
    with (pages / "folding_wing.csv").open() as lines:
        rows = list(csv.DictReader(lines))[::2]  # no more than 600 frames of 801 points
    browser.open(pages / "folding_wing.html")
    cells = "[...document.querySelectorAll('#values td')].map(cell => cell.textContent.replace('−', '-'))"
    pictures = [picture(browser)]
    for key, frame in [("ArrowRight", 1), ("ArrowRight", 2), ("ArrowLeft", 1), ("End", 400), ("Home", 0)]:
        press(browser, key)
        assert clock_s(browser) == pytest.approx(float(rows[frame]["time"]), abs=5.1e-5)
        pictures.append(picture(browser))
    assert len(set(pictures)) == 4, "frames 0, 1, 2 and 400 look different"
    assert pictures[0] == pictures[-1] and pictures[1] == pictures[3]
    browser.value("(s => { s.value = 212; s.dispatchEvent(new Event('input')); return true; })(document.getElementById('time'))")
    assert clock_s(browser) == pytest.approx(0.212, abs=5.1e-5)
    shown, row = browser.value(cells), rows[212]
    assert float(shown[0].split("°")[0]) == pytest.approx(float(row["fold.angle"]) * 57.29577951308232, abs=0.0051)
    assert float(shown[1].split()[0]) == pytest.approx(1e6 * float(row["gauge.root.strain"]), abs=0.51)
    energies = [float(row[f"energy.{name}"]) for name in ("kinetic", "elastic", "gravity", "drive", "work", "dissipated", "total")]
    assert [float(cell.split()[0]) for cell in shown[2:]] == pytest.approx(energies, abs=5.1e-5)
    x, y = centre(browser, "#history")
    drag(browser, (x, y), (0, 0))
    assert clock_s(browser) == pytest.approx(0.2, abs=2e-3)
    press(browser, "End")
    picture(browser)
    assert "latched" in browser.value(cells)[0]
    assert browser.complaints() == []


def test_f193_views_follow_mouse_and_keys(browser, pages):
    """F-193. Drag turns, Shift-drag moves, wheel zooms, Shift with an arrow turns, numbers and buttons choose views; R resets."""
    browser.open(pages / "folding_wing_in_tunnel.html")
    browser.value("seek(0.5 * frameCount), true")
    start = picture(browser)
    x, y = centre(browser, "#view")
    camera = "[camera.azimuth, camera.elevation, camera.distance, ...camera.target]"
    changes = [
        (lambda: drag(browser, (x, y), (90, 30)), {0, 1}),
        (lambda: drag(browser, (x, y), (90, 30), modifiers=8), {3, 4, 5}),
        (lambda: mouse(browser, "mouseWheel", x, y, deltaX=0, deltaY=240), {2}),
        (lambda: press(browser, "ArrowLeft", modifiers=8), {0}),
        (lambda: press(browser, "+"), {2}),
    ]
    seen = {start}
    for change, expected in changes:
        before = browser.value(camera)
        change()
        seen.add(picture(browser))
        after = browser.value(camera)
        assert {i for i in range(6) if abs(after[i] - before[i]) > 1e-9} == expected
    for button, key, direction in [("x", "1", [1, 0, 0]), ("y", "2", [0, -1, 0]), ("z", "3", [0, 0, 1])]:
        press(browser, key)
        by_key = picture(browser)
        assert browser.value("camera.axes[2]") == pytest.approx(direction, abs=1e-12)
        press(browser, "4")
        click(browser, f"[data-view={button}]")
        assert picture(browser) == by_key
        seen.add(by_key)
    assert len(seen) == len(changes) + 4, "every change is seen"
    press(browser, "4")
    assert picture(browser) == start, "the view named oblique is the first"
    press(browser, "w")
    without = picture(browser)
    assert without != start and not browser.value("document.getElementById('wake').checked")
    click(browser, "#theme")
    picture(browser)
    assert browser.value("getComputedStyle(document.body).backgroundColor") == "rgb(18, 24, 31)"
    press(browser, "r")
    assert clock_s(browser) == 0.0
    assert browser.complaints() == []
