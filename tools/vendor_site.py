"""Renews KaTeX, which typesets the equations of the documentation site (`make site`).

Fetches the exact version below from the npm registry into a temporary folder and writes script, style sheet and licence
into `tools/site/vendor`. The fonts are embedded in the style sheet, because browsers may not load fonts for a page that
was opened from the disk; of their three formats only woff2 is kept, which every current browser reads. Needs node, npm and a
network; building the site needs none of them, because the output is committed. The same version gives the same bytes:
`--check` reports whether the committed files are up to date.
"""

import argparse
import base64
import re
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
TARGET = ROOT / "tools/site/vendor"
KATEX = "0.19.1"


def embedded(font):
    """A font as a URL that contains it."""
    return f"url(data:font/woff2;base64,{base64.b64encode(font.read_bytes()).decode()})"


def made():
    """Name and content of every file."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        (folder / "package.json").write_text("{}")
        done = subprocess.run(["npm", "install", "--no-audit", "--no-fund", f"katex@{KATEX}"], cwd=folder, capture_output=True, text=True)
        if done.returncode:
            sys.exit(f"npm install: {done.stderr.strip()}")
        package = folder / "node_modules/katex"
        licence = (package / "LICENSE").read_text(encoding="utf-8")
        notice = f"/*! katex {KATEX}, https://www.npmjs.com/package/katex\n{licence.strip()}\n*/\n"
        script = (package / "dist/katex.min.js").read_text(encoding="utf-8")
        style = (package / "dist/katex.min.css").read_text(encoding="utf-8")
        style = re.sub(r',url\([^)]*\.(?:woff|ttf)\) format\("[a-z]+"\)', "", style)
        style = re.sub(r"url\((fonts/[^)]*)\)", lambda font: embedded(package / "dist" / font[1]), style)
        yield "katex.min.js", notice + script.strip() + "\n"
        yield "katex.min.css", notice + style.strip() + "\n"
        yield "katex.LICENSE.txt", licence
        yield "versions.txt", f"katex {KATEX}: MIT\n"


def main():
    """Runs the command."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="write nothing; fail if a file is not what the package gives")
    arguments = parser.parse_args()
    for name, content in made():
        file = TARGET / name
        if not arguments.check:
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(content, encoding="utf-8", newline="\n")
        elif not file.exists() or file.read_text(encoding="utf-8") != content:
            sys.exit(f"{file.relative_to(ROOT)} is not what the package gives; tools/vendor_site.py renews it")


if __name__ == "__main__":
    main()
