"""Readers of intervals: `[low, high]`, and `±p %` around a nominal value."""

from __future__ import annotations

import re
from fractions import Fraction

from ..errors import InputError
from .exact import bounded, decimal_text
from .fields import described, parsed, quantity, require
from .model import Interval
from .tree import Node, Scalar, Sequence
from .units import Dimension, parse_quantity, parse_tolerance


def interval(node: Node, dimension: Dimension) -> Interval:
    """A list `[low, high]` of two quantities, low ≤ high."""
    if not isinstance(node, Sequence) or len(node.items) != 2:
        found = f"a list of {len(node.items)}" if isinstance(node, Sequence) else described(node)
        raise InputError(f"expected a list [low, high]; found {found}; write two numbers", node.where)
    low, high = (quantity(item, dimension) for item in node.items)
    require(low <= high, f"expected low ≤ high; found {_shown(low, high)}; swap them", node.where)
    return low, high


def around(node: Node, dimension: Dimension, nominal: Fraction) -> Interval:
    """`±p %` of the nominal value, or `[low, high]` that holds it."""

    def parse(text: str) -> Interval | None:
        found = parse_tolerance(text)
        return _spread(nominal, found[1]) if found and not found[0] else None

    within = parsed(node, 'expected a tolerance such as "±20 %"', parse) if isinstance(node, Scalar) else None
    if within is not None:
        return within
    if not isinstance(node, Sequence):
        bare = re.fullmatch(r"±?\s*([0-9.]+)\s*%?", node.text) if isinstance(node, Scalar) else None
        share = f'write "±{bare[1]} %", or ' if bare and bare[1].strip("0.") else "write "
        message = f'expected "±20 %" or [low, high]; found {described(node)}; {share}[v, v] if the value v is exact'
        raise InputError(message, node.where)
    low, high = interval(node, dimension)
    message = f"expected an interval that holds the nominal value {decimal_text(nominal)}; found {_shown(low, high)}"
    message += "; widen it, or correct the nominal value"
    require(low <= nominal <= high, message, node.where)
    return low, high


def one_or_range(node: Node, dimension: Dimension, nominal: Fraction | None = None) -> Fraction | Interval:
    """`v`, `v ±p %` or `[low, high]`; an interval of no width is its value.

    Args:
        node: the value.
        dimension: its unit.
        nominal: what the word `nominal` and a tolerance with nothing before it stand for; None: they mean nothing here.
    """
    if isinstance(node, Sequence):
        return _narrowed(interval(node, dimension))
    if not isinstance(node, Scalar):
        return quantity(node, dimension)

    def parse(text: str) -> Fraction | Interval:
        value, share = parse_tolerance(text) or (text.strip(), None)
        alone = share is not None and not value
        if nominal is not None and (alone or value == "nominal"):
            middle = nominal
        elif alone:
            raise ValueError("say of what: write the value before it, such as 1.25 ±20 %, or [low, high]")
        elif value == "nominal":
            raise ValueError("only the inertia can stay the load's own: write a number")
        elif share is None and re.fullmatch(r"[0-9.]+\s*(\.\.+|…|–|-|:|to)\s*[0-9.]+", value):
            raise ValueError("write a range as [low, high]")
        elif share is None and "±" in value:
            raise ValueError("a tolerance is a share of the value: write a percent sign behind it, such as 1.25 ±20 %")
        else:
            middle = parse_quantity(value, dimension)
        return middle if share is None else _narrowed(_spread(middle, share))

    return parsed(node, f"expected {dimension.name}", parse)


def _spread(middle: Fraction, share: Fraction) -> Interval:
    if share < 0:
        raise ValueError("leave the sign out")
    if middle == 0:
        raise ValueError("any share of the nominal value 0 is 0: write [low, high], or [0, 0] if it is exact")
    return bounded(middle * (1 - share)), bounded(middle * (1 + share))


def _narrowed(both: Interval) -> Fraction | Interval:
    return both[0] if both[0] == both[1] else both


def _shown(low: Fraction, high: Fraction) -> str:
    return f"[{decimal_text(low)}, {decimal_text(high)}]"
