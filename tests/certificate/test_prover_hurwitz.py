"""Routh's test in rationals, against roots that were chosen."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from flint import fmpq, fmpq_poly
from hypothesis import given, settings
from hypothesis import strategies as st

from robimp.synthesis.certificate.hurwitz import decay_rate, is_hurwitz

S = fmpq_poly([0, 1])
parts = st.fractions(-4, 1, max_denominator=8)
real_roots = st.lists(parts, max_size=4)
pairs = st.lists(st.tuples(parts, st.fractions(Fraction(1, 8), 9, max_denominator=8)), max_size=3)


def q(value: Fraction) -> fmpq:
    return fmpq(value.numerator, value.denominator)


def from_roots(real: list[Fraction], pairs: list[tuple[Fraction, Fraction]]) -> fmpq_poly:
    p = fmpq_poly([1])
    for a in real:
        p *= S - q(a)
    for a, b in pairs:
        p *= (S - q(a)) ** 2 + q(b) ** 2
    return p


@settings(max_examples=200, deadline=None)
@given(
    real_roots, pairs, st.sampled_from([Fraction(0), Fraction(1, 2), Fraction(3)]), st.sampled_from([1, -1, 10**200])
)
def test_hurwitz_is_the_position_of_the_chosen_roots(real, pairs, decay, scale):
    rightmost = max([*real, *(a for a, _ in pairs)], default=None)
    p = scale * from_roots(real, pairs)
    assert is_hurwitz(p, q(decay)) is (rightmost is None or rightmost < -decay)
    if rightmost is not None:
        assert decay_rate(p) == pytest.approx(-float(rightmost), abs=1e-12)


@pytest.mark.parametrize(
    "p",
    [
        (S**2 + 1) * (S + 1),  # marginal pair: floats show −2e−16
        S * (S + 1),
        (S**2 + 1) ** 2,
        (S - 1) * (S + 1),
        S**2 - 1,
        S**2 + 1,
        (S**2 + S + 1) * (S**2 - S + 1),
        fmpq_poly([0]),
    ],
)
def test_marginal_and_unstable_are_not_hurwitz(p):
    assert not is_hurwitz(p)
    assert not is_hurwitz(-p)


def test_needle_of_damping_is_told_from_none():
    zeta = fmpq(1, 10**9)
    for damping, expected in ((zeta, True), (fmpq(0), False), (-zeta, False)):
        assert is_hurwitz(S**2 + 2 * damping * S + 1) is expected


def test_forty_equal_roots():
    p = (S + 1) ** 40
    in_floats = np.roots([float(int(c.p)) for c in p.coeffs()[::-1]])
    assert in_floats.real.max() > -0.6  # what exactness is for
    assert is_hurwitz(p, fmpq(999999, 1000000))
    assert not is_hurwitz(p, 1)
    assert decay_rate(p) == 1.0


def test_roots_over_four_hundred_decades():
    small, large = fmpq(1, 10**200), fmpq(10**200)
    p = (S + small) * (S + 1) * (S + large) * (S**2 + large * S + large**2)
    assert is_hurwitz(p)
    assert is_hurwitz(p, small * fmpq(999, 1000))
    assert not is_hurwitz(p, small)
    assert not is_hurwitz((S - small) * (S + large))
    assert decay_rate(p) == pytest.approx(1e-200)


def test_a_constant_has_no_root_to_decay():
    assert is_hurwitz(fmpq_poly([3]), 10)
    assert decay_rate(fmpq_poly([3])) == 0
