"""Builds the documentation site from the Markdown of the repository: `make site`, into target/site.

    build_site.py --output target/site [--work target/site-source] [--rustdoc target/doc] [--live target/live]

The pages are those of `docs/` with README, CHANGELOG, CONTRIBUTING and SECURITY; a page that `NAVIGATION` does not name is added to the
section of its folder. The site also has a gallery of the pictures, a page for each model of `crates/web/page/gallery.json`, which runs
there if `--live` names the output of `make live-site`, the Python API from the sources of the package if it exists, and the Rust API if
`cargo doc` has written it. Sphinx, MyST and the theme Furo generate the HTML, KaTeX typesets the equations; a broken link or a page that
belongs to no section is an error. The result loads nothing from a network and can be opened from the disk.
"""

import argparse
import ast
import inspect
import json
import os
import posixpath
import re
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
TOP = ["CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md", "LICENSE-MIT", "LICENSE-APACHE", "studies/README.md"]
PACKAGE = ROOT / "python/foldwing"

# Sections of the navigation in the order of learning, with their pages in order; `*` represents the pages that are not named before.
NAVIGATION = {
    "Install": ["docs/guide/install"],
    "Tutorial": ["docs/guide/tutorial", "docs/guide/first_scripts"],
    "How to": ["docs/guide/README", "docs/guide/sections", "docs/guide/control_surfaces", "docs/guide/flutter", "docs/guide/failures", "docs/guide/gradients",
               "docs/guide/turbines", "docs/guide/rotor_air", "docs/guide/package", "docs/guide/python", "docs/guide/simulink", "docs/guide/openmodelica",
               "docs/guide/kinds", "docs/guide/co_simulation", "docs/guide/model_exchange", "docs/PLATFORMS", "docs/guide/upgrade", "docs/guide/*"],
    "Reference": ["docs/MODEL_FILE", "docs/COMMAND_LINE", "docs/guide/commands", "docs/guide/variables", "docs/guide/names", "docs/guide/messages",
                  "docs/guide/glossary", "api/python", "api/rust"],
    "Models": ["models", "models/*"],
    "Theory": ["docs/guide/theory", "docs/NOTATION"],
    "What agrees": ["docs/VALIDATION", "docs/validation/papers", "docs/validation/deployment", "docs/validation/tunnel", "docs/validation/*",
                    "docs/BENCHMARKS", "docs/tables/*", "gallery"],
    "Development": ["docs/ARCHITECTURE", "docs/WALKTHROUGH", "docs/tables/structure", "docs/decisions/README", "docs/decisions/*", "docs/*", "studies/README", "CONTRIBUTING", "CHANGELOG",
                    "docs/history/*", "SECURITY"],
}

# Headings of pages without one: in the repository they are parts of other pages.
HEADINGS = {"docs/tables/accuracy": "Figures of the front page"}


def pages(work):
    """Every page of the copy, without its file extension."""
    found = {path.relative_to(work).with_suffix("").as_posix() for kind in ("*.md", "*.rst") for path in work.rglob(kind)}
    return found - {"index"}


def navigation(existing):
    """Title of each section and its pages; every page belongs to exactly one section."""
    left, sections = set(existing), {}
    named = {name for names in NAVIGATION.values() for name in names}
    for title, names in NAVIGATION.items():
        sections[title] = []
        for name in names:
            folder, last = posixpath.split(name)
            here = sorted(page for page in left if posixpath.dirname(page) == folder and page not in named) if last == "*" else [name]
            sections[title] += [page for page in here if page in left]
            left -= set(here)
    if left:
        sys.exit(f"build_site: no place in the navigation for {', '.join(sorted(left))}: NAVIGATION in tools/build_site.py")
    return sections


def trees(sections):
    """The navigation as Sphinx toctrees."""
    for title, names in sections.items():
        yield "\n".join(["```{toctree}", ":hidden:", ":maxdepth: 1", f":caption: {title}", "", *(f"/{name}" for name in names), "```", ""])


def linked_to(page, text):
    """Text in which links to the README of the repository lead to the first page of the site."""
    to_root = posixpath.relpath("README.md", posixpath.dirname(page) or ".")
    return text.replace(f"]({to_root}", f"]({to_root[:-len('README.md')]}index.md") if page != "docs/guide/README.md" else text


def without_sources(text):
    """Text in which links to source files of the repository, which the site does not have, are their paths."""
    return re.sub(r"\[([^\]`]+)\]\((?:\.\./)*(?:crates|python|src|tests)/[^)]+\)", r"`\1`", text)


def titled(text, folder):
    """Text whose links show the title of their target page instead of its file name."""
    def shown(link):
        path, anchor = link[2], link[3] or ""
        page = folder / path
        if not page.is_file():
            return link[0]
        heading = next((line[2:] for line in page.read_text(encoding="utf-8").splitlines() if line.startswith("# ")), link[1])
        return f"[{heading.replace('[', '').replace(']', '')}]({path}{anchor})"

    return re.sub(r"\[`?([\w./-]+\.md)`?\]\(([^)#:]+\.md)(#[^)]*)?\)", shown, text)


def copy_documents(work):
    """Copies the documents, and the files to which they link, to their locations."""
    shutil.copytree(ROOT / "docs", work / "docs")
    for name in TOP:
        (work / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, work / name)
    for path in work.rglob("*.md"):
        name, text = path.relative_to(work).as_posix(), path.read_text(encoding="utf-8")
        heading = HEADINGS.get(name[:-len(".md")])
        text = linked_to(name, titled(without_sources(text), (ROOT / name).parent))
        path.write_text((f"# {heading}\n\n" if heading else "") + text, encoding="utf-8")


def gallery(work):
    """A page of all pictures, each with the caption under which a document shows it and a link to this document."""
    shown = {}
    for path in sorted([work / "docs/VALIDATION.md", *work.glob("docs/**/*.md")]) + [ROOT / "README.md"]:
        base = path.parent
        for words, target in re.findall(r"!\[([^\]]*)\]\(([^)]+\.png)\)", path.read_text(encoding="utf-8")):
            name = Path(os.path.normpath(base / target)).name
            page = "index.md" if path == ROOT / "README.md" else path.relative_to(work).as_posix()
            shown.setdefault(name, (words, page))
    parts = ["# Gallery", "", "Every picture of the documents; its words lead to the page that explains it."]
    for picture in sorted((work / "docs/pictures").glob("*.png")):
        words, page = shown.get(picture.name, (picture.stem.replace("_", " "), None))
        caption = f"[{words[:1].upper() + words[1:]}]({page})" if page else words[:1].upper() + words[1:]
        parts += ["", f"![{words}](docs/pictures/{picture.name})", "", caption + "."]
    (work / "gallery.md").write_text("\n".join(parts) + "\n", encoding="utf-8")


def model_pages(work, live):
    """A page for each model of the gallery, and a list of them: the model runs next to its text if the engine is available, otherwise a
    picture is shown."""
    rows = json.loads((ROOT / "crates/web/page/gallery.json").read_text(encoding="utf-8"))
    how = ("Each page has the model in an editor with the machine beside it, which runs as one types." if live else
           "This copy of the site has pictures of them; `make live-site` before `make site` lets them run in their pages.")
    parts = ["# Models", "", f"Models that come with Foldwing, most of them short. {how}", ""]
    (work / "models").mkdir()
    for row in rows:
        name, text = row["name"], (ROOT / row["model"]).read_text(encoding="utf-8")
        heading = name.replace("_", " ")
        heading = heading[:1].upper() + heading[1:]
        told = re.search(r'^description *= *"(.*)"$', text, flags=re.MULTILINE)
        words = told[1].replace("\\", "") if told else heading
        picture = f"docs/pictures/models/{name}.png"
        page = ["---", "hide-toc: true", "---", "", f"# {heading}", "", words, ""]
        if live:
            page += ["```{raw} html", f'<iframe class="live-model" src="../live/index.html?{name}" title="{heading}, with its model file" loading="lazy"></iframe>',
                     '<script src="../_static/frames.js"></script>', f'<p><a href="../live/index.html?{name}">Open this in a page of its own</a></p>', "```"]
        else:
            page += [f"![{heading} at the end of its run](/{picture})", "",
                     f"`foldwing view {row['model']}` shows the run; [the page of all models](/models) tells how it runs here."]
        page += ["", f"## {row['model']}", "", "```toml", text.rstrip(), "```", ""]
        (work / f"models/{name}.md").write_text("\n".join(page), encoding="utf-8")
        parts += [f"## [{heading}](models/{name})", "", f"[![{heading}]({picture})](models/{name})", "", words, ""]
    (work / "models.md").write_text("\n".join(parts), encoding="utf-8")


def rust_page(work, rustdoc):
    """A page that leads to the output of `cargo doc`, or explains how to generate it."""
    text = "# Rust API\n\n"
    if rustdoc:
        crates = sorted(index.parent.name for index in rustdoc.glob("foldwing*/index.html"))
        rows = "".join(f'<li><a href="../rust/{crate}/index.html"><code>{crate}</code></a></li>\n' for crate in crates)
        text += f"Written by `cargo doc` from the sources.\n\n<ul>\n{rows}</ul>\n"
    else:
        text += "Not in this copy of the site: run `cargo doc --no-deps --workspace`, then `make site`.\n"
    (work / "api/rust.md").write_text(text, encoding="utf-8")


def described(node, indent, owner=""):
    """Directives of Sphinx's Python domain for a function or class with its documented public members."""
    from sphinx.ext.napoleon import Config, GoogleDocstring

    pad = " " * indent
    words = ast.get_docstring(node) or ""
    words = str(GoogleDocstring(inspect.cleandoc(words), Config(napoleon_use_rtype=False)))
    body = "\n".join(f"{pad}   {line}".rstrip() for line in words.splitlines())
    if isinstance(node, ast.ClassDef):
        start = next((item for item in node.body if isinstance(item, ast.FunctionDef) and item.name == "__init__"), None)
        yield f"{pad}.. py:class:: {node.name}({ast.unparse(without_self(start.args)) if start else ''})\n\n{body}\n"
        for item in node.body:
            if isinstance(item, ast.FunctionDef) and ast.get_docstring(item) and (item.name[0] != "_" or item.name.startswith("__get")):
                yield from described(item, indent + 3, node.name)
        return
    marks = {mark.id for mark in node.decorator_list if isinstance(mark, ast.Name)}
    if "property" in marks:
        kind = f":type: {ast.unparse(node.returns)}" if node.returns else ""
        yield f"{pad}.. py:property:: {node.name}\n{pad}   {kind}\n\n{body}\n"
        return
    static = marks & {"staticmethod", "classmethod"}
    arguments = node.args if not owner or "staticmethod" in marks else without_self(node.args)
    result = f" -> {ast.unparse(node.returns)}" if node.returns else ""
    flag = f"{pad}   :{sorted(static)[0]}:\n" if static else ""
    yield f"{pad}.. py:{'method' if owner else 'function'}:: {node.name}({ast.unparse(arguments)}){result}\n{flag}\n{body}\n"


def without_self(arguments):
    """Arguments except the first."""
    rest = ast.arguments(**{field: getattr(arguments, field) for field in arguments._fields})
    first = "posonlyargs" if rest.posonlyargs else "args"
    setattr(rest, first, getattr(rest, first)[1:])
    return rest


def python_page(work):
    """The Python API: the names in `__all__` of the package, read from its sources and stubs without imports."""
    heading = "Python API\n==========\n\n"
    if not (PACKAGE / "__init__.py").exists():
        (work / "api/python.rst").write_text(heading + "This version has no Python package.\n", encoding="utf-8")
        return
    package = ast.parse((PACKAGE / "__init__.py").read_text(encoding="utf-8"))
    public = next(ast.literal_eval(node.value) for node in package.body if isinstance(node, ast.Assign)
                  and getattr(node.targets[0], "id", "") == "__all__")
    found = {}
    for path in sorted(PACKAGE.rglob("*.py")) + sorted(PACKAGE.rglob("*.pyi")):
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            if isinstance(node, (ast.ClassDef, ast.FunctionDef)) and ast.get_docstring(node):
                found.setdefault(node.name, node)
    intro = str(ast.get_docstring(package) or "")
    parts = [heading + intro, ".. py:currentmodule:: foldwing\n"]
    for name in sorted(public, key=lambda name: (name[0].isupper(), name)):
        parts += described(found[name], 0) if name in found else []
    (work / "api/python.rst").write_text("\n\n".join(parts) + "\n", encoding="utf-8")


def main():
    """Runs the command."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--output", type=Path, required=True, help="folder of the site; what it holds is replaced")
    parser.add_argument("--work", type=Path, help="folder of the copied documents; default: beside the output")
    parser.add_argument("--rustdoc", type=Path, help="folder that `cargo doc` has written; copied into the site if it exists")
    parser.add_argument("--live", type=Path, help="folder that `make live-site` has written; copied into the site if it exists")
    arguments = parser.parse_args()
    output = arguments.output.resolve()
    live = arguments.live if arguments.live and (arguments.live / "engine.js").exists() else None
    work = (arguments.work or output.with_name(output.name + "-source")).resolve()
    rustdoc = arguments.rustdoc if arguments.rustdoc and (arguments.rustdoc / "foldwing/index.html").exists() else None
    for folder in (work, output):
        shutil.rmtree(folder, ignore_errors=True)
    (work / "api").mkdir(parents=True)
    copy_documents(work)
    gallery(work)
    model_pages(work, live)
    python_page(work)
    rust_page(work, rustdoc)
    sections = navigation(pages(work))
    front = titled((ROOT / "README.md").read_text(encoding="utf-8"), ROOT)
    (work / "index.md").write_text(front + "\n" + "\n".join(trees(sections)), encoding="utf-8")
    command = [sys.executable, "-m", "sphinx", "--quiet", "--fail-on-warning", "--keep-going", "-j", "auto", "-b", "html",
               "-c", ROOT / "tools/site", "-d", work / ".doctrees", work, output]
    done = subprocess.run(command)
    if done.returncode:
        sys.exit(done.returncode)
    if rustdoc:
        shutil.copytree(rustdoc, output / "rust")
    if live:
        shutil.copytree(live, output / "live", ignore=shutil.ignore_patterns("*.wasm"))
    print(f"open {os.path.relpath(output / 'index.html')}")


if __name__ == "__main__":
    main()
