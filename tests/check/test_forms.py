"""Forms `ζ^m 2^e (c + Σ l_i t_i + q t_0² ± r)`: an operation encloses all it should, and its r is what that takes.

Sums, products and what is cut to 64 bits are compared with exact ones.
"""

from __future__ import annotations

import random
from collections.abc import Iterator
from fractions import Fraction
from itertools import product
from math import ceil

import pytest

from robimp.synthesis.check.enclosure.cells import Cell
from robimp.synthesis.check.enclosure.forms import Form, UnresolvedError
from robimp.synthesis.check.polynomials import Poly

BITS = 64
CELL = Cell(Fraction(1), Fraction(4), False, {})  # b = 2: ζ = −χ/4, from −1/4 to −1
ZERO, FAR = (Cell(Fraction(0), Fraction(1, 4), far, {}) for far in (False, True))
Point = tuple[Fraction, ...]  # t_0, t_1, … in [−1, 1]


def form(c: int = 0, slopes: list[int] | None = None, q: int = 0, r: int = 0, e: int = 0, m: int = 0) -> Form:
    return Form(CELL, m, e, c, slopes or [0], q, r)


def numbers(f: Form) -> tuple[int, int, int, list[int], int, int]:
    assert f.w == sum(map(abs, f.l)) + abs(f.q)
    return f.m, f.e, f.c, f.l, f.q, f.r


def between(f: Form, t: Point) -> tuple[Fraction, Fraction]:
    """What a form says at one point, exactly."""
    zeta = -((f.cell.lo + f.cell.hi) / 2 + (f.cell.hi - f.cell.lo) / 2 * t[0]) / Fraction(2) ** f.cell.b
    middle = f.c + sum(a * x for a, x in zip(f.l, t, strict=True)) + f.q * t[0] ** 2
    low, high = sorted(zeta**f.m * Fraction(2) ** f.e * (middle + side) for side in (-f.r, f.r))
    return low, high


def points(n: int) -> Iterator[Point]:
    """Corners, all if there are few, and between them in t_0."""
    rng = random.Random(n)
    signs = list(product((-1, 1), repeat=n - 1)) if n < 4 else [rng.choices((-1, 1), k=n - 1) for _ in range(4)]
    for t_0, others in product((-3, 0, 1, 3), signs):
        yield (Fraction(t_0, 3), *map(Fraction, others))


# --- 64 bits


FULL = 2**BITS - 1


@pytest.mark.parametrize("given", [
    (FULL, [0], 0, 0), (-FULL, [0], 0, 0), (0, [-FULL], 0, 0), (0, [0, FULL], 0, 0), (0, [0], -FULL, 0),
    (0, [0], 0, FULL),
    (-(2**62), [2**62, -1], -(2**62), 2**62 - 2), (2**62, [-(2**62), 2**61], 2**62 - 1, 2**61),
])  # fmt: skip
def test_64_bits_are_kept_and_the_65th_is_not(given: tuple[int, list[int], int, int]) -> None:
    c, slopes, q, r = given
    kept = form(c, slopes, q, r, e=-7, m=2)
    assert numbers(kept) == (2, -7, *given)
    assert form(c, slopes, q, r + 1).e == form(2 * c, [2 * v for v in slopes], 2 * q, 2 * r + 1).e == 1
    assert form(8 * c, [8 * v for v in slopes], 8 * q, 8 * r).e == 3


@pytest.mark.parametrize("n", [1, 2, 5])
@pytest.mark.parametrize("sign", [1, -1])
def test_the_bound_takes_up_all_that_floors_can_lose_and_no_more(n: int, sign: int) -> None:
    """Every number loses almost one: at t_i = 1 they add up to almost n + 2, and r loses one more."""
    lost = 2**20 - 1
    c, q, r = sign * 2**83 + lost, sign * 5 * 2**20 + lost, 9 * 2**20 + lost
    f = form(c, [sign * 3 * 2**20 + lost] * n, q, r)
    assert (f.e, f.c, f.l, f.q) == (20, c >> 20, [sign * 3] * n, sign * 5)
    assert f.r == ceil(Fraction(r + (n + 2) * lost, 2**20))


@pytest.mark.parametrize("n", [1, 2, 5])
def test_the_size_of_what_is_not_constant_is_never_below_the_true_one(n: int) -> None:
    """Floors of negative numbers grow: by almost one each, when only one more than a multiple is there."""
    f = form(2**83, [-(3 * 2**20 + 1)] * n, -(5 * 2**20 + 1), 7)
    assert f.w == sum(map(abs, f.l)) + abs(f.q) == 4 * n + 6


# --- what is exact


def test_questions() -> None:
    assert not form() and not form(e=5, m=-2)
    assert all(form(**{k: v}) for k, v in {"c": -1, "slopes": [0, 1], "q": -1, "r": 1}.items())  # type: ignore[arg-type]
    for c, slopes, q, r in ((3, [-4, 1], 2, 1), (-3, [0], 0, 0), (0, [0, 0], -8, 8), (1, [1], 1, 5)):
        f, spread = form(c, slopes, q, r, e=-3, m=4), sum(map(abs, slopes)) + abs(q) + r
        assert f.middle() == Fraction(c, 8) and f.width() == Fraction(spread, 8)
        assert 2 ** (f.size() - 1) <= Fraction(abs(c) + spread, 8) < Fraction(2) ** f.size()
    assert form(3, e=5).middle() == 96 and form(3, r=3, e=5).width() == 96 and form(7, e=5).size() == 8


def test_what_needs_no_rounding() -> None:
    f = form(5, [-2, 3], 7, 4, e=3, m=-1)
    assert numbers(-f) == (-1, 3, -5, [2, -3], -7, 4)
    assert numbers(f.up()) == (0, 5, 5, [-2, 3], 7, 4)  # τ² = 2^b ζ
    assert numbers(f.scaled(-6)) == (-1, 3, -30, [12, -18], -42, 24)
    assert numbers(f.scaled(2)) == (-1, 3, 10, [-4, 6], 14, 8)
    assert numbers(f.along(1)) == (-1, 3, 0, [0, 5], 0, 16)  # `t_1 (5 ± 2 ± 3 ± 7 ± 4)`
    assert numbers(form(-9, [0, 1, 2]).along(2)) == (0, 0, 0, [0, 0, -9], 0, 3)


def test_a_sum_of_one_power_is_exact_over_64_binary_digits() -> None:
    a, b = form(3, [1, -2], 4, 5, e=2, m=1), form(-7, [5, 0], -1, 1, e=0, m=1)
    assert numbers(a + b) == numbers(b + a) == (1, 0, 5, [9, -8], 15, 21)
    assert numbers(a - b) == (1, 0, 19, [-1, -8], 17, 21)
    assert numbers(a + a) == (1, 2, 6, [2, -4], 8, 10)
    high, low = form(1, e=BITS, m=3), form(-50, [3], -4, 5, m=3)
    assert numbers(high + low) == numbers(low + high) == (3, 0, 2**BITS - 50, [3], -4, 5)
    wide = form(0, [1], 0, 0, e=62), form(0, [0], 1, 0, e=62), form(0, [0], 0, 1, e=62)
    assert [numbers(f + form(1))[1:] for f in wide] == [
        (0, 1, [2**62], 0, 0), (0, 1, [0], 2**62, 0), (0, 1, [0], 0, 2**62),
    ]  # fmt: skip


@pytest.mark.parametrize("n", [1, 2, 5])
def test_a_sum_of_very_different_sizes_takes_up_what_is_cut_and_no_more(n: int) -> None:
    """The larger one is moved by 64 digits; of the smaller one every number loses almost one."""
    high, low = form(1, [0] * n, e=BITS + 8), form(-(2**62) - 1, [3 * 256 + 255] * n, 5 * 256 + 255, 7 * 256 + 255)
    for f in (high + low, low + high):
        assert numbers(f)[:-1] == (0, 8, 2**BITS - 2**54 - 1, [3] * n, 5)
        assert f.r == ceil(Fraction(low.r + (n + 2) * 255, 256))


def test_nothing_added_changes_nothing_whatever_its_power() -> None:
    for cell in (CELL, ZERO, FAR):
        for m in (-1, 0, 2):
            nothing, f = Form(cell, m, 9, 0, [0], 0, 0), Form(cell, 1, 0, 5, [1], 0, 0)
            assert f + nothing is nothing + f is f
            assert not nothing + nothing and (nothing * f).m == m + 1 and not nothing * f


def test_polynomials_are_added_and_multiplied_on_either_side() -> None:
    p, f = Poly.of(0, 1, Fraction(1, 3)), form(5, [1])
    for t in points(1):
        x = Fraction(5, 2) + Fraction(3, 2) * t[0]
        u, v = x + x * x / 3, 5 + t[0]
        for made, true in ((f + p, u + v), (p + f, u + v), (p - f, u - v), (f * p, u * v), (p * f, u * v)):
            low, high = between(made, t)
            assert low <= true <= high


# --- powers of ζ


@pytest.mark.parametrize("m, to", [(0, 1), (0, -1), (2, -1), (-3, 1), (1, 3), (-1, -2)])
def test_the_same_value_with_another_power_of_zeta(m: int, to: int) -> None:
    narrow = Cell(Fraction(100), Fraction(101), False, {})
    f = Form(narrow, m, 3, 40, [5], -6, 2)
    moved = f.at(to)
    assert moved.m == to and f.m == m and f.at(m) is f
    assert moved.width() < Fraction(11, 10) * abs(moved.middle()) / 40 * 13
    for t in points(1):
        (low, high), (least, most) = between(f, t), between(moved, t)
        assert least <= low < high <= most


def test_where_zeta_reaches_zero_only_lower_powers_are_possible() -> None:
    for cell in (ZERO, FAR):
        f, nothing = Form(cell, 1, 0, 5, [1], 0, 0), Form(cell, 1, 0, 0, [0], 0, 0)
        for m in (2, 5):
            with pytest.raises(UnresolvedError):
                f.at(m)
            assert nothing.at(m).m == m and not nothing.at(m)
        assert f.at(1) is f and not nothing.at(0) and nothing.at(0).m == 0
        for t in ((Fraction(-1, 2),), (Fraction(0),), (Fraction(1),)):
            (low, high), (least, most) = between(f, t), between(f.at(0), t)
            assert least <= low <= high <= most


def test_a_sum_keeps_the_power_of_the_larger_or_where_zeta_reaches_zero_the_lower_one() -> None:
    for cell in (CELL, ZERO, FAR):
        for m, to in ((2, 0), (0, 2), (-1, 1)):
            large, small = Form(cell, m, 40, 5, [1], 0, 0), Form(cell, to, 0, 3, [-1], 1, 1)
            for f in (large + small, small + large):
                assert f.m == (m if cell is CELL else min(m, to))
                for t in ((Fraction(-1, 2),), (Fraction(0),), (Fraction(1),)):
                    low, high = map(sum, zip(between(large, t), between(small, t), strict=True))
                    assert between(f, t)[0] <= low <= high <= between(f, t)[1]


# --- products


def product_of(a: Form, b: Form) -> tuple[Fraction, list[Fraction], Fraction, Fraction]:
    """c, l, q and r by multiplying out: t_0² is kept, t_i² is 1/2 ± 1/2, any other two are at most 1."""
    c, q, r = Fraction(a.c * b.c), Fraction(a.c * b.q + b.c * a.q), Fraction(0)
    for (i, u), (k, v) in product(enumerate([*a.l, a.q]), enumerate([*b.l, b.q])):
        if i == k == 0:
            q += u * v
        elif i == k < len(a.l):
            c, r = c + Fraction(u * v, 2), r + Fraction(abs(u * v), 2)
        else:
            r += abs(u * v)
    most = [abs(f.c) + sum(map(abs, f.l)) + abs(f.q) for f in (a, b)]
    r += most[0] * b.r + most[1] * a.r + a.r * b.r
    return c, [Fraction(a.c * v + b.c * u) for u, v in zip(a.l, b.l, strict=True)], q, r


def test_a_product_is_multiplied_out() -> None:
    rng = random.Random(1)
    for n, bits in product((1, 2, 4), (3, 20)):
        for _ in range(60):
            a, b = (Form(CELL, rng.randint(-3, 3), rng.randint(-9, 9), *some(rng, n, bits)) for _ in range(2))
            f, (c, slopes, q, r) = a * b, product_of(a, b)
            assert (f.m, f.e, f.w) == (a.m + b.m, a.e + b.e - 1, sum(map(abs, f.l)) + abs(f.q))
            assert [Fraction(v, 2) for v in (f.c, *f.l, f.q, f.r)] == [c, *slopes, q, r]


def some(rng: random.Random, n: int, bits: int) -> tuple[int, list[int], int, int]:
    """Numbers of a form, some of them 0."""
    c, q, *slopes = (rng.choice((0, 1, 1)) * rng.randint(-(2**bits), 2**bits) for _ in range(n + 2))
    return c, slopes, q, rng.choice((0, 1)) * rng.randint(0, 2**bits)


@pytest.mark.parametrize("n, bits", [(1, 33), (1, 61), (3, 33), (3, 61)])
def test_large_products_and_sums_contain_those_at_every_point(n: int, bits: int) -> None:
    rng = random.Random(bits + n)
    for _ in range(6):
        a, b = (Form(CELL, 0, rng.randint(-70, 70), *some(rng, n, bits)) for _ in range(2))
        for t, (f, does) in product(points(n), ((a * b, Fraction.__mul__), (a + b, Fraction.__add__))):
            ends = [does(u, v) for u, v in product(between(a, t), between(b, t))]
            assert between(f, t)[0] <= min(ends) <= max(ends) <= between(f, t)[1]
