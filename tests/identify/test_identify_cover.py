"""The weight covers its steps at every frequency, by proof; and one that does not is seen not to."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robimp.synthesis.identify.cover import MOST_STEPS, Step, cover, covers, steps
from robimp.synthesis.spec.model import Polynomials

RISING = tuple((Fraction(w), Fraction(b)) for w, b in ((1, "0.1"), (3, "0.12"), (10, "0.5"), (30, "1.2"), (60, "1.5")))
PEAK = tuple(
    (Fraction(w), Fraction(b)) for w, b in ((1, "0.1"), (5, "0.3"), (7, "2"), (9, "0.35"), (40, "0.1"), (80, "0.1"))
)


def gain(weight: Polynomials, omega: np.ndarray) -> np.ndarray:
    parts = ([float(c) for c in part] for part in (weight.numerator, weight.denominator))
    N, D = (np.polyval(part, 1j * omega) for part in parts)
    return abs(N / D)


def test_the_steps_are_the_larger_neighbours_and_what_is_stated_outside() -> None:
    bounds = tuple((Fraction(w), Fraction(b)) for w, b in ((1, 2), (2, 1), (3, 1), (4, 3)))
    found = [(step.low, step.high, step.bound) for step in steps(bounds, Fraction(2), Fraction(5))]
    assert found == [(0, 2, 2), (2, 3, 1), (3, 4, 3), (4, None, 5)]


@pytest.mark.parametrize("bounds", [RISING, PEAK], ids=["rising", "peak"])
@pytest.mark.parametrize("order", range(7))
def test_every_order_covers_at_every_frequency(bounds: tuple[tuple[Fraction, Fraction], ...], order: int) -> None:
    wanted = steps(bounds, bounds[0][1], bounds[-1][1])
    weight = cover(wanted, order)
    assert len(weight.denominator) - 1 <= order
    assert covers(weight, wanted)
    omega = np.geomspace(1e-3, 1e4, 20_001)  # a second opinion, in floats
    for step in wanted:
        inside = (omega >= float(step.low)) & (omega <= float(step.high or 1e9))
        assert (gain(weight, omega[inside]) >= float(step.bound) * (1 - 1e-12)).all()
    for part in (weight.numerator, weight.denominator):
        roots = np.roots([float(c) for c in part])
        assert (roots.real < 0).all(), "stable and minimum phase"


def test_a_weight_of_some_order_follows_what_a_constant_cannot() -> None:
    for bounds in (RISING, PEAK):
        wanted = steps(bounds, bounds[0][1], bounds[-1][1])
        omega, level = (np.array([float(row[k]) for row in bounds]) for k in (0, 1))
        constant, second = (np.log(gain(cover(wanted, order), omega) / level).mean() for order in (0, 2))
        assert second < 0.6 * constant


@pytest.mark.parametrize("order", [0, 1, 2, 4])
def test_a_weight_that_falls_short_anywhere_does_not_cover(order: int) -> None:
    wanted = steps(PEAK, Fraction("0.1"), Fraction("0.1"))
    weight = cover(wanted, order)
    by_a_third = tuple(c * Fraction(2, 3) for c in weight.numerator)
    assert not covers(weight.model_copy(update={"numerator": by_a_third}), wanted)
    needle = (*wanted[:-1], Step(Fraction(100), Fraction(100), Fraction(3)), wanted[-1])
    assert not covers(weight, needle), "one point, on no grid"


@pytest.mark.parametrize(
    ("numerator", "denominator"), [([10, -100], [1, 1]), ([10, 100], [1, -1]), ([100, 0], [1, 1]), ([100], [1, 1])]
)
def test_unstable_or_not_minimum_phase_or_vanishing_at_an_end_does_not_cover(
    numerator: list[int], denominator: list[int]
) -> None:
    wanted = (Step(Fraction(0), None, Fraction(1)),)
    assert covers(Polynomials(numerator=(Fraction(10), Fraction(100)), denominator=(Fraction(1), Fraction(1))), wanted)
    given_ = Polynomials(numerator=tuple(map(Fraction, numerator)), denominator=tuple(map(Fraction, denominator)))
    assert not covers(given_, wanted)


def test_nothing_to_cover_and_very_much() -> None:
    assert cover((Step(Fraction(0), None, Fraction(0)),), 3).numerator[0] > 0
    many = tuple((Fraction(k), Fraction(k % 7 + 1, 10)) for k in range(1, 6 * MOST_STEPS))
    wanted = steps(many, many[0][1], many[-1][1])
    assert covers(cover(wanted, 2), wanted)


@settings(max_examples=8, deadline=None)
@given(
    st.lists(st.tuples(st.integers(1, 500), st.integers(1, 20_000)), min_size=2, max_size=8, unique_by=lambda p: p[0]),
    st.integers(0, 4),
    st.integers(1, 10),
)
def test_whatever_the_bounds(points: list[tuple[int, int]], order: int, factor: int) -> None:
    bounds = tuple((Fraction(w, 4), Fraction(b, 10_000)) for w, b in sorted(points))
    wanted = steps(bounds, bounds[0][1], factor * bounds[-1][1])
    assert covers(cover(wanted, order), wanted)
