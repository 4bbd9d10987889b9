"""Records from files a user names, and from `control.FRD` objects."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

from ..errors import InputError, Location
from ..spec.data_file import read_bytes
from ..spec.record import Record, Sample
from ..spec.response_file import read_responses


def read_files(paths: Sequence[Path]) -> tuple[Record, ...]:
    """The records of CSV files, named after their files.

    Raises:
        InputError: file, line and column of the first fault.
    """
    stems = [path.stem for path in paths]
    records: list[Record] = []
    for path in paths:
        where = Location(str(path))
        try:
            regular = path.is_file() or not path.exists()  # a pipe would be read for ever
        except (OSError, ValueError) as error:
            raise InputError(f"the file cannot be read: {error}", where) from None
        if not regular:
            raise InputError("expected a CSV file; this is no regular file", where)
        name = path.stem if stems.count(path.stem) == 1 else path.with_suffix("").as_posix()
        records += read_responses(read_bytes(path, where), str(path), name)
    return tuple(records)


def record_of(
    response: Any, name: str, *, amplitude: float | None = None, coherence: Sequence[float] | None = None
) -> Record:
    """A record from a `control.FRD` (`control.FrequencyResponseData`) with one input and one output.

    Its doubles are taken as the exact numbers they are.

    Args:
        response: frequencies in rad/s.
        name: of the record.
        amplitude: of the excitation.
        coherence: (n,), of each frequency.

    Raises:
        InputError: several inputs or outputs, a frequency that is not positive, a number that is not finite, or a
        coherence that is not a share of one for each frequency.
    """
    if not response.issiso():
        raise InputError(f"the response {name!r} has several inputs or outputs; give one of each")
    omega, values = list(response.omega), list(response(1j * response.omega))
    shares = [None] * len(omega) if coherence is None else list(coherence)
    if len(shares) != len(omega):
        raise InputError(f"the response {name!r} has {len(omega)} frequencies and {len(shares)} coherences")
    samples = []
    for w, value, share in zip(omega, values, shares, strict=True):
        numbers = (w, value.real, value.imag, *([] if share is None else [share]))
        if not all(math.isfinite(part) for part in numbers) or w <= 0 or not 0 <= (share or 0) <= 1:
            raise InputError(f"the response {name!r} at {w:g} rad/s: expected a frequency > 0 and finite numbers")
        known = None if share is None else Fraction(float(share))
        at, re, im = (Fraction(float(part)) for part in numbers[:3])
        samples.append(Sample(at, re, im, coherence=known))
    samples.sort(key=lambda sample: sample.omega)
    if len({sample.omega for sample in samples}) < max(len(samples), 2):
        raise InputError(f"the response {name!r} needs at least two frequencies, each once")
    return Record(name, tuple(samples), None if amplitude is None else Fraction(float(amplitude)))
