"""Bytes to a certificate: limits first, then JSON without its ambiguities, then every field of the format."""

import hashlib
import json
import re
from collections.abc import Callable
from fractions import Fraction
from functools import partial
from itertools import accumulate, pairwise
from math import inf, lcm
from typing import Any

from .outcome import UNREADABLE, CheckError, demand

MAX_BYTES, MAX_DIGITS, MAX_DEGREE, MAX_CLAIMS, MAX_POINTS, MAX_DEPTH = 4_000_000, 2_000, 100, 64, 1_000, 12
NUMBER = re.compile(r"(-?(?:0|[1-9][0-9]*))(?:/([1-9][0-9]*))?")
# Forms of a controller: the most zeros, the least and most poles, and whether one of the poles is 0.
FORMS = {"eq23": (0, 2, 2, False), "p": (0, 0, 0, False), "pi": (1, 1, 1, True)}
FORMS |= {"lead-lag": (1, 0, 1, False), "pi-lead": (2, 1, 2, True)}
FORMS |= {f"{k}-filtered": (z, low + 1, high + 1, i) for k, (z, low, high, i) in FORMS.items() if k != "eq23"}
STRUCTURE = re.compile(rb'"(?:[^"\\]|\\.)*"?|[\[\]{}]', re.DOTALL)  # a string without end is one match, too


def read(data: bytes) -> dict[str, Any]:
    """Certificate with number texts as Fractions, coefficients ascending, "inf" as a float; or CheckError."""
    demand(len(data) <= MAX_BYTES, f"file: more than {MAX_BYTES} bytes")
    steps = ({b"[": 1, b"{": 1, b"]": -1, b"}": -1}.get(match[0], 0) for match in STRUCTURE.finditer(data))
    demand(all(depth <= MAX_DEPTH for depth in accumulate(steps)), f"file: nested deeper than {MAX_DEPTH}")
    bare: dict[str, Any] = dict.fromkeys(("parse_int", "parse_float", "parse_constant"), _bare_number)
    try:
        raw = json.loads(data.decode("utf-8"), object_pairs_hook=_object, **bare)
    except ValueError as error:
        raise CheckError(UNREADABLE, f"file: not JSON in UTF-8: {error}") from None
    certificate: dict[str, Any] = _meaning(CERTIFICATE, raw, "certificate")
    body = {key: part for key, part in raw.items() if key != "end"}
    for key, content, place in (("spec_sha256", raw["spec"], raw), ("body_sha256", body, raw["end"])):
        digest = hashlib.sha256(canonical_json(content)).hexdigest()
        demand(digest == place[key], f"{key}: the digest does not match the content")
    demand(raw["end"]["claims"] == len(raw["claims"]), f"end.claims: there are {len(raw['claims'])}")
    demand(len(raw["claims"]) <= MAX_CLAIMS, f"claims: more than {MAX_CLAIMS}")
    return certificate


def canonical_json(value: object) -> bytes:
    """The bytes a digest is taken of: sorted keys, no spaces, ASCII."""
    return json.dumps(value, sort_keys=True, separators=(",", ":"), ensure_ascii=True, allow_nan=False).encode("ascii")


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for key, value in pairs:
        demand(key not in found, f"file: duplicate key {key!a:.40}")
        found[key] = value
    return found


def _bare_number(text: str) -> int:
    demand(text.isdecimal() and len(text) < 10, f"file: the bare number {text[:20]} (numbers are text here)")
    return int(text)


def _meaning(schema: Any, value: Any, path: str) -> Any:
    """A value by its schema: a record, a one-entry list, a type, a tuple of choices, a function of (value, path)."""
    if isinstance(schema, dict):
        return _record(schema, _meaning(dict, value, path), path)
    if isinstance(schema, list):
        return [_meaning(schema[0], entry, f"{path}[{k}]") for k, entry in enumerate(_meaning(list, value, path))]
    if not isinstance(schema, type | tuple):
        return schema(value, path)
    choices = schema if isinstance(schema, tuple) else ()
    fits = type(value) is schema or any(type(value) is type(choice) and value == choice for choice in choices)
    if not fits:  # only now: the text of a large value takes time
        expected = schema.__name__ if isinstance(schema, type) else " or ".join(map(repr, schema))
        raise CheckError(UNREADABLE, f"{path}: expected {expected}, got {value!a:.40}")
    return value


def _record(schema: dict[str, Any], value: dict[str, Any], path: str) -> dict[str, Any]:
    """Exactly the schema's keys: `key~` may be null, `key?` absent too, `key-` only absent; "type" may choose."""
    if isinstance(variants := schema.get("type"), dict):
        kind = _meaning(tuple(variants), value.get("type"), f"{path}.type")
        schema = {"type": str, **variants[kind]}
    fields = {key.rstrip("~?-"): (key[-1], inner) for key, inner in schema.items()}
    for key in value:
        demand(key in fields, f"{path}: unknown field {key!a:.40}")
    found = {}
    for key, (mark, inner) in fields.items():
        demand(key in value or mark in "?-", f"{path}.{key}: missing")
        if key in value or mark == "?":
            null = value.get(key) is None and mark in "~?"
            found[key] = None if null else _meaning(inner, value[key], f"{path}.{key}")
    return found


def number(value: Any, path: str, sign: str = "") -> Fraction:
    """Canonical number text `p` or `p/q`."""
    match = NUMBER.fullmatch(_meaning(str, value, path))
    p, q = match.groups("1") if match else ("", "")
    demand(p != "", f"{path}: {value!a:.40} is not a canonical number")
    demand(max(len(p), len(q)) <= MAX_DIGITS, f"{path}: more than {MAX_DIGITS} digits")
    try:
        found = Fraction(int(p), int(q))
    except ValueError:
        raise CheckError(UNREADABLE, f"{path}: more digits than this Python accepts") from None
    demand(str(found) == value, f"{path}: {value!a:.40} is not in lowest terms")
    demand(sign == "" or found > 0 or (found == 0 and sign != "be positive"), f"{path}: must {sign}")
    return found


NATURAL, POSITIVE = partial(number, sign="not be negative"), partial(number, sign="be positive")


def _or(word: str, meaning: Any, schema: Any, value: Any, path: str) -> Any:
    return meaning if value == word else schema(value, path)


FREQUENCY, POSITION = partial(_or, "inf", inf, NATURAL), partial(_or, "none", "none", POSITIVE)


def _interval(value: Any, path: str, end: Callable[[Any, str], Any] = FREQUENCY) -> tuple[Any, Any]:
    ends = _meaning([end], value, path)
    demand(len(ends) == 2 and ends[0] <= ends[1] and ends[0] != inf, f"{path}: expected [low, high]")
    return ends[0], ends[1]


def _coefficients(value: Any, path: str, nonzero: bool = False) -> tuple[Fraction, ...]:
    found = tuple(_meaning([number], value, path)[::-1])
    demand(0 < len(found) <= MAX_DEGREE + 1, f"{path}: expected 1 to {MAX_DEGREE + 1} coefficients")
    common = lcm(*(entry.denominator for entry in found))
    demand(common < 10**MAX_DIGITS, f"{path}: the common denominator has more than {MAX_DIGITS} digits")
    demand(any(found) or not nonzero, f"{path}: zero denominator")
    return found


def _number_or(schema: Any, value: Any, path: str) -> Any:
    return schema(value, path) if isinstance(value, list) else NATURAL(value, path)


def _points(value: Any, path: str) -> list[list[Fraction]]:
    found = _meaning([[NATURAL]], value, path)
    pairs = 0 < len(found) <= MAX_POINTS and all(len(point) == 2 for point in found)
    demand(pairs, f"{path}: expected 1 to {MAX_POINTS} pairs")
    demand(all(a[0] < b[0] for a, b in pairwise(found)), f"{path}: frequencies must increase")
    return found  # type: ignore[no-any-return]


RANGE, POSITIVE_RANGE = partial(_interval, end=NATURAL), partial(_interval, end=POSITIVE)
RATIONAL = {"numerator": _coefficients, "denominator": partial(_coefficients, nonzero=True)}
LOAD = {"inertia": NATURAL, "damping": NATURAL, "stiffness": NATURAL}
LOOP = {"kp": NATURAL, "kd": NATURAL, "derivative_corner": POSITIVE, "feedforward": number}
MOTOR = {"motor_inertia": POSITIVE, "motor_damping": NATURAL, "spring_stiffness": POSITIVE, "torque_loop": LOOP}
MEASURED = {"files": [{"name": str, "sha256": str}], "records": int, "excluded": [str], "amplitude-": RANGE}
SPEC = {
    "robimp": (1,),
    "name": str,
    "motion": ("rotary", "linear"),
    "plant": {**LOAD, "inertia": POSITIVE},
    "sampling?": {"rate": POSITIVE, "delay": NATURAL},
    "uncertainty": {
        "box?": dict.fromkeys(LOAD, RANGE) | {"inertia": POSITIVE_RANGE},
        "weight?": RATIONAL,
        "table?": {"points": _points, "beyond": ("hold",), "measured-": MEASURED},
        "actuator?": {"motor_inertia-": POSITIVE_RANGE, "motor_damping-": RANGE, "spring_stiffness-": POSITIVE_RANGE},
    },
    "actuator": {
        "type": {"ideal": {}, "series-elastic": MOTOR, "two-port": {"transfer": RATIONAL, "impedance": RATIONAL}}
    },
    "impedance": dict.fromkeys(LOAD, partial(_number_or, RANGE)),
    "controller": {
        "type": ("dob", "dynamic-feedback"),
        "order?": int,
        "form?": tuple(FORMS),
        "coefficients?": RATIONAL,
        "filters?": {"force?": POSITIVE, "position?": POSITION, "derivative?": POSITIVE},
    },
    "objective": {"maximize": ("bandwidth",), "attenuation": POSITIVE, "rendering_error?": POSITIVE},
    "constraints": {
        "eq9?": {},
        "eq12?": {"form": ("paper", "disc", "structured"), "band?": _interval, "margin": NATURAL},
        "eq18?": {"form": ("paper", "lumped", "half-plane"), "coupling": ("frozen", "physical")},
        "peak?": POSITIVE,
        "noise?": {"gain": POSITIVE, "above?": NATURAL},
        "tolerance?": POSITIVE,
        "friction": ("report", "require"),
    },
}
CLAIM = {
    **dict.fromkeys(("id", "equation", "form", "statement", "uncertainty"), str),
    "interval": _interval,
    "required": bool,
    "status": ("proven", "refuted", "undecided"),
    "margin~": number,
    "refuted_at~": {
        "value": number,
        "omega~": FREQUENCY,
        "load~": dict.fromkeys(LOAD, number),
        "impedance?": dict.fromkeys(LOAD, number),
        "actuator?": {"motor_inertia": number, "motor_damping": number, "spring_stiffness": number},
        "controller?": RATIONAL,
        "claim?": [str],
    },
    "hints": dict,
}
CERTIFICATE = {
    "robimp_certificate": (1,),
    "spec": SPEC,
    "spec_sha256": str,
    "controller": {"type": {"dob": {"Q": RATIONAL, "C": RATIONAL}, "dynamic-feedback": {"C": RATIONAL}}},
    "bandwidth": {"proven": NATURAL, "refuted_at~": NATURAL, "bound~": NATURAL},
    "claims": [CLAIM],
    "assumptions": [str],
    "not_claimed": [str],
    "producer": lambda value, path: [_meaning(str, v, path) for v in _meaning(dict, value, path).values()],
    "end": {"claims": int, "body_sha256": str},
}
