"""The box of loads stretched about its nominal load until something gives: stability, or passivity."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np

from ...spec.model import Spec
from ..batch.environment import attached
from ..batch.switched import Switched, switched
from ..block import Block
from ..equations import Compensator
from .tones import Array, responses, worst, yielding

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


def worst_poles(spec: Spec, C: Compensator, loads: Array) -> Array:
    """Real part of the worst pole [rad/s] of each load in free motion."""
    joint = switched(spec, C, loads)
    return np.asarray(np.linalg.eigvals(joint.flows[:, 0, :, : joint.states]).real.max(axis=1))


def stretch_to_yield(spec: Spec, C: Compensator, band: tuple[float, float], most: float = 20.0) -> float | None:
    """Smallest stretch at which some corner yields to a motion (`Re(Z/jω) < 0`); None if none does up to `most`."""

    def yields(stretch: float) -> bool:
        corners = vertices(spec, stretch)
        if corners[:, 0].min() <= 0:
            return True
        load, omega = worst(spec, C, corners, yielding, band)
        Z, _ = responses(spec, C, load[None], np.array([omega]))
        return bool((Z[0, 0] / (1j * omega)).real < 0)

    if not yields(most):
        return None
    low, high = 0.0, most
    while high - low > FINE * high:
        middle = (low + high) / 2
        low, high = (low, middle) if yields(middle) else (middle, high)
    return high if vertices(spec, high)[:, 0].min() > 0 else None


@dataclass(frozen=True, eq=False)
class Partner:
    """A mass and a spring (passive, without loss) tuned to what a joint feeds at one frequency [rad/s]."""

    omega: float
    inertia: float
    stiffness: float

    def laws(self) -> list[Block]:
        """Held rigidly at the port."""
        return attached(self.inertia, 0, self.stiffness)

    def joint(self, spec: Spec, C: Compensator, load: Array) -> Switched:
        """The joint coupled to it."""
        return switched(spec, C, load[None], environment=self.laws())


def partner(spec: Spec, C: Compensator, load: Array, omega: float) -> Partner:
    """The mass and spring that cancel the joint's reactance at ω, where its resistance is negative, and resonate there.

    Their reactance rises so steeply that the joint's own slope does not count: what remains at ω is a resonance with
    negative resistance, and it grows.
    """
    near = omega * np.array([1 - 1e-4, 1.0, 1 + 1e-4])
    Z, _ = responses(spec, C, load[None], near)
    port = Z[0] / (1j * near)
    reactance, slope = port[1].imag, abs(port[2] - port[0]) / (near[2] - near[0])
    steep = max(FASTER * slope, 1.01 * abs(reactance) / omega)
    return Partner(omega, (steep - reactance / omega) / 2, omega**2 * (steep + reactance / omega) / 2)
