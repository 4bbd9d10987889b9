"""Readers of one field each: a node of the tree in, a value of the right type out, or an `InputError` at its place."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from fractions import Fraction
from typing import TypeVar

from ..errors import InputError, Location
from .model import Polynomials
from .suggestion import suggestion
from .tree import Mapping, Node, Scalar, Sequence, joined, shown
from .units import PLAIN, Dimension, parse_quantity

MAX_DEGREE = 60

T = TypeVar("T")


def require(condition: bool, message: str, where: Location) -> None:
    """Refuse the value at `where` unless the condition holds."""
    if not condition:
        raise InputError(message, where)


def described(node: Node) -> str:
    """What was found, for the second half of a message."""
    if isinstance(node, Scalar):
        return shown(node.text) if node.text else "nothing"
    return "a list" if isinstance(node, Sequence) else "a section"


def is_null(node: Node) -> bool:
    """Whether the value is the word `null`, which stands for an absent optional key; an empty value does not."""
    return isinstance(node, Scalar) and node.plain and node.text == "null"


def entries(node: Node, required: Iterable[str] = (), optional: Iterable[str] = ()) -> dict[str, Node]:
    """The keys of a section, without the optional ones that are null.

    Args:
        node: the section.
        required: keys that must be there.
        optional: keys that may be there.
    """
    if not isinstance(node, Mapping):
        advice = "write {} for one without keys"
        if required or optional:
            advice = f"give it {'the keys' if required else 'some of the keys'} {', '.join(required or optional)}"
        raise InputError(f"expected a section; found {described(node)}; {advice}", node.where)
    known = (*required, *optional)
    found: dict[str, Node] = {}
    for key, (place, value) in node.entries.items():
        require(key in known, f"unknown key; {suggestion(key, known, node.where.key or '')}", place)
        if key in optional and is_null(value):
            continue
        found[key] = value
    for key in required:
        where = node.where
        place = Location(where.file, where.line, where.column, joined(where.key, key))
        message = f"expected this key; it is missing, and it has no default; add `{key}:` here"
        require(key in found, message, place)
    return found


def word(node: Node, *choices: str) -> str:
    """One of the words in `choices`."""
    if not isinstance(node, Scalar) or node.text not in choices:
        near = suggestion(node.text, choices) if isinstance(node, Scalar) and node.text else ""
        hint = f"; {near}" if near.startswith("did") else ""
        raise InputError(f"expected {' or '.join(choices)}; found {described(node)}{hint}", node.where)
    return node.text


def quantity(node: Node, dimension: Dimension = PLAIN) -> Fraction:
    """A number in SI, with or without a unit."""
    expected = f"expected {dimension.name}"
    if not isinstance(node, Scalar):
        raise InputError(f"{expected}; found {described(node)}; write one number", node.where)
    return parsed(node, expected, lambda text: parse_quantity(text, dimension))


def integer(node: Node, what: str) -> int:
    """A whole number."""
    if not isinstance(node, Scalar):
        raise InputError(f"expected {what}; found {described(node)}", node.where)
    value = parsed(node, f"expected {what}", lambda text: parse_quantity(text, PLAIN))
    message = f"expected {what}; found {shown(node.text)}; write a whole number"
    require(value.denominator == 1, message, node.where)
    return int(value)


def above(node: Node, bound: int, dimension: Dimension = PLAIN) -> Fraction:
    """A quantity > bound."""
    value = quantity(node, dimension)
    message = f"expected {dimension.name} > {bound}; found {described(node)}; write a number above {bound}"
    require(value > bound, message, node.where)
    return value


def non_negative(node: Node, dimension: Dimension = PLAIN) -> Fraction:
    """A quantity ≥ 0."""
    value = quantity(node, dimension)
    message = f"expected {dimension.name} ≥ 0; found {described(node)}; write 0 or a number above it"
    require(value >= 0, message, node.where)
    return value


def polynomials(node: Node, *, zero: bool = False) -> Polynomials:
    """A proper rational function, descending powers of s; leading zeros of the numerator are dropped.

    Args:
        node: the section.
        zero: whether the function may be zero everywhere.
    """
    section = entries(node, ("numerator", "denominator"))
    numerator, denominator = (_coefficients(section[key]) for key in ("numerator", "denominator"))
    top, bottom = section["numerator"].where, section["denominator"].where
    require(any(denominator), "expected a denominator; every coefficient is zero; write one that is not", bottom)
    require(denominator[0] != 0, "expected a non-zero leading coefficient; found 0; leave it out", bottom)
    require(zero or any(numerator), "expected a numerator; every coefficient is zero; write one that is not", top)
    while numerator[0] == 0 and len(numerator) > 1:
        numerator = numerator[1:]
    found = "found a numerator of higher degree than the denominator"
    message = f"expected a proper rational function; {found}; write at most {len(denominator)} coefficients"
    require(len(numerator) <= len(denominator), message, top)
    return Polynomials(numerator=numerator, denominator=denominator)


def _coefficients(node: Node) -> tuple[Fraction, ...]:
    if not isinstance(node, Sequence) or not node.items:
        found = "an empty list" if isinstance(node, Sequence) else described(node)
        advice = "write them in brackets, [1, 70, 2500]"
        raise InputError(
            f"expected a list of coefficients, descending powers of s; found {found}; {advice}", node.where
        )
    require(
        len(node.items) <= MAX_DEGREE + 1,
        f"expected a degree of at most {MAX_DEGREE}; found {len(node.items) - 1}",
        node.where,
    )
    return tuple(quantity(item) for item in node.items)


def parsed(node: Scalar, expected: str, parse: Callable[[str], T]) -> T:
    """What `parse` makes of the text; its advice goes behind what was expected."""
    try:
        return parse(node.text)
    except ValueError as error:
        raise InputError(f"{expected}; found {described(node)}: {error}", node.where) from None
