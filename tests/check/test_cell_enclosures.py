"""Cells: powers of ζ, sums of them and forms contain the true values, by no more than their rounding explains."""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from fractions import Fraction

import pytest
from test_cells import bounds, chi, contains

from robimp.synthesis.check.enclosure import cells, forms
from robimp.synthesis.check.enclosure.cells import Cell
from robimp.synthesis.check.enclosure.forms import Form
from robimp.synthesis.check.joint import Ranges
from robimp.synthesis.check.polynomials import Poly

F = Fraction
EXACT = 10_000  # bits of a form: none is rounded
TWO: Ranges = {("plant", "inertia"): (F(1), F(2)), ("plant", "damping"): (F(1), F(2))}
TAYLOR = 2, 5, 11, 64  # bits: with few of them every unit counts
ENDS = [(F(0), F(1, 100)), (F(1), F(4)), (F(5), F(7)), (F(3, 7), F(3, 7)), (F(10**8 - 9), F(10**8 + 7)), (F(0), F(3))]

Bits = Callable[..., None]


@pytest.fixture
def bits(monkeypatch: pytest.MonkeyPatch) -> Bits:
    """Another number of bits for what cells compute, and for the forms that come of it."""

    def use(cell: int, form: int = EXACT) -> None:
        monkeypatch.setattr(cells, "BITS", cell)
        monkeypatch.setattr(forms, "BITS", form)
        monkeypatch.setattr(cells._fixed, "__defaults__", (cell,))
        monkeypatch.setattr(cells, "_mantissas", cells._mantissas.__wrapped__)  # those in store have other bits

    return use


def zeta(cell: Cell, t: Fraction) -> Fraction:
    return -chi(cell, [t]) / F(2) ** cell.b


def drawn(rng: random.Random) -> Cell:
    """Somewhere on a cell that is a point, narrow, wide, or begins at 0."""
    hi = F(rng.randint(1, 999), rng.randint(1, 999)) * F(2) ** rng.randint(-9, 9)
    share = rng.choice([F(0), F(1), F(rng.randint(900, 999), 1000), F(rng.randint(300, 900), 1000)])
    return Cell(hi * share, hi, False, {})


def total(ascending: list[Fraction], z: Fraction) -> Fraction:
    return sum((c * z**k for k, c in enumerate(ascending)), F(0))


def places(rng: random.Random) -> list[Fraction]:
    return [F(-1), F(0), F(1), F(rng.randint(-99, 99), 100)]


# ── powers of ζ ──────────────────────────────────────────────────────────────────────────────────────────────────────


@pytest.mark.parametrize("unit", TAYLOR)
def test_powers_of_zeta_are_within_their_bound(unit: int, bits: Bits) -> None:
    bits(unit)
    rng = random.Random(unit)
    for _ in range(60):
        cell = drawn(rng)
        for k in range(0 if cell.ends else -4, 6):
            c0, c1, c2, r = cell._power(k)
            for t in places(rng):
                assert abs(zeta(cell, t) ** k * 2**unit - (c0 + c1 * t + c2 * t * t)) <= r


@pytest.mark.parametrize("unit", TAYLOR)
def test_the_three_powers_that_others_are_made_of_are_as_near_as_their_rounding_allows(unit: int, bits: Bits) -> None:
    bits(unit)
    rng = random.Random(unit)
    for _ in range(60):
        cell = drawn(rng)
        assert cell._power(0) == (2**unit, 0, 0, 0)
        c, d = -zeta(cell, F(0)), zeta(cell, F(0)) - zeta(cell, F(1))
        assert cell._power(1) == (-math.floor(c * 2**unit), -math.floor(d * 2**unit), 0, 2)  # each loses less than one
        if cell.lo:  # the series in d t/c is alternating at t = 1, and geometric at t = −1
            remainder = 1 / (c - d) - (1 / c + d / c**2 + d**2 / c**3)
            assert 0 <= cell._power(-1)[3] <= remainder * 2**unit + 20


@pytest.mark.parametrize("sign", [1, -1])
def test_the_next_power_contains_all_products_and_little_more(sign: int, bits: Bits) -> None:
    """Whatever is within the two factors' bounds; the third and fourth order, and four floors, are what is added."""
    unit, rng = 6, random.Random(sign)
    bits(unit)

    def factor(top: int) -> tuple[int, int, int, int]:
        way = rng.choice([(1, 1, 1), (-1, -1, -1), (1, -1, 1), (-1, 1, 1)])
        c0, c1, c2 = (s * rng.randint(0, top) for s in way)
        return c0, c1, c2, rng.choice([0, rng.randint(0, top)])

    for _ in range(600):
        cell, top = Cell(F(1), F(2), False, {}), rng.choice([9, 2**unit, 2 ** (unit + 3)])
        (_, a1, a2, ra), (_, b1, b2, rb) = a, b = factor(top), factor(top)
        cell.taylor.update({4 * sign: a, sign: b})
        c0, c1, c2, r = cell._power(5 * sign)
        for t in (-1, 1, F(1, 2)):
            for way in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
                u, w = (x[0] + x[1] * t + x[2] * t * t + s * x[3] for x, s in zip((a, b), way, strict=True))
                assert abs(F(u * w, 2**unit) - (c0 + c1 * t + c2 * t * t)) <= r
        size_a, size_b = (sum(map(abs, x[:3])) for x in (a, b))
        bound = size_a * rb + size_b * ra + ra * rb + abs(a1 * b2) + abs(a2 * b1) + abs(a2 * b2)
        assert r <= F(bound, 2**unit) + 4


def test_a_point_at_zero_has_exact_powers_and_a_high_power_is_no_deep_recursion() -> None:
    cell = Cell(F(0), F(0), False, {})
    assert cell._power(0) == (2**64, 0, 0, 0) and cell._power(1) == cell._power(3) == (0, 0, 0, 0)
    assert Cell(F(1), F(1), False, {})._power(2000)[0] // 2**54 in (1023, 1024)


# ── sums of powers ───────────────────────────────────────────────────────────────────────────────────────────────────


@pytest.mark.parametrize("lo", [F(0), F(5)])
def test_a_sum_contains_all_that_its_terms_may_be_and_little_more(lo: Fraction, bits: Bits) -> None:
    """A mantissa of full length is off by up to one, a short one is exact, a power is within its bound."""
    unit, rng = 6, random.Random(int(lo))
    bits(unit)
    for _ in range(400):
        cell, few = Cell(lo, F(7), False, TWO), rng.randint(1, 4)
        for k in range(-9, 10):
            c0, c1, c2 = rng.choices([0, 9, 99, -99], k=3)
            cell.taylor[k] = c0, c1, c2, rng.choice([0, 0, 7, 99])
        terms = []
        for k in rng.sample(range(-3, 6), few):
            a = rng.choice([1, 3, rng.randint(2**13, 2**15 - 1), rng.randint(2**13, 2**15 - 1)])
            terms.append((k, rng.choice([1, -1]) * a, rng.randint(-9, 9) - a.bit_length()))
        sized = [(a.bit_length() + e + cell.b * k, k) for k, a, e in terms]
        form = cell._sum(terms)
        assert form.m == (min(k for _, k in sized) if cell.ends else max(sized)[1])
        assert form.e == max(sized)[0] - unit - 8 - unit and form.l[1:] == [0, 0]
        unit_of_a, slack = F(2) ** (form.e + unit), F(0)
        for t in places(rng):
            for way in (1, -1):
                value = F(0)
                for k, a, e in terms:
                    z0, z1, z2, zr = cell.taylor[k - form.m]
                    z, exact = z0 + z1 * t + z2 * t * t, a.bit_length() < unit + 8
                    moved = z + way * zr * (1 if a > 0 else -1)
                    value += F(2) ** (e + cell.b * k) * (a if exact else a + (way if moved > 0 else -way)) * moved
                assert abs(value / unit_of_a - (form.c + form.l[0] * t + form.q * t * t)) <= form.r
        for k, a, e in terms:
            z0, z1, z2, zr = cell.taylor[k - form.m]
            aligned = math.floor(a * F(2) ** (e + cell.b * k) / unit_of_a)
            slack += abs(aligned) * zr + abs(z0) + abs(z1) + abs(z2) + zr
        assert form.r <= slack


def test_the_power_of_zeta_in_front_is_the_lowest_at_an_end_and_else_that_of_the_largest_term() -> None:
    p = Poly.of(0, 1, F(-1, 3), 1000)
    assert Cell(F(0), F(4), False, {}).real(p).m == 1 and Cell(F(0), F(4), True, {}).real(p).m == -3
    assert Cell(F(1), F(4), False, {}).real(p).m == 3 and Cell(F(10) ** -9, F(2, 10**9), False, {}).real(p).m == 1
    assert not Cell(F(0), F(4), False, {}).real(Poly.of())


@pytest.mark.parametrize("far", [False, True])
def test_where_zeta_is_zero_the_lowest_term_is_all(far: bool) -> None:
    """A term that is 2^500 times as large must not take the bits of the one that counts."""
    form = Cell(F(0), F(0), far, TWO).real(Poly.of(F(2) ** 500 if far else 5, F(-1, 3), 5 if far else F(2) ** 500))
    assert form.m == (-2 if far else 0)
    low, high = ((form.c + s * form.r) * F(2) ** form.e for s in (-1, 1))
    assert low <= 5 <= high and high - low < F(1, 2**57) and not any([*form.l, form.q])


@pytest.mark.parametrize("k", [-3, -1, 0, 1, 2, 5])
def test_a_power_of_zeta_as_a_form(k: int) -> None:
    for lo, hi in ENDS[1:4]:
        cell = Cell(lo, hi, False, TWO)
        form = cell.power(k)
        assert form.m == 0 and form is cell.power(k)
        for t in (F(-1), F(0), F(1)):
            true = zeta(cell, t) ** k
            low, high = bounds(form, [t, F(1), F(-1)])
            assert low <= true <= high and (lo < hi or high - low < abs(true) / 2**57)


# ── polynomials ──────────────────────────────────────────────────────────────────────────────────────────────────────


@pytest.mark.parametrize("unit", [*TAYLOR, None])
def test_polynomials_are_contained_in_both_coordinates(unit: int | None, bits: Bits) -> None:
    if unit:
        bits(unit, unit)
    rng = random.Random(str(unit))
    for _ in range(40):
        lo, hi = rng.choice(ENDS)
        cell = Cell(lo, hi, rng.random() < 0.5, TWO)
        size = [rng.choice([0, 1]) * F(4) ** rng.randint(-9, 9) for _ in range(6)]
        a = [F(rng.randint(-99, 99), rng.randint(1, 9)) * s for s in size]
        p, x = cell.axis(Poly.of(*a)), cell.real(Poly.of(*a))
        for t in places(rng):
            if value := chi(cell, [t]):
                at = [t, F(rng.randint(-1, 1)), F(rng.randint(-1, 1))]
                assert contains(x, at, total(a, 1 / value if cell.far else value))
                # s^2i = τ^2i, and s^(2i+1) = τ τ^2i; or τ^-2i, and τ τ^-2(i+1), where τ = 1/s
                z = -1 / value if cell.far else -value
                assert contains(p.p, at, total(a[::2], z))
                assert contains(p.q, at, total(a[1::2], z) * (z if cell.far else 1))


def test_a_polynomial_is_enclosed_once_and_what_is_on_the_cell_stays() -> None:
    cell, p = Cell(F(1), F(2), False, {}), Poly.of(1, 2, 3)
    axis, form = cell.axis(p), cell.real(p)
    assert cell.axis(p) is axis and cell.real(p) is form
    assert cell.axis(axis) is axis and cell.real(form) is form
    assert form.cell is cell and (form.c, form.q) != (axis.p.c, axis.p.q)


@pytest.mark.parametrize("unit", [3, 64])
def test_mantissas_are_coefficients_cut_to_eight_bits_more_than_a_form_has(unit: int, bits: Bits) -> None:
    bits(unit)
    rng = random.Random(unit)
    for _ in range(100):
        a = [rng.choice([0, rng.randint(-9, 9), rng.randint(-(2**90), 2**90)]) for _ in range(5)]
        p = Poly.of(*(F(c, rng.choice([1, 7, 2**99 + 1])) for c in a))
        found = cells._mantissas(p)
        assert [k for k, _, _ in found] == [k for k, c in enumerate(p.c) if c]
        for k, m, e in found:
            assert 0 <= F(p.c[k], p.d) / F(2) ** e - m < 1 and unit + 8 <= m.bit_length() <= unit + 9


def test_fixed_point_numbers_are_floors() -> None:
    given = (F(7, 3), 2), (F(-7, 3), 2), (F(7), 0), (F(47, 3), -2)
    assert [cells._fixed(value, places) for value, places in given] == [9, -10, 7, 3]
    assert cells._fixed(3) == 3 * 2**64


# ── forms from rationals ─────────────────────────────────────────────────────────────────────────────────────────────


def numbers(form: Form) -> tuple[int, int, int, list[int], int, int]:
    return form.m, form.e, form.c, form.l, form.q, form.r


def test_forms_of_short_numbers_are_exact_but_for_their_three_units(bits: Bits) -> None:
    bits(64)
    cell, one = Cell(F(1), F(2), False, TWO), 2**63
    assert numbers(cell.form(3, 1, 2, 1)) == (0, -63, 3 * one, [0, 2 * one, 0], 0, one + 3)
    assert numbers(cell.form(1, value=-3)) == (0, -63, one, [-3 * one, 0, 0], 0, 3)
    assert numbers(cell.form(r=F(3, 2))) == (0, -64, 0, [0, 0, 0], 0, 3 * one + 3)
    assert numbers(cell.form(F(1, 5)))[1] == -66  # 1/5 has its leading bit three places lower than 1
    assert numbers(cell.form(0, 2, 1)) == (0, -64, 0, [0, 0, 2 * one], 0, 3)
    nothing = cell.form()
    assert not nothing and numbers(nothing)[2:] == (0, [0, 0, 0], 0, 0)


def test_forms_contain_what_they_are_made_of_and_lose_three_units_at_most(bits: Bits) -> None:
    """At a corner three floors are against one bound: of 4 bits, so that they lose almost three now and then."""
    bits(4)
    cell, rng, worst = Cell(F(1), F(2), False, TWO), random.Random(3), F(0)
    for _ in range(500):
        c, value, r = (F(rng.randint(-999, 999), rng.randint(1, 99)) for _ in range(3))
        form = cell.form(c, 1, value, abs(r))
        unit = F(2) ** form.e
        for t in (-1, 1):
            assert contains(form, [F(0), F(t), F(1)], c + value * t + abs(r))
            assert contains(form, [F(0), F(t), F(1)], c + value * t - abs(r))
        assert form.r <= abs(r) / unit + 3
        worst = max(worst, (c + value + abs(r)) / unit - (form.c + form.l[1] + form.r - 3))
    assert 2.5 < worst < 3


@pytest.mark.parametrize("width", [F(0), F(1, 1000)])
def test_omega(width: Fraction) -> None:
    cell = Cell(F(9), F(9) + width, False, {})
    for t in (F(-1), F(0), F(1)):
        low, high = bounds(cell.omega(), [t])
        assert low**2 <= chi(cell, [t]) <= high**2 and high - low < F(1, 10**17) + width**2 / 100
    low, high = bounds(Cell(F(0), F(9), False, {}).omega(), [F(0)])
    assert low <= 0 and 3 <= high < F(31, 10)


def test_what_is_linear_in_symbols_is_known_from_its_values_with_one_of_them_changed() -> None:
    cell, first, others = Cell(F(3), F(3), False, TWO), Poly.of(1, 2, 5), [Poly.of(7, 2, 5), Poly.of(4, -3, 1)]
    found = cell.spread(first, *others)
    for u, w in ((0, 0), (1, 0), (0, 1), (F(-1, 2), 1)):
        p, q = (first + Poly.of(u) * (others[0] - first) + Poly.of(w) * (others[1] - first)).parts()
        for form, part in ((found.p, p), (found.q, q)):
            true = sum((F(c, part.d) * 3**k for k, c in enumerate(part.c)), F(0))
            low, high = bounds(form, [F(0), F(u), F(w)])
            assert low <= true <= high and high - low < F(1, 2**50)
    assert numbers(cell.spread(first, first).p) == numbers(cell.axis(first).p)
