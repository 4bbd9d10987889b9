"""Every field of the format: what may be null, absent, zero or negative; and each limit, at it and one beyond."""

from __future__ import annotations

import copy
import json
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest
from certificate_builder import claim, data, dob, seal, spec
from claim_floats import Json

from robimp.synthesis.check.outcome import CheckError
from robimp.synthesis.check.reader import canonical_json, read

RATIONAL: Json = {"numerator": ["2"], "denominator": ["3"]}
LOAD: Json = {"inertia": "1/2", "damping": "1/3", "stiffness": "1/4"}
WITNESS: Json = {
    "value": "1/2",
    "omega": "3",
    "load": LOAD,
    "impedance": LOAD,
    "actuator": {"motor_inertia": "1/2", "motor_damping": "1/3", "spring_stiffness": "1/4"},
    "controller": RATIONAL,
    "claim": ["peak"],
}


def full(**changes: Any) -> Json:
    """A certificate with every field that there is; what it says is nonsense, which is not the reader's business."""
    box = {"inertia": ["1/2", "2"], "damping": ["1/2", "2"], "stiffness": ["1/2", "2"]}
    measured = {
        "files": [{"name": "a", "sha256": "b"}],
        "records": 7,
        "excluded": ["c"],
        "amplitude": ["1/2", "2"],
    }
    motor = {"motor_inertia": ["1/2", "2"], "motor_damping": ["1/2", "2"], "spring_stiffness": ["1/2", "2"]}
    s = spec(
        sampling={"rate": "100", "delay": "1/100"},
        uncertainty={
            "box": box,
            "weight": RATIONAL,
            "table": {"points": [["1/2", "1/3"], ["2", "1/3"]], "beyond": "hold", "measured": measured},
            "actuator": motor,
        },
        impedance={"inertia": "1/2", "damping": "1/3", "stiffness": ["1/4", "2"]},
        controller={
            "order": 4,
            "form": "eq23",
            "coefficients": RATIONAL,
            "filters": {"force": "5", "position": "6", "derivative": "7"},
        },
        objective={"rendering_error": "1/2"},
        constraints={
            "eq12": {"form": "paper", "band": ["1/2", "2"], "margin": "1/2"},
            "noise": {"gain": "1/2", "above": "1/3"},
            "tolerance": "1/1000",
        },
    )
    body = {
        "robimp_certificate": 1,
        "spec": s,
        "controller": dob(["4"], ["1", "5"]),
        "bandwidth": {"proven": "1/2", "refuted_at": "2", "bound": "3"},
        "claims": [claim("peak", "sensitivity", ["1/2", "2"], "1/2", True, refuted_at=WITNESS)],
        "assumptions": ["x"],
        "not_claimed": ["y"],
        "producer": {"name": "z"},
    }
    return seal(json.loads(json.dumps({**body, **changes})))  # nothing in it twice


FULL = full()
PORT = {**FULL["spec"], "actuator": {"type": "two-port", "transfer": RATIONAL, "impedance": RATIONAL}}
FEEDBACK: Json = {"type": "dynamic-feedback", "C": RATIONAL}
TWO_PORT = full(spec=PORT, controller=FEEDBACK)


def places(value: Json, path: str = "certificate") -> Iterator[tuple[str, Json, Any]]:
    """Every field, and the first of every list: its path, what holds it, and its key there."""
    for key in value if isinstance(value, dict) else [0] if isinstance(value, list) and value else []:
        inner = f"{path}[0]" if key == 0 else f"{path}.{key}"
        yield inner, value, key
        yield from places(value[key], inner)


def complaint(cert: Json) -> str:
    """What the reader says of a certificate; nothing if it reads it."""
    try:
        read(json.dumps(cert).encode())
    except CheckError as error:
        assert error.code == 2
        return str(error)
    return ""


@contextmanager
def replaced(holder: Json, key: Any, *value: Any) -> Iterator[None]:
    """Another value in one place for a while, or none."""
    before = holder.pop(key)
    if isinstance(holder, list):
        holder[key:key] = value
    elif value:
        holder[key] = value[0]
    yield
    if value:
        holder.pop(key)
    holder.insert(key, before) if isinstance(holder, list) else holder.update({key: before})


SPEC, CLAIM = "certificate.spec", "certificate.claims[0]"
WITNESSED, NULL_ONLY = f"{CLAIM}.refuted_at", {"certificate.bandwidth.refuted_at", "certificate.bandwidth.bound"}
NULL_ONLY |= {f"{CLAIM}.margin", f"{CLAIM}.refuted_at", f"{WITNESSED}.omega", f"{WITNESSED}.load"}
NULL_OR_ABSENT = {f"{SPEC}.sampling", f"{SPEC}.objective.rendering_error", f"{SPEC}.constraints.eq12.band"}
NULL_OR_ABSENT |= {f"{SPEC}.uncertainty.{key}" for key in ("box", "weight", "table", "actuator")}
NULL_OR_ABSENT |= {f"{SPEC}.controller.{key}" for key in ("order", "form", "coefficients", "filters")}
NULL_OR_ABSENT |= {f"{SPEC}.controller.filters.{key}" for key in ("force", "position", "derivative")}
NULL_OR_ABSENT |= {f"{SPEC}.constraints.{key}" for key in ("eq9", "eq12", "eq18", "peak", "noise", "tolerance")}
NULL_OR_ABSENT |= {f"{SPEC}.constraints.noise.above"}
NULL_OR_ABSENT |= {f"{WITNESSED}.{key}" for key in ("impedance", "actuator", "controller", "claim")}
ABSENT_ONLY = {f"{SPEC}.uncertainty.table.measured", f"{SPEC}.uncertainty.table.measured.amplitude"}
ABSENT_ONLY |= {f"{SPEC}.uncertainty.actuator.{k}" for k in ("motor_inertia", "motor_damping", "spring_stiffness")}
SHARE = [  # a quarter of the fields at a time
    pytest.param(cert, part, id=f"{name} {part + 1}/4")
    for name, cert in (("full", FULL), ("two-port", TWO_PORT))
    for part in range(4)
]
FREE = {"certificate.producer.name"}  # of any number and name


@pytest.mark.parametrize(("whole", "part"), SHARE)
def test_a_field_is_null_only_where_the_format_says_so(whole: Json, part: int) -> None:
    cert = copy.deepcopy(whole)
    for path, holder, key in [*places(cert)][part::4]:
        with replaced(holder, key, None):
            if path in NULL_ONLY | NULL_OR_ABSENT:
                assert complaint(seal(cert)) == "", path
            else:
                assert complaint(cert).startswith("certificate.producer:" if path in FREE else path), path
    assert cert == whole


@pytest.mark.parametrize(("whole", "part"), SHARE)
def test_a_field_is_absent_only_where_the_format_says_so(whole: Json, part: int) -> None:
    cert = copy.deepcopy(whole)
    for path, holder, key in [*places(cert)][part::4]:
        with replaced(holder, key):
            if path in NULL_OR_ABSENT | ABSENT_ONLY | FREE:
                assert complaint(seal(cert)) == "", path
            elif isinstance(holder, dict):
                assert complaint(cert).startswith(path), path


def test_an_absent_field_reads_as_null() -> None:
    cert = copy.deepcopy(FULL)
    del cert["spec"]["objective"]["rendering_error"]
    assert read(data(seal(cert)))["spec"]["objective"]["rendering_error"] is None
    plain = read(data(full(spec=spec())))["spec"]
    assert plain["sampling"] is None and plain["constraints"]["tolerance"] is None


POSITIVE = {f"{SPEC}.plant.inertia", f"{SPEC}.sampling.rate", f"{SPEC}.objective.attenuation"}
POSITIVE |= {f"{SPEC}.objective.rendering_error", f"{SPEC}.constraints.peak", f"{SPEC}.constraints.tolerance"}
POSITIVE |= {f"{SPEC}.actuator.{key}" for key in ("motor_inertia", "spring_stiffness", "torque_loop.derivative_corner")}
POSITIVE |= {f"{SPEC}.controller.filters.{key}" for key in ("force", "position", "derivative")}
POSITIVE |= {f"{SPEC}.constraints.noise.gain"}
POSITIVE |= {
    f"{SPEC}.uncertainty.{key}[0]" for key in ("box.inertia", "actuator.motor_inertia", "actuator.spring_stiffness")
}
POSITIVE |= {f"{path[:-3]}[1]" for path in POSITIVE if path.endswith("[0]")}
SIGNED = {f"{CLAIM}.margin", f"{WITNESSED}.value", f"{SPEC}.actuator.torque_loop.feedforward"}
SIGNED |= {f"{WITNESSED}.{place}.{key}" for place in ("load", "impedance") for key in LOAD}
SIGNED |= {f"{WITNESSED}.actuator.{key}" for key in ("motor_inertia", "motor_damping", "spring_stiffness")}


@pytest.mark.parametrize("value", ["0", "-1/2", "-1", "1/1000"])
@pytest.mark.parametrize(("whole", "part"), SHARE)
def test_a_number_is_zero_or_negative_only_where_it_may_be(whole: Json, part: int, value: str) -> None:
    cert = copy.deepcopy(whole)
    for path, holder, key in [*places(cert)][part::4]:
        before, coefficient = holder[key], path.endswith(("numerator[0]", "denominator[0]"))
        if not (isinstance(before, str) and before.strip("/0123456789") == "" and "sha256" not in path):
            continue
        rule = "must be positive" if path in POSITIVE and value in ("0", "-1/2", "-1") else ""
        rule = rule or ("" if coefficient or path in SIGNED or value[0] != "-" else "must not be negative")
        rule = "zero denominator" if value == "0" and path.endswith("denominator[0]") and len(holder) == 1 else rule
        with replaced(holder, key, value):
            said = complaint(cert if rule else seal(cert))
        assert said.endswith(f": {rule}") if rule else said == "", path


def with_interval(interval: Json) -> Json:
    return full(claims=[claim("peak", "sensitivity", interval, "2", True)])


def with_spec(section: str, key: str, value: Json) -> Json:
    return full(spec={**FULL["spec"], section: {**FULL["spec"][section], key: value}})


def with_table(points: Json) -> Json:
    return with_spec("uncertainty", "table", {"points": points, "beyond": "hold"})


def with_denominator(coefficients: list[str]) -> Json:
    return full(controller={"type": "dynamic-feedback", "C": {"numerator": ["1"], "denominator": coefficients}})


def with_hints(hints: Json) -> Json:
    return full(claims=[claim("peak", "sensitivity", ["0", "1"], "2", True, hints=hints)])


def nested(kind: str, levels: int) -> Json:
    """So many lists or objects inside one another."""
    value: Json = [] if kind == "lists" else {}
    for _ in range(levels - 1):
        value = [value] if kind == "lists" else {"a": value}
    return value


def rows(count: int) -> Json:
    return [[str(k), "1/2"] for k in range(count)]


HINTS = 4  # levels down to the hints of a claim, which may be anything
READ: dict[str, Json] = {
    "an interval of one point": with_interval(["1", "1"]),
    "up to infinity": with_interval(["1", "inf"]),
    "2,000 digits": with_spec("plant", "damping", "1" * 2000),
    "2,000 digits below": with_spec("plant", "damping", "1/1" + "0" * 1999),
    "101 coefficients": with_denominator(["1"] * 101),
    "a common denominator of 2,000 digits": with_denominator([f"1/{2**1999}", f"1/{5**1999}"]),
    "a zero among the coefficients": with_denominator(["0", "1"]),
    "64 claims": full(claims=FULL["claims"] * 64),
    "no claims": full(claims=[]),
    "one point": with_table(rows(1)),
    "1,000 points": with_table(rows(1000)),
    "an order of nine digits": with_spec("controller", "order", 999_999_999),
    "a filter that is absent on purpose": with_spec("controller", "filters", {"position": "none"}),
    "12 levels of objects": with_hints({"a": nested("objects", 12 - HINTS)}),
    "12 levels of lists": with_hints({"a": nested("lists", 12 - HINTS)}),
    "many lists and objects next to one another": with_hints({"a": [[]] * 40, "b": [{}] * 40}),
    "brackets in texts": with_hints({"a": "[" * 40 + "{" * 40, "b": '"[[[[[[[[[[[[[', "c": "\\"}),
}
REFUSED: dict[str, tuple[Json, str]] = {
    "from infinity": (with_interval(["inf", "inf"]), "interval: expected [low, high]"),
    "one end": (with_interval(["1"]), "interval: expected [low, high]"),
    "three ends": (with_interval(["1", "2", "3"]), "interval: expected [low, high]"),
    "reversed": (with_interval(["2", "1"]), "interval: expected [low, high]"),
    "2,001 digits": (with_spec("plant", "damping", "1" * 2001), "more than 2000 digits"),
    "2,001 digits below": (with_spec("plant", "damping", "1/1" + "0" * 2000), "more than 2000 digits"),
    "102 coefficients": (with_denominator(["1"] * 102), "expected 1 to 101 coefficients"),
    "no coefficient": (with_denominator([]), "expected 1 to 101 coefficients"),
    "a common denominator of 2,001 digits": (
        with_denominator([f"1/{2**2000}", f"1/{5**2000}"]),
        "the common denominator has more than 2000 digits",
    ),
    "nothing but zeros below": (with_denominator(["0", "0"]), "zero denominator"),
    "65 claims": (full(claims=FULL["claims"] * 65), "claims: more than 64"),
    "no point": (with_table([]), "expected 1 to 1000 pairs"),
    "1,001 points": (with_table(rows(1001)), "expected 1 to 1000 pairs"),
    "a point of one number": (with_table([["1"], ["2", "1"]]), "expected 1 to 1000 pairs"),
    "a point of three numbers": (with_table([["1", "1"], ["2", "1", "1"]]), "expected 1 to 1000 pairs"),
    "the same frequency twice": (with_table([["1", "1"], ["1", "1"]]), "frequencies must increase"),
    "frequencies that fall": (with_table([["1", "1"], ["3", "1"], ["2", "1"]]), "frequencies must increase"),
    "an order of ten digits": (with_spec("controller", "order", 1_000_000_000), "the bare number 1000000000"),
    "a negative order": (with_spec("controller", "order", -1), "the bare number -1"),
    "an order that is true": (with_spec("controller", "order", True), "order: expected int, got True"),
    "1 for true": (full(claims=[claim("peak", "x", ["0", "1"], "2", 1)]), "required: expected bool, got 1"),  # type: ignore[arg-type]
    "no filter of another name": (with_spec("controller", "filters", {"force": "none"}), "not a canonical number"),
    "another version of the specification": (full(spec={**FULL["spec"], "robimp": 0}), "robimp: expected 1, got 0"),
    "another version": (full(robimp_certificate=0), "robimp_certificate: expected 1, got 0"),
    "13 levels of objects": (with_hints({"a": nested("objects", 13 - HINTS)}), "nested deeper than 12"),
    "13 levels of lists": (with_hints({"a": nested("lists", 13 - HINTS)}), "nested deeper than 12"),
    "13 levels after many lists": (with_hints({"a": [[]] * 40, "b": nested("lists", 13 - HINTS)}), "nested deeper"),
    "13 levels after many objects": (with_hints({"a": [{}] * 40, "b": nested("lists", 13 - HINTS)}), "nested deeper"),
    "a wrong digest of the specification": ({**FULL, "spec_sha256": "0"}, "spec_sha256: the digest does not match"),
    "a wrong digest of the whole": ({**FULL, "end": {**FULL["end"], "body_sha256": "0"}}, "body_sha256: the digest"),
    "a claim cut off": ({**FULL, "end": {**FULL["end"], "claims": 2}}, "end.claims: there are 1"),
}


@pytest.mark.parametrize("name", READ)
def test_it_is_read(name: str) -> None:
    assert complaint(READ[name]) == ""


@pytest.mark.parametrize("name", REFUSED)
def test_it_is_refused_with_the_reason(name: str) -> None:
    cert, reason = REFUSED[name]
    assert reason in complaint(cert)


@pytest.mark.parametrize(("size", "refused"), [(4_000_000, False), (4_000_001, True)])
def test_four_million_bytes_are_read_and_not_one_more(size: int, refused: bool) -> None:
    padded = data(FULL).ljust(size)
    if refused:
        with pytest.raises(CheckError, match="file: more than 4000000 bytes"):
            read(padded)
    else:
        assert read(padded)["bandwidth"]["proven"] * 2 == 1


def test_what_is_read() -> None:
    found = read(data(full(claims=[claim("peak", "sensitivity", ["1/2", "inf"], "-3/2", True)])))
    entry, loop = found["claims"][0], found["spec"]["actuator"]["torque_loop"]
    assert entry["interval"] == (0.5, float("inf")) and entry["margin"] == -1.5 and entry["required"] is True
    assert found["controller"]["Q"] == {"numerator": (4,), "denominator": (5, 1)}  # ascending
    assert (loop["kp"], loop["kd"] * 4) == (10, 1) and found["spec"]["controller"]["filters"]["position"] == 6
    assert found["spec"]["uncertainty"]["box"]["damping"] == (0.5, 2) == found["spec"]["constraints"]["eq12"]["band"]
    (low, _), (high, _) = found["spec"]["uncertainty"]["table"]["points"]
    assert (low, high) == (0.5, 2)


def test_a_digest_is_of_what_json_can_say() -> None:
    with pytest.raises(ValueError):
        canonical_json({"a": float("nan")})
