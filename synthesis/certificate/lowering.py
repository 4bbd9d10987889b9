"""From an inequality and an exact X(s) to polynomials: `Σ √A_i(x) ≤ √B(x)` or `≤ R(x)`, x = ω².

Everything is multiplied by what clears denominators: |common denominator|, and the √M or M − N that turns the gains of
W = √(N/M) into square roots of polynomials. Multiplying by a positive quantity keeps the inequality; where it vanishes
or has a pole (x = 0, x = ∞) the two sides are compared by their leading coefficients.

A segment of loads adds a second variable t in [0, 1]; polynomials are then tuples of coefficients of powers of t.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

from flint import fmpq, fmpq_poly

from ...models.impedance import DynamicStiffness
from ...models.rational import ZERO, RationalFunction
from ...models.uncertainty import Segment, Uncertainty
from ..problem.constraints.inequality import Gain, Inequality, Role, Source, Term, needs_disc
from .bivariate import Bivariate, degree, shift, times, valuation

ONE = fmpq_poly([1])
NO_RADIUS: tuple[Bivariate, Bivariate] = ((fmpq_poly([0]),), (ONE,))  # W² = 0/1: an exact model


@dataclass(frozen=True)
class SumOfRoots:
    """`Σ √radicand_i ≤ √right` (squared) or `≤ right`, and the segment of loads it is about (None: no load).

    strict: equality fails even where the claim itself allows it.
    """

    radicands: tuple[Bivariate, ...]
    right: Bivariate
    squared: bool
    segment: Segment | None
    strict: bool = False


def even_part(p: fmpq_poly) -> fmpq_poly:
    """Real part of p(jω) as a polynomial in x = ω²."""
    return fmpq_poly([c if k % 2 == 0 else -c for k, c in enumerate(p.coeffs()[::2])])


def mirror(p: fmpq_poly) -> fmpq_poly:
    """`p(−s)`, the complex conjugate of p on the imaginary axis."""
    return fmpq_poly([c if k % 2 == 0 else -c for k, c in enumerate(p.coeffs())])


def abs2(p: fmpq_poly) -> fmpq_poly:
    """`|p(jω)|²` as a polynomial in x."""
    return even_part(p * mirror(p))


def in_s(p: fmpq_poly) -> fmpq_poly:
    """A polynomial in x = ω² = −s² as one in s."""
    coefficients = [fmpq(0)] * (2 * p.degree() + 1)
    for k, c in enumerate(p.coeffs()):
        coefficients[2 * k] = c if k % 2 == 0 else -c
    return fmpq_poly(coefficients)


def lower(inequality: Inequality, v: fmpq, X: RationalFunction, uncertainty: Uncertainty) -> Iterator[SumOfRoots]:
    """One `SumOfRoots` per member of the uncertainty that decides it, preceded by `W < 1` where the gains need it."""
    if inequality.source is Source.NONE:
        yield _without_radius(inequality, v, X)
        return
    scale = v * v if inequality.role is Role.RADIUS else fmpq(1)
    for segment, ratios in _radii(inequality, uncertainty):
        if needs_disc(inequality):
            ((N, M),) = ratios
            N = tuple(scale * c for c in N)
            yield SumOfRoots((N,), M, True, segment, strict=True)
            yield _with_disc(inequality, v, X, N[0], M[0], segment)
        else:
            yield _with_radius(inequality, scale, X, ratios, segment)


def _radii(
    inequality: Inequality, uncertainty: Uncertainty
) -> Iterator[tuple[Segment | None, tuple[tuple[Bivariate, Bivariate], ...]]]:
    """Members of Δ: the segment of loads and the squared radii N/M whose roots, combined, are W."""
    weight = None
    if uncertainty.weight is not None:
        weight = ((abs2(uncertainty.weight.num),), (abs2(uncertainty.weight.den),))
    if inequality.source is Source.DISC or uncertainty.box is None:
        load = inequality.load
        yield (None if load is None else (load, load)), (weight or NO_RADIUS,)
        return
    # Gains of Δ/(1+Δ) need W < 1, where the corners alone decide; the edge matters only beyond.
    points = tuple((load, load) for load in uncertainty.corners())
    for segment in points if needs_disc(inequality) else uncertainty.segments():
        box = _load_ratio(uncertainty.nominal, segment)
        yield segment, (box,) if weight is None else (box, weight)


def _load_ratio(nominal: DynamicStiffness, segment: Segment) -> tuple[Bivariate, Bivariate]:
    """`|ĝ−g|²` and `|g|²` along a segment of loads, as polynomials in x and t."""
    start, end = (load.polynomial for load in segment)
    step = end - start
    pairs = []
    for p, q in ((nominal.polynomial - start, -step), (start, step)):
        squares = (abs2(p), 2 * even_part(p * mirror(q)), abs2(q))
        pairs.append(squares if step.degree() >= 0 else squares[:1])
    return pairs[0], pairs[1]


def _clear(values: list[RationalFunction]) -> tuple[list[fmpq_poly], fmpq_poly]:
    """Numerators over the least common denominator E, and E."""
    E = ONE
    for value in values:
        E = E * (value.den // E.gcd(value.den))
    return [value.num * (E // value.den) for value in values], E


def _without_radius(inequality: Inequality, v: fmpq, X: RationalFunction) -> SumOfRoots:
    load = inequality.load
    return _assemble(
        inequality,
        v,
        moduli=[(term.affine(X), [ONE]) for term in inequality.moduli],
        real=sum((term.affine(X) for term in inequality.reals), ZERO),
        right=inequality.right(X),
        unit=ONE,
        segment=None if load is None else (load, load),
    )


def _with_disc(
    inequality: Inequality, v: fmpq, X: RationalFunction, N: fmpq_poly, M: fmpq_poly, segment: Segment | None
) -> SumOfRoots:
    """Gains of Δ/(1+Δ) for a fixed `W² = N/M < 1`: everything multiplied by `M − N` > 0."""
    factors = {Gain.ONE: [ONE], Gain.RHO: [N * M], Gain.R: [N * N, N * M]}
    n, gap = RationalFunction.lift(in_s(N)), RationalFunction.lift(in_s(M - N))

    def value(term: Term) -> Any:
        inside = term.affine(X) if term.gain is not Gain.ONE else term.affine(X) * gap
        return inside if term.shift is None else inside - term.shift(X) * n

    return _assemble(
        inequality,
        v,
        moduli=[(value(term), factors[term.gain]) for term in inequality.moduli],
        real=sum((value(term) for term in inequality.reals), ZERO),
        right=inequality.right(X) * gap,
        unit=M - N,
        segment=segment,
    )


def _assemble(
    inequality: Inequality,
    v: fmpq,
    *,
    moduli: list[tuple[RationalFunction, list[fmpq_poly]]],
    real: RationalFunction,
    right: RationalFunction,
    unit: fmpq_poly,
    segment: Segment | None,
) -> SumOfRoots:
    """Clear denominators. Each modulus comes with the polynomials of x whose roots multiply it; `unit` scales v."""
    (real_num, right_num, *nums), E = _clear([real, right, *(value for value, _ in moduli)])
    squares = [factor * abs2(num) for num, (_, factors) in zip(nums, moduli, strict=True) for factor in factors]
    ceiling = v if inequality.role is Role.CEILING else fmpq(1)
    if inequality.modulus_right:
        return SumOfRoots(tuple((p,) for p in squares), (ceiling * ceiling * abs2(right_num),), True, segment)
    E2 = abs2(E)
    floor = v * unit * E2 if inequality.role is Role.FLOOR else fmpq_poly([0])
    R = even_part((ceiling * right_num - real_num) * mirror(E)) - floor
    return SumOfRoots(tuple((p * E2,) for p in squares), (R,), False, segment)


def _with_radius(
    inequality: Inequality,
    scale: fmpq,
    X: RationalFunction,
    ratios: tuple[tuple[Bivariate, Bivariate], ...],
    segment: Segment | None,
) -> SumOfRoots:
    """Gains ONE and W, `W = √scale·Σ` over non-empty subsets of the sources of `Π √(N/M)`; multiplied by `√(Π M)`."""
    (*nums, right_num), _ = _clear([*(term.affine(X) for term in inequality.moduli), inequality.right(X)])
    every: Bivariate = (ONE,)
    for _, M in ratios:
        every = times(every, M)
    radicands = []
    for term, num in zip(inequality.moduli, nums, strict=True):
        square: Bivariate = (abs2(num),)
        if term.gain is Gain.ONE:
            radicands.append(times(square, every))
            continue
        for choice in product((False, True), repeat=len(ratios)):
            if any(choice):
                factor: Bivariate = (scale * ONE,)
                for (N, M), chosen in zip(ratios, choice, strict=True):
                    factor = times(factor, N if chosen else M)
                radicands.append(times(square, factor))
    return SumOfRoots(tuple(radicands), times((abs2(right_num),), every), True, segment)


def strip(inequality: SumOfRoots) -> SumOfRoots:
    """Drop roots of 0 and divide both sides by the highest common power of ω: x = 0 compares leading coefficients."""
    inequality = replace(inequality, radicands=tuple(p for p in inequality.radicands if degree(p) >= 0))
    right_weight = 1 if inequality.squared else 2
    k = min((valuation(p) for p in inequality.radicands), default=10**6)
    k = min(k, right_weight * valuation(inequality.right)) if degree(inequality.right) >= 0 else k
    k -= k % right_weight
    if k in (0, 10**6):
        return inequality
    return replace(
        inequality,
        radicands=tuple(shift(p, k) for p in inequality.radicands),
        right=shift(inequality.right, k // right_weight),
    )
