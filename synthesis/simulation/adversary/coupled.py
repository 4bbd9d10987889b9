"""The certified port in other hands: passive environments it must be stable with, whatever the load."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ...spec.model import SeriesElasticActuator, Spec
from ..batch.environment import LIMBS, attached, held_by, second_robot, through_spring
from ..batch.run import simulate_batch
from ..batch.switched import Wall, switched
from ..block import Block
from ..equations import Compensator, desired, loads
from .stretched import vertices
from .tones import LEVELS

SECONDS = 20.0
TICK = 1e-3
KEPT = 1e-9  # growth from rounding
LIGHT, SOFT, STIFF = 0.1, 0.1, 100.0  # of the joint's own inertia and stiffness


@dataclass(frozen=True)
class Contact:
    """How joints (one per corner) behaved against an environment: the largest ratio of late to early motion."""

    environment: str
    growth: float

    @property
    def grows(self) -> bool:
        """Some joint moved more at the end than before."""
        return not self.growth <= 1 + KEPT


def environments(spec: Spec, C: Compensator) -> Iterator[tuple[str, Sequence[Block], Wall | None]]:
    """Names, laws and walls, scaled to the joint."""
    wish, load = desired(spec), loads(spec)[0]
    I, K = float(load.inertia), float(wish.stiffness)  # noqa: E741
    if isinstance(spec.actuator, SeriesElasticActuator):
        K = max(K, float(spec.actuator.spring_stiffness))
    K = K or I * 100.0
    yield "free", (), None
    yield "soft spring", attached(0, 0, SOFT * K), None
    yield "stiff spring", attached(0, 0, STIFF * K), None
    yield "light mass", attached(LIGHT * I), None
    yield "heavy mass", attached(10 * I), None
    yield "mass on a spring", through_spring(K, 0, I), None
    yield "damped mass on a stiff spring", through_spring(STIFF * K, 0.01 * (K * I) ** 0.5, I), None
    for limb in LIMBS if spec.motion == "rotary" else ():
        yield limb.name, held_by(limb), None
    yield "second robot", second_robot(spec, C, load, K, 0.01 * (K * I) ** 0.5), None
    yield "one-sided wall", (), Wall(STIFF * K, 0.02 * (STIFF * K * I) ** 0.5, 0.0)


def contacts(spec: Spec, C: Compensator) -> list[Contact]:
    """Every corner of the box against every environment, thrown at 1 rad/s from the middle and left alone."""
    found = []
    for name, laws, wall in environments(spec, C):
        joints = switched(spec, C, vertices(spec), environment=laws, wall=wall)
        start = np.zeros(joints.states)
        start[0] = 1.0
        run = simulate_batch(joints, TICK, np.zeros(round(SECONDS / TICK)), start=start, levels=13 if wall else LEVELS)
        ratio = np.where(run.late < 1e-12, 0.0, run.late / np.maximum(run.early, 1e-300))
        found.append(Contact(name, float(ratio.max())))
    return found
