"""Comparisons over ranges of parameters, and at the ends ω = 0 and ∞: what is proven, refuted, or halved where."""

from __future__ import annotations

import random
from fractions import Fraction
from itertools import product
from math import prod
from time import monotonic
from typing import Any

import pytest
from test_comparison_on_cells import NEAR, POINT, WIDE, Said, Value, form, grid, inequality

from robimp.synthesis.check.enclosure import search
from robimp.synthesis.check.enclosure.cells import Cell
from robimp.synthesis.check.enclosure.forms import Form
from robimp.synthesis.check.enclosure.search import compare, cover
from robimp.synthesis.check.polynomials import ZERO, Poly
from robimp.synthesis.check.positivity import Inequality

OPEN: Said = (0, [])
YES: Said = (1, [])
NO: Said = (-1, [])


# At the ends the smallest power of ζ decides.


@pytest.mark.parametrize(
    ("terms", "bound", "said"),
    [
        ([(4, 2)], (-5, 1), YES),  # 4 ζ² < 5 |ζ|, over |ζ|
        ([(5, 2)], (-4, 1), NO),
        ([(-4, 1)], (5, 2), NO),
        ([(1, 0)], (-5, 1), NO),
        ([(-5, 1)], (6, 0), YES),
        ([(-6, 1)], (5, 0), NO),
        ([(-5 << 20, 1)], (1, 0), NO),  # the largest has not the smallest power
        ([(4, 2)], (5, 2), YES),
        ([(5, 2)], (4, 2), NO),
        ([(4, 2), (-9, 1)], (99, 0), YES),
        ([(-4, 3), (9, 2)], (-1, 1), NO),
    ],
)
def test_an_end_is_decided_by_the_smallest_power(
    terms: list[tuple[int, int]], bound: tuple[int, int], said: Said
) -> None:
    *forms, last = (form(c, m=m, cell=NEAR) for c, m in (*terms, bound))
    assert compare(NEAR, [Inequality(forms, last)]) == said


ONE, TURNED, VAGUE = form(1, cell=NEAR), form(-1, cell=NEAR), form(0, r=5, cell=NEAR)
FIRST, SECOND = form(-1, m=1, cell=NEAR), form(1, m=2, cell=NEAR)  # |ζ| and ζ²


@pytest.mark.parametrize(
    ("bound", "over", "strict", "said"),
    [
        (FIRST, ONE, True, NO),  # |ζ|/1 is 0 in the limit
        (FIRST, TURNED, True, NO),
        (SECOND, FIRST, True, NO),
        (FIRST, VAGUE, True, OPEN),  # as far as is known, it may not be
        (FIRST, ONE, False, YES),
        (FIRST, FIRST, True, YES),
        (FIRST, SECOND, True, YES),
        (ONE, FIRST, True, YES),
        (ONE, ONE, True, YES),
        (FIRST, ZERO, True, YES),
    ],
)
def test_a_bound_that_vanishes_at_an_end_beside_what_it_was_multiplied_by_is_not_positive_there(
    bound: Form, over: Any, strict: bool, said: Said
) -> None:
    assert compare(NEAR, [Inequality([], bound, strict, over)]) == said


def test_it_is_not_above_a_root_either() -> None:
    assert compare(NEAR, [Inequality([VAGUE], FIRST, True, ONE)]) == NO
    assert compare(NEAR, [Inequality([SECOND], FIRST, True, ONE)]) == NO


@pytest.mark.parametrize(("cell", "over"), [(WIDE, form(1, cell=WIDE)), (POINT, form(1)), (POINT, form(-1))])
def test_between_the_ends_nothing_vanishes(cell: Cell, over: Form) -> None:
    assert compare(cell, [Inequality([], form(-1, m=1, cell=cell), True, over)]) == YES


def test_with_a_parameter_a_vanishing_bound_is_left_open() -> None:
    one = Inequality([], form(-2, m=1, cell=NEAR), True, ONE)
    assert compare(NEAR, [one] * 2, 1, 1) == OPEN
    others = Inequality([], form(9, cell=NEAR), True, ONE)
    assert compare(NEAR, [others, one, others], 2, 1) == OPEN  # one of the values is enough


@pytest.mark.parametrize("largest", ["bound", "term"])
@pytest.mark.parametrize("m", [0, 3])
def test_between_the_ends_what_is_largest_keeps_its_power(largest: str, m: int) -> None:
    """On so wide a cell another power of ζ would not be known well enough for so small a share."""
    sign, share, small = (-1) ** m, 2**60 - 2**52, (-1) ** (3 - m) * 2**20
    steep = form(sign * 2**60, l=sign * share, m=m, cell=WIDE)
    other = form(small, m=3 - m, cell=WIDE)
    if largest == "bound":
        assert compare(WIDE, [Inequality([other], steep)]) == YES
    else:
        bend = form(sign * (2**60 + 2**52), l=sign * share, m=m, cell=WIDE)
        assert compare(WIDE, [Inequality([other, steep], bend)]) == YES


# One parameter: values at the grid.
VALUES: list[tuple[int, list[Value], bool, Said]] = [
    (2, [1, 1, 1], True, YES),
    (2, [-1, 9, 9], True, NO),
    (2, [9, 9, -1], True, NO),
    (2, [9, -9, 9], True, (0, [0])),  # false, but only corners refute
    (2, [5, 1, 5], True, YES),  # Bernstein coefficients 5, −3, 5
    (2, [1, 0, 1], True, (0, [0])),
    (2, [0, 1, 2], False, YES),
    (2, [0, 1, 2], True, OPEN),
    (2, [0, form(5, r=1), form(10, r=1)], False, YES),  # at a corner only its own r counts
    (2, [form(1000, r=r) for r in (795, 795, 795)], True, YES),  # 5/4 · 796 < 1000
    (2, [form(1000, r=r) for r in (801, 801, 801)], True, (0, [])),
    (2, [form(-1000, r=r, m=1) for r in (795, 795, 795)], True, YES),  # times ζ = −1
    (2, [form(1000, r=r, m=2) for r in (795, 795, 795)], True, YES),
    (1, [1, 1], True, YES),
    (1, [1, -1], True, NO),
    (1, [-1, 1], True, NO),
    (1, [0, 1], False, YES),
    (4, [1, 1, 1, 1, 1], True, YES),
    (4, [9, 9, 9, 9, -1], True, NO),
    (4, [-1, 9, 9, 9, 9], True, NO),
    (4, [9, -9, 9, 9, 9], True, (0, [0])),
    (4, [9, 9, 9, -9, 9], True, (0, [0])),
    (4, [*grid([3, 3, 3, -9, 3], 4, 1)], True, (0, [0])),  # the first three are not all
    (4, [*grid([5, -3, 5, -9, 1], 4, 1)], True, (0, [0])),
    (4, [form(1000, r=r) for r in (448, 448, 448, 448, 448)], True, YES),  # 20/9 · 449 < 1000
]


@pytest.mark.parametrize(("degree", "values", "strict", "said"), VALUES)
def test_a_polynomial_in_one_parameter(degree: int, values: list[Value], strict: bool, said: Said) -> None:
    assert compare(POINT, [inequality([], v, strict) for v in values], degree, 1) == said


@pytest.mark.parametrize(
    ("place", "said"),
    [
        ((0, 0), NO),
        ((0, 2), NO),
        ((2, 0), NO),
        ((2, 2), NO),
        ((1, 0), (0, [0])),
        ((1, 2), (0, [0])),
        ((0, 1), (0, [1])),
        ((2, 1), (0, [1])),
        ((1, 1), (0, [0, 1])),
        (None, YES),
    ],
)
def test_a_low_coefficient_of_two_parameters(place: tuple[int, int] | None, said: Said) -> None:
    """The first three are a positive quadratic in most of these: that is not enough."""
    digits = list(product(range(3), repeat=2))
    values = grid([-7 if at == place else 9 for at in digits], 2, 2)
    assert compare(POINT, [inequality([], v) for v in values], 2, 2) == said


@pytest.mark.parametrize(("bound", "said"), [(26, YES), (25, (0, [])), (24, NO)])
def test_two_roots_are_squared_where_the_degree_allows_it(
    bound: int, said: Said, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(search, "_moduli", lambda *_: pytest.fail("by roots"))
    assert compare(POINT, [inequality([4, 9], bound)] * 5, 4, 1) == said
    assert compare(POINT, [inequality([4, 9], bound)], 2, 0) == said
    assert compare(POINT, [inequality([4], bound)] * 9, 2, 2) == YES
    assert compare(POINT, [inequality([4], bound)] * 2, 1, 1) == YES


@pytest.mark.parametrize(("terms", "degree", "n"), [(3, 4, 1), (3, 2, 0), (2, 2, 1), (2, 1, 2), (4, 4, 0)])
def test_more_roots_are_taken_by_roots(terms: int, degree: int, n: int, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Any] = []

    def moduli(rows: list[list[Form]], *given: int) -> Said:
        asked.append(([[f.c for f in row] for row in rows], *given))
        return 1, [7]

    monkeypatch.setattr(search, "_moduli", moduli)
    count = (degree + 1) ** n
    assert compare(POINT, [inequality([1] * terms, 9)] * count, degree, n) == (1, [7])
    assert asked == [([[*[1] * terms, 9]] * count, degree, n)]


def test_a_term_that_is_zero_at_some_values_only_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(search, "_moduli", lambda rows, *_: (0, [len(row) for row in rows]))
    rows = [inequality([4, 0, 0], 9), inequality([4, 1, 0], 9), inequality([0, 0, 0], 9)]
    assert compare(POINT, rows, 2, 1) == (0, [3, 3, 3])


def value(f: Form, t: Fraction) -> Fraction:
    return f.c + f.l[0] * t + f.q * t * t


@pytest.mark.parametrize(("degree", "n"), [(2, 1), (2, 2), (4, 1)])
def test_random_comparisons_are_true(degree: int, n: int) -> None:
    """However values are that are known to ±r: what is proven holds between them, what is refuted fails at a corner."""
    rng, counts = random.Random(f"{degree} {n}"), {1: 0, -1: 0, 0: 0}
    fine = 8 if n == 1 else 3
    places = list(product(range(degree * fine + 1), repeat=n))

    def weight(k: int, u: int) -> Fraction:
        others = (i for i in range(degree + 1) if i != k)
        return prod(((Fraction(u, fine) - i) / (k - i) for i in others), start=Fraction(1))

    lagrange = [[weight(k, u) for u in range(degree * fine + 1)] for k in range(degree + 1)]
    digits = list(product(range(degree + 1), repeat=n))
    one = Fraction(1)
    weights = [[prod((lagrange[k][u] for k, u in zip(d, p, strict=True)), start=one) for d in digits] for p in places]
    for _ in range(40):
        most, spread = rng.choice([(300, 0), (120, 20), (40, 200), (20, 600)])
        middle, slope, bend = rng.randint(0, 600), rng.randint(-90, 90), rng.randint(-90, 90)
        forms = [
            Form(WIDE, 0, 0, middle + u, [slope + rng.randint(-9, 9)], bend + rng.randint(-9, 9), rng.randint(0, most))
            for u in (rng.randint(-spread, spread) for _ in digits)
        ]
        said, _ = compare(WIDE, [Inequality([], f) for f in forms], degree, n)
        counts[said] += 1
        if said > 0:
            t = rng.choice((Fraction(-1), Fraction(1), Fraction(rng.randint(-9, 9), 9)))
            known = [(value(f, t), f.r) for f in forms]
            assert all(sum(v * w - r * abs(w) for (v, r), w in zip(known, many, strict=True)) > 0 for many in weights)
        if said < 0:
            corners = [f for f, d in zip(forms, digits, strict=True) if all(k in (0, degree) for k in d)]
            bottoms = [max(Fraction(-1), min(Fraction(1), Fraction(-f.l[0], 2 * f.q or 1))) for f in corners]
            tried = ((f, t) for f, b in zip(corners, bottoms, strict=True) for t in (Fraction(-1), Fraction(1), b))
            assert any(value(f, t) + f.r <= 0 for f, t in tried)
    assert all(count >= 3 for count in counts.values()), counts


def test_a_range_is_halved_until_its_polynomial_is_decided() -> None:
    """(u − 1/3)² > c for u in [0, 1] and all ω: with c < 0 it is proven, with c > 0 found false between the corners."""
    key = ("impedance", "stiffness")

    def said(c: Fraction) -> str:
        def parts(_: Cell, at: dict[Any, Fraction]) -> list[Inequality]:
            return [Inequality([], Poly.of((at[key] - Fraction(1, 3)) ** 2 - c))]

        return cover([WIDE], parts, monotonic() + 20, {key: (Fraction(0), Fraction(1))}, 4)

    assert said(Fraction(-1, 10**9)) == ""
    assert said(Fraction(1, 10**9)) == " at ω = 1 rad/s"
