"""Sums of three or more square roots: adaptive cells in (x, t), enclosed by ball arithmetic."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, cast

from flint import arb, arb_poly, ctx, fmpq, fmpq_poly

from .bivariate import Bivariate, degree
from .lowering import SumOfRoots
from .outcome import Interval, Outcome

MAX_CELLS = 20_000
PRECISION = 192

Cell = tuple[fmpq, fmpq, fmpq, fmpq]  # x from, x to, t from, t to


def holds_on_cells(inequality: SumOfRoots, interval: Interval) -> Outcome:
    """`Σ√A < √B` or `< R` on the closed interval; the part beyond x = 1 (in units of its scale) as 1/x ∈ [0, 1]."""
    low, high = interval
    if high is not None:
        return _subdivide(inequality, (low, high))
    split = max(low, fmpq(1)) * 1024
    outer = _subdivide(reversed_sides(inequality), (fmpq(0), 1 / split))
    return outer if outer is not Outcome.PROVEN else _subdivide(inequality, (low, split))


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


def _subdivide(inequality: SumOfRoots, interval: tuple[fmpq, fmpq]) -> Outcome:
    depends_on_t = max(len(p) for p in (*inequality.radicands, inequality.right)) > 1
    stack: list[Cell] = [(*interval, fmpq(0), fmpq(1))]
    precision, ctx.prec = ctx.prec, PRECISION
    try:
        inequality = _mapped(inequality, _in_balls)
        along_x = _mapped(inequality, lambda p: tuple(c.derivative() for c in p))
        along_t = _mapped(inequality, lambda p: tuple(k * c for k, c in enumerate(p) if k))
        for _ in range(MAX_CELLS):
            if not stack:
                return Outcome.PROVEN
            x0, x1, t0, t1 = stack.pop()
            X, T, x, t = _ball(x0, x1), _ball(t0, t1), _middle(x0, x1), (t0 + t1) / 2
            at_middle = gap(inequality, arb(x), arb(t))
            if at_middle <= 0:
                return Outcome.REFUTED
            centred = at_middle + _slope(inequality, along_x, X, T) * (X - arb(x))
            if depends_on_t:
                centred += _slope(inequality, along_t, X, T) * (T - arb(t))
            if centred > 0 or gap(inequality, X, T) > 0:
                continue
            halves = [(x0, x, t0, t1), (x, x1, t0, t1)]
            if depends_on_t:
                halves = [(a, b, *part) for a, b, _, _ in halves for part in ((t0, t), (t, t1))]
            stack.extend(halves)
        return Outcome.UNDECIDED
    finally:
        ctx.prec = precision


def _in_balls(p: Bivariate) -> Bivariate:
    """Coefficients as balls, converted once and not at every cell."""
    return tuple(cast(Any, arb_poly(c)) for c in p)


def gap(inequality: SumOfRoots, x: arb, t: arb) -> arb:
    """Right minus left side at x and t: an enclosure, for balls of both."""
    right = _value(inequality.right, x, t)
    if inequality.squared:
        right = right.nonnegative_part().sqrt()
    return right - sum((_value(p, x, t).nonnegative_part().sqrt() for p in inequality.radicands), arb(0))


def _mapped(inequality: SumOfRoots, change: Callable[[Bivariate], Bivariate]) -> SumOfRoots:
    """Each polynomial of an inequality changed."""
    return replace(inequality, radicands=tuple(map(change, inequality.radicands)), right=change(inequality.right))


def _slope(inequality: SumOfRoots, derivative: SumOfRoots, x: arb, t: arb) -> arb:
    """Derivative of the gap, `(√p)' = p'/(2√p)`: with the value in the middle it encloses a cell to second order."""

    def of_root(p: Bivariate, slope: Bivariate) -> arb:
        return _value(slope, x, t) / (2 * _value(p, x, t).sqrt())

    right = of_root if inequality.squared else lambda _, slope: _value(slope, x, t)
    roots = (of_root(p, slope) for p, slope in zip(inequality.radicands, derivative.radicands, strict=True))
    return right(inequality.right, derivative.right) - sum(roots, arb(0))


def _value(p: Bivariate, x: arb, t: arb) -> arb:
    total = arb(0)
    for c in p[::-1]:
        total = total * t + arb_poly(c)(x)
    return total


def _ball(low: fmpq, high: fmpq) -> arb:
    return arb(low).union(arb(high))


def _middle(low: fmpq, high: fmpq) -> fmpq:
    """Geometric where the cell spans more than a factor 4, so that decades get cells of their own."""
    if low == 0:
        return high / 4
    return low * 2 if high > 4 * low else (low + high) / 2
