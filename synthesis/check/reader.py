"""Bytes to a certificate: limits first, then JSON without its ambiguities, then every field of the format."""

from __future__ import annotations

import hashlib
import json
import re
from fractions import Fraction
from math import gcd, lcm
from typing import Any

from .outcome import UnreadableError

MAX_BYTES, MAX_DIGITS, MAX_DEGREE, MAX_CLAIMS, MAX_DEPTH = 4_000_000, 2_000, 100, 64, 12
NUMBER = re.compile(r"(-?(?:0|[1-9][0-9]*))(?:/([1-9][0-9]*))?")
STRUCTURE = re.compile(rb'"(?:[^"\\]|\\.)*"|[\[\]{}]', re.DOTALL)


def read(data: bytes) -> dict[str, Any]:
    """Certificate with number texts as Fractions, coefficients ascending, "inf" as None; or UnreadableError."""
    raw = _json(data)
    certificate: dict[str, Any] = _meaning(CERTIFICATE, raw, "certificate")
    body = {key: part for key, part in raw.items() if key != "end"}
    digests = (("spec_sha256", raw["spec"], raw), ("body_sha256", body, raw["end"]))
    for key, content, place in digests:
        if hashlib.sha256(canonical_json(content)).hexdigest() != place[key]:
            raise UnreadableError(f"{key}: the digest does not match the content")
    if raw["end"]["claims"] != len(raw["claims"]):
        raise UnreadableError(f"end.claims: says {raw['end']['claims']}, there are {len(raw['claims'])}")
    if len(raw["claims"]) > MAX_CLAIMS:
        raise UnreadableError(f"claims: more than {MAX_CLAIMS}")
    return certificate


def canonical_json(value: object) -> bytes:
    """The bytes a digest is taken of: sorted keys, no spaces, ASCII."""
    return json.dumps(value, sort_keys=True, separators=(",", ":"), ensure_ascii=True, allow_nan=False).encode("ascii")


def _json(data: bytes) -> Any:
    if len(data) > MAX_BYTES:
        raise UnreadableError(f"file: more than {MAX_BYTES} bytes")
    depth = 0
    for match in STRUCTURE.finditer(data):
        depth += {b"[": 1, b"{": 1, b"]": -1, b"}": -1}.get(match[0], 0)
        if depth > MAX_DEPTH:
            raise UnreadableError(f"file: nested deeper than {MAX_DEPTH}")
    hooks: dict[str, Any] = {"parse_int": _integer, "parse_float": _no_float, "parse_constant": _no_float}
    try:
        return json.loads(data.decode("utf-8"), object_pairs_hook=_object, **hooks)
    except UnicodeDecodeError as error:
        raise UnreadableError(f"file: not UTF-8 at byte {error.start}") from None
    except json.JSONDecodeError as error:
        raise UnreadableError(f"file: not JSON: {error.msg} at line {error.lineno} column {error.colno}") from None


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    keys = [key for key, _ in pairs]
    if len(set(keys)) < len(keys):
        raise UnreadableError(f"file: duplicate key {_quoted(next(k for k in keys if keys.count(k) > 1))}")
    return dict(pairs)


def _integer(text: str) -> int:
    if len(text) > 9:
        raise UnreadableError(f"file: the bare number {text[:9]}... (numbers are text here)")
    return int(text)


def _no_float(text: str) -> Any:
    raise UnreadableError(f"file: the floating-point number {text[:20]} (numbers are text here)")


def _quoted(value: object) -> str:
    """Foreign text for a message: ASCII, one line, short."""
    text = ascii(value)
    return text if len(text) <= 40 else text[:37] + "..."


def _meaning(schema: Any, value: Any, path: str) -> Any:
    """A value by its schema: a type, a tuple of choices, a one-entry list, a record, or a function of (value, path)."""
    if isinstance(schema, dict):
        return _record(schema, value, path)
    if isinstance(schema, list):
        return [_meaning(schema[0], entry, f"{path}[{k}]") for k, entry in enumerate(_meaning(list, value, path))]
    if isinstance(schema, tuple):
        if not any(type(value) is type(choice) and value == choice for choice in schema):
            raise UnreadableError(f"{path}: expected {' or '.join(map(repr, schema))}, got {_quoted(value)}")
        return value
    if isinstance(schema, type):
        if type(value) is not schema:
            raise UnreadableError(f"{path}: expected {schema.__name__}, got {_quoted(value)}")
        return value
    return schema(value, path)


def _record(schema: dict[str, Any], value: Any, path: str) -> dict[str, Any]:
    """Exactly the schema's keys: `key~` may be null, `key?` may be absent too."""
    _meaning(dict, value, path)
    fields = {key.rstrip("~?"): (key[-1], inner) for key, inner in schema.items()}
    for key in value:
        if key not in fields:
            raise UnreadableError(f"{path}: unknown field {_quoted(key)}")
    found = {}
    for key, (mark, inner) in fields.items():
        if key not in value and mark != "?":
            raise UnreadableError(f"{path}.{key}: missing")
        null = value.get(key) is None and mark in "~?"
        found[key] = None if null else _meaning(inner, value[key], f"{path}.{key}")
    return found


def number(value: Any, path: str) -> Fraction:
    """Canonical number text `p` or `p/q`."""
    match = NUMBER.fullmatch(_meaning(str, value, path))
    if match is None:
        raise UnreadableError(f"{path}: {_quoted(value)} is not a canonical number")
    if any(len(part or "") > MAX_DIGITS for part in match.groups()):
        raise UnreadableError(f"{path}: more than {MAX_DIGITS} digits")
    try:
        p, q = int(match[1]), int(match[2] or 1)
    except ValueError:
        raise UnreadableError(f"{path}: more digits than this Python accepts") from None
    if gcd(p, q) != 1 or match[2] == "1" or match[1] == "-0":
        raise UnreadableError(f"{path}: {_quoted(value)} is not in lowest terms")
    return Fraction(p, q)


def _natural(value: Any, path: str, least: str = "not be negative") -> Fraction:
    found = number(value, path)
    if found < 0 or (found == 0 and least == "be positive"):
        raise UnreadableError(f"{path}: must {least}")
    return found


def _positive(value: Any, path: str) -> Fraction:
    return _natural(value, path, "be positive")


def _range(value: Any, path: str) -> tuple[Fraction, Fraction]:
    ends = _meaning([_natural], value, path)
    if len(ends) != 2 or ends[0] > ends[1]:
        raise UnreadableError(f"{path}: expected [low, high]")
    return ends[0], ends[1]


def _band(value: Any, path: str) -> tuple[Fraction, Fraction | None]:
    if type(value) is list and len(value) == 2 and value[1] == "inf":
        return _natural(value[0], path), None
    return _range(value, path)


def _witness(value: Any, path: str) -> tuple[Fraction | None]:
    """A frequency in a tuple of its own: None is infinity there, and no frequency outside."""
    return (None if value == "inf" else _natural(value, path),)


def _coefficients(value: Any, path: str) -> tuple[Fraction, ...]:
    found = tuple(_meaning([number], value, path)[::-1])
    if not 0 < len(found) <= MAX_DEGREE + 1:
        raise UnreadableError(f"{path}: expected 1 to {MAX_DEGREE + 1} coefficients")
    if lcm(*(entry.denominator for entry in found)) >= 10**MAX_DIGITS:
        raise UnreadableError(f"{path}: the common denominator has more than {MAX_DIGITS} digits")
    return found


def _denominator(value: Any, path: str) -> tuple[Fraction, ...]:
    if not any(found := _coefficients(value, path)):
        raise UnreadableError(f"{path}: zero denominator")
    return found


def _variant(**variants: Any) -> Any:
    """A record whose "type" says which."""

    def schema(value: Any, path: str) -> Any:
        kind = _meaning(tuple(variants), _meaning(dict, value, path).get("type"), f"{path}.type")
        return _record({"type": str, **variants[kind]}, value, path)

    return schema


RATIONAL = {"numerator": _coefficients, "denominator": _denominator}
LOAD = {"inertia": _natural, "damping": _natural, "stiffness": _natural}
LOOP = {"kp": _natural, "kd": _natural, "derivative_corner": _positive, "feedforward": number}
SERIES_ELASTIC = {
    "motor_inertia": _positive,
    "motor_damping": _natural,
    "spring_stiffness": _positive,
    "torque_loop": LOOP,
}
FILTERS = {
    "force?": _positive,
    "position?": lambda value, path: value if value == "none" else _positive(value, path),
    "derivative?": _positive,
}
SPEC = {
    "robimp": (1,),
    "name": str,
    "motion": ("rotary", "linear"),
    "plant": {**LOAD, "inertia": _positive},
    "uncertainty": {"box?": dict.fromkeys(LOAD, _range), "weight?": RATIONAL},
    "actuator": _variant(**{"ideal": {}, "series-elastic": SERIES_ELASTIC}),
    "impedance": LOAD,
    "controller": {
        "type": ("dob", "dynamic-feedback"),
        "order?": int,
        "form?": ("eq23",),
        "coefficients?": RATIONAL,
        "filters?": FILTERS,
    },
    "objective": {"maximize": ("bandwidth",), "attenuation": _positive, "rendering_error?": _positive},
    "constraints": {
        "eq9?": {},
        "eq12?": {"form": ("paper", "disc", "structured"), "band?": _band, "margin": _natural},
        "eq18?": {"form": ("paper", "lumped", "half-plane"), "coupling": ("frozen", "physical")},
        "peak?": _positive,
        "friction": ("report", "require"),
    },
}
CLAIM = {
    **dict.fromkeys(("id", "equation", "form", "statement", "uncertainty"), str),
    "interval": _band,
    "required": bool,
    "status": ("proven", "refuted", "undecided"),
    "margin~": number,
    "refuted_at~": {"value": number, "omega~": _witness, "load~": LOAD},
    "hints": dict,
}
CERTIFICATE = {
    "robimp_certificate": (1,),
    "spec": SPEC,
    "spec_sha256": str,
    "controller": _variant(**{"dob": {"Q": RATIONAL, "C": RATIONAL}, "dynamic-feedback": {"C": RATIONAL}}),
    "bandwidth": {"proven": _natural, "refuted_at~": _natural, "bound~": _natural},
    "claims": [CLAIM],
    "assumptions": [str],
    "not_claimed": [str],
    "producer": lambda value, path: [_meaning(str, v, path) for v in _meaning(dict, value, path).values()],
    "end": {"claims": int, "body_sha256": str},
}
