"""Takes a picture of the page that plays a run: docs/pictures/viewer.png, the wing in the tunnel with its wake and its loads.

Usage: shoot_viewer.py --foldwing target/release/foldwing --output docs/pictures; needs Chromium.
"""

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests/fmi"))

import pytest  # noqa: E402
from browser import Browser  # noqa: E402, in the folder of the tests

MODEL = ROOT / "examples/models/folding_wing_in_tunnel.toml"
TIME_S = 0.13


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--foldwing", type=Path, required=True)
    parser.add_argument("--output", type=Path, required=True)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder, Browser() as browser:
        page = Path(folder) / "tunnel.html"
        subprocess.run([arguments.foldwing, "simulate", MODEL, "--quiet", "--view", page], check=True)
        browser.open(page, 1400, 860)
        browser.value(f"seek(main.positionAt({TIME_S})), turn(-0.4, 0.05), zoom(1.25), get('along').open = true, true")
        browser.call("Runtime.evaluate", awaitPromise=True,
                     expression="new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
        browser.screenshot(arguments.output / "viewer.png")


if __name__ == "__main__":
    try:
        main()
    except pytest.skip.Exception as reason:
        print(f"no picture of the page: {reason}")
