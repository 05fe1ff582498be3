"""Models and options for commands of 0.1.0: names that have changed since, from the table with which the reader rejects them.

    command = Command(path)                     # determines once which names it supports
    with command.model(path) as model: ...      # the file itself, or a copy with the old names next to it
    command.option("--variables")               # "--output" for an old command
    command.column("fold.torque")               # "fold.external_torque": the current name
"""

import contextlib
import re
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
OPTIONS = {"--variables": "--output", "--output": "--out", "--profile": "--timing", "--interface": "--kinds", "--state": "--about", "--vary": "--over"}
# only for variables of revolute and prismatic joints: the others keep the names of parameters
COLUMNS = [
    (r"\.(torque|force)$", r".external_\1", r"^(?!rotor|root|aero|load|generator|internal_load|section_load|loop)"),
    (r"\.applied_(torque|force)$", r".total_\1", ""),
    (r"^tip_(\w+)\.", r"tip.\1.", ""),
    (r"^aero\.flap\.", "aero.control_surface.", ""),
    (r"^section_load\.", "internal_load.", ""),
    (r"^energy\.drive$", "energy.motor", ""),
]


def table(name):
    """The rows (table or key, old, new) of `crates/file/src/renamed.rs`."""
    text = (ROOT / "crates/file/src/renamed.rs").read_text(encoding="utf-8")
    return re.findall(r'\("([^"]*)", "([^"]*)", "([^"]*)"\)', text.split(f"const {name}")[1].split("];")[0])


def in_old_names(text):
    """Converts a current model file for a reader of 0.1.0. Keys and tables are distinguished by the table at the top of their
    path."""
    lines, top = [], ""
    values = [(key, old, new) for key, old, new in table("VALUES")]
    for line in text.splitlines():
        header = re.match(r"\s*\[+([^\]]+)\]", line)
        key = re.match(r"\s*([\w.]+)\s*=", line)
        inside = header[1].split(".")[0] if header else top
        for under, old, new in values:
            line = re.sub(rf'(?<![\w-]){under}(\s*=\s*)"{new}"', rf'{under}\1"{old}"', line)
        for of, old, new in table("KEYS"):
            if of == "" and (header or key and not top):
                line = re.sub(rf"^(\s*\[*){new}(?=[\].=\s])", rf"\g<1>{old}", line)
            elif of in ("*", inside) and header:  # after the names of the table and of its part
                line = re.sub(rf"^(\s*\[+\w+\.\w+(?:\.\w+)*?\.){new}(?=[.\]])", rf"\g<1>{old}", line)
            elif of in ("*", inside) or not top and key and key[1].split(".")[0] == of:
                line = re.sub(rf"(?<![\w-]){new}(?=\s*=|\.|\])", old, line)
        top = inside
        lines.append(line)
    return "\n".join(lines) + "\n"


class Command:
    """The current command or that of 0.1.0."""

    def __init__(self, path):
        self.path = path
        shown = subprocess.run([path, "check", "--help"], capture_output=True, text=True).stdout
        self.is_old = "--list-variables" not in shown

    def option(self, name):
        """Name of a current option in this command."""
        return OPTIONS.get(name, name) if self.is_old else name

    @contextlib.contextmanager
    def model(self, path):
        """The model file in the form that this command reads, next to the files that it references."""
        if not self.is_old:
            yield path
            return
        text = in_old_names(path.read_text(encoding="utf-8"))
        copies = [path.with_name(f"{path.stem}-0.1.0-names.toml")]
        keys = {new: old for of, old, new in table("KEYS") if of in ("*", "section", "body")}
        for name in set(re.findall(r'"([^"]+\.csv)"', text)):
            columns = (path.parent / name).read_text(encoding="utf-8")
            columns = re.sub(r"(?m)^eta\b.*$", lambda head: ",".join(keys.get(key.strip(), key) for key in head[0].split(",")), columns, count=1)
            copies.append(path.with_name(f"{path.stem}-0.1.0-{Path(name).name}"))
            copies[-1].write_text(columns, encoding="utf-8")
            text = text.replace(f'"{name}"', f'"{copies[-1].name}"')
        copies[0].write_text(text, encoding="utf-8")
        try:
            yield copies[0]
        finally:
            for copy in copies:
                copy.unlink()

    def column(self, name):
        """The current name of a column written by this command."""
        if self.is_old:
            for pattern, new, where in COLUMNS:
                if re.search(where, name):
                    name = re.sub(pattern, new, name)
        return name
