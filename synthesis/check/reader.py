"""Bytes to a certificate: limits first, then JSON without its ambiguities, then every field of the format."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Callable
from fractions import Fraction
from math import gcd
from typing import Any

from .outcome import UnreadableError

MAX_BYTES, MAX_DIGITS, MAX_DEGREE, MAX_CLAIMS, MAX_DEPTH = 4_000_000, 2_000, 100, 64, 12
NUMBER = re.compile(r"(-?(?:0|[1-9][0-9]*))(?:/([1-9][0-9]*))?")
STRUCTURE = re.compile(rb'"(?:[^"\\]|\\.)*"|[\[\]{}]', re.DOTALL)

Field = Callable[[Any, str], Any]  # (JSON value, path) → meaning, or UnreadableError


def read(data: bytes) -> dict[str, Any]:
    """Certificate with every number text as a Fraction ("inf" as None) and every list of polynomial coefficients ascending.

    Raises:
        UnreadableError: one line that names the field.
    """
    raw = _json(data)
    certificate: dict[str, Any] = CERTIFICATE(raw, "certificate")
    body = {key: part for key, part in raw.items() if key != "end"}
    _digest(raw["spec"], raw["spec_sha256"], "spec_sha256")
    _digest(body, raw["end"]["body_sha256"], "end.body_sha256")
    if raw["end"]["claims"] != len(raw["claims"]):
        raise UnreadableError(f"end.claims: says {raw['end']['claims']}, there are {len(raw['claims'])}")
    return certificate


def canonical_json(value: object) -> bytes:
    """The bytes a digest is taken of: sorted keys, no spaces, ASCII."""
    text = json.dumps(value, sort_keys=True, separators=(",", ":"), ensure_ascii=True, allow_nan=False)
    return text.encode("ascii")


def _digest(value: object, expected: str, path: str) -> None:
    if hashlib.sha256(canonical_json(value)).hexdigest() != expected:
        raise UnreadableError(f"{path}: the digest does not match the content")


def _json(data: bytes) -> Any:
    if len(data) > MAX_BYTES:
        raise UnreadableError(f"file: more than {MAX_BYTES} bytes")
    depth = 0
    for match in STRUCTURE.finditer(data):
        depth += {b"[": 1, b"{": 1, b"]": -1, b"}": -1}.get(match[0], 0)
        if depth > MAX_DEPTH:
            raise UnreadableError(f"file: nested deeper than {MAX_DEPTH}")
    try:
        return json.loads(
            data.decode("utf-8"),
            object_pairs_hook=_object,
            parse_int=_integer,
            parse_float=_no_float,
            parse_constant=_no_float,
        )
    except UnicodeDecodeError as error:
        raise UnreadableError(f"file: not UTF-8 at byte {error.start}") from None
    except json.JSONDecodeError as error:
        raise UnreadableError(f"file: not JSON: {error.msg} at line {error.lineno} column {error.colno}") from None


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) < len(pairs):
        keys = [key for key, _ in pairs]
        raise UnreadableError(f"file: duplicate key {_quoted(next(k for k in keys if keys.count(k) > 1))}")
    return found


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


def _kind(kind: type, name: str) -> Field:
    def field(value: Any, path: str) -> Any:
        if type(value) is not kind:
            raise UnreadableError(f"{path}: expected {name}, got {_quoted(value)}")
        return value

    return field


def _choice(*choices: object) -> Field:
    def field(value: Any, path: str) -> Any:
        if not any(type(value) is type(choice) and value == choice for choice in choices):
            raise UnreadableError(f"{path}: expected one of {', '.join(map(repr, choices))}, got {_quoted(value)}")
        return value

    return field


def _optional(inner: Field) -> Field:
    return lambda value, path: None if value is None else inner(value, path)


def _many(inner: Field, least: int = 0, most: int = MAX_BYTES) -> Field:
    def field(value: Any, path: str) -> Any:
        if type(value) is not list or not least <= len(value) <= most:
            raise UnreadableError(f"{path}: expected a list of {least} to {most} entries")
        return [inner(entry, f"{path}[{k}]") for k, entry in enumerate(value)]

    return field


def _record(optional: tuple[str, ...] = (), /, **fields: Field) -> Field:
    """Exactly these keys; the `optional` ones may be absent, which means null."""

    def field(value: Any, path: str) -> Any:
        _kind(dict, "an object")(value, path)
        for key in value:
            if key not in fields:
                raise UnreadableError(f"{path}: unknown field {_quoted(key)}")
        for key in fields:
            if key not in value and key not in optional:
                raise UnreadableError(f"{path}.{key}: missing")
        return {key: inner(value.get(key), f"{path}.{key}") for key, inner in fields.items()}

    return field


def _tagged(**variants: Field) -> Field:
    """An object whose "type" says which record it is."""

    def field(value: Any, path: str) -> Any:
        _kind(dict, "an object")(value, path)
        return variants[_choice(*variants)(value.get("type"), f"{path}.type")](value, path)

    return field


def number(value: Any, path: str) -> Fraction:
    """Canonical number text `p` or `p/q`."""
    match = NUMBER.fullmatch(TEXT(value, path))
    if match is None:
        raise UnreadableError(f"{path}: {_quoted(value)} is not a canonical number")
    if any(len(part or "") > MAX_DIGITS for part in match.groups()):
        raise UnreadableError(f"{path}: more than {MAX_DIGITS} digits")
    try:
        p, q = int(match[1]), int(match[2] or 1)
    except ValueError:
        raise UnreadableError(f"{path}: more digits than this Python accepts") from None
    if gcd(p, q) != 1 or (match[2] and q == 1) or match[1] == "-0":
        raise UnreadableError(f"{path}: {_quoted(value)} is not in lowest terms")
    return Fraction(p, q)


def _at_least_zero(value: Any, path: str) -> Fraction:
    found = number(value, path)
    if found < 0:
        raise UnreadableError(f"{path}: negative")
    return found


def _above_zero(value: Any, path: str) -> Fraction:
    found = number(value, path)
    if found <= 0:
        raise UnreadableError(f"{path}: must be positive")
    return found


def _frequency(value: Any, path: str) -> Fraction | None:
    return None if value == "inf" else _at_least_zero(value, path)


def _position(value: Any, path: str) -> Any:
    return value if value == "none" else _above_zero(value, path)


def _interval(inner: Field) -> Field:
    def field(value: Any, path: str) -> Any:
        lo, hi = _many(inner, 2, 2)(value, path)
        if lo is None or (hi is not None and lo > hi):
            raise UnreadableError(f"{path}: the ends are not in order")
        return lo, hi

    return field


def _coefficients(value: Any, path: str) -> Any:
    ascending = tuple(_many(number, 1, MAX_DEGREE + 1)(value, path)[::-1])
    common = 1
    for entry in ascending:
        common = common // gcd(common, entry.denominator) * entry.denominator
        if common.bit_length() > MAX_DIGITS * 3.33:
            raise UnreadableError(f"{path}: the common denominator has more than {MAX_DIGITS} digits")
    return ascending


def _denominator(value: Any, path: str) -> Any:
    found = _coefficients(value, path)
    if not any(found):
        raise UnreadableError(f"{path}: zero denominator")
    return found


TEXT = _kind(str, "a text")
RATIONAL = _record(numerator=_coefficients, denominator=_denominator)
BAND = _interval(_frequency)
RANGE = _interval(_at_least_zero)
LOAD = _record(inertia=_at_least_zero, damping=_at_least_zero, stiffness=_at_least_zero)

SPEC = _record(
    robimp=_choice(1),
    name=TEXT,
    motion=_choice("rotary", "linear"),
    plant=_record(inertia=_above_zero, damping=_at_least_zero, stiffness=_at_least_zero),
    uncertainty=_record(
        ("box", "weight"),
        box=_optional(_record(inertia=RANGE, damping=RANGE, stiffness=RANGE)),
        weight=_optional(RATIONAL),
    ),
    actuator=_tagged(
        **{
            "ideal": _record(type=TEXT),
            "series-elastic": _record(
                type=TEXT,
                motor_inertia=_above_zero,
                motor_damping=_at_least_zero,
                spring_stiffness=_above_zero,
                torque_loop=_record(
                    kp=_at_least_zero, kd=_at_least_zero, derivative_corner=_above_zero, feedforward=number
                ),
            ),
        }
    ),
    impedance=LOAD,
    controller=_record(
        ("order", "form", "coefficients", "filters"),
        type=_choice("dob", "dynamic-feedback"),
        order=_optional(_kind(int, "an integer")),
        form=_choice(None, "eq23"),
        coefficients=_optional(RATIONAL),
        filters=_optional(
            _record(
                ("force", "position", "derivative"),
                force=_optional(_above_zero),
                position=_optional(_position),
                derivative=_optional(_above_zero),
            )
        ),
    ),
    objective=_record(
        ("rendering_error",),
        maximize=_choice("bandwidth"),
        attenuation=_above_zero,
        rendering_error=_optional(_above_zero),
    ),
    constraints=_record(
        ("eq9", "eq12", "eq18", "peak"),
        eq9=_optional(_record()),
        eq12=_optional(
            _record(
                ("band",),
                form=_choice("paper", "disc", "structured"),
                band=_optional(BAND),
                margin=_at_least_zero,
            )
        ),
        eq18=_optional(_record(form=_choice("paper", "lumped", "half-plane"), coupling=_choice("frozen", "physical"))),
        peak=_optional(_above_zero),
        friction=_choice("report", "require"),
    ),
)

CLAIM = _record(
    id=TEXT,
    equation=TEXT,
    form=TEXT,
    interval=BAND,
    statement=TEXT,
    uncertainty=TEXT,
    required=_kind(bool, "true or false"),
    status=_choice("proven", "refuted", "undecided"),
    margin=_optional(number),
    refuted_at=_optional(
        _record(
            value=number,
            omega=lambda value, path: None if value is None else (_frequency(value, path),),
            load=_optional(LOAD),
        )
    ),
    hints=_kind(dict, "an object"),
)

CERTIFICATE = _record(
    robimp_certificate=_choice(1),
    spec=SPEC,
    spec_sha256=TEXT,
    controller=_tagged(
        **{"dob": _record(type=TEXT, Q=RATIONAL, C=RATIONAL), "dynamic-feedback": _record(type=TEXT, C=RATIONAL)}
    ),
    bandwidth=_record(proven=_at_least_zero, refuted_at=_optional(_at_least_zero), bound=_optional(_at_least_zero)),
    claims=_many(CLAIM, 0, MAX_CLAIMS),
    assumptions=_many(TEXT),
    not_claimed=_many(TEXT),
    producer=lambda value, path: {k: TEXT(v, path) for k, v in _kind(dict, "an object")(value, path).items()},
    end=_record(claims=_kind(int, "an integer"), body_sha256=TEXT),
)
