"""Gain and phase to real and imaginary part, in decimal arithmetic: the same digits on every machine."""

from __future__ import annotations

from decimal import Context, Decimal, localcontext
from fractions import Fraction
from typing import Literal

DIGITS = 40
ERROR = Fraction(1, 10**30)  # of the gain: what the arithmetic here may be wrong by, with room to spare
MOST_TURNS = 10**6
MOST_DECIBELS = 400

_PI = Fraction("3.14159265358979323846264338327950288419716939937510582097494459")
_WORK = Context(prec=DIGITS + 15)


def ratio_of_decibels(value: Fraction) -> Fraction:
    """`10^(dB/20)`. Raises: ValueError beyond ±400 dB."""
    if abs(value) > MOST_DECIBELS:
        raise ValueError(f"expected at most {MOST_DECIBELS} dB: write the ratio itself, without unit")
    with localcontext(_WORK):
        return Fraction(Decimal(10) ** (Decimal(value.numerator) / Decimal(value.denominator) / 20))


def cartesian(gain: Fraction, phase: Fraction, unit: Literal["deg", "rad"]) -> tuple[Fraction, Fraction]:
    """Real and imaginary part, each within ERROR·gain. Raises: ValueError for a phase of more than a million turns."""
    turns = phase / 360 if unit == "deg" else phase / (2 * _PI)
    if abs(turns) > MOST_TURNS:
        raise ValueError("expected a phase of less than a million turns")
    angle = (turns - round(turns)) * 2 * _PI  # within ±π
    with localcontext(_WORK):
        x = Decimal(angle.numerator) / Decimal(angle.denominator)
        term, sums = Decimal(1), [Decimal(0), Decimal(0), Decimal(0), Decimal(0)]
        n = 0
        while term == 1 or abs(term) > Decimal(10) ** -(DIGITS + 10):  # Taylor's series, one sum for each power of j
            sums[n % 4] += term
            n += 1
            term = term * x / n
        cos, sin = (round(+part, DIGITS) for part in (sums[0] - sums[2], sums[1] - sums[3]))
    return gain * Fraction(cos), gain * Fraction(sin)
