"""Phrases of a private dialect that must not come back into what users read: the field's words are in `docs/guide/glossary.md`."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGES = [ROOT / name for name in ("README.md", "CONTRIBUTING.md", "docs/COMMAND_LINE.md", "docs/PLATFORMS.md", "docs/ARCHITECTURE.md", "docs/NOTATION.md")]
PAGES += sorted((ROOT / "docs/guide").glob("*.md"))
# written from the program; messages.md quotes messages in its first column
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
    r"\bin the air of\b|\bin air by\b|\bin that of strips\b|\bair of (a|the) (rotor|lattice|strips)\b",
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
    r"\bmotion that every turn repeats\b|\bturns? (that )?repeats?\b",
]


def prose(page):
    """Lines of a page with their numbers, without code and, of the page of messages, without what it quotes."""
    fenced = False
    for number, line in enumerate(page.read_text(encoding="utf-8").splitlines(), 1):
        if line.lstrip().startswith("```"):
            fenced = not fenced
        elif not fenced:
            if page.name == "messages.md" and line.startswith("|"):
                line = "|".join(line.split("|")[2:])
            yield number, re.sub(r"`[^`]*`", "", line)


@pytest.mark.parametrize("page", [page for page in PAGES if page.name not in GENERATED], ids=lambda page: page.name)
def test_pages_are_in_the_words_of_the_field(page):
    found = [f"{number}: {match[0]!r} in {line.strip()[:120]}" for number, line in prose(page) for phrase in PHRASES
             for match in [re.search(phrase, line, re.IGNORECASE)] if match]
    assert not found, "\n".join(found)


def test_phrases_are_found():
    assert re.search(PHRASES[0], "the machine is told of it") and re.search(PHRASES[12], "the wing comes to rest")
