"""Pictures of the models in the documentation's gallery, by `foldwing render`: the end of each run.

    picture_models.py --foldwing target/release/foldwing --output docs/pictures/models
"""

import argparse
import json
import shutil
import subprocess
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


def main():
    """Runs the command."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--foldwing", type=Path, required=True, help="the command")
    parser.add_argument("--output", type=Path, required=True, help="folder of the pictures")
    arguments = parser.parse_args()
    arguments.output.mkdir(parents=True, exist_ok=True)
    for row in json.loads((ROOT / "crates/web/page/gallery.json").read_text(encoding="utf-8")):
        with tempfile.TemporaryDirectory() as place:
            subprocess.run([arguments.foldwing, "render", ROOT / row["model"], "--video", Path(place) / "a.png", "--size", "720x420", "--fps", "1",
                            "--quiet"], check=True)
            shutil.copy(max(Path(place).glob("*.png")), arguments.output / f"{row['name']}.png")


if __name__ == "__main__":
    main()
