"""Exact rational functions: the laws of a field, doubles at the edge, `control` objects in and out."""

from __future__ import annotations

from fractions import Fraction

import control
import numpy as np
import pytest
from flint import fmpq, fmpq_poly
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from robimp.models.rational import (
    ONE,
    ZERO,
    RationalFunction,
    S,
    descending,
    evaluate,
    exact,
    fraction,
    polynomial,
    to_float,
)

numbers = st.fractions(min_value=-9, max_value=9, max_denominator=7)
coefficients = st.lists(numbers, min_size=1, max_size=4)
functions = st.builds(RationalFunction.of, coefficients, coefficients.filter(lambda c: any(c)))
quick = settings(max_examples=30, deadline=None)


# ---- arithmetic


@quick
@given(functions, functions, functions)
def test_the_laws_of_a_field(a: RationalFunction, b: RationalFunction, c: RationalFunction) -> None:
    assert a + b == b + a
    assert a * b == b * a
    assert (a + b) + c == a + (b + c)
    assert (a * b) * c == a * (b * c)
    assert a * (b + c) == a * b + a * c
    assert a + ZERO == a == a * ONE
    assert a - a == ZERO
    assert (a == b) == (a - b == ZERO)
    if a != ZERO:
        assert a / a == ONE
        assert b / a * a == b


@quick
@given(functions, functions, st.fractions(min_value=20, max_value=30, max_denominator=5))
def test_values_are_combined_as_the_functions_are(a: RationalFunction, b: RationalFunction, at: Fraction) -> None:
    def value(r: RationalFunction) -> fmpq:
        assume(r.den(exact(at)) != 0)
        return r.num(exact(at)) / r.den(exact(at))

    assert value(a + b) == value(a) + value(b)
    assert value(a - b) == value(a) - value(b)
    assert value(a * b) == value(a) * value(b)
    if value(b) != 0:
        assert value(a / b) == value(a) / value(b)


@quick
@given(functions, numbers)
def test_scalars_on_either_side(a: RationalFunction, k: Fraction) -> None:
    lifted = RationalFunction.lift(k)
    assert (k + a, k - a, k * a, a - k) == (lifted + a, lifted - a, lifted * a, a - lifted)
    if a != ZERO:
        assert k / a == lifted / a


@quick
@given(coefficients, coefficients, coefficients)
def test_common_factors_change_neither_value_nor_hash(n: list[Fraction], d: list[Fraction], f: list[Fraction]) -> None:
    assume(any(d) and any(f))
    num, den, factor = map(polynomial, (n, d, f))
    plain, padded = RationalFunction(num, den), RationalFunction(num * factor, den * factor)
    assert plain == padded
    assert hash(plain) == hash(padded)
    assert padded.num.gcd(padded.den).degree() <= 0  # lowest terms
    assert plain + 1 != padded


def test_exactness_where_doubles_give_up() -> None:
    tenth = RationalFunction.of(["0.1"])
    assert tenth + tenth + tenth == RationalFunction.of(["0.3"])
    assert RationalFunction.of([0.1]) != tenth  # the double is another number, and is taken as what it is
    tiny = RationalFunction.of(["1e-300"])
    assert (S + 1 + tiny) - (S + 1) == tiny != ZERO
    roots = ONE
    for _ in range(40):
        roots = roots * (S + 1)
    assert roots.num(fmpq(-1)) == 0
    assert roots.num(fmpq(-100001, 100000)) == fmpq(1, 100000) ** 40


def test_equality_with_something_else_is_no_error() -> None:
    assert ONE != "1"
    assert RationalFunction.lift(1) == ONE


def test_relative_degree() -> None:
    assert [r.relative_degree for r in (S, ONE, 1 / S, RationalFunction.of([1], [1, 2, 3]))] == [-1, 0, 1, 2]


@pytest.mark.parametrize(
    "make",
    [
        lambda: RationalFunction.of([1], [0]),
        lambda: RationalFunction.of([1], [0, 0, 0]),
        lambda: RationalFunction.of([0], [0]),
        lambda: RationalFunction(fmpq_poly([1]), fmpq_poly([])),
        lambda: ONE / ZERO,
        lambda: 1 / (S - S),
    ],
)
def test_a_zero_denominator_is_refused(make: object) -> None:
    with pytest.raises(ZeroDivisionError, match="zero denominator"):
        make()  # type: ignore[operator]


# ---- numbers


@pytest.mark.parametrize("bad", ["", "one", "1,5", float("nan"), float("inf"), "nan", "inf"])
def test_what_is_no_finite_number_is_refused(bad: str | float) -> None:
    with pytest.raises((ValueError, OverflowError)):
        exact(bad)


@quick
@given(st.fractions())
def test_fractions_come_back_unchanged(value: Fraction) -> None:
    assert fraction(exact(value)) == value
    assert fraction(exact(str(value))) == value


@quick
@given(st.floats(allow_nan=False, allow_infinity=False))
def test_a_double_is_the_number_it_is(value: float) -> None:
    assert to_float(exact(value)) == value


@quick
@given(st.integers(-300, 300), st.integers(1, 999))
def test_to_float_over_six_hundred_decades(exponent: int, digits: int) -> None:
    """Rounded once, also where numerator and denominator are each far beyond the range of doubles."""
    assert to_float(exact(f"{digits}e{exponent}")) == float(f"{digits}e{exponent}")
    both_huge = fmpq(digits * 10**2000 + 1, 10**2000)
    assert to_float(both_huge) == float(digits)


def test_coefficients_over_six_hundred_decades_evaluate() -> None:
    r = RationalFunction.of(["1e-300", 1], ["1e300", 1])
    assert r(0.0) == 1.0
    assert abs(r.at(np.array([1.0]))[0]) == pytest.approx(1e-300, rel=1e-12, abs=0)
    assert abs(r.at(np.array([1e-300]))[0]) == pytest.approx(0.5**0.5, rel=1e-12)


@quick
@given(coefficients)
def test_descending_is_the_order_engineers_write(c: list[Fraction]) -> None:
    significant = c[next((k for k, x in enumerate(c) if x), len(c) - 1) :]
    assert descending(polynomial(c)) == tuple(significant)


@quick
@given(functions, st.floats(0.1, 50))
def test_frequency_response_is_the_value_at_j_omega(r: RationalFunction, omega: float) -> None:
    s = 1j * omega
    num, den = (np.polyval([float(c) for c in descending(p)], s) for p in (r.num, r.den))
    assume(abs(den) > 1e-3)
    assert r.at(np.array([omega]))[0] == pytest.approx(num / den, rel=1e-9, abs=1e-9)
    assert evaluate(r.num, s) == pytest.approx(num, rel=1e-9, abs=1e-9)


# ---- control.TransferFunction in and out


@quick
@given(st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=4), st.lists(st.floats(0.1, 1e6), min_size=1, max_size=5))
def test_a_transfer_function_is_taken_as_the_doubles_it_is_made_of(num: list[float], den: list[float]) -> None:
    assert RationalFunction.from_control(control.tf(num, den)) == RationalFunction.of(num, den)


@quick
@given(functions)
def test_round_trip_through_control(r: RationalFunction) -> None:
    back = RationalFunction.from_control(r.to_control())
    omega = np.array([0.3, 2.0, 17.0])
    assume(np.all(np.abs(evaluate(r.den, 1j * omega)) > 1e-3))
    np.testing.assert_allclose(back.at(omega), r.at(omega), rtol=1e-9, atol=1e-12)


def test_round_trip_is_exact_for_doubles_and_only_near_for_thirds() -> None:
    doubles = RationalFunction.of(["0.5", 3], [1, "0.25", 7])
    third = RationalFunction.of(["1/3"], [1, 1])
    assert RationalFunction.from_control(doubles.to_control()) == doubles
    assert RationalFunction.from_control(third.to_control()) != third


@pytest.mark.parametrize(
    "system",
    [
        control.tf([1], [1, 1], True),
        control.tf([1], [1, 0.5], 0.001),
        control.tf([[[1], [1]], [[1], [1]]], [[[1, 1], [1, 2]], [[1, 3], [1, 4]]]),
    ],
    ids=["discrete, rate unknown", "discrete", "two by two"],
)
def test_discrete_and_mimo_are_refused(system: control.TransferFunction) -> None:
    with pytest.raises(ValueError, match="single-input single-output continuous"):
        RationalFunction.from_control(system)
