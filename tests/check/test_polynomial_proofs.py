"""What polynomials decide of a claim, what they leave to cells, and how a box of loads is proven without them."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from math import inf
from typing import Any

import pytest
from claim_floats import Json, num
from test_statements import FRICTION, PORT, UNCERTAIN, WHOLE, by_hand, prover, rational, soon

from robimp.synthesis.check.enclosure.claims import CellProver
from robimp.synthesis.check.outcome import UNDECIDED, CheckError
from robimp.synthesis.check.polynomials import ONE, Poly
from robimp.synthesis.check.positivity import Inequality

FREE, LOCKED, BOX, EQ9 = (
    ("stability-free", "hurwitz"),
    ("stability-locked", "hurwitz"),
    ("stability-free", "box"),
    ("eq9", "printed"),
)
STIFF: Json = {"impedance": {"stiffness": ["1", "3/2"]}}
MOTOR: Json = {"uncertainty": {"actuator": {"motor_inertia": ["1/200", "1/50"]}}}
TABLE: Json = {"uncertainty": {"box": None, "table": {"points": [["0", "1/9"], ["9", "1/9"]], "beyond": "hold"}}}
SAMPLED: Json = {"sampling": {"rate": "1000", "delay": "0"}}
AT = Fraction(3), Fraction(3)
LEFT: list[tuple[Json, tuple[str, str], bool]] = [  # a specification, a claim, whether it is left to cells
    ({}, ("peak", "sensitivity"), False),
    (SAMPLED, ("peak", "sensitivity"), True),
    (SAMPLED, FREE, True),
    ({}, ("tolerance", "coefficients"), True),
    (STIFF, EQ9, True),
    (STIFF, ("eq12", "paper"), True),
    (STIFF, ("eq12", "structured"), True),
    (STIFF, ("peak", "sensitivity"), False),
    (MOTOR, ("peak", "sensitivity"), True),
    (MOTOR, ("eq18", "half-plane/frozen"), True),
    (MOTOR, EQ9, False),
    (TABLE, EQ9, True),
    (TABLE, ("peak", "sensitivity"), True),
    (UNCERTAIN["a box of discs"], EQ9, True),
    (UNCERTAIN["a box of discs"], FRICTION, False),
    (UNCERTAIN["a box with a spring"], ("eq18", "lumped/physical"), True),  # a third modulus
]


@pytest.mark.parametrize(("changes", "kind", "left"), LEFT)
def test_what_polynomials_do_not_decide_is_left_to_cells(changes: Json, kind: tuple[str, str], left: bool) -> None:
    assert (prover(**changes).fault(kind, Fraction(1, 100), AT, False) is None) is left


def test_at_a_witness_that_fixes_what_varies_polynomials_decide() -> None:
    p = prover(**STIFF)
    fixed: dict[str, Any] = {"load": None, "impedance": {"stiffness": Fraction(6, 5)}}
    assert p.fault(EQ9, Fraction(1, 100), AT, False, fixed) == ""
    assert p.fault(EQ9, Fraction(100), AT, False, fixed) == " at ω = 3 rad/s"
    assert p.fault(EQ9, Fraction(1, 100), AT, False, {"load": None, "impedance": None}) is None


SLOW = ": a root does not decay at the stated rate"
LAG = ": any lag of the actuator makes it unstable"


@pytest.mark.parametrize(
    ("kind", "gain", "impedance", "rate", "said"),
    [
        (FREE, "1", "1 3 2", "999/1000", ""),  # N(ĝ) = 2 (s + 1)(s + 2)
        (FREE, "1", "1 3 2", "1", SLOW),
        (LOCKED, "2 / 1 1", "1 3 2", "299/100", ""),  # s + 1 + 2
        (LOCKED, "2 / 1 1", "1 3 2", "3", SLOW),
        (LOCKED, "1", "1 3 2", "3", ""),  # no root
        (LOCKED, "-1 5 / 1 1", "1 3 2", "0", LAG),
        (LOCKED, "-99/100 5 / 1 1", "1 3 2", "0", ""),
        (LOCKED, "-3", "1 3 2", "0", LAG),  # −2, no root; with a lag at +2/ε
        (LOCKED, "-3 -3 / 1 1/2", "1 3 2", "0", LAG),  # −2 (s + 5/4)
        (LOCKED, "1 1 1 / 1 1", "1 3 2", "0", ""),  # infinite: s² + 2 s + 2
        (FREE, "1", "0 1 1", "0", LAG),  # 2 s + 2, without the inertia of E g
        (FREE, "-3", "1 3 2", "0", LAG),  # −2 m
        (FREE, "-99/100", "1 3 2", "0", ""),
        (FREE, "1", "1 0 1", "0", SLOW),
    ],
)
def test_the_nominal_decays_at_the_stated_rate(
    kind: tuple[str, str], gain: str, impedance: str, rate: str, said: str
) -> None:
    assert by_hand(gain, "2 2 3", impedance).fault(kind, Fraction(rate), WHOLE, True) == said


LOADS: dict[str, tuple[Json, str | None]] = {  # N(g) = g − ĝ + 2 m for every load of a box
    "the nominal alone": ({"box": "2..2 2..2 3..3"}, ""),
    "all coefficients positive": ({"box": "1..3 1..3 2..4"}, ""),  # from 1 to 3
    "the stiffness as low as 0": ({"box": "1..3 1..3 1..4"}, None),
    "the stiffness negative": ({"box": "1..3 1..3 0..4"}, None),
    "the damping negative": ({"box": "1..3 0..3 2..4", "impedance": "1 1/2 1"}, None),
    "the inertia as low as 0, twice the box": ({"box": "1..3 3/2..5/2 5/2..7/2"}, None),
    "the inertia negative, twice the box": ({"plant": "3 2 3", "box": "1..4 3/2..5/2 5/2..7/2"}, None),
    "nothing at one corner of twice the box": ({"box": "1..3 1..3 2..4"}, None),
    "all coefficients negative": ({"gain": "-1 / -1", "box": "1..3 1..3 2..4"}, ""),
    "another sign than without control": ({"gain": "-2", "box": "3/2..5/2 3/2..5/2 5/2..7/2"}, LAG),  # g − ĝ − m
    "not separated for x < 0": (
        {"gain": "19 / 1 1 1/4", "plant": "2 4 0", "impedance": "4 6 2", "box": "2..3 4..4 0..2"},
        "",
    ),
    "the nominal slow": ({"impedance": "1 1/9 1", "box": "2..2 2..2 3..4"}, ""),
    "the nominal unstable": ({"gain": "1 / 1 -3/2", "box": "2..2 2..2 3..4"}, SLOW),  # (s − 1/2) m
}


@pytest.mark.parametrize("name", LOADS)
def test_every_load_of_a_box_is_stable_if_no_root_can_cross(name: str) -> None:
    joint, said = LOADS[name]
    p = by_hand(**{"gain": "1", "plant": "2 2 3", "impedance": "1 1 1"} | joint)
    assert p.fault(BOX, Fraction(2 if "twice" in name else 1), WHOLE, True) == said


@pytest.mark.parametrize(
    ("name", "changes", "left"),
    [
        ("stability-free", {}, False),
        ("stability-free", STIFF, True),
        ("stability-free", MOTOR, True),
        ("stability-locked", {}, False),
        ("stability-locked", STIFF, False),  # it does not depend on it
        ("stability-locked", MOTOR, True),
    ],
)
def test_a_box_of_more_than_loads_is_left_to_cells(name: str, changes: Json, left: bool) -> None:
    assert prover(**changes).fault((name, "box"), Fraction(1), WHOLE, True) == (None if left else "")


def test_against_a_wall_the_load_is_of_no_matter() -> None:
    p = by_hand("1", "2 2 3", "1 0 1", "1..3 0..3 0..5")
    assert p.fault(("stability-locked", "box"), Fraction(1), WHOLE, True) == ""
    assert p.fault(BOX, Fraction(1), WHOLE, True) == SLOW, "free it is not even damped"


def test_a_witness_of_a_box_is_one_load_whose_joint_is_stable_or_not() -> None:
    p = by_hand("1", "2 2 3", "1 1/2 1", "1..3 0..3 2..4")  # damping from −1 to 2
    for damping, said in ((0, SLOW), (1, SLOW), (Fraction(101, 100), "")):
        witness = {"load": {"inertia": Fraction(2), "damping": Fraction(damping), "stiffness": Fraction(3)}}
        assert p.fault(BOX, Fraction(1), WHOLE, True, witness) == said


def test_on_the_whole_axis_the_port_is_compared_over_its_own_degree() -> None:
    assert prover().fault(PORT, Fraction(-100), WHOLE, True) == ""


def test_what_is_false_is_said_even_if_something_else_is_undecided() -> None:
    three, wrong = Inequality([ONE, ONE, ONE], Poly.of(100)), Inequality([], Poly.of(3, -1))
    p = prover()
    assert p._exactly([three, wrong], (Fraction(1), Fraction(2))) == " at ω = 2 rad/s"
    with pytest.raises(CheckError, match="more than two roots") as stop:
        p._exactly([three, Inequality([], ONE)], WHOLE)
    assert stop.value.code == UNDECIDED


def response(ratio: str, s: complex) -> tuple[complex, complex]:
    """Numerator and denominator."""
    n, d = (list(map(num, part)) for part in rational(ratio).values())
    return sum(a * s**k for k, a in enumerate(reversed(n))), sum(a * s**k for k, a in enumerate(reversed(d)))


def load_at(s: complex, load: Any) -> complex:
    I, B, K = load  # noqa: E741
    return I * s**2 + B * s + K


def values(joint: dict[str, str]) -> tuple[list[float], list[float], list[list[float]]]:
    """Plant, impedance and box in numbers."""
    plant, impedance = (list(map(num, joint[key].split())) for key in ("plant", "impedance"))
    return plant, impedance, [list(map(num, pair.split(".."))) for pair in joint["box"].split()]


def logarithmic(lo: float, hi: float, n: int) -> Iterator[float]:
    return (lo * (hi / lo) ** (k / n) for k in range(n + 1))


EDGES: list[dict[str, str]] = [  # W may be larger on the edge from (I_hi, K_lo) to (I_lo, K_hi) than at its ends
    {"gain": "1", "plant": "10 21/10 10", "impedance": "9 1 12", "box": "10..10 1..3 8..12"},
    {"gain": "1", "plant": "10 2 10", "impedance": "9 1 12", "box": "9..11 1..3 7..14"},
    {"gain": "3", "plant": "10 2 10", "impedance": "4 1 2", "box": "8..11 3/2..4 7..11"},
    {"gain": "5 / 1 2", "plant": "10 4 10", "impedance": "4 1 2", "box": "8..19 3/2..4 7..31"},
    {"gain": "1/2", "plant": "1 2 1", "impedance": "1/10 7 1", "box": "1/2..1 2..3 1/4..5"},
    {"gain": "2", "plant": "1 3 1", "impedance": "2 3 4", "box": "1..4 3..4 1..1"},
    {"gain": "2", "plant": "1 3 1", "impedance": "2 3 4", "box": "1..1 3..4 1/2..3"},
]


def largest_factor(joint: dict[str, str], omegas: Any) -> tuple[float, float]:
    """(9) `v W |U| < |(1 − Q) ĝ + U|` over the loads of the edge and the corners, and over the corners alone."""
    plant, impedance, ((I_lo, I_hi), dampings, (K_lo, K_hi)) = values(joint)
    everywhere, corners = inf, inf
    for s in (1j * omega for omega in omegas):
        (n, d), nominal, m = response(joint["gain"], s), load_at(s, plant), load_at(s, impedance)
        U = n * m - d * (nominal - m)
        for B in dampings:
            for t in (k / 60 for k in range(61)):
                g = load_at(s, (I_hi + t * (I_lo - I_hi), B, K_lo + t * (K_hi - K_lo)))
                if (at := abs(nominal - g) * abs(U)) > 0:
                    v = abs(d * nominal + U) * abs(g) / at
                    everywhere, corners = min(everywhere, v), min(corners, v if t in (0, 1) else inf)
    return everywhere, corners


@pytest.mark.parametrize("joint", EDGES)
@pytest.mark.parametrize("band", [(1, 1), (Fraction(1, 2), 2), (0, Fraction(2, 5)), (3, inf), (0, inf)])
def test_robustness_for_a_box_is_proven_up_to_what_its_worst_load_allows(joint: dict[str, str], band: Any) -> None:
    lo, hi = max(float(band[0]), 1e-4), min(float(band[1]), 1e4)
    inner = logarithmic(max(lo, 0.1), min(hi, 10), 250) if lo < hi else ()
    v, corners = largest_factor(joint, [lo, hi, *inner])
    p, interval = by_hand(**joint), (Fraction(band[0]), band[1] if band[1] == inf else Fraction(band[1]))

    def said(factor: float) -> str | None:
        return p.fault(EQ9, Fraction(factor), interval, False)

    assert said(v * 0.97) == "" and said(v * 1.001) != ""
    assert v > 0.9 * corners or said(corners * 0.95) is None, "where the corners alone hold, cells decide"


def test_what_holds_at_the_corners_only_is_refuted_on_cells() -> None:
    p = by_hand(**EDGES[0])
    v, corners = largest_factor(EDGES[0], [1.0])
    assert v < 0.95 * corners
    for factor, holds in ((v * 0.97, True), ((v + corners) / 2, False)):
        text = CellProver(p.certificate, soon()).fault(EQ9, Fraction(factor), (Fraction(1), Fraction(1)), False)
        assert (text == "") is holds


def test_on_the_edge_the_smallest_whole_numbers_are_positive_too() -> None:
    """|b|²|g|² − |a|²|ĝ − g|² = (1 + x)²|g|² − x|ĝ − g|² is 1 at ω = 0 for K_lo, and 1 x⁴ at infinity for I_lo."""
    p = by_hand("1", "1 3 1", "1/2 1 1/2", "1..2 3..4 1..2")
    assert p.fault(EQ9, Fraction(1), WHOLE, False) == ""


def test_an_edge_that_begins_without_stiffness_is_left_to_cells() -> None:
    """Both sides vanish at ω = 0 for K_lo = 0 = K̂, so that nothing follows from the coefficients there."""
    p = by_hand("1", "10 2 0", "9 1 12", "9..11 1..3 0..14")
    assert p.fault(EQ9, Fraction(1, 1000), WHOLE, False) is None
    assert p.fault(EQ9, Fraction(1, 1000), (Fraction(1, 2), inf), False) == ""


BOXES: list[tuple[str, str, str, str, str]] = [  # what is on −M/E first, as the box is scaled, and where
    ("at ω = 8.6, from the right", "5 23 / 1 9", "3 8 2", "1 3 7", "2..4 7..9 1..3"),
    ("at ω = 51, from the right", "259 / 1 3 -32", "6 5 2", "6 4 4", "5..7 4..6 1..3"),
    ("at ω = 1.8, from the left", "5 35 / 1 -3", "4 2 3", "3 4 7", "3..5 1..3 2..4"),
    ("at ω = 5.5, from the left", "6 5 317 / 1 0 -36", "4 2 2", "1 1 7", "3..5 1..3 2..2"),
    ("at ω = 0.88, from above", "7 9 / 1 -6", "4 6 8", "6 2 5", "3..5 5..7 7..9"),
    ("at ω = 0.52, from below", "2 12 / 1 8", "6 9 3", "8 1 1", "5..7 8..10 2..4"),
    ("at ω = 11.8, from below", "227 / 1 1 -9", "4 8 9", "3 5 4", "3..5 7..9 8..10"),
    ("at 0, from the right", "1 28 / 1 -8", "4 7 9", "2 4 1", "3..5 6..8 8..10"),
    ("at 0, from the left", "7 -3 / 1 7", "9 2 4", "8 8 2", "8..10 1..3 3..5"),
    ("at infinity, from the right", "107 / 1 8 38", "9 3 2", "4 8 6", "8..10 2..4 1..3"),
]


def widest_box(joint: dict[str, str]) -> float:
    """How far the box may be scaled about the nominal until some load of it has a root on the axis."""
    plant, impedance, ((I_lo, I_hi), (B_lo, B_hi), (K_lo, K_hi)) = values(joint)
    I, B, K = plant  # noqa: E741

    def needed(at: float, down: float, up: float) -> float:
        room = down if at < 0 else up
        return abs(at) / room if room else inf

    def scale(omega: float) -> float:
        s, x = 1j * omega, omega**2
        (n, d), nominal, m = response(joint["gain"], s), load_at(s, plant), load_at(s, impedance)
        off = -(n * m - d * (nominal - m)) / d - nominal  # from ĝ to the load that has a root here
        along = needed(off.real, K - K_lo + x * (I_hi - I), K_hi - K + x * (I - I_lo))
        return max(along, needed(off.imag / omega, B - B_lo, B_hi - B) if 1e-4 < omega < 1e4 else 0)

    return min(scale(omega) for omega in [1e-5, *logarithmic(0.1, 100, 1000), 1e5])


@pytest.mark.parametrize("case", BOXES, ids=lambda case: case[0])
def test_a_box_of_loads_is_proven_until_one_of_them_has_a_root_on_the_axis(case: tuple[str, ...]) -> None:
    joint = dict(zip(("gain", "plant", "impedance", "box"), case[1:], strict=True))
    p, widest = by_hand(**joint), widest_box(joint)
    assert [p.fault(BOX, Fraction(widest * by), WHOLE, True) for by in (0.5, 0.96, 1.01, 2)] == ["", "", None, None]
