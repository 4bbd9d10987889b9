"""Forms, cells and the hold contain the true values; what is outside is refused."""

from __future__ import annotations

import cmath
import math
import random
from fractions import Fraction
from itertools import pairwise
from time import monotonic

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robimp.synthesis.check.enclosure.cells import Cell, roots
from robimp.synthesis.check.enclosure.forms import Axis, Form, UnresolvedError, excludes_zero
from robimp.synthesis.check.enclosure.search import compare, cover
from robimp.synthesis.check.outcome import CheckError
from robimp.synthesis.check.polynomials import Poly
from robimp.synthesis.check.positivity import Inequality

Point = list[Fraction]  # t_0, t_1, … in [−1, 1]


def chi(cell: Cell, t: Point) -> Fraction:
    return (cell.lo + cell.hi) / 2 + (cell.hi - cell.lo) / 2 * t[0]


def bounds(form: Form, t: Point) -> tuple[Fraction, Fraction]:
    """What a form says at one point of its cell, exactly."""
    zeta = -chi(form.cell, t) / Fraction(2) ** form.cell.b
    scale = zeta**form.m * Fraction(2) ** form.e if zeta or form.m >= 0 else Fraction(0)
    middle = form.c + sum(a * x for a, x in zip(form.l, t, strict=True)) + form.q * t[0] ** 2
    low, high = sorted((scale * (middle - form.r), scale * (middle + form.r)))
    return low, high


def contains(form: Form, t: Point, value: Fraction) -> bool:
    low, high = bounds(form, t)
    return low <= value <= high


CELLS = [
    (Fraction(0), Fraction(1, 100), False),
    (Fraction(1), Fraction(4), False),
    (Fraction(100), Fraction(101), False),
    (Fraction(10**8), Fraction(10**8 + 7), False),
    (Fraction(3, 7), Fraction(3, 7), False),
    (Fraction(0), Fraction(1, 10**4), True),
]
COEFFICIENTS = st.lists(st.fractions(min_value=-50, max_value=50, max_denominator=9), min_size=1, max_size=7)
SYMBOLS = st.lists(st.fractions(min_value=-1, max_value=1, max_denominator=8), min_size=2, max_size=2)


def true_real(cell: Cell, p: Poly, t: Point) -> Fraction:
    x = 1 / chi(cell, t) if cell.far else chi(cell, t)
    return sum((Fraction(a, p.d) * x**k for k, a in enumerate(p.c)), Fraction(0))


@settings(max_examples=200, deadline=None)
@given(st.sampled_from(CELLS), COEFFICIENTS, COEFFICIENTS, SYMBOLS)
def test_real_forms_contain_the_exact_values(
    ends: tuple[Fraction, Fraction, bool], a: list[Fraction], b: list[Fraction], t: Point
) -> None:
    cell = Cell(*ends, {("impedance", "stiffness"): (Fraction(2), Fraction(5))})
    if chi(cell, t) == 0:
        return
    p, q, k = Poly.of(*a), Poly.of(*b), Fraction(7, 2) + Fraction(3, 2) * t[1]
    P, Q, K = cell.real(p), cell.real(q), cell.form(Fraction(7, 2), 1, Fraction(3, 2))
    u, w = true_real(cell, p, t), true_real(cell, q, t)
    for form, value in (
        (P, u), (Q, w), (K, k), (P + Q, u + w), (P - K, u - k), (P * Q, u * w), (P * K + Q * K, (u + w) * k),
        (P * P * K, u * u * k),
    ):  # fmt: skip
        assert contains(form, t, value)
    try:
        inverse = (Q + K).inverse()
    except UnresolvedError:
        return
    assert contains(inverse, t, 1 / (w + k))


@settings(max_examples=200, deadline=None)
@given(st.sampled_from(CELLS), COEFFICIENTS, COEFFICIENTS, SYMBOLS)
def test_roots_and_signs_of_forms(
    ends: tuple[Fraction, Fraction, bool], a: list[Fraction], b: list[Fraction], t: Point
) -> None:
    cell = Cell(*ends, {("impedance", "stiffness"): (Fraction(2), Fraction(5))})
    if chi(cell, t) == 0:
        return
    p, k = Poly.of(*a), Fraction(7, 2) + Fraction(3, 2) * t[1]
    form, value = cell.real(p) * cell.form(Fraction(7, 2), 1, Fraction(3, 2)), true_real(cell, p, t) * k
    if form.sign() == 1:
        assert value > 0
    square = form * form
    if not cell.ends or square.m >= 0:
        low, high = bounds(square.at(0).root(), t)
        assert low <= abs(value) * (1 + Fraction(1, 10**30)) and high >= abs(value) * (1 - Fraction(1, 10**30))


@settings(max_examples=200, deadline=None)
@given(st.sampled_from(CELLS), COEFFICIENTS, COEFFICIENTS, st.integers(0, 8))
def test_complex_quantities_are_the_polynomials(
    ends: tuple[Fraction, Fraction, bool], a: list[Fraction], b: list[Fraction], eighth: int
) -> None:
    cell, t = Cell(*ends, {}), [Fraction(eighth, 4) - 1]
    if chi(cell, t) == 0:
        return
    p, q = Poly.of(*a), Poly.of(*b)
    for axis, poly in (
        (cell.axis(p) * cell.axis(q), p * q),
        (cell.axis(p) * q + p, p * q + p),
        (-(p - cell.axis(q)), q - p),
    ):
        for form, exact in zip(axis.parts(), poly.parts(), strict=True):
            assert contains(form, t, true_real(cell, exact, t))
    try:
        one = cell.axis(q) * cell.axis(q).inverse()
    except UnresolvedError:
        return
    assert contains(one.p, t, Fraction(1)) and contains(one.q, t, Fraction(0))


@settings(max_examples=200, deadline=None)
@given(st.floats(-3, 6), st.floats(-6, 1), st.integers(0, 8), st.sampled_from(["0", "1/1000", "1/30"]))
def test_the_hold_contains_the_float_values(log_omega: float, log_width: float, eighth: int, delay: str) -> None:
    x = Fraction(10 ** (2 * log_omega))
    cell = Cell(x, x * Fraction(1 + 10**log_width), False, {})
    t = [Fraction(eighth, 4) - 1]
    s, T, d = 1j * math.sqrt(chi(cell, t)), 1e-3, float(Fraction(delay))
    value = cmath.exp(-s * d) * (1 - cmath.exp(-s * T)) / (s * T)
    if abs(s) * T < 1e-4:
        value = cmath.exp(-s * (d + T / 2))
    hold = cell.hold(Fraction(1000), Fraction(delay))
    for form, true in ((hold.p, value.real), (hold.q, value.imag / abs(s))):
        low, high = (float(v) for v in bounds(form, t))
        slop = 1e-7 * (1 if form is hold.p else 1 / abs(s))
        assert low - slop <= true <= high + slop
    if log_width < -4 and abs(s) * (d + T) < 50:
        assert float(bounds(hold.p, t)[1] - bounds(hold.p, t)[0]) < 1e-3


@pytest.mark.parametrize("delay", ["1/100", "3", "1000000000000"])
@pytest.mark.parametrize("width", [Fraction(3), Fraction(1, 10**9)])
def test_the_hold_of_a_long_delay_is_bounded_and_soon_there(delay: str, width: Fraction) -> None:
    """Halving the angle many times must not make powers, exponents or time grow with it."""
    began = monotonic()
    for omega in (Fraction(1, 50), Fraction(30), Fraction(10**5), Fraction(10**40)):
        hold = Cell(omega**2, omega**2 * (1 + width), False, {}).hold(Fraction(1000), Fraction(delay))
        for form, most in ((hold.p, 1), (hold.q, 1 / omega)):
            low, high = bounds(form, [Fraction(0)])
            assert -5 * most <= low <= high <= 5 * most
    assert monotonic() - began < 2


@pytest.mark.parametrize("omega", [2e4, 1e6])
def test_the_hold_in_the_cell_at_infinity(omega: float) -> None:
    cell = Cell(Fraction(0), Fraction(1, 10**8), True, {})
    hold, s = cell.hold(Fraction(1000), Fraction(1, 500)), 1j * omega
    value = cmath.exp(-s / 500) * (1 - cmath.exp(-s / 1000)) / (s / 1000)
    t = [Fraction(2 * 10**8) / Fraction(omega) ** 2 - 1]  # z = p + q/s
    assert contains(hold.p, t, Fraction(value.real)) and contains(hold.q, t, Fraction(-value.imag * omega))


def zonotope(cell: Cell, rows: list[list[Fraction]]) -> list[Axis]:
    return [cell.axis(Poly.of(*row)) for row in rows]


@pytest.mark.parametrize("hulls", [1, 2])
def test_zero_exclusion_never_says_no_root_where_there_is_one(hulls: int) -> None:
    """f = f_0 + u_1 f_1 + u_2 f_2, or anything between two of these: 0 is inside if two parameters reach it."""
    rng, excluded, kept = random.Random(4), 0, 0
    for _ in range(400):
        cell = Cell(Fraction(1), Fraction(1 + rng.random() / 8), False, {})
        given = [[[Fraction(rng.randint(-9, 9)) for _ in range(3)] for _ in range(3)] for _ in range(hulls)]
        inside, share = False, rng.random()
        for k in range(9):
            s = 1j * math.sqrt(float(chi(cell, [Fraction(k, 4) - 1])))
            values = [[sum(float(c) * s**n for n, c in enumerate(row)) for row in rows] for rows in given]
            u, v, w = (share * first + (1 - share) * last for first, last in zip(values[0], values[-1], strict=True))
            det = v.real * w.imag - v.imag * w.real
            if abs(det) > 1e-9:
                a = (-u.real * w.imag + u.imag * w.real) / det
                b = (-v.real * u.imag + v.imag * u.real) / det
                inside = inside or (abs(a) < 0.999 and abs(b) < 0.999)
        said, near = excludes_zero([zonotope(cell, rows) for rows in given])
        excluded, kept = excluded + said, kept + inside
        assert near or not said
        assert not (inside and said)
    assert excluded > 30 and kept > 30


@pytest.mark.parametrize("gap", [Fraction(1, 10**4), Fraction(-1, 10**4)])
@pytest.mark.parametrize("turned", [[1], [Fraction(9, 10), 1], [Fraction(1, 2), 3, 1]])
def test_a_flat_box_a_hair_from_zero_is_excluded_at_once(gap: Fraction, turned: list[Fraction]) -> None:
    """Loads of 20 ± 27 N·m/rad and 0.1 ± 0.1 N·m·s/rad, an edge near 0, behind a factor that turns it with ω."""
    cell, E = Cell(Fraction(1), Fraction(65, 64), False, {}), Poly.of(*turned)
    damping = Fraction(1, 10)
    load = [Poly.of(20, damping + gap), Poly.of(27), Poly.of(0, damping)]
    assert excludes_zero([[cell.axis(E * g) for g in load]])[0] == (gap > 0)
    both = [[cell.axis(E * g) for g in load], [cell.axis(E * -g) for g in load]]  # 0 is between them
    assert excludes_zero(both) == (False, False)


def test_a_cell_with_a_parameter_is_refuted_at_a_corner_and_halved_where_it_bends() -> None:
    key = ("impedance", "stiffness")
    cell = Cell(Fraction(1), Fraction(1), False, {})

    def slack(c: Fraction) -> str:
        def parts(cell: Cell, at: dict[tuple[str, str], Fraction]):  # type: ignore[no-untyped-def]  # (k − 1/3)² + c > 0
            yield Inequality([], Poly.of((at[key] - Fraction(1, 3)) ** 2 + c))

        return cover([cell], parts, monotonic() + 5, {key: (Fraction(-1), Fraction(1))})

    assert slack(Fraction(1, 10**6)) == "" and slack(Fraction(-1, 10**6)) != ""
    with pytest.raises(CheckError, match="neither"):
        slack(Fraction(0))


def test_the_ends_are_compared_by_leading_coefficients() -> None:
    for far in (False, True):
        cell = Cell(Fraction(0), Fraction(1, 64), far, {})
        p, q = (Poly.of(0, 1, 1), Poly.of(0, 2, 3)) if not far else (Poly.of(1, 1), Poly.of(3, 2))
        assert compare(cell, [Inequality([p], q)])[0] == 1 and compare(cell, [Inequality([q], p)])[0] == -1
    at_infinity = Cell(Fraction(0), Fraction(0), True, {})
    assert compare(at_infinity, [Inequality([], Poly.of(1), True, Poly.of(1, 1))])[0] == -1  # 1/(1 + x) is zero there
    assert compare(at_infinity, [Inequality([], Poly.of(1), True)])[0] == 1


def test_roots_cover_the_interval_without_gaps() -> None:
    for lo, hi in (("0", math.inf), ("1/3", "7/2"), ("100000", math.inf), ("0", "1/1000000")):
        cells = roots((Fraction(lo), hi if hi == math.inf else Fraction(hi)), [Fraction(2), Fraction(3)], {})
        ends = [(1 / c.hi if c.far else c.lo, None if c.far else c.hi) for c in cells]
        assert ends[0][0] == Fraction(lo) ** 2
        assert all(a[1] == b[0] for a, b in pairwise(ends))
        assert ends[-1][1] == (None if hi == math.inf else Fraction(hi) ** 2)


def test_axis_inverse_refuses_a_zero() -> None:
    cell = Cell(Fraction(1), Fraction(4), False, {})
    with pytest.raises(UnresolvedError):
        cell.axis(Poly.of(2, 0, 1)).inverse()  # s² + 2 is zero at x = 2
