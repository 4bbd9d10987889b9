"""Joints set in motion and left alone: whether what they do dies out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..batch.run import Runs, simulate_batch
from ..batch.switched import Switched
from .tones import LEVELS

PER_RADIAN = 10  # ticks per radian of the fastest motion looked at
LONGEST = 2_000_000  # ticks
E_FOLDS = 12.0  # of the slowest motion, if there is time


@dataclass(frozen=True)
class Decay:
    """Largest |θ| [rad] in the second and in the last quarter of the time [s], and the worst pole [rad/s]."""

    early: float
    late: float
    duration: float
    worst_pole: float

    @property
    def grows(self) -> bool:
        """By more than rounding."""
        return not self.late <= self.early * (1 + 1e-9)


def left_alone(joint: Switched, omega: float) -> Decay:
    """A linear joint from θ' = 1 rad/s at rest position, sampled finely for a motion at ω [rad/s]."""
    poles = np.linalg.eigvals(joint.flows[0, 0, :, : joint.states])
    rate = float(poles.real.max())
    tick = 1 / (PER_RADIAN * omega)
    ticks = int(np.clip(E_FOLDS / max(abs(rate), 1e-12) / tick, 1000, LONGEST))
    start = np.zeros(joint.states)
    start[0] = 1.0
    run = simulate_batch(joint, tick, np.zeros(ticks), start=start, levels=LEVELS)
    return decay_of(run, tick, rate)


def decay_of(run: Runs, tick: float, rate: float, joint: int = 0) -> Decay:
    """What a run says of one joint."""
    return Decay(float(run.early[joint]), float(run.late[joint]), float(run.ticks[joint] * tick), rate)
