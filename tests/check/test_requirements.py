# ruff: noqa: E501  (tables of edits, one a line)
"""What a specification asks for, and whether the fields of claims and witnesses fit it; nothing is proven here."""

from __future__ import annotations

import copy
import json
from collections.abc import Callable
from fractions import Fraction
from math import inf
from typing import Any

import pytest
from certificate_builder import claim, data, dob, find, seal, spec
from claim_floats import Json

from robimp.synthesis.check.outcome import CheckError
from robimp.synthesis.check.reader import read
from robimp.synthesis.check.requirements import compare, requirements

WHOLE, BAND, OMEGA_B = ["0", "inf"], ["0", "1/2"], Fraction(1, 2)
EQ18 = [f"{form}/{coupling}" for coupling in ("frozen", "physical") for form in ("paper", "lumped", "half-plane")]
NOTHING: Json = {"eq9": None, "eq12": None, "eq18": None, "peak": None, "friction": "report"}
EVERYTHING: Json = {
    "plant": {"inertia": "2", "damping": "4", "stiffness": "6"},
    "uncertainty": {
        "box": {"inertia": ["1", "3"], "damping": ["3", "6"], "stiffness": ["5", "7"]},
        "actuator": {"motor_inertia": ["1/200", "3/200"]},
    },
    "impedance": {"inertia": "1", "damping": ["1", "3"], "stiffness": "1"},
    "objective": {"rendering_error": "1/2"},
    "constraints": {
        "eq12": {"form": "structured", "band": None, "margin": "1/10"},
        "noise": {"gain": "30", "above": "200"},
        "tolerance": "1/1000",
        "friction": "require",
    },
}
LEVELS: dict[tuple[str, str], tuple[list[str], str]] = {  # of every claim required: interval and just enough margin
    ("stability-free", "hurwitz"): (WHOLE, "0"),
    ("stability-locked", "hurwitz"): (WHOLE, "0"),
    ("stability-free", "box"): (WHOLE, "1"),
    ("stability-locked", "box"): (WHOLE, "1"),
    ("bandwidth", "attenuation"): (BAND, "1/2"),
    ("peak", "sensitivity"): (WHOLE, "2"),
    ("noise", "command"): (["200", "inf"], "30"),
    ("rendering", "every-load"): (BAND, "1/2"),
    ("friction", "strictly-positive-real"): (WHOLE, "1/9"),  # anything positive
    ("eq9", "printed"): (WHOLE, "1"),
    ("eq12", "structured"): (WHOLE, "1/10"),
    ("eq18", "half-plane/physical"): (WHOLE, "1"),
    ("tolerance", "coefficients"): (WHOLE, "1/1000"),
}
OPTIONAL = [("eq12", "paper"), ("eq12", "disc"), *[("eq18", form) for form in EQ18 if form != "half-plane/physical"]]


def everything(**changes: Any) -> Json:
    """A certificate that claims all its specification asks for, nowhere more."""
    claims = [claim(*kind, interval, margin, True) for kind, (interval, margin) in LEVELS.items()]
    body = {
        "robimp_certificate": 1,
        "spec": spec(**EVERYTHING),
        "controller": dob(["4"], ["1", "5"]),
        "bandwidth": {"proven": "1/2", "refuted_at": None, "bound": None},
        "claims": claims,
        "assumptions": [],
        "not_claimed": [],
        "producer": {},
    }
    return json.loads(json.dumps({**body, **changes}))


def complaint(cert: Json) -> tuple[int, str]:
    """Exit code and message of a comparison; 0 and nothing if there is nothing to complain about."""
    certificate = read(data(seal(cert)))
    try:
        compare(certificate)
    except CheckError as error:
        return error.code, str(error)
    return 0, ""


def fits(cert: Json) -> bool:
    return complaint(cert) == (0, "")


def edited(kind: str, form: str | None = None, /, **changes: object) -> Json:
    cert = everything()
    find(cert, kind, form).update(changes)
    return cert


def asked(**changes: Any) -> dict[tuple[str, str], Any]:
    """What a specification requires, with which margin on which interval."""
    certificate = read(data(seal(everything(spec=spec(**changes)))))
    return requirements(certificate["spec"], OMEGA_B)


def exact(interval: list[str]) -> tuple[Any, Any]:
    lo, hi = (inf if end == "inf" else Fraction(end) for end in interval)
    return lo, hi


def test_all_that_a_specification_can_ask_for() -> None:
    found = asked(**EVERYTHING)
    for kind, (interval, margin) in LEVELS.items():
        enough = {"friction": Fraction(0), "bandwidth": None}.get(kind[0], Fraction(margin))
        assert found[kind] == (True, exact(interval), enough), kind
    for kind in OPTIONAL:
        level = Fraction(1, 10) if kind == ("eq12", "disc") else 1
        assert found[kind] == (False, exact(WHOLE), level), kind
    winding = [("stability-free", "winding"), ("stability-locked", "winding")]
    assert all(found[kind] == (False, exact(WHOLE), 0) for kind in winding)
    assert found.keys() == {*LEVELS, *OPTIONAL, *winding}


def test_the_least_that_a_specification_can_ask_for() -> None:
    found = asked(constraints=NOTHING, uncertainty={"box": None})
    always = {("stability-free", "hurwitz"), ("stability-locked", "hurwitz"), ("bandwidth", "attenuation")}
    assert {kind for kind, (required, *_) in found.items() if required} == always
    assert found["noise", "command"] == (False, exact(WHOLE), None)
    assert found["eq12", "disc"] == (False, exact(WHOLE), 0)
    assert found["rendering", "every-load"] == (False, exact(BAND), None)


def test_sampling_asks_for_the_winding_in_place_of_routh() -> None:
    found = asked(sampling={"rate": "1000", "delay": "0"})
    for name in ("stability-free", "stability-locked"):
        assert found[name, "winding"] == (True, exact(WHOLE), 0) and found[name, "hurwitz"][0] is False


@pytest.mark.parametrize(
    ("changes", "free", "locked"),
    [
        ({}, True, False),
        ({"uncertainty": {"box": None}}, False, False),
        ({"uncertainty": {"box": {k: [v, v] for k, v in spec()["plant"].items()}}}, False, False),
        ({"uncertainty": {"box": None}, "impedance": {"damping": ["1/3", "1/2"]}}, True, False),
        ({"uncertainty": {"box": None, "actuator": {"motor_damping": ["0", "1"]}}}, True, True),
        ({"uncertainty": {"box": None, "actuator": {"motor_damping": ["1/20", "1/20"]}}}, False, False),
    ],
)
def test_what_varies_asks_for_the_stability_of_a_box(changes: Json, free: bool, locked: bool) -> None:
    found = asked(**changes)
    assert (found["stability-free", "box"][0], found["stability-locked", "box"][0]) == (free, locked)


def test_passivity_on_a_band() -> None:
    band = {"eq12": {"form": "disc", "band": ["1", "9"], "margin": "0"}}
    found = asked(constraints=band)
    assert found["eq12", "disc"] == (True, exact(["1", "9"]), 0) and not found["eq12", "structured"][0]
    assert asked(constraints={"noise": {"gain": "3"}})["noise", "command"] == (True, exact(WHOLE), 3)


def test_what_is_asked_for_and_no_more_is_enough() -> None:
    assert fits(everything())


@pytest.mark.parametrize("kind", LEVELS, ids=" ".join)
def test_what_is_asked_for_has_to_be_there(kind: tuple[str, str]) -> None:
    cert = everything()
    cert["claims"].remove(find(cert, *kind))
    assert complaint(cert) == (6, f"{' '.join(kind)}: required by the specification and missing")


@pytest.mark.parametrize("kind", OPTIONAL, ids=" ".join)
def test_more_may_be_claimed_but_not_as_required(kind: tuple[str, str]) -> None:
    cert = everything()
    cert["claims"].append(claim(*kind, WHOLE, "1/2", False))
    assert fits(cert)
    cert["claims"][-1]["required"] = True
    assert complaint(cert) == (6, f"{' '.join(kind)}: `required` disagrees with the specification")


@pytest.mark.parametrize("kind", [k for k in LEVELS if k[0] not in ("bandwidth", "friction")], ids=" ".join)
def test_a_margin_short_of_the_level_is_6_and_a_better_one_is_not(kind: tuple[str, str]) -> None:
    step = Fraction(-1 if kind[0] in ("peak", "noise", "rendering") else 1, 10**9)
    level = Fraction(LEVELS[kind][1])
    assert fits(edited(*kind, margin=str(level + step)))
    short = (6, "its margin is short of what the specification asks for") if level else (4, "a negative margin")
    assert complaint(edited(*kind, margin=str(level - step))) == (short[0], f"{' '.join(kind)}: {short[1]}")


CLAIMS: dict[str, tuple[Json, int, str]] = {
    "no such claim": (edited("eq9", form="imagined"), 2, "eq9 imagined: no such claim"),
    "proven without margin": (edited("eq9", margin=None), 2, "margin does not fit the status proven"),
    "undecided with margin": (edited("eq9", status="undecided"), 2, "margin does not fit the status undecided"),
    "undecided": (edited("eq9", status="undecided", margin=None), 0, ""),
    "refuted without witness": (edited("eq9", status="refuted", margin=None), 2, "refuted_at does not fit the status refuted"),
    "undecided with witness": (edited("eq9", status="undecided", margin=None, refuted_at={"value": "2", "omega": "1", "load": None}), 2, "refuted_at does not fit the status undecided"),
    "not required": (edited("eq9", required=False), 6, "`required` disagrees with the specification"),
    "another interval": (edited("peak", interval=["0", "9"]), 6, "its interval is not the specification's"),
    "another band": (edited("noise", interval=["100", "inf"]), 6, "its interval is not the specification's"),
    "passivity that is required, elsewhere": (edited("eq12", interval=["1", "2"]), 6, "its interval is not"),
    "negative passivity that is required": (edited("eq12", margin="-1"), 6, "its margin is short"),
    "no friction margin": (edited("friction", margin="0"), 4, "the margin must be positive"),
    "no tolerance": (edited("tolerance", margin="0"), 4, "the margin must be positive"),
    "any tolerance above": (edited("tolerance", margin="1/999"), 0, ""),
    "bandwidth above": (edited("bandwidth", margin="1"), 6, "its margin is not bandwidth.proven"),
    "bandwidth below": (edited("bandwidth", margin="1/4"), 6, "its margin is not bandwidth.proven"),
    "a negative peak": (edited("peak", margin="-1"), 4, "a negative margin"),
}  # fmt: skip


@pytest.mark.parametrize("name", CLAIMS)
def test_the_fields_of_a_claim_fit(name: str) -> None:
    cert, code, text = CLAIMS[name]
    found, said = complaint(cert)
    assert found == code and text in said


def test_no_bandwidth_is_no_certificate() -> None:
    cert = everything()
    cert["bandwidth"]["proven"] = "0"
    for kind in ("bandwidth", "rendering"):
        find(cert, kind)["interval"] = ["0", "0"]
    find(cert, "bandwidth")["margin"] = "0"
    assert complaint(cert) == (6, "bandwidth attenuation: its margin is not bandwidth.proven")


@pytest.mark.parametrize(
    ("more", "code", "text"),
    [
        (claim("eq12", "disc", ["1", "2"], "-3", False), 0, ""),
        (claim("eq12", "paper", ["1", "2"], "1/2", False), 0, ""),
        (claim("eq12", "paper", ["1", "2"], "-1", False), 4, "a negative margin"),
        (claim("eq18", "paper/frozen", ["1", "2"], "1/2", False), 6, "its interval is not"),
        (claim("eq18", "paper/frozen", WHOLE, "0", False), 0, ""),
        (claim("stability-free", "winding", WHOLE, "0", False), 6, "not with or without sampling"),
        (claim("eq9", "printed", WHOLE, "1", True), 2, "appears twice"),
    ],
)
def test_the_fields_of_a_claim_that_is_not_required(more: Json, code: int, text: str) -> None:
    found, said = complaint(everything(claims=[*everything()["claims"], more]))
    assert found == code and text in said


@pytest.mark.parametrize(("margin", "code"), [("0", 0), ("1", 6), ("1/2", 6), ("-1", 4)])
def test_a_winding_has_no_margin(margin: str, code: int) -> None:
    s = spec(constraints=NOTHING, uncertainty={"box": None}, sampling={"rate": "1000", "delay": "0"})
    claims = [claim(f"stability-{end}", "winding", WHOLE, margin, True) for end in ("free", "locked")]
    claims.append(claim("bandwidth", "attenuation", BAND, "1/2", True))
    assert complaint(everything(spec=s, claims=claims))[0] == code
    routh = claim("stability-free", "hurwitz", WHOLE, "0", False)
    assert complaint(everything(spec=s, claims=[routh, *claims]))[1].endswith("not with or without sampling")


NOMINAL: Json = {"inertia": "2", "damping": "4", "stiffness": "6"}
IMPEDANCE: Json = {"inertia": "1", "damping": "2", "stiffness": "1"}
MOTOR: Json = {"motor_inertia": "1/100", "motor_damping": "1/20", "spring_stiffness": "24/5"}
SHIPPED: Json = {"numerator": ["4"], "denominator": ["1", "5"]}


def witnessed(kind: str, value: str, omega: str | None, load: Json = None, /, **more: Any) -> Json:
    return edited(*kind.split(), refuted_at={"value": value, "omega": omega, "load": load, **more})


def about(kind: str) -> Json:
    """What a witness of a tolerance says besides: the claim that fails, and of which controller."""
    return {"controller": SHIPPED, "claim": kind.split()}


def refuted(kind: str, value: str, **changes: Any) -> Json:
    witness = {"value": value, "omega": "1", "load": None}
    return edited(kind, status="refuted", margin=None, refuted_at=witness, **changes)


def load(**changes: str) -> Json:
    return {**NOMINAL, **changes}


WITNESSES: dict[str, tuple[Json, str]] = {
    "any value": (witnessed("eq9", "7", "1"), ""),
    "nought": (witnessed("eq9", "0", "1"), ""),
    "a negative value": (witnessed("eq9", "-1/2", "1"), "refuted_at.value: negative"),
    "a negative value of passivity": (witnessed("eq12", "-1/2", "1"), ""),
    "refuted at the level": (refuted("eq9", "1"), ""),
    "refuted above the level": (refuted("eq9", "2"), "refuted_at.value: is not the required one"),
    "refuted below the level": (refuted("eq9", "1/2"), "refuted_at.value: is not the required one"),
    "at no frequency": (witnessed("eq9", "2", None), "refuted_at.omega: does not fit"),
    "at zero": (witnessed("eq9", "2", "0"), ""),
    "at infinity": (witnessed("eq9", "2", "inf"), ""),
    "where the band begins": (witnessed("noise", "2", "200"), ""),
    "before the band": (witnessed("noise", "2", "1999/10"), "refuted_at.omega: is outside the interval"),
    "where the band ends": (witnessed("rendering", "2", "1/2"), ""),
    "beyond the band": (witnessed("rendering", "2", "3/5"), "refuted_at.omega: is outside the interval"),
    "roots at a frequency": (witnessed("stability-free hurwitz", "2", "1"), "refuted_at.omega: does not fit"),
    "roots": (witnessed("stability-free hurwitz", "2", None), ""),
    "roots for a load": (witnessed("stability-free hurwitz", "2", None, NOMINAL), "refuted_at.load: this claim is nominal"),
    "roots for an impedance": (witnessed("stability-free hurwitz", "2", None, impedance=IMPEDANCE), "refuted_at.impedance: this claim is nominal"),
    "a root of a box at a frequency": (witnessed("stability-free box", "2", "1", NOMINAL), ""),
    "a root of a box": (witnessed("stability-free box", "2", None, NOMINAL), ""),
    "a load at the lower corner": (witnessed("eq9", "2", "1", load(inertia="1", damping="3", stiffness="5")), ""),
    "a load at the upper corner": (witnessed("eq9", "2", "1", load(inertia="3", damping="6", stiffness="7")), ""),
    "too light": (witnessed("eq9", "2", "1", load(inertia="99/100")), "refuted_at.load: is not in the box"),
    "too heavy": (witnessed("eq9", "2", "1", load(inertia="301/100")), "refuted_at.load: is not in the box"),
    "too stiff": (witnessed("eq9", "2", "1", load(stiffness="8")), "refuted_at.load: is not in the box"),
    "a box grows about the nominal": (witnessed("stability-free box", "3/2", None, load(inertia="1/2", damping="7", stiffness="15/2")), ""),
    "a box grows so far below": (witnessed("stability-free box", "3/2", None, load(damping="249/100")), "refuted_at.load: is not in the box"),
    "a box grows so far above": (witnessed("stability-free box", "3/2", None, load(damping="701/100")), "refuted_at.load: is not in the box"),
    "an impedance in its range": (witnessed("eq9", "2", "1", impedance={**IMPEDANCE, "damping": "3"}), ""),
    "an impedance out of its range": (witnessed("eq9", "2", "1", impedance={**IMPEDANCE, "damping": "4"}), "refuted_at.impedance: is not in the box"),
    "an impedance without range": (witnessed("eq9", "2", "1", impedance={**IMPEDANCE, "inertia": "2"}), "refuted_at.impedance: is not in the box"),
    "a motor in its range": (witnessed("eq9", "2", "1", actuator={**MOTOR, "motor_inertia": "3/200"}), ""),
    "a motor out of its range": (witnessed("eq9", "2", "1", actuator={**MOTOR, "motor_inertia": "1/50"}), "refuted_at.actuator: is not in the box"),
    "a controller of another claim": (witnessed("eq9", "2", "1", controller=SHIPPED), "refuted_at: fields"),
    "a claim of another claim": (witnessed("eq9", "2", "1", claim=["peak", "sensitivity"]), "fields"),
    "both of another claim": (witnessed("eq9", "2", "1", **about("eq9 printed")), "refuted_at: fields"),
    "tolerance": (witnessed("tolerance", "1", "1", **about("eq9 printed")), ""),
    "tolerance without both": (witnessed("tolerance", "1", "1"), "refuted_at: fields"),
    "tolerance without controller": (witnessed("tolerance", "1", "1", claim=["eq9", "printed"]), "refuted_at: fields"),
    "tolerance without claim": (witnessed("tolerance", "1", "1", controller=SHIPPED), "refuted_at: fields"),
    "tolerance of a claim that is not required": (witnessed("tolerance", "1", "1", **about("eq12 paper")), "refuted_at.claim: is not a required one"),
    "tolerance of a claim that there is not": (witnessed("tolerance", "1", "1", **about("eq12")), "refuted_at.claim: is not a required one"),
    "tolerance of itself": (witnessed("tolerance", "1", "1", **about("tolerance coefficients")), "refuted_at.claim: is not a required one"),
    "tolerance in the band of its claim": (witnessed("tolerance", "1", "1/2", **about("bandwidth attenuation")), ""),
    "tolerance out of the band of its claim": (witnessed("tolerance", "1", "1", **about("bandwidth attenuation")), "refuted_at.omega: is outside the interval"),
    "tolerance and roots": (witnessed("tolerance", "1", None, **about("stability-free hurwitz")), ""),
    "tolerance and roots for a load": (witnessed("tolerance", "1", None, NOMINAL, **about("stability-free hurwitz")), "refuted_at.load: this claim is nominal"),
    "tolerance and the box": (witnessed("tolerance", "2", None, NOMINAL, **about("stability-free box")), ""),
    "tolerance and a corner of the box": (witnessed("tolerance", "2", None, load(inertia="1"), **about("stability-free box")), ""),
    "tolerance does not make the box grow": (witnessed("tolerance", "2", None, load(inertia="1/2"), **about("stability-free box")), "refuted_at.load: is not in the box"),
}  # fmt: skip


@pytest.mark.parametrize("name", WITNESSES)
def test_the_fields_of_a_witness_fit(name: str) -> None:
    cert, text = WITNESSES[name]
    code, said = complaint(cert)
    assert code == (4 if text else 0) and text in said


@pytest.mark.parametrize(
    ("numerator", "denominator", "near"),
    [
        (["5"], ["5/4", "25/4"], True),
        (["3"], ["3/4", "15/4"], True),
        (["501/100"], ["1", "5"], False),
        (["299/100"], ["1", "5"], False),
        (["4"], ["1", "313/50"], False),
        (["4"], ["63/50", "5"], False),
        (["0", "4"], ["1", "5"], False),
        (["4"], ["0", "1", "5"], False),
    ],
)
@pytest.mark.parametrize("type", ["dob", "dynamic-feedback"])
def test_each_coefficient_of_a_tolerance_witness_is_within_it(
    type: str, numerator: list[str], denominator: list[str], near: bool
) -> None:
    controller = {"numerator": numerator, "denominator": denominator}
    cert = witnessed("tolerance", "1/4", "1", claim=["eq9", "printed"], controller=controller)
    if type != "dob":
        cert["controller"] = {"type": type, "C": SHIPPED}
    beyond = (4, "tolerance coefficients: refuted_at.controller: is not within the tolerance")
    assert complaint(cert) == ((0, "") if near else beyond)


def test_an_ideal_actuator_has_no_motor() -> None:
    cert = witnessed("eq9", "2", "1", actuator=MOTOR)
    cert["spec"]["actuator"], cert["spec"]["uncertainty"]["actuator"] = {"type": "ideal"}, None
    cert["claims"].remove(find(cert, "stability-locked", "box"))
    assert complaint(cert) == (4, "eq9 printed: refuted_at.actuator: there is no motor_inertia")


def twin(proven: str | None, witness: str | None) -> Json:
    cert = everything()
    cert["bandwidth"]["refuted_at"] = proven
    if witness:
        find(cert, "bandwidth")["refuted_at"] = {"value": witness, "omega": witness, "load": None}
    return cert


def at(omega: str) -> Callable[[Json], None]:
    return lambda cert: find(cert, "bandwidth")["refuted_at"].update(omega=omega)


@pytest.mark.parametrize(
    ("proven", "witness", "fitting"),
    [(None, None, True), ("3", "3", True), ("3", None, False), (None, "3", False), ("3", "4", False)],
)
def test_the_bandwidths_witness_is_where_the_certificate_says(
    proven: str | None, witness: str | None, fitting: bool
) -> None:
    said = complaint(twin(proven, witness))[1]
    assert said == ("" if fitting else "bandwidth attenuation: its witness is not bandwidth.refuted_at")


@pytest.mark.parametrize("omega", ["0", "1", "299/100", "301/100", "inf"])
def test_a_bandwidth_is_refuted_at_its_end(omega: str) -> None:
    cert = twin("3", "3")
    at(omega)(cert)
    assert complaint(cert) == (4, "bandwidth attenuation: refuted_at.omega: is outside the interval")


def test_no_other_claim_has_to_do_with_the_bandwidths_witness() -> None:
    cert = copy.deepcopy(WITNESSES["any value"][0])
    cert["bandwidth"]["refuted_at"] = "3"
    assert complaint(cert)[1] == "bandwidth attenuation: its witness is not bandwidth.refuted_at"
    find(cert, "bandwidth")["refuted_at"] = {"value": "3", "omega": "3", "load": None}
    assert fits(cert)
