"""A transfer function somebody hands over in Python: checked as strictly as one in a file."""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from math import isfinite
from typing import Any

from ..errors import InputError, Location
from .demands import demand_realizable
from .fields import polynomials
from .model import Polynomials
from .tree import Mapping, Node, Scalar, Sequence

NAMES = ("numerator", "denominator")
SHAPES = "a control.TransferFunction or a pair (numerator, denominator) of coefficients, descending powers of s"


def given(system: Any, kind: str) -> Polynomials:
    """Q (kind `dob`) or C_imp from a continuous SISO `control.TransferFunction`, `Polynomials`, or a pair of lists.

    system: coefficients in descending powers of s, lists or arrays (n,) of numbers or of exact text; a double is taken
    as the exact number it is.

    Raises: InputError for several inputs or outputs, a discrete system, a number that is not finite, a numerator of
    higher degree than the denominator, Q(∞) = 1.
    """
    where = Location("controller")
    if isinstance(system, Polynomials):
        system = system.numerator, system.denominator
    if hasattr(system, "issiso"):
        if not hasattr(system, "num") or not system.issiso() or system.isdtime(strict=True):
            raise InputError("expected a continuous transfer function of one input and one output", where)
        system = system.num[0][0], system.den[0][0]
    if not isinstance(system, tuple | list) or len(system) != 2:
        raise InputError(f"expected {SHAPES}; found {type(system).__name__}", where)
    parts: dict[str, tuple[Location, Node]] = {
        name: (Location("controller", key=name), _list(part, name)) for name, part in zip(NAMES, system, strict=True)
    }
    found = polynomials(Mapping(parts, where))
    demand_realizable(found, kind, where)
    return found


def _list(part: Any, name: str) -> Sequence:
    where = Location("controller", key=name)
    if isinstance(part, str) or not isinstance(part, Iterable):
        raise InputError(f"expected a list of coefficients; found {part!r:.40}; write [{part!r:.20}]", where)
    places = (Location("controller", key=f"{name}[{k}]") for k in range(10**6))
    return Sequence(tuple(Scalar(_exact(c, at), False, at) for c, at in zip(part, places, strict=False)), where)


def _exact(value: Any, where: Location) -> str:
    """Text of the exact number; text as it is, for the reader to judge."""
    if isinstance(value, str):
        return value
    try:
        if not isfinite(value):
            raise InputError(f"expected a number; found {value}: a number must be finite", where)
        return str(Fraction(value) if isinstance(value, int | Fraction) else Fraction(float(value)))
    except (TypeError, ValueError):
        raise InputError(f"expected a number; found {value!r:.40}", where) from None
