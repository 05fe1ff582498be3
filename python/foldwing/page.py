"""Results as tables in notebooks."""

from __future__ import annotations

from html import escape
from typing import Any, Iterable, List, Sequence

MAXIMUM_ROWS = 20
"""Maximum number of rows of a table; further rows are only counted."""


def number(value: Any) -> str:
    """Text of a cell: numbers with six significant digits, empty for missing values.

    >>> number(1234.56789), number(float("nan")), number(True), number("done"), number(None)
    ('1234.57', '', 'True', 'done', '')
    """
    if value is None or (isinstance(value, float) and value != value):
        return ""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return str(value)
    return f"{value:.6g}"


def table(title: str, header: Sequence[str], rows: Iterable[Sequence[Any]], note: str = "") -> str:
    """HTML table with a title above it and a note below."""
    every: List[Sequence[Any]] = list(rows)
    head = "".join(f"<th style='text-align:left'>{escape(cell)}</th>" for cell in header)
    body = "".join(
        "<tr>" + "".join(f"<td style='text-align:left'>{escape(number(_plain(cell)))}</td>" for cell in row) + "</tr>"
        for row in every[:MAXIMUM_ROWS]
    )
    more = f"{len(every) - MAXIMUM_ROWS} more rows" if len(every) > MAXIMUM_ROWS else ""
    notes = "".join(f"<div>{escape(text)}</div>" for text in (more, note) if text)
    return f"<div><b>{escape(title)}</b></div><table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>{notes}"


def _plain(cell: Any) -> Any:
    return cell.item() if hasattr(cell, "item") else cell
