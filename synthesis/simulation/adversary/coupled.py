"""The certified port in other hands: passive environments it must be stable with, whatever the load."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ...spec.model import SeriesElasticActuator, Spec
from ..batch.environment import LIMBS, attached, held_by, second_robot, through_spring
from ..batch.law import law_and_compensator
from ..batch.run import simulate_batch
from ..batch.switched import Wall, switched
from ..block import Block
from ..equations import Compensator, desired, loads
from .loop import free
from .motion import left_alone
from .stretched import vertices

SECONDS = 20.0
TICK = 1e-3
KEPT = 1e-9  # growth from rounding
WALL = "one-sided wall"
LIGHT, SOFT, STIFF = 0.1, 0.1, 100.0  # of the joint's own inertia and stiffness


@dataclass(frozen=True)
class Contact:
    """How the worst of the corners behaved against an environment: the ratio of late to early motion."""

    environment: str
    growth: float

    @property
    def grows(self) -> bool:
        """It moved more at the end than before."""
        return not self.growth <= 1 + KEPT


def environments(spec: Spec, C: Compensator) -> Iterator[tuple[str, Sequence[Block]]]:
    """Names and laws, scaled to the joint."""
    K, I = _scale(spec)  # noqa: E741
    yield "free", ()
    yield "soft spring", attached(0, 0, SOFT * K)
    yield "stiff spring", attached(0, 0, STIFF * K)
    yield "light mass", attached(LIGHT * I)
    yield "heavy mass", attached(10 * I)
    yield "mass on a spring", through_spring(K, 0, I)
    yield "damped mass on a stiff spring", through_spring(STIFF * K, 0.01 * (K * I) ** 0.5, I)
    for limb in LIMBS if spec.motion == "rotary" else ():
        yield limb.name, held_by(limb)
    if spec.sampling is None:  # the other one, of the same kind, is passive as a continuous one is
        yield "second robot", second_robot(spec, C, loads(spec)[0], K, 0.01 * (K * I) ** 0.5)


def _scale(spec: Spec) -> tuple[float, float]:
    """Stiffness and inertia that the joint knows."""
    wish, load = desired(spec), loads(spec)[0]
    I, K = float(load.inertia), float(wish.stiffness)  # noqa: E741
    if isinstance(spec.actuator, SeriesElasticActuator):
        K = max(K, float(spec.actuator.spring_stiffness))
    return K or I * 100.0, I


def contacts(spec: Spec, C: Compensator) -> Iterator[Contact]:
    """Every corner of the box in every company; the one whose worst pole is furthest right is thrown and left alone."""
    for name, laws in environments(spec, C):
        worst = max((free(spec, C, load, laws) for load in vertices(spec)), key=lambda loop: loop.rate)
        yield Contact(name, left_alone(worst).growth)
    yield against_wall(spec, C)


def against_wall(spec: Spec, C: Compensator) -> Contact:
    """Thrown at 1 rad/s at a one-sided wall from its surface; with `sampling` the sampled controller."""
    K, I = _scale(spec)  # noqa: E741
    wall = Wall(STIFF * K, 0.02 * (STIFF * K * I) ** 0.5, 0.0)
    law, continuous = law_and_compensator(spec, C)
    joints = switched(spec, continuous, vertices(spec), wall=wall)
    start = np.zeros(joints.states)
    start[0] = 1.0
    tick = law.tick if law else TICK
    run = simulate_batch(joints, tick, np.zeros(round(SECONDS / tick)), law=law, start=start)
    ratio = np.where(run.late < 1e-12, 0.0, run.late / np.maximum(run.early, 1e-300))
    return Contact(WALL, float(ratio.max()))
