"""Whether `Σ √terms < √bound` on a cell for a range of parameters: coefficients, and what follows from them."""

from __future__ import annotations

import random
from collections.abc import Sequence
from fractions import Fraction
from itertools import product
from math import comb, prod
from typing import Any

import pytest

from robimp.synthesis.check.enclosure import search
from robimp.synthesis.check.enclosure.cells import Cell
from robimp.synthesis.check.enclosure.forms import Form
from robimp.synthesis.check.enclosure.search import compare, control, levelled
from robimp.synthesis.check.polynomials import ZERO, Poly
from robimp.synthesis.check.positivity import Inequality

POINT = Cell(Fraction(1), Fraction(1), False, {})  # ζ = −1
NEAR = Cell(Fraction(0), Fraction(1, 64), False, {})  # ζ in [−1, 0]
WIDE = Cell(Fraction(1), Fraction(4), False, {})  # ζ in [−1, −1/4]
SCALE = {1: 1, 2: 2, 4: 36}  # of Bernstein coefficients, for each parameter
Said = tuple[int, list[int]]
Value = int | Form


def form(c: int, r: int = 0, l: int = 0, m: int = 0, e: int = 0, q: int = 0, cell: Cell = POINT) -> Form:  # noqa: E741
    """`ζ^m 2^e (c + l t + q t² ± r)`."""
    return Form(cell, m, e, c, [l], q, r)


def parts_of(f: Form) -> tuple[int, int, int, list[int], int, int]:
    return f.m, f.e, f.c, f.l, f.q, f.r


def inequality(terms: Sequence[Value], bound: Value, strict: bool = True, over: Any = ZERO) -> Inequality:
    *forms, last = (v if isinstance(v, Form) else form(v) for v in (*terms, bound))
    return Inequality(forms, last, strict, over)


def grid(coefficients: Sequence[int], degree: int, n: int) -> list[int]:
    """Values on the grid, times degree^(degree n), of the polynomial with these Bernstein coefficients."""

    def basis(k: int, i: int) -> int:  # at i/degree
        return comb(degree, k) * int(i**k * (degree - i) ** (degree - k))

    digits = list(product(range(degree + 1), repeat=n))
    return [
        sum(c * prod(map(basis, place, at)) for c, place in zip(coefficients, digits, strict=True)) for at in digits
    ]


# Coefficients


@pytest.mark.parametrize(("degree", "n"), [(1, 0), (1, 1), (1, 3), (2, 0), (2, 1), (2, 2), (2, 3), (4, 1), (4, 2)])
def test_control_points_are_exactly_the_bernstein_coefficients_times_a_known_number(degree: int, n: int) -> None:
    rng = random.Random(f"{degree} {n}")
    c = [rng.randint(-9, 9) for _ in range((degree + 1) ** n)]
    times = (SCALE[degree] * degree**degree) ** n
    found = control([form(v) for v in grid(c, degree, n)], degree, n)
    assert [parts_of(f) for f in found] == [(0, 0, times * b, [0], 0, 0) for b in c]


# What is unknown, times the Lebesgue constant 1, 5/4 or 20/9 and SCALE, for each parameter; rounded up.
UNKNOWN = [
    (1, 0, [7], 8 + 1),
    (1, 1, [7, 3], 8 + 1),
    (1, 2, [1, 2, 3, 4], 5 + 1),
    (2, 1, [3, 0, 6], 17 + 1),  # 7 · 5/2
    (2, 2, [0] * 8 + [9], 62 + 1),  # 10 · 25/4
    (4, 1, [0, 4, 0, 0, 2], 5 * 80 + 1),
    (4, 2, [0] * 24 + [1], 2 * 6400 + 1),
]


@pytest.mark.parametrize(("degree", "n", "r", "unknown"), UNKNOWN)
def test_what_is_unknown_is_bounded_once_for_all_coefficients(degree: int, n: int, r: list[int], unknown: int) -> None:
    rng = random.Random(f"{degree} {n}")
    c = [rng.randint(1, 9) for _ in r]
    times = (SCALE[degree] * degree**degree) ** n
    found = levelled([form(v, r=x) for v, x in zip(grid(c, degree, n), r, strict=True)], degree, n)
    assert [parts_of(f) for f in found] == [(0, 0, times * b, [0], 0, unknown) for b in c]


@pytest.mark.parametrize(
    ("values", "unknown", "e"),
    [
        ([form(8, r=3), form(1, r=5, e=1), form(8, r=4)], (5 + 1) * 5 // 2 + 1, 1),
        ([form(8, r=3), form(1, r=0, e=2), form(8, r=9)], (2 + 1) * 5 // 2 + 1, 2),  # 9/4 is less than 3
        ([form(8, r=4), form(2, r=0, e=2), form(8, r=3)], (1 + 1) * 5 // 2 + 1, 2),
        ([form(0), form(0), form(0)], 1, 0),
        ([form(0, e=3), form(2), form(0)], (0 + 1) * 5 // 2 + 1, 3),
    ],
)
def test_what_is_unknown_is_in_the_coarsest_unit(values: list[Form], unknown: int, e: int) -> None:
    """The known part stays exact below it."""
    known = control([form(f.c, e=f.e) for f in values], 2, 1)
    for f, exact in zip(levelled(values, 2, 1), known, strict=True):
        assert f.r * Fraction(2) ** (f.e - e) == unknown
        assert (f.m, f.c * Fraction(2) ** f.e, f.l, f.q) == (0, exact.c * Fraction(2) ** exact.e, [0], 0)


def test_what_depends_on_the_place_or_on_a_symbol_is_known() -> None:
    cell = Cell(Fraction(1), Fraction(4), False, {("numerator", 0): (Fraction(-1), Fraction(1))})
    found = levelled([Form(cell, 0, 0, 5, [3, 7], -2, 1)] * 3, 2, 1)
    assert [parts_of(f) for f in found] == [(0, 0, 10, [6, 14], -4, 6)] * 3


# Conditions


def test_one_root_is_compared_by_a_difference_two_by_the_square_too() -> None:
    rows = [[form(7)], [form(4), form(7)], [form(9), form(4), form(30)]]
    found = [[[f.c * 2**f.e for f in values] for values in search._conditions([row, row])] for row in rows]
    assert found == [[[7, 7]], [[3, 3]], [[17, 17], [17 * 17 - 4 * 36] * 2]]


@pytest.mark.parametrize(
    ("b", "strict", "positive"),
    [
        ((1, 1, 1), True, True),
        ((1, 0, 1), True, True),  # 0 < 1 · 1
        ((10, -6, 10), True, True),
        ((4, -6, 9), True, False),  # touches
        ((4, -6, 9), False, False),
        ((4, -6, 10), True, True),
        ((5, -6, 9), False, True),
        ((10, -11, 10), True, False),
        ((0, 5, 1), True, False),
        ((1, 5, 0), True, False),
        ((0, 5, 0), True, False),
        ((-4, 5, 1), True, False),
        ((1, 5, -4), True, False),
        ((-4, 1, -4), True, False),  # b_0 b_2 is positive here
        ((form(9, r=2), form(0, r=1), form(9, r=1)), True, True),
        ((form(3, r=2), form(1, r=1), form(1, r=0)), False, True),  # b_1 ≥ 0
        ((form(3, r=2), form(1, r=2), form(3, r=0)), True, False),  # 1 · 3 and 3²
        ((form(3, r=3), form(4), form(3)), True, False),
        ((form(3), form(4), form(3, r=3)), True, False),
    ],
)
def test_a_quadratic_is_positive_between_positive_ends(b: tuple[Value, ...], strict: bool, positive: bool) -> None:
    assert search._quadratic([v if isinstance(v, Form) else form(v) for v in b], strict) == positive


# Coefficients, each with the parameters in which it is not a true value: what they say, and what to halve.
VERDICTS: list[tuple[list[tuple[list[int], Form]], bool, Said]] = [
    ([([], form(1)), ([0], form(2)), ([], form(3))], True, (1, [])),
    ([([], form(0)), ([0], form(2)), ([], form(3))], False, (1, [])),
    ([([], form(0)), ([0], form(2)), ([], form(3))], True, (0, [])),
    ([([], form(4)), ([0], form(0)), ([], form(3))], True, (0, [0])),
    ([([], form(-1)), ([], form(3))], True, (-1, [])),
    ([([], form(-2)), ([], form(3))], False, (-1, [])),
    ([([], form(3)), ([0], form(2)), ([], form(-1))], True, (-1, [])),
    ([([], form(3)), ([0], form(-9)), ([], form(3))], True, (0, [0])),  # not a true value
    ([([], form(3)), ([0], form(-9)), ([], form(-1))], True, (-1, [])),
    ([([], form(-1, r=1)), ([], form(3))], True, (0, [])),
    ([([], form(9)), ([0], form(-9)), ([1], form(-8)), ([0, 1], form(-7))], True, (0, [0])),  # the lowest
    ([([], form(9)), ([0], form(-7)), ([1], form(-8)), ([0, 1], form(-9))], True, (0, [0, 1])),
    ([([], form(9)), ([1], form(-8)), ([0], form(5)), ([0, 1], form(3))], True, (0, [1])),
    ([([], form(9)), ([0], form(-8, r=4)), ([1], form(-8, r=3))], True, (0, [1])),  # the better known
    ([([], form(9)), ([1], form(-8)), ([0], form(-8))], True, (0, [0])),
    ([([], form(9)), ([0], form(-1, r=9))], True, (0, [0])),  # 10 below the least corner and known to 9
    ([([], form(8)), ([0], form(-1, r=9))], True, (0, [])),
    ([([], form(7)), ([0], form(-1, r=9))], True, (0, [])),
    ([([], form(9)), ([], form(6)), ([0], form(-1, r=9))], True, (0, [])),
    ([([0], form(-1, r=9)), ([], form(99)), ([], form(6))], True, (0, [])),
    ([([], form(8)), ([0], form(-1, l=5, q=3, r=1))], True, (0, [])),
    ([([], form(9)), ([0], form(-1, l=5, q=3, r=1))], True, (0, [0])),
    ([([], form(8, e=1)), ([0], form(-1, r=4, e=2))], True, (0, [0])),  # 16 + 4 > 16
    ([([], form(6, e=1)), ([0], form(-1, r=4, e=2))], True, (0, [])),
]


@pytest.mark.parametrize(("slacks", "strict", "said"), VERDICTS)
def test_what_coefficients_say(slacks: list[tuple[list[int], Form]], strict: bool, said: Said) -> None:
    assert search._verdict(slacks, strict) == said


# Comparisons at one point of the parameters: terms, bound, strict, and what is said.
OPEN: Said = (0, [])
YES: Said = (1, [])
NO: Said = (-1, [])
COMPARED: list[tuple[list[Value], Value, bool, Said]] = [
    ([], 1, True, YES),
    ([], 0, True, OPEN),
    ([], 0, False, YES),
    ([], -1, True, NO),
    ([], -2, False, NO),
    ([4], 5, True, YES),
    ([4], 4, True, OPEN),
    ([4], 4, False, YES),
    ([5], 4, True, NO),
    ([6], 4, False, NO),
    ([0], 0, False, YES),
    ([0], 0, True, OPEN),
    ([1], 0, True, NO),
    ([8], form(10, r=1), True, YES),
    ([9], form(10, r=1), True, OPEN),
    ([9], form(10, r=1), False, YES),
    ([4, 9], 26, True, YES),
    ([4, 9], 25, True, OPEN),
    ([4, 9], 25, False, OPEN),
    ([4, 9], 24, True, NO),
    ([100, 1], 1, True, NO),  # h < 0, h² > 4 a1 a2
    ([0, 9], 10, True, YES),
    ([0, 4, 0], 4, False, YES),  # what is zero is no term
    ([0, 0, 0, 0], 0, False, YES),
    ([1, 4, 9], 37, True, YES),
    ([1, 4, 9], 35, True, NO),
    ([1, 4, 9], 35, False, NO),
    ([1, 4, 9, 16], 101, True, YES),
    ([1, 4, 9, 16], 99, True, NO),
    ([1, 4, 9], form(1, r=2), True, NO),  # the bound's root is at most √3
    ([form(-4, m=1)], form(-5, m=1), True, YES),  # times ζ = −1
    ([form(-5, m=1)], form(-4, m=1), True, NO),
    ([form(4, m=2)], form(5, m=2), True, YES),
    ([form(5, m=2)], form(4, m=2), True, NO),
    ([form(-4, m=3)], form(-5, m=3), True, YES),
    ([form(-5, m=3)], form(-4, m=3), True, NO),
    ([form(-4, m=-1)], form(-5, m=-1), True, YES),
    ([form(4 << 20, m=2)], form(-5 << 20, m=1), True, YES),
    ([form(5 << 20, m=2)], form(-4 << 20, m=1), True, NO),
    ([form(-4 << 20, m=1)], form(5 << 20), True, YES),
    ([form(4 << 20, m=2), form(-9 << 20, m=1)], form(26 << 20), True, YES),
    ([form(4 << 20, m=2), form(-9 << 20, m=1)], form(24 << 20), True, NO),
    ([form(-1, m=1), form(-4, m=1), form(-9, m=1)], form(-37, m=1), True, YES),
    ([form(-1, m=1), form(-4, m=1), form(-9, m=1)], form(-35, m=1), True, NO),
    ([form(1, m=2), form(4, m=2), form(9, m=2)], form(35, m=2), True, NO),
    ([form(-1 << 20, m=1), form(4 << 20, m=2), form(9 << 20)], form(-37 << 20, m=3), True, YES),
    ([form(-1 << 20, m=1), form(4 << 20, m=2), form(9 << 20)], form(-35 << 20, m=3), True, NO),
    ([form(-1, m=1, e=3)], form(-1, m=1, e=4), True, YES),
    ([form(-1, m=1, r=1)], form(-3, m=1), True, YES),
    ([form(-1, m=1, r=2)], form(-3, m=1), True, OPEN),
]


@pytest.mark.parametrize(("terms", "bound", "strict", "said"), COMPARED)
def test_sums_of_roots_are_compared(terms: list[Value], bound: Value, strict: bool, said: Said) -> None:
    assert compare(POINT, [inequality(terms, bound, strict)]) == said


def test_the_degree_is_two_if_it_is_not_said() -> None:
    assert compare(POINT, [inequality([4], 5)] * 3, n=1) == YES


def test_polynomials_become_forms_of_the_cell() -> None:
    two, three = Poly.of(1, 1), Poly.of(Fraction(5, 2), Fraction(1, 2))  # at x = 1
    assert compare(POINT, [Inequality([two], three)]) == YES
    assert compare(POINT, [Inequality([three], two)]) == NO
