"""The page of a run: loads along the bodies, aerodynamic loads on the surfaces, and the address, as a browser shows them."""

import functools
import io
import math
import re
import subprocess
import time

import pytest
from browser import PATIENCE_S
from conftest import ROOT
from PIL import Image, ImageChops
from test_viewer import awaited, click, picture, press, records, settled

TUNNEL = ROOT / "examples/models/folding_wing_in_tunnel.toml"
AIRCRAFT = ROOT / "examples/flight/folding_aircraft.toml"
# Distances on the bodies at which the page has sections: a quarter of each is a boundary of elements, the others are within one.
PLACES = {"root": ("inner", 0.0), "within": ("inner", 0.028125), "mesh": ("inner", 0.075), "outer": ("outer", 0.046875)}
PARTS = [f"{kind}.{axis}" for kind in ("force", "moment") for axis in "xyz"]


@pytest.fixture(scope="module")
def pages(foldwing, tmp_path_factory):
    """Page and CSV of the wing in the tunnel with internal loads among its outputs, and of an aircraft in free flight."""
    folder = tmp_path_factory.mktemp("loads")
    text = TUNNEL.read_text().replace("#:schema ./foldwing.schema.json", "")
    for name, (body, place_m) in PLACES.items():
        side = "outboard" if place_m == 0.0 else "inboard"
        text += f'\n[internal_load.{name}]\nbody = "{body}"\nposition_m = {place_m}\nside = "{side}"\n'
    (folder / "wing.toml").write_text(text)
    for name, model in (("wing", folder / "wing.toml"), ("aircraft", AIRCRAFT)):
        subprocess.run([foldwing, "simulate", model, "--quiet", *(["--stop", "1"] if name == "aircraft" else []), "--csv", folder / f"{name}.csv", "--view", folder / f"{name}.html"], check=True)
    return folder


def rows_of_frames(browser, path):
    """The rows of a CSV at the times of the page's frames."""
    rows = records(path)
    times = browser.value("Array.from({ length: main.count }, (_, i) => main.timeOf(i))")
    by_time = {round(float(row["time"]), 6): row for row in rows}
    return [by_time[round(time_s, 6)] for time_s in times]


@pytest.mark.parametrize("width, dark", [(1700, False), (390, True)], ids=["wide", "narrow"])
def test_f370_diagrams_are_the_internal_loads_of_the_run(browser, pages, width, dark):
    """F-370. Shear force, bending and torsion along the bodies at several times: those of the outputs `internal_load` there, in single
    precision; the extremes are those of the frames; the curves are interrupted between bodies; nothing is wider than the window.
    """
    browser.open(pages / "wing.html", width, 1000, dark)
    rows = rows_of_frames(browser, pages / "wing.csv")
    click(browser, "#along summary")
    settled(browser)
    assert browser.value("along.charts.map(chart => chart.about.title.split(' (')[0])") == ["shear", "bending", "torsion", "lift"]
    shown = {"Vz": "force.z", "Vy": "force.y", "My": "moment.y", "Mz": "moment.z", "Mx": "moment.x"}
    largest = {part: max(abs(float(row[f"internal_load.{name}.{part}"])) for row in rows for name in PLACES) for part in PARTS}
    drawn = "(label => { for (const { plot } of along.charts) { const i = plot.series.findIndex(s => s.label === label); if (i > 0) return [plot.data[0], plot.data[i]]; } })"
    for frame in (0, len(rows) // 3, len(rows) - 7):
        browser.value(f"seek({frame}), true")
        settled(browser)
        for label, part in shown.items():
            x, y = browser.value(f"{drawn}('{label}')")
            for name, (body, place_m) in PLACES.items():
                at = place_m + (0.15 if body == "outer" else 0.0)
                value = y[min(range(len(x)), key=lambda i: abs(x[i] - at))]
                assert value == pytest.approx(float(rows[frame][f"internal_load.{name}.{part}"]), abs=2e-6 * largest[part]), (frame, label, name)
            assert None in y[:-1], "the bodies are parted"
    for label, part in shown.items():
        x, least = browser.value(f"{drawn}('least {label}')")
        _, most = browser.value(f"{drawn}('largest {label}')")
        for name, (body, place_m) in PLACES.items():
            at = place_m + (0.15 if body == "outer" else 0.0)
            i = min(range(len(x)), key=lambda i: abs(x[i] - at))
            values = [float(row[f"internal_load.{name}.{part}"]) for row in rows]
            assert (least[i], most[i]) == pytest.approx((min(values), max(values)), abs=2e-6 * largest[part]), (label, name)
    # a click into a diagram picks the section there
    box = browser.value("(b => [b.x, b.y, b.width, b.height])(along.charts[0].plot.over.getBoundingClientRect())")
    browser.value("along.charts[0].plot.over.scrollIntoView({ block: 'center' }), true")
    box = browser.value("(b => [b.x, b.y, b.width, b.height])(along.charts[0].plot.over.getBoundingClientRect())")
    for kind in ("mousePressed", "mouseReleased"):
        browser.call("Input.dispatchMouseEvent", type=kind, x=box[0] + 0.75 * box[2], y=box[1] + 0.5 * box[3], button="left", clickCount=1)
    settled(browser)
    assert browser.value("picked.on.body") == 1 and browser.value("picked.on.place") == pytest.approx(0.075, abs=0.3 / box[2])
    assert browser.value("document.documentElement.scrollWidth") <= width
    assert browser.complaints() == []


def test_f371_forces_on_the_surfaces_sum_to_those_of_the_run(browser, pages):
    """F-371. Aerodynamic forces at the edges of the strips: their sum is the output `aero.force`, in single precision. Lift per span,
    integrated over the flat wing, is the component of that sum normal to the flow; the colours of the surfaces change along the span.
    """
    for name in ("wing", "aircraft"):
        browser.open(pages / f"{name}.html")
        rows = rows_of_frames(browser, pages / f"{name}.csv")
        largest = max(abs(float(row[f"aero.force.{axis}"])) for row in rows for axis in "xyz")
        for frame in (1, len(rows) // 2, len(rows) - 1):
            total = browser.value(f"""about.surfaces.reduce((sum, surface, i) => {{
              for (let c = 0; c < surface.columns; c++) sum = plus(sum, vector(main.numbers, about.begins[{frame}] + main.layout.edgeForces[i] + 3 * c));
              return sum; }}, [0, 0, 0])""")
            assert total == pytest.approx([float(rows[frame][f"aero.force.{axis}"]) for axis in "xyz"], abs=3e-6 * largest), (name, frame)
    browser.open(pages / "wing.html")
    assert browser.value("[get('surface-field').value, get('surface-scale').hidden]") == ["lift", False]
    rows = rows_of_frames(browser, pages / "wing.csv")
    lift = browser.value("about.surfaces.reduce((sum, surface, i) => { for (let c = 0; c < surface.columns; c++) sum += liftAt(main, i, c, main.last) * spanOf(surface, c); return sum; }, 0)")
    # the latched wing is bent by a few degrees only, so that the force normal to flow and span is nearly that along z
    assert lift == pytest.approx(float(rows[-1]["aero.force.z"]), rel=0.02), rows[-1]["aero.force.z"]


def test_f372_left_and_right_are_alike(browser, pages):
    """F-372. Aircraft: lift per span of the left and of the right wing is equal at mirrored positions, directed upward, and shown in equal
    colours; circulations about the axes of the bodies have opposite signs.
    """
    browser.open(pages / "aircraft.html")
    frame = browser.value("Math.round(0.1 * main.last)")
    lifts = browser.value(f"about.surfaces.map((surface, i) => Array.from({{ length: surface.columns }}, (_, c) => liftAt(main, i, c, {frame})))")
    names = browser.value("about.surfaces.map(surface => about.bodies[surface.body].name)")
    pairs = [(names.index(name), names.index(name.replace("left", "right"))) for name in names if "left" in name]
    assert pairs, names
    for left, right in pairs:
        assert lifts[left] == pytest.approx(lifts[right], rel=1e-3, abs=1e-3 * max(map(abs, lifts[left]))), names[left]
        assert sum(lifts[left]) > 0.0
    browser.value(f"seek({frame}), true")
    settled(browser)
    colours = browser.value("shapes.filter(one => one instanceof SurfaceShape && one.run === main).map(one => Array.from(one.mesh.geometry.getAttribute('color').array.slice(0, 12)))")
    for left, right in pairs:
        assert colours[left] == pytest.approx(colours[right], abs=2e-3)
    browser.value("(list => { list.value = 'circulation'; list.dispatchEvent(new Event('change')); return true; })(get('surface-field'))")
    settled(browser)
    colours = browser.value("shapes.filter(one => one instanceof SurfaceShape && one.run === main).map(one => Array.from(one.mesh.geometry.getAttribute('color').array.slice(0, 12)))")
    assert any(colours[left] != pytest.approx(colours[right], abs=0.05) for left, right in pairs)
    assert browser.complaints() == []


def test_f373_pressures_carry_the_loads(browser, pages):
    """F-373. Pressure jump on the panels times their areas is the aerodynamic force normal to the surface, at the end of an aerodynamic
    step in which it hardly changes. It falls from the leading to the trailing edge; the panels of the image have the corresponding colours.
    """
    browser.open(pages / "wing.html")
    rows = rows_of_frames(browser, pages / "wing.csv")
    count = len(rows)
    sums = browser.value("""Array.from({ length: main.count }, (_, frame) => about.surfaces.reduce((sum, surface, i) => {
      const strips = surface.columns - 1;
      for (let panel = 0; panel < surface.panels * strips; panel++) {
        const strip = panel % strips;
        const up = mix(pushedSide(main, i, strip, frame), pushedSide(main, i, strip + 1, frame), 0.5);
        sum += main.numbers[about.begins[frame] + main.layout.panelForces[i] + panel] * up[2];
      }
      return sum; }, 0))""")
    forces = [float(row["aero.force.z"]) for row in rows]
    scale = max(map(abs, forces))
    later = range(int(0.6 * count), count)
    off = max(abs(sums[i] - forces[i]) for i in later)
    print(f"largest difference {off / scale:.4f} of the largest force")
    # frames lie within aerodynamic steps of 1.25 ms, whereas the pressures are those at the ends of these steps
    assert off < 0.03 * scale
    profile = browser.value(f"Array.from({{ length: about.surfaces[0].panels }}, (_, row) => pressureAt(main, 0, 4, row, {count - 1}))")
    assert all(abs(a) > abs(b) for a, b in zip(profile, profile[1:])), profile
    browser.value("(list => { list.value = 'pressure'; list.dispatchEvent(new Event('change')); return true; })(get('surface-field'))")
    press(browser, "End")
    settled(browser)
    triangles = browser.value("shapes.find(one => one instanceof SurfaceShape).mesh.geometry.index.count / 3")
    assert triangles == 2 * 10 * 4
    assert browser.value("get('surface-scale').firstChild.textContent") == "pressure jump (Pa)"
    assert browser.complaints() == []


WAITING = "new Promise(done => setTimeout(() => done(true), 400))"


def test_f374_the_address_opens_the_page_as_it_was(browser, pages):
    """F-374. Time, fields, followed and selected objects, camera and open diagrams are in the fragment of the address; a page opened with
    it shows the same image, and so does an open page to which it is passed. Invalid parts are named, and the others applied.
    """
    page = pages / "wing.html"
    browser.open(page)
    browser.value("seek(main.positionAt(0.1234)), true")
    browser.value("for (const [id, value] of [['field', 'bending_y'], ['surface-field', 'pressure']]) { get(id).value = value; get(id).dispatchEvent(new Event('change')); } true")
    browser.value("choose(sectionPicked(1, 0.06)), setFollow('picked'), turn(0.4, -0.3), zoom(0.6), toggleFlat(), true")
    browser.value("get('along').open = true, true")
    settled(browser)
    awaited(browser, WAITING)
    state = "[get('clock').textContent, get('field').value, get('surface-field').value, get('follow').value, picked.title, picked.on.place, get('along').open]"
    fragment, before, camera = browser.value("location.hash"), browser.value(state), browser.value("[camera.azimuth, camera.elevation, camera.distance, ...camera.target, camera.flat]")
    first = picture(browser)
    assert re.search(r"t=0\.1234\d*&field=bending_y&surfaces=pressure&at=body%3Aouter%2C0\.06&follow=picked&camera=", fragment), fragment
    browser.open("about:blank")
    browser.open(page.resolve().as_uri() + fragment)
    settled(browser)
    assert browser.value(state) == before
    # five digits of the camera are kept
    assert browser.value("[camera.azimuth, camera.elevation, camera.distance, ...camera.target, camera.flat]") == pytest.approx(camera, rel=2e-5, abs=2e-5)
    second = picture(browser)
    assert changed_share(first, second) < 0.01
    assert browser.complaints() == []
    # a preset, another selection, and invalid parts
    browser.value("(location.hash = '#t=0.05&view=top&at=gauge:root&field=nonsense&colour=red'), true")
    stop = time.monotonic() + PATIENCE_S
    while browser.value("get('clock').textContent") != "t = 0.0500 s" and time.monotonic() < stop:
        settled(browser)
    assert browser.value("[get('clock').textContent, picked.title, camera.preset]") == ["t = 0.0500 s", "gauge root", "top"]
    assert browser.value("camera.axes[2]") == pytest.approx([0, 0, 1], abs=1e-12)
    assert browser.value("get('said').textContent") == "parts of the address that do not apply to this page: field=nonsense, colour"
    for bad in ("t=soon", "at=body:outer,9", "at=gauge:none", "camera=1,2", "camera=0,0,-1,0,0,0", "follow=picked2", "view=below", "ortho=2", "along=x", "%E0=1"):
        browser.value(f"(location.hash = '#{bad}'), true")
        awaited(browser, WAITING)
        assert bad.split("=")[0] in browser.value("get('said').textContent") or bad.startswith("%"), bad
    assert browser.complaints() == []


def changed_share(one, other):
    """Fraction of the pixels of two PNG files that differ by more than 16 of 255."""
    difference = ImageChops.difference(*(Image.open(io.BytesIO(data)).convert("RGB") for data in (one, other)))
    largest = functools.reduce(ImageChops.lighter, difference.split())
    return sum(largest.histogram()[17:]) / math.prod(largest.size)


def test_f378_a_sweep_is_a_fan_with_bands(foldwing, browser, tmp_path):
    """F-378. Twelve start angles on one page: the end of every drawn axis is that of its run, the bands of the plots are the quantiles of
    the twelve runs; one draw call more than without them, less than 10 MB; the check box hides lines and bands.
    """
    model, angles = ROOT / "examples/models/folding_wing.toml", [1.8 + 0.1 * i for i in range(12)]
    values = ",".join(f"{value:.2f}" for value in angles)
    page, rows = tmp_path / "fan.html", tmp_path / "sweep.csv"
    subprocess.run([foldwing, "sweep", model, "--vary", f"fold.start_angle={values}", "-o", rows, "--view", page, "--quiet"], check=True)
    assert page.stat().st_size < 10_000_000
    for width, dark in ((1700, False), (390, True)):
        browser.open(page, width, 1000, dark)
        settled(browser)
        assert browser.complaints() == [] and browser.value("document.documentElement.scrollWidth") <= width
    browser.open(page)
    assert browser.value("[fan.count, fan.like, fan.labels.length, fan.labels[3][0]]") == [12, 12, 12, "2.10"]
    runs = []
    for value in angles:
        csv_file = tmp_path / f"{value:.2f}.csv"
        subprocess.run([foldwing, "simulate", model, "--set", f"fold.start_angle={value:.2f}", "--csv", csv_file, "--quiet", "--variables", "fold.angle,tip.position.*"], check=True)
        runs.append({round(float(row["time"]), 6): row for row in records(csv_file)})
    times = browser.value("fanTimes")
    for index in (0, 40, 77, len(times) - 1):
        time_s = round(times[index], 6)
        own = [float(run[time_s]["fold.angle"]) * 180.0 / math.pi for run in runs]
        bands = browser.value(f"bandsOf('fold.angle').map(band => band.values[{index}])")
        assert bands == pytest.approx([quantile(own, fraction) for fraction in (0.0, 0.05, 0.5, 0.95, 1.0)], rel=1e-6, abs=1e-6 * max(map(abs, own)) + 1e-9)
        for run in (0, 7, 11):
            tip = browser.value(f"vector(fan.numbers, fanPlace({run}, {index}, fanPoints - 1))")
            assert tip == pytest.approx([float(runs[run][time_s][f"tip.position.{axis}"]) for axis in "xyz"], abs=1e-6)
    # the lines change with time, and are one object
    browser.value("(seek(main.positionAt(fanTimes[40])), true)")
    with_fan = picture(browser)
    calls = browser.value("renderer.info.render.calls")
    ends = browser.value("Array.from(fanLines.geometry.getAttribute('position').array.slice(-3))")
    assert ends == pytest.approx(browser.value("vector(fan.numbers, fanPlace(11, 40, fanPoints - 1))"), abs=1e-6)
    series = browser.value("charts[0].plot.series.length")
    browser.value("get('fan').click(), true")
    assert picture(browser) != with_fan
    assert browser.value("renderer.info.render.calls") == calls - 1
    assert browser.value("charts[0].plot.series.length") == series - 5
    assert browser.complaints() == []


def quantile(values, fraction):
    """Value below which a fraction of the values lies, linear between them."""
    values = sorted(values)
    place = fraction * (len(values) - 1)
    before = min(int(place), len(values) - 2)
    return values[before] + (place - before) * (values[before + 1] - values[before])
