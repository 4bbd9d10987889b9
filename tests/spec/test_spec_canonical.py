"""The canonical form: one text for one meaning, and a valid specification itself."""

from __future__ import annotations

import copy
import hashlib
import json
import re
from collections.abc import Callable, Iterator
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
from spec_texts import EVERY_NEW_KEY, TWO_PORT, Pair, actuator, loose_actuator, sampling, stiffness, table

from robimp.synthesis.errors import InputError
from robimp.synthesis.spec import (
    canonical,
    canonical_json,
    from_canonical,
    load_spec,
    number_text,
    parse_spec,
    spec_sha256,
)

Edit = Callable[..., str]
EVERYTHING = (
    ("{box: {inertia", "{weight: {numerator: [-1/3, 0], denominator: [1, 800]}, box: {inertia"),
    (
        "order: 4",
        "coefficients: {numerator: [2000], denominator: [1, 70.75, 2500]}, filters: {force: 40 Hz, position: none}",
    ),
    ("attenuation: 0.3", "attenuation: 0.3, rendering_error: 1e-300"),
    ("form: structured", "form: structured, band: [0.5, 100], margin: 0.02"),
)


def numbers(value: Any, key: str = "") -> Iterator[str]:
    if isinstance(value, dict):
        for name, item in value.items():
            yield from numbers(item, name)
    elif isinstance(value, list):
        for item in value:
            yield from numbers(item, key)
    elif isinstance(value, str) and key not in {
        "name",
        "motion",
        "type",
        "form",
        "coupling",
        "friction",
        "maximize",
        "beyond",
    }:
        yield value


def test_the_canonical_form_of_the_good_specification(good: str) -> None:
    assert canonical(parse_spec(good)) == {
        "robimp": 1,
        "name": "joint",
        "motion": "rotary",
        "plant": {"inertia": "3/100", "damping": "1/5", "stiffness": "0"},
        "uncertainty": {
            "box": {"inertia": ["3/125", "9/250"], "damping": ["3/25", "7/25"], "stiffness": ["0", "0"]},
            "weight": None,
        },
        "actuator": {
            "type": "series-elastic",
            "motor_inertia": "1/100",
            "motor_damping": "1/20",
            "spring_stiffness": "24/5",
            "torque_loop": {"kp": "10", "kd": "1/4", "derivative_corner": "1000", "feedforward": "1"},
        },
        "impedance": {"inertia": "3/100", "damping": "7/20", "stiffness": "5/4"},
        "controller": {
            "type": "dob",
            "order": 4,
            "form": None,
            "coefficients": None,
            "filters": {"force": None, "position": None, "derivative": None},
        },
        "objective": {"maximize": "bandwidth", "attenuation": "3/10", "rendering_error": None},
        "constraints": {
            "eq9": {},
            "eq12": {"form": "structured", "band": None, "margin": "0"},
            "eq18": {"form": "half-plane", "coupling": "physical"},
            "peak": "2",
            "friction": "report",
        },
    }


PROPER_PORT = actuator(TWO_PORT.replace("[1/100, 1]", "[1/100, 1, 0]"))
RIGID_PORT = actuator(TWO_PORT.replace("[0.01, 0.05, 0]", "[0]"))


@pytest.mark.parametrize(
    "pairs",
    [(), EVERYTHING, EVERY_NEW_KEY, (*EVERYTHING, *EVERY_NEW_KEY[1:4]), (PROPER_PORT,), (RIGID_PORT,)],
    ids=["good", "everything", "every new key", "both", "two-port", "rigid two-port"],
)
def test_there_and_back(pairs: tuple[tuple[str, str], ...], edit: Edit) -> None:
    spec = parse_spec(edit(*pairs))
    document = canonical(spec)
    assert from_canonical(document) == spec
    assert from_canonical(json.loads(canonical_json(document))) == spec
    assert parse_spec(json.dumps(document, indent=1)) == spec  # the canonical form is a specification


@pytest.mark.parametrize("corner", ["1e300", "1e-300", "1." + "7" * 98 + "e200 Hz", "1" * 1999 + "/3" + "0" * 1998])
def test_what_is_accepted_at_the_limits_comes_back(corner: str, edit: Edit) -> None:
    spec = parse_spec(edit(("derivative_corner: 1000", f"derivative_corner: {corner}")))
    assert from_canonical(canonical(spec)) == spec


@pytest.mark.parametrize("corner", ["1e300 Hz", "1" * 1999 + "/3" + "0" * 1998 + " Hz", "1" * 2001 + "/1"])
def test_what_could_not_come_back_is_refused(corner: str, edit: Edit) -> None:
    with pytest.raises(InputError, match=r"magnitude|digits"):
        parse_spec(edit(("derivative_corner: 1000", f"derivative_corner: {corner}")))


def test_every_number_is_canonical_text(edit: Edit) -> None:
    texts = [text for text in numbers(canonical(parse_spec(edit(*EVERYTHING)))) if text != "none"]
    texts += numbers(canonical(parse_spec(edit(*EVERY_NEW_KEY))))
    assert len(texts) > 60
    for text in texts:
        assert re.fullmatch(r"0|-?[1-9][0-9]*(/[1-9][0-9]*)?", text)
        assert number_text(Fraction(text)) == text
    assert number_text(Fraction(-6, 4)) == "-3/2"
    assert number_text(Fraction(4, 2)) == "2"


def test_the_digest_follows_the_meaning_and_not_the_spelling(good: str, edit: Edit) -> None:
    digest = spec_sha256(parse_spec(good))
    assert digest == hashlib.sha256(canonical_json(canonical(parse_spec(good)))).hexdigest()
    assert spec_sha256(parse_spec("# note\n" + edit(("0.35", "350e-3 N·m·s/rad")))) == digest
    assert spec_sha256(parse_spec(edit(("0.35", "0.3500000001")))) != digest


# As they were before the keys that are absent when not given: certificates of that time name these digests.
DIGESTS = {
    "haninger2016": "17b924a50ac6d558cfef2d328a7169f5e70b84354f5601f474250339354822a8",
    "haninger2016-eq23": "994448de285077cf2323feea78a158ddf5c62840dbf10d1e7291b5e548b4821d",
    "haninger2016-feedback": "02567658cd99c86d584f604aa111efc9076bb2ae8810b9c039931546da21d79e",
    "haninger2016-paper": "7eae0a1452cb064cf6153c0870e0fa7eab1b3afbf41b8c98ac13eb1b20b3df84",
    "haninger2016-stiff": "2eefd6011bae7d149a838cba8c98376208121a002776d6a012c2d22142058336",
    "unstable-optimum": "d9d817bb945591c065a5ac053b838a10d1ae3de6990dd0859cde3ce2a9a37f85",
}


@pytest.mark.parametrize(("name", "digest"), DIGESTS.items())
def test_the_digest_of_an_older_specification_stays(name: str, digest: str) -> None:
    assert spec_sha256(load_spec(Path(__file__).parents[2] / "examples" / f"{name}.yaml")) == digest


@pytest.mark.parametrize("pair", EVERY_NEW_KEY, ids=[new for _, new in EVERY_NEW_KEY])
def test_a_new_key_changes_the_digest(pair: Pair, good: str, edit: Edit) -> None:
    assert spec_sha256(parse_spec(edit(pair))) != spec_sha256(parse_spec(good))


def test_the_canonical_form_of_the_new_keys(edit: Edit) -> None:
    document: dict[str, Any] = canonical(parse_spec(edit(*EVERY_NEW_KEY)))
    assert document["sampling"] == {"rate": "1000", "delay": "1/1000"}
    assert document["impedance"] == {"inertia": ["27/1000", "33/1000"], "damping": "7/20", "stiffness": ["1/5", "4"]}
    assert document["uncertainty"]["actuator"] == {"motor_inertia": ["9/1000", "11/1000"]}
    assert document["uncertainty"]["table"] == {
        "points": [["0", "1/10"], ["6283185307179586476925287/1000000000000000000000000", "1/20"], ["100", "1/3"]],
        "beyond": "hold",
    }
    assert document["constraints"]["noise"] == {"gain": "30", "above": "200"}
    assert document["constraints"]["tolerance"] == "1/16777216"
    port: dict[str, Any] = canonical(parse_spec(edit(PROPER_PORT)))
    assert port["actuator"] == {
        "type": "two-port",
        "transfer": {"numerator": ["100"], "denominator": ["1", "20", "100"]},
        "impedance": {"numerator": ["1/100", "1/20", "0"], "denominator": ["1/100", "1", "0"]},
    }


def test_one_meaning_has_one_digest_here_too(edit: Edit) -> None:
    for one, other in (
        (stiffness("[3, 3]"), stiffness("3")),
        (stiffness("2 ±50 %"), stiffness("[1, 3]")),
        (sampling("{rate: 1000, delay: 0}"), sampling("{delay: 0 ms, rate: 1 kHz}")),
        (loose_actuator("{motor_inertia: ±10 %}"), loose_actuator("{motor_inertia: [9 g·m², 0.011]}")),
        (table("{points: [[1, 0.5]], beyond: hold}"), table("{points: [[1 rad/s, 50 %]], beyond: hold}")),
    ):
        assert spec_sha256(parse_spec(edit(one))) == spec_sha256(parse_spec(edit(other)))


@pytest.mark.parametrize(
    ("path", "value", "reason"),
    [
        ("sampling", None, "canonical form"),
        ("uncertainty.actuator.motor_damping", None, "canonical form"),
        ("uncertainty.actuator", None, "canonical form"),
        ("uncertainty.table", None, "canonical form"),
        ("constraints.noise", None, "canonical form"),
        ("constraints.tolerance", None, "canonical form"),
        ("constraints.tolerance", "float32", "canonical form"),
        ("constraints.noise", {"gain": "30"}, "canonical form"),
        ("impedance.stiffness", ["1", "1"], "canonical form"),
        ("impedance.stiffness", "1 ±20 %", "canonical form"),
        ("impedance.stiffness", ["1"], "found a list of 1"),
        ("sampling.rate", "1 kHz", "canonical form"),
        ("uncertainty.actuator.motor_inertia", "±10 %", "canonical form"),
        ("uncertainty.table.points", [["1", "1"], ["1", "1"]], "each frequency once"),
        ("uncertainty.table.points", [["1", "1/2"], ["2", "2/4"]], "canonical form"),
        ("uncertainty.table", {"points": [["1", "1"]]}, "beyond: expected this key"),
        ("uncertainty.table", {"file": "bound.csv", "beyond": "hold"}, "no folder to look in"),
        ("uncertainty.measured", {"files": []}, "expected a table or measured responses"),
    ],
)
def test_a_new_key_not_in_canonical_form_is_refused(path: str, value: object, reason: str, edit: Edit) -> None:
    document = canonical(parse_spec(edit(*EVERY_NEW_KEY)))
    with pytest.raises(InputError, match=reason):
        from_canonical(change(document, path, value))
    assert from_canonical(change(document, "name", "other")).name == "other"


def test_canonical_json_is_one_byte_string() -> None:
    assert canonical_json({"b": [1, None], "a": "±"}) == b'{"a":"\\u00b1","b":[1,null]}'
    with pytest.raises(ValueError, match="JSON"):
        canonical_json(float("nan"))


def change(document: dict[str, Any], path: str, value: object) -> dict[str, Any]:
    changed = copy.deepcopy(document)
    *parents, last = path.split(".")
    section = changed
    for parent in parents:
        section = section[parent]
    section[last] = value
    return changed


@pytest.mark.parametrize(
    ("path", "value", "reason"),
    [
        ("plant.inertia", "6/200", "canonical form"),
        ("plant.inertia", "0.03", "canonical form"),
        ("plant.inertia", "0.03 kg·m²", "canonical form"),
        ("impedance.inertia", "nominal", "canonical form"),
        ("controller.order", "4", "canonical form"),
        ("plant.stiffness", 0, "canonical form"),
        ("plant.inertia", 0.03, "expected exact text; found 0.03"),
        ("plant.inertia", True, "expected exact text; found True"),
        ("robimp", True, "expected exact text; found True"),
        ("plant.inertia", "-1", "an inertia > 0"),
        ("plant.inertia", "1" * 2001 + "/1", "at most 2000 digits"),
        ("plant.mass", "1", "unknown key"),
        ("plant", None, "expected a section"),
        ("constraints.eq9", [], "expected a section"),
    ],
)
def test_what_is_not_canonical_is_refused(path: str, value: object, reason: str, good: str) -> None:
    document = canonical(parse_spec(good))
    with pytest.raises(InputError, match=reason):
        from_canonical(change(document, path, value))
    assert from_canonical(change(document, "name", "other")).name == "other"


def test_a_missing_absent_option_is_not_canonical(good: str) -> None:
    document = canonical(parse_spec(good))
    del document["uncertainty"]["weight"]  # type: ignore[attr-defined]
    with pytest.raises(InputError, match="canonical form"):
        from_canonical(document)


def test_an_endless_nest_is_refused() -> None:
    nest: dict[str, object] = {}
    for _ in range(5000):
        nest = {"a": nest}
    with pytest.raises(InputError, match="nested levels"):
        from_canonical(nest)
