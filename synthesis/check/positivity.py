"""Exact positivity of polynomials and of `Σ √a_i < √b` on an interval: Bernstein cells, squares, common factors."""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from math import comb, inf, isqrt, lcm, prod
from operator import mul

from .outcome import UNDECIDED, CheckError, tick
from .polynomials import PRIME, ZERO, Poly, Row, common_divisor, mobius, primitive, product, quotient, size

Point = tuple[int, int]  # x = p/q with q >= 0; (1, 0) is infinity
Group = Sequence[Row]  # rows over t (one, or three) of one polynomial: in x with a formal degree, or Bernstein's
Cell = tuple[Sequence[Group], Point, Point, int]  # terms and then the bound; its two ends; how often it was halved

SHALLOW, DEEP, CELLS = 24, 4000, 40_000  # depth at which repeated roots are looked for; limits of depth and number
CORNERS = (0, 0), (-1, 0), (0, -1), (-1, -1)  # of a cell: which row in t, which end in x


@dataclass(frozen=True)
class Inequality:
    """`Σ √terms < √bound` (strict) or `≤` for polynomials in x = ω², ≥ 0 where a root of them is meant; or `0 < bound`.

    Three rows instead of one are `r0(x)(1−t)² + 2 r1(x) t(1−t) + r2(x) t²`, wanted for all t in [0, 1]. `over` is what
    a bound without terms was multiplied by; at 0 and ∞, where leading coefficients are compared, it matters.
    """

    terms: Sequence[Sequence[Poly]]
    bound: Sequence[Poly]
    strict: bool = True
    over: Poly = ZERO

    def integers(self) -> list[Group]:
        """Terms that do not vanish, then the bound, over one denominator: common powers of x removed, one degree."""
        groups = [*(term for term in self.terms if any(p.c for p in term)), self.bound]
        compared = [p for group in (*groups, [self.over] * self.strict) for p in group if p.c]
        d = lcm(*(p.d for p in compared))
        low = min((next(k for k, a in enumerate(p.c) if a) for p in compared), default=0)
        top = max((len(p.c) for p in compared), default=1)
        return [[[a * (d // p.d) for a in (p.c + (0,) * (top - len(p.c)))[low:]] for p in group] for group in groups]


def square(omega: Fraction | float) -> Point:
    """x = ω² of a frequency, a Fraction or inf."""
    return (1, 0) if omega == inf else (Fraction(omega).numerator ** 2, Fraction(omega).denominator ** 2)


def counterexample(inequality: Inequality, lo: Point, hi: Point, deadline: float) -> Point | None:
    """A point of [lo, hi], infinity included, where the inequality is false; None: it is proven. Or CheckError."""
    groups = inequality.integers()
    if len(groups) > 3 or len(groups[-1]) > 1:
        return _cover(groups, lo, hi, deadline)
    found = (failure(row, lo, hi, inequality.strict, deadline) for row in _conditions([group[0] for group in groups]))
    return next((at for at in found if at is not None), None)


def _conditions(rows: list[Row]) -> list[Row]:
    """`√a < √b` is `b − a > 0`; `√a1 + √a2 < √b` is `h = b − a1 − a2 > 0` and `h² − 4 a1 a2 > 0`."""
    *terms, bound = rows
    rest = [b - sum(a) for b, *a in zip(bound, *terms, strict=True)]
    if len(terms) < 2:
        return [rest]
    return [rest, [u - 4 * w for u, w in zip(product(rest, rest), product(*terms), strict=True)]]


def failure(p: Row, lo: Point, hi: Point, strict: bool, deadline: float) -> Point | None:
    """A point of [lo, hi] where not p > 0 (strict), or not p ≥ 0; None if there is none. p has its formal degree."""
    try:
        return _cover([[p]], lo, hi, deadline, strict, SHALLOW)
    except CheckError:  # a root that only touches never lets halving end: go on without repeated roots
        return _cover([[_simple(p, lo, strict)]], lo, hi, deadline, strict)


def _simple(p: Row, lo: Point, strict: bool) -> Row:
    """p with all roots once and its sign at lo (strict), or with those of odd multiplicity once and its sign."""
    p = primitive(p)
    derivative = [k * a for k, a in enumerate(p)][1:]
    if p[-1] % PRIME and len(common_divisor(p, derivative, PRIME)) == 1:
        return p  # the degree of a common divisor can only grow modulo a prime
    repeated = common_divisor(p, derivative)
    squarefree = quotient(p, repeated)
    if strict:
        return squarefree if mobius(squarefree, *lo, *lo)[0] > 0 else [-a for a in squarefree]
    double = common_divisor(squarefree, repeated)
    return p if len(repeated) == 1 else _simple(quotient(p, product(double, double)), lo, strict)


def bernstein(p: Row, lo: Point, hi: Point) -> Row:
    """Bernstein coefficients of p on [lo, hi] (projective), times a positive number that depends on len(p) only."""
    n = len(p) - 1
    scale = lcm(*(comb(n, k) for k in range(n + 1)))
    return [a * (scale // comb(n, k)) for k, a in enumerate(mobius(p, *lo, *hi))]


def _cover(
    groups: Sequence[Group], lo: Point, hi: Point, deadline: float, strict: bool = True, depth: int = DEEP
) -> Point | None:
    """Halve cells in x (and t) until `_slack` is ≥ 0, (strict: > 0 at corners) or a corner fails, roots floored."""
    lo, hi = _aligned(lo, hi, groups[-1][-1])
    cells: list[Cell] = [([[bernstein(row, lo, hi) for row in group] for group in groups], lo, hi, 0)]
    for _ in range(CELLS):
        tick(deadline)
        groups, left, right, level = cells.pop()
        for row, end in CORNERS:
            *a, b = (group[row][end] for group in groups)
            if sum(isqrt(u << 128) for u in a) ** 2 >= b << 128 if a else b < strict:
                return right if end else left
        slack = _slack(groups)
        if min(map(min, slack)) < 0 or (strict and not all(slack[row][end] for row, end in CORNERS)):
            if level == depth or (lo == hi and len(slack) == 1):
                break
            in_x, in_t = (max(max(line) - min(line) for line in lines) for lines in (slack, zip(*slack, strict=True)))
            along_t = in_t > in_x  # the direction in which the slack varies more
            first, second = zip(*(_halves(group, along_t) for group in groups), strict=True)
            if along_t:
                cells += [(first, left, right, level + 1), (second, left, right, level + 1)]
            else:
                middle = (left[0] + right[0], left[1] + right[1])
                left, right = (2 * left[0], 2 * left[1]), (2 * right[0], 2 * right[1])  # the scale of the middle
                cells += [(second, middle, right, level + 1), (first, left, middle, level + 1)]
        if not cells:
            return None
    raise CheckError(UNDECIDED, "neither proven nor refuted")


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


def _slack(groups: Sequence[Group]) -> Group:
    """Bernstein rows of `b·Πw − Σ a_i Σw Πw/w_i`: > 0 is `Σ √a_i < √b` if w_i ∝ √a_i, and implies it for any w > 0."""
    *terms, bound = groups
    if not terms:
        return bound
    roots = [isqrt(sum(map(sum, term)) << 64) for term in terms]
    excess = max(size(roots) - 24, 0)
    weights = [(root >> excess) + 1 for root in roots]
    whole, total = prod(weights), sum(weights)
    factors = [*(-total * (whole // w) for w in weights), whole]
    columns = ((zip(*rows, strict=True)) for rows in zip(*groups, strict=True))
    return [[sum(map(mul, factors, values)) for values in column] for column in columns]


def _halves(group: Group, along_t: bool) -> list[Group]:
    """De Casteljau at the middle of every row, or column; both halves are scaled by 2^n."""
    halves: tuple[list[Row], list[Row]] = ([], [])
    for row in zip(*group, strict=True) if along_t else group:
        n = len(row) - 1
        first, second = [row[0] << n], [row[-1] << n]
        for k in reversed(range(n)):
            row = [u + w for u, w in pairwise(row)]
            first.append(row[0] << k)
            second.append(row[-1] << k)
        halves[0].append(first)
        halves[1].append(second[::-1])
    return [list(zip(*half, strict=True)) if along_t else half for half in halves]
