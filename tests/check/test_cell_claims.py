"""What a claim on cells is taken to be: which way it goes, over which parameters, of which degree, at which ends."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from functools import partial
from math import inf
from time import monotonic
from typing import Any

import pytest
from certificate_builder import data, seal, spec
from claim_floats import Json

from robimp.synthesis.check.enclosure import claims
from robimp.synthesis.check.enclosure.cells import Cell, roots
from robimp.synthesis.check.enclosure.claims import CellProver
from robimp.synthesis.check.enclosure.joint import PLACE, VariedJoint
from robimp.synthesis.check.joint import Joint
from robimp.synthesis.check.polynomials import ZERO, Poly
from robimp.synthesis.check.proofs import Prover
from robimp.synthesis.check.reader import read

WHOLE, NONE = (Fraction(0), inf), Fraction(0)
PLANT: Json = {"inertia": "3/100", "damping": "1/5", "stiffness": "1"}
BOX: Json = {"inertia": ["1/50", "1/25"], "damping": ["1/10", "3/10"], "stiffness": ["1/2", "3/2"]}
WEIGHT: Json = {"numerator": ["1/20", "0"], "denominator": ["1", "100"]}
TABLE: Json = {"points": [["10", "1/10"], ["100", "1/5"]], "beyond": "hold"}
NOTHING: Json = {"eq9": None, "eq12": None, "eq18": None, "peak": None, "friction": "report"}
SAMPLING: Json = {"rate": "1000", "delay": "0"}
STIFFNESS, SPRING = ("impedance", "stiffness"), ("actuator", "spring_stiffness")


def certificate(gain: str = "2", ideal: bool = True, **changes: Any) -> Any:
    """A constant gain C: with an ideal actuator and without a hold `Z = m + (g − ĝ)/(1 + C)`, `1 − Q̃ = 1/(1 + C)`."""
    changes = {"plant": PLANT, "impedance": {"inertia": "1/50", "damping": "1/5", "stiffness": "1/2"}} | changes
    s = spec(**changes, **({"actuator": {"type": "ideal"}} if ideal else {}))
    s["constraints"] = NOTHING | changes.get("constraints", {})
    s["controller"]["type"] = "dynamic-feedback"
    body: Json = {"robimp_certificate": 1, "claims": [], "assumptions": [], "not_claimed": [], "producer": {}}
    body |= {"spec": s, "controller": {"type": "dynamic-feedback", "C": {"numerator": [gain], "denominator": ["1"]}}}
    body["bandwidth"] = {"proven": "10", "refuted_at": None, "bound": None}
    return read(data(seal(body)))


def prover(gain: str = "2", **changes: Any) -> CellProver:
    return CellProver(certificate(gain, **changes), monotonic() + 20)


def noting(asked: list[Any], answer: Any) -> Callable[..., Any]:
    """A function that writes down what it was asked, and answers this."""

    def note(*given: Any) -> Any:
        asked.append(given)
        return answer

    return note


def uncertain(box: Json = None, **more: Any) -> Json:
    return {"box": {key: [v, v] for key, v in PLANT.items()} | (box or {}), **more}


PARTS = "E", "M", "rest", "driven", "carried", "command", "E_i", "D_i", "U_n", "load", "desired"


def parts(j: Joint) -> list[Poly]:
    return [getattr(j, name) for name in PARTS]


# Joints, and the stores


def test_a_joint_is_in_the_middle_of_its_symbols_and_has_one_other_for_each_at_its_upper_end() -> None:
    given = prover()
    point = {("plant", "damping"): Fraction(3)}
    symbols = {STIFFNESS: (Fraction(1), Fraction(4)), ("numerator", 0): (Fraction(0), Fraction(1, 2))}
    middle: Any = {**point, STIFFNESS: Fraction(5, 2), ("numerator", 0): Fraction(1, 4)}
    joint = given.joint(point, symbols)
    make = partial(VariedJoint, given.spec, given.certificate["controller"])
    assert parts(joint) == parts(make(middle))
    ends = [middle | {STIFFNESS: Fraction(4)}, middle | {("numerator", 0): Fraction(1, 2)}]
    assert [parts(other) for other in joint.others] == [parts(make(end)) for end in ends]
    assert parts(given.joint(point)) == parts(make(point)) != parts(joint) and not given.joint(point).others


def test_joints_are_kept_for_the_next_claim_but_not_too_many(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(claims, "VIEWS", 3)
    given, places = prover(), [{STIFFNESS: Fraction(k)} for k in range(1, 9)]
    first = given.joint(places[0])
    assert given.joint(places[1]) is not first and given.joint(places[0]) is first
    for place in places:
        assert given.joint(place).desired.c[0] == place[STIFFNESS] * given.joint(place).desired.d
        assert given.joint(place) is given.joint(place) and len(given.joints) <= 3
    many = {("plant", key): (Fraction(1), Fraction(3)) for key in ("inertia", "damping", "stiffness")}
    symbols = many | {STIFFNESS: (Fraction(1), Fraction(3))}
    assert len(given.joint({}, symbols).others) == 4  # more than are kept


def test_views_are_kept_for_the_next_claim_but_not_too_many(monkeypatch: pytest.MonkeyPatch) -> None:
    """An equal cell is the one that has been there before, with what is known on it."""
    monkeypatch.setattr(claims, "VIEWS", 3)
    given, places = prover(), [{STIFFNESS: Fraction(k)} for k in range(1, 9)]
    ends = Fraction(1), Fraction(4), False, {("numerator", 0): (Fraction(-1, 4), Fraction(1, 2))}
    cell = Cell(*ends)
    view = given.view(cell, places[0])
    assert parts(view)[-2:] == parts(given.joint(places[0], cell.ranges))[-2:] and view.others and view.cell is cell
    assert given.view(Cell(*ends), places[0]) is view and given.view(Cell(*ends), places[1]).cell is cell
    assert given.view(Cell(Fraction(4), Fraction(16), False, {}), places[0]).cell is not cell
    most, emptied = 0, 0
    for place in places:
        cell.cache["mark"] = ZERO
        assert given.view(cell, place).desired == given.joint(place).desired
        most, emptied = max(most, len(given.views)), emptied + ("mark" not in cell.cache)
    assert most <= 4 and emptied


# Which way a claim goes

WITNESS: Json = {"load": {"inertia": Fraction(1), "damping": Fraction(2), "stiffness": Fraction(3)}}
WITNESS["impedance"] = {"stiffness": Fraction(5)}
AT = {**{("plant", key): v for key, v in WITNESS["load"].items()}, STIFFNESS: Fraction(5)}
LOAD = Poly.of(3, 2, 1)
HALF, BAND = Fraction(1, 2), (Fraction(1), Fraction(2))
WAYS: list[tuple[tuple[str, str], Json, tuple[Any, ...]]] = [
    (("tolerance", "coefficients"), None, ("_tolerance", HALF)),
    (("tolerance", "coefficients"), WITNESS, ("_perturbed", WITNESS)),
    (("stability-free", "box"), None, ("_box", "stability-free", HALF, {})),
    (("stability-locked", "box"), None, ("_box", "stability-locked", HALF, {})),
    (("stability-free", "box"), WITNESS, ("_unstable", "stability-free", HALF, AT)),
    (("stability-locked", "winding"), None, ("_unstable", "stability-locked", HALF, {})),
    (("peak", "sensitivity"), None, ("_on_cells", ("peak", "sensitivity"), HALF, BAND, True, None, {}, {})),
    (("peak", "sensitivity"), WITNESS, ("_on_cells", ("peak", "sensitivity"), HALF, BAND, True, LOAD, AT, {})),
]


@pytest.mark.parametrize(("kind", "witness", "way"), WAYS)
def test_what_polynomials_do_not_decide_goes_its_way(
    kind: tuple[str, str], witness: Json, way: tuple[Any, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    given = prover(sampling=SAMPLING)
    for name in ("_tolerance", "_perturbed", "_box", "_unstable", "_on_cells"):
        monkeypatch.setattr(CellProver, name, lambda _, *said, name=name: (name, *said))
    assert given.fault(kind, HALF, BAND, True, witness) == way  # type: ignore[comparison-overlap]


def test_what_polynomials_decide_stays_as_they_say() -> None:
    given = prover(uncertainty={"box": BOX, "weight": None})
    exact = Prover(certificate(uncertainty={"box": BOX, "weight": None}), monotonic() + 20)
    for kind, v, holds in (
        (("peak", "sensitivity"), "1/2", True), (("peak", "sensitivity"), "1/4", False),
        (("stability-free", "hurwitz"), "1/2", True), (("stability-free", "hurwitz"), "50", False),
        (("eq12", "structured"), "1/10", True), (("eq12", "structured"), "1/5", False),
    ):  # fmt: skip
        said = given.fault(kind, Fraction(v), WHOLE, True)
        assert said == exact.fault(kind, Fraction(v), WHOLE, True) and (said == "") == holds
    assert not given.views


# Over what, and of which degree

IMPEDANCE, ACTUATOR, BOTH = (STIFFNESS,), (SPRING,), (STIFFNESS, SPRING)
FAMILIES: dict[tuple[str, str], tuple[tuple[Any, ...], int, int]] = {  # parameters; degree for a box, and with a disc
    ("bandwidth", "attenuation"): (ACTUATOR, 2, 2),
    ("peak", "sensitivity"): (ACTUATOR, 2, 2),
    ("noise", "command"): (ACTUATOR, 2, 2),
    ("rendering", "every-load"): (BOTH, 2, 4),
    ("friction", "strictly-positive-real"): (BOTH, 2, 4),
    ("eq9", "printed"): ((STIFFNESS, PLACE), 2, 4),
    ("eq12", "paper"): (IMPEDANCE, 4, 4),
    ("eq12", "disc"): (BOTH, 4, 4),
    ("eq12", "structured"): (BOTH, 2, 4),
    **{("eq18", f"{form}/{c}"): ((*BOTH, PLACE), 4, 4) for form in ("paper", "lumped") for c in ("frozen", "physical")},
    **{("eq18", f"half-plane/{c}"): ((*BOTH, PLACE), 2, 4) for c in ("frozen", "physical")},
}
RANGED: Json = {"inertia": "1/50", "damping": "1/5", "stiffness": ["1/2", "1"]}
MOTOR: Json = {"actuator": {"spring_stiffness": ["4", "6"]}}
VALUES = {
    STIFFNESS: (Fraction(1, 2), Fraction(1)),
    SPRING: (Fraction(4), Fraction(6)),
    PLACE: (Fraction(0), Fraction(1)),
}


LOADED: Json = uncertain({"stiffness": ["1/2", "3/2"]}, **MOTOR)
NO_EDGE: Json = uncertain({"damping": ["1/10", "3/10"], "stiffness": ["0", "0"]}, **MOTOR)
DISCS: list[Json] = [{"weight": WEIGHT}, {"weight": None, "table": TABLE}]
PLACED: Json = {"load": {key: Fraction(v) for key, v in PLANT.items()}, "impedance": {"stiffness": HALF}}


@pytest.mark.parametrize("kind", FAMILIES, ids=" ".join)
def test_a_statement_is_searched_over_what_it_depends_on_with_its_degree(
    kind: tuple[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A box without stiffness has no edge; what a witness gives does not vary; points of a table are ends of cells."""
    asked: list[Any] = []
    monkeypatch.setattr(claims, "cover", noting(asked, ""))
    every, boxed, squared = FAMILIES[kind]
    inner = tuple(key for key in every if key != PLACE)
    alone = boxed if PLACE in every else squared
    stiff = PLANT | {"stiffness": "0"}
    cases: list[tuple[Json, Json, tuple[Any, ...], int]] = [
        (LOADED | {"weight": None}, None, every, boxed),
        (NO_EDGE | {"weight": None}, None, inner, boxed),
        *((LOADED | disc, None, every, squared) for disc in DISCS),
        *((NO_EDGE | disc, None, inner, alone) for disc in DISCS),
        (LOADED | DISCS[0], PLACED, tuple(key for key in inner if key != STIFFNESS), alone),
    ]
    for uncertainty, witness, family, degree in cases:
        plant = stiff if uncertainty["box"]["stiffness"][1] == "0" else PLANT
        given = prover(ideal=False, sampling=SAMPLING, uncertainty=uncertainty, impedance=RANGED, plant=plant)
        given.fault(kind, HALF, (Fraction(1), Fraction(300)), False, witness)
        cells, _, deadline, box, found = asked.pop()
        assert box == {key: VALUES[key] for key in family} and found == degree and deadline == given.deadline
        breaks = map(Fraction, [10, 100] if uncertainty.get("table") else [])
        assert [c.key for c in cells] == [c.key for c in roots((Fraction(1), Fraction(300)), breaks, {})] and not asked


@pytest.mark.parametrize("name", ["stability-free", "stability-locked"])
def test_a_box_is_searched_over_the_actuator_and_everything_else_is_a_symbol(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of loads, impedances and coefficients no three are multiplied; the actuator's may be, with any two of them."""
    asked: list[Any] = []
    monkeypatch.setattr(claims, "cover", noting(asked, ""))
    monkeypatch.setattr(CellProver, "generators", noting(asked, {}))
    given = prover(ideal=False, uncertainty=LOADED, impedance=RANGED)
    symbols: Any = {("plant", "stiffness"): (NONE, Fraction(2)), STIFFNESS: (Fraction(1, 4), Fraction(5, 4))}
    coefficient = {("numerator", 0): (-HALF, HALF)}
    for v in (Fraction(2), NONE):  # scaled about the nominal; 0: coefficients alone
        given._box(name, v, coefficient)
        _, on, _, motor, degree = asked.pop()
        assert motor == ({SPRING: (Fraction(16, 5), Fraction(36, 5))} if v else {}) and degree == 1
        on(Cell(Fraction(1), Fraction(2), False, {}), {SPRING: Fraction(5)})
        varied = symbols if v and name == "stability-free" else {}
        assert asked.pop() == (given, name, {SPRING: Fraction(5)}, varied | coefficient)


# Tolerance

REQUIRED: Json = {"peak": "2", "eq9": {}, "eq12": {"form": "structured", "band": ["1", "50"], "margin": "0"}}


@pytest.mark.parametrize("kind", ["dynamic-feedback", "dob"])
def test_tolerance_asks_for_every_required_claim_at_its_level_and_nothing_else(
    kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[Any] = []
    wrong: list[Any] = []

    def note(name: str, *said: Any) -> str:
        asked.append((name, *said))
        return " here" if said in wrong else ""

    for name in ("_box", "_on_cells"):
        monkeypatch.setattr(CellProver, name, lambda _, *said, name=name: note(name, *said))
    given = prover(constraints=REQUIRED | {"tolerance": "1/100"}, uncertainty={"box": BOX, "weight": None})
    rational = {"numerator": (Fraction(3), Fraction(0)), "denominator": (Fraction(0), Fraction(2), Fraction(1))}
    other = {"numerator": (Fraction(9),), "denominator": (Fraction(9),)}
    given.certificate["controller"] = {"type": kind, "Q": rational, "C": other if kind == "dob" else rational}
    v = Fraction(1, 50)
    extra = dict.fromkeys([("denominator", 1), ("denominator", 2), ("numerator", 0)], (-v, v))
    assert given.fault(("tolerance", "coefficients"), v, WHOLE, True) == ""
    band = (NONE, Fraction(10))
    assert asked == [
        ("_box", "stability-free", NONE, extra),
        ("_box", "stability-free", Fraction(1), extra),
        ("_box", "stability-locked", NONE, extra),
        *(
            ("_on_cells", claim, level, where, where == WHOLE, None, {}, extra)
            for claim, level, where in (
                (("bandwidth", "attenuation"), NONE, band),
                (("peak", "sensitivity"), Fraction(2), WHOLE),
                (("eq9", "printed"), Fraction(1), WHOLE),
                (("eq12", "structured"), NONE, (Fraction(1), Fraction(50))),
            )
        ),
    ]
    for at, text in ((1, ": stability-free box here"), (4, ": peak sensitivity here")):
        wrong[:] = [asked[at][1:]]
        calls = len(asked)
        assert given.fault(("tolerance", "coefficients"), v, WHOLE, True) == text and len(asked) == calls + at + 1
        del asked[calls:]
