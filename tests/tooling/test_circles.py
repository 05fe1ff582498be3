"""Circular imports between files: no crate may have more or larger circles than listed here (`tools/circles.py` prints them)."""

import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))
import circles  # noqa: E402

# sizes of the circles of each crate, in files; when a circle shrinks, enter its new size here
SIZES = {
    "command": [4, 3, 2, 2, 2],
    "engine": [4, 3, 3, 3, 3, 2, 2, 2, 2, 2],
    "file": [],
    "fmi": [2],
    "fmu": [2],
    "import": [2],
    "python": [2],
    "recording": [2],
    "study": [2],
    "web": [],
}


@pytest.fixture
def crate(tmp_path):
    """Imports of a crate with the given files, by names of modules."""

    def build(**files):
        for name, text in files.items():
            path = tmp_path / (name.replace("__", "/") + ".rs")
            path.parent.mkdir(exist_ok=True)
            path.write_text(text)
        tree = circles.Crate(tmp_path)
        return {circles.name(a): {circles.name(b) for b in others} for a, others in tree.imports.items()}, tree.circles()

    return build


def test_no_crate_has_more_circles_than_listed():
    found = {crate: [len(circle) for circle in tree.circles()] for crate, tree in circles.crates().items()}
    assert found.keys() == SIZES.keys()
    larger = {
        crate: sizes
        for crate, sizes in found.items()
        if len(sizes) > len(SIZES[crate]) or any(new > old for new, old in zip(sizes, SIZES[crate]))
    }
    assert not larger, f"circles of files, where {SIZES} are listed; tools/circles.py CRATE --cuts names the imports"


def test_an_import_through_a_re_export_is_one_of_the_file_behind_it(crate):
    imports, found = crate(
        lib="mod a; mod b;",
        a__mod="mod inner; pub use inner::Thing as Named;",
        a__inner="use crate::b::B; pub struct Thing(B);",
        b="use crate::a::Named; pub struct B;",
    )
    assert imports == {"lib": set(), "a": set(), "a::inner": {"b"}, "b": {"a::inner"}}
    assert found == [[("a", "inner"), ("b",)]]


def test_paths_in_code_count_and_comments_texts_and_tests_do_not(crate):
    imports, found = crate(
        lib="pub mod a; pub mod b; #[cfg(test)] mod probe;",
        a="// use crate::b::B;\n/// [`crate::b`]\nconst T: &str = \"crate::b::B\"; const C: char = '\"';\nfn f() -> u8 { super::b::two() }",
        b="pub fn two() -> u8 { 2 } #[cfg(test)] mod tests { use crate::a::f; }\n#[cfg(test)]\nuse crate::a::{f, g};\n",
        probe="use crate::a::f;",
    )
    assert imports == {"lib": set(), "a": {"b"}, "b": set()}
    assert found == []


def test_an_item_in_mod_rs_is_one_of_that_file(crate):
    imports, found = crate(
        lib="mod a;",
        a__mod="mod leaf; use leaf::{self, grow as larger}; pub struct Tree; fn f() { leaf::grow() }",
        a__leaf="use super::Tree; pub fn grow() {}",
    )
    assert imports == {"lib": set(), "a": {"a::leaf"}, "a::leaf": {"a"}}
    assert found == [[("a",), ("a", "leaf")]]


def test_cuts_open_a_circle():
    graph = {"a": {"b"}, "b": {"c", "d"}, "c": {"a"}, "d": {"b"}, "e": {"a"}}
    (circle,) = circles.circles_of(graph)
    assert circle == ["a", "b", "c", "d"]
    removed = circles.cuts(graph, circle)
    for a, b, _ in removed:
        graph[a].remove(b)
    assert len(removed) == 2 and circles.circles_of(graph) == []
