"""Polynomials whose truth is known by construction: chosen roots, touching roots, needles, edges."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise
from math import inf, isqrt, sqrt
from time import monotonic

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robimp.synthesis.check.enclosure.cells import Cell
from robimp.synthesis.check.enclosure.search import cover
from robimp.synthesis.check.outcome import CheckError
from robimp.synthesis.check.polynomials import ONE, ZERO, Poly, common_divisor, decays_faster, norm2, on_axis, product
from robimp.synthesis.check.positivity import Inequality, Point, counterexample, failure

ZERO_X, INF = (0, 1), (1, 0)
ROOTS = st.fractions(min_value=-4, max_value=40, max_denominator=7)


def soon() -> float:
    return monotonic() + 20


def from_roots(*roots: Fraction | int) -> list[int]:
    out = [1]
    for root in roots:
        r = Fraction(root)
        out = product(out, [-r.numerator, r.denominator])
    return out


def status(p: list[int], lo: Point = ZERO_X, hi: Point = INF, strict: bool = True) -> str:
    return "proven" if failure(p, lo, hi, strict, soon()) is None else "refuted"


def decide(inequality: Inequality, lo: Point, hi: Point) -> str:
    if len(inequality.terms) < 3:
        return "proven" if counterexample(inequality, lo, hi, soon()) is None else "refuted"
    ends = [Fraction(*end) if end[1] else inf for end in (lo, hi)]
    if lo == hi:
        zero, far = Fraction(0), ends[0] == inf
        cells = [Cell(zero, zero, True, {}) if far else Cell(Fraction(*lo), Fraction(*lo), False, {})]
    else:
        inner = [Fraction(4) ** k for k in range(-8, 9)]
        points = [ends[0], *(x for x in inner if ends[0] < x < ends[1]), ends[1]]
        cells = [Cell(Fraction(a), Fraction(b), False, {}) for a, b in pairwise(points)]
    return "refuted" if cover(cells, lambda cell, _: [inequality], soon()) else "proven"


@settings(max_examples=150, deadline=None)
@given(st.lists(ROOTS, max_size=5), st.lists(ROOTS, max_size=2), st.integers(0, 20), st.integers(1, 20))
def test_truth_is_the_one_of_the_chosen_roots(
    single: list[Fraction], double: list[Fraction], lo: int, width: int
) -> None:
    p = from_roots(*single, *double, *double)
    hi = lo + width
    roots = [*single, *double]
    points = sorted({Fraction(lo), Fraction(hi), *(r for r in roots if lo <= r <= hi)})
    middles = [(a + b) / 2 for a, b in pairwise(points)]

    def value(x: Fraction) -> Fraction:
        return sum((a * x**k for k, a in enumerate(p)), Fraction(0))

    expected = all(value(x) > 0 for x in [*points, *middles])
    expected_weak = all(value(x) >= 0 for x in [*points, *middles])
    assert status(p, (lo, 1), (hi, 1)) == ("proven" if expected else "refuted")
    assert status(p, (lo, 1), (hi, 1), strict=False) == ("proven" if expected_weak else "refuted")


def test_a_touching_irrational_root_is_not_strict_but_not_negative() -> None:
    touching = product([-2, 0, 1], [-2, 0, 1])  # (x² − 2)²
    assert status(touching) == "refuted"
    assert status(touching, strict=False) == "proven"
    above = [touching[0] * 10**30 + 1, *(c * 10**30 for c in touching[1:])]
    assert status(above) == "proven"
    below = [touching[0] * 10**30 - 1, *(c * 10**30 for c in touching[1:])]
    assert status(below, strict=False) == "refuted"


def test_a_refutation_carries_a_point_where_it_is_false() -> None:
    p = product([-3, 1], [-4, 1])  # negative between 3 and 4
    at = failure(p, ZERO_X, INF, True, soon())
    assert at is not None and 3 <= Fraction(*at) <= 4


def test_the_ends_count() -> None:
    assert status([0, 1]) == "refuted" and status([0, 1], strict=False) == "proven"  # zero at 0
    assert status([1, 1, 0]) == "refuted" and status([1, 1]) == "proven"  # a lost formal degree is a zero at infinity
    assert status([-1, 1], (1, 1), (2, 1)) == "refuted" and status([-1, 1], (1, 1), (2, 1), strict=False) == "proven"
    assert status([3, -1], (1, 1), (3, 1), strict=False) == "proven" and status([3, -1], strict=False) == "refuted"


@pytest.mark.parametrize(("gap", "expected"), [(1, "proven"), (0, "refuted"), (-1, "refuted")])
def test_a_needle_of_relative_width_1e9_is_seen(gap: int, expected: str) -> None:
    """|1 − x + 2ζj√x|² with ζ = 1e-9 has its minimum 4ζ²(1 − ζ²) at x = 1 − 2ζ²."""
    z2 = Fraction(1, 10**18)
    level = 4 * z2 * (1 - z2) - gap * Fraction(1, 10**40)
    p = Poly.of(1 - level, 4 * z2 - 2, 1)
    assert status(list(p.c)) == expected


def test_modulus_sums_with_one_two_and_three_roots() -> None:
    a, b = Poly.of(0, 4), Poly.of(9)

    def truth(terms: list[Poly], bound: Poly) -> str:
        return decide(Inequality(terms, bound, True), (1, 1), (4, 1))

    # √(4x) + √9 at x = 4 is 7
    assert truth([a, b], Poly.of(Fraction(491, 10))) == "proven" and truth([a, b], Poly.of(49)) == "refuted"
    assert truth([a, b, ONE], Poly.of(Fraction(641, 10))) == "proven"
    assert truth([a, b, ONE], Poly.of(Fraction(639, 10))) == "refuted"
    assert truth([a], Poly.of(Fraction(161, 10))) == "proven" and truth([a], Poly.of(16)) == "refuted"


@settings(max_examples=60, deadline=None)
@given(
    st.lists(st.tuples(st.integers(0, 9), st.integers(0, 9), st.integers(0, 9)), min_size=3, max_size=4),
    st.integers(1, 99),
)
def test_three_and_more_roots_agree_with_floats(rows: list[tuple[int, int, int]], percent: int) -> None:
    terms = [Poly.of(*row) for row in rows if any(row)]
    xs = [k / 200 for k in range(401)]
    peak = max(sum(sqrt(sum(c * x**k for k, c in enumerate(row))) for row in rows) for x in xs)
    for factor, expected in ((1 + percent / 1000 + 1e-3, "proven"), (1 - percent / 1000, "refuted")):
        bound = Poly.of(Fraction(max(peak * factor, 1e-9)) ** 2)
        if peak > 0:
            one = Inequality(terms, bound, True)
            assert decide(one, ZERO_X, (2, 1)) == expected


def test_at_one_point_two_roots_are_compared_exactly() -> None:
    def at(bound: Fraction, strict: bool) -> str:
        return decide(Inequality([Poly.of(2), Poly.of(8)], Poly.of(bound), strict), (1, 1), (1, 1))

    assert at(Fraction(18), True) == "refuted" and at(Fraction(18), False) == "proven"  # √2 + √8 = √18
    assert at(18 + Fraction(1, 10**300), True) == "proven"


def test_at_one_point_three_roots_can_be_too_close_to_tell() -> None:
    def at(bound: Fraction, x: Point) -> str:
        three = [Poly.of(0, c) for c in (2, 8, 32)]
        return decide(Inequality(three, Poly.of(0, bound), True), x, x)

    for x in ((1, 1), (5, 7), INF, ZERO_X):
        with pytest.raises(CheckError, match="neither"):
            at(Fraction(98), x)  # √2 + √8 + √32 = √98
        assert at(98 + Fraction(1, 10**9), x) == "proven" and at(98 - Fraction(1, 10**9), x) == "refuted"


def test_common_powers_of_x_are_compared_by_leading_coefficients() -> None:
    def truth(low: Fraction) -> str:
        return decide(Inequality([Poly.of(0, 1)], Poly.of(0, low, 1), True), ZERO_X, (1, 1))

    assert truth(Fraction(2)) == "proven" and truth(Fraction(1)) == "refuted"
    falling = Poly.of(1)  # 1/(1 + x) > 0 multiplied by 1 + x: zero at infinity
    assert decide(Inequality((), falling, True, Poly.of(1, 1)), ZERO_X, INF) == "refuted"
    assert decide(Inequality((), falling, True), ZERO_X, INF) == "proven"
    assert decide(Inequality((), ZERO, True), ZERO_X, INF) == "refuted"
    assert decide(Inequality((), ZERO, False), ZERO_X, INF) == "proven"


@settings(max_examples=80, deadline=None)
@given(st.lists(st.tuples(st.integers(1, 40), st.integers(0, 9)), min_size=1, max_size=6), st.integers(-3, 3))
def test_decay_rate_is_the_slowest_root(pairs: list[tuple[int, int]], offset: int) -> None:
    p = ONE
    for a, b in pairs:  # roots −a/4 ± jb
        p = p * (Poly.of(Fraction(a * a, 16) + b * b, Fraction(a, 2), 1) if b else Poly.of(Fraction(a, 4), 1))
    slowest = Fraction(min(a for a, _ in pairs), 4)
    rate = slowest + Fraction(offset, 1000)
    assert decays_faster(p, rate, soon()) == (rate < slowest)


def test_roots_on_the_axis_are_not_stable() -> None:
    for p in (Poly.of(1, 0, 1), Poly.of(0, 1, 1), Poly.of(1, 0, 2, 0, 1), Poly.of(1, 1, 1, 1), ZERO):
        assert not decays_faster(p, Fraction(0), soon())
    assert decays_faster(Poly.of(*[isqrt(k * k) for k in (1, 3, 3, 1)]), Fraction(0), soon())
    forty = ONE
    for _ in range(40):
        forty = forty * Poly.of(1, 1)
    assert decays_faster(forty, Fraction(999, 1000), soon()) and not decays_faster(forty, Fraction(1), soon())


@given(st.lists(st.integers(-9, 9), min_size=1, max_size=7), st.floats(0.01, 10))
def test_values_on_the_axis(c: list[int], omega: float) -> None:
    p, s = Poly.of(*c), 1j * omega
    exact = sum(a * s**k for k, a in enumerate(c))
    q = Poly.of(3, -2, 1)
    other = 3 - 2 * s + s**2

    def real(poly: Poly) -> float:
        return sum(a * omega ** (2 * k) for k, a in enumerate(poly.c)) / poly.d

    scale = 1 + abs(exact) * abs(other) * 1e3 + sum(abs(a) * omega**k for k, a in enumerate(c)) ** 2
    assert real(norm2(p)) == pytest.approx(abs(exact) ** 2, abs=1e-9 * scale)
    assert real(on_axis(p, q)[1]) == pytest.approx((exact * other.conjugate()).imag / omega, abs=1e-9 * scale / omega)


@given(st.lists(ROOTS, min_size=1, max_size=4), st.lists(ROOTS, max_size=3), st.lists(ROOTS, max_size=3))
def test_common_divisor(shared: list[Fraction], left: list[Fraction], right: list[Fraction]) -> None:
    left = [r for r in left if r not in right]
    right = [r for r in right if r not in left]
    found = common_divisor(from_roots(*shared, *left), from_roots(*shared, *right), soon())
    assert found in (from_roots(*shared), [-c for c in from_roots(*shared)])


def test_the_clock_stops_a_long_subdivision() -> None:
    with pytest.raises(CheckError, match="time limit"):
        failure([3, -10, 10], ZERO_X, INF, True, monotonic() - 1)
