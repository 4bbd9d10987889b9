"""Exact Hurwitz tests by Routh's table in rationals."""

from __future__ import annotations

from flint import fmpq, fmpq_poly

from .roots import complex_roots


def is_hurwitz(p: fmpq_poly, decay: fmpq | int = 0) -> bool:
    """Whether every root of p has real part < −decay: Routh's first column of p(s − decay) keeps one strict sign."""
    if p.degree() < 0:
        return False
    shifted = p(fmpq_poly([-decay, 1])).coeffs()[::-1]
    sign = 1 if shifted[0] > 0 else -1
    above, row = [sign * c for c in shifted[0::2]], [sign * c for c in shifted[1::2]]
    for _ in range(len(shifted) - 1):
        if not row or row[0] <= 0:
            return False
        ratio = above[0] / row[0]
        padded = row[1:] + [fmpq(0)] * (len(above) - len(row))
        above, row = row, [a - ratio * b for a, b in zip(above[1:], padded, strict=True)]
    return True


def decay_rate(p: fmpq_poly) -> float:
    """`−max Re(root)`, where to look for the proven figure; 0 for a constant, which has no root to look at."""
    return -max((float(root.real.mid()) for root, _ in complex_roots(p)), default=0.0)
