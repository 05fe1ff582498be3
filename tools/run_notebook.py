#!/usr/bin/env python3
"""Runs the code cells of a notebook in plain Python and writes their output back into it.

Usage: run_notebook.py NOTEBOOK.ipynb [--check]

Cells run one after the other in one namespace, in the folder of the notebook; their printed text and figures are kept.
The notebooks here need no more: no magics, no widgets, no value of a last line. A kernel would add twenty packages and
a server to the tests. With `--check` nothing is written; a line whose words differ from the stored ones, or whose
numbers differ by more than 2 %, is an error. (Numbers may change slightly with the solver's steps.)
"""

import argparse
import base64
import contextlib
import io
import json
import math
import os
import re
import sys
from itertools import zip_longest
from pathlib import Path

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt

NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
CLOSE = 0.02  # allowed relative difference of a number


def run(notebook, folder):
    """Outputs of every code cell, in order."""
    namespace = {"__name__": "__main__"}
    outputs = []
    with entered(folder):
        for number, cell in enumerate(code_cells(notebook), start=1):
            text = io.StringIO()
            with contextlib.redirect_stdout(text):
                exec(compile("".join(cell["source"]), f"cell {number}", "exec"), namespace)
            lines = text.getvalue().splitlines(keepends=True)
            printed = [{"output_type": "stream", "name": "stdout", "text": lines}] if lines else []
            outputs.append(printed + figures())
    return outputs


@contextlib.contextmanager
def entered(folder):
    """Context that changes to a folder and back."""
    before = os.getcwd()
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(before)


def code_cells(notebook):
    """The cells to run."""
    return [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]


def figures():
    """Open figures as outputs; closes them."""
    shown = []
    for number in plt.get_fignums():
        picture = io.BytesIO()
        plt.figure(number).savefig(picture, format="png", dpi=90, bbox_inches="tight", metadata={"Software": None})
        data = {"image/png": base64.b64encode(picture.getvalue()).decode("ascii"), "text/plain": ["<Figure>"]}
        shown.append({"output_type": "display_data", "data": data, "metadata": {}})
        plt.close(number)
    return shown


def texts(outputs):
    """Printed text of each cell."""
    streams = ([output for output in cell if output["output_type"] == "stream"] for cell in outputs)
    return ["".join("".join(output["text"]) for output in cell) for cell in streams]


def agree(stored, now):
    """Whether two lines have the same words and nearly the same numbers."""
    pairs = zip_longest(NUMBER.findall(stored), NUMBER.findall(now), fillvalue="nan")
    return NUMBER.sub("#", stored) == NUMBER.sub("#", now) and all(
        math.isclose(float(one), float(other), rel_tol=CLOSE) for one, other in pairs)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("notebook", type=Path)
    parser.add_argument("--check", action="store_true", help="compare with the stored texts instead of writing")
    arguments = parser.parse_args()

    path = arguments.notebook.resolve()
    notebook = json.loads(path.read_text(encoding="utf-8"))
    sys.path.insert(0, str(path.parent))  # as a kernel does
    outputs = run(notebook, path.parent)
    if arguments.check:
        stored, now = (texts(cells) for cells in ([cell["outputs"] for cell in code_cells(notebook)], outputs))
        lines = zip_longest("".join(stored).splitlines(), "".join(now).splitlines(), fillvalue="(nothing)")
        wrong = [f"stored: {one}\nnow:    {other}" for one, other in lines if not agree(one, other)]
        if wrong:
            raise SystemExit("\n".join(wrong))
        print(f"{len(outputs)} cells of {arguments.notebook} show what is stored")
        return
    for number, (cell, shown) in enumerate(zip(code_cells(notebook), outputs), start=1):
        cell.update(execution_count=number, outputs=shown)
    path.write_text(json.dumps(notebook, indent=1, ensure_ascii=False, sort_keys=True) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
