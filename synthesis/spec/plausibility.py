"""What is allowed but unlikely to be meant: warnings, each with its remedy."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

from .exact import decimal_text
from .model import SeriesElasticActuator, Spec
from .timing import hertz, resonances, timing_warnings
from .units import TWO_PI

_SLOWEST, _FASTEST = Fraction("0.05"), 500  # Hz; joints of robots resonate in between
_SPRUNG = 150  # Hz; springs of series-elastic actuators: the stiffest of examples/ gives 60 Hz on its motor


def spec_warnings(spec: Spec) -> tuple[str, ...]:
    """One line each, in the order of the file; empty for a specification that looks as usual."""
    return (*_resonances(spec), *_spring(spec), *_filters(spec), *_disc_band(spec), *timing_warnings(spec))


def _resonances(spec: Spec) -> Iterator[str]:
    """`√(K/I)/2π` of springs and impedances on their inertias: far off, a unit is likely wrong. A line each."""
    pairs, said = list(resonances(spec)), set()
    if isinstance(spec.actuator, SeriesElasticActuator):
        squared = spec.actuator.spring_stiffness / spec.actuator.motor_inertia / TWO_PI**2
        pairs.append(("actuator.spring_stiffness on actuator.motor_inertia", squared))
    for what, squared in pairs:
        stiffness, highest = what.split(" on ")[0], _SPRUNG if what.startswith("actuator") else _FASTEST
        if squared and stiffness not in said and not _SLOWEST**2 <= squared <= highest**2:
            said.add(stiffness)
            yield (
                f"{what} resonates at {hertz(squared)}, outside 0.05 to {highest} Hz: "
                f"check the units of both, and `motion: {spec.motion}`"
            )


def _spring(spec: Spec) -> Iterator[str]:
    actuator, stiffness = spec.actuator, spec.impedance.stiffness
    highest = stiffness[1] if isinstance(stiffness, tuple) else stiffness
    if isinstance(actuator, SeriesElasticActuator) and highest > actuator.spring_stiffness:
        yield (
            f"impedance.stiffness {decimal_text(highest)} exceeds actuator.spring_stiffness "
            f"{decimal_text(actuator.spring_stiffness)}: only feedback renders that, and with a slow torque loop "
            "passivity may leave little bandwidth"
        )


def _filters(spec: Spec) -> Iterator[str]:
    force, position = spec.controller.filters.force, spec.controller.filters.position
    if position is not None and (None if position == "none" else position) != force:
        yield (
            "controller.filters.position differs from controller.filters.force: equal filters render better; "
            "leave `position` out to have one filter on both"
        )


def _disc_band(spec: Spec) -> Iterator[str]:
    """Near ω = ∞ the budget of (12) falls like 1/ω while the disc of an uncertain inertia keeps its size."""
    eq12, box = spec.constraints.eq12, spec.uncertainty.box
    unbounded = eq12 is not None and eq12.form != "structured" and eq12.band is None
    if unbounded and box is not None and box.inertia[0] < box.inertia[1]:
        yield (
            "constraints.eq12 in the forms paper and disc cannot hold up to ω = ∞ with an uncertain inertia: "
            "give a `band`, or write `form: structured`"
        )
