"""One axis of a map: a specification key and the values it takes, `A:B:N` or `A:B:N:log`."""

from __future__ import annotations

import re
from dataclasses import dataclass
from decimal import Context, Decimal
from fractions import Fraction

from ..errors import InputError, Location
from ..spec.exact import parse_number

MOST_VALUES = 200
_DIGITS = Context(prec=6)  # of the values between the ends: a map samples the plane, and short numbers read better
_KEY = re.compile(r"[a-z_0-9]+(\.[a-z_0-9]+)+")


@dataclass(frozen=True)
class Axis:
    """A dotted key (`impedance.stiffness`) and its values in SI, as exact text."""

    key: str
    values: tuple[str, ...]
    logarithmic: bool = False

    @classmethod
    def parse(cls, key: str, text: str) -> Axis:
        """From `A:B:N` (linear) or `A:B:N:log`: N values from A to B, those between rounded to 6 digits.

        Raises: InputError.
        """
        where = Location(f"{key}={text}"[:100])
        if not _KEY.fullmatch(key):
            raise InputError("expected a key such as impedance.stiffness before the equals sign", where)
        parts = text.split(":")
        if len(parts) not in (3, 4) or parts[3:] not in ([], ["log"]):
            raise InputError("expected A:B:N or A:B:N:log, such as 0.5:10:20", where)
        try:
            low, high = (parse_number(part.strip()) for part in parts[:2])
        except ValueError as error:
            raise InputError(f"expected numbers A and B in SI: {error}", where) from None
        if not parts[2].isascii() or not parts[2].isdigit() or not 2 <= int(parts[2][:9]) <= MOST_VALUES:
            raise InputError(f"expected a whole number N of values from 2 to {MOST_VALUES}", where)
        if low >= high:
            raise InputError("expected A < B", where)
        if parts[3:] and low <= 0:
            raise InputError("expected A > 0 on a logarithmic axis", where)
        return cls(key, tuple(_between(low, high, int(parts[2]), bool(parts[3:]))), bool(parts[3:]))

    @classmethod
    def assignment(cls, text: str) -> Axis:
        """From `KEY=A:B:N`. Raises: InputError."""
        key, equals, values = text.partition("=")
        if not equals:
            raise InputError("expected KEY=A:B:N, such as impedance.stiffness=0.5:10:20", Location(text[:100]))
        return cls.parse(key.strip(), values)

    @property
    def floats(self) -> list[float]:
        """The values, to draw."""
        return [float(Fraction(value)) for value in self.values]

    def to_json(self) -> dict[str, object]:
        """As it stands in the files of a map."""
        return {"key": self.key, "values": list(self.values), "scale": "log" if self.logarithmic else "linear"}


def _between(low: Fraction, high: Fraction, n: int, logarithmic: bool) -> list[str]:
    if logarithmic:
        ratio = float(high / low) ** (1 / (n - 1))
        inner = [low * Fraction(ratio**k) for k in range(1, n - 1)]
    else:
        inner = [low + (high - low) * k / (n - 1) for k in range(1, n - 1)]
    return [str(low), *(_short(value) for value in inner), str(high)]


def _short(value: Fraction) -> str:
    return f"{_DIGITS.divide(Decimal(value.numerator), Decimal(value.denominator)).normalize():f}"
