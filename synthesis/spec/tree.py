"""The tree a specification is read from: text, lists and sections, each with its place in the file."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TypeAlias

from ..errors import Location

MAX_DEPTH = 12


@dataclass(frozen=True)
class Scalar:
    """Text as written; `plain` where it stood without quotes."""

    text: str
    plain: bool
    where: Location


@dataclass(frozen=True)
class Sequence:
    """A list."""

    items: tuple[Node, ...]
    where: Location


@dataclass(frozen=True)
class Mapping:
    """A section: each key with the place it stands at, and its value."""

    entries: dict[str, tuple[Location, Node]]
    where: Location


Node: TypeAlias = Scalar | Sequence | Mapping


def shown(text: str) -> str:
    """Text quoted for an error message: one line, printable, short."""
    return repr(text if len(text) <= 40 else text[:37] + "...")


def joined(key: str | None, child: str) -> str:
    """The dotted key of a child, safe to print whatever the file calls it."""
    name = child if re.fullmatch(r"[\w-]{1,40}", child) else shown(child)
    return f"{key}.{name}" if key else name
