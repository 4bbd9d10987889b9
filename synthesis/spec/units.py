"""Units of every physical key: what each is worth in SI with rad/s, exactly.

A bare number is SI. Two factors are irrational: 2π (Hz to rad/s) and 180/π (per degree to per radian). They stand
here as decimals of 25 significant digits, so `40 Hz` *is* 40·6.283185307179586476925287 rad/s: the canonical
specification holds that rational number, and what is proven is proven for it. It is within 1e-24 of the ideal value.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from typing import Literal

from .exact import NUMBER, bounded, misread, parse_number

TWO_PI = Fraction("6.283185307179586476925287")
DEGREES_PER_RADIAN = Fraction("57.29577951308232087679815")
_MILLI, _CENTI2, _KILO = Fraction(1, 1000), Fraction(1, 10_000), Fraction(1000)

_QUANTITY = re.compile(rf"({NUMBER})\s*(.*)", re.DOTALL)
_PERCENT = re.compile(r"(.*?)\s*(?:±|\+-|\+/-)\s*(.*?)\s*%", re.DOTALL)


@dataclass(frozen=True)
class Dimension:
    """A physical quantity and its accepted units, SI first; no units: a plain number."""

    name: str
    units: Mapping[str, Fraction]

    @property
    def accepted(self) -> str:
        """The units as a list for an error message or a schema."""
        return ", ".join(self.units)


@dataclass(frozen=True)
class Mechanics:
    """The three dimensions whose units depend on whether the joint turns or slides."""

    inertia: Dimension
    damping: Dimension
    stiffness: Dimension


_ROTARY = Mechanics(
    Dimension("an inertia", {"kg·m²": Fraction(1), "g·m²": _MILLI, "kg·cm²": _CENTI2, "g·cm²": _MILLI * _CENTI2}),
    Dimension(
        "a damping",
        {"N·m·s/rad": Fraction(1), "N·m·s": Fraction(1), "mN·m·s/rad": _MILLI, "N·m·s/deg": DEGREES_PER_RADIAN},
    ),
    Dimension(
        "a stiffness",
        {"N·m/rad": Fraction(1), "mN·m/rad": _MILLI, "kN·m/rad": _KILO, "N·m/deg": DEGREES_PER_RADIAN},
    ),
)
_LINEAR = Mechanics(
    Dimension("an inertia", {"kg": Fraction(1), "g": _MILLI}),
    Dimension("a damping", {"N·s/m": Fraction(1), "kN·s/m": _KILO, "N·s/mm": _KILO}),
    Dimension("a stiffness", {"N/m": Fraction(1), "kN/m": _KILO, "N/mm": _KILO}),
)
MECHANICS: Mapping[Literal["rotary", "linear"], Mechanics] = {"rotary": _ROTARY, "linear": _LINEAR}

FREQUENCY = Dimension("an angular frequency", {"rad/s": Fraction(1), "Hz": TWO_PI, "kHz": TWO_PI * _KILO})
RATE = Dimension("a sampling rate", {"Hz": Fraction(1), "kHz": _KILO})  # samples per second: no factor 2π
TIME = Dimension("a time", {"s": Fraction(1), "ms": _MILLI, "us": _MILLI * _MILLI})
RATIO = Dimension("a ratio", {"%": Fraction(1, 100)})
PLAIN = Dimension("a plain number", {})


def parse_quantity(text: str, dimension: Dimension) -> Fraction:
    """The value in SI of a number with or without a unit of `dimension`.

    Raises:
        ValueError: with advice for the person who wrote it.
    """
    text = text.strip()
    match = _QUANTITY.fullmatch(text)
    # What only looks like a number is told apart before its tail is taken for a unit ("0x10", "1_000").
    if not match or misread(text) or re.match(r"[0-9.+/*^:(-]", match[2]):
        return parse_number(text)
    value = parse_number(match[1])
    if not match[2]:
        return value
    factors = {_plain(unit): factor for unit, factor in dimension.units.items()}
    if _plain(match[2]) in factors:
        return bounded(value * factors[_plain(match[2])])
    if dimension is RATIO and match[2] == "dB":
        raise ValueError(f"decibels are irrational numbers: write {_from_decibels(value)}")
    units = f"use one of {dimension.accepted}, or a bare number in SI" if dimension.units else "write a bare number"
    raise ValueError(f"{match[2][:20]!r} is not a unit of {dimension.name} here: {units}")


def parse_tolerance(text: str) -> tuple[str, Fraction] | None:
    """What stands before `±p %`, and p as a fraction of one; None where the text has no tolerance.

    Raises:
        ValueError: with advice, where the text is a tolerance without a usable number.
    """
    match = _PERCENT.fullmatch(text.strip())
    return (match[1], parse_number(match[2]) / 100) if match else None


def _plain(unit: str) -> str:
    """Spelling aside: `kg*m^2`, `kg m²` and `kg·m²` are one unit."""
    return re.sub(r"[\s·⋅*]", "", unit).replace("²", "2").replace("^", "").replace("µ", "u").replace("μ", "u")


def _from_decibels(value: Fraction) -> str:
    if abs(value) > 200:
        return "the ratio itself, 10^(dB/20)"
    ratio = Decimal(10) ** (Decimal(value.numerator) / Decimal(value.denominator) / 20)
    return f"{ratio:.4g} (= 10^({float(value):g}/20))"
