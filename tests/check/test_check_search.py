"""Parameters by control points: the degrees they rest on, the coefficients, and what halving them decides."""

from __future__ import annotations

import math
import random
from fractions import Fraction
from math import comb, inf
from time import monotonic

import pytest
from certificate_builder import EQ23, data, seal, spec
from certificate_builder import certificate as certificate_of
from claim_floats import Json

from robimp.synthesis.check.enclosure.cells import Cell
from robimp.synthesis.check.enclosure.claims import CellProver
from robimp.synthesis.check.enclosure.joint import PLACE, View
from robimp.synthesis.check.enclosure.search import CONTROL, LEBESGUE, control, cover, levelled
from robimp.synthesis.check.joint import Joint
from robimp.synthesis.check.outcome import CheckError
from robimp.synthesis.check.polynomials import Poly
from robimp.synthesis.check.positivity import Inequality
from robimp.synthesis.check.reader import read
from robimp.synthesis.check.statements import STATEMENTS

WEIGHT = {"numerator": ["1/20", "0"], "denominator": ["1", "100"]}
BOX = {"inertia": ["3/125", "9/250"], "damping": ["3/25", "7/25"], "stiffness": ["1/2", "3/2"]}
SOURCES: dict[str, Json] = {"box": {"box": BOX, "weight": None}, "disc": {"box": None, "weight": WEIGHT}}
KEYS = [
    *(("impedance", key) for key in ("inertia", "damping", "stiffness")),
    *(("actuator", key) for key in ("motor_inertia", "motor_damping", "spring_stiffness")),
    PLACE,
]


def prover_of(uncertainty: Json) -> CellProver:
    plant = {"inertia": "3/100", "damping": "1/5", "stiffness": "1"}
    s = spec(plant=plant, uncertainty=uncertainty, constraints={"eq12": None, "eq9": None, "eq18": None})
    s["controller"]["filters"] = {"force": "500", "position": "400", "derivative": "2000"}
    return CellProver(read(data(seal(certificate_of(spec(), EQ23) | {"spec": s}))), monotonic() + 60)


def value(p: Poly, x: Fraction) -> Fraction:
    return sum((Fraction(a, p.d) * x**k for k, a in enumerate(p.c)), Fraction(0))


def difference(values: list[Fraction], order: int) -> Fraction:
    """Zero for a polynomial of a degree below the order."""
    return sum(((-1) ** (order - k) * comb(order, k) * v for k, v in enumerate(values)), Fraction(0))


@pytest.mark.parametrize("source", SOURCES)
@pytest.mark.parametrize("kind", STATEMENTS, ids=" ".join)
def test_a_statement_has_the_degree_that_the_search_takes_it_to_have(
    kind: tuple[str, str], source: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """2 in every parameter, 4 for the squared margin over a disc, 0 in what a statement is said not to depend on."""
    monkeypatch.setattr(Joint, "weighed", View.weighed)  # as on cells: not squared
    prover, rng = prover_of(SOURCES[source]), random.Random(str(kind))
    statement, sections = STATEMENTS[kind]
    place = {PLACE: Fraction(1, 3)} if source == "box" else {}
    for key in KEYS if source == "box" else KEYS[:-1]:
        start, step = Fraction(rng.randint(1, 9), 3), Fraction(rng.randint(1, 9), 5)
        grid = [prover.joint({**place, key: start + k * step}) for k in range(6)]
        try:
            rows = [[p for part in statement(j, Fraction(5, 4), None) for p in (*part.terms, part.bound)] for j in grid]
        except CheckError:  # a form for a box, or for a disc
            return
        passive = (source == "disc" or kind[1] == "disc") and kind[0] in ("eq12", "friction")
        degree = (4 if passive else 2) if key[0] in sections else 0
        for same in zip(*rows, strict=True):
            values = [value(p, Fraction(7, 3)) for p in same]
            assert difference(values[: degree + 2], degree + 1) == 0, (key, degree)


@pytest.mark.parametrize("degree", [1, 2, 4])
def test_control_points_are_the_bernstein_coefficients(degree: int) -> None:
    cell, rng = Cell(Fraction(1), Fraction(1), False, {}), random.Random(degree)
    c = [[Fraction(rng.randint(-9, 9)) for _ in range(degree + 1)] for _ in range(degree + 1)]

    def basis(k: int, t: Fraction) -> Fraction:
        return comb(degree, k) * t**k * (1 - t) ** (degree - k)

    at = [Fraction(k, degree) for k in range(degree + 1)]
    grid = [
        sum((c[i][k] * basis(i, u) * basis(k, t) for i in range(degree + 1) for k in range(degree + 1)), Fraction(0))
        for u in at
        for t in at
    ]
    found = [form.middle() for form in control([cell.form(v) for v in grid], degree, 2)]
    scale = {1: 1, 2: 4, 4: 36**2}[degree]
    assert [float(f / scale) for f in found] == pytest.approx([float(v) for row in c for v in row], abs=1e-12)


@pytest.mark.parametrize("degree", LEBESGUE)
def test_what_is_unknown_at_the_points_is_bounded_between_them(degree: int) -> None:
    """A polynomial of at most 1 at 0, 1/n, …, 1 is nowhere larger than the Lebesgue constant of these points."""
    at = [Fraction(k, degree) for k in range(degree + 1)]

    def lagrange(k: int, t: Fraction) -> Fraction:
        return math.prod([(t - a) / (at[k] - a) for a in at if a != at[k]], start=Fraction(1))

    largest = max(sum(abs(lagrange(k, Fraction(n, 400))) for k in range(degree + 1)) for n in range(401))
    over, under = LEBESGUE[degree]
    assert largest <= Fraction(over, under * CONTROL[degree][0][0]) <= largest * Fraction(101, 100)


@pytest.mark.parametrize("degree", LEBESGUE)
def test_bounds_of_the_values_bound_the_polynomial(degree: int) -> None:
    """Values known to ±r, at their worst: the smallest coefficient is still below the polynomial everywhere."""
    cell, rng = Cell(Fraction(1), Fraction(1), False, {}), random.Random(degree)
    for _ in range(30):
        values = [Fraction(rng.randint(1, 99)) for _ in range(degree + 1)]
        r = [Fraction(rng.randint(0, 20)) for _ in values]
        worst = [v - x * rng.choice((-1, 1)) for v, x in zip(values, r, strict=True)]
        found = levelled([cell.form(v, r=x) for v, x in zip(values, r, strict=True)], degree, 1)
        low = min(Fraction(f.c - f.w - f.r) * Fraction(2) ** f.e for f in found) / CONTROL[degree][0][0]
        for n in range(41):
            t = Fraction(n, 40) * degree
            at = sum(
                v * math.prod([(t - k) / (i - k) for k in range(degree + 1) if k != i], start=Fraction(1))
                for i, v in enumerate(worst)
            )
            assert low <= at


@pytest.mark.parametrize(("below", "said"), [("0", ""), ("1/1000000000", " at ω = 1 rad/s")])
def test_equality_at_a_corner_of_the_parameters_is_enough_where_it_may_be(below: str, said: str) -> None:
    """k ≥ 0 for k in [0, 1]: what is unknown of the other values is not held against this one."""
    key = ("impedance", "stiffness")

    def parts(_: Cell, at: dict[tuple[str, str], Fraction]) -> list[Inequality]:
        return [Inequality([], Poly.of(at[key] / 7 - Fraction(below)), strict=False)]

    cell, box = Cell(Fraction(1), Fraction(1), False, {}), {key: (Fraction(0), Fraction(1))}
    assert cover([cell], parts, monotonic() + 20, box, 2) == said


@pytest.mark.parametrize("terms", [0, 1, 2, 3])
@pytest.mark.parametrize("gap", [Fraction(1, 1000), Fraction(-1, 1000)])
def test_moduli_of_affine_functions_over_a_box_of_parameters(terms: int, gap: Fraction) -> None:
    """Their sum against the largest value that it has on the box, a little above and a little below."""
    keys = ("impedance", "damping"), ("impedance", "stiffness")
    box = dict.fromkeys(keys, (Fraction(-1), Fraction(1)))
    rows = [(Fraction(k + 2), Fraction(1), Fraction(k)) for k in range(terms)]
    top = sum(a + b + c for a, b, c in rows) if rows else Fraction(0)

    def parts(_: Cell, at: dict[tuple[str, str], Fraction]) -> list[Inequality]:
        u, w = (at[key] for key in keys)
        if not rows:  # (u − w)² + gap > 0: touches inside and at corners
            return [Inequality([], Poly.of((u - w) ** 2 + gap))]
        moduli = [Poly.of((a + b * u + c * w) ** 2) for a, b, c in rows]
        return [Inequality(moduli, Poly.of((top + gap) ** 2))]

    cell = Cell(Fraction(1), Fraction(1), False, {})
    text = cover([cell], parts, monotonic() + 20, box, 4 if terms == 2 else 2)
    assert (text == "") == (gap > 0)


def test_everything_of_a_joint_is_affine_in_every_parameter() -> None:
    prover = prover_of(SOURCES["box"])
    for key in [key for key in KEYS if key != PLACE] + [("plant", "inertia")]:
        three = [prover.joint({key: Fraction(k, 7)}) for k in (1, 2, 3)]
        for name in ("E", "M", "rest", "driven", "carried", "command", "E_i", "D_i", "U_n", "load", "locked"):
            a, b, c = (getattr(j, name) for j in three)
            assert a - b - b + c == Poly.of(0), (key, name)
    assert isinstance(three[0], Joint)


@pytest.mark.parametrize("name", ["stability-free", "stability-locked"])
def test_the_characteristic_function_is_what_its_generators_add_up_to(name: str) -> None:
    """At rational places u of every load, impedance and coefficient; with a third factor something would be missing."""
    prover, rng = prover_of(SOURCES["box"]), random.Random(name)
    place = {("actuator", "motor_inertia"): Fraction(1, 90), ("actuator", "spring_stiffness"): Fraction(5)}
    sections = {"plant": ("inertia", "damping", "stiffness"), "impedance": ("damping", "stiffness")}
    keys: list[tuple[str, object]] = [(section, key) for section, given in sections.items() for key in given]
    keys += [("denominator", 0), ("denominator", 1), ("numerator", 0)]
    ranges = {key: (Fraction(rng.randint(1, 9), 9), Fraction(rng.randint(10, 19), 9)) for key in keys}
    u = {key: Fraction(rng.randint(-9, 9), 9) for key in keys}
    there = {key: (lo + hi) / 2 + u[key] * (hi - lo) / 2 for key, (lo, hi) in ranges.items()}
    found = prover.generators(name, place, ranges)
    for k, part in enumerate(prover.joint(place | there).loop(name)):
        total = sum((pair[k] * Poly.of(math.prod(map(u.get, up))) for up, pair in found.items()), Poly.of(0))  # type: ignore[arg-type]
        assert total == part and part != found[()][k]


def test_a_coefficient_is_multiplied_by_no_other() -> None:
    """Every part of a joint is its value at t = 0 and what each t_k alone changes."""
    prover = prover_of(SOURCES["box"])
    keys = [("denominator", 0), ("denominator", 1), ("numerator", 0)]
    j = prover.joint({}, {key: (Fraction(-1, 5), Fraction(1, 5)) for key in keys})
    all_at_once = prover.joint(dict.fromkeys(keys, Fraction(1, 5)))
    for name in ("E", "rest", "driven", "carried", "command", "E_i", "D_i", "U_n"):
        first, end = getattr(j, name), getattr(all_at_once, name)
        assert sum((getattr(other, name) - first for other in j.others), first) == end != first


def test_a_box_down_to_almost_no_inertia_is_decided_by_halving_what_matters() -> None:
    """Near the widest box the exclusion rests on Im f: halving the motor's damping for ever would not find it."""
    changes: Json = {
        "plant": {"inertia": "231/10000", "damping": "111/1000", "stiffness": "0"},
        "uncertainty": {
            "box": {
                "inertia": ["693/50000", "1617/50000"],
                "damping": ["111/2500", "111/625"],
                "stiffness": ["0", "0"],
            },
            "weight": None,
            "actuator": {"motor_damping": ["201/12500", "469/12500"]},
        },
        "actuator": {
            "type": "series-elastic",
            "motor_inertia": "53/2500",
            "motor_damping": "67/2500",
            "spring_stiffness": "789/100",
            "torque_loop": {"kp": "167/10", "kd": "149/1000", "derivative_corner": "1450", "feedforward": "0"},
        },
        "impedance": {
            "inertia": "231/10000",
            "damping": ["477/1000", "583/1000"],
            "stiffness": ["3231/1000", "2513/500"],
        },
        "controller": {
            "type": "dynamic-feedback",
            "filters": {"force": None, "position": "none", "derivative": "482"},
        },
    }
    controller = {"type": "dynamic-feedback", "C": {"numerator": ["11/2"], "denominator": ["1"]}}
    whole = certificate_of(spec(), EQ23) | {"spec": spec(**changes), "controller": controller}
    prover = CellProver(read(data(seal(whole))), monotonic() + 60)

    def fault(v: str) -> str:
        return prover.fault(("stability-free", "box"), Fraction(v), (Fraction(0), inf), True)

    assert fault("2478/1000") == ""
    with pytest.raises(CheckError):  # an unstable joint is in there
        fault("2600/1000")
