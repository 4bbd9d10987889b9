"""Measured responses of the load to a table: `|Δ(jω)| ≤ W(ω)` around the nominal load, exact and self-contained.

At every measured frequency W is the largest |G/Ĝ − 1| of all records, rounded up to four digits; between two of them
the larger of the two; outside of the band what `beyond` says. The table keeps the digests of the files it came from.
"""

from __future__ import annotations

import re
from hashlib import sha256
from pathlib import Path, PurePosixPath

from ..errors import InputError, Location
from .data_file import data_files, read_bytes
from .exact import decimal_text
from .fields import described, entries, integer, non_negative, require
from .model import DataFile, Interval, Measured, Plant, Table
from .ranges import interval
from .record import Bounds, Record, dynamic_stiffness, envelope, stepped, unusable
from .response_file import read_responses
from .selection import select
from .table import MAX_ROWS
from .tree import Mapping, Node, Scalar, Sequence, joined
from .units import PLAIN, RATIO

MAX_SAMPLES = 50_000  # of all records

_BEYOND = "write `beyond: hold` to say that the deviations at both ends hold outside of the measured band, or"
_BEYOND += " `beyond: [0.5, 2]` to give |Δ| below and above it"


def measured(node: Node, plant: Plant, folder: Path | None) -> Table:
    """The table that the responses in a specification's `measured:` section come down to.

    Raises:
        InputError: in the specification or at a line of a data file.
    """
    section = entries(node, ("files",), ("amplitude", "exclude", "beyond"))
    where = node.where
    missing = Location(where.file, where.line, where.column, joined(where.key, "beyond"))
    require("beyond" in section, f"expected this key; it is missing, and it has no default; {_BEYOND}", missing)
    records, files = _read(section["files"], folder)
    amplitude = _amplitude(section["amplitude"]) if "amplitude" in section else None
    selection = select(records, amplitude, _names(section.get("exclude")), where)
    for name, fault in unusable(selection.kept).items():
        raise InputError(f"the record {name!r} is {fault}; measure it again, or leave it out with `exclude:`", where)
    count = len({sample.omega for record in selection.kept for sample in record.samples})
    message = f"expected at most {MAX_ROWS} frequencies in all records; found {count}; measure at common ones"
    require(count <= MAX_ROWS, message, where)
    bounds = stepped(envelope(selection.kept, dynamic_stiffness(plant.inertia, plant.damping, plant.stiffness)))
    origin = Measured(
        files=files,
        amplitude=amplitude,
        records=len(selection.kept),
        excluded=selection.excluded,
    )
    return Table(points=beyond(section["beyond"], bounds), beyond="hold", measured=origin)


def beyond(node: Node, bounds: Bounds) -> Bounds:
    """The bounds with their ends raised to what is said to hold outside of the band."""
    if isinstance(node, Scalar) and node.text == "hold":
        return bounds
    if not isinstance(node, Sequence) or len(node.items) != 2:
        raise InputError(f"expected hold or [low, high]; found {described(node)}; {_BEYOND}", node.where)
    ends = [(*bounds[0], node.items[0]), (*bounds[-1], node.items[1])]
    found = dict(bounds)
    for omega, least, item in ends:
        value = non_negative(item, RATIO)
        message = f"expected at least the {decimal_text(least)} that was measured at {decimal_text(omega)} rad/s"
        require(value >= least, f"{message}; found {described(item)}", item.where)
        found[omega] = value
    return tuple(found.items())


def origin(node: Node) -> Measured:
    """Where the points of a canonical specification's table came from."""
    section = entries(node, ("files", "records", "excluded"), ("amplitude",))
    files = section["files"]
    if not isinstance(files, Sequence) or not files.items:
        raise InputError(f"expected a list of files; found {described(files)}", files.where)
    return Measured(
        files=tuple(_digest(item) for item in files.items),
        amplitude=_amplitude(section["amplitude"]) if "amplitude" in section else None,
        records=integer(section["records"], "a number of records"),
        excluded=_names(section["excluded"]),
    )


def _digest(node: Node) -> DataFile:
    section = entries(node, ("name", "sha256"))
    name, digest = section["name"], section["sha256"]
    if not isinstance(digest, Scalar) or not re.fullmatch(r"[0-9a-f]{64}", digest.text):
        raise InputError(f"expected 64 hexadecimal digits; found {described(digest)}", digest.where)
    if not isinstance(name, Scalar) or not name.text:
        raise InputError(f"expected the name of a file; found {described(name)}", name.where)
    return DataFile(name=name.text, sha256=digest.text)


def _read(node: Node, folder: Path | None) -> tuple[tuple[Record, ...], tuple[DataFile, ...]]:
    items = node.items if isinstance(node, Sequence) else (node,)
    require(bool(items), "expected the names of CSV files; found an empty list", node.where)
    if isinstance(node, Mapping):
        raise InputError("expected a list of CSV files, such as [frf/*.csv]; found a section", node.where)
    paths = {name: (path, item) for item in items for name, path in data_files(item, folder).items()}
    records: list[Record] = []
    files: list[DataFile] = []
    for name, (path, item) in paths.items():
        data = read_bytes(path, item.where)
        records += read_responses(data, str(path), PurePosixPath(name).with_suffix("").as_posix())
        files.append(DataFile(name=name, sha256=sha256(data).hexdigest()))
        count = sum(len(record.samples) for record in records)
        require(count <= MAX_SAMPLES, f"expected at most {MAX_SAMPLES} measured points; found more", item.where)
    return tuple(records), tuple(files)


def _amplitude(node: Node) -> Interval:
    low, high = interval(node, PLAIN)
    require(low >= 0, f"expected amplitudes ≥ 0; found {decimal_text(low)}", node.where)
    return low, high


def _names(node: Node | None) -> tuple[str, ...]:
    if node is None:
        return ()
    items = node.items if isinstance(node, Sequence) else (node,)
    for item in items:
        named = isinstance(item, Scalar) and item.text
        require(bool(named), f"expected the name of a record; found {described(item)}", item.where)
    return tuple(item.text for item in items if isinstance(item, Scalar))
