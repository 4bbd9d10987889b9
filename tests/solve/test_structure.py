"""Controller families: few exact digits, starts inside their bounds, each contained in the next larger one."""

from __future__ import annotations

from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest

from robimp.synthesis.solve.structure import DIGITS, Feedback, QFilter, Structure, convolve

FAMILIES: list[Structure] = [*(QFilter(order) for order in range(2, 9)), Feedback(0), Feedback(1)]
OMEGA_0 = 37.3


def digits(value: Fraction) -> int:
    """Significant digits of an exact decimal; fails for a number that is none."""
    scaled, shift = value, 0
    while scaled.denominator != 1:
        scaled, shift = scaled * 10, shift + 1
        assert shift < 60, f"{value} is no decimal of few digits"
    return len(str(abs(scaled.numerator)).rstrip("0") or "0")


@pytest.mark.parametrize("family", FAMILIES, ids=str)
def test_a_start_lies_inside_the_bounds(family: Structure) -> None:
    low, high = family.bounds
    assert np.all(low < high)
    rng = np.random.default_rng(0)
    for _ in range(50):
        x = family.start(rng)
        assert x.shape == low.shape
        assert np.all(low <= x) and np.all(x <= high)
    assert not np.all(2 * high <= high), "a point outside is seen"


@pytest.mark.parametrize("family", FAMILIES, ids=str)
def test_a_start_is_a_stable_proper_filter(family: Structure) -> None:
    rng = np.random.default_rng(1)
    for _ in range(50):
        num, den = family.polynomials(family.start(rng))
        assert np.all(np.roots(den).real < 0)
        assert len(den) - len(num) == (2 if isinstance(family, QFilter) else 0)
        if isinstance(family, QFilter):
            assert 0 < num[-1] / den[-1] < 1, "Q(0) starts below 1"


@pytest.mark.parametrize("family", FAMILIES, ids=str)
def test_a_rounded_controller_is_exact_decimals_of_few_digits(family: Structure) -> None:
    rng = np.random.default_rng(2)
    for _ in range(10):
        x = family.start(rng)
        shipped = family.rounded(x, OMEGA_0)
        for exact in (*shipped.numerator, *shipped.denominator):
            assert isinstance(exact, Fraction) and digits(exact) <= DIGITS
        num, den = family.polynomials(x)
        s = np.array([0.1, 1.0, 10.0]) * 1j * OMEGA_0
        wanted = np.polyval(num, s / OMEGA_0) / np.polyval(den, s / OMEGA_0)
        numerator, denominator = ([float(c) for c in part] for part in (shipped.numerator, shipped.denominator))
        got = np.polyval(numerator, s) / np.polyval(denominator, s)
        np.testing.assert_allclose(got, wanted, rtol=10.0 ** (2 - DIGITS))


def test_an_unrounded_coefficient_would_be_seen() -> None:
    assert digits(Fraction(Decimal("0.00123456"))) == 6
    assert digits(Fraction(Decimal("1.234567"))) == 7
    assert digits(Fraction(0.1)) > DIGITS, "the double next to 0.1 is not 0.1"
    with pytest.raises(AssertionError):
        digits(Fraction(1, 3))


@pytest.mark.parametrize("order", range(3, 9))
def test_extending_a_family_keeps_the_filter(order: int) -> None:
    family, rng = QFilter(order), np.random.default_rng(order)
    smaller = family.simpler
    assert smaller is not None and smaller.order < order
    low, high = family.bounds
    x = smaller.start(rng)
    larger = family.extended(x, rng)
    assert larger.shape == low.shape and np.all(low <= larger) and np.all(larger <= high)
    p = 1j * np.geomspace(0.01, 100, 30)

    def value(structure: QFilter, parameters: np.ndarray) -> np.ndarray:
        num, den = structure.polynomials(parameters)
        return np.polyval(num, p) / np.polyval(den, p)

    np.testing.assert_allclose(value(family, larger), value(smaller, x), rtol=1e-10)
    larger[-1] *= 1.01
    assert not np.allclose(value(family, larger), value(smaller, x), rtol=1e-4)


def test_the_simplest_families_have_nothing_below() -> None:
    assert QFilter(2).simpler is None and Feedback(1).simpler is None
    with pytest.raises(NotImplementedError):
        Feedback(1).extended(np.zeros(1), np.random.default_rng(0))


def test_order_2_is_the_papers_filter() -> None:
    """(23) with α = 0.8, ω = 50 rad/s, ζ = 0.7075."""
    x = np.array([np.log(50 / OMEGA_0), 0.7075, 0.8 * (50 / OMEGA_0) ** 2])
    shipped = QFilter(2).rounded(x, OMEGA_0)
    assert shipped.numerator == (Fraction(2000),)
    assert shipped.denominator == (Fraction(1), Fraction("70.75"), Fraction(2500))


def test_products_of_polynomials() -> None:
    assert convolve([1, 2], [3, 4, 5]) == [3, 10, 13, 10]
    assert convolve([1, 2], [3, 4, 5]) == list(np.polymul([1, 2], [3, 4, 5]))
