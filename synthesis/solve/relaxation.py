"""What to relax: of all single changes to a specification, the smallest one that takes its contradiction away."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from ..spec.model import Box, Polynomials, Spec, Table

LARGEST = 100.0  # factor that is still a relaxation
NEAR = 0.02  # relative accuracy of the factor

Holds = Callable[[Spec], bool]


@dataclass(frozen=True)
class Relaxation:
    """A change of one number, or of all uncertainty, and the specification with it. factor > 1: by how much."""

    text: str
    factor: float
    spec: Spec


Change = Callable[[float], Relaxation | None]  # a factor to the change; None where the value ends


def smallest_relaxation(spec: Spec, holds: Holds) -> Relaxation | None:
    """The relaxation of least factor after which `holds`; None when no single one helps."""
    best: Relaxation | None = None
    for change in _changes(spec):
        found = _least(change, holds, LARGEST if best is None else best.factor)
        best = found or best
    return best


def droppable(spec: Spec, holds: Holds) -> str | None:
    """The first constraint without which `holds`; None when none is enough."""
    for key in ("eq12", "eq18", "eq9", "peak", "noise"):
        if getattr(spec.constraints, key) is not None and holds(_with(spec, f"constraints.{key}", None)):
            return f"constraints.{key}"
    required = spec.constraints.friction == "require"
    if required and holds(_with(spec, "constraints.friction", "report")):
        return "constraints.friction"
    return None


def _least(change: Change, holds: Holds, below: float) -> Relaxation | None:
    """The least factor below a given one, to within NEAR; what is returned was tried as it stands."""

    def tried(factor: float) -> Relaxation | None:
        relaxation = change(factor)
        return relaxation if relaxation is not None and holds(relaxation.spec) else None

    low, high = 1.0, below / (1 + NEAR)
    best = tried(high)
    while best is not None and high / low > 1 + NEAR:
        middle = float(np.sqrt(low * high))
        found = tried(middle)
        low, high, best = (low, middle, found) if found is not None else (middle, high, best)
    return best


def _changes(spec: Spec) -> Iterator[Change]:
    yield _number(spec, "objective.attenuation", 1, most=Fraction(99, 100))
    for key in ("objective.rendering_error", "constraints.peak", "constraints.noise.gain", "impedance.damping"):
        yield _number(spec, key, 1)
    for key in ("constraints.eq12.margin", "impedance.stiffness"):
        yield _number(spec, key, -1)
    yield lambda factor: Relaxation(f"all uncertainty × {1 / factor:.3g}", factor, shrunk(spec, 1 / factor))


def _number(spec: Spec, key: str, direction: int, most: Fraction | None = None) -> Change:
    """One number times or divided by the factor, rounded to three digits, up to `most`."""
    value = _get(spec, key)

    def change(factor: float) -> Relaxation | None:
        if not isinstance(value, Fraction) or value == 0:
            return None
        new = Fraction(f"{float(value) * factor**direction:.3g}")
        if most is not None and new > most > value:
            new = most
        return Relaxation(f"{key} {float(value):.4g} → {float(new):.4g}", factor, _with(spec, key, new))

    return change


def shrunk(spec: Spec, share: float) -> Spec:
    """The specification with every uncertainty a share of what it is, around the nominal joint."""
    part, found = Fraction(f"{share:.3g}"), spec.uncertainty
    changed: dict[str, Any] = {}
    if found.box is not None:
        around = {key: _narrowed(getattr(found.box, key), getattr(spec.plant, key), part) for key in Box.model_fields}
        changed["box"] = Box(**around)
    if found.actuator is not None:
        spans = {key: span for key, span in found.actuator if span is not None}
        around = {key: _narrowed(span, getattr(spec.actuator, key), part) for key, span in spans.items()}
        changed["actuator"] = found.actuator.model_copy(update=around)
    if found.weight is not None:
        numerator = tuple(part * c for c in found.weight.numerator)
        changed["weight"] = Polynomials(numerator=numerator, denominator=found.weight.denominator)
    if found.table is not None:
        changed["table"] = Table(points=tuple((w, part * b) for w, b in found.table.points), beyond=found.table.beyond)
    return spec.model_copy(update={"uncertainty": found.model_copy(update=changed)})


def _narrowed(span: tuple[Fraction, Fraction], nominal: Fraction, part: Fraction) -> tuple[Fraction, Fraction]:
    return nominal - part * (nominal - span[0]), nominal + part * (span[1] - nominal)


def _get(spec: Any, key: str) -> Any:
    for part in key.split("."):
        spec = getattr(spec, part, None)
    return spec


def _with(section: Any, key: str, value: object) -> Any:
    first, _, rest = key.partition(".")
    return section.model_copy(update={first: _with(getattr(section, first), rest, value) if rest else value})
