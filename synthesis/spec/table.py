"""A frequency table in a CSV file: two columns, frequency and bound; exact numbers, and every fault at its line."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

from ..errors import InputError, Location
from .csv_rows import number, rows
from .data_file import read_bytes
from .exact import decimal_text, misread
from .fields import require
from .reader import decode
from .tree import shown
from .units import FREQUENCY, RATIO, Dimension, parse_quantity

MAX_ROWS = 1000

Points = tuple[tuple[Fraction, Fraction], ...]

_EXAMPLE = "write `frequency [Hz],bound` or `omega [rad/s],bound`"
_HEADINGS = tuple(
    re.compile(rf"(?:{name})\s*(?:\[({unit})\]|\(({unit})\))?", re.IGNORECASE)
    for name, unit in (("frequency|omega|ω", ".+"), ("bound", r"\s*%\s*"))
)


@dataclass(frozen=True)
class Point:
    """One row: where it stands, its frequency in rad/s, its bound."""

    where: Location
    omega: Fraction
    bound: Fraction


def ordered(found: Iterable[Point], whole: Location) -> Points:
    """The points of a table: at least one, frequencies from 0 that increase, bounds ≥ 0."""
    points: list[tuple[Fraction, Fraction]] = []
    for row in found:
        message = f"expected at most {MAX_ROWS} points; found more; leave some out, and round the bound up around them"
        require(len(points) < MAX_ROWS, message, row.where)
        require(row.omega >= 0, f"expected a frequency ≥ 0; found {decimal_text(row.omega)} rad/s", row.where)
        require(row.bound >= 0, f"expected a bound ≥ 0; found {decimal_text(row.bound)}", row.where)
        if points:
            last, here = points[-1][0], f"{decimal_text(row.omega)} after {decimal_text(points[-1][0])} rad/s"
            twice = f"expected each frequency once; found {here}; keep the larger bound"
            require(row.omega != last, twice, row.where)
            require(row.omega > last, f"expected frequencies that increase; found {here}; sort the rows", row.where)
        points.append((row.omega, row.bound))
    require(bool(points), "expected at least one point, a frequency and a bound; found none", whole)
    return tuple(points)


def read_table(path: Path, where: Location) -> Points:
    """The points of a CSV file; `where` it is named.

    Raises:
        InputError: file, line and column name of the first fault, what was expected, what to do.
    """
    text, file = decode(read_bytes(path, where), str(path)), str(path)
    return ordered(_points(text, file), Location(file, 1))


def _points(text: str, file: str) -> Iterator[Point]:
    factors = (Fraction(1), Fraction(1))
    for index, (line, cells) in enumerate(rows(text, file)):
        require(len(cells) == 2, f"expected two columns, frequency and bound; found {len(cells)}", line)
        if not index and misread(cells[0]) is None and not re.match(r"[0-9.+-]", cells[0]):
            factors = (_factor(cells[0], 0, FREQUENCY, line), _factor(cells[1], 1, RATIO, line))
        else:
            omega = number(cells[0], line, "frequency", factors[0])
            yield Point(line, omega, number(cells[1], line, "bound", factors[1]))


def _factor(heading: str, column: int, dimension: Dimension, line: Location) -> Fraction:
    """What one of a column's unit is worth in SI; a heading without unit: SI."""
    match = _HEADINGS[column].fullmatch(heading)
    what = ("a heading or a frequency", "the heading bound or bound [%]")[column]
    expected = f"expected {what}; found {shown(heading)}"
    if not match:
        raise InputError(f"{expected}; {_EXAMPLE}", line)
    try:
        return parse_quantity(f"1 {(match[1] or match[2] or '').strip()}", dimension)
    except ValueError as error:
        raise InputError(f"{expected}: {error}", line) from None
