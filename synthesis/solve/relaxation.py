"""What to relax: of all single changes to a specification, the smallest one that takes its contradiction away."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np

from ..spec.model import Box, Polynomials, Spec, Table

LARGEST = 1e3  # factor that is still a relaxation
FIRST = (100.0, 30.0, 10.0, 3.0)  # factors that are tried where the largest does not help
CANDIDATES = 2  # changes that are tried
NEAR = 0.02  # relative accuracy of the factor

FURTHER = (1.0, 1.2, 1.6, 2.5)  # times the least factor: until a controller is found, too

Holds = Callable[[Spec], bool]
Reached = Callable[[Spec], float | None]  # ω_B [rad/s] that is proven of a specification; None where nothing is found


@dataclass(frozen=True)
class Relaxation:
    """A change of one number, or of all uncertainty, and the specification with it. factor > 1: by how much."""

    text: str
    factor: float
    spec: Spec
    omega_B: float | None = None  # [rad/s] of a controller that was found with it


Change = Callable[[float], Relaxation | None]  # a factor to the change; None where the value ends


def smallest_relaxation(spec: Spec, holds: Holds, reached: Reached = lambda _: None) -> Relaxation | None:
    """The relaxation of least factor after which `holds`; None when no single one helps.

    With `reached` it is taken so much further that a controller is found with it; omega_B says whether one was.
    """
    found: list[tuple[Relaxation, Change]] = []
    for change in _changes(spec):
        least = _least(change, holds, found[-1][0].factor if found else LARGEST)
        found += [] if least is None else [(least, change)]
    for least, change in found[: -1 - CANDIDATES : -1]:
        for further in FURTHER:
            relaxation = change(least.factor * further)
            omega_B = None if relaxation is None or not holds(relaxation.spec) else reached(relaxation.spec)
            if relaxation is not None and omega_B is not None:
                return replace(relaxation, omega_B=omega_B)
    return found[-1][0] if found else None


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

    low = 1.0
    for high in (below / (1 + NEAR), *(factor for factor in FIRST if factor < below)):  # too much may be as bad
        best = tried(high)
        if best is not None:
            break
    while best is not None and high / low > 1 + NEAR:
        middle = float(np.sqrt(low * high))
        found = tried(middle)
        low, high, best = (low, middle, found) if found is not None else (middle, high, best)
    return best


def _changes(spec: Spec) -> Iterator[Change]:
    yield _number(spec, "objective.attenuation", 1, most=Fraction(99, 100))
    for key in ("objective.rendering_error", "constraints.peak", "constraints.noise.gain", "impedance.damping"):
        yield _number(spec, key, 1)
    for key in ("constraints.eq12.margin", "impedance.stiffness", "sampling.delay"):
        yield _number(spec, key, -1)
    yield _number(spec, "sampling.rate", 1)
    for key in ("impedance.damping", "impedance.stiffness"):
        yield _range(spec, key, key.endswith("damping"))
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


def _range(spec: Spec, key: str, low: bool) -> Change:
    """The low end of a range times the factor, or the high end divided by it, as far as the other end."""
    ends = _get(spec, key)

    def change(factor: float) -> Relaxation | None:
        if not isinstance(ends, tuple) or ends[not low] == 0:
            return None
        new = Fraction(f"{float(ends[not low]) * factor ** (1 if low else -1):.3g}")
        changed = (min(new, ends[1]), ends[1]) if low else (ends[0], max(new, ends[0]))
        before, after = (", ".join(f"{float(end):.4g}" for end in pair) for pair in (ends, changed))
        return Relaxation(f"{key} [{before}] → [{after}]", factor, _with(spec, key, changed))

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
