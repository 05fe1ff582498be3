"""Phrases of a private dialect that must not return to texts for users, nor to the comments of the sources below: the terms of the field are
in `docs/guide/glossary.md`."""

import ast
import io
import re
import tokenize
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGES = [ROOT / name for name in ("README.md", "CONTRIBUTING.md", "docs/COMMAND_LINE.md", "docs/PLATFORMS.md", "docs/ARCHITECTURE.md", "docs/NOTATION.md")]
PAGES += sorted((ROOT / "docs/guide").glob("*.md"))
# generated from the program; messages.md quotes messages in its first column
GENERATED = {"commands.md", "variables.md"}
PHRASES = [
    r"\b(is|are|was|were|be|been) told\b",
    r"\b(tells?|hears?|asks?) (the|of|what|whether|for|it|its)\b",
    r"\b(says?|said) (so|what|where|how|which|whether|that|why|nothing)\b",
    r"\b(file|message|program|command|page|header|paper|line|model|description|table|text|row|key) says?\b",
    r"\blooks? at\b",
    r"\b(it|machine|wing|code|program|loop|importer|lattice|gauge|command|air) (sees|knows|hears|wants|wants to|asks|feels)\b",
    r"\bknows? nothing\b",
    r"\bspeaks? of\b",
    r"\bwhoever\b|\bwho looks\b",
    r"\blet(s|ting)? go\b",
    r"\bgo(es|ne)? back (to|over)\b",
    r"\bbrings? (it |them |a failure |the failure )?about\b|\bbrought about\b",
    r"\b(comes?|come|brought|bring|brings) to rest\b",
    r"\bstopper(s|ed)?\b",
    r"\bsound (one|wing|blade|until)\b|\bfailing one\b",
    r"\bhangs? on\b|\bhung on\b",
    r"\b(in|on|along|over|half|some) (the|its|a|this) way\b|\bway (of|along|across|round)\b|\bper way\b",
    r"\bin the air of\b|\bin air by\b|\bair of strips\b|\b(has|have|without) the air of\b|\bin that of strips\b|\bair of (a|the) (rotor|lattice|strips)\b",
    r"\btake[sn]? (part|out|from it|its own|it as|them as|one for)\b",
    r"\bgives? (way|up|back|nothing)\b",
    r"\bas it says\b|\bAs the message says\b",
    r"\bnothing (holds|resists|moves|of it|stiffens|pushes|acts)\b",
    r"\bso (many|much|far) (states|rows|steps)\b",
    r"\bthe begin\b|\bat its begin\b",
    r"\b(who|which) brings\b",
    r"\b(dies|died|die) (out|away|on the way)\b|\bmotors? that die\b|\bmotor dies\b",
    r"\bteeth\b",
    r"\brefuse[sd]?\b|\brefusal",
    r"\bmistakes?\b",
    r"\bstrikes? nothing\b",
    r"\bsense (of|in which)\b",
    r"\blag (bending|stiffness|direction)\b|\bflap and lag\b",
    r"\bsection loads?\b",
    r"\bstraight lines between\b",
    r"\bseen from the ground\b|\bas the ground sees\b",
    r"\btext behind\b|\bbehind a bar\b|\bgoes on below\b|\bwithout haste\b|\bof a GIF\b",
    r"\bmotion that every turn repeats\b|\bturns? (that )?repeats?\b",
    r"\bdoubt(s|ed|ful)?\b",
    r"\bground(-fixed)? frame\b",
    r"(?<!sweep )(?<!sweeps )\bover the (wind|rotor) speed\b|\bover the speed of\b",
    r"\bpull(s|ed)? at it\b|\bpresent computer\b|\bdescent steps?\b",
]
# folders of Rust files whose comments are checked, and the phrases forbidden in them in addition to those above
SOURCES = sorted(path for path in (ROOT / "crates/engine/src").iterdir() if path.is_dir()) + [
    ROOT / f"crates/{name}/src" for name in ("command", "file", "fmi", "fmu", "python", "recording", "study", "web")]
# folders of Python files whose comments, docstrings and templates of pages are checked, and of JavaScript files, without those of others
SCRIPTS = ["benches", "examples", "python", "studies", "tools"]
PAGE_SCRIPTS = ["crates/command/src/report/viewer", "crates/web/page", "tools/site"]
# terms of FMI, in the crates of its interface
_OF_FMI = {"command": r"\bexperiments?\b", "fmi": r"\bexperiments?\b", "fmu": r"\bexperiments?\b"}
COMMENT_PHRASES = PHRASES + [
    # a field, type or constant is described by a noun phrase, a function by a verb in the third person
    r"(^|[.;:] )(what|who|whose|whom|whoever|whatever|where|how|why)\b",
    r"\bwhat\b|\bwho\b|\bwhatever\b",
    r"\b(hears?|heard|knows?|knew|asks|asked|sees|seen|wants?|wanted|says?|said|speaks?|feels?|felt)\b",
    r"\blook(s|ed)? (at|for)\b",
    r"\bintegrators? (of its own )?from outside\b|\bunder way\b|\banew\b|\bafresh\b",
    r"\bbegins?\b|\bbegun\b",
    r"\bexperiments?\b",
    r"\bslides? (with|of|along|about|at)\b.*\bhinges?\b|\bhinges? (or|and) (a )?slides?\b",
    r"\bgive[sn]? up\b|\bgave up\b|\bgoe?s? (on|by|with|back)\b",
    r"\bbrings?\b|\bbrought\b",
    r"\bstrangers?\b|\bdeaf\b|\bdies\b|\bpatience\b|\bforgiven\b",
    r"\bhangs?\b|\bhung\b",
    r"\bstand(s|ing)? (at|in|on|beside|behind|before|for|there|still|together)\b",
    r"\bit remembers\b|\bis remembered\b",
    r"\btake[sn]? for (one|granted|round|a )\b|\btaken for\b",
    r"\bbeside the present\b|\bof the present one\b",
    r"\b(derivatives?|slopes?) (of [a-z ]+ )?by (the|all|its|a) (parameters?|inputs?|motion|state|loads|time|start|spin)\b",
]


def prose(page):
    """Lines of a page with their numbers, without code and, for the page of messages, without the quoted messages."""
    fenced = False
    for number, line in enumerate(page.read_text(encoding="utf-8").splitlines(), 1):
        if line.lstrip().startswith("```"):
            fenced = not fenced
        elif not fenced:
            if page.name == "messages.md" and line.startswith("|"):
                line = "|".join(line.split("|")[2:])
            yield number, re.sub(r"`[^`]*`", "", line)


def comments(file):
    """Comments of a Rust file without code, adjacent lines joined, with the number of the first line."""
    block, first = [], 0
    for number, line in enumerate(file.read_text(encoding="utf-8").splitlines() + [""], 1):
        comment = re.match(r"\s*//[/!]?(?: (.*))?$", line)
        if not comment and (behind := re.search(r"[;,{})] // (.*)$", line)):
            yield number, behind[1]
        if comment:
            first = first if block else number
            block.append(comment[1] or "")
        elif block:
            yield first, re.sub(r"`[^`]*`|\]\([^)]*\)", "", " ".join(block))
            block = []


def _joined(lines):
    """Adjacent lines of comments joined, with the number of the first; `lines` are pairs of a number and a text."""
    first = last = None
    block = []
    for number, text in [*lines, (None, "")]:
        if block and (number is None or number != last + 1):
            yield first, " ".join(block)
            block = []
        first, last = first if block else number, number
        block.append(text)


def python_comments(file):
    """Comments, docstrings and Markdown templates of a Python file without code, with line numbers."""
    text = file.read_text(encoding="utf-8")
    own, found = [], []
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.COMMENT:
            comment = (token.start[0], token.string.lstrip("#!").strip())
            (own if token.line.lstrip().startswith("#") else found).append(comment)
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef)) and (docstring := ast.get_docstring(node)):
            found.append((node.body[0].lineno, docstring))
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and re.match(r"# .*\n", node.value):
            found.append((node.lineno, node.value))
    return [(number, re.sub(r"`[^`]*`", "", comment)) for number, comment in [*_joined(own), *found]]


def script_comments(file):
    """Comments of a JavaScript file without code, with line numbers."""
    own, found = [], []
    for number, line in enumerate(file.read_text(encoding="utf-8").splitlines(), 1):
        if comment := re.match(r"\s*//+ ?(.*)$", line):
            own.append((number, comment[1]))
        elif behind := re.search(r"[;,{})\]] // (.*)$", line):
            found.append((number, behind[1]))
    return [(number, re.sub(r"`[^`]*`", "", comment)) for number, comment in [*_joined(own), *found]]


def _forbidden(files, comments_of):
    """Places and forbidden phrases of the comments of files."""
    return [f"{file.relative_to(ROOT)}:{number}: {match[0]!r}" for file in files for number, text in comments_of(file)
            for phrase in COMMENT_PHRASES for match in [re.search(phrase, text, re.IGNORECASE)] if match]


@pytest.mark.parametrize("page", [page for page in PAGES if page.name not in GENERATED], ids=lambda page: page.name)
def test_pages_are_in_the_words_of_the_field(page):
    found = [f"{number}: {match[0]!r} in {line.strip()[:120]}" for number, line in prose(page) for phrase in PHRASES
             for match in [re.search(phrase, line, re.IGNORECASE)] if match]
    assert not found, "\n".join(found)


@pytest.mark.parametrize("folder", SOURCES, ids=lambda folder: str(folder.relative_to(ROOT)))
def test_comments_are_in_the_words_of_the_field(folder):
    found = [f"{file.relative_to(ROOT)}:{number}: {match[0]!r}" for file in sorted(folder.rglob("*.rs")) for number, text in comments(file)
             for phrase in COMMENT_PHRASES if phrase != _OF_FMI.get(folder.parent.name) for match in [re.search(phrase, text, re.IGNORECASE)] if match]
    assert not found, "\n".join(found)


@pytest.mark.parametrize("folder", SCRIPTS)
def test_comments_of_scripts_are_in_the_words_of_the_field(folder):
    files = sorted((ROOT / folder).rglob("*.py"))
    found = _forbidden(files, python_comments)
    assert files and not found, "\n".join(found)


@pytest.mark.parametrize("folder", PAGE_SCRIPTS)
def test_comments_of_page_scripts_are_in_the_words_of_the_field(folder):
    files = sorted((ROOT / folder).glob("*.js"))
    found = _forbidden(files, script_comments)
    assert files and not found, "\n".join(found)


def test_phrases_of_scripts_are_found(tmp_path):
    file = tmp_path / "some.py"
    file.write_text('"""It is\nsaid, as `what` says."""\n\nA = 1  # as it knows\n# What\n# is\n\n# this\nPAGE = """# Title\n\nIt asks.\n"""\n', encoding="utf-8")
    assert python_comments(file) == [(5, "What is"), (8, "this"), (4, "as it knows"), (1, "It is\nsaid, as  says."), (9, "# Title\n\nIt asks.\n")]
    script = tmp_path / "some.js"
    script.write_text('// What\n// is\nf("http://a"); // as `it` knows\n', encoding="utf-8")
    assert script_comments(script) == [(1, "What is"), (3, "as  knows")]


def test_phrases_are_found():
    assert re.search(PHRASES[0], "the machine is told of it") and re.search(PHRASES[12], "the wing comes to rest")


def test_phrases_of_comments_are_found(tmp_path):
    file = tmp_path / "some.rs"
    file.write_text("fn f() {}\n/// What is\n/// said then, as `what` says.\nconst A: f64 = 1.0; // as it knows\n", encoding="utf-8")
    assert list(comments(file)) == [(4, "as it knows"), (2, "What is said then, as  says.")]
    assert re.search(COMMENT_PHRASES[len(PHRASES)], "What is said then.", re.IGNORECASE)
