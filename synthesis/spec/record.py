"""Measured frequency responses: records, which of them are dead or incoherent, and how far they are from a model."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import ceil, isqrt
from statistics import median

from .exact import decimal_text
from .units import TWO_PI

SILENT_COHERENCE = Fraction(1, 10)  # below: the output has nothing to do with the input
SILENT_GAIN = Fraction(1, 20)  # of the median of all records at that frequency
DEAD = Fraction(1, 4)  # share of silent points
INCOHERENT = Fraction(1, 2)  # median coherence of a record
FEWEST_PEERS = 3  # records at a frequency before their median means anything
DIGITS = 4  # of a bound; rounded up

Complex = tuple[Fraction, Fraction]
Model = Callable[[Fraction], Complex]  # ω [rad/s] to a complex number, exactly
Bounds = tuple[tuple[Fraction, Fraction], ...]  # (ω, bound on |Δ|), ω increasing


@dataclass(frozen=True)
class Sample:
    """One measured point: ω [rad/s], the response, how far arithmetic may be off, coherence if it was measured."""

    omega: Fraction
    re: Fraction
    im: Fraction
    error: Fraction = Fraction(0)
    coherence: Fraction | None = None


@dataclass(frozen=True)
class Record:
    """One sweep: its samples by increasing frequency; the amplitude of its excitation if that was written down."""

    name: str
    samples: tuple[Sample, ...]
    amplitude: Fraction | None = None


def dynamic_stiffness(inertia: Fraction, damping: Fraction, stiffness: Fraction) -> Model:
    """`1/G(jω) = K − Iω² + jωB` of a load (1), exactly."""
    return lambda omega: (stiffness - inertia * omega**2, damping * omega)


def unusable(records: Sequence[Record]) -> dict[str, str]:
    """Names of dead and incoherent records, and why: a fault of the measurement is no property of the joint.

    Dead: at a quarter of its points or more the output is silent, with a coherence below 0.1 or a gain below 1/20 of
    what the records show there on the median. Incoherent: its median coherence is below 0.5.
    """
    gains: dict[Fraction, list[Fraction]] = {}
    for record in records:
        for sample in record.samples:
            gains.setdefault(sample.omega, []).append(_squared(sample))
    usual = {omega: median(found) for omega, found in gains.items() if len(found) >= FEWEST_PEERS}
    found = {record.name: _fault(record, usual) for record in records}
    return {name: fault for name, fault in found.items() if fault}


def _fault(record: Record, usual: dict[Fraction, Fraction]) -> str:
    count = len(record.samples)
    coherent = [(s.coherence, s.omega) for s in record.samples if s.coherence is not None]
    least, where = min(coherent, default=(Fraction(1), Fraction(0)))
    lost = sum(value < SILENT_COHERENCE for value, _ in coherent)
    low = sum(_squared(s) < SILENT_GAIN**2 * usual.get(s.omega, 0) for s in record.samples)
    if lost >= DEAD * count:
        lowest = f"the least {decimal_text(least)} at {decimal_text(where)} rad/s ({decimal_text(where / TWO_PI)} Hz)"
        return f"dead: coherence below {float(SILENT_COHERENCE)} at {lost} of {count} points, {lowest}"
    if (nothing := sum(_squared(s) == 0 for s in record.samples)) >= DEAD * count:
        return f"dead: gain 0 at {nothing} of {count} points"
    if low >= DEAD * count:
        return f"dead: gain below {float(SILENT_GAIN)} of the other records' at {low} of {count} points"
    middle = median(value for value, _ in coherent) if coherent else Fraction(1)
    return f"incoherent: median coherence {decimal_text(middle)}" if middle < INCOHERENT else ""


def deviations(record: Record, inverse: Model) -> tuple[Fraction, ...]:
    """Bounds on |Δ|, `measured = model·(1+Δ)`, at the samples of a record: exact, then rounded up to four digits.

    inverse: 1/model at ω.
    """
    return tuple(_deviation(sample, inverse(sample.omega)) for sample in record.samples)


def _deviation(sample: Sample, inverse: Complex) -> Fraction:
    (u, v), x, y = inverse, sample.re, sample.im
    squared = (x * u - y * v - 1) ** 2 + (x * v + y * u) ** 2
    error = sample.error * (abs(u) + abs(v))
    return rounded_up(squared + error * (1 + squared) + error**2)  # ≥ (√squared + error)²


def rounded_up(squared: Fraction) -> Fraction:
    """The least number of four digits that is not below the square root of a number ≥ 0."""
    if squared == 0:
        return Fraction(0)
    half = (len(str(squared.numerator)) - len(str(squared.denominator))) // 2
    for shift in range(DIGITS - half - 2, DIGITS - half + 3):
        scaled = squared * Fraction(10) ** (2 * shift)
        if scaled > 10 ** (2 * DIGITS - 2):
            break
    return Fraction(isqrt(ceil(scaled) - 1) + 1) / Fraction(10) ** shift


def envelope(records: Iterable[Record], inverse: Model) -> Bounds:
    """The largest deviation of all records at every frequency of any of them.

    Between two of its own samples a record counts with the larger of the two; outside its band it says nothing.
    """
    found = [(record.samples, deviations(record, inverse)) for record in records]
    largest: dict[Fraction, Fraction] = {sample.omega: Fraction(0) for samples, _ in found for sample in samples}
    grid = sorted(largest)
    for samples, values in found:
        k = 0
        for omega in grid:
            while k + 1 < len(samples) and samples[k + 1].omega <= omega:
                k += 1
            if not samples[0].omega <= omega <= samples[-1].omega:
                continue
            between = omega > samples[k].omega
            value = max(values[k], values[k + 1]) if between else values[k]
            largest[omega] = max(largest[omega], value)
    return tuple((omega, largest[omega]) for omega in grid)


def stepped(bounds: Bounds) -> Bounds:
    """Each bound raised to its neighbours': straight lines between the points then stay above the larger of two.

    What is claimed between two frequencies is therefore the larger of the deviations measured at them.
    """
    values = [value for _, value in bounds]
    return tuple((omega, max(values[max(k - 1, 0) : k + 2])) for k, (omega, _) in enumerate(bounds))


def _squared(sample: Sample) -> Fraction:
    return sample.re**2 + sample.im**2
