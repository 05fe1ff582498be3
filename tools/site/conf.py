"""Sphinx's configuration of the documentation site; `tools/build_site.py` (`make site`) runs it over a copy of the documents."""

import html
import shutil
from pathlib import Path

HERE = Path(__file__).resolve().parent

project = "Foldwing"
copyright = "The Foldwing developers, MIT or Apache-2.0"  # noqa: A001, Sphinx's name
extensions = ["myst_parser"]
root_doc = "index"

myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 4
# `$` next to a digit is a currency or shell sign, as on GitHub
myst_dmath_allow_digits = False
default_role = "code"
# code blocks in the documents are for readers; nothing is executed
highlight_language = "none"
suppress_warnings = ["misc.highlighting_failure", "myst.header"]

html_theme = "furo"
html_title = "Foldwing"
html_css_files = ["foldwing.css"]
html_static_path = [str(HERE / "foldwing.css"), str(HERE / "frames.js")]
html_copy_source = False
html_show_sphinx = False
html_use_index = False
# summaries of search results need requests, which browsers block for pages opened from the disk; the results themselves do not
html_show_search_summary = False


def inline(translator, node):
    """Writes an equation in a line of text: its source, which `equations.js` typesets."""
    translator.body.append(f'<span class="equation">{html.escape(node.astext())}</span>')


def block(translator, node):
    """Writes a displayed equation."""
    translator.body.append(f'<div class="equation">{html.escape(node.astext())}</div>')


def visit_inline(translator, node):
    """Sphinx requires an exception to skip the children of a node."""
    from docutils.nodes import SkipNode

    inline(translator, node)
    raise SkipNode


def visit_block(translator, node):
    """As for inline equations."""
    from docutils.nodes import SkipNode

    block(translator, node)
    raise SkipNode


def with_equations(app, page, template, context, doctree):
    """Loads KaTeX only in pages with equations."""
    from docutils import nodes

    if doctree is not None and any(doctree.findall(lambda node: isinstance(node, (nodes.math, nodes.math_block)))):
        app.add_css_file("katex/katex.min.css")
        app.add_js_file("katex/katex.min.js", defer="defer")
        app.add_js_file("equations.js", defer="defer")


def copy_katex(app, error):
    """Copies KaTeX with its licence next to the files of Sphinx and the theme."""
    if error is None:
        shutil.copytree(HERE / "vendor", Path(app.outdir) / "_static/katex", dirs_exist_ok=True)
        shutil.copy(HERE / "equations.js", Path(app.outdir) / "_static")


def setup(app):
    """Called by Sphinx."""
    app.add_html_math_renderer("katex", inline_renderers=(visit_inline, None), block_renderers=(visit_block, None))
    app.connect("html-page-context", with_equations)
    app.connect("build-finished", copy_katex)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


html_math_renderer = "katex"
