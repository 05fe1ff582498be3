"""Measures the time per picture of the page that plays a run, in headless Chromium without a GPU: every shipped model, an aircraft and a
turbine; `make bench-viewer`.

  python studies/painting_time.py --foldwing COMMAND [--pictures 24]

Prints a table: draw calls and triangles of a picture, time per picture with the initial settings and with everything switched on,
pictures per second from the smallest time, and whether the target of ten is met. Fails if a picture has more than 150 draw calls or 40
000 triangles, or if a page writes to the console or sends a request. Software WebGL (SwiftShader) uses all cores: run nothing else.
"""

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests/fmi"))

import pytest  # noqa: E402
from browser import Browser  # noqa: E402, in the folder of the tests

MODELS = [*sorted((ROOT / "examples/models").glob("*.toml")), ROOT / "examples/flying_aircraft.toml", ROOT / "examples/turbine/nrel_5mw.toml"]
STOP_S = {"nrel_5mw": 2.0}
MAXIMUM_CALLS, MAXIMUM_TRIANGLES, MINIMUM_PER_S = 150, 40_000, 10.0
WIDTH, HEIGHT = 1400, 900
ALL_ON = "document.querySelectorAll('#display input[type=checkbox]').forEach(box => { box.checked = box.id !== 'glass'; }), true"
# Times in ms of the given number of pictures, each at another time; reading a pixel waits until the picture is drawn.
PAINT = """(pictures => {
  const gl = renderer.getContext(), pixel = new Uint8Array(4), times = [];
  for (let i = 0; i < pictures + 2; i++) {
    const begin = performance.now();
    main.goTo((i + 1) * main.last / (pictures + 3));
    show();
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
    if (i > 1) times.push(performance.now() - begin);
  }
  return { times, calls: renderer.info.render.calls, triangles: renderer.info.render.triangles };
})"""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--foldwing", type=Path, required=True, help="the command")
    parser.add_argument("--pictures", type=int, default=24, help="pictures of each model")
    arguments = parser.parse_args()
    failed = []
    print(f"{WIDTH} × {HEIGHT} pixels, software WebGL, {os.cpu_count()} processors, load {os.getloadavg()[0]:.1f}\n")
    print("| model | page, MB | draw calls | triangles | as it opens: least, median, ms | pictures/s, target ≥ 10 | everything on: least, median, ms |")
    print("|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder, Browser() as browser:
        for model in MODELS:
            page = Path(folder) / f"{model.stem}.html"
            stop = ["--stop", str(STOP_S[model.stem])] if model.stem in STOP_S else []
            subprocess.run([arguments.foldwing, "simulate", model, "--quiet", "--view", page, *stop], check=True)
            browser.open(page, WIDTH, HEIGHT)
            opens = browser.value(f"{PAINT}({arguments.pictures})")
            browser.value(ALL_ON)
            full = browser.value(f"{PAINT}({arguments.pictures})")
            least, median = (of(opens["times"]) for of in (min, statistics.median))
            words = ", ".join(f"{of(full['times']):.0f}" for of in (min, statistics.median))
            print(f"| `{model.stem}` | {page.stat().st_size / 1e6:.1f} | {full['calls']} | {full['triangles']} | {least:.0f}, {median:.0f} "
                  f"| {1e3 / least:.0f}{'' if 1e3 / least >= MINIMUM_PER_S else ' (**missed**)'} | {words} |", flush=True)
            asked = {url for url in browser.requests() if not url.startswith("data:")} - {page.resolve().as_uri()}
            for wrong, what in ((full["calls"] > MAXIMUM_CALLS, f"more than {MAXIMUM_CALLS} draw calls"),
                                (full["triangles"] > MAXIMUM_TRIANGLES, f"more than {MAXIMUM_TRIANGLES} triangles"),
                                (bool(browser.complaints()), "the page writes to the console"),
                                (bool(asked), f"the page asks for {asked}")):
                failed += [f"{model.stem}: {what}"] if wrong else []
            page.unlink()
    if failed:
        raise SystemExit("\n".join(failed))


if __name__ == "__main__":
    try:
        main()
    except pytest.skip.Exception as reason:
        print(f"no painting times: {reason}")
