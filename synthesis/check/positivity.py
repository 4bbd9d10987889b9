"""Exact positivity of polynomials and of `Σ √a_i < √b` on an interval: Bernstein cells, squares, common factors."""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from math import comb, inf, lcm
from typing import Any

from .outcome import UNDECIDED, CheckError, demand, tick
from .polynomials import PRIME, ZERO, Row, common_divisor, mobius, primitive, product, quotient

Point = tuple[int, int]  # x = p/q with q >= 0; (1, 0) is infinity
SHALLOW, DEEP, CELLS = 24, 4000, 40_000  # depth at which repeated roots are looked for; limits of depth and number


@dataclass(frozen=True)
class Inequality:
    """`Σ √terms < √bound` (strict) or `≤`, for quantities ≥ 0 where a root of them is meant; or `0 < bound`.

    They are polynomials in x = ω², or forms on a cell. `over` is what a bound without terms was multiplied by; at 0 and
    ∞, where leading coefficients are compared, it matters."""

    terms: Sequence[Any]
    bound: Any
    strict: bool = True
    over: Any = ZERO

    def rows(self) -> list[Row]:
        """Polynomial terms that do not vanish, then the bound, over one denominator: common powers of x removed."""
        rows = [*(p for p in self.terms if p.c), self.bound]
        compared = [p for p in (*rows, *[self.over] * self.strict) if p.c]
        d = lcm(*(p.d for p in compared))
        low = min((next(k for k, a in enumerate(p.c) if a) for p in compared), default=0)
        top = max((len(p.c) for p in compared), default=1)
        return [[a * (d // p.d) for a in (p.c + (0,) * (top - len(p.c)))[low:]] for p in rows]


def square(omega: Fraction | float) -> Point:
    """x = ω² of a frequency, a Fraction or inf."""
    return (1, 0) if omega == inf else (Fraction(omega).numerator ** 2, Fraction(omega).denominator ** 2)


def counterexample(inequality: Inequality, lo: Point, hi: Point, deadline: float) -> Point | None:
    """A point of [lo, hi] where an inequality with at most two roots is false; None: it is proven. Or CheckError.

    `√a < √b` is `b − a > 0`; `√a1 + √a2 < √b` is `h = b − a1 − a2 > 0` and `h² − 4 a1 a2 > 0`."""
    *terms, bound = inequality.rows()
    demand(len(terms) <= 2, "more than two roots", UNDECIDED)
    conditions = [[b - sum(a) for b, *a in zip(bound, *terms, strict=True)]]
    if len(terms) == 2:
        square, both = product(conditions[0], conditions[0]), product(*terms)
        conditions.append([u - 4 * w for u, w in zip(square, both, strict=True)])
    found = (failure(row, lo, hi, inequality.strict, deadline) for row in conditions)
    return next((at for at in found if at is not None), None)


def failure(p: Row, lo: Point, hi: Point, strict: bool, deadline: float) -> Point | None:
    """A point of [lo, hi] where not p > 0 (strict), or not p ≥ 0; None if there is none. p has its formal degree."""
    try:
        return _cover(p, lo, hi, deadline, strict, SHALLOW)
    except CheckError:  # a root that only touches never lets halving end: go on without repeated roots
        return _cover(_simple(p, lo, strict, deadline), lo, hi, deadline, strict)


def _simple(p: Row, lo: Point, strict: bool, deadline: float) -> Row:
    """p with all roots once and its sign at lo (strict), or with those of odd multiplicity once and its sign."""
    p = primitive(p)
    derivative = [k * a for k, a in enumerate(p)][1:]
    if p[-1] % PRIME and len(common_divisor(p, derivative, deadline, PRIME)) == 1:
        return p  # the degree of a common divisor can only grow modulo a prime
    repeated = common_divisor(p, derivative, deadline)
    squarefree = quotient(p, repeated)
    if strict:
        return squarefree if mobius(squarefree, *lo, *lo)[0] > 0 else [-a for a in squarefree]
    double = common_divisor(squarefree, repeated, deadline)
    return p if len(repeated) == 1 else _simple(quotient(p, product(double, double)), lo, strict, deadline)


def bernstein(p: Row, lo: Point, hi: Point) -> Row:
    """Bernstein coefficients of p on [lo, hi] (projective), times a positive number that depends on len(p) only."""
    n = len(p) - 1
    scale = lcm(*(comb(n, k) for k in range(n + 1)))
    return [a * (scale // comb(n, k)) for k, a in enumerate(mobius(p, *lo, *hi))]


def _cover(p: Row, lo: Point, hi: Point, deadline: float, strict: bool, depth: int = DEEP) -> Point | None:
    """Halve cells until all coefficients are ≥ 0 (strict: > 0 at the ends), or an end fails."""
    lo, hi = _aligned(lo, hi, p)
    cells: list[tuple[Row, Point, Point, int]] = [(bernstein(p, lo, hi), lo, hi, 0)]
    for _ in range(CELLS):
        tick(deadline)
        row, left, right, level = cells.pop()
        if row[0] < strict or row[-1] < strict:
            return left if row[0] < strict else right
        if min(row) < 0:
            if level == depth or lo == hi:
                break
            middle = (left[0] + right[0], left[1] + right[1])
            left, right = (2 * left[0], 2 * left[1]), (2 * right[0], 2 * right[1])  # the scale of the middle
            first, second = _halves(row)
            cells += [(second, middle, right, level + 1), (first, left, middle, level + 1)]
        if not cells:
            return None
    raise CheckError(UNDECIDED, "neither proven nor refuted")


def one_is_positive(rows: Sequence[Row], lo: Point, hi: Point, deadline: float) -> bool:
    """Whether at every point of [lo, hi] one of them is: cells are halved until it is the same one on all of each."""
    lo, hi = _aligned(lo, hi, max(rows, key=len))
    cells = [([bernstein(row, lo, hi) for row in rows], 0)]
    while cells:
        tick(deadline)
        found, level = cells.pop()
        if not any(min(row) >= 0 and row[0] and row[-1] for row in found):
            if level == SHALLOW or any(all(row[end] <= 0 for row in found) for end in (0, -1)):
                return False
            cells += [([*half], level + 1) for half in zip(*map(_halves, found), strict=True)]
    return True


def _aligned(lo: Point, hi: Point, p: Row) -> tuple[Point, Point]:
    """Homogeneous coordinates whose sum is a sensible middle: the mean, or the scale of p's roots towards infinity."""
    if lo == hi:
        return lo, hi
    if hi[1]:
        return (lo[0] * hi[1], lo[1] * hi[1]), (hi[0] * lo[1], hi[1] * lo[1])
    support = [k for k, a in enumerate(p) if a] or [0]
    low, top = support[0], support[-1]
    scale = max(-300, min(300, (p[low].bit_length() - p[top].bit_length()) // max(top - low, 1)))
    return (lo[0] << max(-scale, 0), lo[1] << max(-scale, 0)), (lo[1] << max(scale, 0), 0)


def _halves(row: Row) -> tuple[Row, Row]:
    """De Casteljau at the middle; both halves are scaled by 2^n."""
    n = len(row) - 1
    first, second = [row[0] << n], [row[-1] << n]
    for k in reversed(range(n)):
        row = [u + w for u, w in pairwise(row)]
        first.append(row[0] << k)
        second.append(row[-1] << k)
    return first, second[::-1]
