"""The models of the documentation run in its pages: the engine as WebAssembly in Node, and the page in a browser.

`make live-site` builds the pages under test; it needs a compiler with the target wasm32-unknown-unknown, and lists the packages to install if it
is missing.
"""

import base64
import gzip
import json
import os
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
LIVE = Path(os.environ.get("FOLDWING_LIVE", ROOT / "target/live"))
GALLERY = json.loads((ROOT / "crates/web/page/gallery.json").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def live():
    """The folder written by `make live-site`."""
    if not (LIVE / "engine.js").exists():
        pytest.skip("the engine is not compiled for pages: `make live-site` compiles it, or lists the packages to install")
    return LIVE


@pytest.fixture(scope="module")
def engine(live):
    """Results of the engine in Node, without a browser."""
    node = shutil.which("node")
    if node is None:
        pytest.skip("node is not installed (Debian: nodejs): it runs the module without a browser")
    done = subprocess.run([node, ROOT / "tests/fmi/live_engine.mjs", live], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_lw01_engine_is_small_and_whole(live):
    """Below 2 MB compressed; pages opened from disk load the module itself."""
    packed = re.fullmatch(r'const ENGINE = "([A-Za-z0-9+/=]+)";\n', (live / "engine.js").read_text(encoding="ascii"))[1]
    packed = base64.b64decode(packed)
    module = (live / "foldwing.wasm").read_bytes()
    assert gzip.decompress(packed) == module and module[:4] == b"\0asm"
    assert len(packed) < 2_000_000, len(packed)


def test_lw02_every_model_of_the_gallery_runs(engine):
    """At least 20 models, simulated to their stop times, each with a picture."""
    assert len(GALLERY) >= 20 and set(engine["models"]) == {row["name"] for row in GALLERY}
    for name, found in engine["models"].items():
        assert found["state"] == 1 and found["summary"]["failure"] is None, (name, found["summary"])
        assert found["summary"]["share"] == 1.0 and found["frames"] >= 2 and found["numbers"] > 0, name


def test_lw03_latch_times_are_those_of_the_command(engine, foldwing):
    """Latch times agree to 1e-12 s, the round-off of functions such as the sine from different libraries, with the same number of steps: it
    is the same program. In machines with loops of springs, round-off grows: the last digit of gravity moves the latch time of the braced
    wing by 5e-7 s and its thirteenth digit by 1e-6 s in the command, so that these may differ by 1e-5 s.
    """
    compared = 0
    for row in GALLERY:
        found = engine["models"][row["name"]]["summary"]
        if not any(latch["time_s"] is not None for latch in found["latches"]):
            continue
        done = subprocess.run([foldwing, "simulate", ROOT / row["model"], "--csv", os.devnull, "--quiet", "--json"], capture_output=True, text=True)
        native = json.loads(done.stdout)
        assert native["solver"]["steps"] == found["steps"], row["name"]
        times = {joint["name"]: joint["latch_time_s"] for joint in native["joints"]}
        allowed_s = 1e-5 if "[loop." in (ROOT / row["model"]).read_text(encoding="utf-8") else 1e-12
        for latch in found["latches"]:
            expected = times[latch["joint"]]
            assert (expected is None) == (latch["time_s"] is None), (row["name"], latch)
            if expected is not None:
                print(f"{row['name']}: latch {latch['joint']} {latch['time_s'] - expected:.1e} s after that of the command")
                assert abs(latch["time_s"] - expected) < allowed_s, (row["name"], latch, expected)
                compared += 1
    assert compared >= 10, compared


def test_lw04_a_refusal_has_line_column_and_cure(engine):
    """A misspelt key is reported with its position and the intended key."""
    assert engine["refused"] == 1
    text = (ROOT / GALLERY[0]["model"]).read_text(encoding="utf-8").replace("length_m", "lenght_m", 1)
    at = text.index("lenght_m")
    mark = next(mark for mark in engine["refusal"]["marks"] if "lenght_m" in mark["message"])
    assert (mark["line"], mark["column"]) == (text[:at].count("\n") + 1, at - text.rfind("\n", 0, at))
    assert "length_m" in mark["message"]


def shown(browser, wanted="page.shown && page.shown.done && page.shown.id === page.latest", patience_s=120):
    """Waits for a picture."""
    stop = time.monotonic() + patience_s
    while not browser.value(f"Boolean({wanted})"):
        assert time.monotonic() < stop, browser.value("document.querySelector('#engine-state').textContent")
        time.sleep(0.02)
    return browser.value("page.shown")


def type_at(browser, place, text):
    """Replaces the text between two positions of the model file."""
    browser.value(f"editor.focus(), editor.dispatch({{ selection: {{ anchor: {place[0]}, head: {place[1]} }} }}), 0")
    browser.call("Input.insertText", text=text)


def test_lw05_typing_changes_the_picture(live, browser):
    """Opened from disk: the run of the new text replaces the previous one; the view and the plots selected by the reader are kept."""
    browser.open(live / "index.html")
    browser.value("location.hash = '#folding_wing', 0")
    first = shown(browser)
    assert first["summary"]["name"] == "FoldingWing" and first["summary"]["latches"][0]["time_s"] == pytest.approx(0.1222, abs=1e-3)
    before = browser.value("Array.from(page.viewer.main.numbers.slice(-50))")
    browser.value("page.viewer.charts[0].remove(), document.querySelector('[data-view=top]').click(), document.querySelector('#ground').click(), 0")
    charts = browser.value("page.viewer.charts.length")
    text = browser.value("editor.state.doc.toString()")
    at = re.search(r"constant_torque_N_m *= *([0-9.e-]+)", text)
    type_at(browser, at.span(1), "0.05")
    second = shown(browser, f"page.shown.done && page.shown.id > {first['id']}")
    assert second["summary"]["latches"][0]["time_s"] != first["summary"]["latches"][0]["time_s"]
    assert browser.value("Array.from(page.viewer.main.numbers.slice(-50))") != before
    assert browser.value("page.viewer.charts.length") == charts and not browser.value("document.querySelector('#ground').checked")
    kept = browser.value("page.viewer.keptNow().camera")
    assert kept["elevation"] == pytest.approx(1.5708, abs=1e-3)
    assert not browser.complaints() and {url.split(":")[0] for url in browser.requests()} <= {"file", "data", "blob"}


def test_lw06_an_error_is_shown_in_its_line(live, browser):
    """The line is marked and the cause is shown below it with the remedy, while the last valid picture remains; after a correction the page
    continues."""
    browser.open(live / "index.html")
    browser.value("location.hash = '#three_bodies', 0")
    first = shown(browser, "page.shown && page.shown.done && page.model === 'three_bodies' && page.shown.id === page.latest")
    text = browser.value("editor.state.doc.toString()")
    at = text.index("length_m")
    line = text[:at].count("\n") + 1
    type_at(browser, (at, at + 8), "lenght_m")
    stop = time.monotonic() + 60
    while not browser.value("Boolean(page.refused)"):
        assert time.monotonic() < stop
        time.sleep(0.02)
    rows = browser.value("[...document.querySelectorAll('#engine-marks button')].map(row => row.textContent)")
    assert any(row.startswith(f"line {line}, column 1") and "length_m" in row for row in rows), rows
    marked = browser.value("(mark => mark && editor.state.doc.lineAt(editor.posAtDOM(mark)).number)(document.querySelector('.cm-lintRange-error'))")
    assert marked == line
    assert browser.value("page.shown.id") == first["id"] and browser.value("document.querySelector('main').classList.contains('behind')")
    type_at(browser, (at, at + 8), "length_m")
    again = shown(browser, f"page.shown.done && page.shown.id > {first['id']}")
    assert again["summary"]["steps"] == first["summary"]["steps"]
    assert not browser.value("document.querySelectorAll('#engine-marks .error').length")


OFFERED = "[...document.querySelectorAll('.cm-tooltip-autocomplete li')].map(row => row.querySelector('.cm-completionLabel').textContent)"
CHOSEN = "document.querySelector('.cm-tooltip-autocomplete li[aria-selected] .cm-completionLabel')?.textContent ?? null"


def press(browser, key, code, number, modifiers=0):
    """A key with its code, its number and its modifiers (2: Ctrl)."""
    for kind in ("rawKeyDown", "keyUp"):
        browser.call("Input.dispatchKeyEvent", type=kind, key=key, code=code, windowsVirtualKeyCode=number, modifiers=modifiers)


def at_the_end(browser, text):
    """Appends text and sets the cursor behind it."""
    browser.value(f"editor.focus(), editor.dispatch({{ changes: {{ from: editor.state.doc.length, insert: {json.dumps(text)} }} }}), "
                  "editor.dispatch({ selection: { anchor: editor.state.doc.length } }), 0")


def accepted(browser, word, line):
    """Waits until the word is selected, accepts it with Enter, and compares the last line; the editor ignores Enter in the first 75 ms of a list."""
    browser.await_value(CHOSEN, word)
    time.sleep(0.2)
    press(browser, "Enter", "Enter", 13)
    browser.await_value("editor.state.doc.toString().split('\\n').pop()", line)


def test_f390_completion_while_the_engine_runs(live, browser):
    """F-390. While the texts being typed are refused by the engine, the list stays: table, key with its unit, and word are completed with the
    keyboard, and the completed text runs with as many steps as in the command. While the tunnel runs, Ctrl-Space opens a list before the run
    ends, and neither its pictures nor its end close it; Escape does. The console stays empty.
    """
    browser.open(live / "index.html")
    browser.value("location.hash = '#folding_wing', 0")
    first = shown(browser)
    at_the_end(browser, "\n")
    for letter in "[sol":
        browser.call("Input.insertText", text=letter)
    accepted(browser, "solver", "[solver]")
    at_the_end(browser, "\n")
    for letter in "max_st":
        browser.call("Input.insertText", text=letter)
    shown(browser, "page.refused && page.refused.id === page.latest")
    detail = "document.querySelector('.cm-tooltip-autocomplete li[aria-selected] .cm-completionDetail').textContent"
    browser.await_value(CHOSEN, "max_step_s")
    assert browser.value(detail).startswith("s") and browser.value("page.shown.id") >= first["id"]
    accepted(browser, "max_step_s", "max_step_s = ")
    browser.call("Input.insertText", text="0.0005")
    shown(browser)
    at_the_end(browser, "\nmethod = ")
    browser.call("Input.insertText", text='"')
    browser.await_value(f"{OFFERED}.includes('\"rk4\"')", True)
    browser.call("Input.insertText", text="sd")
    accepted(browser, '"sdirk2"', 'method = "sdirk2"')
    last = shown(browser)
    assert last["summary"]["failure"] is None and last["summary"]["steps"] >= 0.4 / 0.0005 - 1 > first["summary"]["steps"]
    # while the tunnel runs
    browser.value("location.hash = '#folding_wing_in_tunnel', 0")
    shown(browser, "page.model === 'folding_wing_in_tunnel' && page.shown.id === page.latest && !page.shown.done")
    at_the_end(browser, "\n[solver]\n")
    begun = time.monotonic()
    press(browser, " ", "Space", 32, modifiers=2)
    browser.await_value(f"{OFFERED}.includes('tolerance')", True)
    print(f"list {1e3 * (time.monotonic() - begun):.0f} ms after Ctrl-Space, while the tunnel runs")
    assert not browser.value("page.shown.done && page.shown.id === page.latest"), "the run was over before the list was open"
    shown(browser)
    assert "tolerance" in browser.value(OFFERED)
    press(browser, "Escape", "Escape", 27)
    browser.await_value(OFFERED, [])
    assert not browser.complaints()


def test_f392_shaders_are_kept_from_run_to_run(live, browser):
    """F-392. Once two runs of a model have been drawn, further runs link no shader program, whatever is visible in their first pictures: without
    a GPU a program takes 50 to 200 ms.
    """
    browser.open(live / "index.html")
    for name in ("two_body", "flying_wing"):
        browser.value(f"location.hash = '#{name}', 0")
        shown(browser, f"page.model === '{name}' && page.shown && page.shown.done && page.shown.id === page.latest")
        for number in range(6):
            if number == 2:
                browser.value("""(gl => { globalThis.linked = 0; const own = gl.linkProgram.bind(gl);
                    gl.linkProgram = program => { linked++; own(program); }; })(page.viewer.renderer.getContext())""")
            before = browser.value("page.latest")
            # a comment, then another name, which needs a new scene for the beginning of the run, too
            place = re.search(r'(?m)^name *= *"()', browser.value("editor.state.doc.toString()")).end() if number % 2 else 0
            browser.value(f"editor.dispatch({{ changes: {{ from: {place}, insert: {json.dumps('A' if number % 2 else '#' + chr(10))} }} }}), 0")
            shown(browser, f"page.shown.done && page.shown.id > {before}")
        assert browser.value("linked") == 0, name
        browser.value("delete page.viewer.renderer.getContext().linkProgram, 0")
    assert not browser.complaints()


def test_f394_shaders_of_slow_computers_are_kept(live, browser):
    """F-394. Where frames take long, a run is played without shadows, with other shader programs. These are kept from run to run, too: frames
    of 120 ms while runs play, and runs after them link no program.
    """
    browser.open(live / "index.html")
    browser.value("location.hash = '#folding_wing', 0")
    shown(browser)
    browser.value("globalThis.slow = setInterval(() => { const begun = performance.now(); while (performance.now() - begun < 120); }, 1), 0")
    browser.value("document.querySelector('#repeat').checked || document.querySelector('#repeat').click(), 0")
    playing = "document.querySelector('#play').getAttribute('aria-pressed')"
    if browser.value(playing) != "true":
        browser.value("document.querySelector('#play').click(), 0")
    browser.await_value("page.viewer.keptNow().slowed === true", True)
    for number in range(5):
        time.sleep(2.5)
        assert browser.value(playing) == "true"
        if number == 2:
            browser.value("""(gl => { globalThis.linked = 0; const own = gl.linkProgram.bind(gl);
                gl.linkProgram = program => { linked++; own(program); }; })(page.viewer.renderer.getContext())""")
        before = browser.value("page.latest")
        browser.value("editor.dispatch({ changes: { from: 0, insert: '#\\n' } }), 0")
        shown(browser, f"page.shown.done && page.shown.id > {before}")
    time.sleep(2.5)
    assert browser.value("linked") == 0
    assert not browser.complaints()


def test_f393_beginnings_of_runs_continue_in_the_scene(live, browser):
    """F-393. While a run lasts, its beginning is drawn in the scene of the previous run: the ends are where the whole run has them at the same
    times, and not where the previous run had them; the plots of the previous run, their lines and the time of the reader are kept. A model with another structure, here another
    length of a body or another name, gets a scene of its own.
    """
    browser.open(live / "index.html")
    browser.value("location.hash = '#folding_wing', 0")
    first = shown(browser)
    browser.value("document.querySelector('#play').getAttribute('aria-pressed') === 'true' && document.querySelector('#play').click(), 0")
    browser.value("(bar => { bar.value = bar.max; bar.dispatchEvent(new Event('input')); })(document.querySelector('#time')), 0")
    browser.await_value("document.querySelector('#clock').textContent", "t = 0.4000 s")
    browser.value("""(own => {
        globalThis.log = [];
        globalThis.ends = (run, frame) => [run.timeOf(frame), ...run.about.bodies.map((body, b) => run.section(b, body.rims.length - 1, frame).at)];
        showRun = message => {
            const scene = page.viewer, plots = page.plotted.charts.length;
            own(message);
            const { main } = page.viewer;
            log.push({ id: message.id, done: message.done, continued: page.shown.continued, same: page.viewer === scene, plots,
                drawn: [main.timeAt(main.position), ...main.about.bodies.map((body, b) => main.section(b, body.rims.length - 1).at)],
                lines: page.plotted.charts.map(chart => chart.line.style.transform), ends: Array.from({ length: main.count }, (_, frame) => ends(main, frame)), slider: Number(document.querySelector("#time").max),
            });
        };
    })(showRun)""")
    before = browser.value("(run => Array.from({ length: run.count }, (_, frame) => ends(run, frame)))(page.viewer.main)")
    text = browser.value("editor.state.doc.toString()")
    lines = browser.value("page.plotted.charts.map(chart => chart.line.style.transform)")

    def typed(pattern, value):
        """Pictures of the run after the first match of a pattern is replaced; in the first group stands the text to replace."""
        last = browser.value("log.length = 0, page.latest")
        type_at(browser, re.search(pattern, browser.value("editor.state.doc.toString()")).span(1), value)
        shown(browser, f"page.shown.done && page.shown.id > {last}")
        return browser.value("log")

    def away(found, frames):
        """Largest distance in m of the ends in a frame from those of a run, interpolated between its frames; and the time of that frame."""
        time, *ends = found
        late = next(i for i, frame in enumerate(frames) if frame[0] >= time - 1e-9)
        (a, *from_m), (b, *to_m) = frames[max(late - 1, 0)], frames[late]
        share = (time - a) / (b - a) if b > a else 1.0
        return max(abs(x + share * (y - x) - z) for p, q, r in zip(from_m, to_m, ends) for x, y, z in zip(p, q, r))

    pictures = typed(r"constant_torque_N_m *= *([0-9.e-]+)", "0.2")
    *partial, whole = pictures
    assert partial and whole["done"] and not any(one["done"] for one in partial), [one["done"] for one in pictures]
    for one in partial:
        assert one["continued"] and one["same"] and one["plots"] == whole["plots"] and one["lines"] == lines
        assert one["slider"] == len(one["ends"]) - 1 and one["drawn"][0] == pytest.approx(one["ends"][-1][0], abs=1e-6)
        assert away(one["drawn"], whole["ends"]) < 1e-3, one["drawn"]  # chords between frames of the whole run
    late = max(partial, key=lambda one: one["drawn"][0])["drawn"]
    print(f"beginnings until {[round(one['drawn'][0], 4) for one in partial]} s; the last one {away(late, before):.3f} m from the previous run")
    if late[0] > 0.02:
        assert away(late, before) > 0.01
    # the reader was at the end of the run, and is again
    assert not whole["continued"] and whole["drawn"][0] == pytest.approx(0.4, abs=1e-6) and whole["slider"] == len(whole["ends"]) - 1
    for pattern, value in ((r'(?m)^name *= *"([^"]*)"', "Another"), (r"length_m *= *([0-9.e-]+)", "0.4")):
        assert not any(one["continued"] for one in typed(pattern, value))
    assert browser.value("editor.state.doc.toString()") != text and browser.value("page.shown.id") > first["id"] and not browser.complaints()


def test_lw08_editor_has_its_notice():
    """Names, versions and licence are in the bundle and next to it; the tool that updates it has the same versions."""
    folder = ROOT / "crates/web/page/vendor"
    notice = (folder / "codemirror.LICENSE.txt").read_text(encoding="utf-8").strip()
    bundle, tool = (folder / "codemirror.js").read_text(encoding="utf-8"), (ROOT / "tools/vendor_editor.py").read_text(encoding="utf-8")
    assert notice.count("opyright") >= 3 and notice in bundle.split("*/")[0]
    lines = (folder / "versions.txt").read_text(encoding="utf-8").splitlines()
    for line in lines:
        name, version = re.fullmatch(r"(\S+) (\S+): MIT", line).groups()
        assert f"{name} {version}" in notice and f'"{name}": "{version}"' in tool
    assert len(lines) > 10


def test_lw07_without_the_target_it_is_said_what_to_install(tmp_path):
    """A compiler without the target, whatever is installed on this computer."""
    fake = tmp_path / "rustc"
    fake.write_text("#!/bin/sh\necho /nowhere\n")
    fake.chmod(0o755)
    environment = {**os.environ, "FOLDWING_WASM_RUSTC": str(fake)}
    done = subprocess.run([sys.executable, ROOT / "tools/live_site.py", "--output", tmp_path / "live"], capture_output=True, text=True, env=environment)
    assert done.returncode == 1 and not (tmp_path / "live").exists()
    for needed in ("wasm32-unknown-unknown", "rustup target add", "libstd-rust-dev-wasm32", "FOLDWING_WASM_RUSTC"):
        assert needed in done.stderr, done.stderr
