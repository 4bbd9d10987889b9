"""Unstructured uncertainty at its worst: a stable rational Δ within a bound that turns the loop's own phase against it.

`G = G₀(1+Δ)` is a load with a further torque, Δ times all that is applied to it, that no sensor feels. What Δ sees is
`T = applied/unfelt torque`; the loop closes on itself where `Δ T = 1`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import product

import numpy as np

from ..block import Block, transfer
from .bounds import Bound, rational
from .loop import Array, Loop
from .tones import Badness, Quantity, worst

DAMPINGS = (0.7, 0.3, 0.1, 0.03, 0.01)  # of the band that Δ is made of, from wide to narrow
SLOPES = (1, 2, 3)  # with which it falls to both sides
TURNED = 1e-6  # rad, of a phase
NEARLY = 0.99  # of the size asked for: good enough to stop
CHECKED = np.geomspace(1e-6, 1e6, 6001)  # of the frequency Δ is built for
DECADES = 3.0  # below and above the joint's own frequencies, where the critical one is looked for
FILL = 0.999  # of the bound that Δ uses at most
PHASES = np.linspace(-np.pi, np.pi, 72, endpoint=False)


@dataclass(frozen=True, eq=False)
class Delta:
    """A stable Δ built for one frequency [rad/s]; `gain`: |Δ| there, `fill`: max |Δ|/W."""

    omega: float
    numerator: tuple[float, ...]
    denominator: tuple[float, ...]
    gain: float
    fill: float

    def laws(self) -> list[Block]:
        """The laws of Δ, for the `environment` of a joint."""
        return [
            transfer("unfelt_torque", "applied", *(list(map(Fraction, p)) for p in (self.numerator, self.denominator)))
        ]


@dataclass(frozen=True, eq=False)
class Attack:
    """A Δ against stability; `reach`: |Δ T| at its frequency, above 1 if the bound allows."""

    delta: Delta
    reach: float


def seen(loop: Loop, omega: Array) -> Array:
    """|T| at each frequency, (n,)."""
    return np.asarray(abs(loop.response(omega, "applied", "unfelt")[0]))


def attack(loop: Loop, bound: Bound, factor: float, band: tuple[float, float], hints: tuple[float, ...] = ()) -> Attack:
    """The Δ with |Δ| ≤ factor·W that comes closest to closing the loop, or closes it where it does so fastest."""
    low, high = band
    grid = np.unique([*np.geomspace(low / 10**DECADES, high * 10**DECADES, 4000), *hints])
    reach = factor * FILL * bound(grid) * seen(loop, grid)
    # Above 1 everywhere counts alike; then a fast growth shows sooner than a slow one.
    best = np.argmax(reach) if reach.max() <= 1 else np.flatnonzero(reach > 1 + 0.5 * (reach.max() - 1))[-1]
    omega = float(grid[best])
    T = complex(loop.response(grid[[best]], "applied", "unfelt")[0][0])
    delta = built(lambda frequencies: factor * bound(frequencies), omega, -float(np.angle(T)))
    return Attack(delta, delta.gain * abs(T))


def reachable(loop: Loop, bound: Bound, band: tuple[float, float], hints: tuple[float, ...] = ()) -> float:
    """The factor on W from which on some Δ closes the loop; inf if none does."""
    low, high = min(band[0], *hints, np.inf), max(band[1], *hints, 0.0)

    def reach(omega: Array) -> Array:
        return np.asarray(FILL * bound(omega) * seen(loop, omega))

    _, _, most = worst([reach], (low / 10**DECADES, high * 10**DECADES), hints)
    return 1 / most if most > 0 else np.inf


def worst_within(
    loops: Sequence[Loop], quantity: Quantity, bound: Bound, band: tuple[float, float], hints: tuple[float, ...]
) -> tuple[int, Delta]:
    """The loop, and the Δ within the bound, for which a quantity of the port is worst at some frequency."""

    def at_phases(loop: Loop, omega: Array) -> Array:
        """Of every phase of the largest Δ, (phases, n)."""
        delta = FILL * bound(omega) * np.exp(1j * PHASES)[:, None]
        *applied, T = loop.response(omega, "applied", *quantity.inputs, "unfelt")
        *theta, unfelt = loop.response(omega, "theta", *quantity.inputs, "unfelt")
        closed = [free + unfelt * delta * seen / (1 - delta * T) for free, seen in zip(theta, applied, strict=True)]
        return quantity.worse(omega, *closed)

    def badness(loop: Loop) -> Badness:
        return lambda omega: np.asarray(at_phases(loop, omega).max(axis=0))

    which, omega, _ = worst([badness(loop) for loop in loops], band, hints)
    phase = PHASES[np.argmax(at_phases(loops[which], np.array([omega]))[:, 0])]
    return which, built(bound, omega, float(phase))


def built(bound: Bound, omega: float, phase: float) -> Delta:
    """A stable rational Δ that nearly fills the bound at ω [rad/s] with a phase [rad], within it everywhere."""
    size, frequencies = FILL * float(bound(np.array([omega]))[0]), CHECKED * omega
    allowed, best = np.maximum(bound(frequencies), 1e-300), Delta(omega, (0.0,), (1.0,), 0.0, 0.0)
    for slope, zeta in product(SLOPES, DAMPINGS):
        numerator, denominator = _shaped(omega, zeta, slope, (phase + np.pi) % (2 * np.pi) - np.pi)
        fill = size * float((abs(rational(numerator, denominator, frequencies)) / allowed).max())
        gain = size / max(fill, 1.0)
        if gain > best.gain:
            best = Delta(omega, tuple(gain * numerator), tuple(denominator), gain, min(fill, 1.0))
        if gain >= NEARLY * size:
            break
    return best


def _shaped(omega: float, zeta: float, slope: int, phase: float) -> tuple[Array, Array]:
    """A band-pass of gain 1 at ω with the phase asked for, by a first-order all-pass and a sign."""
    sign, rest = (1.0, phase) if phase <= 0 else (-1.0, phase - np.pi)  # (β−s)/(β+s) turns by −2 atan(ω/β): 0 … −π
    numerator: Array
    denominator: Array
    if min(-rest, np.pi + rest) < TURNED:  # a sign is enough: an all-pass would have its pole at 0 or ∞
        numerator, denominator = np.array([sign if -rest < TURNED else -sign]), np.ones(1)
    else:
        beta = omega / np.tan(-rest / 2)
        numerator, denominator = np.array([-sign, sign * beta]), np.array([1.0, beta])
    for _ in range(slope):
        numerator = np.asarray(np.polymul(numerator, [2 * zeta * omega, 0.0]), dtype=np.float64)
        denominator = np.asarray(np.polymul(denominator, [1.0, 2 * zeta * omega, omega**2]), dtype=np.float64)
    return numerator, denominator
