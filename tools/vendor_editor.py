"""Renews the text editor of the documentation's pages that run a model (`make live-site`): CodeMirror 6.

Fetches the exact versions below from the npm registry into a temporary folder, bundles the parts used by the pages (esbuild, also at an
exact version), and writes the bundle with its licences to `crates/web/page/vendor`. Needs node, npm and a network; building the pages
needs none of them, because the output is committed. The same versions give the same bytes: `--check` fails if the committed files
differ.
"""

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
TARGET = ROOT / "crates/web/page/vendor"
ESBUILD = "0.28.2"
# direct and transitive packages, all at exact versions; all are under the MIT licence
PACKAGES = {
    "@codemirror/state": "6.7.6", "@codemirror/view": "6.43.15", "@codemirror/commands": "6.11.1", "@codemirror/language": "6.13.1",
    "@codemirror/lint": "6.9.8", "@codemirror/legacy-modes": "6.5.5", "@codemirror/streamparser": "6.0.0", "@codemirror/autocomplete": "6.20.4", "@lezer/common": "1.5.5",
    "@lezer/highlight": "1.2.5", "@lezer/lr": "1.4.12", "@marijn/find-cluster-break": "1.0.4", "crelt": "1.0.7", "style-mod": "4.1.5",
    "w3c-keyname": "2.2.8",
}

# The parts used by the pages.
ENTRY = """
export { EditorState } from '@codemirror/state';
export { EditorView, keymap, lineNumbers, highlightActiveLine, drawSelection } from '@codemirror/view';
export { defaultKeymap, history, historyKeymap, indentWithTab } from '@codemirror/commands';
export { StreamLanguage, HighlightStyle, syntaxHighlighting, bracketMatching } from '@codemirror/language';
export { autocompletion, completionKeymap, startCompletion, acceptCompletion } from '@codemirror/autocomplete';
export { setDiagnostics, lintGutter, lintKeymap } from '@codemirror/lint';
export { tags } from '@lezer/highlight';
export { toml } from '@codemirror/legacy-modes/mode/toml';
"""


def run(*command, folder):
    """Runs a command that must succeed."""
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{' '.join(map(str, command))}: {done.stderr.strip()}")


def made():
    """Name and content of every file."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        (folder / "package.json").write_text("{}")
        packages = [f"{name}@{version}" for name, version in PACKAGES.items()]
        run("npm", "install", "--no-audit", "--no-fund", *packages, f"esbuild@{ESBUILD}", folder=folder)
        (folder / "entry.js").write_text(ENTRY)
        run("npx", "esbuild", "entry.js", "--bundle", "--minify", "--format=iife", "--global-name=CodeMirror", "--target=es2020",
            "--legal-comments=none", "--charset=utf8", "--outfile=codemirror.js", folder=folder)
        bundle = (folder / "codemirror.js").read_text(encoding="utf-8").replace("</script", "<\\/script").replace("{{", "{ {")
        licences = {name: (folder / "node_modules" / name / "LICENSE").read_text(encoding="utf-8").strip() for name in PACKAGES}
        texts = {}
        for name, licence in licences.items():
            texts.setdefault(licence, []).append(f"{name} {PACKAGES[name]}")
        notice = "\n\n".join(", ".join(names) + "\n" + licence for licence, names in texts.items())
        yield "codemirror.js", f"/*! {notice}\n*/\n{bundle}"
        yield "codemirror.LICENSE.txt", notice + "\n"
        yield "versions.txt", "".join(f"{name} {version}: MIT\n" for name, version in PACKAGES.items())


def main():
    """Runs the command."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="write nothing; fail if a file is not what the packages give")
    arguments = parser.parse_args()
    for name, text in made():
        file = TARGET / name
        if not arguments.check:
            TARGET.mkdir(parents=True, exist_ok=True)
            file.write_text(text, encoding="utf-8", newline="\n")
        elif not file.exists() or file.read_text(encoding="utf-8") != text:
            sys.exit(f"{file.relative_to(ROOT)} is not what the packages give; tools/vendor_editor.py renews it")


if __name__ == "__main__":
    main()
