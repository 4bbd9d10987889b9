"""How positivity is shown: one denominator, Bernstein coefficients, cells halved, repeated roots, where it stops."""

from __future__ import annotations

import re
from fractions import Fraction
from math import inf
from pathlib import Path
from time import monotonic

import pytest

from robimp.synthesis.check import positivity
from robimp.synthesis.check.outcome import UNDECIDED, CheckError
from robimp.synthesis.check.polynomials import ONE, PRIME, ZERO, Poly, Row, X, product
from robimp.synthesis.check.positivity import (
    Inequality,
    Point,
    bernstein,
    counterexample,
    failure,
    one_is_positive,
    square,
)

NOUGHT, UNIT, FAR = (0, 1), (1, 1), (1, 0)
CHECK = Path(positivity.__file__).parent


def soon() -> float:
    return monotonic() + 20


def power(p: Row, n: int) -> list[int]:
    out = [1]
    for _ in range(n):
        out = product(out, p)
    return out


def value(p: Row, at: Point) -> Fraction:
    return sum((a * Fraction(*at) ** k for k, a in enumerate(p)), Fraction(0))


def test_the_terms_of_an_inequality_have_one_denominator_and_no_common_power_of_x() -> None:
    half, third = Poly.of(0, 0, Fraction(1, 2)), Poly.of(0, 3, Fraction(1, 3), 1)
    assert Inequality([half], third).rows() == [[0, 3, 0], [18, 2, 6]]
    assert Inequality([ZERO, half], Poly.of(0, 0, 2)).rows() == [[1], [4]], "a term that vanishes is none"
    assert Inequality([], X * X).rows() == [[1]] and Inequality([], ZERO).rows() == [[0]]


def test_what_a_bound_was_multiplied_by_counts_where_leading_coefficients_do() -> None:
    bound, over = X, Poly.of(Fraction(1, 3), 0, 1)
    assert Inequality([], bound, over=over).rows() == [[0, 3, 0]], "equality at both ends"
    assert Inequality([], bound, strict=False, over=over).rows() == [[1]], "≥ may be attained"
    assert Inequality([], bound).rows() == [[1]]
    assert Inequality([], X, over=X).strict


def test_x_is_the_square_of_a_frequency() -> None:
    assert [square(at) for at in (Fraction(3, 2), Fraction(0), inf)] == [(9, 4), (0, 1), (1, 0)]


@pytest.mark.parametrize(
    ("terms", "bound", "holds"),
    [  # all on [1, 4]
        ([], X, True),
        ([], X - ONE, False),
        ([X], Poly.of(5), True),
        ([X], Poly.of(4), False),
        ([X, ONE], Poly.of(10), True),  # √4 + 1 = 3
        ([X, ONE], Poly.of(9), False),
        ([X, ONE], Poly.of(Fraction(89, 10)), False),
        ([X, X], X * Poly.of(4), False),  # √x + √x is not below √(4x)
        ([X, X], X * Poly.of(Fraction(41, 10)), True),
        ([X, X], X, False),
        ([X, ZERO], Poly.of(5), True),
    ],
)
def test_sums_of_roots_below_a_root(terms: list[Poly], bound: Poly, holds: bool) -> None:
    assert (counterexample(Inequality(terms, bound), UNIT, (4, 1), soon()) is None) is holds


def test_sums_of_roots_may_attain_a_bound_that_is_not_strict() -> None:
    for terms, bound in (([X], Poly.of(4)), ([X, X], X * Poly.of(4)), ([X, ONE], Poly.of(9))):
        assert counterexample(Inequality(terms, bound, strict=False), UNIT, (4, 1), soon()) is None
        assert counterexample(Inequality(terms, bound - X, strict=False), UNIT, (4, 1), soon()) is not None


def test_bernstein_coefficients() -> None:
    assert bernstein([1, 2, 3], NOUGHT, UNIT) == [2, 4, 12], "of (1, 2, 6), times 2"
    assert bernstein([1, 2, 3], NOUGHT, FAR) == [2, 2, 6]
    assert bernstein([0, 0, 0, 1], UNIT, (2, 1)) == [3, 6, 12, 24]
    assert bernstein([7], NOUGHT, FAR) == [7]


@pytest.mark.parametrize("row", [[5], [5, -3], [1, 2, 4], [3, -1, 4, 1, -5]])
def test_halves_have_the_bernstein_coefficients_of_the_two_halves(row: list[int]) -> None:
    """De Casteljau's means, times 2^n: the halves share the middle and keep their outer ends."""
    n, means = len(row) - 1, [[Fraction(a) for a in row]]
    while len(means[-1]) > 1:
        means.append([(u + w) / 2 for u, w in zip(means[-1][:-1], means[-1][1:], strict=True)])
    first, second = positivity._halves(row)
    assert first == [level[0] * 2**n for level in means]
    assert second == [level[-1] * 2**n for level in reversed(means)]


def middle(lo: Point, hi: Point, p: Row) -> Fraction:
    lo, hi = positivity._aligned(lo, hi, p)
    return Fraction(lo[0] + hi[0], lo[1] + hi[1])


def test_the_first_middle_is_the_mean() -> None:
    assert middle((1, 3), (5, 7), [1, 1]) == Fraction(11, 21)
    assert middle((2, 7), (2, 7), [1, 1]) == Fraction(2, 7)
    assert positivity._aligned(FAR, FAR, [1, 1]) == (FAR, FAR)


@pytest.mark.parametrize(
    ("p", "expected"),
    [
        ([1, 1], 0),
        ([-(2**40), 1], 40),
        ([-1, 2**40], -40),
        ([2**40, -7, 1], 20),
        ([2**41, -7, 1], 20),  # rounded down
        ([0, 0, 2**40, 5, 1, 0], 20),  # zeros at either end are no roots at this scale
        ([2**1000, 1], 300),
        ([1, 2**1000], -300),
        ([2**299, 1], 299),
        ([1, 2**299], -299),
        ([0, 0], 0),
        ([0], 0),
        ([7], 0),
    ],
)
def test_towards_infinity_it_is_at_the_scale_of_the_roots(p: list[int], expected: int) -> None:
    assert middle(NOUGHT, FAR, p) == Fraction(2) ** expected
    lo, _ = positivity._aligned((3, 5), FAR, p)
    assert Fraction(*lo) == Fraction(3, 5)
    assert middle((3, 5), FAR, p) == Fraction(3, 5) + Fraction(2) ** expected


@pytest.mark.parametrize("exponent", [-200, -30, 0, 30, 200])
def test_a_refutation_is_a_point_where_it_is_false(exponent: int) -> None:
    """Negative only within 10⁻⁶ of a third of a power of two, to the right and to the left of dyadic points."""
    place, width = Fraction(2) ** exponent / 3, Fraction(1, 10**6)
    p = (X - Poly.of(place)) * (X - Poly.of(place)) - Poly.of((place * width) ** 2)
    at = failure(p.c, NOUGHT, FAR, True, soon())
    assert at is not None and value(p.c, at) <= 0
    assert failure(p.c, (1, 1 << 300), (1 << 300, 1), False, soon()) is not None


def test_an_end_that_is_false_is_the_point() -> None:
    assert failure([-1, 2], NOUGHT, UNIT, False, soon()) == NOUGHT
    for p in ([1, -2], [0, -2]):
        assert failure(p, NOUGHT, UNIT, False, soon()) == UNIT
    assert failure([1, -2], NOUGHT, UNIT, True, soon()) == UNIT
    assert failure([-1, 0, -1], NOUGHT, UNIT, False, soon()) == NOUGHT, "the lower one first"
    at = failure([1, -1], NOUGHT, FAR, False, soon())
    assert at is not None and at[1] == 0
    for point in (UNIT, (7, 3), FAR):
        assert failure([1, 1], point, point, True, soon()) is None
        assert failure([-1, -1], point, point, False, soon()) is not None
        assert failure([1, 3, 3, 1, 0], point, point, True, soon()) == (FAR if point == FAR else None)


def test_a_coefficient_of_minus_1_is_not_overlooked() -> None:
    assert failure([0, -1, 5], NOUGHT, FAR, False, soon()) is not None
    assert failure([1, -1, -1, 1], NOUGHT, FAR, True, soon()) is not None  # (1 − x)² (1 + x)


def test_a_refutation_far_away_is_found_where_the_roots_are() -> None:
    """(x − c)² < (3c/4)² at c = 2²⁰⁰: seen at c/2, not after two hundred cells that each reach twice as far."""
    c = 2**200
    at = failure([7 * c * c // 16, -2 * c, 1], NOUGHT, FAR, False, soon())
    assert at is not None and Fraction(*at) == c // 2


THIRD, NEAR = [-1, 3], [1, -2 * 3 * 2**30, 9 * 2**60 + 1]  # (1 − c x)² + x², c = 3·2³⁰: |root − 1/c| is 1/c²
MISS, CROSS = [2**80 + 1, -6 * 2**80, 9 * 2**80], [2**80 - 1, -6 * 2**80, 9 * 2**80]  # (3x − 1)² ± 2⁻⁸⁰
REPEATED: dict[str, tuple[list[int], bool, bool]] = {  # p ≥ 0, and whether ≥ and > hold on [0, ∞]
    "touching at a third": (power(THIRD, 2), True, False),
    "touching four times": (power(THIRD, 4), True, False),
    "touching six times, and a factor": (product(power(THIRD, 6), [5, 1, 1]), True, False),
    "touching at two places": (product(power(THIRD, 2), power([-5, 7], 4)), True, False),
    "touching where the leading coefficient vanishes modulo the prime": (power([-1, PRIME], 2), True, False),
    "touching beside a root at the end": (product([0, 1], power(THIRD, 2)), True, False),
    "a near miss": (MISS, True, True),
    "a near miss, twice": (power(MISS, 2), True, True),
    "a near miss, three times": (power(MISS, 3), True, True),
    "a near miss with value 1 at the end, twice": (power(NEAR, 2), True, True),
    "a near miss, beside a factor that is repeated": (product(MISS, power([2, 1], 2)), True, True),
    "a near miss, beside one with others": (product(MISS, product([1, 1], power([2, 1], 2))), True, True),
    "a near miss where the leading coefficient vanishes modulo the prime": (
        [2**80 + 1, -6 * 2**80 * PRIME, 9 * 2**80 * PRIME**2],
        True,
        True,
    ),
    "a near miss, and touching": (product(power(MISS, 2), power(THIRD, 2)), True, False),
    "a narrow crossing": (CROSS, False, False),
    "a narrow crossing, three times": (power(CROSS, 3), False, False),
    "a narrow crossing, twice": (power(CROSS, 2), True, False),
    "a crossing, and touching": (product(power(THIRD, 4), CROSS), False, False),
    "one sign change at a triple root": (product(power(THIRD, 3), [-2, 6, 1]), False, False),
}


@pytest.mark.parametrize("name", REPEATED)
def test_repeated_roots_are_told_from_crossings(name: str) -> None:
    p, weak, strong = REPEATED[name]
    for row in (p, [6 * a for a in p]):
        assert (failure(row, NOUGHT, FAR, False, soon()) is None) is weak
        assert (failure(row, NOUGHT, FAR, True, soon()) is None) is strong
    assert (failure([*p, 0], NOUGHT, FAR, False, soon()) is None) is weak, "zero at infinity is ≥ 0"
    assert failure([*p, 0], NOUGHT, FAR, True, soon()) is not None
    assert (failure(p, (1, 5), (1, 2), False, soon()) is None) is weak


def test_halving_ends_at_a_depth_of_4000() -> None:
    """(x − 2^−k)² − 2^−3k is first seen to be negative at 2^−k, an end of cells of the k-th halving; or seen from 1."""

    def found(k: int, mirrored: bool) -> Fraction:
        c, b, a = 2**k - 1, -(2 ** (2 * k + 1)), 2 ** (3 * k)
        p = [a + b + c, -2 * a - b, a] if mirrored else [c, b, a]
        at = failure(p, NOUGHT, UNIT, False, soon())
        assert at is not None
        return 1 - Fraction(*at) if mirrored else Fraction(*at)

    for mirrored in (False, True):
        assert found(4000, mirrored) == Fraction(1, 2**4000)
        with pytest.raises(CheckError, match="neither proven nor refuted") as stop:
            found(4001, mirrored)
        assert stop.value.code == UNDECIDED


def test_the_readme_says_how_many_cells_there_may_be() -> None:
    (said,) = re.findall(r"([\d,]+) cells and", (CHECK / "README.md").read_text(encoding="utf-8"))
    assert int(said.replace(",", "")) == positivity.CELLS


def beside(depth: int) -> list[list[int]]:
    """x > ε or x < δ: on cells of width 2^−depth one of them everywhere, on twice as wide ones not."""
    return [[-1, 2 ** (depth + 1)], [3, -(2 ** (depth + 1))]]


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        *((beside(depth), depth <= 24) for depth in (1, 23, 24, 25)),
        ([[4**24 + 2, -6 * 4**24, 9 * 4**24]], True),  # at a third: a coefficient is 0 after 24 halvings
        ([[4**24 + 1, -6 * 4**24, 9 * 4**24]], False),
        ([[-1, 2], [2, -3]], True),  # small at the end, but positive
        ([[11, -60, 90]], True),  # a negative coefficient between the ends
        ([[-1, 1], [3, 0, -1]], True),  # not of the same degree
    ],
)
def test_one_of_several_polynomials_is_looked_for_in_24_halvings(rows: list[list[int]], said: bool) -> None:
    assert one_is_positive(rows, NOUGHT, UNIT, soon()) is said


@pytest.mark.parametrize("exponent", [-250, 0, 250])
def test_one_of_several_polynomials_is_looked_for_at_the_scale_of_their_roots(exponent: int) -> None:
    up, down = 2 ** max(exponent, 0), 2 ** max(-exponent, 0)
    assert one_is_positive([[-up, down], [2 * up, -down]], NOUGHT, FAR, soon())  # x > 2^exponent or x < 2 · 2^exponent
    assert not one_is_positive([[-2 * up, down], [up, -down]], NOUGHT, FAR, soon())
    assert one_is_positive([[-1], [-up, down], [2 * up, -down]], NOUGHT, FAR, soon()), "that of the highest degree"


@pytest.mark.parametrize("row", [[1, -1], [-1, 1], [0, 1], [1, 0]])
def test_zero_at_an_end_is_not_positive(row: list[int]) -> None:
    assert not one_is_positive([row, [-1, 0]], NOUGHT, UNIT if sum(row) == 0 else FAR, soon())


def test_halving_looks_at_the_clock() -> None:
    for row in ([1, 1], power(MISS, 2)):
        with pytest.raises(CheckError, match="time limit"):
            failure(row, NOUGHT, FAR, True, monotonic() - 1)
    with pytest.raises(CheckError, match="time limit"):
        one_is_positive([[1]], NOUGHT, FAR, monotonic() - 1)
