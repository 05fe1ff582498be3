"""Times from a key press to the picture in the pages written by `make live-site`, and run times of the engine as WebAssembly.

    live_times.py --live target/live [--repeats 12]

Headless Chromium with software WebGL types a comment into every model of the gallery, then a letter into its name, after which the page makes a
new scene; in Node the engine runs alone.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests/fmi"))
from browser import Browser  # noqa: E402


COMMENT = "editor.dispatch({ changes: { from: 0, insert: '#\\n' } })"
# another name of the model: the page then makes a new scene, as after a change of a length
NAME = """(text => {
    const at = /^name *= *"[^"]*/m.exec(text), end = at.index + at[0].length;
    editor.dispatch({ changes: { from: end, insert: "a" } });
})(editor.state.doc.toString())"""


def typed(page, name, repeats, change=COMMENT):
    """Times in ms from the key press to the first picture and to that of the whole run, per repeat."""
    page.value(f"location.hash = '#{name}', 0")
    until(page, f"page.model === '{name}' && page.shown && page.shown.done && page.shown.id === page.latest")
    for _ in range(repeats):
        before = page.value("page.latest")
        page.value(f"{change}, 0")
        until(page, f"page.shown.done && page.shown.id > {before}")
        yield page.value("[page.shown.first, page.shown.all]")


def until(page, condition):
    """Waits for a condition of the page, two minutes at most."""
    stop = time.monotonic() + 120
    while not page.value(f"Boolean({condition})"):
        if time.monotonic() > stop:
            sys.exit(f"live_times: {condition} did not come")
        time.sleep(0.02)


def main():
    """Runs the command."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--live", type=Path, required=True, help="folder that `make live-site` has written")
    parser.add_argument("--repeats", type=int, default=12)
    arguments = parser.parse_args()
    gallery = json.loads((ROOT / "crates/web/page/gallery.json").read_text(encoding="utf-8"))
    done = subprocess.run(["node", ROOT / "tests/fmi/live_engine.mjs", arguments.live, str(arguments.repeats)], check=True, capture_output=True, text=True)
    alone = json.loads(done.stdout)["models"]
    print(f"load {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores; ms, the least of {arguments.repeats}")
    print("| model | engine alone, to the first step | to the whole run: clock | processor | key to first picture: least, median | with a new scene | key to the whole run |"
          "\n|---|---|---|---|---|---|---|")
    with Browser() as page:
        page.open(arguments.live / "index.html", width=1400, height=900)
        for row in gallery:
            name = row["name"]
            times, renamed = (list(typed(page, name, arguments.repeats, change)) for change in (COMMENT, NAME))
            first, whole = ([one[i] for one in times] for i in (0, 1))
            scene = [one[0] for one in renamed]
            print(f"| `{name}` | {alone[name]['begun']:.1f} | {alone[name]['all']:.0f} | {alone[name]['processor']:.0f} | {min(first):.0f}, {statistics.median(first):.0f} "
                  f"| {min(scene):.0f}, {statistics.median(scene):.0f} | {min(whole):.0f} |", flush=True)
    print(f"load {os.getloadavg()[0]:.1f}")


if __name__ == "__main__":
    main()
