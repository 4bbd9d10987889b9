"""The checker's arithmetic at its edges: nothing, lowest terms, lost degrees, and the work allowed for one step."""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from time import monotonic

import pytest

from robimp.synthesis.check import polynomials
from robimp.synthesis.check.outcome import UNDECIDED, CheckError
from robimp.synthesis.check.polynomials import (
    ONE,
    ZERO,
    Poly,
    Ring,
    X,
    common_divisor,
    decays_faster,
    limit,
    mobius,
    norm2,
    on_axis,
    primitive,
    product,
    quotient,
    size,
)


def soon() -> float:
    return monotonic() + 20


@dataclass(frozen=True)
class Length(Ring):
    """Something that is no polynomial, but can be added to one and multiplied by one: here by the value at z = 2."""

    value: int

    def __neg__(self) -> Length:
        return Length(-self.value)

    def __add__(self, other: Length | Poly) -> Length:
        return Length(self.value + at_two(other))

    def __mul__(self, other: Length | Poly) -> Length:
        return Length(self.value * at_two(other))


def at_two(other: Length | Poly) -> int:
    return other.value if isinstance(other, Length) else sum(a * 2**k for k, a in enumerate(other.c)) // other.d


def test_a_polynomial_on_the_left_of_another_quantity_leaves_the_work_to_that() -> None:
    p, x = Poly.of(3, 1), Length(4)  # p(2) = 5
    assert (p + x, p - x, p * x) == (Length(9), Length(1), Length(20))
    assert (x + p, x - p, x * p) == (Length(9), Length(-1), Length(20))


def test_a_number_is_not_taken_for_a_polynomial() -> None:
    for strange in (lambda: ONE + 1, lambda: ONE * 2, lambda: 2 * ONE, lambda: ONE - 1):
        with pytest.raises(TypeError):
            strange()


def test_polynomials_are_kept_in_lowest_terms_without_zeros_at_the_top() -> None:
    half = Poly.of(Fraction(1, 2), Fraction(1, 3), 0)
    assert (half.c, half.d) == ((3, 2), 6)
    assert (half + half).c == (3, 2) and (half + half).d == 3
    assert half * Poly.of(6) == Poly((3, 2)) == half + Poly.of(Fraction(5, 2), Fraction(5, 3))
    assert Poly.of(1, 2) + Poly.of(3) == Poly.of(4, 2) == Poly.of(3) + Poly.of(1, 2)
    assert half - half == ZERO == Poly.of() == Poly.of(0, 0) and ZERO.d == 1
    assert not ZERO and half and not half * ZERO
    named = polynomials.ZERO, polynomials.ONE, polynomials.X
    assert [(p.c, p.d) for p in named] == [((), 1), ((1,), 1), ((0, 1), 1)]
    assert -half == Poly.of(Fraction(-1, 2), Fraction(-1, 3)) and -half != half


def test_real_and_imaginary_part_on_the_axis() -> None:
    """p(jω) = 1 + 2jω − 3ω² − 4jω³ + 5ω⁴ + 6jω⁵, over 7."""
    p = Poly((1, 2, 3, 4, 5, 6), 7)
    assert p.parts() == (Poly((1, -3, 5), 7), Poly((2, -4, 6), 7))
    assert p.conj() == Poly((1, -2, 3, -4, 5, -6), 7)
    assert norm2(Poly((3, 4), 5)) == Poly((9, 16), 25)
    assert on_axis(Poly.of(1, 2), Poly.of(3, 4)) == (Poly.of(3, 8), Poly.of(2))  # (1 + 2jω)(3 − 4jω)


def test_a_limit_compares_the_orders_of_zeros_and_poles() -> None:
    double, single = Poly((0, 0, 3, 1), 2), Poly((0, 5, 1), 7)
    assert limit(double, single, far=False) == ZERO and limit(single, double, far=False) is None
    assert limit(double, single, far=True) is None and limit(single, double, far=True) == ZERO
    assert limit(single, X, far=False) == Poly((5,), 7) and limit(X, single, far=False) == Poly((7,), 5)
    assert limit(double, X * X * X, far=True) == Poly((1,), 2)
    assert limit(ZERO, ONE, far=False) == ZERO and limit(ONE, ZERO, far=False) is None
    assert limit(ZERO, ZERO, far=True) is None


def test_products_of_rows_keep_their_formal_degree() -> None:
    assert product([1, 2, 0], [3, 0]) == [3, 6, 0, 0]
    assert product([], [1, 2]) == product([1, 2], []) == product([], []) == []


def test_bits_are_those_of_the_largest_coefficient() -> None:
    assert [size(row) for row in ([], [0], [1, -1], [3, -8], [7])] == [0, 0, 1, 4, 3]


def test_a_mobius_map_keeps_the_formal_degree() -> None:
    """(3 + 5z)² p((2 + 7z)/(3 + 5z)) for p = x² + 4, and for p = 0 x² + x + 4."""
    assert mobius([4, 0, 1], 2, 3, 7, 5) == [4 * 9 + 4, 4 * 30 + 28, 4 * 25 + 49]
    assert mobius([4, 1, 0], 2, 3, 7, 5) == [36 + 6, 120 + 10 + 21, 100 + 35]


def test_primitive_rows_have_no_common_factor_and_keep_their_sign() -> None:
    assert primitive([-4, 6, 0, 0]) == [-2, 3] and primitive([0, 0]) == [] == primitive([])
    assert primitive([-1, 9, 14], 7) == [6, 2]


def test_the_modulus_is_a_prime() -> None:
    """By Fermat's little theorem, and larger than any degree and any small coefficient."""
    prime = polynomials.PRIME
    assert all(pow(base, prime - 1, prime) == 1 for base in (2, 3, 5, 7, 11)) and prime > 2**60


def test_common_divisors_are_primitive_over_the_rationals_and_in_any_order() -> None:
    p, q = product([-1, 3], [2, 5, 7]), product([-1, 3], [6, 0, 4])
    assert common_divisor(p, q, soon()) in ([-1, 3], [1, -3])
    assert common_divisor([1], p, soon()) == [1]
    assert common_divisor(p, [-1, 3], soon()) == [-1, 3]
    assert common_divisor(p, [], soon()) == p == common_divisor([], p, soon())
    assert len(common_divisor([1, 0, 1], [1, 1], soon())) == 1
    assert len(common_divisor([1, 0, 1], [1, 1], soon(), 2)) == 2  # x² + 1 = (x + 1)² modulo 2


def test_exact_quotients() -> None:
    p, q = [-2, 3, 5], [7, -1, 4, 2]
    assert quotient(product(p, q), p) == q and quotient(product(p, q), q) == p and quotient(p, p) == [1]
    assert quotient(p, [1]) == p


ALLOWED: dict[str, tuple[Callable[[], object], Callable[[], object]]] = {  # 10¹² bit products, and more than that
    "product": (
        lambda: product([1, 0, 0, 1 << 249_999], [1, 1 << 499_999]),
        lambda: product([1, 0, 0, 1 << 250_000], [1, 1 << 499_999]),
    ),
    "substitution": (
        lambda: mobius([1 << 989_999] + [0] * 99, 0, 1 << 99, 0, 0),
        lambda: mobius([1 << 990_000] + [0] * 99, 0, 1 << 99, 0, 0),
    ),
    "division": (
        lambda: common_divisor([1, 0, 0, 1 << 249_999], [1, 0, 0, 1 << 249_999], soon()),
        lambda: common_divisor([1, 0, 0, 1 << 249_999], [1, 0, 0, 1 << 250_000], soon()),
    ),
}


@pytest.mark.parametrize("name", ALLOWED)
def test_one_step_is_a_million_million_bit_products_at_most(name: str) -> None:
    allowed, more = ALLOWED[name]
    allowed()
    with pytest.raises(CheckError, match="too large") as stop:
        more()
    assert stop.value.code == UNDECIDED


@pytest.mark.parametrize(
    "long", [lambda at: common_divisor([1, 2], [3, 4], at), lambda at: decays_faster(X + ONE, Fraction(0), at)]
)
def test_the_clock_is_looked_at_in_every_step(long: Callable[[float], object]) -> None:
    with pytest.raises(CheckError, match="time limit"):
        long(monotonic() - 1)


@pytest.mark.parametrize(
    ("coefficients", "rate", "expected"),
    [
        ((), 0, False),
        ((5,), 0, True),  # no root
        ((-5,), 0, True),
        ((1, 1), 0, True),
        ((-1, -1), 0, True),  # the sign of the whole is of no matter
        ((-1, 1), 0, False),
        ((0, 1), 0, False),
        ((1, 1), 1, False),  # exactly at the rate
        ((1, 2), Fraction(1, 2), False),
        ((1, 2), Fraction(499, 1000), True),
        ((0, -1, -1), 0, False),  # roots 0 and −1
        ((-1, -1, 1), 0, False),  # real roots of either sign
        ((1, -3, -1, 1), 0, False),
        ((1, 0, 1), 0, False),
        ((1, 0, -1), 0, False),
        ((2, 1, 1), 0, True),
        ((2, -1, 1), 0, False),
        ((6, 11, 6, 1), Fraction(999, 1000), True),
        ((6, 11, 6, 1), 1, False),
        ((1, 1, 1, 1), 0, False),  # ±j
        ((1, 1, 2, 1), 0, True),
        ((3, 1, 2, 1), 0, False),
        ((1, 2, 3, 2, 1), 0, True),
        ((2, 1, 3, 1, 1), 0, False),  # (1 + s²)(2 + s + s²)
        ((4, 1, 3, 1, 1), 0, False),
        ((Fraction(1, 3), Fraction(1, 2)), Fraction(2, 3), False),
        ((Fraction(1, 3), Fraction(1, 2)), Fraction(3, 5), True),
    ],
)
def test_roots_are_to_the_left_of_a_rate_or_not(coefficients: tuple[int, ...], rate: Fraction, expected: bool) -> None:
    assert decays_faster(Poly.of(*coefficients), Fraction(rate), soon()) is expected


def test_one_pair_of_roots_on_the_right_is_found_among_any_others() -> None:
    rng = random.Random(1)
    for _ in range(40):
        p = Poly.of(rng.choice((-3, 2)))
        for _ in range(rng.randint(0, 4)):
            p = p * Poly.of(rng.randint(1, 30), rng.randint(1, 9), 1) * Poly.of(rng.randint(1, 9), rng.randint(0, 1))
        c, b = rng.randint(1, 40), rng.randint(1, 3)
        assert decays_faster(p, Fraction(0), soon()) and decays_faster(p * Poly.of(c, b, 9), Fraction(0), soon())
        for wrong in (Poly.of(c, 0, 9), Poly.of(c, -b, 9), Poly.of(-c, b, 9)):
            assert not decays_faster(p * wrong, Fraction(0), soon())
