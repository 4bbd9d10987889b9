"""Complex quantities on a cell are what their arithmetic says; a hull of zonotopes is shown not to contain 0."""

from __future__ import annotations

import random
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import pytest

from robimp.synthesis.check.enclosure import forms
from robimp.synthesis.check.enclosure.cells import Cell
from robimp.synthesis.check.enclosure.forms import Axis, Form, excludes_zero
from robimp.synthesis.check.polynomials import Poly

Pair = tuple[int, int]
Vector = tuple[Fraction, Fraction]
TWO = Cell(Fraction(4), Fraction(4), False, {})  # ω = 2, τ = s = 2j, ζ = −1
FAR = Cell(Fraction(1, 4), Fraction(1, 4), True, {})  # ω = 2 again, τ = 1/s = −j/2
WIDE = Cell(Fraction(1), Fraction(4), False, {})
ZERO = Cell(Fraction(0), Fraction(1, 16), False, {})  # it ends at ω = 0


def form(cell: Cell, c: int, m: int = 0, e: int = 0, r: int = 0) -> Form:
    return Form(cell, m, e, c, [0] * (len(cell.ranges) + 1), 0, r)


def axis(cell: Cell, p: int, q: int) -> Axis:
    return Axis(form(cell, p), form(cell, q))


def number(f: Form) -> float:
    """Of a form that is known well, where ζ = −1."""
    assert f.width() < 1e-12
    return float(-f.middle() if f.m % 2 else f.middle())


def complex_of(z: Axis) -> complex:
    return number(z.p) + number(z.q) * (-0.5j if z.p.cell.far else 2j)


def fields(f: Form) -> tuple[Any, ...]:
    return f.m, f.e, f.c, f.l, f.q, f.r


@pytest.mark.parametrize("cell", [TWO, FAR], ids=["s", "1/s"])
def test_the_arithmetic_of_complex_quantities(cell: Cell) -> None:
    rng, s = random.Random(1), 2j
    for _ in range(40):
        z, w = (axis(cell, rng.randint(-9, 9), rng.randint(-9, 9)) for _ in range(2))
        u, v, k = complex_of(z), complex_of(w), rng.randint(1, 9)
        for found, true in (
            (z + w, u + v), (z - w, u - v), (-z, -u), (z * w, u * v), (z.conj(), u.conjugate()),
            (z + Poly.of(k, 1), u + k + s), (Poly.of(k, 1) + z, u + k + s), (z * Poly.of(k, 3), u * (k + 3 * s)),
            (Poly.of(k) * z, k * u), (z * axis(cell, k, 0), k * u),
            (z * axis(cell, 0, k), u * k * (1 / s if cell.far else s)),
        ):  # fmt: skip
            assert complex_of(found) == pytest.approx(true, abs=1e-12)
        assert number(z.norm2()) == pytest.approx(abs(u) ** 2)
        assert [number(f) for f in z.parts()] == pytest.approx([u.real, u.imag / 2])
        if abs(u) > 0:
            assert complex_of(z.inverse()) == pytest.approx(1 / u)


def test_a_real_factor_multiplies_both_parts() -> None:
    for p, q in ((5, 7), (0, 7), (5, 0)):
        z, factor = axis(WIDE, p, q), axis(WIDE, 3, 0)
        found = z * factor
        assert (fields(found.p), fields(found.q)) == (fields(z.p * factor.p), fields(z.q * factor.p))


def test_a_symbol_times_a_complex_quantity() -> None:
    cell = Cell(Fraction(4), Fraction(4), False, dict.fromkeys([("plant", "inertia"), ("plant", "damping")], (0, 1)))  # type: ignore[arg-type]
    for k in (1, 2):
        found = axis(cell, 5, 7).along(k)
        for f, c in ((found.p, 5), (found.q, 7)):
            assert (f.c, f.l, f.q, f.r) == (0, [0, *(c * (n == k) for n in (1, 2))], 0, 0)


@pytest.mark.parametrize(
    ("p", "q", "finite"),
    [
        ((0, 5), (0, 5), True), ((1, 5), (2, 5), True), ((-1, 5), (0, 5), False), ((0, 5), (-1, 5), False),
        ((-1, 0), (1, 5), True), ((0, 5), (-1, 0), True), ((-1, 0), (-2, 0), True), ((-1, 5), (-1, 0), False),
    ],
)  # fmt: skip
def test_a_quantity_is_bounded_where_no_power_of_zeta_is_divided_by(p: Pair, q: Pair, finite: bool) -> None:
    assert Axis(form(ZERO, p[1], p[0]), form(ZERO, q[1], q[0])).bounded() is finite


def zonotopes(cell: Cell, given: list[list[Pair]], e: int = 0, d: int = 0) -> list[list[Axis]]:
    """Centre and generators (p, q), in units of 2^e and 2^d."""
    return [[Axis(form(cell, p, 0, e), form(cell, q, 0, d)) for p, q in z] for z in given]


def share(v: Vector, given: list[list[Pair]]) -> Fraction | None:
    """How much of the centre's distance is left, if all zonotopes are on one side at all."""
    rows = [[v[0] * p + v[1] * q for p, q in z] for z in given]
    one_side = all(row[0] > 0 for row in rows) or all(row[0] < 0 for row in rows)
    return min(1 - sum(map(abs, row[1:])) / abs(row[0]) for row in rows) if one_side else None


@pytest.mark.parametrize("hulls", [1, 2])
@pytest.mark.parametrize(("e", "d"), [(0, 0), (60, -60), (-60, 60), (3000, -3000), (-3000, 3000)])
def test_the_three_directions_that_leave_most_are_tried(
    hulls: int, e: int, d: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Normals (−q, p) of the edges, and the centre's, in units in which p and q are as large: the best ones first."""
    tried: list[tuple[Form, Form, Any]] = []
    monkeypatch.setattr(forms, "_separates", lambda a, b, plane, own: tried.append((a, b, own)))
    rng, one = random.Random(f"{hulls} {e} {d}"), Fraction(1)
    counts = set()
    for _ in range(60):
        rows = [[(rng.randint(-99, 99) + 200, rng.randint(-99, 99) - 150)] for _ in range(hulls)]
        given = [[*row, *((rng.randint(-99, 99), rng.randint(-99, 99)) for _ in range(3))] for row in rows]
        bits = [max(abs(pair[k]) for z in given for pair in z).bit_length() for k in (0, 1)]
        p, q = (sum(z[0][k] for z in given) for k in (0, 1))
        wanted: list[tuple[Fraction | None, Pair, Pair | None]] = [
            (share((one * p / 4 ** bits[0], one * q / 4 ** bits[1]), given), (p, q), None)
        ]
        wanted += [(share((-one * v, one * u), given), (-v, u), (k, n)) for k, z in enumerate(given)
                   for n, (u, v) in enumerate(z) if n]  # fmt: skip
        best = sorted([w for w in wanted if w[0] and w[0] > 0], key=lambda w: w[0] or 0, reverse=True)
        tried.clear()
        planes = zonotopes(WIDE, given, e, d)
        assert excludes_zero(planes) == (False, bool(best))
        assert len(tried) == len(best[:3])
        counts.add(len(best))
        for (a, b, own), (_, (x, y), at) in zip(tried, best, strict=False):
            shifts = (-2 * bits[0] - e, -2 * bits[1] - d) if at is None else (d, e)
            assert (fields(a), fields(b)) == ((0, shifts[0], x, [0], 0, 0), (0, shifts[1], y, [0], 0, 0))
            edge = planes[at[0]][at[1]] if at else None
            assert own == (edge and (edge.p, edge.q))
    assert min(counts) < 3 < max(counts)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ([[(5, 3)]], (True, True)),
        ([[(-5, -3), (2, 1), (1, -1)]], (True, True)),
        ([[(1, 1), (9, 8)]], (True, True)),  # nothing but the edge's own normal shows it
        ([[(9, 8), (1, 1), (7, 7), (1, 1)]], (True, True)),
        ([[(2, 2), (2, 2)]], (False, False)),  # 0 is the end of a segment,
        ([[(2, 2), (3, 3)]], (False, False)),  # or inside it,
        ([[(4, 0), (4, 1), (0, 1)]], (False, False)),  # or on an edge, where an edge's normal says 4 ± 4
        ([[(0, 0), (1, 0)]], (False, False)),
        ([[(9, 10)], [(-8, 10)]], (True, True)),  # the hull of two
        ([[(9, 0)], [(-8, 0)]], (False, False)),
        ([[(9, 1), (1, 0)], [(8, 1), (0, 3)]], (True, True)),
        ([[(9, 1), (1, 0)], [(8, 1), (0, 3), (8, 0)]], (False, False)),
    ],
)
@pytest.mark.parametrize(("e", "d"), [(0, 0), (40, -40), (-40, 40), (3000, -3000), (-3000, 3000)])
def test_a_hull_without_zero(given: list[list[Pair]], said: tuple[bool, bool], e: int, d: int) -> None:
    assert excludes_zero(zonotopes(WIDE, given, e, d)) == said
    turned = [[(-q, p) for p, q in z] for z in given]
    assert excludes_zero(zonotopes(WIDE, turned, e, d)) == said


@pytest.mark.parametrize("bits", [3, 40, 70])
@pytest.mark.parametrize("width", [Fraction(0), Fraction(1, 10**12), Fraction(1, 8)])
def test_a_hull_that_zero_is_a_corner_of_is_never_excluded(bits: int, width: Fraction) -> None:
    """f_0 ± f_1 ± f_2 = 0 for all ω, or 0 is between two such corners; not so with 9/8 f_0."""
    rng, excluded = random.Random(f"{bits} {width}"), 0
    for _ in range(60):
        lo = Fraction(rng.randint(1, 99), rng.randint(1, 99))
        cell = Cell(lo, lo * (1 + width), False, {})
        rows = [Poly.of(*(Fraction(rng.getrandbits(bits) - 2 ** (bits - 1), 7) for _ in range(3))) for _ in range(2)]
        at_zero = sum((Poly.of(rng.choice((-1, 1))) * row for row in rows), Poly.of(0))
        off = Poly.of(*(rng.randint(-9, 9) for _ in range(3)))
        one = [cell.axis(p) for p in (at_zero, *rows)]
        hull = [[cell.axis(p) for p in (at_zero + Poly.of(k) * off, *rows)] for k in (2, -3)]
        assert not excludes_zero([one])[0] and not excludes_zero(hull)[0]
        excluded += excludes_zero([[one[0] * Poly.of(Fraction(9, 8)), *one[1:]]])[0]
    assert excluded > 30


@pytest.mark.parametrize("r", [0, 1])
def test_what_floating_point_takes_for_excluded_is_not_where_a_form_reaches_zero(r: int) -> None:
    """q = 1 ± r of the second: in the middle of the cell the centre's direction (0, 2) has it on one side."""
    first, second = axis(WIDE, 1, 1), Axis(form(WIDE, -1), form(WIDE, 1, r=r))
    assert excludes_zero([[first], [second]]) == (r == 0, True)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ([((0, 4), (0, 0)), ((0, 1), (0, 5))], (True, True)),  # q is multiplied by τ = 0 there
        ([((0, 4), (0, 0)), ((0, 1), (0, -5))], (True, True)),
        ([((0, -4), (0, 1)), ((0, 3), (1, 5))], (True, True)),
        ([((0, 4), (-1, 0))], (True, True)),
        ([((0, 4), (0, 0)), ((0, 4), (0, 0))], (False, False)),
        ([((1, 4), (0, 9))], (False, True)),  # p = 4ζ: zero at the end
        ([((1, 4), (1, 9))], (False, True)),
        ([((0, 4), (-1, 1))], (False, False)),  # not finite
        ([((-1, 4), (0, 1))], (False, False)),
        ([((0, 4), (0, 1)), ((0, 1), (-1, 1))], (False, False)),
    ],
)
def test_at_an_end_the_real_part_has_to_stay_away_from_zero(
    given: list[tuple[Pair, Pair]], said: tuple[bool, bool]
) -> None:
    z = [Axis(form(ZERO, p, m), form(ZERO, q, n)) for (m, p), (n, q) in given]
    assert excludes_zero([z]) == said
    assert excludes_zero([z, z]) == said
    assert excludes_zero([z, [Axis(form(ZERO, 4), form(ZERO, 0))]])[0] == (said[0] and given[0][0][1] > 0)


@pytest.mark.parametrize("power", [6, -6])
def test_forms_are_compared_at_the_power_of_the_first_centre(power: int) -> None:
    """There it is exact; what another power of ζ is on a wide cell may contain 0."""
    cell = Cell(Fraction(1), Fraction(2), False, {})
    big, small = Axis(form(cell, 1, power, 40), form(cell, 0)), axis(cell, 1, 1)
    assert excludes_zero([[big]]) == excludes_zero([[big, small]]) == (True, True)
    assert cell.power(power).sign() == 0 and not excludes_zero([[axis(cell, 1 << 40, 0), big]])[0]
    one, other = [axis(cell, 1, 0)], [Axis(form(cell, 1, 4), form(cell, 0))]
    assert excludes_zero([one, other]) == (True, True) and excludes_zero([other, one]) == (False, True)


@pytest.mark.parametrize(
    ("a", "b", "given", "least"),
    [
        (1.0, 0.0, [[(0.5, 9.0)]], 1.0),
        (2.0, 3.0, [[(1.0, 1.0), (0.5, 0.0), (0.0, -0.5)]], 0.5),
        (-2.0, -3.0, [[(1.0, 1.0), (0.5, 0.0), (0.0, -0.5)], [(0.25, 0.0)]], 0.5),
        (1.0, 1.0, [[(0.25, 0.25), (1.0, 0.0)], [(8.0, 0.0)]], -1.0),
        (1.0, 1.0, [[(-0.25, -0.25), (0.0, 1.0), (0.0, -0.5)]], -2.0),
        (1.0, 1.0, [[(0.25, 0.25)], [(-0.25, -0.25)]], -1.0),  # on both sides, or at 0: no number
        (1.0, 1.0, [[(0.5, -0.5)]], -1.0),
        (1.0, 0.0, [[(0.5, 0.0)], [(0.0, 0.5)]], -1.0),
        (-1.0, 0.0, [[(0.5, 0.0)], [(0.0, 0.5)]], -1.0),
    ],
)
def test_the_share_that_is_left_of_a_centre(
    a: float, b: float, given: list[list[tuple[float, float]]], least: float
) -> None:
    assert forms._clearance(a, b, given) == least


SIGNED: dict[str, tuple[Pair, list[list[Pair]], bool]] = {
    "what is left is 1": ((2, 3), [[(4, 1), (2, 1), (1, -1), (1, 0)]], True),
    "nothing is left": ((2, 3), [[(4, 1), (2, 1), (2, 0)]], False),
    "less than nothing": ((2, 3), [[(4, 1), (9, 9)]], False),
    "negative": ((2, 3), [[(-4, -1), (2, 1), (1, -1), (1, 0)]], True),
    "negative, nothing is left": ((2, 3), [[(-4, -1), (2, 1), (-2, 0)]], False),
    "negative, less than nothing": ((2, 3), [[(-4, -1), (9, 9)]], False),
    "a centre at 0": ((2, 3), [[(3, -2)]], False),
    "two": ((1, 1), [[(4, 1), (2, 2)], [(1, 1)]], True),
    "two on the other side": ((1, 1), [[(-4, -1), (2, 2)], [(-1, -1)]], True),
    "the second does not": ((1, 1), [[(4, 1), (2, 2)], [(1, 1), (1, 1)]], False),
    "one on each side": ((1, 1), [[(4, 1)], [(-1, -1)]], False),
}


@pytest.mark.parametrize("case", SIGNED)
@pytest.mark.parametrize("m", [0, 1])
def test_a_functional_of_one_sign(case: str, m: int) -> None:
    (a, b), given, said = SIGNED[case]
    plane = [[(form(WIDE, p, m), form(WIDE, q, m)) for p, q in z] for z in given]
    assert forms._separates(form(WIDE, a), form(WIDE, b), plane, None) is said


@pytest.mark.parametrize(("r", "own_left_out", "all_asked"), [(0, True, True), (4, True, False), (8, False, False)])
def test_an_edge_is_left_out_of_its_own_normal_and_of_no_other(r: int, own_left_out: bool, all_asked: bool) -> None:
    """(−q, p)·(p, q) is 0 for numbers, but not for forms, that know p and q to ± r only: 0 ± 2 r (16 + r)."""
    edge = form(WIDE, 8, r=r), form(WIDE, 8, r=r)
    plane = [[(form(WIDE, 9), form(WIDE, -9)), edge]]
    assert forms._separates(-edge[1], edge[0], plane, edge) is own_left_out  # −144 ± 18 r
    assert forms._separates(-edge[1], edge[0], plane, None) is all_asked


@pytest.mark.parametrize(
    ("given", "below"),
    [
        ((0, 9, [2, -3], 1, 2), lambda f: -f),  # > 0 everywhere: its negative
        ((1, -9, [2, -3], 1, 2), lambda f: -f),  # so is −9 ζ
        ((0, -9, [2, -3], 1, 2), lambda f: f),
        ((1, 9, [2, -3], 1, 2), lambda f: f),
        ((0, 1, [2, -3], -4, 5), (0, [0, 0], 0, 15)),  # |f| ≤ 1 + 2 + 3 + 4 + 5
        ((1, -1, [2, -3], -4, 5), (0, [0, 0], 0, 15)),
        ((0, 1, [1, 0], 0, 0), (0, [0, 0], 0, 2)),
    ],
)
def test_what_lies_below_the_modulus(
    given: tuple[int, int, list[int], int, int], below: Callable[[Form], Form] | tuple[Any, ...]
) -> None:
    cell = Cell(Fraction(1), Fraction(4), False, {("plant", "inertia"): (Fraction(0), Fraction(1))})
    m, c, l, q, r = given  # noqa: E741
    f = Form(cell, m, 7, c, l, q, r)
    assert fields(forms._below(f)) == (fields(below(f)) if callable(below) else (m, 7, *below))
