"""The page that plays a run, as a browser shows it."""

import base64
import csv
import io
import json
import math
import re
import subprocess
import time

import pytest
from browser import PATIENCE_S
from conftest import MODELS, ROOT
from PIL import Image

ELSEWHERE = {"flying_aircraft": ROOT / "examples/flying_aircraft.toml", "nrel_5mw": ROOT / "examples/turbine/nrel_5mw.toml"}
ALL = [*MODELS, *ELSEWHERE]
VIEWED = ["folding_wing", "folding_wing_in_tunnel", "branched", "curved_blade", "four_bar", "double_pendulum", *ELSEWHERE]
MAXIMUM_BYTES = 10_000_000
MODEL = ROOT / "examples/models/folding_wing.toml"

# Maximum number of draw calls and of triangles of a frame: 20 calls for everything except the bodies and a few for each body, twice because
# of the shadow. The models need a third of it.
MAXIMUM_CALLS, MAXIMUM_TRIANGLES = 150, 40_000

# Pixels of the canvas: fraction that is not background, and number of distinct colours.
PIXELS = """(() => {
  render();
  const gl = renderer.getContext(), width = canvas.width, height = canvas.height, data = new Uint8Array(4 * width * height);
  gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, data);
  const paper = scene.background.toArray().map(c => Math.round(255 * c)), colours = new Set();
  let drawn = 0;
  for (let i = 0; i < data.length; i += 4) if (paper.some((c, k) => Math.abs(c - data[i + k]) > 2)) {
    drawn++;
    colours.add(data[i] << 16 | data[i + 1] << 8 | data[i + 2]);
  }
  return { share: drawn / (width * height), colours: colours.size };
})()"""

UNLABELLED = """[...document.querySelectorAll('button, input, select')].filter(control =>
  !control.innerText?.trim() && !control.getAttribute('aria-label') && !control.closest('label')).length"""

# Window coordinates of a position in the root frame.
ON_PAGE = """(place => { const v = new THREE.Vector3(...place).project(lens()), box = canvas.getBoundingClientRect();
  return [box.left + (1 + v.x) / 2 * box.width, box.top + (1 - v.y) / 2 * box.height]; })"""


@pytest.fixture(scope="module")
def pages(foldwing, tmp_path_factory):
    """Page and CSV of every shipped model, an aircraft and a turbine."""
    folder = tmp_path_factory.mktemp("pages")
    for model in ALL:
        file = ELSEWHERE.get(model, ROOT / f"examples/models/{model}.toml")
        subprocess.run([foldwing, "simulate", file, "--quiet", *(["--stop", "2"] if model == "nrel_5mw" else []),
                        "--csv", folder / f"{model}.csv", "--view", folder / f"{model}.html"], check=True)
    return folder


def records(path):
    """Rows of a CSV."""
    with path.open() as lines:
        return list(csv.DictReader(lines))


def awaited(browser, expression):
    """Value of a promise."""
    result = browser.call("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True)
    assert "exceptionDetails" not in result, result
    return result["result"].get("value")


def settled(browser):
    """Waits until the requested frame is drawn."""
    awaited(browser, "new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => done(true))))")


def picture(browser):
    """The canvas as PNG, after the requested frame is drawn."""
    settled(browser)
    return base64.b64decode(browser.value("(render(), canvas.toDataURL())").split(",")[1])


def number(text):
    """The first number of a text shown to users."""
    return float(re.search(r"-?[0-9.]+(e-?[0-9]+)?", text.replace("−", "-"))[0])


def numbers(text):
    """All numbers of a text."""
    return [float(part) for part in re.findall(r"-?[0-9.]+(?:e-?[0-9]+)?", text.replace("−", "-").split(" m")[0])]


def hovered(browser, x, y):
    """Title and rows of the page's tooltip at a point of the window."""
    mouse(browser, "mouseMoved", x, y)
    settled(browser)
    return browser.value("""(tip => tip.hidden ? null : { title: tip.querySelector('b').textContent,
      rows: Object.fromEntries([...tip.querySelectorAll('tr')].map(row => [row.cells[0].textContent, row.cells[1].textContent])) })(get('tip'))""")


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
    """F-190. The pages of still air, tunnel with wake, branches, curved blade, closed loop, pendulum, aircraft and turbine: no console
    messages, no request beyond the page, a drawing of more than a few colours, labels on all controls, nothing wider than the window.
    """
    for model in VIEWED:
        page = pages / f"{model}.html"
        assert page.stat().st_size < MAXIMUM_BYTES, model
        browser.open(page, width, 900, dark)
        browser.value("seek(0.4 * main.count), true")
        assert len(picture(browser)) > 1000
        assert browser.complaints() == [], model
        assert {url for url in browser.requests() if not url.startswith("data:")} == {page.resolve().as_uri()}, model
        pixels = browser.value(PIXELS)
        assert pixels["share"] > 0.005 and pixels["colours"] > 10, (model, pixels)
        assert browser.value(UNLABELLED) == 0, model
        assert browser.value("document.documentElement.scrollWidth") <= width, model
        assert browser.value("charts.length") > 0, model
        paper = [int(part) for part in re.findall(r"\d+", browser.value("getComputedStyle(document.body).backgroundColor"))]
        assert (max(paper[:3]) < 64) == dark, (model, paper)


def test_f191_play_moves_the_wing(browser, pages):
    """F-191. Button and space bar play and pause: time advances, pixels change, and neither changes afterwards."""
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
    """F-192. Arrows, Home, End, the slider, the plots and the marks of events set the time; the values are the CSV's.

    The page shows hundredths of a degree, whole µm/m and tenths of a mJ of single-precision numbers.
    """
    rows = records(pages / "folding_wing.csv")[::2]  # no more than 600 frames of 801 points
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
    energies = [float(row[f"energy.{name}"]) for name in ("kinetic", "elastic", "gravity", "motor", "work", "dissipated", "total")]
    assert [float(cell.split()[0]) for cell in shown[2:]] == pytest.approx(energies, abs=5.1e-5)
    click(browser, ".chart .u-over")
    assert clock_s(browser) == pytest.approx(0.2, abs=2e-3)
    click(browser, "#events button")
    picture(browser)
    assert clock_s(browser) == pytest.approx(float(rows[-1]["fold.latch_time"]), abs=5.1e-5)
    press(browser, "End")
    picture(browser)
    assert "latched" in browser.value(cells)[0]
    assert browser.complaints() == []


def test_f193_views_follow_mouse_and_keys(browser, pages):
    """F-193. Drag rotates, Shift-drag moves, wheel zooms, Shift with an arrow rotates, numbers and buttons choose views; R resets."""
    browser.open(pages / "folding_wing_in_tunnel.html")
    browser.value("seek(0.5 * main.count), true")
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
    for button, key, direction in [("side", "2", [1, 0, 0]), ("front", "1", [0, -1, 0]), ("top", "3", [0, 0, 1])]:
        press(browser, key)
        by_key = picture(browser)
        assert browser.value("camera.axes[2]") == pytest.approx(direction, abs=1e-12)
        press(browser, "4")
        click(browser, f"[data-view={button}]")
        assert picture(browser) == by_key
        seen.add(by_key)
    assert len(seen) == len(changes) + 4, "every change is seen"
    press(browser, "4")
    assert picture(browser) == start, "the view named iso is the first"
    # without perspective, parallel edges stay parallel: equal lengths look equal at any position
    press(browser, "o")
    assert picture(browser) != start and browser.value("get('flat').getAttribute('aria-pressed')") == "true"
    ends = [browser.value(f"{ON_PAGE}({json.dumps(place)})") for place in ([0, 0, 0], [0, 0.1, 0], [0.5, 0, 0], [0.5, 0.1, 0])]
    sides = [[b - a for a, b in zip(*ends[i:i + 2])] for i in (0, 2)]
    assert sides[0] == pytest.approx(sides[1], abs=1e-3)
    press(browser, "a")
    settled(browser)
    inside = browser.value(f"(box => presentPoints().map({ON_PAGE}).every(([x, y]) => x >= box.left && x <= box.right && "
                           "y >= box.top && y <= box.bottom))(canvas.getBoundingClientRect())")
    assert inside, "`frame all` has the near wake in the picture too"
    press(browser, "w")
    without = picture(browser)
    assert without != start and not browser.value("document.getElementById('wake').checked")
    browser.value("(f => { f.value = about.tips[0]; f.dispatchEvent(new Event('change')); return true; })(get('follow'))")
    places = []
    for share in (0.2, 0.8):
        browser.value(f"seek({share} * main.count), true")
        settled(browser)
        places.append(browser.value(f"{ON_PAGE}(followPoint())"))
    assert places[0] == pytest.approx(places[1], abs=0.5), "the end that is followed stays where it is"
    click(browser, "#theme")
    picture(browser)
    assert browser.value("getComputedStyle(document.body).backgroundColor") == "rgb(18, 24, 31)"
    press(browser, "r")
    assert clock_s(browser) == 0.0
    assert browser.complaints() == []


# Pixels at which an object of one kind covers an object of the other kind, with their colours in the complete image, without the
# covered object, and without the covering object.
LAYERS = """(() => {
  for (const id of ["shadow", "trace", "joints", "gauges", "ground", "lattice"]) get(id).checked = false;
  for (const set of arrowSets) get(`arrow-${set.name}`).checked = false;
  marks.visible = false;
  const gl = renderer.getContext(), ray = new THREE.Raycaster(), shown = shapes.map(({ mesh }) => mesh);
  render();
  // what is in front, where something of the other kind lies behind it
  const frontAt = (x, y) => {
    ray.setFromCamera(new THREE.Vector2(2 * (x + 0.5) / canvas.width - 1, 1 - 2 * (y + 0.5) / canvas.height), lens());
    const kinds = ray.intersectObjects(shown, false).map(hit => shapes[shown.indexOf(hit.object)].constructor.name);
    return kinds.some(kind => kind !== kinds[0]) ? kinds[0] : null;
  };
  const found = [];
  for (let y = 4; y < canvas.height - 4; y += 6) for (let x = 4; x < canvas.width - 4; x += 6) {
    const front = frontAt(x, y);
    // not on edges, which are smoothed
    if (front && [[-2, -2], [2, -2], [-2, 2], [2, 2]].every(([dx, dy]) => frontAt(x + dx, y + dy) === front)) found.push({ x, y, front });
  }
  const read = ({ x, y }) => { const p = new Uint8Array(4); gl.readPixels(x, canvas.height - 1 - y, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, p); return [...p]; };
  const without = name => {
    render();
    for (const one of shapes) {
      one.mesh.visible = one.constructor.name !== name;
      if (one.lattice) one.lattice.visible = false;
    }
    renderer.render(scene, lens());
    return found.map(read);
  };
  const [whole, noBody, noSurface] = [without(""), without("BodyShape"), without("SurfaceShape")];
  return found.map((pixel, i) => ({ ...pixel, whole: whole[i], noBody: noBody[i], noSurface: noSurface[i] }));
})()"""


@pytest.mark.parametrize("turn", [(0.0, 0.0), (0.3, -0.9)], ids=["oblique", "below"])
def test_f194_what_lies_behind_is_hidden(browser, pages, turn):
    """F-194. Depth test on `flared_wing_tip`, whose spar lies in its lifting surface: where the surface is in front, the image is
    that of the surface without the spar, and vice versa; without the object in front the image differs. Pixels on
    edges, which are anti-aliased, are excluded.
    """
    browser.open(pages / "flared_wing_tip.html")
    browser.value(f"turn({turn[0]}, {turn[1]}), zoom(0.35), seek(0.5 * main.count), true")
    settled(browser)
    pixels = browser.value(LAYERS)
    differ = {"SurfaceShape": 0, "BodyShape": 0}
    for front, behind in (("SurfaceShape", "noBody"), ("BodyShape", "noSurface")):
        of_front = [pixel for pixel in pixels if pixel["front"] == front]
        wrong = [pixel for pixel in of_front if max(abs(a - b) for a, b in zip(pixel["whole"], pixel[behind])) > 2]
        assert len(of_front) > 40, (front, len(of_front))
        assert not wrong, (front, len(wrong), len(of_front), wrong[:3])
        other = "noBody" if behind == "noSurface" else "noSurface"
        differ[front] = sum(max(abs(a - b) for a, b in zip(pixel["whole"], pixel[other])) > 2 for pixel in of_front) / len(of_front)
    assert min(differ.values()) > 0.9, f"what is behind would look different: {differ}"


def test_f195_hover_reads_the_csv(browser, pages):
    """F-195. Pointing at a gauge, at the end of the wing and at a joint shows the values of the CSV at that time, to the digits
    shown of single-precision numbers. A click keeps them in the list of values while time advances.
    """
    rows = records(pages / "folding_wing.csv")[::2]
    browser.open(pages / "folding_wing.html")
    press(browser, "3")
    for frame in (130, 300):
        browser.value(f"seek({frame}), true")
        settled(browser)
        row = {name: float(value) for name, value in rows[frame].items()}
        x, y = browser.value(f"{ON_PAGE}(vector(main.present, main.layout.gauges))")
        shown = hovered(browser, x, y)
        assert shown["title"] == "gauge root", shown
        assert number(shown["rows"]["strain"]) == pytest.approx(1e6 * row["gauge.root.strain"], abs=0.51)
        # just inside the end, beside the axis
        x, y = browser.value(f"{ON_PAGE}(pointOf(between(main, 1, about.bodies[1].rims.length - 2, 0.9), [0.01, 0]))")
        shown = hovered(browser, x, y)
        assert shown["title"] == about_body(browser, 1), shown
        assert numbers(shown["rows"]["axis at"]) == pytest.approx([row[f"tip.position.{axis}"] for axis in "xyz"], abs=1e-6)
        velocity = [row[f"tip.velocity.{axis}"] for axis in "xyz"]
        assert numbers(shown["rows"]["velocity"]) == pytest.approx(velocity, rel=6e-4, abs=1e-6)
    press(browser, "4")
    x, y = browser.value(f"{ON_PAGE}(main.section(1, 0).at)")
    shown = hovered(browser, x, y)
    assert shown["title"] in {"joint fold", "mass hinge"} or "joint" in shown["title"] or "mass" in shown["title"], shown
    press(browser, "3")
    settled(browser)
    x, y = browser.value(f"{ON_PAGE}(vector(main.present, main.layout.gauges))")
    drag(browser, (x, y), (0, 0))
    browser.value("seek(200), true")
    settled(browser)
    assert browser.value("get('picked-name').textContent") == "gauge root"
    assert number(browser.value("get('picked-rows').rows[0].cells[1].textContent")) == pytest.approx(1e6 * float(rows[200]["gauge.root.strain"]), abs=0.51)
    assert browser.complaints() == []


def about_body(browser, index):
    """Name of a body."""
    return browser.value(f"about.bodies[{index}].name")


def test_f196_runs_and_measurements_lie_over_each_other(foldwing, browser, pages, tmp_path):
    """F-196. A model, a page and a table compared with a run: the other wings have the positions of their CSV files at the same
    time, the plots have all curves and the dots of the table, and a check box hides each of them. Signals that are only measured have a
    plot.
    """
    measured = tmp_path / "measured.csv"
    measured.write_text("# by hand\ntime,fold.angle,bench.force\n0.01,3.0,1\n0.1,,2\n0.2,0.5,3\n")
    page = tmp_path / "beside.html"
    tunnel = ROOT / "examples/models/folding_wing_in_tunnel.toml"
    subprocess.run([foldwing, "simulate", MODEL, "--quiet", "--view", page, "--compare", tunnel, "--compare", measured,
                    "--compare", pages / "folding_wing_as_printed.html"], check=True)
    browser.open(page)
    assert browser.value("[runs.length, tables.length, charts.length]")[:2] == [3, 1]
    browser.value("seek(main.positionAt(0.15)), true")
    with_all = picture(browser)
    for run, model in ((1, "folding_wing_in_tunnel"), (2, "folding_wing_as_printed")):
        row = min(records(pages / f"{model}.csv"), key=lambda row: abs(float(row["time"]) - 0.15))
        place = browser.value(f"runs[{run}].section(1, runs[{run}].about.bodies[1].rims.length - 1).at")
        # between frames positions are interpolated: the arc of 1 ms at 3 m/s is off by less than 1e-4 m
        assert place == pytest.approx([float(row[f"tip.position.{axis}"]) for axis in "xyz"], abs=1e-4)
    labels = browser.value("charts[0].plot.series.map(s => s.label)")
    assert labels[1:] == ["fold.angle", "fold.angle (folding_wing_in_tunnel.toml)", "fold.angle (folding_wing_as_printed.html)",
                          "fold.angle (measured.csv)"]
    dots = browser.value("(p => p.data[0].map((t, i) => [t, p.data[4][i]]).filter(([, v]) => v !== null && v !== undefined))(charts[0].plot)")
    assert [time for time, _ in dots] == pytest.approx([0.01, 0.2], rel=1e-6)
    assert [value for _, value in dots] == pytest.approx([math.degrees(3.0), math.degrees(0.5)], rel=1e-6)
    assert browser.value("charts.some(chart => chart.names.includes('bench.force'))")
    browser.value("get('runs').querySelectorAll('input')[1].click(), true")
    assert picture(browser) != with_all
    assert len(browser.value("charts[0].plot.series.map(s => s.label)")) == 4
    assert browser.complaints() == []


def download(browser, folder, selector, name):
    """The file that a button saves."""
    browser.call("Page.setDownloadBehavior", behavior="allow", downloadPath=str(folder))
    click(browser, selector)
    file, stop = folder / name, time.monotonic() + PATIENCE_S
    while not file.exists() and time.monotonic() < stop:
        time.sleep(0.05)
    assert file.exists(), list(folder.iterdir())
    return file.read_bytes()


def test_f197_export_writes_picture_table_and_film(browser, pages, tmp_path):
    """F-197. PNG: decodes, has the stage's size, shows the wing. CSV: the signals of the plots within the times that they show, equal to the
    run's CSV in single precision. WebM: a video element plays it, with the stage's size.
    """
    browser.open(pages / "folding_wing.html")
    browser.value("seek(0.35 * main.count), true")
    settled(browser)
    image = Image.open(io.BytesIO(download(browser, tmp_path, "#save-picture", "FoldingWing.png")))
    image.load()
    assert list(image.size) == browser.value("[canvas.width, canvas.height]")
    assert len(image.convert("RGB").getcolors(1 << 20)) > 200
    browser.value("charts[0].plot.setScale('x', { min: 0.1, max: 0.2 }), true")
    settled(browser)
    table = list(csv.DictReader(io.StringIO(download(browser, tmp_path, "#save-table", "FoldingWing.csv").decode())))
    original = {float(row["time"]): row for row in records(pages / "folding_wing.csv") if 0.1 - 1e-9 <= float(row["time"]) <= 0.2 + 1e-9}
    assert len(table) == pytest.approx(len(original), abs=2) and len(table) > 190
    for row in table:
        true = original[min(original, key=lambda t: abs(t - float(row["time"])))]
        for name, value in row.items():
            assert float(value) == pytest.approx(float(true[name]), rel=2e-7, abs=1e-12), name
    browser.value("(s => { s.selectedIndex = SPEEDS.indexOf(1); return true; })(get('speed'))")
    size = awaited(browser, """filmBlob().then(blob => new Promise((done, fail) => {
      const film = document.createElement('video');
      film.onloadeddata = () => done([film.videoWidth, film.videoHeight, blob.size]);
      film.onerror = () => fail(new Error('the film cannot be played'));
      film.src = URL.createObjectURL(blob);
    }))""")
    assert size[:2] == browser.value("[canvas.width, canvas.height]") and size[2] > 5000
    assert browser.complaints() == []


def test_f357_the_stage_shows_what_there_is(browser, pages):
    """F-357. The view follows an aircraft from the start, but no other model, and presets show it at its position; `frame all` at the start
    in the tunnel shows the wing, not the far wake; legends are those of the fields shown; the axis of a constant signal includes its value.
    """
    width = "(points => { const x = points.map(p => %s(p)[0]); return (Math.max(...x) - Math.min(...x)) / canvas.clientWidth; })" % ON_PAGE
    for model, followed in (("flying_aircraft", "machine"), ("folding_wing", "nothing"), ("nrel_5mw", "nothing")):
        browser.open(pages / f"{model}.html")
        assert browser.value("get('follow').value") == followed, model
        if followed == "machine":
            browser.value("(seek(main.last), true)")
            settled(browser)
            press(browser, "1")
            settled(browser)
            assert browser.value(f"{width}(machinePoints())") > 0.5
    assert browser.value("[get('body-scale').hidden, get('air-scale').hidden]") == [True, True], "modal bodies without air"
    browser.open(pages / "folding_wing.html")
    assert browser.value("[get('body-scale').hidden, get('air-scale').hidden]") == [False, True]
    assert browser.value("rangeOf(null, 0, 0)") == [-1, 1] and browser.value("rangeOf(null, 5, 5)") == [4.5, 5.5]
    browser.open(pages / "folding_wing_in_tunnel.html")
    press(browser, "a")
    settled(browser)
    assert browser.value(f"{width}(machinePoints())") > 0.5, "the wing is not a speck beside its far wake"
    browser.value("seek(main.positionAt(0.10021)), true")
    settled(browser)
    assert browser.value("charts[0].box.querySelector('.u-value').textContent") == "0.1002 s", "one clock"
    assert browser.complaints() == []


def test_f198_pictures_are_cheap(browser, pages):
    """F-198. Every shipped model, aircraft and turbine: draw calls and triangles of a frame with everything shown, without a GPU; size
    of the page; no console messages. `make bench-viewer` measures rendering times.
    """
    for model in ALL:
        page = pages / f"{model}.html"
        assert page.stat().st_size < MAXIMUM_BYTES, model
        browser.open(page)
        browser.value("document.querySelectorAll('#display input[type=checkbox]').forEach(box => { box.checked = box.id !== 'glass'; }), true")
        browser.value("seek(0.6 * main.count), true")
        settled(browser)
        info = browser.value("({ calls: renderer.info.render.calls, triangles: renderer.info.render.triangles })")
        print(f"{model}: {info['calls']} calls, {info['triangles']} triangles, {page.stat().st_size / 1e6:.1f} MB")
        assert info["calls"] <= MAXIMUM_CALLS and info["triangles"] <= MAXIMUM_TRIANGLES, (model, info)
        assert browser.complaints() == [], model


def test_f199_without_webgl_a_message_says_so(browser, pages):
    """F-199. Without WebGL in the browser the page states it, plots and readings still work, and nothing is written to the console."""
    script = """const own = HTMLCanvasElement.prototype.getContext;
      HTMLCanvasElement.prototype.getContext = function (kind, ...more) { return kind.startsWith("webgl") ? null : own.call(this, kind, ...more); };"""
    added = browser.call("Page.addScriptToEvaluateOnNewDocument", source=script)["identifier"]
    try:
        browser.open(pages / "folding_wing.html")
        assert browser.value("getComputedStyle(get('missing')).display") != "none"
        assert "WebGL" in browser.value("get('missing').textContent")
        press(browser, "End")
        awaited(browser, "new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => done(true))))")
        assert browser.value("get('clock').textContent") == "t = 0.4000 s"
        assert "latched" in browser.value("get('values').textContent") and browser.value("charts.length") > 2
        assert browser.complaints() == []
    finally:
        browser.call("Page.removeScriptToEvaluateOnNewDocument", identifier=added)
