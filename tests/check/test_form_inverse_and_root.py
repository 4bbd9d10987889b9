"""1/f and √f contain the true values, also where f is smallest, and are not wider than their remainder explains."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator
from fractions import Fraction
from itertools import product
from math import isqrt

import pytest

from robimp.synthesis.check.enclosure.cells import Cell
from robimp.synthesis.check.enclosure.forms import Form, UnresolvedError

BITS = 64
CELL = Cell(Fraction(1), Fraction(4), False, {})
WHERE = {
    "place": (1, 0, 0, 0),
    "symbols": (0, 1, 0, 0),
    "bend": (0, 0, 1, 0),
    "unknown": (0, 0, 0, 1),
    "all": (3, 2, 1, 2),
}
KEPT: tuple[Callable[[Form], int], ...] = (lambda f: f.l[1], lambda f: f.q)
START = 12 * 10**18  # of 64 bits
SHARES = [
    Fraction(0),
    Fraction(1, 2**40),
    Fraction(1, 300),
    Fraction(1, 9),
    Fraction(1, 2),
    Fraction(29, 30),
    Fraction(1),
]


def form(c: int, slopes: list[int] | None = None, q: int = 0, r: int = 0, e: int = 0, m: int = 0) -> Form:
    return Form(CELL, m, e, c, slopes or [0], q, r)


def between(f: Form, t: tuple[int, ...]) -> tuple[Fraction, Fraction]:
    """What a form says at one point, without its power of ζ."""
    middle = f.c + sum(a * x for a, x in zip(f.l, t, strict=True)) + f.q * t[0] ** 2
    return (middle - f.r) * Fraction(2) ** f.e, (middle + f.r) * Fraction(2) ** f.e


def points(n: int) -> Iterator[tuple[int, ...]]:
    """t_0 = 0 and corners: those where all t_i are the same, and some others."""
    rng = random.Random(n)
    for t_0, k in product((-1, 0, 1), (-1, 1, None, None)):
        yield (t_0, *([k] * (n - 1) if k else rng.choices((-1, 1), k=n - 1)))


def some(rng: random.Random, n: int, bits: int, where: str, share: Fraction) -> Form:
    """A form with a positive c, and a given share of it elsewhere."""
    c = rng.choice((2**bits, 2**bits - 1, rng.randint(2 ** (bits - 1), 2**bits)))
    D = min(int(c * share), c - 1)
    weights = [w for w, k in zip(WHERE[where], (1, n - 1, 1, 1), strict=True) for _ in range(k)]
    parts = [D * w // max(sum(weights), 1) for w in weights]
    *slopes, q = (part * rng.choice((-1, 1)) for part in parts[:-1])
    return form(c, slopes, q, parts[-1], rng.randint(-70, 70), rng.randint(-2, 2))


def cases(seed: int, n: int) -> Iterator[Form]:
    """Forms with n coefficients of 1 to 62 bits: some with their variation in one place, some in all."""
    rng = random.Random(seed)
    for where, share in product(WHERE, SHARES):
        if where != "symbols" or n > 1:
            for _ in range(4 if n < 20 else 1):
                yield some(rng, n, rng.choice((1, 2, 4, 11, 30, 62)), where, share)


@pytest.mark.parametrize("n", [1, 3, 20])
def test_an_inverse_contains_the_inverse_at_every_point(n: int) -> None:
    for f in cases(1, n):
        g = f.inverse()
        assert g.m == -f.m
        for t in points(n):
            (low, high), (least, most) = between(f, t), between(g, t)
            assert least <= 1 / high <= 1 / low <= most, (f.c, f.l, f.q, f.r)


@pytest.mark.parametrize("n", [1, 3, 20])
def test_an_inverse_is_as_wide_as_its_remainder_and_its_floors(n: int) -> None:
    """`(D² − l_0²)/c³ + D³/(c³(c − D)) + r/c²`, a unit for its floor, two a number, and eight; all halved at least."""
    for f in cases(2, n):
        g, D = f.inverse(), f.w + f.r
        rest = (Fraction(D * D - f.l[0] ** 2) + Fraction(D**3, f.c - D)) / f.c**3 + Fraction(f.r, f.c**2)
        assert g.r <= rest / Fraction(2) ** (f.e + g.e) + Fraction(2 * n + 9, 2) + n + 3
        assert (abs(g.c) + g.w + g.r).bit_length() >= BITS - 1


def test_an_inverse_keeps_the_second_order_in_the_place_and_the_sign() -> None:
    """1/(8 + t_0) = 1/8 − t_0/64 + t_0²/512 ± 1/3584, 1/(8 + t_0²) = 1/8 − t_0²/64 ± …, to 60 bits."""
    for f, slope, bend in ((form(8, [1]), -1, 1), (form(8, [0], 1), 0, -8), (form(8, [2, 1], -2), -2, 4 + 16)):
        g, digits = f.inverse(), Fraction(1, 2**60)
        for found, true in ((g.c, 64), (g.l[0], 8 * slope), (g.q, bend)):
            assert abs(found * Fraction(2) ** g.e - Fraction(true, 512)) < digits
        h = (-f).inverse()
        assert (h.e, h.c, h.l, h.q, h.r) == (g.e, -g.c, [-v for v in g.l], -g.q, g.r)
    assert abs(form(-1).inverse().middle() + 1) < digits  # the smallest one, too


@pytest.mark.parametrize("f", [
    form(0), form(0, r=1), form(5, [3], 1, 1), form(-5, [3], 1, 1), form(5, [0, 5]), form(-5, q=5), form(5, r=5),
    form(3, [9]),
])  # fmt: skip
def test_what_may_be_zero_has_no_inverse(f: Form) -> None:
    with pytest.raises(UnresolvedError):
        f.inverse()


def contains_root(g: Form, t: tuple[int, ...], low: Fraction, high: Fraction) -> bool:
    """Whether √low and √high are in it: compared as squares."""
    least, most = between(g, t)
    return (least <= 0 or least**2 <= low) and most >= 0 and most**2 >= high


def sqrt(value: Fraction) -> Fraction:
    return Fraction(isqrt(int(value * 4**200)), 2**200)


@pytest.mark.parametrize("n", [1, 3, 20])
def test_a_root_contains_the_root_at_every_point(n: int) -> None:
    for f in cases(3, n):
        g = f.root()
        assert g.m == 0
        for t in points(n):
            assert contains_root(g, t, *between(f, t)), (f.c, f.l, f.q, f.r)


@pytest.mark.parametrize("n", [1, 3, 20])
def test_a_root_is_as_wide_as_its_remainder_and_its_floors(n: int) -> None:
    """`(√c − √(c − D))²/(4√c) + r/(2√c)`; of n + 7 units of what is computed sixteen or more are one of the result."""
    for f in cases(4, n):
        g, D, unit = f.root(), f.w + f.r, Fraction(2) ** f.e
        root = sqrt(f.c * unit)
        rest = (root - sqrt((f.c - D) * unit)) ** 2 / root / 4 + f.r * unit / root / 2
        assert g.r <= rest / Fraction(2) ** g.e + Fraction(n + 7, 16) + n + 3
        assert (abs(g.c) + g.w + g.r).bit_length() >= BITS - 1


@pytest.mark.parametrize("n", [1, 3, 10])
def test_the_first_rounding_of_a_root_costs_less_than_one_unit_of_the_second(n: int) -> None:
    """n + 5 of at least sixteen, with ten coefficients fifteen; the second, to 64 bits, takes n + 3."""
    for c in (1, 2**63 + 1, 3**39):
        assert form(c, [0] * n, e=1).root().r == form(c, [0] * n).root().r == n + 3


@pytest.mark.parametrize("n", [1, 4, 30])
@pytest.mark.parametrize("operation, lost", [(Form.inverse, Fraction(5, 4)), (Form.root, Fraction(14, 5))])
def test_the_bounds_hold_where_every_floor_loses_much(
    operation: Callable[[Form], Form], lost: Fraction, n: int
) -> None:
    """Of many numbers those are taken of which most is cut off, all in one direction; then r goes on by one."""

    def true(c: int) -> tuple[Fraction, Fraction]:
        value = sqrt(Fraction(c)) if operation is Form.root else Fraction(1, c)
        return value, (1 / value / 2 if operation is Form.root else -(value**2))  # and its derivative

    unit = Fraction(2) ** operation(form(START)).e
    c = max(range(START, START + 300), key=lambda c: true(c)[0] / unit - operation(form(c)).c)
    value, slope = (a / unit for a in true(c))
    slopes, bends = ({v: v * slope - kept(operation(form(c, [0, v], v))) for v in range(-300, 300)} for kept in KEPT)
    v, bend = (max(less, key=lambda v: less[v]) for less in (slopes, bends))
    assert value - operation(form(c)).c + slopes[v] + bends[bend] > lost  # three floors, in units
    for r, side in product(range(64), (-1, 0, 1)):
        f = form(c, [v] * n, bend, r)
        g, t = operation(f), (side,) * n
        (low, high), (least, most) = between(f, t), between(g, t)
        assert contains_root(g, t, low, high) if operation is Form.root else least <= 1 / high <= 1 / low <= most


@pytest.mark.parametrize("e", [0, 1, -1, -63, 70])
@pytest.mark.parametrize(
    "slopes, q, r", [([9], 0, 0), ([0, 9], 0, 0), ([-4, 2], -1, 2), ([0], 0, 9), ([10], 0, 0), ([1], 2, 80)]
)
def test_the_root_of_what_may_reach_zero_is_anything_up_to_the_largest(
    slopes: list[int], q: int, r: int, e: int
) -> None:
    f = form(9, slopes, q, r, e)
    g, n = f.root(), len(slopes)
    least, most = between(g, (0,) * n)
    assert g.m == g.q == 0 and not any(g.l)
    top = (9 + f.w + f.r) * Fraction(2) ** e
    assert contains_root(g, (0,) * n, Fraction(0), top)
    few = (2 * n + 8) * Fraction(2) ** g.e
    assert -few <= least and most <= sqrt(top) + few and g.c.bit_length() > BITS - 3


@pytest.mark.parametrize("e", [0, 1])
@pytest.mark.parametrize("over", range(1, 40))
def test_the_root_of_a_little_more_than_zero_has_half_the_digits_and_less_than_two_units_too_many(
    over: int, e: int
) -> None:
    """c + D = `over`, of numbers of 64 bits, and c < 0: the root has so few digits that none is cut."""
    g, value = form(-(2**62), [0, 0], 0, 2**62 + over, e).root(), Fraction(over * 2**e)
    least, most = between(g, (0, 0))
    assert (g.m, g.e, g.l, g.q) == (0, -36, [0, 0], 0)
    assert contains_root(g, (0, 0), Fraction(0), value) and least >= -(Fraction(2) ** g.e)
    assert most <= sqrt(value) + 2 * Fraction(2) ** g.e


@pytest.mark.parametrize("c, r", [(0, 0), (-5, 0), (-5, 5), (-(2**63), 2**20)])
def test_the_root_of_what_is_not_above_zero_is_zero_and_less_than_a_unit(c: int, r: int) -> None:
    g = form(c, [0, 0], 0, r, 10).root()
    assert (g.m, g.c, g.l, g.q, g.r) == (0, 0, [0, 0], 0, 1) and g.e < -26


@pytest.mark.parametrize("f, root, slope", [
    (form(25 << 40, [10]), 5 << 20, 1), (form(4 << 40, [0, 4]), 2 << 20, 1), (form(9, e=4), 12, 0),
])  # fmt: skip
def test_the_root_of_a_square_and_its_first_order(f: Form, root: int, slope: int) -> None:
    """√(25·2^40 + 10 t_0) = 5·2^20 + 2^−20 t_0 − …, √(4·2^40 + 4 t_1) = 2·2^20 + 2^−20 t_1 − …, √144 = 12."""
    g = f.root()
    assert abs(g.middle() - root) < Fraction(1, 2**19)
    assert abs(g.l[-1] * Fraction(2) ** g.e * 2**20 - slope) < Fraction(1, 2**19)
