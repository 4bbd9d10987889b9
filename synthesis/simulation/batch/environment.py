"""What a joint may be coupled to: passive laws that make `contact_torque` of the port's motion.

Human limbs are mass, damper and spring by measured values; each names its source.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from ...spec.model import Spec
from ..block import Block, combination, connect, integrator
from ..equations import Compensator, Load
from ..joint import free_equations

Number = Fraction | float
Array = NDArray[np.float64]


@dataclass(frozen=True)
class Limb:
    """A human joint about one axis: inertia [kg·m²], damping [N·m·s/rad], stiffness [N·m/rad], and where from."""

    name: str
    inertia: float
    damping: float
    stiffness: float
    source: str


# Forearm and hand of the two-joint limb model in J. Neurosci. 29(40), 12606-12616 (2009), table 1: I₂ = 0.06 N·m·s²
# about the centre of mass, m₂ = 1.52 kg, l₂ = 0.34 m, B = 0.05 s · K; about the elbow with the centre of mass at l₂/2:
# 0.06 + 1.52 · 0.17² = 0.104. K follows muscle force there; the two stiffnesses span relaxed to firmly held.
_SOURCE = "forearm and hand, J. Neurosci. 29(40):12606 (2009), table 1, B = 0.05 s K; K chosen"
LIMBS = (
    Limb("relaxed arm", 0.104, 0.1, 2.0, _SOURCE),
    Limb("stiff arm", 0.104, 2.0, 40.0, _SOURCE),
)


def attached(inertia: Number = 0, damping: Number = 0, stiffness: Number = 0) -> list[Block]:
    """Mass, damper and spring to the ground, held rigidly: `τ = −(I θ'' + B θ' + K θ)`; parts of zero are left out."""
    parts = {"acceleration": inertia, "velocity": damping, "theta": stiffness}
    return [combination("contact_torque", **{name: -Fraction(value) for name, value in parts.items() if value})]


def held_by(limb: Limb) -> list[Block]:
    """A limb that holds the port."""
    return attached(limb.inertia, limb.damping, limb.stiffness)


def through_spring(grip: Number, grip_damping: Number, inertia: Number, damping: Number = 0) -> list[Block]:
    """A mass on a spring and a damper: `m z'' = grip (θ−z) + grip_damping (θ'−z') − damping z'`."""
    return [
        integrator("other_theta", "other_velocity"),
        integrator("other_velocity", "other_acceleration"),
        *_grip(grip, grip_damping),
        combination(
            "other_acceleration",
            contact_torque=-1 / Fraction(inertia),
            other_velocity=-Fraction(damping) / Fraction(inertia),
        ),
    ]


def second_robot(spec: Spec, compensator: Compensator, load: Load, grip: Number, grip_damping: Number) -> list[Block]:
    """Another controlled joint, hand in hand through a spring and a damper."""
    other = free_equations(spec, compensator, load)
    theta, velocity = (other.outputs.index(name) for name in ("theta", "velocity"))
    robot = Block(
        ("other_push",), ("other_theta", "other_velocity"),
        other.A, other.B, other.C[[theta, velocity]], other.D[[theta, velocity]],
    )  # fmt: skip
    return [robot, combination("other_push", contact_torque=-1), *_grip(grip, grip_damping)]


def stable_with(joint: Block, environment: Sequence[Block]) -> complex:
    """Worst pole [rad/s] of a joint (input tau_int) coupled to an environment."""
    coupled = connect([joint, *environment, combination("tau_int", contact_torque=1)])
    return complex(max(np.linalg.eigvals(coupled.A), key=lambda pole: pole.real))


def _grip(stiffness: Number, damping: Number) -> list[Block]:
    k, d = Fraction(stiffness), Fraction(damping)
    return [combination("contact_torque", theta=-k, velocity=-d, other_theta=k, other_velocity=d)]
