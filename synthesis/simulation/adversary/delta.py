"""Unstructured uncertainty at its worst: a stable rational Δ within a bound that turns the loop's own phase against it.

`G = Ĝ(1+Δ)` is the nominal load with a further torque `Δ·(τ_int + τ_sea)` that no sensor feels. What Δ sees is
`T = (τ_int + τ_sea)/unfelt torque`; the loop closes on itself where `Δ T = 1`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from ...spec.model import Spec
from ..batch.switched import Switched, switched
from ..block import Block, combination, transfer
from ..equations import Compensator, loads
from .tones import Array, responses

Bound = Callable[[Array], Array]  # W at frequencies [rad/s]

DAMPINGS = (0.7, 0.3, 0.1, 0.03, 0.01)  # of the band that Δ is made of, from wide to narrow
CHECKED = np.geomspace(1e-6, 1e6, 6001)  # of the frequency Δ is built for
DECADES = 3.0  # below and above the joint's own frequencies, where the critical one is looked for
FILL = 0.999  # of the bound that Δ uses at most


@dataclass(frozen=True, eq=False)
class Attack:
    """A Δ built against one frequency [rad/s]; `reach`: |Δ T| there, above 1 if the bound allows; `fill`: max |Δ|/W."""

    omega: float
    numerator: tuple[float, ...]
    denominator: tuple[float, ...]
    reach: float
    fill: float

    def laws(self) -> list[Block]:
        """The laws of Δ, for the `environment` of a joint."""
        delta = transfer("unfelt_torque", "felt", *(list(map(Fraction, p)) for p in (self.numerator, self.denominator)))
        return [combination("felt", tau_int=1, tau_sea=1), delta]

    def joint(self, spec: Spec, C: Compensator) -> Switched:
        """The nominal joint with this Δ."""
        return switched(spec, C, loads(spec)[:1], environment=self.laws())


def seen(spec: Spec, C: Compensator, omega: Array) -> NDArray[np.complex128]:
    """T at each frequency, (n,): with the nominal load, `Ĝ⁻¹ θ/disturbance − 1`."""
    load = loads(spec)[0]
    I, B, K = float(load.inertia), float(load.damping), float(load.stiffness)  # noqa: E741
    Z, attenuation = responses(spec, C, np.array([[I, B, K]]), omega)
    s = 1j * omega
    return np.asarray((I * s**2 + B * s + K) * attenuation[0] / Z[0] - 1)


def attack(spec: Spec, C: Compensator, bound: Bound, factor: float, band: tuple[float, float]) -> Attack:
    """The Δ with |Δ| ≤ factor·W that comes closest to closing the loop, or closes it where it does so fastest."""
    low, high = band
    grid = np.geomspace(low / 10**DECADES, high * 10**DECADES, 4000)
    reach = factor * FILL * bound(grid) * abs(seen(spec, C, grid))
    # Above 1 everywhere counts alike; then a fast growth shows sooner than a slow one.
    best = np.argmax(reach) if reach.max() <= 1 else np.flatnonzero(reach > 1 + 0.5 * (reach.max() - 1))[-1]
    return _at(spec, C, bound, factor, float(grid[best]))


def _at(spec: Spec, C: Compensator, bound: Bound, factor: float, omega: float) -> Attack:
    T = complex(seen(spec, C, np.array([omega]))[0])
    size = factor * FILL * float(bound(np.array([omega]))[0])
    phase = -np.angle(T)
    frequencies = CHECKED * omega
    allowed = factor * bound(frequencies)
    for zeta in DAMPINGS:
        numerator, denominator = _shaped(omega, zeta, size, phase)
        fill = abs(_value(numerator, denominator, frequencies)) / np.maximum(allowed, 1e-300)
        if fill.max() <= 1:
            break
    shrink = max(fill.max(), 1.0)
    gain = abs(complex(_value(numerator, denominator, np.array([omega]))[0])) / shrink
    return Attack(omega, tuple(numerator / shrink), tuple(denominator), gain * abs(T), float(fill.max() / shrink))


def _shaped(omega: float, zeta: float, size: float, phase: float) -> tuple[Array, Array]:
    """A band-pass of gain `size` at ω with the phase asked for, by a first-order all-pass and a sign."""
    sign, rest = (1.0, phase) if phase <= 0 else (-1.0, phase - np.pi)  # (β−s)/(β+s) turns by −2 atan(ω/β): 0 … −π
    beta = omega / np.tan(min(max(-rest / 2, 1e-9), np.pi / 2 - 1e-9))
    numerator = np.polymul([sign * size * 2 * zeta * omega, 0.0], [-1.0, beta])
    return numerator, np.polymul([1.0, 2 * zeta * omega, omega**2], [1.0, beta])


def _value(numerator: Array, denominator: Array, omega: Array) -> NDArray[np.complex128]:
    return np.asarray(np.polyval(numerator, 1j * omega) / np.polyval(denominator, 1j * omega))


def bound_of(spec: Spec) -> Bound | None:
    """W of the specification: its weight, or the largest |Ĝ⁻¹/G⁻¹ − 1| over its box; None for both or a table."""
    uncertainty = spec.uncertainty
    if uncertainty.table is not None or (uncertainty.weight is None) == (uncertainty.box is None):
        return None
    if uncertainty.weight is not None:
        numerator, denominator = (np.array([float(c) for c in part]) for part in (
            uncertainty.weight.numerator, uncertainty.weight.denominator))  # fmt: skip
        return lambda omega: np.asarray(abs(_value(numerator, denominator, omega)))
    return lambda omega: _of_box(spec, omega)


def _of_box(spec: Spec, omega: Array) -> Array:
    """Over the edges of the rectangle that `G⁻¹ = K − Iω² + jωB` fills: W from below, so that Δ stays within it."""
    box, plant = spec.uncertainty.box, spec.plant
    assert box is not None
    (I0, I1), (B0, B1), (K0, K1) = ((float(a), float(b)) for a, b in (box.inertia, box.damping, box.stiffness))
    s = 1j * omega
    nominal = float(plant.inertia) * s**2 + float(plant.damping) * s + float(plant.stiffness)
    low, high = K0 - I1 * omega**2, K1 - I0 * omega**2
    candidates = [end + s * B for end in (low, high) for B in (B0, B1)]
    for t in np.linspace(0, 1, 33)[1:-1]:
        candidates += [low + t * (high - low) + s * B for B in (B0, B1)]
        candidates += [end + s * (B0 + t * (B1 - B0)) for end in (low, high)]
    return np.asarray(np.max([abs(nominal / value - 1) for value in candidates], axis=0))
