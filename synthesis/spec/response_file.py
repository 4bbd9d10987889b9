"""Frequency responses in a CSV file: exact numbers, units in the heading, and every fault at its line and column."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from fractions import Fraction
from typing import Literal, cast

from ..errors import InputError, Location
from .csv_rows import number, rows
from .exact import decimal_text
from .fields import require
from .polar import ERROR, cartesian, ratio_of_decibels
from .reader import decode
from .record import Record, Sample
from .tree import shown
from .units import TWO_PI

MAX_RECORDS = 1000
_MOST_SAMPLES = 1000  # of a record

_NAMES = {
    "frequency": ("frequency", "freq", "f", "omega", "ω"),
    "real": ("real", "re"),
    "imaginary": ("imaginary", "imag", "im"),
    "gain": ("gain", "magnitude", "mag", "abs"),
    "phase": ("phase", "angle", "arg"),
    "coherence": ("coherence", "coh"),
    "amplitude": ("amplitude", "amp"),
    "record": ("record", "file", "run", "name"),
}
_UNITS: dict[str, tuple[str, ...]] = {  # SI first; "" where the heading may leave it out
    "frequency": ("rad/s", "Hz", "kHz"),
    "gain": ("", "abs", "dB", "rad/(N·m)", "rad/N·m", "m/N"),
    "phase": ("deg", "°", "rad"),
    "real": ("", "rad/(N·m)", "rad/N·m", "m/N"),
    "imaginary": ("", "rad/(N·m)", "rad/N·m", "m/N"),
    "coherence": ("",),
    "record": ("",),
}
_FREQUENCIES = {"rad/s": Fraction(1), "Hz": TWO_PI, "kHz": 1000 * TWO_PI}
_HEADING = re.compile(r"([^\W\d_]+)\s*(?:\[(.*)\]|\((.*)\)|_(.*))?")
_EXAMPLE = "write `frequency [Hz],real,imaginary` or `frequency [Hz],gain [dB],phase [deg]`"

Columns = Mapping[str, tuple[int, str, str]]  # kind → position, heading as written, unit


def read_responses(data: bytes, file: str, name: str) -> tuple[Record, ...]:
    """The records of a CSV file, in the order of the file; `file` names it in errors, `name` begins theirs.

    A column `record` (or `file`, `run`, `name`) tells records apart, a change of `amplitude` too.

    Raises:
        InputError: file, line and column of the first fault, what was expected, what to do.
    """
    columns: Columns | None = None
    found: dict[tuple[str, Fraction | None], list[Sample]] = {}
    for line, cells in rows(decode(data, file), file):
        if columns is None:
            columns = _columns(cells, line)
            continue
        count = len({position for position, *_ in columns.values()})
        hint = "; write decimals with a point" if len(cells) > count else ""
        require(len(cells) == count, f"expected {count} columns as in the heading; found {len(cells)}{hint}", line)
        label = cells[columns["record"][0]] if "record" in columns else ""
        named = len(label) <= 200 and label.isprintable()
        require(named, f"expected the name of a record; found {shown(label)}; write it in one line", line)
        amplitude = _positive(columns, "amplitude", cells, line) if "amplitude" in columns else None
        samples = found.setdefault((label, amplitude), [])
        sample = _sample(columns, cells, line)
        _demand_increasing(samples, sample, columns, line)
        samples.append(sample)
    require(bool(found), f"expected a heading and rows; found none; {_EXAMPLE}", Location(file, 1))
    require(len(found) <= MAX_RECORDS, f"expected at most {MAX_RECORDS} records; found {len(found)}", Location(file))
    records = [Record(_name(name, *key, found), tuple(samples), key[1]) for key, samples in found.items()]
    for record in records:
        message = f"expected at least two frequencies of a record; found one of {shown(record.name)}"
        require(len(record.samples) > 1, f"{message}; a bound says nothing between points that are not there", line)
    return tuple(records)


def _columns(cells: list[str], line: Location) -> Columns:
    found: dict[str, tuple[int, str, str]] = {}
    for position, cell in enumerate(cells):
        kind, unit = _heading(cell, line)
        require(kind not in found, f"expected one column {kind}; found a second one, {shown(cell)}; keep one", line)
        found[kind] = (position, cell, unit)
    pairs = [pair for pair in (("real", "imaginary"), ("gain", "phase")) if any(kind in found for kind in pair)]
    wanted = "expected a column frequency and either real and imaginary, or gain and phase"
    require("frequency" in found, f"{wanted}; frequency is missing; {_EXAMPLE}", line)
    require(len(pairs) < 2, f"{wanted}; found some of both; keep one pair", line)
    require(bool(pairs), f"{wanted}; found neither; {_EXAMPLE}", line)
    missing = [kind for kind in pairs[0] if kind not in found]
    require(not missing, f"{wanted}; {' and '.join(missing)} is missing", line)
    return found


def _heading(cell: str, line: Location) -> tuple[str, str]:
    """Which quantity a column holds, in which unit."""
    match = _HEADING.fullmatch(cell)
    word = match[1].lower() if match else ""
    kind = next((kind for kind, names in _NAMES.items() if word in names), None)
    if match is None or kind is None:
        known = ", ".join(_NAMES)
        raise InputError(f"expected a heading, one of {known}; found {shown(cell)}; {_EXAMPLE}", line)
    unit = (match[2] or match[3] or match[4] or "").strip()
    if kind == "amplitude":  # whatever the excitation was measured in
        return kind, unit
    if kind == "frequency" and not unit and word in ("omega", "ω"):
        return kind, "rad/s"
    spelled = {_plain(known): known for known in _UNITS[kind]}
    accepted = ", ".join(known for known in _UNITS[kind] if known) or "none"
    said = f"{shown(unit)} is not a unit of a {kind} here" if unit else "its unit is missing"
    require(_plain(unit) in spelled, f"{shown(cell)}: {said}; use {accepted}, in brackets behind the name", line)
    return kind, spelled[_plain(unit)]


def _plain(unit: str) -> str:
    return re.sub(r"[\s·*]", "", unit).lower()


def _sample(columns: Columns, cells: list[str], line: Location) -> Sample:
    omega = _positive(columns, "frequency", cells, line) * _FREQUENCIES[columns["frequency"][2]]
    coherence = None
    if "coherence" in columns:
        coherence = _value(columns, "coherence", cells, line)
        message = f"expected a coherence from 0 to 1; found {decimal_text(coherence)}; it is a share, not per cent"
        require(0 <= coherence <= 1, message, _at(columns, "coherence", line))
    if "real" in columns:
        re, im = (_value(columns, kind, cells, line) for kind in ("real", "imaginary"))
        return Sample(omega, re, im, coherence=coherence)
    gain, phase = (_value(columns, kind, cells, line) for kind in ("gain", "phase"))
    unit = "rad" if columns["phase"][2] == "rad" else "deg"
    decibels = columns["gain"][2] == "dB"
    message = f"expected a gain ≥ 0; found {decimal_text(gain)}; if it is in decibels, write gain [dB]"
    require(decibels or gain >= 0, message, _at(columns, "gain", line))
    try:
        gain = ratio_of_decibels(gain) if decibels else gain
        re, im = cartesian(gain, phase, cast(Literal["deg", "rad"], unit))
    except ValueError as error:
        raise InputError(str(error), _at(columns, "phase", line)) from None
    return Sample(omega, re, im, error=gain * ERROR, coherence=coherence)


def _demand_increasing(samples: list[Sample], sample: Sample, columns: Columns, line: Location) -> None:
    where = _at(columns, "frequency", line)
    require(len(samples) < _MOST_SAMPLES, f"expected at most {_MOST_SAMPLES} frequencies of a record", where)
    if not samples:
        return
    here, last = (decimal_text(s.omega) for s in (sample, samples[-1]))
    found = f"found {here} after {last} rad/s"
    advice = "if a new record begins here, tell records apart by a column `record`"
    require(sample.omega != samples[-1].omega, f"expected each frequency once in a record; {found}; {advice}", where)
    message = f"expected frequencies that increase within a record; {found}; sort the rows, or {advice}"
    require(sample.omega > samples[-1].omega, message, where)


def _positive(columns: Columns, kind: str, cells: list[str], line: Location) -> Fraction:
    value = _value(columns, kind, cells, line)
    article = "an" if kind == "amplitude" else "a"
    require(value > 0, f"expected {article} {kind} > 0; found {decimal_text(value)}", _at(columns, kind, line))
    return value


def _value(columns: Columns, kind: str, cells: list[str], line: Location) -> Fraction:
    position, heading, _ = columns[kind]
    return number(cells[position], line, heading)


def _at(columns: Columns, kind: str, line: Location) -> Location:
    return Location(line.file, line.line, key=columns[kind][1])


def _name(file: str, label: str, amplitude: Fraction | None, every: Iterable[tuple[str, Fraction | None]]) -> str:
    """File and record; with the amplitude where only that tells records of the file apart."""
    name = f"{file}:{label}" if label else file
    alone = sum(other == label for other, _ in every) == 1
    return name if alone or amplitude is None else f"{name} at {decimal_text(amplitude)}"
