"""Rates, delays and frequencies that are allowed but unlikely to be meant: mostly s for ms, and Hz for rad/s."""

from __future__ import annotations

from collections.abc import Iterator
from decimal import Decimal
from fractions import Fraction

from .exact import decimal_text
from .model import SeriesElasticActuator, Spec
from .units import TWO_PI

_PERIODS = 100  # of delay
_SAMPLES = 10  # per period of the fastest natural frequency


def resonances(spec: Spec) -> Iterator[tuple[str, Fraction]]:
    """Squares of natural frequencies in Hz, and the stiffness of each; ranges count with both ends."""
    stiffness = spec.impedance.stiffness
    for end in stiffness if isinstance(stiffness, tuple) else (stiffness,):
        yield "impedance.stiffness on plant.inertia", end / spec.plant.inertia / TWO_PI**2
    if isinstance(spec.actuator, SeriesElasticActuator):
        spring = spec.actuator.spring_stiffness
        yield "actuator.spring_stiffness on plant.inertia", spring / spec.plant.inertia / TWO_PI**2


def hertz(squared: Fraction) -> str:
    """The root, to three digits."""
    return f"{(Decimal(squared.numerator) / Decimal(squared.denominator)).sqrt():.3g} Hz"


def timing_warnings(spec: Spec) -> Iterator[str]:
    """One line each."""
    yield from _rate(spec)
    yield from _delay(spec)
    yield from _table(spec)
    yield from _noise(spec)


def _rate(spec: Spec) -> Iterator[str]:
    if spec.sampling is None:
        return
    rate, actuator, found = spec.sampling.rate, spec.actuator, list(resonances(spec))
    if isinstance(actuator, SeriesElasticActuator):
        held = actuator.spring_stiffness * (1 + actuator.torque_loop.kp) / actuator.motor_inertia / TWO_PI**2
        found.append(("actuator.spring_stiffness and torque_loop.kp on motor_inertia", held))
    what, fastest = max(found, key=lambda pair: pair[1])
    if rate**2 < _SAMPLES**2 * fastest:
        yield (
            f"sampling.rate {decimal_text(rate)} Hz is below {_SAMPLES} times the {hertz(fastest)} of {what}: "
            "check its unit, Hz or kHz; so slow a loop leaves almost no bandwidth"
        )
    turns = rate / TWO_PI
    rounded = Fraction(f"{Decimal(turns.numerator) / Decimal(turns.denominator):.1e}")
    if abs(turns - rounded) < turns / 5000:
        yield (
            f"sampling.rate {decimal_text(rate)} Hz is 2π·{decimal_text(rounded)}: if it is meant in rad/s, "
            f"write {decimal_text(rounded)} Hz"
        )


def _delay(spec: Spec) -> Iterator[str]:
    if spec.sampling is not None and spec.sampling.delay * spec.sampling.rate > _PERIODS:
        yield (
            f"sampling.delay {decimal_text(spec.sampling.delay)} s is "
            f"{decimal_text(spec.sampling.delay * spec.sampling.rate)} sampling periods: "
            "check its unit; a bare number is in s, write ms"
        )


def _table(spec: Spec) -> Iterator[str]:
    """A table that ends below the resonance it should describe was likely written in Hz."""
    table = spec.uncertainty.table
    if table is None or len(table.points) == 1:
        return
    last = table.points[-1][0]
    what, fastest = max(resonances(spec), key=lambda pair: pair[1])
    if last**2 < TWO_PI**2 * fastest:
        advice = "if its frequencies are in Hz, say so (`frequency [Hz]`, or `10 Hz`)"
        advice = "measure up to higher frequencies, or state a bound there with `beyond`" if table.measured else advice
        key = "measured" if table.measured else "table"
        yield f"uncertainty.{key} ends at {decimal_text(last)} rad/s, below the {hertz(fastest)} of {what}: {advice}"


def _noise(spec: Spec) -> Iterator[str]:
    noise, sampling = spec.constraints.noise, spec.sampling
    if noise is not None and sampling is not None and noise.above > sampling.rate * TWO_PI / 2:
        yield (
            f"constraints.noise.above {decimal_text(noise.above)} rad/s lies beyond half of sampling.rate, "
            f"{decimal_text(sampling.rate * TWO_PI / 2)} rad/s: check its unit; a bare number is in rad/s"
        )
