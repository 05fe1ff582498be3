"""Counts of the source tree at an earlier commit and now, as a table: size, circular imports, largest types, literals for numbers of strains.

    studies/structure.py [--before COMMIT] [--table docs/tables/structure.md]

Code under `#[cfg(test)]`, files of tests, comments and string literals are not counted, except in the rows on lines and files.
"""

import argparse
import io
import re
import statistics
import subprocess
import sys
import tarfile
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tools"))
import circles  # noqa: E402, a module of the tools

BEFORE = "45f5929"
TYPES = ("System", "Plant", "Study", "Equations", "State")
PARTS = r"(state|equations|air|scratch|outputs|machine)"
HEAD = """# Structure of the sources

Counts of `crates` at the commit {before} and at {after}, by `python studies/structure.py --table docs/tables/structure.md`. Code of tests, comments and string
literals are not counted, except in the first two rows. Circular imports: `tools/circles.py`. Methods include those of all `impl` blocks of a type; a function has
the lines from `fn` to its closing brace.

"""


def block_end(text, start):
    """Position after the brace that closes the first one at or behind `start`; `None` if a semicolon comes first."""
    opening, nested = None, 0
    for letter in re.compile(r"[()\[\]{;]").finditer(text, start):
        nested += (letter[0] in "([") - (letter[0] in ")]")
        if nested == 0 and letter[0] in "{;":
            opening = letter
            break
    depth = 0
    for brace in re.compile(r"[{}]").finditer(text, opening.start()):
        depth += 1 if brace[0] == "{" else -1
        if depth == 0:
            return brace.end()
    return None


def functions(text):
    """Lines of every function with a body."""
    ends = ((found.start(), block_end(text, found.end())) for found in re.finditer(r"\bfn\s+\w+", text))
    return [text.count("\n", start, end) + 1 for start, end in ends if end]


def methods(texts, name):
    """Number of functions in all `impl` blocks of a type, and number of files with such a block."""
    count = files = 0
    for text in texts:
        own = 0
        for found in re.finditer(rf"^impl(?:<[^>]*>)?\s+(?:\w+(?:::\w+)*\s+for\s+)?{name}\b[^{{;]*", text, re.MULTILINE):
            end = block_end(text, found.start())
            own += len(re.findall(r"\bfn\s+\w+", text[found.start() : end])) if end else 0
        count, files = count + own, files + (own > 0)
    return count, files


def fields(texts, name):
    """Number of fields of a struct of the engine; 0 if it has none."""
    for text in texts:
        found = re.search(rf"\bstruct {name}\b[^;{{(]*{{", text)
        if not found:
            continue
        depth, flat = 0, ""
        for letter in text[found.end() : block_end(text, found.start()) - 1]:
            depth -= letter in ")]}>"
            flat += letter if depth == 0 else ""
            depth += letter in "([{<"
        return len(re.findall(r"\b\w+\s*:(?!:)", flat.replace("::", "")))
    return 0


def counts(root):
    """Rows of the table for one tree, by their names."""
    sources = sorted((root / "crates").glob("*/src"))
    crates = {source.parent.name: circles.Crate(source) for source in sources}
    files = [path for source in sources for path in source.rglob("*.rs")]
    lines = [path.read_text(encoding="utf-8").count("\n") for path in files]
    found = {name: [len(circle) for circle in crate.circles()] for name, crate in crates.items()}
    sizes = [size for each in found.values() for size in each]
    code = [text for crate in crates.values() for text in crate.code.values()]
    engine = crates["engine"]
    texts = list(engine.code.values())
    above = [text for module, text in engine.code.items() if module[:1] in (("study",), ("run",))]
    bodies = functions("\n".join(code))
    rows = {
        "crates": str(len(sources)),
        "files; lines": f"{len(files)}; {sum(lines)}",
        "files above 400 lines; above 490; largest": f"{sum(n > 400 for n in lines)}; {sum(n > 490 for n in lines)}; {max(lines)}",
        "functions; median of their lines": f"{len(bodies)}; {statistics.median(bodies):g}",
        "functions above 60 lines; above 100": f"{sum(n > 60 for n in bodies)}; {sum(n > 100 for n in bodies)}",
        "circles of files; files in them; largest": f"{len(sizes)}; {sum(sizes)}; {max(sizes, default=0)}",
        "largest circle of each crate": ", ".join(f"{name} {max(each)}" for name, each in found.items() if each),
        "folders with more than 15 files": str(sum(len(list(folder.glob("*.rs"))) > 15 for source in sources for folder in [source, *source.rglob("*")] if folder.is_dir())),
    }
    for name in TYPES:
        count, blocks = methods(texts, name)
        rows[f"`{name}`: methods; files with them; fields"] = f"{count}; {blocks}; {fields(texts, name)}"
    rows["accesses to `x.system.…` from `study` and `run`"] = str(sum(len(re.findall(rf"\bsystem\s*\.{PARTS}\b", text)) for text in above))
    rows["`Vector4`, `Matrix4`, `[f64; 4]`, `[_; 4]` in the engine"] = str(sum(len(re.findall(r"\bVector4\b|\bMatrix4\b|; 4\]", text)) for text in texts))
    rows["`unreachable!` in the engine"] = str(sum(len(re.findall(r"\bunreachable!", text)) for text in texts))
    return rows


def tree_of(commit, folder):
    """Writes the crates of a commit into a folder."""
    archive = subprocess.run(["git", "archive", commit, "crates"], cwd=ROOT, capture_output=True, check=True).stdout
    with tarfile.open(fileobj=io.BytesIO(archive)) as files:
        files.extractall(folder)
    return Path(folder)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--before", default=BEFORE, help=f"the earlier commit [default: {BEFORE}]")
    parser.add_argument("--table", type=Path, help="page to write; without it the table is printed")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        before = counts(tree_of(options.before, folder))
    after = counts(ROOT)
    date = subprocess.run(["git", "log", "-1", "--format=%cs"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.strip()
    text = HEAD.format(before=options.before, after=date)
    text += f"| | {options.before} | {date} |\n|---|---|---|\n"
    text += "".join(f"| {name} | {before[name]} | {value} |\n" for name, value in after.items())
    if options.table:
        options.table.write_text(text, encoding="utf-8")
    else:
        print(text)


if __name__ == "__main__":
    main()
