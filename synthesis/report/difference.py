"""Where two documents differ, in words: every difference, by key."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from decimal import Context, Decimal
from fractions import Fraction
from typing import Any

NUMBER = re.compile(r"-?(?:0|[1-9][0-9]*)(?:/[1-9][0-9]*)?")
LONGEST = 48  # characters of a value that are shown


def differences(certified: Any, asked: Any, where: str, key: str = "") -> Iterator[str]:
    """Every difference of two canonical documents, in the order of the file; where: what the second one is.

    `plant.inertia 0.02 → 0.021`, `constraints.peak: only in the specification`. Null means absent.
    """
    if isinstance(certified, dict) and isinstance(asked, dict):
        for name in dict.fromkeys([*asked, *certified]):
            yield from differences(certified.get(name), asked.get(name), where, f"{key}.{name}" if key else name)
    elif isinstance(certified, list) and isinstance(asked, list):
        for k in range(max(len(certified), len(asked))):
            one, other = (side[k] if k < len(side) else None for side in (certified, asked))
            yield from differences(one, other, where, f"{key}[{k}]")
    elif asked is None and certified is not None:
        yield f"{key}: only in the certificate"
    elif certified is None and asked is not None:
        yield f"{key}: only in the {where}"
    elif type(certified) is not type(asked) or certified != asked:  # True == 1
        yield f"{key} {readable(certified)} → {readable(asked)}"


def without_consequences(certified: dict[str, Any], asked: dict[str, Any]) -> dict[str, Any]:
    """The specification asked for, less what only follows from another nominal value: ± 20 % of it, an inertia like it.

    A canonical document has intervals, not shares: one that is the same share of both nominal values has not changed.
    """
    found: dict[str, Any] = json.loads(json.dumps(asked))
    for section, given in (("plant", "box"), ("actuator", "actuator")):
        for key, nominal in certified[section].items():
            other = asked[section].get(key)
            if not (isinstance(nominal, str) and isinstance(other, str)) or nominal == other or key == "type":
                continue
            boxes = [(document["uncertainty"].get(given) or {}).get(key) for document in (certified, asked)]
            scaled = [
                [Fraction(end) * Fraction(n) for end in box]
                for box, n in zip(boxes, (other, nominal), strict=True)
                if box
            ]
            if len(scaled) == 2 and scaled[0] == scaled[1]:
                found["uncertainty"][given][key] = boxes[0]
            if (section, key) == ("plant", "inertia") and (certified["impedance"][key], asked["impedance"][key]) == (
                nominal,
                other,
            ):
                found["impedance"][key] = nominal
    return found


def readable(value: Any) -> str:
    """A value for a person: exact numbers as decimals where they end soon, long text with its middle left out."""
    text = value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)
    if isinstance(value, str) and NUMBER.fullmatch(value):
        text = decimal(value)
    return text if len(text) <= LONGEST else f"{text[: LONGEST // 2]}…{text[-LONGEST // 2 :]}"


def decimal(text: str) -> str:
    """`3/100` as 0.03; an exact fraction stays one where it has no decimal, or only a long one."""
    if len(text) > LONGEST:
        return text
    number, context = Fraction(text), Context(prec=12)
    short = context.divide(Decimal(number.numerator), Decimal(number.denominator))
    return f"{short.normalize():f}" if Fraction(short) == number and abs(short.adjusted()) < 12 else text
