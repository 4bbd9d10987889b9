"""What each claim says, at single frequencies and at 0 and ∞, on joints whose values are known."""

from __future__ import annotations

from fractions import Fraction
from math import inf
from time import monotonic
from typing import Any

import pytest
from certificate_builder import EQ23, data, seal, spec
from claim_floats import Joint, Json, num

from robimp.synthesis.check.enclosure.claims import CellProver
from robimp.synthesis.check.outcome import MISMATCH, CheckError
from robimp.synthesis.check.proofs import Prover
from robimp.synthesis.check.reader import read
from robimp.synthesis.check.statements import STATEMENTS

Kind = tuple[str, str]
KEYS = "inertia", "damping", "stiffness"
NOTHING: Json = {"eq9": None, "eq12": None, "eq18": None, "peak": None, "friction": "report"}
WHOLE = Fraction(0), inf


def prover(shipped: Json = EQ23, **changes: Any) -> Prover:
    """Of a specification without claims."""
    body = {
        "robimp_certificate": 1,
        "spec": spec(constraints=NOTHING, **changes),
        "controller": shipped,
        "bandwidth": {"proven": "1", "refuted_at": None, "bound": None},
        **{key: [] for key in ("claims", "assumptions", "not_claimed")},
        "producer": {"robimp": "test"},
    }
    return Prover(read(data(seal(body))), soon())


def soon() -> float:
    return monotonic() + 20


WEIGHT = {"numerator": ["1/20", "3"], "denominator": ["1", "100"]}
SPRING: Json = {
    "plant": {"inertia": "3/100", "damping": "1/5", "stiffness": "2"},
    "uncertainty": {
        "box": {"inertia": ["3/125", "9/250"], "damping": ["3/25", "7/25"], "stiffness": ["3/2", "5/2"]},
        "weight": None,
    },
}
UNCERTAIN: dict[str, Json] = {
    "a box": {},
    "a box with a spring": SPRING,
    "a disc": {"uncertainty": {"box": None, "weight": WEIGHT}},
    "a box of discs": {"uncertainty": {"weight": WEIGHT}},
    "a box of discs, filtered": {
        "uncertainty": {"weight": WEIGHT},
        "controller": {"filters": {"force": "500", "position": "400", "derivative": "1000"}},
    },
    "a disc, ideal actuator": {"uncertainty": {"box": None, "weight": WEIGHT}, "actuator": {"type": "ideal"}},
}
LOADS = [{"inertia": "29/1000", "damping": "13/100", "stiffness": stiffness} for stiffness in ("0", "9/5")]


@pytest.mark.parametrize("name", UNCERTAIN)
@pytest.mark.parametrize("kind", [kind for kind in STATEMENTS if kind[0] != "bandwidth"], ids=" ".join)
def test_a_statement_holds_up_to_the_margin_of_the_transfer_functions(name: str, kind: Kind) -> None:
    """Evaluated in floats, from the equations: for one load of a box, and for all of it where its corners decide."""
    p, falling = prover(**UNCERTAIN[name]), kind[0] in ("peak", "rendering", "noise")
    box = p.spec["uncertainty"]["box"]
    if kind in {("eq12", "paper"), ("eq12", "disc")} and box and p.spec["uncertainty"]["weight"]:
        with pytest.raises(CheckError, match="for a box or for discs, not for both") as stop:
            p.fault(kind, Fraction(1), (Fraction(1), Fraction(1)), False)
        assert stop.value.code == MISMATCH
        return
    for omega in (Fraction(1, 2), Fraction(3), Fraction(40)):
        at = Joint(spec(constraints=NOTHING, **UNCERTAIN[name]), EQ23, float(omega))
        for load in (LOADS[bool(p.nominal.edge)], None) if box else (None,):
            witness = load and {"load": {key: Fraction(value) for key, value in load.items()}}
            value = at.margin(*kind, load=load and tuple(map(num, load.values())))
            if not 1e-6 < value < 1e6 and kind[1] not in ("disc", "structured"):
                continue  # nothing to be proven
            step = 1e-6 * max(abs(value), 1e-2) * (-1 if falling else 1)
            found = [p.fault(kind, Fraction(v), (omega, omega), False, witness) for v in (value - step, value + step)]
            if None in found:
                assert "edge" in STATEMENTS[kind][1] and (p.nominal.disc[0] or (load is None and p.nominal.edge))
                if load is None and p.nominal.edge:
                    continue  # smaller on the edge
                cells = CellProver(p.certificate, soon())
                found = [
                    cells.fault(kind, Fraction(v), (omega, omega), False, witness) for v in (value - step, value + step)
                ]
            assert [not text for text in found] == [True, False]


def by_hand(gain: str, plant: str, impedance: str, box: str = "", weight: Json = None, **changes: Any) -> Prover:
    """Ideal actuator and C = gain: `Z(g) = m + (g − ĝ)/(1 + gain)`, `N(g) = g − ĝ + (1 + gain) m`. All as I B K."""
    ends = [pair.split("..") for pair in box.split()]
    return prover(
        {"type": "dynamic-feedback", "C": rational(gain)},
        plant=dict(zip(KEYS, plant.split(), strict=True)),
        impedance=dict(zip(KEYS, impedance.split(), strict=True)),
        uncertainty={"box": dict(zip(KEYS, ends, strict=True)) if box else None, "weight": weight},
        **{"actuator": {"type": "ideal"}, "controller": {"type": "dynamic-feedback"}} | changes,
    )


def rational(ratio: str) -> Json:
    """As `1 2 / 3`: (s + 2)/3."""
    numerator, _, denominator = ratio.partition(" / ")
    return {"numerator": numerator.split(), "denominator": (denominator or "1").split()}


ATTAINED: list[tuple[Kind, dict[str, Any], str, str]] = [  # a joint, a value that may be attained, and one just beyond
    (("peak", "sensitivity"), {}, "1/4", "249/1000"),  # 1 − Q = 1/4
    (("noise", "command"), {}, "3/4", "749/1000"),
    (("bandwidth", "attenuation"), {"objective": {"attenuation": "1/4"}}, "9", ""),
    (("bandwidth", "attenuation"), {"objective": {"attenuation": "249/1000"}}, "", "1/9"),
    (("eq12", "structured"), {"box": "2..2 1..3 3..3"}, "3/4", "751/1000"),  # B + (1 − 2)/4
    (("friction", "strictly-positive-real"), {"box": "2..2 1..3 3..3"}, "3", "3001/1000"),  # 4 B + 1 − 2
    (
        ("friction", "strictly-positive-real"),
        {"plant": "2 9/2 3", "box": "2..2 1/2..9 3..3"},
        "",
        "0",
    ),  # 4 B + 1/2 − 9/2
    (("friction", "strictly-positive-real"), {"plant": "2 9/2 3", "box": "2..2 3/5..9 3..3"}, "1/10", "101/1000"),
    (("rendering", "every-load"), {"box": "2..2 2..2 2..8", "plant": "2 2 4", "impedance": "0 0 2"}, "1/2", "499/1000"),
    (("eq9", "printed"), {"plant": "12 12 12", "weight": rational("1 / 2")}, "999/1000", "1"),  # W |4 m − ĝ| < 4 |m|
]


@pytest.mark.parametrize(("kind", "joint", "attained", "beyond"), ATTAINED)
def test_only_robustness_and_friction_at_zero_are_strict(
    kind: Kind, joint: dict[str, Any], attained: str, beyond: str
) -> None:
    p = by_hand(**{"gain": "3", "plant": "2 2 3", "impedance": "1 1 1"} | joint)
    assert not attained or p.fault(kind, Fraction(attained), WHOLE, False) == ""
    assert not beyond or p.fault(kind, Fraction(beyond), WHOLE, False)


RADII: list[tuple[Kind, str, str, bool]] = [
    (("eq12", "paper"), "1/2", "19/10", True),
    (("eq12", "paper"), "1/2", "2", False),
    (("eq12", "paper"), "1/2", "3", False),
    (("eq12", "paper"), "9/10", "1/10", True),
    (("eq12", "paper"), "1", "1/10", False),
    (("eq12", "paper"), "3/2", "1/10", False),
    (("friction", "strictly-positive-real"), "1/2", "1/10", True),
    *((("friction", "strictly-positive-real"), weight, v, False) for weight in ("1", "3/2") for v in ("1/10", "1000")),
    *((("eq12", form), "1/2", "-100", True) for form in ("disc", "structured")),
    *((("eq12", form), w, v, False) for form in ("disc", "structured") for w in ("1", "3/2") for v in ("-100", "100")),
    (("rendering", "every-load"), "1/2", "1000", True),
    *((("rendering", "every-load"), weight, "1000", False) for weight in ("1", "3/2")),
]


@pytest.mark.parametrize(("kind", "weight", "v", "holds"), RADII)
def test_a_disc_of_radius_1_or_more_is_never_passive(kind: Kind, weight: str, v: str, holds: bool) -> None:
    """For (12) as printed neither W nor v W, although what is squared would hold again beyond 1."""
    p = by_hand("9999", "2 2 0", "1 1 1", weight=rational(f"{weight} / 1"))
    assert (p.fault(kind, Fraction(v), (Fraction(1), Fraction(2)), False) == "") is holds


def test_friction_is_compared_by_leading_coefficients_at_infinity() -> None:
    """C = −1/(s + 1): Re[N/(D s)] = 1/(1 + x) is positive, but 0 at infinity, where the disc is nothing."""
    kind, fast = ("friction", "strictly-positive-real"), rational("1/100 / 1 4 6 4 1")
    p = by_hand("-1 / 1 1", "2 2 0", "1 1 1", weight=fast)
    assert p.fault(kind, Fraction(0), (Fraction(0), Fraction(1000)), False) == ""
    assert p.fault(kind, Fraction(0), WHOLE, False) == " at ω = inf rad/s"


PORT, FRICTION = ("eq12", "structured"), ("friction", "strictly-positive-real")
ENDS: dict[str, tuple[Kind, dict[str, Any], str]] = {  # what is said on [0, ∞]
    "Z(0) = 0": (PORT, {"box": "2..2 2..2 1..5"}, ""),  # K + (1 − 3)/2
    "Z(0) < 0": (PORT, {"box": "2..2 2..2 9/10..5"}, "Z(0)"),
    "Z(0) = −1/2": (PORT, {"box": "2..2 2..2 0..5"}, "Z(0)"),
    "lim Z/s² = 0": (PORT, {"plant": "3 2 3", "box": "1..5 2..2 3..3"}, ""),
    "lim Z/s² < 0": (PORT, {"plant": "3 2 3", "box": "9/10..5 2..2 3..3"}, "Z at infinity"),
    "Z(0) is infinite on a disc": (PORT, {"gain": "1 -1"}, "Z(0)"),  # C = s − 1
    "Z(0) is infinite off the nominal": (PORT, {"gain": "1 -1", "plant": "2 2 0", "box": "2..2 2..2 0..1"}, "Z(0)"),
    "lim Z/s² is infinite off the nominal": (PORT, {"gain": "-1 0 / 1 1", "box": "1..3 2..2 3..3"}, "Z at infinity"),
    "lim Z/s² is infinite on a disc": (PORT, {"gain": "-1 0 / 1 1"}, "Z at infinity"),
    "Z(0) = 0 on a disc": (PORT, {"plant": "2 2 7", "impedance": "1 1 3/2", "weight": rational("3/4 / 1")}, ""),
    "Z(0) < 0 on a disc": (PORT, {"plant": "2 2 7", "impedance": "1 1 3/2", "weight": rational("19/25 / 1")}, "Z(0)"),
    "lim Z/s² = 0 on a disc": (PORT, {"plant": "7 2 2", "impedance": "3/2 1 1", "weight": rational("3/4 / 1")}, ""),
    "lim Z/s² < 0 on a disc": (PORT, {"plant": "7 2 2", "impedance": "3/2 1 1", "weight": rational("4/5 / 1")}, "Z at"),
    "N(0) = 0": (FRICTION, {"box": "2..2 2..2 1..5"}, "Z(0)"),  # 2 K + 1 − 3
    "N(0) > 0": (FRICTION, {"box": "2..2 2..2 11/10..5"}, ""),
    "N at infinity = 0": (FRICTION, {"plant": "3 2 3", "box": "1..5 2..2 3..3"}, "Z at infinity"),
    "N at infinity > 0": (FRICTION, {"plant": "3 2 3", "box": "11/10..5 2..2 3..3"}, ""),
    "N(0) = 0 on a disc": (FRICTION, {"plant": "2 2 7", "impedance": "1 1 3/2", "weight": rational("3/4 / 1")}, "Z(0)"),
}


@pytest.mark.parametrize("name", ENDS)
def test_the_port_at_zero_and_infinity(name: str) -> None:
    """Re(Z/s) says nothing of the pole of Z/s there: its sign is looked at apart, on the whole axis only."""
    kind, joint, said = ENDS[name]
    p = by_hand(**{"gain": "1", "plant": "2 2 3", "impedance": "1 1 1"} | joint)
    v = Fraction(-100) if kind == PORT else Fraction(1, 100)
    text = p.fault(kind, v, WHOLE, True)
    assert text is not None and (said in text if said else "finite" not in text), text
    assert said == "" or text.endswith(f"is not finite and {'>=' if kind == PORT else '>'} 0")
    inside = p.fault(kind, v, (Fraction(1), Fraction(2)), True)
    assert inside is not None and "finite" not in inside and "finite" not in str(p.fault(kind, v, WHOLE, False))


def series_elastic(motor: str, loop: str) -> Json:
    """From J b K_sp, and kp kd corner ff."""
    motors = dict(zip(("motor_inertia", "motor_damping", "spring_stiffness"), motor.split(), strict=True))
    loops = dict(zip(("kp", "kd", "derivative_corner", "feedforward"), loop.split(), strict=True))
    return {"type": "series-elastic", **motors, "torque_loop": loops}


def test_friction_is_compared_with_the_nominal_load_even_where_that_is_negative() -> None:
    """Twice the torque fed forward: with a stiffness of 0 in place of 1 both N(0) change their sign."""
    given = prover(
        {"type": "dynamic-feedback", "C": rational("1")},
        plant={"inertia": "2", "damping": "2", "stiffness": "3"},
        impedance={"inertia": "1", "damping": "1", "stiffness": ["0", "2"]},
        uncertainty={"box": {"inertia": ["2", "2"], "damping": ["2", "2"], "stiffness": ["2", "5"]}},
        actuator=series_elastic("1 1 1", "1 0 1 2"),
        controller={"type": "dynamic-feedback"},
    )
    for load, text in (("3", ""), ("5", ": Z(0) is not finite and > 0")):  # 2 K − 9, over 2 · 3 − 9
        witness = {
            "load": {"inertia": Fraction(2), "damping": Fraction(2), "stiffness": Fraction(load)},
            "impedance": {"stiffness": Fraction(0)},
        }
        assert given.fault(FRICTION, Fraction(1, 100), (Fraction(0), Fraction(0)), True, witness) == text
