#!/usr/bin/env python3
"""Observed and allowed differences of the verification: docs/tables/agreement.md.

  FOLDWING_AGREEMENT=$PWD/target/agreement.csv cargo test --test verification
  python studies/agreement.py --rows target/agreement.csv --table docs/tables/agreement.md

Tests append a row with `agree` (tests/verification/agreement.rs). Of rows with the same name, the one nearest to its limit counts.
"""
import argparse
import csv
import math
import pathlib

FRAGILE, LOOSE = 1.5, 100.0
HEAD = """# Observed and allowed differences

Differences that the tests of the verification observe, those that they allow, and the ratio of allowed to observed. *Fragile*: below 1.5, the next
compiler may break the test. *Loose*: above 100, faults pass that the row is there to find. Written by
`python studies/agreement.py --rows target/agreement.csv --table docs/tables/agreement.md` (`make validate`) from the rows that tests give through
`agree` of `tests/verification/agreement.rs`.

| row | observed | allowed | ratio | |
|---|---|---|---|---|
"""


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rows", type=pathlib.Path, required=True)
    parser.add_argument("--table", type=pathlib.Path, required=True)
    given = parser.parse_args()
    nearest = {}
    with given.rows.open(encoding="utf-8", newline="") as file:
        for name, observed, allowed in csv.reader(file):
            ratio = float(allowed) / float(observed) if float(observed) else math.inf
            if name not in nearest or ratio < nearest[name][2]:
                nearest[name] = (float(observed), float(allowed), ratio)
    lines = [HEAD]
    counts = {"fragile": 0, "loose": 0}
    for name, (observed, allowed, ratio) in sorted(nearest.items()):
        kind = "fragile" if ratio < FRAGILE else "loose" if LOOSE < ratio < math.inf else ""
        if kind:
            counts[kind] += 1
        lines.append(f"| {name} | {observed:.1e} | {allowed:.1e} | {'equal' if ratio == math.inf else f'{ratio:.1f}'} | {kind} |\n")
    given.table.write_text("".join(lines), encoding="utf-8")
    print(f"{len(nearest)} rows, {counts['fragile']} fragile, {counts['loose']} loose: {given.table}")


if __name__ == "__main__":
    main()
