"""Cells of ω: their coordinate, their halves, and those that cover an interval."""

from __future__ import annotations

import math
from fractions import Fraction
from itertools import pairwise
from typing import Any

import pytest

from robimp.synthesis.check.enclosure.cells import Cell, roots
from robimp.synthesis.check.joint import Ranges

F = Fraction
TWO: Ranges = {("plant", "inertia"): (F(1), F(2)), ("plant", "damping"): (F(1), F(2))}


def ends(found: list[Cell]) -> list[tuple[Any, Any, bool]]:
    """χ where the cells begin and end, and whether it is 1/x."""
    return [(cell.lo, cell.hi, cell.far) for cell in found]


@pytest.mark.parametrize(
    ("lo", "hi", "b"),
    [(0, F(0), 0), (0, F(1), 0), (0, F(3), 1), (0, F(4), 2), (F(3, 7), F(3, 7), -1), (0, F(1, 100), -6), (5, F(7), 2)],
)
def test_zeta_is_about_one_where_chi_is_largest(lo: Fraction, hi: Fraction, b: int) -> None:
    cell = Cell(F(lo), hi, False, TWO)
    assert cell.b == b and (not hi or F(1, 2) < hi / F(2) ** cell.b < 2)
    assert cell.ends == (lo == 0) and cell.key == (lo, hi, False, tuple(TWO.items()))


@pytest.mark.parametrize("far", [False, True])
def test_halves_are_two_cells_the_one_at_smaller_frequency_first(far: bool) -> None:
    wide = Cell(F(0), F(1, 4), True, TWO) if far else Cell(F(0), F(4), False, TWO)
    if far:  # [4, ∞] = [4, 16] and [16, ∞]
        assert ends(wide.halves()) == [(4, 16, False), (0, F(1, 16), True)]
    else:
        assert ends(wide.halves()) == [(0, 1, False), (1, 4, False)]
        assert ends(Cell(F(1), F(4), False, TWO).halves()) == [(1, F(5, 2), False), (F(5, 2), 4, False)]
    assert all(half.ranges is TWO for half in wide.halves())


def test_a_cell_says_where_it_begins() -> None:
    assert str(Cell(F(1, 9), F(1), False, {})) == " at ω = 0.333333 rad/s"
    assert str(Cell(F(0), F(1), True, {})) == " at ω = inf"


def test_all_frequencies_are_cut_at_powers_of_four() -> None:
    points = [F(0), *(F(4) ** k for k in range(-6, 15))]
    cuts = [*((lo, hi, False) for lo, hi in pairwise(points)), (F(0), F(1, 4**14), True)]
    found = roots((F(0), math.inf), [], TWO)
    assert ends(found) == cuts and all(cell.ranges is TWO for cell in found)


@pytest.mark.parametrize(
    ("interval", "breaks", "cuts"),
    [
        (("1", "3"), (), [1, 2, 4, 9]),
        (("1", "2"), ("1", "2", "3/2"), [1, 2, F(9, 4), 4]),
        (("3", "4"), ("7/2", "5", "1/2"), [9, F(49, 4), 16]),
        (("100000", "200000"), (), [10**10, 2 * 10**10, 4 * 10**10]),
        (("1/1000", "1/500"), (), [F(1, 10**6), F(2, 10**6), F(4, 10**6)]),
    ],
)
def test_an_interval_is_cut_at_breaks_too_and_where_its_beginning_has_doubled(
    interval: tuple[str, str], breaks: tuple[str, ...], cuts: list[Fraction]
) -> None:
    found = roots((F(interval[0]), F(interval[1])), [F(b) for b in breaks], {})
    assert ends(found) == [(a, b, False) for a, b in pairwise(cuts)]


def test_a_high_interval_to_infinity_and_single_frequencies() -> None:
    assert ends(roots((F(10**9), math.inf), [], {})) == [(10**18, 2 * 10**18, False), (0, F(1, 2 * 10**18), True)]
    assert ends(roots((F(3), F(3)), [F(3)], TWO)) == [(9, 9, False)]
    assert ends(roots((F(0), F(0)), [], {})) == [(0, 0, False)]
    (point,) = roots((math.inf, math.inf), [F(2)], TWO)  # type: ignore[arg-type]
    assert ends([point]) == [(0, 0, True)] and point.ranges is TWO
