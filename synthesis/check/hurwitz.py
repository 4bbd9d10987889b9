"""Hurwitz test with a decay rate: fraction-free Routh array."""

from __future__ import annotations

from fractions import Fraction
from math import gcd

from .outcome import Clock
from .polynomials import Poly, mobius


def decays_faster(p: Poly, rate: Fraction, clock: Clock) -> bool:
    """Whether every root of p has Re s < −rate [1/s]: p(s − rate) has a strictly positive first Routh column.

    Each row is divided by the (positive) gcd of its entries, which keeps the signs and holds the growth. A zero in the
    first column, hence also a zero row, means "not Hurwitz".
    """
    if not p.c:
        return False
    shifted = mobius(p.c, -rate.numerator, rate.denominator, rate.denominator, 0)[::-1]
    if shifted[0] < 0:
        shifted = [-a for a in shifted]
    if min(shifted) <= 0:
        return False
    upper, lower = shifted[0::2], shifted[1::2]
    while lower:
        clock.tick()
        if lower[0] <= 0:
            return False
        padded = [*lower, *[0] * (len(upper) - len(lower))]
        following = [lower[0] * upper[k] - upper[0] * padded[k] for k in range(1, len(upper))]
        common = gcd(*following) or 1
        upper, lower = lower, [entry // common for entry in following]
    return True
