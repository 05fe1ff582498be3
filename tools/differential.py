"""Compare two builds of the command on the shipped models and on random ones: every output, bit by bit.

Both commands simulate each model and write all outputs as CSV, in their shortest form that reads back to the same number, so that equal
texts mean equal bits. Each model runs twice with each command, and the two runs must be identical. If the outputs of the two commands
differ, the table lists the difference relative to the range of the output; the reasons are to be entered in `differential_reasons.csv`
next to the table (columns `model,output,reason`; `*` matches all), which is kept when the table is renewed.
"""

import argparse
import csv
import math
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from old_names import Command

ROOT = Path(__file__).resolve().parents[1]
# limit for a run of a shipped model: a run of seconds in `make deploy` may take minutes on a busy machine
TIMEOUT_S = 600


def simulate(command, model, out):
    """Returns the text of the CSV, or the message with which the command failed."""
    try:
        with command.model(model) as file:
            ran = subprocess.run(
                [command.path, "simulate", file, "--csv", out, "--force", "--quiet"],
                capture_output=True, text=True, timeout=TIMEOUT_S,
            )
    except subprocess.TimeoutExpired:
        return None, f"no end within {TIMEOUT_S} s"
    if ran.returncode != 0:
        return None, (ran.stderr.strip().splitlines() or ["no message"])[0].replace(str(model), model.name)
    head, rows = Path(out).read_text(encoding="utf-8").split("\n", 1)
    return ",".join(map(command.column, head.split(","))) + "\n" + rows, ""


def columns(text):
    """The columns of a CSV by name, as lists of floats."""
    rows = csv.reader(text.splitlines())
    names = next(rows)
    values = list(zip(*[[float(cell) if cell else math.nan for cell in row] for row in rows]))
    return dict(zip(names, values))


def moved(old, new):
    """Rows (output, largest difference, range of the old output, time) for the outputs that differ."""
    old, new = columns(old), columns(new)
    found = []
    for name in old.keys() | new.keys():
        if name not in old or name not in new:
            found.append((name, math.inf, math.nan, "only in the new one" if name not in old else "only in the old one"))
            continue
        a, b = old[name], new[name]
        if len(a) != len(b):
            found.append((name, math.inf, math.nan, f"{len(a)} rows, then {len(b)}"))
            continue
        off = [math.inf if math.isnan(x) != math.isnan(y) else abs(x - y) for x, y in zip(a, b) if x != y and not (x != x and y != y)]
        if off:
            finite = [x for x in a if not math.isnan(x)]
            found.append((name, max(off), max(finite) - min(finite) if finite else 0.0, ""))
    # equal numbers cannot have different texts: both commands write the shortest form
    return sorted(found, key=lambda row: -row[1] / (row[2] or 1.0) if math.isfinite(row[1]) else -math.inf)


def compare(arguments, model, folder):
    """Rows (model, output, difference, range, relative difference, note)."""
    texts = []
    for which in ("old", "new"):
        command = getattr(arguments, which)
        first = simulate(command, model, folder / f"{model.stem}-{which}.csv")
        again = simulate(command, model, folder / f"{model.stem}-{which}.csv")
        if first != again:
            return [(model.name, "*", math.inf, math.nan, math.inf, f"the {which} command does not repeat its own run")]
        texts.append(first)
    (old, old_error), (new, new_error) = texts
    if old is None or new is None:
        if old_error == new_error:
            return []
        return [(model.name, "*", math.inf, math.nan, math.inf, f"old: {old_error or 'runs'}; new: {new_error or 'runs'}")]
    if old == new:
        return []
    return [(model.name, name, off, size, off / size if size else math.inf, note) for name, off, size, note in moved(old, new)]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--old", required=True, type=lambda path: Command(Path(path).resolve()), help="command of the earlier commit")
    parser.add_argument("--new", required=True, type=lambda path: Command(Path(path).resolve()), help="command to compare with it")
    parser.add_argument("--models", type=Path, help="folder of further models, such as random ones")
    parser.add_argument("--output", required=True, type=Path, help="folder of the table and of the runs")
    parser.add_argument("--only-further", action="store_true", help="leave out the shipped models")
    parser.add_argument("--jobs", type=int, default=2)
    arguments = parser.parse_args()
    runs = arguments.output / "runs"
    runs.mkdir(parents=True, exist_ok=True)
    models = [] if arguments.only_further else sorted((ROOT / "examples").glob("**/*.toml"))
    models += sorted(arguments.models.glob("*.toml")) if arguments.models else []
    if not models:
        sys.exit("no models to compare")
    reasons_file = arguments.output / "differential_reasons.csv"
    reasons = {}
    if reasons_file.exists():
        with reasons_file.open(newline="", encoding="utf-8") as file:
            reasons = {(row["model"], row["output"]): row["reason"] for row in csv.DictReader(file)}
    with ThreadPoolExecutor(arguments.jobs) as pool:
        results = list(pool.map(lambda model: compare(arguments, model, runs), models))
    rows = [row for result in results for row in result]
    with (arguments.output / "differential.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["model", "output", "difference", "range", "share", "note", "reason"])
        for row in rows:
            reason = next((reasons[key] for key in ((row[0], row[1]), (row[0], "*"), ("*", row[1]), ("*", "*")) if key in reasons), "")
            writer.writerow([*row, reason])
    lines = ["| model | outputs that moved | most, of the range | output | note |", "|---|---|---|---|---|"]
    for model, result in zip(models, results):
        if result:
            worst = max(result, key=lambda row: row[4])
            lines.append(f"| {model.name} | {len(result)} | {worst[4]:.1e} | `{worst[1]}` | {worst[5]} |")
    same = sum(not result for result in results)
    lines.insert(0, f"{same} of {len(models)} models give the same bits; the others:\n")
    (arguments.output / "differential.md").write_text("\n".join(lines) + "\n", encoding="utf-8")
    print("\n".join(lines))


if __name__ == "__main__":
    main()
