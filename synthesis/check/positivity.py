"""Exact positivity of polynomials and of `Σ √a_i < √b` on an interval: Bernstein cells, squares, common factors."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from math import comb, isqrt, lcm, prod
from operator import mul
from typing import Literal

from .outcome import Clock
from .polynomials import ZERO, Poly, common_divisor, derivative, mobius, primitive, product, quotient, size

Point = tuple[int, int]  # x = p/q with q >= 0; (1, 0) is infinity
Row = list[int]  # coefficients in x with a formal degree, or Bernstein coefficients on a cell
Group = list[Row]  # rows over t (one, or three) of one polynomial
Cell = tuple[list[Group], Point, Point, int]

SHALLOW, DEEP = 24, 4000  # depth at which repeated roots are looked for; depth that is never exceeded
CELLS = 40_000


@dataclass(frozen=True)
class Result:
    """Proven, refuted (with a point x, if one was found where the inequality fails) or undecided."""

    status: Literal["proven", "refuted", "undecided"]
    at: Point | None = None


@dataclass(frozen=True)
class Inequality:
    """`Σ √terms < √bound` (strict) or `≤`, polynomials in x = ω² that are ≥ 0 wherever a root of them is meant.

    Each entry has one row, or three: then it is `r0(x)(1−t)² + 2 r1(x) t(1−t) + r2(x) t²`, wanted for all t in [0, 1].
    Without terms the inequality is `0 < bound` (or `0 ≤ bound`), and `over` is what the bound was multiplied by: it
    only matters at 0 and ∞, where the leading coefficients are compared.
    """

    terms: tuple[tuple[Poly, ...], ...]
    bound: tuple[Poly, ...]
    strict: bool
    over: Poly = ZERO

    def integers(self) -> tuple[list[list[Row]], list[Row]]:
        """Integer coefficients over one denominator, common powers of x removed, padded to one formal degree."""
        groups = [*self.terms, self.bound]
        compared = [p for group in groups for p in group if p.c]
        if self.strict and self.over.c:
            compared.append(self.over)
        d = lcm(*(p.d for p in compared))
        low = min((next(k for k, a in enumerate(p.c) if a) for p in compared), default=0)
        top = max((p.degree for p in compared), default=0)
        rows = [[[a * (d // p.d) for a in p.c[low:]] for p in group] for group in groups]
        rows = [[row + [0] * (top - low + 1 - len(row)) for row in group] for group in rows]
        return rows[:-1], rows[-1]


def decide(inequality: Inequality, lo: Point, hi: Point, clock: Clock) -> Result:
    """Prove or refute the inequality on [lo, hi], infinity included."""
    terms, bound = inequality.integers()
    if len(bound) == 3 or len(terms) > 2:
        return _cover(terms, bound, lo, hi, clock)
    for condition in _conditions([term[0] for term in terms], bound[0]):
        result = positive(condition, lo, hi, inequality.strict, clock)
        if result.status != "proven":
            return result
    return Result("proven")


def holds_at(inequality: Inequality, x: Point) -> bool | None:
    """Truth of a one-row inequality at a rational point; None when the square roots are too close to tell."""
    terms, bound = inequality.integers()
    a, b = [value(term[0], x) for term in terms], value(bound[0], x)
    if len(a) <= 2:
        conditions = [c[0] for c in _conditions([[u] for u in a], [b])]
        return all(c > 0 or (c == 0 and not inequality.strict) for c in conditions)
    for bits in (0, 128, 1024, 8192):
        lower = sum(isqrt(u << bits) for u in a)
        if (lower + len(a)) ** 2 < b << bits:
            return True
        if lower**2 > b << bits:
            return False
    return None


def value(row: Row, x: Point) -> int:
    """`q^n p(x)` for x = p/q: the sign of the row at x, by its leading coefficient at infinity."""
    out, power = 0, 1
    for a in reversed(row):
        out, power = out * x[0] + a * power, power * x[1]
    return out


def _conditions(terms: list[Row], bound: Row) -> list[Row]:
    """`√a < √b` is `b − a > 0`; `√a1 + √a2 < √b` is `h = b − a1 − a2 > 0` and `h² − 4 a1 a2 > 0`."""
    rest = [b - sum(a) for b, *a in zip(bound, *terms, strict=True)]
    if len(terms) < 2:
        return [rest]
    return [rest, [u - 4 * w for u, w in zip(product(rest, rest), product(*terms), strict=True)]]


def positive(p: Row, lo: Point, hi: Point, strict: bool, clock: Clock) -> Result:
    """p > 0 (strict) or p ≥ 0 on [lo, hi], p with its formal degree; decided exactly but for the work limits.

    A root that only touches never lets subdivision end. Then the repeated factors decide: p > 0 iff its squarefree part
    has no root there, p ≥ 0 iff the product of its factors of odd multiplicity is ≥ 0.
    """
    if not any(p):
        return Result("refuted", lo) if strict else Result("proven")
    result = _cover([], [p], lo, hi, clock, strict=strict, depth=SHALLOW)
    if result.status != "undecided":
        return result
    whole = primitive(p)
    repeated = common_divisor(whole, derivative(whole))
    if len(repeated) == 1:
        return _cover([], [p], lo, hi, clock, strict=strict)
    part = quotient(whole, repeated) if strict else _odd_part(whole, repeated)
    sign = value(part, lo) if strict else part[-1] * whole[-1]
    return _cover([], [part if sign > 0 else [-a for a in part]], lo, hi, clock, strict=strict)


def _odd_part(p: Row, repeated: Row) -> Row:
    """Product of the factors of odd multiplicity (Yun)."""
    odd, distinct, multiplicity = [1], quotient(p, repeated), 1
    while len(distinct) > 1:
        following = common_divisor(distinct, repeated)
        if multiplicity % 2:
            odd = product(odd, quotient(distinct, following))
        distinct, repeated, multiplicity = following, quotient(repeated, following), multiplicity + 1
    return odd


def _aligned(lo: Point, hi: Point, p: Row) -> tuple[Point, Point]:
    """Homogeneous coordinates whose sum is a sensible middle: the mean, or the scale of p's roots towards infinity."""
    if hi[1]:
        return (lo[0] * hi[1], lo[1] * hi[1]), (hi[0] * lo[1], hi[1] * lo[1])
    low, top = next((k for k, a in enumerate(p) if a), 0), max((k for k, a in enumerate(p) if a), default=0)
    scale = (p[low].bit_length() - p[top].bit_length()) // (top - low) if top > low else 0
    scale = max(-300, min(300, scale))
    return (lo[0] << max(-scale, 0), lo[1] << max(-scale, 0)), (lo[1] << max(scale, 0), 0)


def bernstein(p: Row, lo: Point, hi: Point) -> Row:
    """Bernstein coefficients of p on [lo, hi] (projective), times a positive number that depends on len(p) only."""
    n = len(p) - 1
    scale = lcm(*(comb(n, k) for k in range(n + 1)))
    return [a * (scale // comb(n, k)) for k, a in enumerate(mobius(p, *lo, *hi))]


def halve(b: Row) -> tuple[Row, Row]:
    """De Casteljau at the middle; both halves are scaled by 2^n."""
    n = len(b) - 1
    first, second, row = [b[0] << n], [b[-1] << n], b
    for k in range(1, n + 1):
        row = [u + w for u, w in pairwise(row)]
        first.append(row[0] << (n - k))
        second.append(row[-1] << (n - k))
    return first, second[::-1]


def _cover(
    terms: list[Group], bound: Group, lo: Point, hi: Point, clock: Clock, *, strict: bool = True, depth: int = DEEP
) -> Result:
    """`Σ √a_i < √b` on cells in x (and t): by Cauchy-Schwarz it follows from `b·Πw > Σ a_i Σw Πw/w_i`, any w_i > 0.

    With w_i in proportion to √a_i the two are equivalent, so weights from the cell's mean values prove any strict
    inequality on small enough cells: there all Bernstein coefficients are ≥ 0 (at the corners > 0 if strict). A corner
    where the inequality itself fails refutes.
    """
    lo, hi = _aligned(lo, hi, bound[-1])
    cells: list[Cell] = [([[bernstein(row, lo, hi) for row in group] for group in (*terms, bound)], lo, hi, 0)]
    for _ in range(CELLS):
        clock.tick()
        groups, left, right, level = cells.pop()
        for end, at in ((0, left), (-1, right)):
            if any(_fails([group[row][end] for group in groups], strict) for row in (0, -1)):
                return Result("refuted", at)
        slack = _slack(groups)
        corners = min(row[end] for row in (slack[0], slack[-1]) for end in (0, -1))
        if min(map(min, slack)) < 0 or (strict and corners == 0):
            if level == depth:
                return Result("undecided")
            cells += _split(groups, slack, left, right, level + 1)
        if not cells:
            return Result("proven")
    return Result("undecided")


def _slack(groups: list[Group]) -> Group:
    """Bernstein rows of `b·Πw − Σ a_i Σw Πw/w_i`."""
    *terms, bound = groups
    if not terms:
        return bound
    roots = [isqrt(max(sum(map(sum, term)), 0)) for term in terms]
    excess = max(size(roots) - 24, 0)
    weights = [(root >> excess) + 1 for root in roots]
    whole, total = prod(weights), sum(weights)
    factors = [-total * (whole // w) for w in weights]
    columns = [zip(*rows, strict=True) for rows in zip(bound, *terms, strict=True)]
    return [[whole * b + sum(map(mul, factors, a)) for b, *a in column] for column in columns]


def _fails(values: list[int], strict: bool) -> bool:
    """Whether `Σ √a_i < √b` is false for certain (roots rounded down)."""
    *a, b = values
    return sum(isqrt(u << 128) for u in a) ** 2 >= b << 128 if a else b < strict


def _split(groups: list[Group], slack: Group, left: Point, right: Point, level: int) -> list[Cell]:
    """Halve the direction in which the slack varies more."""
    along_x = max(max(row) - min(row) for row in slack)
    along_t = max(max(column) - min(column) for column in _transposed(slack))
    if along_t > along_x:
        groups = [_transposed(group) for group in groups]
    rows = [[halve(row) for row in group] for group in groups]
    first, second = ([[pair[k] for pair in group] for group in rows] for k in (0, 1))
    if along_t > along_x:
        return [([_transposed(group) for group in half], left, right, level) for half in (first, second)]
    middle = (left[0] + right[0], left[1] + right[1])
    left, right = (2 * left[0], 2 * left[1]), (2 * right[0], 2 * right[1])  # the scale that the middle has
    return [(second, middle, right, level), (first, left, middle, level)]


def _transposed(group: Group) -> Group:
    return [list(column) for column in zip(*group, strict=True)]


def square(omega: Fraction | None) -> Point:
    """x = ω² of a frequency; None is infinity."""
    return (1, 0) if omega is None else (omega.numerator**2, omega.denominator**2)
