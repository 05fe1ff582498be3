"""Pages and VTK files of mode shapes: values shown by a browser against those of the command."""

import base64
import cmath
import json
import math
import re
import struct
import subprocess
import xml.etree.ElementTree as ElementTree

import pytest
from conftest import ROOT
from test_viewer import MAXIMUM_BYTES, PIXELS, UNLABELLED, click, number, picture, press, settled

WING = ROOT / "examples/models/folding_wing.toml"
GOLAND = ROOT / "examples/models/goland_wing.toml"
TURBINE = ROOT / "examples/turbine/nrel_5mw.toml"
FLUTTERS = ["--set", "wind.velocity.y=-140"]
# Number of phases of a cycle in the page and in the VTK files.
PHASES, CYCLE = 48, 24


@pytest.fixture(scope="module")
def pages(foldwing, tmp_path_factory):
    """Pages of modes about an equilibrium, with aerodynamics beyond flutter, versus wind speed, and about a periodic motion."""
    folder = tmp_path_factory.mktemp("modes")
    for name, arguments in {
        "wing": ["modes", WING],
        "grows": ["modes", GOLAND, *FLUTTERS, "--count", "4"],
        "flutter": ["flutter", GOLAND, "--wind-m-s", "100:160:7", "--count", "3"],
        "turbine": ["periodic", TURBINE, "--speed-rpm", "12.1", "--count", "3", "--perturbations", "60"],
    }.items():
        run = subprocess.run([foldwing, *arguments, "--view", folder / f"{name}.html", "--json"], check=True, capture_output=True, text=True)
        (folder / f"{name}.json").write_text(run.stdout)
    return folder


def numbers_of(pages, name):
    """Output of the command for the same modes."""
    return json.loads((pages / f"{name}.json").read_text())


def opened(browser, pages, name, *size, **more):
    """Opens a page, paused at its first frame."""
    browser.open(pages / f"{name}.html", *size, **more)
    browser.value("(play(false), seek(0), true)")
    settled(browser)


def set_value(browser, name, value):
    """Moves a slider."""
    browser.value(f"(s => {{ s.value = {value}; s.dispatchEvent(new Event('input')); return true; }})(get('{name}'))")
    settled(browser)


# Axis of every section of a body in all frames, minus that of the state.
MOVED = """(body => Array.from({ length: main.count }, (_, k) => about.bodies[body].rims.map((_, i) =>
  plus(main.section(body, i, k).at, still.section(body, i, stateOfModes().frame + (stateOfModes().period === null ? 0 : k % stateOfModes().frames)).at, -1))))"""


def test_f350_pages_of_modes_open_without_complaint(browser, pages):
    """F-350. The four pages, light and dark, at 1280 and 390 pixels: they play, without console messages or requests beyond the page; the
    drawing has the colours of the amplitude, all controls have labels, nothing is wider than the window.
    """
    for name in ("wing", "grows", "flutter", "turbine"):
        page = pages / f"{name}.html"
        assert page.stat().st_size < MAXIMUM_BYTES, name
        for width, dark in ((1280, False), (1280, True), (390, False)):
            browser.open(page, width, 900, dark)
            assert browser.value("get('play').getAttribute('aria-pressed')") == "true"
            browser.value("(play(false), seek(7), true)")
            assert len(picture(browser)) > 1000
            assert browser.complaints() == [], name
            assert {url for url in browser.requests() if not url.startswith("data:")} == {page.resolve().as_uri()}, name
            pixels = browser.value(PIXELS)
            assert pixels["share"] > 0.005 and pixels["colours"] > 10, (name, pixels)
            assert browser.value(UNLABELLED) == 0, name
            assert browser.value("document.documentElement.scrollWidth") <= width, name
            assert not browser.value("get('modes').hidden") and browser.value("get('plots').hidden")
            paper = [int(part) for part in re.findall(r"\d+", browser.value("getComputedStyle(document.body).backgroundColor"))]
            assert (max(paper[:3]) < 64) == dark, (name, paper)


def test_f351_the_list_has_the_numbers_of_the_command(browser, pages):
    """F-351. Frequency and damping of the list are those of the JSON; arrows and radio buttons choose a mode, and the drawing changes; a
    mode that grows is marked.
    """
    opened(browser, pages, "wing")
    rows = "[...get('mode-list').tBodies[0].rows].map(row => [...row.cells].map(cell => cell.textContent.trim()))"
    modes = numbers_of(pages, "wing")["modes"]
    shown = browser.value(rows)
    assert len(shown) == len(modes) == 10
    for row, mode in zip(shown, modes):
        assert number(row[1]) == pytest.approx(mode["frequency_Hz"], rel=6e-5), row
        assert number(row[2]) == pytest.approx(mode["damping_ratio"], abs=5.1e-6), row
    browser.value("(seek(12), true)")
    seen = {picture(browser)}
    for key, index in [("ArrowDown", 1), ("ArrowDown", 2), ("ArrowUp", 1)]:
        press(browser, key)
        seen.add(picture(browser))
        assert browser.value("chosen.mode") == index
        assert browser.value("document.querySelector('#mode-list tr.chosen input').checked")
    assert len(seen) == 3, "each mode looks different"
    click(browser, "#mode-list tbody tr:nth-child(5) input")
    assert browser.value("chosen.mode") == 4
    press(browser, "ArrowDown")
    settled(browser)
    assert browser.value("chosen.mode") == 5, "the arrows of the focused list"
    opened(browser, pages, "grows")
    growing = [mode["grows"] for mode in numbers_of(pages, "grows")["modes"]]
    assert [("grows" in row[2]) for row in browser.value(rows)] == growing and any(growing)
    assert browser.complaints() == []


def test_f352_the_drawn_motion_is_the_mode(browser, pages):
    """F-352. Goland's wing beyond its flutter speed: the first harmonic of the drawn axis, at an amplitude of 5 %, is the shape printed by
    the command with its phases, up to one complex factor: 1e-4 of its magnitude in displacements along the beam, where the second-order
    term of the rotation is 2e-4. At amplitude 1 the drawn points reach the displacement given by the page.
    """
    opened(browser, pages, "grows")
    data = numbers_of(pages, "grows")
    for index, mode in enumerate(data["modes"]):
        browser.value(f"(setMode({index}), true)")
        set_value(browser, "amplitude", 0.05)
        parts = zip(mode["shape"][0]["sections"], mode["shape_imaginary"][0]["sections"])
        due = {section["place_m"]: [complex(re, im) for re, im in zip(real["displacement_m"], imaginary["displacement_m"])]
               for section, (real, imaginary) in zip(data["bodies"][0]["sections"], parts)}
        moved, places = browser.value(f"{MOVED}(0)"), browser.value("about.bodies[0].places")
        assert len(moved) == PHASES + 1
        pairs = []
        for place, shape in due.items():
            i = min(range(len(places)), key=lambda i: abs(places[i] - place))
            assert abs(places[i] - place) < 1e-9
            for axis in range(3):
                harmonic = sum(moved[k][i][axis] * cmath.exp(-2j * math.pi * k / PHASES) for k in range(PHASES)) * 2 / PHASES
                pairs.append((harmonic, shape[axis]))
        # Re(z e^{iθ}) has the first harmonic z
        factor = sum(found * shape.conjugate() for found, shape in pairs) / sum(abs(shape) ** 2 for _, shape in pairs)
        off = math.sqrt(sum(abs(found - factor * shape) ** 2 for found, shape in pairs) / sum(abs(found) ** 2 for found, _ in pairs))
        print(f"F-352 mode {index + 1}: off by {off:.1e}")
        assert off < 1e-4, (index, off)
        set_value(browser, "amplitude", 1)
        text = browser.value("get('amplitude-value').textContent")
        stated = number(text.split("displacement")[1])
        reach = browser.value("""(() => {
          let most = 0;
          for (let k = 0; k < main.count; k++) about.surfaces.forEach((surface, s) => {
            for (let c = 0; c < 2 * surface.columns; c++) {
              const place = main.layout.surfaces[s] + 3 * c;
              const now = vector(main.numbers, about.begins[k] + place), before = vector(still.numbers, still.about.begins[0] + place);
              most = Math.max(most, Math.hypot(...plus(now, before, -1)));
            }
          });
          return most;
        })()""")
        # three digits are shown; a rotation of 20 degrees shortens the chord of its arc by 2 %
        assert reach == pytest.approx(stated, rel=0.03), text
        assert number(text.split("(")[1]) <= 10.01, text
    assert browser.complaints() == []


def test_f353_decay_follows_the_eigenvalue(browser, pages):
    """F-353. Without decay amplitudes are the same after a cycle; with decay they follow the real part of the eigenvalue, also for a
    growing mode."""
    for name, index in (("wing", 0), ("grows", 1)):
        opened(browser, pages, name)
        browser.value(f"(setMode({index}), true)")
        set_value(browser, "amplitude", 0.05)
        re_1_s, im_1_s = numbers_of(pages, name)["modes"][index]["eigenvalue_1_s"]
        held = browser.value(f"{MOVED}(0)")
        assert sum(held[0], []) == pytest.approx(sum(held[-1], []), abs=1e-6)
        press(browser, "d")
        settled(browser)
        moved = browser.value(f"{MOVED}(0)")
        assert len(moved) > PHASES + 1 and browser.value("get('decay').checked")
        first, second = moved[0][-1][2], moved[PHASES][-1][2]
        # second-order term of the rotation
        assert second / first == pytest.approx(math.exp(2 * math.pi * re_1_s / im_1_s), rel=2e-3), name
        assert (abs(moved[-1][-1][2]) > abs(moved[0][-1][2])) == (re_1_s > 0)


def test_f354_flutter_page_goes_over_the_speeds(browser, pages):
    """F-354. The page opens at flutter with the mode that begins to grow; slider, page keys and a click in the plots set the wind speed;
    the state is the equilibrium at that speed and the numbers are those of the sweep.
    """
    opened(browser, pages, "flutter")
    [found] = numbers_of(pages, "flutter")["results"]
    flutter = found["flutter"][0]
    value = "get('state-value').textContent"
    assert number(browser.value(value)) == pytest.approx(flutter["speed_m_s"], rel=1e-5)
    assert f"flutter of mode {flutter['mode']}" in browser.value(value)
    assert browser.value("chosen.mode") == flutter["mode"] - 1
    speeds = browser.value("modal.states.map(state => state.value)")
    assert speeds == sorted(speeds) and set(place["speed_m_s"] for place in found["modes"]) <= set(speeds)
    rows = "[...get('mode-list').tBodies[0].rows].map(row => [...row.cells].map(cell => cell.textContent.trim()))"
    for speed in (speeds[0], speeds[-1]):
        set_value(browser, "state", speeds.index(speed))
        [place] = [place for place in found["modes"] if place["speed_m_s"] == speed]
        for row, (re_1_s, im_1_s) in zip(browser.value(rows), place["eigenvalues_1_s"]):
            assert number(row[1]) == pytest.approx(math.hypot(re_1_s, im_1_s) / (2 * math.pi), rel=6e-5)
            assert number(row[2]) == pytest.approx(-re_1_s / math.hypot(re_1_s, im_1_s), abs=5.1e-6)
    press(browser, "PageDown")
    settled(browser)
    assert number(browser.value(value)) == pytest.approx(speeds[-2], rel=1e-5)
    press(browser, "PageUp")
    settled(browser)
    assert number(browser.value(value)) == pytest.approx(speeds[-1], rel=1e-5)
    click(browser, "#mode-plots .u-over")
    settled(browser)
    assert number(browser.value(value)) == pytest.approx(0.5 * (speeds[0] + speeds[-1]), abs=10.1), "the middle of the plot"
    wind = browser.value("vector(main.numbers, about.begins[0] + main.layout.winds)")
    assert -wind[1] == pytest.approx(number(browser.value(value)), rel=1e-5)
    assert browser.complaints() == []


def test_f355_floquet_modes_have_their_multipliers(browser, pages):
    """F-355. The turbine: at the same azimuth of successive revolutions the drawn end of a blade satisfies `x₂ − 2 Re μ x₁ + |μ|² x₀ = 0`
    with the multiplier of the command, at an amplitude of 0.5 % and with decay.
    """
    opened(browser, pages, "turbine")
    modes = numbers_of(pages, "turbine")["floquet"]["modes"]
    blade = browser.value("about.bodies.findIndex(body => body.name === 'blade1')")
    assert blade >= 0
    for index, mode in enumerate(modes):
        # finer than the steps of the slider
        browser.value(f"(setMode({index}), chosen.amplitude = 0.005, refill(false), true)")
        settled(browser)
        if index == 0:
            press(browser, "d")
            settled(browser)
        per = browser.value("stateOfModes().frames")
        moved = browser.value(f"{MOVED}({blade})")
        assert len(moved) > 2 * per and per % 12 == 0
        mu = complex(*mode["multiplier"])
        worst, size = 0.0, 0.0
        for k in range(0, per, 4):
            x = [moved[k + turn * per][-1] for turn in range(3)]
            for axis in range(3):
                size = max(size, abs(x[0][axis]))
                worst = max(worst, abs(x[2][axis] - 2 * mu.real * x[1][axis] + abs(mu) ** 2 * x[0][axis]))
        print(f"F-355 mode {index + 1}: {worst / size:.1e}")
        # second-order terms of the rotations, of 1e-3 rad at this amplitude; single precision of positions at 100 m relative to 0.1 m
        assert worst / size < 5e-3, (index, worst, size)
    assert browser.complaints() == []


def points_of(path):
    """Points of a VTK file."""
    array = ElementTree.parse(path).getroot().find(".//Points/DataArray")
    data = base64.b64decode(array.text)
    (size,) = struct.unpack("<I", data[:4])
    values = struct.unpack(f"<{size // 8}d", data[4:])
    return [values[i:i + 3] for i in range(0, len(values), 3)]


def test_f356_vtk_files_are_the_page(foldwing, browser, pages, tmp_path):
    """F-356. A cycle of each mode as VTK files: the points of the bodies are those of the page at the same phases, to single precision.

    Displacements are relative to the state: the largest of a cycle is the one given by the page.
    """
    subprocess.run([foldwing, "modes", GOLAND, *FLUTTERS, "--count", "4", "--vtk", tmp_path], check=True, capture_output=True)
    assert sorted(path.name for path in tmp_path.iterdir()) == [f"mode_{i}" for i in range(1, 5)]
    opened(browser, pages, "grows")
    for index in (0, 1):
        browser.value(f"(setMode({index}), true)")
        settled(browser)
        folder = tmp_path / f"mode_{index + 1}"
        assert len(list(folder.glob("wing_*.vtu"))) == CYCLE
        times = [float(entry.get("timestep")) for entry in ElementTree.parse(folder / "wing.pvd").getroot().iter("DataSet")]
        period = 2 * math.pi / numbers_of(pages, "grows")["modes"][index]["eigenvalue_1_s"][1]
        assert times == pytest.approx([k * period / CYCLE for k in range(CYCLE)])
        for k in (0, 5, 17):
            due = browser.value(f"about.bodies[0].rims.flatMap((rim, i) => rim.map(p => pointOf(main.section(0, i, {k * PHASES // CYCLE}), p)))")
            for found, point in zip(points_of(folder / f"wing_{k:04d}.vtu"), due, strict=True):
                assert found == pytest.approx(point, abs=2e-6)
