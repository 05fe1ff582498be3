"""Renews the two JavaScript libraries of the page that `foldwing simulate --view` writes.

Fetches the exact versions below from the npm registry into a temporary folder, bundles only the parts of three.js that
the page uses (esbuild, also at an exact version), and writes them with their licences to the folder `vendor` of the
viewer. Needs node, npm and a network; building Foldwing needs none of them, because the output is committed. The same
versions give the same bytes: `--check` reports whether the committed files are up to date.
"""

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
TARGET = ROOT / "crates/command/src/report/viewer/vendor"
THREE, UPLOT, ESBUILD = "0.187.0", "1.6.32", "0.28.2"

# The parts of three.js used by the page; a test compares the list with the page's scripts.
USED = """
BufferAttribute BufferGeometry CanvasTexture Color ColorManagement ConeGeometry CylinderGeometry DirectionalLight
DoubleSide FrontSide Group HemisphereLight InstancedMesh LineBasicMaterial LineDashedMaterial LinearFilter LineSegments LinearSRGBColorSpace
Matrix4 Mesh MeshBasicMaterial MeshLambertMaterial OrthographicCamera PCFShadowMap PerspectiveCamera PlaneGeometry
Quaternion Raycaster Scene ShadowMaterial SphereGeometry Sprite SpriteMaterial TorusGeometry Vector2 Vector3
WebGLRenderer
""".split()


def run(*command, folder):
    """Runs a command that must succeed."""
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{' '.join(map(str, command))}: {done.stderr.strip()}")


def script_safe(text):
    """A script that neither ends its element nor contains a placeholder of the page; in strings the escapes are equivalent."""
    return text.replace("</script", "<\\/script").replace("{{", "{ {")


def notice(name, version, licence):
    """The licence as a comment above the library, which minifiers keep."""
    return f"/*! {name} {version}, https://www.npmjs.com/package/{name}\n{licence.strip()}\n*/\n"


def made():
    """Name and content of every file."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        (folder / "package.json").write_text("{}")
        run("npm", "install", "--no-audit", "--no-fund", f"three@{THREE}", f"uplot@{UPLOT}", f"esbuild@{ESBUILD}", folder=folder)
        modules = folder / "node_modules"
        (folder / "entry.js").write_text(f"export {{ {', '.join(USED)} }} from 'three';\n")
        run("npx", "esbuild", "entry.js", "--bundle", "--minify", "--format=iife", "--global-name=THREE", "--target=es2020",
            "--legal-comments=none", "--charset=utf8", "--outfile=three.js", folder=folder)
        three = (modules / "three/LICENSE").read_text(encoding="utf-8")
        uplot = (modules / "uplot/LICENSE").read_text(encoding="utf-8")
        plots = (modules / "uplot/dist/uPlot.iife.min.js").read_text(encoding="utf-8")
        yield "three.js", notice("three", THREE, three) + script_safe((folder / "three.js").read_text(encoding="utf-8"))
        yield "uplot.js", notice("uplot", UPLOT, uplot) + script_safe(plots)
        yield "uplot.css", (modules / "uplot/dist/uPlot.min.css").read_text(encoding="utf-8").strip() + "\n"
        yield "three.LICENSE.txt", three
        yield "uplot.LICENSE.txt", uplot
        yield "versions.txt", f"three {THREE}: MIT\nuplot {UPLOT}: MIT\n"


def main():
    """Runs the command."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="write nothing; fail if a file is not what the packages give")
    arguments = parser.parse_args()
    for name, text in made():
        file = TARGET / name
        if not arguments.check:
            TARGET.mkdir(exist_ok=True)
            file.write_text(text, encoding="utf-8", newline="\n")
        elif not file.exists() or file.read_text(encoding="utf-8") != text:
            sys.exit(f"{file.relative_to(ROOT)} is not what the packages give; tools/vendor_viewer.py renews it")


if __name__ == "__main__":
    main()
