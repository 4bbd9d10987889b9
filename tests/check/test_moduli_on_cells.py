"""Sums of three moduli or more on a cell: `Σ |a + b u + c w| < √bound` for u and w in [0, 1]."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from itertools import product

import pytest
from test_comparison_on_cells import POINT, Said, form, inequality
from test_parameters_on_cells import NO, OPEN, YES

from robimp.synthesis.check.enclosure import search
from robimp.synthesis.check.enclosure.forms import Form
from robimp.synthesis.check.enclosure.search import compare
from robimp.synthesis.check.polynomials import Poly
from robimp.synthesis.check.positivity import Inequality

EPS = Fraction(1, 10**12)


def moduli(rows: Sequence[tuple[int, ...]], bound: Callable[..., Fraction | int], degree: int, n: int) -> Said:
    places = product([Fraction(k, degree) for k in range(degree + 1)], repeat=n)
    same = []
    for at in places:
        squares = [(a + sum(b * u for b, u in zip(more, at, strict=True))) ** 2 for a, *more in rows]
        same.append(Inequality([Poly.of(v) for v in squares], Poly.of(bound(*at))))
    return compare(POINT, same, degree, n)


@pytest.mark.parametrize(("degree", "n"), [(2, 0), (2, 1), (2, 2), (4, 1), (1, 1), (4, 2)])
@pytest.mark.parametrize("gap", [EPS, -EPS])
def test_the_sum_is_largest_at_a_corner(degree: int, n: int, gap: Fraction) -> None:
    """Against the largest, a hair above and a hair below."""
    rows = [(2, 1, -1)[: n + 1], (-5, -1, -2)[: n + 1], (3, 0, 1)[: n + 1], (1, -1, 0)[: n + 1]]
    top = max(sum(abs(a + sum(map(int.__mul__, b, at))) for a, *b in rows) for at in product((0, 1), repeat=n))
    assert moduli(rows, lambda *_: top**2 * (1 + gap), degree, n) == (YES if gap > 0 else NO)


def test_what_is_halved_is_where_the_bound_is_least_and_the_sum_largest_in_different_places() -> None:
    first, second = [(1, 1), (2, 1), (3, 0)], [(1, 0, 1), (2, 0, 1), (3, -1, 0)]
    assert moduli(first, lambda u: (6 + 2 * u) ** 2 * (1 + EPS), 2, 1) == (0, [0])
    assert moduli(second, lambda u, w: (6 + 2 * w + u / 100) ** 2 * (1 + EPS), 2, 2) == (0, [1])
    assert moduli(first, lambda u: (6 + 2 * u) ** 2 * (1 - EPS), 2, 1) == NO


def test_a_bound_that_may_be_negative_is_halved_in_all_parameters() -> None:
    """8 (u − 1/2)² + 1 has the Bernstein coefficients 3, −1, 3."""
    assert moduli([(0, 0), (0, 0), (0, 0)], lambda u: 8 * (u - Fraction(1, 2)) ** 2 + 1, 2, 1) == YES  # no terms
    assert moduli([(1, 0), (1, 0), (1, 0)], lambda u: 800 * (u - Fraction(1, 2)) ** 2 + 10, 2, 1) == (0, [0])
    assert moduli([(1, 0, 0), (1, 0, 0)], lambda u, w: 800 * (u - Fraction(1, 2)) ** 2 + 10, 2, 2) == (0, [0, 1])
    assert moduli([(9, 0), (9, 0)], lambda u: 4 * u, 2, 1) == (0, [0])  # 0 at a corner


@pytest.mark.parametrize(("r", "said"), [(795, YES), (801, OPEN)])
def test_the_bound_of_a_sum_is_known_to_the_lebesgue_constant(r: int, said: Said) -> None:
    same = [inequality([0, form(1, r=0), form(1, r=0)], form(1004, r=r))] * 3
    assert compare(POINT, same, 2, 1)[0] == said[0]


def test_a_sum_has_to_be_less_whatever_is_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    """Also if it may be equal; and at one point of the parameters the bound is a value, not a lower bound."""
    asked: list[bool] = []

    def verdict(_: list[tuple[list[int], Form]], strict: bool) -> Said:
        asked.append(strict)
        return YES

    monkeypatch.setattr(search, "_verdict", verdict)
    monkeypatch.setattr(search, "levelled", lambda *_: pytest.fail("a lower bound"))
    assert compare(POINT, [inequality([1, 1, 1], 10, strict=False)], 2, 0) == YES
    assert asked == [True]
