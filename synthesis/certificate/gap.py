"""How far a sum of square roots stays below its right side at a point, in ball arithmetic."""

from __future__ import annotations

from dataclasses import replace

from flint import arb, arb_poly, fmpq_poly

from .bivariate import Bivariate, degree
from .lowering import SumOfRoots


def gap(inequality: SumOfRoots, x: arb, t: arb) -> arb:
    """Right minus left side at x and t: an enclosure."""
    right = _value(inequality.right, x, t)
    if inequality.squared:
        right = right.nonnegative_part().sqrt()
    return right - sum((_value(p, x, t).nonnegative_part().sqrt() for p in inequality.radicands), arb(0))


def reversed_sides(inequality: SumOfRoots) -> SumOfRoots:
    """The same inequality in y = 1/x, multiplied by a power of y."""
    weight = 1 if inequality.squared else 2
    D = max(degree(*inequality.radicands), weight * degree(inequality.right))
    D += D % weight

    def flip(p: Bivariate, n: int) -> Bivariate:
        return tuple(fmpq_poly([c[k] for k in range(n, -1, -1)]) for c in p)

    return replace(
        inequality,
        radicands=tuple(flip(p, D) for p in inequality.radicands),
        right=flip(inequality.right, D // weight),
    )


def _value(p: Bivariate, x: arb, t: arb) -> arb:
    total = arb(0)
    for c in p[::-1]:
        total = total * t + arb_poly(c)(x)
    return total
