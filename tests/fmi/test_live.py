"""`foldwing live`: a model that is simulated in wall-clock time and controlled by the user, as shown by a browser."""

import json
import math
import signal
import subprocess
import time

import pytest
from browser import PATIENCE_S
from conftest import ROOT, WHOLE
from live_client import Client, farewell, live
from test_viewer import ON_PAGE, UNLABELLED, centre, mouse, press, settled

WING = ROOT / "examples/models/folding_wing.toml"
TUNNEL = ROOT / "examples/models/folding_wing_in_tunnel.toml"
TURBINE = ROOT / "examples/turbine/nrel_5mw.toml"
# settles within a second of simulated time; damping does not affect statics
QUIET = [word for body in ("inner", "outer") for word in ("--set", f"body.{body}.mass_damping=20")]


def awaited(browser, expression, what):
    """Waits until an expression in the page is true."""
    stop = time.monotonic() + PATIENCE_S
    while not browser.value(f"Boolean({expression})"):
        assert time.monotonic() < stop, (what, browser.value("[get('pace').textContent, get('said').textContent, main.timeOf(main.last)]"))
        time.sleep(0.02)


def opened(browser, address, **options):
    """Opens the page at an address, connected, with the machine at its start."""
    browser.open(address, **options)
    awaited(browser, "link.socket.readyState === WebSocket.OPEN && controls.length && !link.fresh", "no picture came")


def present(browser):
    """Time of the last picture."""
    return browser.value("main.timeOf(main.last)")


def leave(browser):
    """Closes the page."""
    browser.open("about:blank")


@pytest.mark.parametrize("dark, width", [(False, 1400), (True, 1400), (False, 390)])
def test_page_connects_and_shows_the_machine_in_real_time(foldwing, browser, dark, width):
    """The page finds its socket, has no console messages and no other requests, and shows as much time as has passed."""
    with live(foldwing, WING) as (address, process):
        opened(browser, address, width=width, dark=dark)
        assert browser.value("[get('name').textContent, get('play').textContent, get('pace').textContent]") == ["FoldingWing", "▶ run", "paused"]
        assert browser.value("document.querySelectorAll('#sliders .control').length + document.querySelectorAll('#switches button').length") \
            == browser.value("live.controls.length") > 64
        assert browser.value(UNLABELLED) == 0
        assert browser.value("document.documentElement.scrollWidth <= innerWidth")
        begun = time.monotonic()
        press(browser, " ", "Space")
        awaited(browser, "main.timeOf(main.last) > 0.3 && charts.every(chart => chart.plot.data[0].length > 20)", "no time passed")
        assert present(browser) <= time.monotonic() - begun, "ahead of the clock"
        assert browser.value("about.events.map(event => event.kind)") == ["latch"]
        assert browser.value("get('events').children.length") == 1
        assert browser.complaints() == []
        assert {request.split("/")[2] for request in browser.requests() if not request.startswith("data:")} == {address.split("/")[2]}
        leave(browser)
        assert farewell(process)["text"].startswith("note: the page was closed: ")
        assert process.returncode == 0


def test_a_pull_of_known_force_is_a_static_load(foldwing, browser):
    """The mouse pulls the tip of the wing in equilibrium; the new equilibrium is that of `foldwing static` under the force of the spring.
    The page has single precision: 1e-6 m of 0.3 m, and the deflection is a few millimetres."""
    with live(foldwing, WING, "--speed", "5", *QUIET) as (address, _):
        opened(browser, address)
        browser.value("get('stiffness').value = 10")
        press(browser, " ", "Space")
        awaited(browser, "main.present[main.layout.latched] > 0.5 && main.timeOf(main.last) > 3", "the wing does not latch")
        settled(browser)
        x, y = browser.value(f"{ON_PAGE}(stationPlace(7))")
        mouse(browser, "mousePressed", x, y, button="left", clickCount=1)
        for part in range(1, 9):
            mouse(browser, "mouseMoved", x, y - 5 * part, button="left", buttons=1)
        awaited(browser, "link.pull && link.pull.station === 7", "the spring does not pull")
        since = present(browser)
        awaited(browser, f"main.timeOf(main.last) > {since + 6}", "no time passed")
        force = browser.value("link.pull.force")
        tip = browser.value("main.section(1, about.bodies[1].rims.length - 1).at")
        assert browser.value("get('pulling').textContent").startswith("load.outer[4]: ")
        loads = [word for axis, value in zip("xyz", force) for word in ("--set", f"load.outer[4].force.{axis}={value!r}")]
        still = json.loads(subprocess.run([foldwing, "static", WING, "--json", *loads], check=True, capture_output=True, text=True).stdout)
        expected = still["tips"][0]["position_m"]
        assert still["joints"][0]["latched"] and math.hypot(*force) > 0.01 and abs(expected[2]) > 1e-3, (force, expected)
        assert math.dist(tip, expected) < 2e-6, (tip, expected, force)
        mouse(browser, "mouseReleased", x, y - 40, button="left", clickCount=1)
        awaited(browser, "!link.pull", "the spring still pulls")
        since = present(browser)
        awaited(browser, f"main.timeOf(main.last) > {since + 6}", "no time passed")
        assert abs(browser.value("main.section(1, about.bodies[1].rims.length - 1).at[2]")) < 1e-4
        assert browser.complaints() == []
        leave(browser)


def test_a_body_without_load_input_says_so(foldwing, browser):
    """The blades of the turbine have no stations: the page lists the bodies that have stations."""
    with live(foldwing, TURBINE) as (address, _):
        opened(browser, address)
        browser.value("setView('front')")
        settled(browser)
        # the middle of a blade, on its surface
        x, y = browser.value(f"""(() => {{ const b = about.bodies.findIndex(body => body.name === "blade1");
          return {ON_PAGE}(main.section(b, about.bodies[b].rims.length >> 1).at); }})()""")
        mouse(browser, "mousePressed", x, y, button="left", clickCount=1)
        said = browser.value("get('said').textContent")
        mouse(browser, "mouseReleased", x, y, button="left", clickCount=1)
        assert said == "blade1 has no load station to pull on; bodies with load stations: nacelle, generator, hub"
        leave(browser)


def test_pause_step_and_roll_back(foldwing, browser):
    """The simulation is paused, continues in single steps, and is rolled back by dragging the time bar, with its events and plots."""
    with live(foldwing, WING, "--speed", "0.2") as (address, _):
        opened(browser, address)
        browser.value("get('play').click()")
        awaited(browser, "main.timeOf(main.last) > 0.2", "no time passed")
        browser.value("get('play').click()")
        awaited(browser, "!link.running", "it does not pause")
        stands = present(browser)
        time.sleep(0.3)
        assert present(browser) == stands
        press(browser, "ArrowRight")
        awaited(browser, f"main.timeOf(main.last) > {stands} + 1e-5", "no step")
        assert abs(present(browser) - stands - 5e-4) < 1e-7
        assert browser.value("about.events.length") == 1
        # the bar: previews while it is dragged, rolls back when it is released
        # (the last picture before 0.1 s: a slow browser has few of them, and the next one may follow the latch)
        wanted = browser.value("Math.floor(main.positionAt(0.1))")
        at = browser.value(f"main.timeOf({wanted})")
        assert 0.0 < at <= 0.1
        browser.value(f"(() => {{ const bar = get('time'); bar.value = {wanted}; bar.dispatchEvent(new Event('input')); }})()")
        settled(browser)
        assert browser.value("main.timeAt(main.position)") == at and present(browser) > stands
        browser.value("get('time').dispatchEvent(new Event('change'))")
        awaited(browser, "main.timeOf(main.last) < 0.11", "it does not go back")
        back, angle = present(browser), browser.value("main.present[main.layout.angles]")
        assert back == at
        assert browser.value("[about.events.length, main.times[main.times.length - 1] <= main.timeOf(main.last) + 1e-6, get('events').children.length]") \
            == [0, True, 0]
        assert angle > 5.0, "the wing is folded there"
        # from there the wing latches again, at the same time
        browser.value("get('play').click()")
        awaited(browser, "main.timeOf(main.last) > 0.15", "it does not go on")
        again = browser.value("about.events.map(event => [event.kind, event.t])")
        assert [kind for kind, _ in again] == ["latch"] and abs(again[0][1] - 0.1222) < 5e-5, (back, again)
        browser.value("reset()")
        awaited(browser, "main.timeOf(main.last) === 0 && !link.running", "it does not start anew")
        assert browser.complaints() == []
        leave(browser)


def test_sliders_and_buttons_move_the_machine(foldwing, browser):
    """A slider sets its input in the displayed unit, a button opens the latch, an invalid value is rejected with a message."""
    with live(foldwing, WING, "--speed", "2") as (address, _):
        opened(browser, address)
        press(browser, " ", "Space")
        awaited(browser, "main.present[main.layout.latched] > 0.5", "the wing does not latch")
        browser.value("document.querySelector('#switches [data-name=\"fold.latch_enable\"]').click()")
        awaited(browser, "main.present[main.layout.latched] < 0.5 && about.events.some(event => event.kind === 'open')", "the latch does not open")
        assert browser.value("document.querySelector('#switches [data-name=\"fold.latch_enable\"]').getAttribute('aria-pressed')") == "false"
        slider = "document.querySelector('[data-name=\"fold.external_torque\"] input[type=range]')"
        browser.value(f"({slider}.value = 0.06, {slider}.dispatchEvent(new Event('input')))")
        awaited(browser, "main.present[main.layout.angles] > 20", "the torque does not turn the wing")
        field = "document.querySelector('[data-name=\"fold.motor_damping\"] input[type=number]')"
        browser.value(f"({field}.value = -1, {field}.dispatchEvent(new Event('change')))")
        awaited(browser, "get('said').textContent", "nothing is said")
        assert browser.value("get('said').textContent") == "variable fold.motor_damping cannot be -1: it must be ≥ 0 N.m.s/rad"
        browser.value("(get('filter').value = 'inner[2].force', get('filter').dispatchEvent(new Event('input')))")
        assert browser.value("[...document.querySelectorAll('#sliders .control')].filter(row => row.checkVisibility()).map(row => row.dataset.name)") \
            == [f"load.inner[2].force.{axis}" for axis in "xyz"]
        leave(browser)


def test_the_end_of_the_process_is_told_to_the_page(foldwing, browser):
    """Ctrl-C ends the process without an error; the page reports this and keeps the run."""
    with live(foldwing, WING) as (address, process):
        opened(browser, address)
        press(browser, " ", "Space")
        awaited(browser, "main.timeOf(main.last) > 0.1", "no time passed")
        process.send_signal(signal.SIGINT)
        assert farewell(process)["text"].startswith("note: interrupted: ")
        assert process.returncode == 0
        awaited(browser, "link.ended", "the page does not notice")
        assert browser.value("get('pace').textContent") == "The simulation has ended; the run so far remains on this page."
        assert browser.value("get('play').disabled") and present(browser) > 0.1
        leave(browser)


def damped(folder, name="DampedWing", factor=5):
    """The folding wing with another name and a larger damping of the joint."""
    text = WING.read_text().replace('name = "FoldingWing"', f'name = "{name}"')
    changed = text.replace("damping_N_m_s_rad = 0.0008", f"damping_N_m_s_rad = {0.0008 * factor:g}")
    assert changed != text != WING.read_text()
    path = folder / f"damped_{factor}.toml"
    path.write_text(changed)
    return path


def latch_time(foldwing, model):
    """Time of the first latch of a run of a model."""
    run = json.loads(subprocess.run([foldwing, "simulate", model, "--json", "--stop", "1"], check=True, capture_output=True, text=True).stdout)
    return run["joints"][0]["latch_time_s"]


@pytest.mark.parametrize("dark, width", [(False, 1400), (True, 390)])
def test_two_machines_run_in_step(foldwing, browser, tmp_path, dark, width):
    """Two wings have one clock, step and rollback; each latches at the same time as alone; both are drawn, with a legend and curves for both."""
    other = damped(tmp_path)
    with live(foldwing, WING, "--compare", other, "--speed", "0.5") as (address, _):
        opened(browser, address, dark=dark, width=width)
        both = "runs.map(run => run.timeOf(run.last))"
        assert browser.value("runs.map(run => run.label)") == ["FoldingWing", "DampedWing"]
        assert browser.value("[get('runs').hidden, ...[...get('runs').children].map(label => label.textContent)]") == [False, "FoldingWing", "DampedWing – – –"]
        assert browser.value(UNLABELLED) == 0
        assert browser.value("document.documentElement.scrollWidth <= innerWidth")
        press(browser, " ", "Space")
        awaited(browser, "about.events.filter(event => event.kind === 'latch').length === 2", "they do not both latch")
        press(browser, " ", "Space")
        awaited(browser, "!link.running", "it does not pause")
        times = dict(browser.value("about.events.filter(event => event.kind === 'latch').map(event => [event.text.split(':')[0], event.t])"))
        for name, model in (("FoldingWing", WING), ("DampedWing", other)):
            assert abs(times[name] - latch_time(foldwing, model)) < 5e-5, (name, times)
        assert times["DampedWing"] > times["FoldingWing"] + 0.01
        one, two = browser.value(both)
        assert one == two > times["DampedWing"]
        # both have curves with the same times; single precision
        assert browser.value("charts[0].plot.series.slice(1).map(series => series.label)") == ["fold.angle", "fold.angle (DampedWing)"]
        assert browser.value("runs[1].times.length === main.times.length && runs[1].times.every((time, i) => time === main.times[i])")
        gap = browser.value("Math.max(...main.samples.get('fold.angle').map((angle, i) => Math.abs(angle - runs[1].samples.get('fold.angle')[i])))")
        assert gap > 0.1, "the curves are the same"
        press(browser, "ArrowRight")
        awaited(browser, f"main.timeOf(main.last) > {one} + 1e-5", "no step")
        assert browser.value(both) == [pytest.approx(one + 5e-4, abs=1e-7)] * 2
        browser.value("rollBack(main.positionAt(0.05))")
        awaited(browser, "main.timeOf(main.last) < 0.06 && runs[1].timeOf(runs[1].last) < 0.06", "it does not go back")
        back = browser.value(both)
        assert back[0] == back[1] and browser.value("about.events.length") == 0
        # the curves end there too
        assert browser.value(f"runs.every(run => run.times[run.times.length - 1] <= {back[0]} + 1e-6)")
        # the second can be hidden
        browser.value("get('runs').children[1].querySelector('input').click()")
        settled(browser)
        assert browser.value("[shapes.filter(shape => shape.run !== main && shape.mesh.visible).length, charts[0].plot.series.length]") == [0, 2]
        assert browser.complaints() == []
        leave(browser)


def test_controls_and_pulls_act_on_both_machines_or_one(foldwing, browser, tmp_path):
    """A slider acts on both machines, or on the selected one; the page shows differences between them. A pull acts on the same stations of both."""
    with live(foldwing, WING, "--compare", damped(tmp_path)) as (address, _):
        opened(browser, address)
        row = lambda name: f"controls.find(one => one.control.name === '{name}')"  # noqa: E731
        assert browser.value(f"[{row('fold.motor_damping')}.values.map(value => +value.toPrecision(6)), {row('fold.motor_damping')}.note.textContent]") \
            == [[0.0008, 0.004], "FoldingWing: 0.0008 N.m.s/rad, DampedWing: 0.004 N.m.s/rad"]
        move = "(name => value => { const field = document.querySelector(`[data-name=\"${name}\"] input[type=number]`); field.value = value; field.dispatchEvent(new Event('change')); })"
        browser.value(f"{move}('fold.external_torque')(0.01)")
        awaited(browser, f"{row('fold.external_torque')}.values.every(value => value === 0.01)", "the slider does not move both")
        choose = lambda value: browser.value(f"(get('acts-on').value = '{value}', get('acts-on').dispatchEvent(new Event('change')))")  # noqa: E731
        choose("1")
        browser.value(f"{move}('fold.external_torque')(0.02)")
        awaited(browser, f"{row('fold.external_torque')}.values[1] === 0.02", "the slider does not move the second")
        assert browser.value(f"{row('fold.external_torque')}.values[0]") == 0.01
        browser.value("document.querySelector('#switches [data-name=\"fold.latch_enable\"]').click()")
        awaited(browser, f"{row('fold.latch_enable')}.note?.textContent === 'FoldingWing: on, DampedWing: off'", "the switch acts on the wrong machine")
        # pulls: the machines coincide at the start
        browser.value("get('stiffness').value = 1")
        for chosen, pulled in (("", [True, True]), ("0", [True, False])):
            choose(chosen)
            settled(browser)
            x, y = browser.value(f"{ON_PAGE}(stationPlace(7))")
            mouse(browser, "mousePressed", x, y, button="left", clickCount=1)
            assert browser.value("spring.held.run.label") == "FoldingWing"
            for part in range(1, 5):
                mouse(browser, "mouseMoved", x, y - 5 * part, button="left", buttons=1)
            awaited(browser, f"JSON.stringify(link.pulls.map(Boolean)) === '{json.dumps(pulled, separators=(',', ':'))}'", "the spring pulls at the wrong machine")
            mouse(browser, "mouseReleased", x, y - 20, button="left", clickCount=1)
            awaited(browser, "link.pulls.every(pull => !pull)", "the spring still pulls")
        assert browser.complaints() == []
        leave(browser)


def test_machines_that_cannot_run_in_step_are_refused(foldwing, tmp_path):
    """A second model that cannot be shown with the first one is an error with its name and the remedy."""
    late = tmp_path / "late.toml"
    late.write_text(WING.read_text().replace("[simulation]\n", "[simulation]\nstart_time_s = 0.1\n"))
    state = tmp_path / "state"
    state.write_bytes(b"")
    table = tmp_path / "run.csv"
    for words, code, said in (
        (["--compare", table], 2, f"--compare {table}: must be a model file (.toml): runs and tables are compared by `simulate --view --compare`"),
        (["--compare", late], 2, f"--compare {late}: starts at 0.1 s and the first model at 0 s, but they have one clock; set the same start_time_s in [simulation]"),
        (["--compare", WING] * 4, 2, f"--compare {WING}: there can be at most 3 models besides the first"),
        (["--compare", WING, "--state", state], 2, "--state: 1 states cannot start 2 models; give one state for each, in their order"),
        (["--compare", tmp_path / "none.toml"], 4, "none.toml"),
    ):
        done = subprocess.run([foldwing, "live", WING, "--no-browser", *words], capture_output=True, text=True, timeout=PATIENCE_S)
        assert done.returncode == code and said in done.stderr and not done.stdout, (words, done)


# Machine and speed relative to real time. In `make validate`, alone on the computer, no time may be lost. The lattice wing takes 0.73 s of
# processor time per second: at a quarter of real time it keeps up on a computer five times as slow.
PACED = [(WING, 1.0), (TURBINE, 1.0), (TUNNEL, 0.25), (TUNNEL, 1.0)]


@pytest.mark.parametrize("model, speed", PACED, ids=lambda value: getattr(value, "stem", str(value)))
def test_the_clock_does_not_fall_behind(foldwing, model, speed, record_property):
    """A live run of one minute: never ahead of the wall clock, and no time is lost. Five seconds in `make test`, together with other work:
    time not simulated is counted as lost."""
    span_s = 60.0 if WHOLE else 5.0
    with live(foldwing, model, "--speed", str(speed)) as (address, process):
        client = Client(address)
        first = client.picture()
        # the clock is read before the order is sent: the program may run before `ask` returns
        begun, factors = time.monotonic(), []
        client.ask(do="run")
        while time.monotonic() - begun < span_s:
            header = client.picture()
            # a header is older than the clock reading after it
            assert header["time"] - first["time"] <= speed * (time.monotonic() - begun), "ahead of the clock"
            factors.append(header["factor"])
        passed = time.monotonic() - begun
        gone = client.picture()
        process.send_signal(signal.SIGINT)
        figures = farewell(process)
    record_property("figures", figures["text"])
    print(model.stem, speed, figures["text"], "smallest factor", min(filter(None, factors)))
    if not WHOLE:
        # whatever the speed of this computer, the times add up, apart from a delay still to be caught up and the time of a picture
        assert abs(figures["simulated"] / speed + figures["lost"] - figures["ran"]) < 1.0, figures
        # the note is rounded to milliseconds
        assert gone["lost"] <= figures["lost"] + 1e-3
        return
    assert figures["lost"] == 0.0, figures
    assert figures["simulated"] >= speed * (passed - figures["lost"] - 0.3), (passed, figures)
