"""What becomes of a linear joint that is thrown and left alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .loop import Loop

PER_RADIAN = 10  # ticks per radian of the motion looked at
WINDOW = 600  # ticks looked at, early and late
LONGEST = 2_000_000  # ticks
E_FOLDS = 12.0  # of the slowest motion, if there is time
LEG, LEGS = 150.0, 4  # e-folds of the slowest motion, and how often


@dataclass(frozen=True)
class Decay:
    """Largest |θ| early and late, in the same unit, and the worst pole's real part [rad/s]."""

    early: float
    late: float
    rate: float

    @property
    def growth(self) -> float:
        """Late over early motion."""
        return self.late / max(self.early, 1e-300)

    @property
    def grows(self) -> bool:
        """By more than rounding."""
        return not self.late <= self.early * (1 + 1e-9)


def left_alone(loop: Loop, omega: float | None = None) -> Decay:
    """A joint at θ = 0 with some speed, sampled finely for a motion at ω [rad/s]; by default that of its worst pole."""
    worst = loop.poles.worst or 0j
    omega = omega or abs(worst) or 1.0
    ticks = int(np.clip(E_FOLDS / max(abs(worst.real), 1e-12) * PER_RADIAN * omega, 4 * WINDOW, LONGEST))
    return Decay(*loop.alone(omega, ticks, WINDOW, PER_RADIAN), worst.real)


@dataclass(frozen=True)
class Fading:
    """Rate [/s] at which motion dies out at last, from a run, and by how much that still changed."""

    rate: float
    change: float


def fading(loop: Loop) -> Fading:
    """What is left of a joint thrown and left alone, until only the slowest of its motion remains."""
    *_, before, last = loop.fading(LEG, LEGS)
    return Fading(float(last), abs(float(last - before)))
