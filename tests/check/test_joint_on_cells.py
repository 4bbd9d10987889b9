"""The joint on a cell: what it is made of, over the nominal's `locked`, behind the hold, with a table and an edge."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import pytest

from robimp.synthesis.check.enclosure.cells import Cell
from robimp.synthesis.check.enclosure.forms import Axis, Form, UnresolvedError
from robimp.synthesis.check.enclosure.joint import PLACE, VariedJoint, View, _table, filtered, square_on
from robimp.synthesis.check.joint import Joint, Point
from robimp.synthesis.check.polynomials import ONE, ZERO, Poly, X, norm2, on_axis
from robimp.synthesis.check.positivity import Inequality

F = Fraction
Json = dict[str, Any]
THREE = F(9), F(9), False  # ω = 3
FAR = F(1, 9), F(1, 9), True  # ω = 3, too
AT_ZERO, AT_INFINITY = (F(0), F(1, 64), False), (F(0), F(0), True)
HOLD = Poly.of(F(1, 2), F(-1, 50))  # in place of the hold: then all is rational
SERIES: Json = {
    "type": "series-elastic",
    "motor_inertia": F(1, 100),
    "motor_damping": F(1, 20),
    "spring_stiffness": F(24, 5),
    "torque_loop": {"kp": F(10), "kd": F(1, 4), "derivative_corner": F(1000), "feedforward": F(1)},
}
BOX = {"inertia": (F(1, 50), F(1, 25)), "damping": (F(1, 10), F(3, 10)), "stiffness": (F(0), F(2))}
WEIGHT = {"numerator": [F(1, 20), F(1, 50)], "denominator": [F(1), F(1, 100)]}
TABLE: Json = {"points": [[F(1), F(1, 10)], [F(3), F(1, 5)], [F(7), F(4, 5)]]}
GIVEN = {"numerator": (F(2000),), "denominator": (F(2500), F(283, 4), F(1))}
INERTIA, DAMPING, MOTOR = ("impedance", "inertia"), ("impedance", "damping"), ("actuator", "motor_inertia")
FIRST, GAIN = ("denominator", 1), ("numerator", 0)
EACH = "D_i", "E_i", "U_n", "command", "rest", "driven", "locked", "M", "E"


def spec(actuator: Json = SERIES, sampling: Json | None = None, impedance: Json | None = None, **given: Any) -> Json:
    return {
        "plant": {"inertia": F(3, 100), "damping": F(1, 5), "stiffness": F(1)},
        "sampling": sampling,
        "uncertainty": dict.fromkeys(("box", "weight", "table", "actuator")) | given,
        "actuator": actuator,
        "impedance": {"inertia": F(3, 100), "damping": F(7, 20), "stiffness": F(5, 4)} | (impedance or {}),
        "controller": {"filters": {"force": F(500), "position": F(400), "derivative": F(2000)}},
    }


def cell_of(ends: tuple[F, F, bool], symbols: int = 0, hold: bool = False) -> Cell:
    cell = Cell(*ends, {("numerator", k): (F(-1), F(1)) for k in range(symbols)})
    if hold:
        cell.cache["hold"] = cell.axis(HOLD)
    return cell


def varied(given: Json, point: Point | None = None, symbols: Point | None = None) -> VariedJoint:
    """The joint at a point, its symbols 0 there, and where one of them is 1."""
    point, controller = point or {}, filtered("dob", GIVEN)
    j = VariedJoint(given, controller, point)
    j.others = [VariedJoint(given, controller, point | {key: high}) for key, high in (symbols or {}).items()]
    return j


def is_at(f: Form | Poly, true: float, *t: int, slack: float = 1e-12) -> None:
    """Where t_0 = 1, so that χ = hi, and the other symbols are t, a form contains the value, and not much else."""
    if isinstance(f, Poly):
        assert true == round(true) and f == Poly.of(round(true))
        return
    scale = F(2) ** f.e * (-f.cell.hi / F(2) ** f.cell.b) ** f.m
    middle = scale * (f.c + sum(a * b for a, b in zip(f.l, (1, *t), strict=True)) + f.q)
    assert abs(middle - F(true)) <= abs(scale * f.r) + abs(F(true)) / 10**12
    assert abs(scale) * (f.r + abs(f.q)) <= slack * (1 + abs(true))


def at(p: Poly, x: F) -> F:
    return sum((F(a, p.d) * x**k for k, a in enumerate(p.c)), F(0))


def quotient(p: Poly, q: Poly, x: F) -> tuple[float, float]:
    """Re and Im/ω of p/q at x = ω²."""
    a, b = on_axis(p, q)
    return float(at(a, x) / at(norm2(q), x)), float(at(b, x) / at(norm2(q), x))


def parts(j: Joint, name: str) -> tuple[Poly, Poly]:
    """A quantity of the joint, as summands without and with the hold."""
    whole = {"rest": (ZERO, j.rest), "driven": (ZERO, j.driven), "M": (j.carried, j.driven), "locked": (j.E, j.rest)}
    return whole[name] if name in whole else (getattr(j, name), ZERO)


FAMILIES: dict[str, tuple[Json, Point, Point]] = {
    "the nominal": ({}, {}, {}),
    "another joint": ({}, {INERTIA: F(1, 10), MOTOR: F(1, 80)}, {}),
    "coefficients": ({}, {}, {FIRST: F(1, 5), GAIN: F(1, 5)}),
    "coefficients of another joint": ({}, {DAMPING: F(1, 10), MOTOR: F(1, 80)}, {GAIN: F(1, 5), FIRST: F(1, 5)}),
    "an ideal actuator": ({"actuator": {"type": "ideal"}}, {INERTIA: F(1, 10)}, {GAIN: F(1, 5)}),
}


@pytest.mark.parametrize("ends", [THREE, FAR], ids=["s", "1/s"])
@pytest.mark.parametrize("sampling", [None, {"rate": F(1000), "delay": F(1, 500)}], ids=["", "hold"])
@pytest.mark.parametrize("family", FAMILIES)
def test_a_view_is_the_joint_over_the_nominals_denominator(
    family: str, sampling: Json | None, ends: tuple[F, F, bool]
) -> None:
    changes, point, symbols = FAMILIES[family]
    given = spec(sampling=sampling, **changes)
    j, nominal, H = varied(given, point, symbols), varied(given), HOLD if sampling else ONE
    view = View(j, nominal, cell_of(ends, len(symbols), bool(sampling)))
    for name in EACH:
        first, *others = ((A + B * H) for A, B in (parts(o, name) for o in (j, *j.others)))
        for t in [(0,) * len(symbols), *((n * (k == m) for m in symbols) for k in symbols for n in (1, -1))]:
            t = tuple(t)
            true = sum((Poly.of(n) * (other - first) for n, other in zip(t, others, strict=True)), first)
            found = getattr(view, name)
            both = found.parts() if isinstance(found, Axis) else (found, ZERO)
            for form, value in zip(both, quotient(true, nominal.E + nominal.rest * H, F(9)), strict=True):
                is_at(form, value, *t)
    assert (view.spec, view.corners, view.disc) == (given, j.corners, j.disc)


def test_on_a_cell_nothing_is_enclosed_twice(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a joint with another impedance only what depends on it; what is zero needs no form."""
    asked: list[tuple[tuple[Poly, Poly], ...]] = []
    enclose = VariedJoint.enclose

    def counted(self: VariedJoint, cell: Cell, *pairs: tuple[Poly, Poly]) -> Axis:
        asked.append(pairs)
        return enclose(self, cell, *pairs)

    monkeypatch.setattr(VariedJoint, "enclose", counted)
    nominal, cell = varied(spec()), cell_of(THREE)
    for point, new in (({}, 8), ({}, 0), ({INERTIA: F(1, 10)}, 2), ({MOTOR: F(1, 80)}, 3)):
        asked.clear()
        j = varied(spec(), point)
        View(j, nominal, cell)
        assert len(asked) == new
        assert all(any(map(any, pairs)) for pairs in asked)
    assert asked[0] == ((j.command, ZERO),)


def test_the_hold_of_a_cell_is_found_once(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[tuple[F, F]] = []

    def hold(cell: Cell, rate: F, delay: F) -> Axis:
        asked.append((rate, delay))
        return cell.axis(HOLD)

    monkeypatch.setattr(Cell, "hold", hold)
    j, cell = varied(spec(sampling={"rate": F(1000), "delay": F(1, 500)})), cell_of(THREE)
    for pair in ((j.E, j.rest), (ZERO, j.driven), (j.E, ZERO)):
        for form, value in zip(
            j.enclose(cell, pair).parts(), quotient(pair[0] + pair[1] * HOLD, ONE, F(9)), strict=True
        ):
            is_at(form, value)
    assert asked == [(F(1000), F(1, 500))]


@pytest.mark.parametrize("kind", ["dob", "dynamic-feedback"])
def test_coefficients_are_changed_in_proportion(kind: str) -> None:
    """In Q = n/d of a disturbance observer, C = n/(d − n) follows; other parameters may change, too."""
    n, d = (F(2200),), (F(2500), F(283, 5), F(1))
    changed = {"type": kind, "C": {"numerator": n, "denominator": (d[0] - n[0], *d[1:]) if kind == "dob" else d}}
    twice = {"type": kind, "Q": GIVEN, "C": {"numerator": (F(8000),), "denominator": (F(2000), F(283), F(4))}}
    for point in ({}, {MOTOR: F(1, 80)}):
        changes: Point = point | {GAIN: F(1, 10), FIRST: F(-1, 5)}
        assert same(VariedJoint(spec(), filtered(kind, GIVEN), changes), Joint(spec(), changed, point))
        assert same(VariedJoint(spec(), twice, point), Joint(spec(), twice, point))  # C as given, up to a factor


def same(j: Joint, other: Joint) -> bool:
    return all(parts(j, name) == parts(other, name) for name in EACH)


def test_the_controller_that_coefficients_make() -> None:
    Q: Json = {"numerator": [F(2), F(0)], "denominator": [F(5), F(3), F(1)]}
    C = {"numerator": [F(2), F(0)], "denominator": [F(3), F(3), F(1)]}
    assert filtered("dob", Q) == {"type": "dob", "Q": Q, "C": C}
    assert filtered("dynamic-feedback", C) == {"type": "dynamic-feedback", "C": C}


def test_a_place_on_the_edge_of_the_box_is_a_load() -> None:
    """v = B_lo ω, from (I_hi, K_lo) to (I_lo, K_hi)."""
    assert varied(spec(box=BOX)).place == varied(spec()).place == []
    for t in (F(0), F(1, 3), F(1)):
        load = Poly.of(2 * t, F(1, 10), F(1, 25) - t * F(1, 50))
        assert varied(spec(box=BOX), {PLACE: t}).place == [load]


@pytest.mark.parametrize(
    ("omega", "W"),
    [("0", ".1"), ("1/2", ".1"), ("1", ".1"), ("2", ".15"), ("3", ".2"), ("4", ".35"), ("7", ".8"), ("9", ".8")],
)
def test_the_table_is_linear_between_its_points_and_constant_beyond(omega: str, W: str) -> None:
    x, here = F(omega) ** 2, F(W)
    is_at(_table(TABLE["points"], Cell(x, x, False, {})), float(here))
    is_at(_table([[F(3), here]], Cell(x, x, False, {})), float(here))
    if x:
        is_at(_table(TABLE["points"], Cell(1 / x, 1 / x, True, {})), 0.8)  # it begins behind the last point
        to = Cell(x, x * (1 + F(1, 10**6)), False, {})
        slope = 0 if x < 1 or x >= 49 else 0.05 if x < 9 else 0.15
        is_at(
            _table(TABLE["points"], to), float(here) + slope * float(F(omega)) * (math.sqrt(1 + 1e-6) - 1), slack=1e-9
        )


@pytest.mark.parametrize(("ends", "x"), [(THREE, F(9)), (FAR, F(9)), ((F(10**6), F(10**6), False), F(10**6))])
@pytest.mark.parametrize("weight", [None, WEIGHT])
def test_the_disc_together_with_the_table(weight: Json | None, ends: tuple[F, F, bool], x: F) -> None:
    cell = cell_of(ends)
    alone = varied(spec(weight=weight))
    assert alone.disc_on(cell) == alone.disc
    W = math.sqrt(at(alone.disc[0], x) / at(alone.disc[1], x))
    table = 0.8 if ends != THREE else 0.2
    for given, beside in ((alone, 0.0), (varied(spec(weight=weight, table=TABLE)), table)):
        V2, one = given.disc_on(cell)
        V = (1 + W) * (1 + beside) - 1
        is_at(square_on(cell, V2, one), V * V)
        assert beside == 0 or one is ONE


def test_a_quotient_is_finite_at_an_end() -> None:
    is_at(square_on(cell_of((F(0), F(0), False)), X * Poly.of(3, 1), X * Poly.of(4)), 0.75)
    is_at(square_on(cell_of(AT_INFINITY), X * Poly.of(1, 3), X * Poly.of(1, 4)), 0.75)
    is_at(square_on(cell_of(AT_INFINITY), Poly.of(1, 3), X * Poly.of(1, 4)), 0)
    with pytest.raises(UnresolvedError):
        square_on(cell_of(AT_INFINITY), X * X, X)


def test_three_roots_are_compared_as_they_are() -> None:
    w, a, b, c, size = (Poly.of(k, 1) for k in (2, 3, 5, 7, 11))
    found = list(View.weighed(None, w, a, b, c, size))  # type: ignore[arg-type]
    assert found == [Inequality([w * a, w * b, w * c], c * size)]


WITNESS = Poly.of(3, F(1, 5), F(3, 100))  # of the nominal's inertia: far up |ĝ−g|²/|g|² is 4/(I² x²)
RANGED = {"stiffness": (F(1), F(3, 2))}
BEYOND = F(10**6), F(10**6), False
BOTH: dict[str, tuple[tuple[F, F, bool], Point, Json, F, Poly | None, str]] = {
    "corners": (THREE, {}, {}, F(1, 4), None, "rrrr"),
    "far": (FAR, {}, {}, F(1, 4), None, "rrrr"),
    "one load": (THREE, {PLACE: F(1, 3)}, {}, F(1, 4), WITNESS, "r"),
    "one load, far up": (BEYOND, {}, {}, F(1, 4), WITNESS, "r"),
    "two moduli along the edge": (THREE, {PLACE: F(1, 3)}, {}, F(0), None, "rrrr3"),
    "three, and other parameters": (THREE, {PLACE: F(1, 3)}, RANGED, F(1, 4), None, "rrrr3"),
    "three": (THREE, {PLACE: F(1, 3)}, {}, F(1, 4), None, "rrrr2"),
    "three, far": (FAR, {PLACE: F(1, 3)}, {}, F(1, 4), None, "rrrr2"),
    "no stiffness, at ω = 0": (AT_ZERO, {PLACE: F(1, 3)}, {}, F(1, 4), None, "2r2r2"),
    "no stiffness, two moduli": (AT_ZERO, {PLACE: F(1, 3)}, {}, F(0), None, "3r3r3"),
}


@pytest.mark.parametrize("case", BOTH)
def test_a_box_and_a_disc_together(case: str) -> None:
    """`|p| + W|a| < |b|`, 1 + W = (1 + W_b)(1 + V): with W at a load, and polynomials along the edge.

    r: `p² , W² a² < b²`; 3: times |g|; 2: over |b|, the first two in one."""
    ends, point, impedance, p2, load, kinds = BOTH[case]
    given, cell = spec(box=BOX, weight=WEIGHT, impedance=impedance), cell_of(ends)
    j = varied(given, point)
    view, x = View(j, varied(given), cell), 1 / ends[1] if ends[2] else ends[1]
    a, b, p = math.sqrt(2), 3.0, math.sqrt(p2)
    found = list(view.both(cell.form(2), cell.form(9), cell.form(p2) if p2 else ZERO, load))
    V, slack = math.sqrt(at(j.disc[0], x) / at(j.disc[1], x)), 1e-12 if ends[0] else 0.05
    assert len(found) == len(kinds)
    for kind, part, g in zip(kinds, found, [load] if load else [*j.corners, *j.place], strict=True):
        gap, size = (math.sqrt(at(norm2(z), x)) for z in (j.nominal - g, g))
        W = (1 + gap / size) * (1 + V) - 1
        true = {
            "r": (p, W * a, b),
            "3": (p * size, V * a * size, (V + 1) * a * gap, b * size),
            "2": ((p + V * a) / b * size, (V + 1) * a / b * gap, size),
        }[kind]
        assert part.strict and len(part.terms) == len(true) - 1
        for form, root in zip([*part.terms, part.bound], true, strict=True):
            is_at(cell.real(form), root * root, slack=slack)
