"""The vocabulary of the JSON Schema: a section, a number with its units, a pair, a choice of words."""

from __future__ import annotations

from typing import Any, TypeAlias

from .exact import NUMBER
from .fields import MAX_DEGREE
from .units import MECHANICS, Dimension

Schema: TypeAlias = dict[str, Any]

TOLERANCE = r"(±|\+-|\+/-).*%"
_QUANTITY = rf"^\s*{NUMBER}\s*([^\s0-9.+-].*)?$"


def section(description: str, required: Schema, optional: Schema | None = None) -> Schema:
    """An object with these keys and no others."""
    return {
        "type": "object",
        "description": description,
        "properties": {**required, **(optional or {})},
        "required": list(required),
        "additionalProperties": False,
    }


def words(description: str, *choices: str) -> Schema:
    """One of these words."""
    return {"enum": list(choices), "description": description}


def mechanical(key: str) -> tuple[Dimension, ...]:
    """The dimension of a mechanical key, rotary and linear."""
    return tuple(getattr(mechanics, key) for mechanics in MECHANICS.values())


def units(*dimensions: Dimension) -> str:
    """The accepted units in words."""
    return "a bare number is SI, or with a unit: " + " | ".join(dimension.accepted for dimension in dimensions)


def number(description: str, *dimensions: Dimension) -> Schema:
    """A number, bare or with a unit."""
    text = "; ".join(part for part in (description, units(*dimensions) if dimensions else "") if part)
    return {"type": ["number", "string"], "pattern": _QUANTITY, "description": text}


def positive(description: str, *dimensions: Dimension) -> Schema:
    """A number > 0."""
    return {**number(description, *dimensions), "exclusiveMinimum": 0}


def non_negative(description: str, *dimensions: Dimension) -> Schema:
    """A number ≥ 0."""
    return {**number(description, *dimensions), "minimum": 0}


def pair(description: str, *dimensions: Dimension) -> Schema:
    """A list [low, high]."""
    item = non_negative("", *dimensions)
    return {"type": "array", "items": item, "minItems": 2, "maxItems": 2, "description": description}


def tolerance(before: str = "") -> Schema:
    """`±p %`, behind what the pattern `before` matches."""
    return {"type": "string", "pattern": rf"^\s*{before}\s*{TOLERANCE}\s*$"}


def polynomials(description: str) -> Schema:
    """A rational function by its coefficients."""
    powers = "coefficients in descending powers of s (rad/s)"
    both = {"type": "array", "items": number(""), "minItems": 1, "maxItems": MAX_DEGREE + 1, "description": powers}
    return section(description, {"numerator": both, "denominator": both})
