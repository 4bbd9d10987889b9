"""Claims on cells against margins worked out by hand: boxes, the port, the edge of the loads, coefficients."""

from __future__ import annotations

from fractions import Fraction
from functools import partial
from itertools import product
from math import isqrt
from time import monotonic
from typing import Any

import pytest
from claim_floats import Json
from test_cell_claims import BOX, NONE, PLANT, RANGED, REQUIRED, SAMPLING, WHOLE, certificate, prover, uncertain

from robimp.synthesis.check.enclosure.cells import Cell
from robimp.synthesis.check.enclosure.claims import CellProver
from robimp.synthesis.check.joint import Joint, Point, S
from robimp.synthesis.check.outcome import UNDECIDED, CheckError
from robimp.synthesis.check.polynomials import ONE, ZERO, Poly
from robimp.synthesis.check.proofs import Prover

ELASTIC: Json = {
    "type": "series-elastic",
    "motor_inertia": "1/100",
    "motor_damping": "1/20",
    "spring_stiffness": "5",
    "torque_loop": {"kp": "10", "kd": "0", "derivative_corner": "1000", "feedforward": "0"},
}


# Boxes


def desired(**changes: Any) -> Json:
    return {"inertia": "1/50", "damping": "1/5", "stiffness": "1/2", **changes}


# How far a box may be scaled until a coefficient of f is 0 for one joint in it, by hand; 1 + C = 3.
WIDEST: dict[str, tuple[str, Json, Fraction]] = {
    "damping of the load and of the impedance": (
        "stability-free",
        {"impedance": desired(damping=["3/20", "1/4"]), "uncertainty": uncertain({"damping": ["1/10", "3/10"]})},
        Fraction(3, 5) / (Fraction(1, 10) + 3 * Fraction(1, 20)),
    ),
    "stiffness of the load and of the impedance": (
        "stability-free",
        {"impedance": desired(stiffness=["2/5", "3/5"]), "uncertainty": uncertain({"stiffness": ["1/2", "3/2"]})},
        Fraction(3, 2) / (Fraction(1, 2) + 3 * Fraction(1, 10)),
    ),
    "inertia of the impedance": (
        "stability-free",
        {"impedance": desired(inertia=["1/100", "3/100"]), "uncertainty": uncertain()},
        Fraction(2),
    ),
    "stiffness of the load, behind a hold": (
        "stability-free",
        {
            "sampling": {"rate": "1000", "delay": "0"},
            "impedance": desired(),
            "uncertainty": uncertain({"stiffness": ["1/2", "3/2"]}),
        },
        Fraction(3, 2) / Fraction(1, 2),
    ),
    "damping of the motor": (
        "stability-locked",
        {
            "ideal": False,
            "actuator": ELASTIC,
            "impedance": desired(),
            "uncertainty": uncertain(actuator={"motor_damping": ["1/40", "3/40"]}),
        },
        Fraction(2),
    ),
    "inertia of the motor": (
        "stability-locked",
        {
            "ideal": False,
            "actuator": ELASTIC,
            "impedance": desired(stiffness=["2/5", "3/5"]),
            "uncertainty": uncertain({"damping": ["1/10", "3/10"]}, actuator={"motor_inertia": ["1/200", "3/200"]}),
        },
        Fraction(2),
    ),
}


@pytest.mark.parametrize("name", WIDEST)
def test_a_box_is_shown_to_be_stable_until_one_joint_in_it_is_not(name: str) -> None:
    claim, changes, widest = WIDEST[name]
    joint = prover(**changes)
    for v in (Fraction(0), Fraction(1), widest * Fraction(999, 1000)):
        assert joint.fault((claim, "box"), v, WHOLE, True) == ""
    with pytest.raises(CheckError, match="neither proven nor refuted") as beyond:
        joint.fault((claim, "box"), widest * Fraction(1001, 1000), WHOLE, True)
    assert beyond.value.code == UNDECIDED


@pytest.mark.parametrize(
    ("sampling", "said"), [(None, "a root does not decay"), (SAMPLING | {"delay": "1/1000"}, "roots with Re s > 0")]
)
def test_a_box_around_an_unstable_joint_says_so(sampling: Json, said: str) -> None:
    impedance = desired(damping="0", stiffness=["2/5", "3/5"])
    joint = prover("20", impedance=impedance, sampling=sampling, uncertainty=uncertain())
    assert said in joint._box("stability-free", Fraction(1), {})


def test_generators_are_the_middle_and_what_one_or_two_parameters_change() -> None:
    """f = g − ĝ + (1 + C) m: every parameter, and C with every one of the impedance; loads change what no hold delays.

    What changes nothing is left out, and what changes one of the two summands only is not."""
    joint = prover(impedance=desired(), sampling={"rate": "1000", "delay": "0"}, uncertainty=uncertain())
    ranges: Any = {
        ("plant", "stiffness"): (Fraction(1), Fraction(2)),
        ("impedance", "damping"): (Fraction(1, 5), Fraction(3, 5)),
        ("numerator", 0): (Fraction(-1, 4), Fraction(3, 4)),
        ("actuator", "motor_inertia"): (Fraction(1), Fraction(2)),  # an ideal one has none
    }
    K, B, C, _ = ranges
    found = joint.generators("stability-free", {("plant", "damping"): Fraction(2)}, ranges)
    gain = 2 * Fraction(5, 4)  # in the middle, with e = 1/4; half of its range is 1
    m = Poly.of(Fraction(1, 2), Fraction(2, 5), Fraction(1, 50))
    desired_part = Poly.of(1 + gain) * m - joint.nominal.nominal
    assert found == {
        (): (Poly.of(Fraction(3, 2), 2, Fraction(3, 100)), desired_part),
        (K,): (Poly.of(Fraction(1, 2)), ZERO),
        (B,): (ZERO, Poly.of(0, (1 + gain) * Fraction(1, 5))),
        (C,): (ZERO, m),
        (B, C): (ZERO, Poly.of(0, Fraction(1, 5))),
    }
    late = prover(impedance=desired())
    late.deadline = monotonic() - 1
    with pytest.raises(CheckError, match="time limit"):
        late.generators("stability-free", {}, ranges)


# The port, and the edge of the box


def refuses(given: CellProver, kind: tuple[str, str], v: Fraction, where: Any = WHOLE, witness: Json = None) -> bool:
    """Whether a claim is refuted, by a text; undecided is an error."""
    return given.fault(kind, v, where, where == WHOLE, witness) != ""


NEARLY, MORE = Fraction(999, 1000), Fraction(1001, 1000)


def test_passivity_over_a_range_ends_where_its_least_damping_does() -> None:
    """Re[Z/s] = B_imp + (B − B̂)/3 at every ω. The inertia, which a witness may leave to vary, does not matter."""
    given = prover(
        impedance={"inertia": ["1/50", "1/40"], "damping": ["1/5", "2/5"], "stiffness": "1/2"},
        uncertainty=uncertain({"damping": ["1/10", "3/10"]}),
    )
    places: list[tuple[Json, Fraction]] = [(None, Fraction(1, 5) - Fraction(1, 30))]
    load = {"inertia": Fraction(3, 100), "damping": Fraction(1, 4), "stiffness": Fraction(1)}
    places += [({"load": load, "impedance": {"damping": Fraction(1, 3)}}, Fraction(1, 3) + Fraction(1, 60))]
    places += [({"load": None, "impedance": {"damping": Fraction(1, 3)}}, Fraction(1, 3) - Fraction(1, 30))]
    for witness, margin in places:
        for where in (WHOLE, (Fraction(3), Fraction(3))):
            assert not refuses(given, ("eq12", "structured"), margin * NEARLY, where, witness)
            assert refuses(given, ("eq12", "structured"), margin * MORE, where, witness)


@pytest.mark.parametrize(("key", "end"), [("stiffness", "Z(0)"), ("inertia", "Z at infinity")])
def test_the_port_is_looked_at_where_the_real_part_is_silent(key: str, end: str) -> None:
    """Z(0) = K_imp + (K − K̂)/3 and lim Z/s² = I_imp + (I − Î)/3 for the least load and the least impedance."""
    for share in (NEARLY, MORE):
        n = Fraction(PLANT[key])
        least = n - Fraction(9, 10) * n
        impedance = desired(**{key: [str((n - least) / 3 / share), "2"]})
        given = prover(impedance=impedance, uncertainty=uncertain({key: [str(least), str(2 * n)]}))
        for kind, above in ((("eq12", "structured"), ">="), (("friction", "strictly-positive-real"), ">")):
            said = given.fault(kind, Fraction(1, 1000), WHOLE, True)
            assert (said == f": {end} is not finite and {above} 0") == (share > 1)
            if share > 1:  # not for a load with more of it, nor where neither end is asked for
                load = {"load": {k: Fraction(v) for k, v in PLANT.items()}}
                assert end not in given.fault(kind, Fraction(1, 1000), WHOLE, True, load)
                assert end not in given.fault(kind, Fraction(1, 1000), (Fraction(1), Fraction(2)), False)


@pytest.mark.parametrize("place", [Fraction(1, 2), Fraction(3, 2)])
def test_a_box_may_be_at_its_worst_between_its_corners_but_not_beyond(place: Fraction) -> None:
    """(9) with `U = m − ĝ/3`, `(1−Q_i) ĝ + U = m`: at this ω the load resonates at this place of the edge."""
    box = {"inertia": ["1/50", "1/25"], "damping": ["1/50", "3/10"], "stiffness": ["1/2", "3/2"]}
    given = prover(impedance=RANGED | {"stiffness": ["1/2", "501/1000"]}, uncertainty={"box": box, "weight": None})

    def g(inertia: float, damping: float, stiffness: float, s: complex) -> complex:
        return inertia * s * s + damping * s + stiffness

    x = (Fraction(1, 2) + place) / (Fraction(1, 25) - Fraction(1, 50) * place)  # K(t) = I(t) ω²
    omega = Fraction(isqrt(int(x * 10**12)), 10**6)
    s, nominal = 1j * float(omega), g(0.03, 0.2, 1, 1j * float(omega))
    loads = [g(0.04 - 0.02 * k / 500, 0.02, 0.5 + k / 500, s) for k in range(501)]
    worst = max(abs(nominal - load) / abs(load) for load in loads)
    both = [g(0.02, 0.2, k, s) for k in (0.5, 0.501)]
    margin = Fraction(min(abs(m) / abs(m - nominal / 3) for m in both) / worst)
    assert not refuses(given, ("eq9", "printed"), margin * NEARLY, (omega, omega))
    assert refuses(given, ("eq9", "printed"), margin * MORE, (omega, omega))
    for load, refused in (((3, 20, 100), False), ((4, 2, 50), False), ((2, 2, 150), place > 1)):  # beyond: at a corner
        values = dict(zip(PLANT, (Fraction(v, 100) for v in load), strict=True))
        assert refuses(given, ("eq9", "printed"), margin * MORE, (omega, omega), {"load": values}) == refused


def test_limits_are_those_of_the_polynomials() -> None:
    """At 0 and ∞, over the nominal's function and a power of s; None: infinite."""
    seen, uncertainty = set(), uncertain({"stiffness": ["1/2", "3/2"]})
    names, key = ("stability-free", "stability-locked"), ("impedance", "stiffness")
    points: list[Point] = [{}, {key: NONE}, {key: Fraction(1, 3)}]
    for ideal, far, name, point in product((True, False), (True, False), names, points):
        given, exact = prover(ideal=ideal, uncertainty=uncertainty), certificate(ideal=ideal, uncertainty=uncertainty)
        on_cell = given._limits_on(Cell(NONE, NONE, far, {}), name, given.joint(point))
        j = Prover(exact, given.deadline).joint(point)
        true = Prover(exact, given.deadline)._limits(name, far, j)
        for g, power in product((j.nominal, ZERO, S, S * S * S), (ONE, S, S * S)):
            part = partial(Joint.loop, name="stability-free", g=g)
            value, found = true(part, power), on_cell(part, power)
            assert (found is None) == (value is None)
            seen.add(None if value is None else bool(value))
            if value is not None:
                middle = Fraction(value.c[0], value.d) if value else NONE
                assert abs(found.middle() - middle) <= found.r * Fraction(2) ** found.e <= abs(middle) / 10**15
                assert found.m == 0 or not found
    assert seen == {None, True, False}


# Tolerance


@pytest.mark.parametrize("claim", ["peak sensitivity", "bandwidth attenuation"])
def test_a_required_claim_has_to_hold_for_all_coefficients_nearby(claim: str) -> None:
    """`1 − Q̃ = (1+e)/((1+e) + 9 (1+e'))`: with |e| ≤ 1/100 at most 101/(101 + 9·99)."""
    most, v = Fraction(101, 992), Fraction(1, 100)
    for level in (most * NEARLY, most * MORE):
        peak, attenuation = (str(level), "1/2") if claim.startswith("peak") else ("1/2", str(level))
        limits = {"peak": peak, "tolerance": str(v)}
        given = prover("9", constraints=limits, objective={"maximize": "bandwidth", "attenuation": attenuation})
        said = given.fault(("tolerance", "coefficients"), v, WHOLE, True)
        assert said == ("" if level > most else f": {claim} at ω = 0 rad/s")


@pytest.mark.parametrize(("name", "gain"), [("stability-free", "-9/10"), ("stability-locked", "-9/10")])
def test_every_joint_nearby_has_to_be_stable(name: str, gain: str) -> None:
    """C = −9/10 (1 + e)/(1 + e'): with |e| ≥ 1/19 f may be 0 against the wall, and, of `C m + m`, in free motion."""
    given = prover(gain, constraints={"tolerance": "1/100"}, objective={"maximize": "bandwidth", "attenuation": "100"})
    extra = {(part, 0): (-1, 1) for part in ("denominator", "numerator")}
    for share, stable in ((NEARLY, True), (MORE, False)):
        symbols = dict.fromkeys(extra, (-share / 19, share / 19))
        if stable:
            assert given._box(name, NONE, symbols) == ""
        else:
            with pytest.raises(CheckError, match="neither"):
                given._box(name, NONE, symbols)


def test_the_compensator_of_every_controller_nearby_has_to_be_proper() -> None:
    """d_Q − n_Q = (1 + e)(s + 10) − (1 + e')(.9 s + 8): its first coefficient may be 0 for |e| ≥ (1 − .9)/(1 + .9)."""
    Q = {"numerator": [Fraction(8), Fraction(9, 10)], "denominator": [Fraction(10), Fraction(1)]}  # from s⁰ upwards
    C = {"numerator": Q["numerator"], "denominator": [Fraction(2), Fraction(1, 10)]}
    given = prover(constraints={"tolerance": "1/100"})
    improper = ": C is not proper for all of them"

    def said(controller: Json, v: Fraction) -> str:
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(given, "asked", {})  # nothing else is required
            patch.setattr(given, "certificate", given.certificate | {"controller": controller})
            return given._tolerance(v)

    for v, text in ((Fraction(1, 19), improper), (Fraction(1, 19) * NEARLY, ""), (Fraction(1, 2), improper)):
        assert said({"type": "dob", "Q": Q, "C": C}, v) == text
        assert said({"type": "dob", "Q": {part: [-c for c in Q[part]] for part in Q}, "C": C}, v) == text
    for controller in (
        {"type": "dob", "Q": Q | {"numerator": [Fraction(8)]}, "C": C},  # with Q(∞) = 0 not before e = −1
        {"type": "dynamic-feedback", "C": Q},
        {"type": "dynamic-feedback", "C": {part: [-c for c in Q[part]] for part in Q}},
    ):
        assert said(controller, Fraction(99, 100)) == "" and said(controller, Fraction(1)) == improper
    thirds = {
        "numerator": [Fraction(8), Fraction(5), Fraction(9, 10)],
        "denominator": [Fraction(c, 3) for c in (9, 8, 1)],
    }
    limit = (Fraction(9, 10) - Fraction(1, 3)) / (Fraction(9, 10) + Fraction(1, 3))  # from the other side
    assert said({"type": "dob", "Q": thirds, "C": C}, limit) == improper
    assert said({"type": "dob", "Q": thirds, "C": C}, limit * NEARLY) == ""


CLAIMED: list[tuple[tuple[str, str], Fraction | None, tuple[Any, ...]]] = [
    (("peak", "sensitivity"), Fraction(3), (Fraction(2), (Fraction(3), Fraction(3)), True)),
    (("bandwidth", "attenuation"), NONE, (NONE, (NONE, NONE), False)),
    (("eq12", "structured"), Fraction(3), (NONE, (Fraction(3), Fraction(3)), False)),
    (("stability-free", "hurwitz"), None, (NONE, WHOLE, True)),
    (("stability-free", "box"), None, (Fraction(1), WHOLE, True)),
    (("bandwidth", "attenuation"), None, (NONE, (NONE, Fraction(10)), False)),
]


@pytest.mark.parametrize(("kind", "omega", "asked"), CLAIMED)
def test_a_controller_nearby_is_a_certificate_of_its_own_for_the_claim_that_it_loses(
    kind: tuple[str, str], omega: Fraction | None, asked: tuple[Any, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    given = prover(constraints=REQUIRED | {"tolerance": "1/100"}, uncertainty={"box": BOX, "weight": None})
    rational = {"numerator": [Fraction(21, 10)], "denominator": [Fraction(1)]}
    witness = {"claim": [*kind], "controller": rational, "omega": omega, "load": None}
    monkeypatch.setattr(
        CellProver, "fault", lambda prover, *said: (prover.certificate["controller"], prover.deadline, said)
    )
    controller = {"type": "dynamic-feedback", "C": rational}
    assert given._perturbed(witness) == (controller, given.deadline, (kind, *asked, witness))  # type: ignore[comparison-overlap]


def test_a_controller_nearby_is_judged_by_its_own_coefficients() -> None:
    """Gain 9 (1 + e): |1 − Q̃| = 1/(1 + 9 (1 + e)) ≤ 1/5 is lost where e < −5/9."""
    given = prover("9", constraints={"peak": "1/5", "tolerance": "1/10"})
    for gain, lost in ((Fraction(41, 10), False), (Fraction(39, 10), True)):
        rational = {"numerator": [gain], "denominator": [Fraction(1)]}
        for omega in (NONE, Fraction(7)):
            witness = {"claim": ["peak", "sensitivity"], "controller": rational, "omega": omega, "load": None}
            assert refuses(given, ("tolerance", "coefficients"), Fraction(3, 5), (omega, omega), witness) == lost
