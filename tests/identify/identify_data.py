"""Frequency responses whose truth is known: files, records, specifications that name them."""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterable, Sequence
from fractions import Fraction

from robimp.synthesis.spec.record import Record, Sample

HERTZ = (0.2, 0.5, 1, 2, 5, 10, 20)
TRUTH = (0.05, 0.3, 2.0)  # inertia, damping, stiffness
HEADING = "frequency [Hz],real,imaginary"


def compliance(load: Sequence[float], hertz: float) -> complex:
    """`1/(K − Iω² + jωB)`."""
    inertia, damping, stiffness = load
    omega = 2 * math.pi * hertz
    return 1 / (stiffness - inertia * omega**2 + 1j * damping * omega)


def csv_text(load: Sequence[float] = TRUTH, hertz: Iterable[float] = HERTZ, scale: complex = 1) -> str:
    """A file of one record."""
    rows = ((f, scale * compliance(load, f)) for f in hertz)
    return HEADING + "\n" + "".join(f"{f:g},{G.real:.9g},{G.imag:.9g}\n" for f, G in rows)


def polar_text(load: Sequence[float] = TRUTH, hertz: Iterable[float] = HERTZ) -> str:
    """The same in decibels and degrees."""
    rows = ((f, compliance(load, f)) for f in hertz)
    lines = (f"{f:g},{20 * math.log10(abs(G)):.12g},{math.degrees(cmath.phase(G)):.12g}\n" for f, G in rows)
    return "frequency [Hz],gain [dB],phase [deg]\n" + "".join(lines)


def record(
    values: Sequence[complex],
    name: str = "r",
    *,
    omega: Sequence[float] | None = None,
    coherence: Sequence[float] | None = None,
    amplitude: float | None = None,
) -> Record:
    """A record of these values at ω = 1, 2, 3, … unless given."""
    at = range(1, len(values) + 1) if omega is None else omega
    shares = [None] * len(values) if coherence is None else [Fraction(str(c)) for c in coherence]
    exact = [(Fraction(v.real), Fraction(v.imag)) for v in map(complex, values)]
    samples = tuple(Sample(Fraction(w), *v, coherence=c) for w, v, c in zip(at, exact, shares, strict=True))
    return Record(name, samples, None if amplitude is None else Fraction(str(amplitude)))


SPEC = """robimp: 1
name: joint
motion: rotary
plant: {inertia: 0.05, damping: 0.3, stiffness: 2}
uncertainty: {measured: MEASURED}
actuator: {type: ideal}
impedance: {inertia: nominal, damping: 0.5, stiffness: 3}
controller: {type: dob, coefficients: {numerator: [80], denominator: [1, 20, 100]}}
objective: {maximize: bandwidth, attenuation: 0.9}
constraints: {eq9: {}}
"""


def spec_text(measured: str) -> str:
    """A specification with this `measured:` section, in line 5."""
    return SPEC.replace("MEASURED", measured)
