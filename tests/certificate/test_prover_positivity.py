"""Signs of polynomials and of sums of square roots, with the truth known from how they were built."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise

import mpmath
import pytest
from flint import fmpq, fmpq_poly
from hypothesis import given, settings
from hypothesis import strategies as st

from robimp.synthesis.certificate.bivariate import bernstein, halves, minus, times, valuation
from robimp.synthesis.certificate.gap import reversed_sides
from robimp.synthesis.certificate.lowering import SumOfRoots, strip
from robimp.synthesis.certificate.outcome import Outcome
from robimp.synthesis.certificate.positivity import holds, positive, positive_univariate
from robimp.synthesis.certificate.witness import find_witness

PROVEN, REFUTED, UNDECIDED = Outcome.PROVEN, Outcome.REFUTED, Outcome.UNDECIDED
WHOLE = (fmpq(0), None)
X = fmpq_poly([0, 1])
ZETA = fmpq(1, 10**9)

places = st.sampled_from(
    [Fraction(0), Fraction(1, 3), Fraction(1), Fraction(1) + Fraction(1, 10**12), Fraction(7), Fraction(10**9)]
)
roots = st.lists(st.tuples(places | st.fractions(-5, 20, max_denominator=50), st.integers(1, 3)), max_size=4)
pairs = st.lists(
    st.tuples(st.fractions(-3, 15, max_denominator=20), st.sampled_from([Fraction(1), Fraction(1, 10**9)])), max_size=2
)
intervals = st.one_of(
    st.tuples(places, st.none()),
    st.tuples(places, places).map(sorted).map(tuple),
)


def q(value: Fraction | int) -> fmpq:
    return fmpq(Fraction(value).numerator, Fraction(value).denominator)


def poly(*ascending: Fraction | int) -> fmpq_poly:
    return fmpq_poly([q(c) for c in ascending])


def built(scale: Fraction, roots: list[tuple[Fraction, int]], pairs: list[tuple[Fraction, Fraction]]) -> fmpq_poly:
    p = poly(scale)
    for root, multiplicity in roots:
        p *= poly(-root, 1) ** multiplicity
    for real, imaginary in pairs:
        p *= poly(real**2 + imaginary**2, -2 * real, 1)
    return p


def truth(
    scale: Fraction, roots: list[tuple[Fraction, int]], low: Fraction, high: Fraction | None, vanishes: bool
) -> tuple[bool, bool]:
    """Whether the built polynomial is > 0 and ≥ 0: its sign at every root, end and point between, from its factors."""
    inside = sorted({low, *(r for r, _ in roots if r > low and (high is None or r < high))})
    marks = [*inside, inside[-1] + 1 if high is None else high]
    points = [*marks, *((a + b) / 2 for a, b in pairwise(marks))]

    def sign(x: Fraction) -> Fraction:
        value = scale
        for root, multiplicity in roots:
            value *= (x - root) ** multiplicity
        return value

    lowest = min(map(sign, points))
    return lowest > 0 and not (high is None and vanishes), lowest >= 0


@settings(max_examples=400, deadline=None)
@given(
    st.sampled_from([Fraction(1), Fraction(-1), Fraction(1, 10**150), Fraction(10**150)]),
    roots,
    pairs,
    intervals,
    st.integers(0, 1),
)
def test_sign_is_that_of_the_chosen_roots(scale, roots, pairs, interval, extra):
    low, high = interval
    p = built(scale, roots, pairs)
    ends = (q(low), None if high is None else q(high))
    strictly, weakly = truth(scale, roots, low, high, vanishes=extra > 0)
    for strict, expected in ((True, strictly), (False, weakly)):
        outcome = positive_univariate(p, ends, strict=strict, D=p.degree() + extra)
        assert outcome is (PROVEN if expected else REFUTED)


@pytest.mark.parametrize(
    ("p", "D", "strictly", "weakly"),
    [
        (X, 1, REFUTED, PROVEN),  # touches at 0
        (poly(1), 2, REFUTED, PROVEN),  # touches at ∞
        (poly(1, -2, 1), 2, REFUTED, PROVEN),  # double root inside
        (poly(-1, 3, -3, 1), 3, REFUTED, REFUTED),  # triple root: crosses
        (poly(0, 0, -1, 1), 3, REFUTED, REFUTED),  # a root at 0 hides the negative values beside it
        (fmpq_poly([0]), 0, REFUTED, PROVEN),
        (poly(1, -2, 1) + 4 * ZETA**2 * X, 2, PROVEN, PROVEN),  # needle that stays above
        (poly(1, -2, 1) - 4 * ZETA**2 * X, 2, REFUTED, REFUTED),  # needle that does not
        (poly(1 + Fraction(1, 10**12)) - 4 * X * poly(1, 1) ** 2 * poly(Fraction(1, 4)), 3, REFUTED, REFUTED),
        (poly(1, 1) ** 40, 40, PROVEN, PROVEN),
        (poly(-1, 1) ** 40, 40, REFUTED, PROVEN),
        (poly(Fraction(1, 10**300), -1, Fraction(10**300)), 2, PROVEN, PROVEN),
    ],
)
def test_known_signs_on_the_whole_axis(p, D, strictly, weakly):
    assert positive_univariate(p, WHOLE, strict=True, D=D) is strictly
    assert positive_univariate(p, WHOLE, strict=False, D=D) is weakly


def test_a_peak_just_above_one_is_told_from_one():
    """`x(2−x) ≤ level` has its peak 1 at x = 1."""
    for excess, expected in ((Fraction(1, 10**12), PROVEN), (Fraction(0), REFUTED), (Fraction(-1, 10**12), REFUTED)):
        assert positive_univariate(poly(1 + excess, -2, 1), WHOLE, strict=True, D=2) is expected


def test_closed_interval_includes_its_ends():
    p = poly(2, -3, 1)  # roots 1 and 2
    assert positive_univariate(p, (fmpq(2), None), strict=True, D=2) is REFUTED
    assert positive_univariate(p, (fmpq(2), None), strict=False, D=2) is PROVEN
    assert positive_univariate(p, (fmpq(2) + ZETA, None), strict=True, D=2) is PROVEN
    assert positive_univariate(-p, (fmpq(1), fmpq(2)), strict=False, D=2) is PROVEN
    assert positive_univariate(-p, (fmpq(1), fmpq(2) + ZETA), strict=False, D=2) is REFUTED
    for at, expected in ((0, PROVEN), (1, PROVEN), (fmpq(3, 2), REFUTED)):  # a single point
        assert positive_univariate(p, (fmpq(at), fmpq(at)), strict=False, D=2) is expected


# Two variables -------------------------------------------------------------------------------------------------------


def dip(place: fmpq, depth: fmpq) -> tuple[fmpq_poly, ...]:
    """`(t − place)² + (x − 1)² − depth`: its minimum is inside the segment, at no end of it."""
    return (poly(1, -2, 1) + place**2 - depth, fmpq_poly([-2 * place]), poly(1))


@pytest.mark.parametrize("place", [fmpq(1, 2), fmpq(1, 3), fmpq(7, 10)])
def test_minimum_inside_the_segment_is_seen(place):
    at_end_0, at_end_1 = dip(place, fmpq(1, 1000))[0], sum(dip(place, fmpq(1, 1000)), fmpq_poly([0]))
    for end in (at_end_0, at_end_1):  # no end shows it
        assert positive_univariate(end, WHOLE, strict=True, D=2) is PROVEN
    assert positive(dip(place, fmpq(1, 1000)), WHOLE, strict=True, D=2) is REFUTED
    assert positive(dip(place, fmpq(-1, 1000)), WHOLE, strict=True, D=2) is PROVEN


def test_touching_inside_the_segment_is_never_proven_strictly():
    assert positive(dip(fmpq(1, 2), fmpq(0)), WHOLE, strict=True, D=2) is REFUTED
    assert positive(dip(fmpq(1, 3), fmpq(0)), WHOLE, strict=True, D=2) is UNDECIDED  # 1/3 is no end of a half of a half
    assert positive(dip(fmpq(1, 3), fmpq(1, 10**9)), WHOLE, strict=True, D=2) is not PROVEN


coefficients = st.lists(st.integers(-4, 4), min_size=1, max_size=3)
surfaces = st.lists(coefficients, min_size=1, max_size=3).map(lambda rows: tuple(poly(*row) for row in rows))


def at(p: tuple[fmpq_poly, ...], x: fmpq, t: fmpq) -> fmpq:
    return sum((c(x) * t**k for k, c in enumerate(p)), fmpq(0))


@settings(max_examples=60, deadline=None)
@given(surfaces, surfaces, st.fractions(0, 4), st.fractions(0, 1))
def test_arithmetic_of_two_variables_is_that_of_values(a, b, x, t):
    x, t = q(x), q(t)
    assert at(times(a, b), x, t) == at(a, x, t) * at(b, x, t)
    assert at(minus(a, b), x, t) == at(a, x, t) - at(b, x, t)
    left, right = halves(bernstein(a))
    n = len(a) - 1
    for half, begin in ((left, 0), (right, fmpq(1, 2))):
        value = at(tuple(bernstein_to_power(half, n)), x, t)
        assert value == at(a, x, begin + t / 2)


def bernstein_to_power(b: tuple[fmpq_poly, ...], n: int) -> list[fmpq_poly]:
    from math import comb

    return [
        sum(((-1) ** (k - i) * comb(k, i) * b[i] for i in range(k + 1)), fmpq_poly([0])) * comb(n, k)
        for k in range(n + 1)
    ]


@settings(max_examples=40, deadline=None)
@given(surfaces)
def test_a_proven_surface_is_positive_at_every_sample(p):
    D = max(c.degree() for c in p)
    samples = [at(p, fmpq(i, 5), fmpq(j, 8)) for i in range(40) for j in range(9)]
    outcome = positive(p, WHOLE, strict=True, D=max(D, 0))
    assert not (outcome is PROVEN and min(samples) <= 0)
    assert not (outcome is REFUTED and D == 0 and min(samples) > 0 and len(p) < 3)


# Sums of square roots ------------------------------------------------------------------------------------------------

BASES = (poly(1, 2), poly(3, 0, 1), poly(Fraction(1, 2), 1), poly(0, 5))  # each ≥ 0 on x ≥ 0


def squares(n: int, factor: fmpq) -> SumOfRoots:
    """`Σ √(a_i²) ≤ √(factor·(Σ a_i)²)`: an equality at every x for factor 1."""
    total = sum(BASES[:n], fmpq_poly([0]))
    return SumOfRoots(tuple((a * a,) for a in BASES[:n]), (factor * total * total,), True, None)


@pytest.mark.parametrize("n", [1, 2])
@pytest.mark.parametrize("interval", [WHOLE, (fmpq(1, 7), fmpq(3)), (fmpq(2), None)])
def test_sum_of_roots_against_the_square_of_the_sum(n, interval):
    tiny = fmpq(1, 10**12)
    assert holds(squares(n, 1 + tiny), interval, strict=True) is PROVEN
    assert holds(squares(n, 1 - tiny), interval, strict=True) is REFUTED
    assert holds(squares(n, fmpq(1)), interval, strict=True) is REFUTED
    assert holds(squares(n, fmpq(1)), interval, strict=False) is PROVEN


def test_three_roots_are_left_to_cells():
    assert holds(squares(3, fmpq(2)), WHOLE, strict=True) is Outcome.UNDECIDED


@pytest.mark.parametrize("n", [0, 1, 2])
def test_right_side_that_is_not_a_root_must_not_be_negative(n):
    """`Σ√A ≤ R`: squaring alone would accept R = −Σ√A."""
    total = sum(BASES[:n], fmpq_poly([0])) + 1
    radicands = tuple((a * a,) for a in BASES[:n])
    assert holds(SumOfRoots(radicands, (total,), False, None), WHOLE, strict=False) is PROVEN
    assert holds(SumOfRoots(radicands, (-total,), False, None), WHOLE, strict=False) is REFUTED


def test_a_strict_part_stays_strict_in_a_claim_that_is_not():
    """`W < 1` in a passivity claim: at W = 1 the disc is no disc."""
    touching = SumOfRoots(((poly(1),),), (poly(1, 1),), True, None)  # √1 ≤ √(1+x): equal at x = 0
    assert holds(touching, WHOLE, strict=False) is PROVEN
    strict = SumOfRoots(touching.radicands, touching.right, True, None, strict=True)
    assert holds(strict, WHOLE, strict=False) is REFUTED
    assert find_witness(strict, WHOLE, (), strict=False) is not None
    assert find_witness(touching, WHOLE, (), strict=False) is None


positive_polynomials = st.lists(st.integers(0, 6), min_size=1, max_size=4).filter(any).map(lambda c: poly(*c))


@settings(max_examples=120, deadline=None)
@given(st.lists(positive_polynomials, min_size=1, max_size=3), positive_polynomials, st.integers(1, 40))
def test_outcome_agrees_with_dense_evaluation(radicands, right, factor):
    inequality = SumOfRoots(tuple((a,) for a in radicands), (factor * right,), True, None)
    interval = (fmpq(1, 4), fmpq(9))
    outcome = holds(inequality, interval, strict=True)
    if len(radicands) > 2:
        assert outcome is Outcome.UNDECIDED
        return
    with mpmath.workdps(40):

        def slack(x: fmpq) -> mpmath.mpf:
            def value(p: fmpq_poly) -> mpmath.mpf:
                exact_value = p(x)
                return mpmath.mpf(int(exact_value.p)) / int(exact_value.q)

            return mpmath.sqrt(factor * value(right)) - sum(mpmath.sqrt(value(a)) for a in radicands)

        lowest = min(slack(fmpq(1, 4) + fmpq(35 * k, 4 * 60)) for k in range(61))
        if outcome is PROVEN:
            assert lowest > 0
        if lowest < 0:
            assert outcome is REFUTED
        witness = find_witness(inequality, interval, (), strict=True)
        if witness is not None:
            assert slack(q(witness.omega) ** 2) <= 0
        if outcome is REFUTED and len(radicands) <= 2:
            assert witness is not None


@settings(max_examples=60, deadline=None)
@given(
    st.lists(positive_polynomials, min_size=1, max_size=3),
    positive_polynomials,
    st.integers(1, 3),
    st.fractions(Fraction(1, 50), 50),
)
def test_common_powers_and_reversal_change_no_sign(radicands, right, power, x):
    x = q(x)
    plain = SumOfRoots(tuple((a,) for a in radicands), (right,), True, None)
    multiplied = SumOfRoots(tuple((a * X**power,) for a in radicands), (right * X**power,), True, None)
    stripped = strip(multiplied)
    common = min(valuation(p) for p in (*plain.radicands, plain.right))
    assert [p[0] * X**common for p in stripped.radicands] == [p[0] for p in plain.radicands]
    turned = reversed_sides(plain)
    ratios = {
        r[0](1 / x) / p[0](x)
        for r, p in zip((*turned.radicands, turned.right), (*plain.radicands, plain.right), strict=True)
    }
    assert len(ratios) == 1
    assert ratios.pop() > 0


def test_infinity_is_compared_by_leading_coefficients():
    for lead, expected in ((fmpq(1) + ZETA, PROVEN), (fmpq(1), REFUTED), (fmpq(1) - ZETA, REFUTED)):
        one = SumOfRoots(((poly(0, 0, 1),),), (poly(1, 0, 0) + lead * X**2,), True, None)
        assert holds(one, WHOLE, strict=True) is expected
    assert find_witness(SumOfRoots(((X**2,),), (poly(1, 0, 1),), True, None), WHOLE, (), strict=True).omega is None


@pytest.mark.parametrize("usual", [3.0, 50.0, 2e5])
def test_a_witness_is_near_the_joints_frequencies(usual):
    """R < 0 between x = 10⁶ and 10²⁸⁶: the middle is at 10¹⁴³ rad/s, where no joint has ever been."""
    right = poly(-(10**6), 1) * poly(-(10**286), 1)
    found = find_witness(SumOfRoots((), (right,), False, None), WHOLE, (usual,), strict=True)
    assert 10**3 < found.omega <= max(2 * 10**3, usual)


def test_what_fails_only_beyond_every_joint_fails_at_infinity():
    falling = SumOfRoots((), (poly(10**250, -1),), False, None)
    assert find_witness(falling, WHOLE, (50.0,), strict=True).omega is None
    returning = SumOfRoots((), (poly(-(10**250), 1) * poly(-(10**252), 1),), False, None)
    far = find_witness(returning, WHOLE, (50.0,), strict=True).omega
    assert 10**250 < far**2 < 10**252, "unless it holds there again"
