"""The rows of a CSV file, each with its place: comma-separated, blank lines left out."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator
from fractions import Fraction

from ..errors import InputError, Location
from .exact import bounded, parse_number
from .fields import require
from .tree import shown


def rows(text: str, file: str) -> Iterator[tuple[Location, list[str]]]:
    """Place and cells of every row that is not blank.

    Raises:
        InputError: broken quotes, or cells separated by something else than commas.
    """
    reader = csv.reader(io.StringIO(text, newline=""), strict=True)
    try:
        for row in reader:
            cells = [cell.strip() for cell in row]
            if not any(cells) and len(cells) < 2:
                continue
            line = Location(file, reader.line_num)
            stray = next((sign for sign in (";", "\t") if any(sign in cell for cell in cells)), None)
            expected = f"expected a comma between the columns; found {stray!r}"
            require(stray is None, f"{expected}; write `10.5,0.1`: a comma, and decimal points", line)
            yield line, cells
    except csv.Error as error:
        raise InputError(f"not valid CSV: {error}; check the quotes", Location(file, reader.line_num)) from None


def number(cell: str, line: Location, column: str, factor: Fraction = Fraction(1)) -> Fraction:
    """The number in a cell, in the unit `factor` of its column."""
    try:
        return bounded(parse_number(cell) * factor)
    except ValueError as error:
        message = f"expected a number; found {shown(cell) if cell else 'nothing'}: {error}; units go into the heading"
        raise InputError(message, Location(line.file, line.line, key=column)) from None
