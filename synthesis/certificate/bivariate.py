"""Polynomials in x = ω² and t ∈ [0, 1], the place on a segment of loads: tuples of coefficients of powers of t."""

from __future__ import annotations

from itertools import pairwise
from math import comb

from flint import fmpq, fmpq_poly

Bivariate = tuple[fmpq_poly, ...]


def times(p: Bivariate, q: Bivariate) -> Bivariate:
    """p·q."""
    product_ = [fmpq_poly([0])] * (len(p) + len(q) - 1)
    for i, a in enumerate(p):
        for j, b in enumerate(q):
            product_[i + j] = product_[i + j] + a * b
    return tuple(product_)


def degree(*polynomials: Bivariate) -> int:
    """Largest degree in x."""
    return max((c.degree() for p in polynomials for c in p), default=-1)


def valuation(p: Bivariate) -> int:
    """Largest power of x that divides p."""
    return min(next(k for k, c in enumerate(q.coeffs()) if c != 0) for q in p if q.degree() >= 0)


def minus(p: Bivariate, q: Bivariate) -> Bivariate:
    """p − q."""
    n, zero = max(len(p), len(q)), fmpq_poly([0])
    pad = [(*r, *(zero,) * (n - len(r))) for r in (p, q)]
    return tuple(a - b for a, b in zip(*pad, strict=True))


def shift(p: Bivariate, k: int) -> Bivariate:
    """p/x^k, for k up to the valuation."""
    return tuple(fmpq_poly(c.coeffs()[k:]) for c in p)


def bernstein(p: Bivariate) -> Bivariate:
    """Bernstein coefficients in t on [0, 1] of a polynomial given by powers of t."""
    n = len(p) - 1
    return tuple(sum((p[i] * fmpq(comb(k, i), comb(n, i)) for i in range(k + 1)), fmpq_poly([0])) for k in range(n + 1))


def halves(b: Bivariate) -> tuple[Bivariate, Bivariate]:
    """De Casteljau at t = 1/2."""
    row, left, right = list(b), [b[0]], [b[-1]]
    while len(row) > 1:
        row = [(p + q) / 2 for p, q in pairwise(row)]
        left.append(row[0])
        right.insert(0, row[-1])
    return tuple(left), tuple(right)
