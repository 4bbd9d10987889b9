"""The controller in use, from a file of its own: its exact coefficients, compared with a certificate's.

{"numerator": […], "denominator": […]} of Q or of C, {"Q": {…}} and/or {"C": {…}}, or a certificate; coefficients in
descending powers of s [rad/s], JSON numbers or exact text, never read as floats.
"""

from __future__ import annotations

import json
import re
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from .errors import InputError, Location
from .report.difference import readable

MAX_BYTES = 4_000_000
MOST_COEFFICIENTS, MOST_CHARACTERS = 1000, 4000
NUMBER = re.compile(r"[-+]?[0-9]+(?:/[0-9]+|(?:\.[0-9]*)?(?:[eE][-+]?[0-9]{1,4})?)")
SHAPE = '{"numerator": […], "denominator": […]}, {"Q": {…}}, {"C": {…}} or a certificate'
UNNAMED = ""  # coefficients of Q or of C, whichever they are

Part = dict[str, tuple[Fraction, ...]]  # "numerator" and "denominator", without leading zeros


@dataclass(frozen=True)
class Controller:
    """Coefficients by name: Q, C or unnamed; and the type, where the file says it."""

    parts: dict[str, Part]
    type: str | None = None


def read_controller(data: bytes, file: str) -> Controller:
    """The controller in a file's bytes. Raises: InputError."""
    try:
        if len(data) > MAX_BYTES:
            raise ValueError(f"more than {MAX_BYTES} bytes")
        exact: dict[str, Any] = dict.fromkeys(("parse_int", "parse_float", "parse_constant"), _number)
        content = json.loads(data.decode("utf-8-sig"), object_pairs_hook=_object, **exact)
        if isinstance(content, dict) and "robimp_certificate" in content:
            content = content.get("controller")
        return _controller(content)
    except RecursionError:
        raise InputError("not a controller: nested too deeply", Location(file)) from None
    except ValueError as error:
        raise InputError(f"not a controller: {error}", Location(file)) from None


def stale(certified: dict[str, Any], asked: Controller) -> list[str]:
    """Every difference of the controller in use from a checked certificate's; C = Q/(1 − Q) only follows another Q."""
    known = {name: _part(certified[name], name) for name in ("Q", "C") if name in certified}
    found = []
    if asked.type is not None and asked.type != certified["type"]:
        found.append(f"controller.type {certified['type']} → {asked.type}")
    for name, part in asked.parts.items():
        if name == UNNAMED:
            against = [_part_differences(f"controller.{n}", known[n], part) for n in known]
            nearest = min(against, key=len)
            found += nearest
        elif name in known and not (name == "C" and "Q" in known and any("controller.Q" in line for line in found)):
            found += _part_differences(f"controller.{name}", known[name], part)
        elif name not in known:
            found.append(f"controller.{name}: only in the controller file")
    return found


def _part_differences(key: str, certified: Part, asked: Part) -> list[str]:
    """Coefficient by coefficient; none for one common factor above and below, which changes nothing."""
    factor = certified["denominator"][0] / asked["denominator"][0]
    if all(certified[side] == tuple(factor * c for c in asked[side]) for side in certified):
        return []
    found = []
    for side in certified:
        a, b = certified[side], asked[side]
        if len(a) != len(b):
            found.append(f"{key}.{side}: degree {len(a) - 1} → {len(b) - 1}")
            continue
        pairs = enumerate(zip(a, b, strict=True))
        found += [f"{key}.{side}[{k}] {readable(str(x))} → {readable(str(y))}" for k, (x, y) in pairs if x != y]
    return found


def _controller(content: Any) -> Controller:
    if isinstance(content, dict) and content.keys() == {"numerator", "denominator"}:
        return Controller({UNNAMED: _part(content, "file")})
    if not isinstance(content, dict) or not content.keys() & {"Q", "C"} or content.keys() - {"Q", "C", "type"}:
        raise ValueError(f"expected {SHAPE}")
    if not isinstance(content.get("type", ""), str):
        raise ValueError("type: expected text")
    return Controller({n: _part(content[n], n) for n in ("Q", "C") if n in content}, content.get("type"))


def _part(content: Any, name: str) -> Part:
    if not isinstance(content, dict) or content.keys() != {"numerator", "denominator"}:
        raise ValueError(f"{name}: expected a numerator and a denominator, and nothing else")
    part = {side: _coefficients(content[side], f"{name}.{side}") for side in ("numerator", "denominator")}
    if not any(part["denominator"]):
        raise ValueError(f"{name}.denominator: is zero")
    return part


def _coefficients(content: Any, key: str) -> tuple[Fraction, ...]:
    if not isinstance(content, list) or not 0 < len(content) <= MOST_COEFFICIENTS:
        raise ValueError(f"{key}: expected a list of 1 to {MOST_COEFFICIENTS} numbers")
    numbers = [c if isinstance(c, Fraction) else _number(c, f"{key}[{k}]") for k, c in enumerate(content)]
    leading = next((k for k, c in enumerate(numbers) if c), len(numbers) - 1)
    return tuple(numbers[leading:])


def _number(text: Any, key: str = "file") -> Fraction:
    if not isinstance(text, str) or len(text) > MOST_CHARACTERS or not NUMBER.fullmatch(text):
        raise ValueError(f"{key}: {text!a:.40} is not an exact number")
    try:
        return Fraction(text)
    except ZeroDivisionError:
        raise ValueError(f"{key}: {text!a:.40} has a zero denominator") from None


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) < len(pairs):
        raise ValueError("duplicate key")
    return found
