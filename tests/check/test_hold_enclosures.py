"""The hold on a cell: its series, what they leave out, the doublings, and what bounds it on a wide cell."""

from __future__ import annotations

import random
from fractions import Fraction
from math import factorial, isqrt

import pytest
from test_cells import bounds, chi

from robimp.synthesis.check.enclosure import cells, forms
from robimp.synthesis.check.enclosure.cells import Cell
from robimp.synthesis.check.enclosure.forms import Axis, Form, UnresolvedError
from robimp.synthesis.check.joint import Ranges
from robimp.synthesis.check.polynomials import ONE, Poly

F = Fraction
ONE_SYMBOL: Ranges = {("impedance", "stiffness"): (F(2), F(5))}


def exponential(a: Fraction, n: int, many: int) -> list[Fraction]:
    """`e^{-sa}`, or `(1 − e^{-sa})/(sa)` for n = 1: coefficients in s."""
    return [(-a) ** k / factorial(k + n) for k in range(many)]


def on_axis(series: list[Fraction], x: Fraction) -> tuple[Fraction, Fraction]:
    """Re, and Im/ω, at s² = −x."""
    even, odd = (sum((c * (-x) ** i for i, c in enumerate(series[k::2])), F(0)) for k in (0, 1))
    return even, odd


def product(a: list[Fraction], b: list[Fraction]) -> list[Fraction]:
    return [sum((a[i] * b[k - i] for i in range(k + 1)), F(0)) for k in range(len(a))]


def true_hold(rate: Fraction, delay: Fraction) -> list[Fraction]:
    """Fifty terms in s: for angles up to 5 the rest is below 5^50/50! < 10^-29."""
    return product(exponential(delay, 0, 50), exponential(1 / rate, 1, 50))


def extent(form: Form, t: Fraction | int = 0) -> tuple[Fraction, Fraction]:
    return bounds(form, [F(t)] + [F(0)] * (len(form.l) - 1))


def about(value: Fraction, expected: Fraction) -> bool:
    return abs(value - expected) <= abs(expected) / 10**15


# ── series ───────────────────────────────────────────────────────────────────────────────────────────────────────────


@pytest.fixture
def precise(monkeypatch: pytest.MonkeyPatch) -> None:
    """Numbers of 400 bits, so that what the series leaves out is all that is left to see."""
    monkeypatch.setattr(cells, "BITS", 400)
    monkeypatch.setattr(forms, "BITS", 400)
    monkeypatch.setattr(cells._fixed, "__defaults__", (400,))
    monkeypatch.setattr(cells, "_mantissas", cells._mantissas.__wrapped__)


@pytest.mark.parametrize("n", [0, 1])
@pytest.mark.parametrize("angle", ["1/3", "1", "2"])
def test_what_thirty_terms_leave_out_is_accounted_for_and_no_more(n: int, angle: str, precise: None) -> None:
    """θ^30/30! for Re, a times that for Im/ω: what is left out is (for Re, n = 0) nearly that."""
    a, θ = F(3, 7), F(angle)
    x = (θ / a) ** 2
    found, true = Cell(x, x, False, ONE_SYMBOL)._exponential(a, n), on_axis(exponential(a, n, 90), x)
    short, rest = on_axis(exponential(a, n, 30), x), θ**30 / factorial(30)
    for form, value, kept, most in zip((found.p, found.q), true, short, (rest, a * rest), strict=True):
        low, high = extent(form)
        assert low <= value <= high and about(low, kept - most) and about(high, kept + most)
        assert about((high - low) / 2, most) and abs(value - kept) < most
    if n == 0:
        assert abs(true[0] - short[0]) > rest * F(99, 100)


def test_the_series_have_thirty_terms() -> None:
    for n in (0, 1):
        assert cells._series(F(2, 3), n) == Poly.of(*exponential(F(2, 3), n, 30))
        assert len(cells._series(F(2, 3), n).c) == 30


# ── doublings ────────────────────────────────────────────────────────────────────────────────────────────────────────


@pytest.mark.parametrize(
    ("rate", "delay", "hi", "k"),
    [  # the larger of T and the delay, times the largest ω, is halved until it is at most 2
        ("1/3", "1", "1/9", 0),
        ("1/3", "1", "4/9", 0),
        ("1/3", "1", "5/9", 1),
        ("1/3", "1", "16/9", 1),
        ("1/3", "1", "17/9", 2),
        ("3", "1/5", "36", 0),
        ("3", "5", "4/25", 0),
        ("3", "5", "16/25", 1),
        ("3", "5", "17/25", 2),
        ("3", "5", "26", 4),
        ("3", "5", "64/25", 2),
        ("3", "5", "65/25", 3),
    ],
)
def test_angles_are_halved_until_they_are_at_most_two(
    rate: str, delay: str, hi: str, k: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    cell, asked = Cell(F(hi) / 2, F(hi), False, {}), list[tuple[Fraction, int]]()

    def half(_: Cell, a: Fraction, n: int) -> Axis:
        asked.append((a, n))
        return Axis(cell.form(F(1, 2)), cell.form())

    monkeypatch.setattr(Cell, "_exponential", half)
    cell.hold(F(rate), F(delay))
    assert asked == [(F(delay) / 2**k, 0), (1 / F(rate) / 2**k, 0), (1 / F(rate) / 2**k, 1)]


@pytest.mark.parametrize(
    ("wait", "lag", "mean", "found"),
    [  # wait² mean (lag + 1)/2, unless one of the three, or this, reaches 2
        ("1", "1/2", "1/2", "3/8"),
        ("1", "1", "1", "1"),
        ("3/2", "1", "1/2", "9/8"),
        ("3/2", "1", "1", None),
        ("2", "1", "1/8", None),
        ("1/8", "2", "1", None),
        ("1/8", "1/8", "2", None),
        ("1/8", "7/4", "15/8", "165/4096"),
    ],
)
def test_a_form_that_reaches_two_is_too_wide_to_go_on(
    wait: str, lag: str, mean: str, found: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    cell = Cell(F(9), F(9), False, {})
    given, bounded = iter([wait, lag, mean]), Axis(cell.form(), cell.form(r=1))
    monkeypatch.setattr(Cell, "_exponential", lambda *_: Axis(cell.form(F(next(given))), cell.form()))
    monkeypatch.setattr(Cell, "_bounded_hold", lambda cell, rate: bounded)
    hold = cell.hold(F(1), F(0))
    assert (hold is bounded) == (found is None)
    if found:
        assert all(about(end, F(found)) for end in extent(hold.p)) and not hold.q


@pytest.mark.parametrize(("mean", "found"), [("3/2", "3/2"), ("2", None)])
def test_without_doubling_only_the_product_is_looked_at(
    mean: str, found: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    cell = Cell(F(1), F(1), False, {})
    given, bounded = iter(["1", "7", mean]), Axis(cell.form(), cell.form(r=1))
    monkeypatch.setattr(Cell, "_exponential", lambda *_: Axis(cell.form(F(next(given))), cell.form()))
    monkeypatch.setattr(Cell, "_bounded_hold", lambda cell, rate: bounded)
    hold = cell.hold(F(1), F(0))
    assert hold is bounded if found is None else all(about(end, F(found)) for end in extent(hold.p))


def test_each_doubling_ends_without_a_power_of_zeta_in_front(monkeypatch: pytest.MonkeyPatch) -> None:
    """A power that grew with every one of many doublings would have no end."""
    cell = Cell(F(9), F(9), False, {})

    def shifted(*_: object) -> Axis:
        return Axis(cell.form(F(1, 4)).at(1), cell.form(F(1, 64)).at(1))

    monkeypatch.setattr(Cell, "_exponential", shifted)
    hold = cell.hold(F(1), F(0))
    z = Poly.of(F(1, 4), F(1, 64))  # in s: wait, lag and mean
    parts = (z * z * z * (z + ONE) * Poly.of(F(1, 2))).parts()
    assert hold.p.m == hold.q.m == 0
    for form, part in zip((hold.p, hold.q), parts, strict=True):
        value = sum((F(c, part.d) * 9**k for k, c in enumerate(part.c)), F(0))
        assert all(about(end, value) for end in extent(form))


@pytest.mark.parametrize("seed", range(4))
def test_the_hold_contains_the_exact_value_and_on_narrow_cells_little_else(seed: int) -> None:
    rng = random.Random(seed)
    for _ in range(6):
        rate, delay = F(rng.randint(1, 99), rng.randint(1, 9)), F(rng.randint(0, 99), rng.randint(1, 9))
        ω = F(rng.randint(1, 80), 20) / (1 / rate + delay)  # angles up to 4, and 5 where the cell ends
        width = rng.choice([F(0), F(1, 10**6), F(1, 100), F(1, 2)])
        cell = Cell(ω**2, ω**2 * (1 + width), False, ONE_SYMBOL)
        hold, series = cell.hold(rate, delay), true_hold(rate, delay)
        for t in (F(-1), F(1, 3), F(1)):
            true = on_axis(series, chi(cell, [t]))
            for form, value, scale in zip((hold.p, hold.q), true, (F(1), 1 / ω), strict=True):
                low, high = extent(form, t)
                assert low <= value <= high
                assert high - low < scale * (F(1, 10**14) + 100 * width**3)


def test_the_hold_at_zero_is_one_less_its_mean_delay() -> None:
    hold = Cell(F(0), F(0), False, {}).hold(F(4), F(3))
    assert hold.p.m == hold.q.m == 0
    assert all(about(end, F(1)) for end in extent(hold.p)) and all(about(end, -F(25, 8)) for end in extent(hold.q))


# ── bounds ───────────────────────────────────────────────────────────────────────────────────────────────────────────


def root(x: Fraction) -> Fraction:
    return F(isqrt(x.numerator * x.denominator * 10**60), x.denominator * 10**30)


@pytest.mark.parametrize(
    ("lo", "most"),
    [("1/9", "1"), ("100/9", "1"), ("71/2", "1"), ("36", "1"), ("73/2", ""), ("44", ""), ("400", ""), ("10000", "")],
)
def test_a_hold_on_a_wide_cell_is_at_most_one_or_two_over_the_angle(lo: str, most: str) -> None:
    """T = 1/3: from ω = 6 on, 2/(ωT) is the lower one."""
    cell = Cell(F(lo), F(lo) * 50, False, ONE_SYMBOL)
    hold, ω = cell._bounded_hold(F(3)), root(F(lo))
    size = F(most) if most else 6 / ω
    for form, bound in ((hold.p, size), (hold.q, size / ω)):
        low, high = extent(form)
        assert min(-low, high) >= bound * (1 - F(1, 10**28))
        assert about(low, -bound) and about(high, bound) and not any([*form.l, form.q])


def test_a_wide_cell_takes_the_bounds_and_one_at_zero_is_halved() -> None:
    wide = Cell(F(10), F(10**6), False, {})
    found, expected = wide.hold(F(2), F(1)), wide._bounded_hold(F(2))
    assert [extent(f) for f in (found.p, found.q)] == [extent(f) for f in (expected.p, expected.q)]
    with pytest.raises(UnresolvedError):
        Cell(F(0), F(10**6), False, {}).hold(F(2), F(1))


@pytest.mark.parametrize(("hi", "rate"), [("1/4", "1"), ("1/2", "3"), ("7/10000", "1000")])
def test_the_hold_at_infinity_is_at_most_two_over_the_angle(hi: str, rate: str) -> None:
    """w/(sT) = p + q/s with |w| ≤ 2: |p| ≤ 2/(ωT), |q| ≤ 2/T, and both are reached."""
    hold = Cell(F(0), F(hi), True, ONE_SYMBOL).hold(F(rate), F(1))
    for form, bound in ((hold.p, 2 * F(rate) * root(F(hi))), (hold.q, 2 * F(rate))):
        low, high = extent(form)
        assert about(low, -bound) and about(high, bound) and low <= -bound <= bound <= high
        assert form.m == 0 and not any([*form.l, form.q])
