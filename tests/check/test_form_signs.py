"""The sign of a form: never said of a value that has another one, and said where the value is one unit away from 0."""

from __future__ import annotations

from fractions import Fraction
from itertools import product

import pytest

from robimp.synthesis.check.enclosure.cells import Cell
from robimp.synthesis.check.enclosure.forms import Form, UnresolvedError, dip
from robimp.synthesis.check.outcome import UNDECIDED, CheckError

CELL = Cell(Fraction(1), Fraction(4), False, {})
SMALL = range(-9, 10)


def form(c: int = 0, l: list[int] | None = None, q: int = 0, r: int = 0, m: int = 0) -> Form:  # noqa: E741
    return Form(CELL, m, 0, c, l or [0], q, r)


def lowest(slope: int, q: int) -> Fraction:
    """The least value of `slope t + q t²` for |t| ≤ 1: at an end, or at t = −slope/(2q)."""
    inner = [Fraction(-slope, 2 * q)] if q and abs(slope) <= abs(2 * q) else []
    return min(slope * t + q * t * t for t in [Fraction(-1), Fraction(1), *inner])


def test_the_dip_is_not_above_the_least_value_and_at_most_one_below() -> None:
    for slope, q in product(SMALL, SMALL):
        true, said = lowest(slope, q), dip(slope, q)
        assert true - 1 <= said <= true, (slope, q)
        assert said == true or 2 * q > abs(slope), (slope, q)  # what is least at an end of the cell is exact


@pytest.mark.parametrize("slope, q", [(10**18 + 1, 10**18), (-(2**63), 2**62 + 1), (3, 2**62), (2**63 - 1, 2**62)])
def test_the_dip_of_large_numbers(slope: int, q: int) -> None:
    assert lowest(slope, q) - 1 <= dip(slope, q) < lowest(slope, q)
    assert dip(slope, -q) == -q - abs(slope)


@pytest.mark.parametrize("r", [0, 1])
@pytest.mark.parametrize("other", [0, -2])
def test_a_sign_is_that_of_every_value_and_is_found_one_unit_from_zero(other: int, r: int) -> None:
    """`c + l_0 t_0 + l_1 t_1 + q t_0² ± r`: all of it is positive, or somewhere it cannot be."""
    for c, slope, q in product(range(-7, 8), range(-3, 4), range(-3, 4)):
        true = c + lowest(slope, q) - abs(other)  # the least value of what is known
        for strict in (True, False):
            said, case = form(c, [slope, other], q, r).sign(strict), (c, slope, q, strict)
            if said == 1:
                assert true - r > 0 or (true == r and not strict), case
            if said == -1:  # at one point, whatever r hides
                assert true + r < 0 or (true == -r and strict), case
            assert said == 1 or true - r < 1 or (strict and true - r == 1), case
            assert said == -1 or true + r > -1 or (true + r == -1 and not strict), case


ENDS = [  # c, least value at an end: what is said if > 0 is asked, and if ≥ 0 is
    (-2, -1, -1),
    (-1, -1, 0),  # there one more unit may be missing
    (0, 0, 1),
    (1, 1, 1),
]


@pytest.mark.parametrize("c, strict, weak", ENDS)
@pytest.mark.parametrize(
    "slopes, q", [([0], 0), ([3], 0), ([-3], 1), ([1], -2), ([0, 3], 0), ([1, -2, 3], 0), ([2, 1], 1)]
)
def test_at_an_end_of_the_cell_the_sign_is_that_of_the_integer(
    c: int, strict: int, weak: int, slopes: list[int], q: int
) -> None:
    f = form(c + sum(map(abs, slopes)) - q, slopes, q)
    assert (f.sign(), f.sign(strict=True), f.sign(strict=False)) == (strict, strict, weak)


UNKNOWN = [(3, 2, 1, 1), (2, 2, 0, 1), (1, 2, 0, 0), (-2, 2, 0, 0), (-3, 2, -1, 0), (-4, 2, -1, -1)]


@pytest.mark.parametrize("c, r, strict, weak", UNKNOWN)
def test_what_is_unknown_counts_against_both_answers(c: int, r: int, strict: int, weak: int) -> None:
    assert (form(c, r=r).sign(), form(c, r=r).sign(strict=False)) == (strict, weak)


@pytest.mark.parametrize("m", range(-3, 5))
def test_an_odd_power_of_zeta_turns_the_sign(m: int) -> None:
    """ζ < 0: `ζ^m (5 + 2 t_0 + t_1)` and `ζ^m (5 − 2 t_0 ± 9)`."""
    sign = -1 if m % 2 else 1
    assert (form(5, [2, 1], m=m).sign(), form(-5, [2, 1], m=m).sign()) == (sign, -sign)
    assert form(5, [-2], r=9, m=m).sign() == form(-5, [-2], r=9, m=m).sign() == 0


@pytest.mark.parametrize("m, q, c, said", [(0, 8, 3, 1), (0, -8, 3, -1), (1, 8, -3, -1), (1, -8, -3, 1), (1, 8, -9, 1)])
def test_the_bend_turns_with_it(m: int, q: int, c: int, said: int) -> None:
    """`3 + 8 t²` is positive, `−3 − 8 t²` times ζ is too; `3 − 8 t²` is not."""
    assert form(c, q=q, m=m).sign() == said


def test_what_is_not_resolved_is_undecided() -> None:
    with pytest.raises(CheckError, match="neither proven nor refuted") as caught:
        raise UnresolvedError
    assert caught.value.code == UNDECIDED
