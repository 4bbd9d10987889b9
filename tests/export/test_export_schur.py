"""Schur and Cohn's test: the truth is known where polynomials are built from their roots."""

from __future__ import annotations

from random import Random

import pytest
from flint import arb, fmpq, fmpq_poly

from robimp.synthesis.export.schur import is_schur

CLOSE = fmpq(1, 10**12)


def built(random: Random, worst: fmpq) -> fmpq_poly:
    """Random roots within radius 0.99, and one pair or real root of modulus `worst`."""
    p = fmpq_poly([1])
    for _ in range(random.randint(0, 4)):
        p *= fmpq_poly([fmpq(random.randint(-99, 99), 100), 1])
        p *= fmpq_poly([fmpq(random.randint(1, 98), 100), fmpq(random.randint(-90, 90), 100), 1])
    # z² − 2 r c z + r² has |z| = r for |c| ≤ 1
    cosine = fmpq(random.randint(-100, 100), 100)
    return p * fmpq_poly([worst * worst, -2 * worst * cosine, 1])


@pytest.mark.parametrize("seed", range(30))
def test_decides_by_the_largest_root(seed: int) -> None:
    random = Random(seed)
    inside = built(random, 1 - CLOSE).coeffs()
    others_inside = built(Random(seed), fmpq(0)).coeffs()
    assert is_schur(others_inside) is True
    assert is_schur(inside) is True
    assert is_schur(built(Random(seed), fmpq(1)).coeffs()) is False
    assert is_schur(built(Random(seed), 1 + CLOSE).coeffs()) is False


def test_constants_and_roots_at_zero() -> None:
    assert is_schur([fmpq(3)]) is True
    assert is_schur([fmpq(0), fmpq(0), fmpq(1)]) is True


def test_balls_too_wide_decide_nothing() -> None:
    assert is_schur([arb(1, "0.5"), arb(1)]) is None
    assert is_schur([arb("0.5", "0.1"), arb(1)]) is True
    assert is_schur([arb(2, "0.1"), arb(1)]) is False
