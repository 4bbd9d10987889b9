"""The boxes of loads, impedances and actuators stretched about the nominal joint until something gives."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from itertools import product
from math import inf

import numpy as np

from ...spec.model import Interval, Spec
from ..batch.environment import attached
from ..block import Block
from ..equations import Compensator, middle
from .loop import Array, Loop, free
from .tones import RESISTANCE, worst

FINE = 1e-4  # relative, of a stretch
FASTER = 10.0  # the environment's own slope of reactance over the joint's


def vertices(spec: Spec, stretch: float = 1.0) -> Array:
    """Corners (k, 3) of the box, each side stretched about the nominal value; without a box the nominal load."""
    plant, box = spec.plant, spec.uncertainty.box
    nominal = np.array([float(plant.inertia), float(plant.damping), float(plant.stiffness)])
    if box is None:
        return nominal[None]
    ends = np.array([[float(v) for v in side] for side in (box.inertia, box.damping, box.stiffness)])
    corners = np.unique(np.array(list(product(*ends))), axis=0)
    return np.asarray(nominal + stretch * (corners - nominal))


def ranges_stretched(spec: Spec, stretch: Fraction) -> Spec:
    """The specification with its ranges of impedances about their middle, and of the actuator about its own value."""
    wish, box = spec.impedance, spec.uncertainty.actuator
    wider = {name: _wider(value, middle(value), stretch) for name, value in wish if isinstance(value, tuple)}
    drive = {name: _wider(value, getattr(spec.actuator, name), stretch) for name, value in box or () if value}
    uncertainty = spec.uncertainty
    if box is not None:
        uncertainty = uncertainty.model_copy(update={"actuator": box.model_copy(update=drive)})
    return spec.model_copy(update={"impedance": wish.model_copy(update=wider), "uncertainty": uncertainty})


def stretch_of(spec: Spec, joint: Spec, load: Array) -> float:
    """The factor by which the boxes must be stretched to hold a joint with a load (3,); inf outside every one of them.

    The largest of |p − nominal| over the half-range on p's side, of every parameter of load, impedance and actuator.
    """
    plant, uncertain = spec.plant, spec.uncertainty
    sides: list[tuple[float, float, Interval | None]] = [
        (float(p), float(getattr(plant, name)), getattr(uncertain.box, name) if uncertain.box else None)
        for name, p in zip(("inertia", "damping", "stiffness"), load, strict=True)
    ]
    for name, value in spec.impedance:
        if isinstance(value, tuple):
            sides.append((float(getattr(joint.impedance, name)), float(middle(value)), value))
    for name, value in uncertain.actuator or ():
        if value:
            sides.append((float(getattr(joint.actuator, name)), float(getattr(spec.actuator, name)), value))
    return max(_of_half(*side) for side in sides)


def _of_half(p: float, nominal: float, interval: Interval | None) -> float:
    if p == nominal:
        return 0.0
    half = abs(float(interval[p > nominal]) - nominal) if interval else 0.0
    return abs(p - nominal) / half if half else inf


def _wider(interval: Interval, about: Fraction, stretch: Fraction) -> Interval:
    low, high = interval
    return about + stretch * (low - about), about + stretch * (high - about)


def joints(spec: Spec, C: Compensator, loads: Array) -> list[Loop]:
    """The joint with each load (k, 3)."""
    return [free(spec, C, load) for load in loads]


def stretch_to_yield(spec: Spec, C: Compensator, band: tuple[float, float], most: float = 20.0) -> float | None:
    """Smallest stretch at which some corner yields to a motion (`Re(Z/jω) < 0`); None if none does up to `most`."""

    def yields(stretch: float) -> bool:
        corners = vertices(spec, stretch)
        if corners[:, 0].min() <= 0:
            return True
        return hardest(spec, C, corners, band)[2] > 0

    if not yields(most):
        return None
    low, high = 0.0, most
    while high - low > FINE * high:
        middle_ = (low + high) / 2
        low, high = (low, middle_) if yields(middle_) else (middle_, high)
    return high if vertices(spec, high)[:, 0].min() > 0 else None


def hardest(
    spec: Spec, C: Compensator, loads: Array, band: tuple[float, float], hints: tuple[float, ...] = ()
) -> tuple[int, float, float]:
    """Which load, at what frequency [rad/s], resists motion least, and `−Re(Z/jω)` there."""
    each = [(lambda omega, loop=loop: RESISTANCE.of(loop, omega)) for loop in joints(spec, C, loads)]
    return worst(each, band, hints)


@dataclass(frozen=True, eq=False)
class Partner:
    """A mass and a spring (passive, without loss) tuned to what a joint feeds at one frequency [rad/s]."""

    omega: float
    inertia: float
    stiffness: float

    def laws(self) -> list[Block]:
        """Held rigidly at the port."""
        return attached(self.inertia, 0, self.stiffness)


def partner(loop: Loop, omega: float) -> Partner:
    """The mass and spring that cancel the joint's reactance at ω, where its resistance is negative, and resonate there.

    Their reactance rises so steeply that the joint's own slope does not count: what remains at ω is a resonance with
    negative resistance, and it grows.
    """
    near = omega * np.array([1 - 1e-4, 1.0, 1 + 1e-4])
    port = 1 / (1j * near * loop.response(near, "theta", "push")[0])
    reactance, slope = port[1].imag, abs(port[2] - port[0]) / (near[2] - near[0])
    steep = max(FASTER * slope, 1.01 * abs(reactance) / omega)
    return Partner(omega, (steep - reactance / omega) / 2, omega**2 * (steep + reactance / omega) / 2)
