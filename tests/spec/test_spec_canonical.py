"""The canonical form: one text for one meaning, and a valid specification itself."""

from __future__ import annotations

import copy
import hashlib
import json
import re
from collections.abc import Callable, Iterator
from fractions import Fraction
from typing import Any

import pytest

from robimp.synthesis.errors import InputError
from robimp.synthesis.spec import canonical, canonical_json, from_canonical, number_text, parse_spec, spec_sha256

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


@pytest.mark.parametrize("pairs", [(), EVERYTHING], ids=["good", "everything"])
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
    assert len(texts) > 25
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
