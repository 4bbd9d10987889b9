"""Exact sign of polynomials and sums of square roots on [x₀, x₁] ⊆ [0, ∞], x = ω². Three outcomes, never a guess.

One variable: FLINT isolates the real roots; between them one exact sample decides. With up to two square roots the
inequality is squared to polynomial positivity; with more, it is left undecided here, and to cells (`enclosure`).
"""

from __future__ import annotations

from dataclasses import dataclass

from flint import arb, ctx, fmpq, fmpq_poly

from .bivariate import Bivariate, bernstein, degree, halves, minus, times
from .lowering import SumOfRoots, strip
from .outcome import Interval, Outcome, all_of
from .roots import complex_roots

MAX_PRECISION = 4096  # bits spent on telling a root from an end of the interval
MAX_T_DEPTH = 8  # halvings of a segment of loads


@dataclass(frozen=True)
class Obligation:
    """`p > 0` (or ≥ 0); at ∞ the coefficient of x^D counts, D the degree of what p was made of."""

    p: Bivariate
    strict: bool
    D: int


def obligations(inequality: SumOfRoots, *, strict: bool) -> tuple[Obligation, ...]:
    """What one or two square roots come down to, by squaring: `√A + √C ≤ √B ⇔ S = B−A−C ≥ 0 and S² ≥ 4AC`."""
    roots, right = inequality.radicands, inequality.right
    square = right if inequality.squared else times(right, right)
    D = degree(*roots, square)
    needed = [] if inequality.squared else [Obligation(right, False, degree(right))]
    if inequality.squared or roots:
        gap = square
        for root in roots:
            gap = minus(gap, root)
        needed.append(Obligation(gap, strict, D))
        if len(roots) == 2:
            cross = minus(times(gap, gap), times((fmpq_poly([4]),), times(*roots)))
            needed.append(Obligation(cross, strict, 2 * D))
    return tuple(needed)


def holds(inequality: SumOfRoots, interval: Interval, *, strict: bool) -> Outcome:
    """Whether `Σ√A ≤ √B` or `≤ R` (strict, for squared ones: <) at every x of the closed interval, ∞ included."""
    inequality, strict = strip(inequality), strict or inequality.strict
    if len(inequality.radicands) > 2:
        return Outcome.UNDECIDED
    outcomes = []
    for needed in obligations(inequality, strict=strict):
        outcomes.append(positive(needed.p, interval, strict=needed.strict, D=needed.D))
        if outcomes[-1] is Outcome.REFUTED:
            break
    return all_of(outcomes)


def positive(p: Bivariate, interval: Interval, *, strict: bool, D: int) -> Outcome:
    """`p > 0` (or ≥ 0) for x in the interval and t in [0, 1]; at ∞ the coefficient of x^D counts."""
    if len(p) == 1:
        return positive_univariate(p[0], interval, strict=strict, D=D)
    return _positive_in_t(bernstein(p), interval, strict, D, MAX_T_DEPTH)


def positive_univariate(p: fmpq_poly, interval: Interval, *, strict: bool, D: int) -> Outcome:
    """`p > 0` (or ≥ 0) on the closed interval [x₀, x₁], ∞ compared by the coefficient of x^D."""
    low, high = interval
    if p.degree() < 0:
        return Outcome.REFUTED if strict else Outcome.PROVEN
    end = p[D] if high is None else p(high)
    if strict and (p(low) == 0 or end == 0):
        return Outcome.REFUTED
    if p(low) < 0 or end < 0:
        return Outcome.REFUTED
    if low == high:
        return Outcome.PROVEN
    for root in {str(e): e for e in (low, high) if e is not None}.values():
        while p.degree() > 0 and p(root) == 0:
            p = p // fmpq_poly([-root, 1]) * (1 if root == low else -1)
    crossing = fmpq_poly([1])
    for factor, multiplicity in p.numer().factor_squarefree()[1]:
        if strict or multiplicity % 2:
            crossing = crossing * fmpq_poly(factor)
    inside = count_roots_inside(crossing, low, high)
    if inside is None:
        return Outcome.UNDECIDED
    if inside:
        return Outcome.REFUTED
    return Outcome.PROVEN if _sample(p, low, high) > 0 else Outcome.REFUTED


def count_roots_inside(p: fmpq_poly, low: fmpq, high: fmpq | None) -> int | None:
    """Number of real roots in the open interval of a squarefree p without roots at its ends; None if undecided."""
    if p.degree() <= 0:
        return 0
    precision = ctx.prec
    try:
        while ctx.prec <= MAX_PRECISION:
            places = [_place(root.real, low, high) for root, _ in complex_roots(p) if root.imag == 0]
            if None not in places:
                return sum(bool(place) for place in places)
            ctx.prec *= 2
        return None
    finally:
        ctx.prec = precision


def _place(root: arb, low: fmpq, high: fmpq | None) -> bool | None:
    below, above = root < arb(low), high is not None and root > arb(high)
    if below or above:
        return False
    if root > arb(low) and (high is None or root < arb(high)):
        return True
    return None


def _sample(p: fmpq_poly, low: fmpq, high: fmpq | None) -> fmpq:
    """Value of p at some interior point where it does not vanish."""
    x = low + 1 if high is None else (low + high) / 2
    step = fmpq(1) if high is None else (high - low) / 4
    while p(x) == 0:
        x, step = x + step, step / 2
    return p(x)


def _positive_in_t(b: Bivariate, interval: Interval, strict: bool, D: int, depth: int) -> Outcome:
    """b: Bernstein coefficients in t. All positive suffices; the first and last are values and can refute."""
    ends = [positive_univariate(p, interval, strict=strict, D=D) for p in (b[0], b[-1])]
    if Outcome.REFUTED in ends:
        return Outcome.REFUTED
    inner = [positive_univariate(p, interval, strict=strict, D=D) for p in b[1:-1]]
    if all_of(ends + inner) is Outcome.PROVEN:
        return Outcome.PROVEN
    if depth == 0:
        return Outcome.UNDECIDED
    return all_of([_positive_in_t(half, interval, strict, D, depth - 1) for half in halves(b)])
