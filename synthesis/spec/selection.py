"""Which records of a measurement a joint is judged by: those of the stated amplitudes, without the excluded ones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import PurePosixPath

from ..errors import InputError, Location
from .exact import decimal_text
from .fields import require
from .model import Interval
from .record import Record
from .tree import shown


@dataclass(frozen=True)
class Selection:
    """Records kept; names of those excluded, and of those of other amplitudes."""

    kept: tuple[Record, ...]
    excluded: tuple[str, ...]
    other_amplitudes: tuple[str, ...]


def select(
    records: Sequence[Record], amplitude: Interval | None, exclude: Sequence[str], where: Location | None
) -> Selection:
    """The records of the stated amplitudes that are not excluded by name (`*` and `?` stand for any letters).

    A record without amplitude is taken to lie in the stated range.

    Raises:
        InputError: at `where`, if two records have one name, if amplitudes differ and no range is stated, if a name
        matches nothing, or if nothing is left.
    """
    place = where or Location("records")
    names = [record.name for record in records]
    twice = next((name for name in names if names.count(name) > 1), "")
    require(not twice, f"two records are named {shown(twice)}; rename a file or a record", place)
    for pattern in exclude:
        found = any(_named(name, pattern) for name in names)
        require(found, f"expected the name of a record to exclude; {shown(pattern)} matches none", place)
    _demand_amplitude(records, amplitude, place)
    excluded = tuple(name for name in names if any(_named(name, pattern) for pattern in exclude))
    others = tuple(record.name for record in records if not _within(record, amplitude) and record.name not in excluded)
    kept = tuple(record for record in records if record.name not in (*excluded, *others))
    message = "expected a record to judge the joint by; amplitude and exclude leave none of"
    require(bool(kept), f"{message} {len(records)}", place)
    return Selection(kept, excluded, others)


def _demand_amplitude(records: Sequence[Record], amplitude: Interval | None, where: Location) -> None:
    stated = sorted({record.amplitude for record in records if record.amplitude is not None})
    if amplitude is None and len(stated) > 1:
        low, high = decimal_text(stated[0]), decimal_text(stated[-1])
        raise InputError(
            f"the records were taken at amplitudes {low} to {high}, and friction makes a joint's response depend on "
            f"them; state the range the joint will see; amplitude: [{low}, {high}], --amplitude {low}:{high} is all",
            where,
        )


def _within(record: Record, amplitude: Interval | None) -> bool:
    return amplitude is None or record.amplitude is None or amplitude[0] <= record.amplitude <= amplitude[1]


def _named(name: str, pattern: str) -> bool:
    """Whether a record is meant: by its whole name, or without its folder, its file."""
    file, _, label = name.partition(":")
    return pattern in (name, label, PurePosixPath(file).name) or fnmatchcase(name, pattern)
