"""Scripts read only options that they declare: a renamed option that is still read by its old name fails only when the script runs."""
import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SCRIPTS = sorted(
    path for folder in ("tools", "studies", "examples", "benches") for path in (ROOT / folder).rglob("*.py") if "add_argument" in path.read_text(encoding="utf-8")
)


def declared(tree):
    """Names of the attributes created by `add_argument`."""
    names = set()
    for call in ast.walk(tree):
        if not (isinstance(call, ast.Call) and isinstance(call.func, ast.Attribute) and call.func.attr == "add_argument"):
            continue
        flags = [flag.value for flag in call.args if isinstance(flag, ast.Constant)]
        dest = [word.value.value for word in call.keywords if word.arg == "dest"]
        long = [flag for flag in flags if flag.startswith("--")] or flags
        names.update(dest or [flag.lstrip("-").replace("-", "_") for flag in long[:1]])
    return names


def read(tree):
    """Attributes read from the values of `parse_args`, also from parameters of the same name."""
    values = {
        target.id
        for node in ast.walk(tree)
        if isinstance(node, ast.Assign) and isinstance(node.value, ast.Call)
        and isinstance(node.value.func, ast.Attribute) and node.value.func.attr == "parse_args"
        for target in node.targets if isinstance(target, ast.Name)
    }
    return {
        node.attr for node in ast.walk(tree)
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id in values
    }


def test_a_script_is_found():
    assert len(SCRIPTS) > 20
    tree = ast.parse("given = p.parse_args()\np.add_argument('--new-name')\nprint(given.old)")
    assert (declared(tree), read(tree)) == ({"new_name"}, {"old"})


@pytest.mark.parametrize("path", SCRIPTS, ids=lambda path: str(path.relative_to(ROOT)))
def test_options_read_are_declared(path):
    tree = ast.parse(path.read_text(encoding="utf-8"))
    missing = {name for name in read(tree) - declared(tree) if not name.startswith("_")}
    assert not missing, f"{path.name} reads {sorted(missing)}, which no option declares"
