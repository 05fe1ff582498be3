"""Lists circular imports between the files of each crate, and the imports to cut.

    circles.py [CRATE ...] [--cuts]

A circle is a strongly connected component of two or more files in the graph of imports between the files of one crate. The program prints
a table of all crates, and for each crate that is named the files of its circles; `--cuts` adds imports whose removal opens each circle, the
most effective first.

Imports are all paths in `use` and in code whose first part is `crate`, `self`, `super` or a module declared in the same file.
Comments, string literals and everything under `#[cfg(test)]` are ignored. A name that another file itself imports by `use` is followed to the
file that defines the item: an import through `mod.rs` is an import of that file, and a re-export (`pub use`) is an import only if the file
also uses the name itself. A path into the `mod.rs` of the same folder is an import of `mod.rs` if the item is defined there.
"""

import argparse
import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
NOT_CODE = re.compile(
    r'//[^\n]*|/\*.*?\*/|\bb?r(#*)".*?"\1|b?"(?:\\.|[^"\\])*"|b?\'(?:\\.[^\']*|[^\\\'])\'', re.DOTALL
)
VISIBILITY = re.compile(r"pub\(in [^)]*\)")
TEST = re.compile(r"#\[cfg\((?:test|all\(test\b[^\]]*)\)\]\s*(?:#\[[^\]]*\]\s*)*")
USE = re.compile(r"(?<!\w)(pub(?:\([^)]*\))?\s+)?use\s+([^;]+);")
MODULE = re.compile(r"(?<!\w)mod\s+(\w+)\s*;")
PATH = re.compile(r"(?<![\w:.])(?:r#)?[a-z_]\w*(?:\s*::\s*\w+)+")


def code_of(text):
    """The text without comments, string literals and items for tests, and the names of the modules that are declared for tests."""
    text = NOT_CODE.sub(lambda found: " " if found[0].startswith("/") else '""', text)
    text = VISIBILITY.sub("pub", text)
    tests = set()
    while found := TEST.search(text):
        end = end_of_item(text, found.end())
        tests.update(MODULE.findall(text[found.end() : end]))
        text = text[: found.start()] + text[end:]
    return text, tests


def end_of_item(text, start):
    """Position after the item at `start`: its semicolon or comma, or its closing brace."""
    depth = 0
    for at in range(start, len(text)):
        if text[at] in "([{":
            depth += 1
        elif text[at] in ")]}":
            depth -= 1
            if depth < 0:
                return at
            if depth == 0 and text[at] == "}" and not text[start:at].lstrip().startswith(("use ", "pub use ")):
                return at + 1
        elif depth == 0 and text[at] in ";,":
            return at + 1
    return len(text)


def expand(tree):
    """Paths of a `use` tree: (segments, name under which it is known here)."""
    tree = tree.strip()
    brace = tree.find("{")
    if brace < 0:
        path, _, name = tree.partition(" as ")
        segments = [part.strip().removeprefix("r#") for part in path.split("::")]
        if segments[-1] == "self":
            segments.pop()
        return [(segments, name.strip() or segments[-1])] if segments else []
    head = [part.strip() for part in tree[:brace].split("::") if part.strip()]
    parts, depth, begin = [], 0, brace + 1
    for at in range(brace + 1, len(tree)):
        if tree[at] == "{":
            depth += 1
        elif (tree[at] == "," and depth == 0) or (tree[at] == "}" and depth == 0):
            parts.append(tree[begin:at])
            begin = at + 1
        elif tree[at] == "}":
            depth -= 1
    return [
        (head + (segments if segments != [""] else []), name if segments else head[-1])
        for part in parts
        if part.strip()
        for segments, name in (expand(part) if part.strip() != "self" else [([], "")])
    ]


class Crate:
    """The files of a crate and their imports, each file named by its module path."""

    def __init__(self, source):
        self.files, self.code = {}, {}
        tests = set()
        for path in sorted(source.rglob("*.rs")):
            parts = path.relative_to(source).with_suffix("").parts
            module = parts[:-1] if parts[-1] in ("mod", "lib", "main") else parts
            text, declared = code_of(path.read_text(encoding="utf-8"))
            tests.update((*module, name) for name in declared)
            self.files[module] = path
            self.code[module] = text
        for module in list(self.files):
            if module[-1:] == ("tests",) or any(module[: len(test)] == test for test in tests):
                del self.files[module], self.code[module]
        self.names = {
            module: {name: segments for _, tree in USE.findall(self.code[module]) for segments, name in expand(tree)}
            for module in self.files
        }
        self.imports = {module: self.imported(module) - {module} for module in self.files}

    def imported(self, module):
        """Files that the file of `module` imports."""
        text = self.code[module]
        body = USE.sub("", text)
        paths = [
            segments
            for public, tree in USE.findall(text)
            for segments, name in expand(tree)
            if not public or re.search(rf"\b{name}\b", body)
        ]
        paths += [re.sub(r"\s|r#", "", path).split("::") for path in PATH.findall(body)]
        return {file for path in paths if (file := self.file_of(module, path)) is not None}

    def file_of(self, module, path, seen=()):
        """The file of the item with a path as written in the file of `module`, None if it is of another crate."""
        path, base = list(path), module
        if path[0] == "crate":
            base, path = (), path[1:]
        elif path[0] == "self":
            path = path[1:]
        elif path[0] == "super":
            while path and path[0] == "super":
                base, path = base[:-1], path[1:]
        elif (*module, path[0]) not in self.files:
            return None
        return self.follow(base, path, seen)

    def follow(self, base, path, seen):
        """The file of the item `path` of the module `base`, through modules and re-exports."""
        while path and (*base, path[0]) in self.files:
            base, path = (*base, path[0]), path[1:]
        if base not in self.files:
            return None
        target = self.names[base].get(path[0]) if path else None
        if target is None or (base, path[0]) in seen:
            return base
        file = self.file_of(base, [*target, *path[1:]], (*seen, (base, path[0])))
        return base if file is None else file

    def circles(self):
        """Circles, the largest first, each as a sorted list of module paths."""
        return circles_of(self.imports)


def circles_of(graph):
    """Strongly connected components of two files or more of a graph, the largest first."""
    reach = {}
    for start in graph:
        found, todo = set(), [start]
        while todo:
            for other in graph[todo.pop()]:
                if other not in found:
                    found.add(other)
                    todo.append(other)
        reach[start] = found
    circles = {tuple(sorted(b for b in reach[a] if a in reach[b])) for a in graph if a in reach[a]}
    return sorted((list(circle) for circle in circles if len(circle) > 1), key=lambda circle: (-len(circle), circle))


def cuts(graph, circle):
    """Imports whose removal opens a circle: (from, to, number of files still in a circle), each the best choice after those before it."""
    graph = {file: graph[file] & set(circle) for file in circle}
    removed = []
    while left := circles_of(graph):
        best = None
        for part in left:
            for a in part:
                for b in sorted(graph[a] & set(part)):
                    graph[a].remove(b)
                    size = sum(map(len, circles_of(graph)))
                    graph[a].add(b)
                    if best is None or size < best[2]:
                        best = (a, b, size)
        graph[best[0]].remove(best[1])
        removed.append(best)
    return removed


def crates():
    """Name and circles of every crate."""
    return {source.parent.name: Crate(source) for source in sorted(ROOT.glob("crates/*/src"))}


def name(module):
    """A module path as text."""
    return "::".join(module) or "lib"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("crate", nargs="*", help="crates of which the circles are listed")
    parser.add_argument("--cuts", action="store_true", help="also imports of which the removal opens each circle")
    options = parser.parse_args()
    found = crates()
    print(f"{'crate':<12}{'files':>6}{'circles':>9}{'in circles':>12}{'largest':>9}")
    for crate, tree in found.items():
        sizes = [len(circle) for circle in tree.circles()]
        print(f"{crate:<12}{len(tree.files):>6}{len(sizes):>9}{sum(sizes):>12}{max(sizes, default=0):>9}")
    for crate in options.crate:
        for circle in found[crate].circles():
            print(f"\n{crate}, {len(circle)} files: " + ", ".join(map(name, circle)))
            for a, b, left in cuts(found[crate].imports, circle) if options.cuts else []:
                print(f"  {name(a)} -> {name(b)}, {left} files left")


if __name__ == "__main__":
    main()
