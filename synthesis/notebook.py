"""How results look in a notebook: a small card of HTML, readable on light and dark pages, every text escaped."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

TONES = {"good": "#1b8a4b", "bad": "#d03a3a", "open": "#b07a10", "plain": "#7a8594"}  # legible on white and on black
_CELL = "text-align:left;padding:.1em .9em .1em 0;vertical-align:top"


def card(
    title: str,
    badge: str = "",
    tone: str = "plain",
    rows: Iterable[tuple[str, str]] = (),
    table: tuple[Sequence[str], Iterable[Sequence[str]]] | None = None,
) -> str:
    """A title with a coloured badge, rows of name and value, and a table of headings and rows. Returns HTML."""
    mark = f' <b style="color:{TONES[tone]}">{escape(badge)}</b>' if badge else ""
    parts = [f"<div><b>{escape(title)}</b>{mark}</div>"]
    listed = "".join(_row((name, value), "td") for name, value in rows)
    parts += [f"<table>{listed}</table>"] if listed else []
    if table is not None:
        body = "".join(_row(row, "td") for row in table[1])
        parts.append(f"<table><thead>{_row(table[0], 'th')}</thead><tbody>{body}</tbody></table>")
    return f'<div style="border-left:4px solid {TONES[tone]};padding:.2em .8em">{"".join(parts)}</div>'


def _row(cells: Sequence[str], tag: str) -> str:
    inside = "".join(f'<{tag} style="{_CELL}">{escape(cell)}</{tag}>' for cell in cells)
    return f"<tr>{inside}</tr>"
