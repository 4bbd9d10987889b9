"""Why the paper takes α = 0.8 in (23): with Q(0) = 1 an integrator works against stiction, and the joint hunts."""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from ...errors import InputError
from ...spec.model import Spec
from ..adversary.friction import QUIET, TICK, back_and_forth, pushed
from ..equations import Compensator
from .experiment import FRICTION, Curve, Experiment, Observation

SECONDS = 200.0
EVERY = 200  # ticks between points of a curve
AXES = ("time [s]", "θ beside its last value [rad]")


def integrating(C: Compensator) -> Compensator:
    """The same Q scaled to Q(0) = 1. From C = Q/(1−Q): `Q = n/(n+d)`.

    Raises: InputError for a Q without dynamics.
    """
    size = max(map(len, C))
    if size == 1:
        raise InputError("hunting: this controller is a gain, its Q cannot be scaled to Q(0) = 1")
    n, d = ([Fraction(0)] * (size - len(part)) + [Fraction(c) for c in part] for part in C)
    scaled = [c * (n[-1] + d[-1]) / n[-1] for c in n]
    return scaled, [a + b - c for a, b, c in zip(n, d, scaled, strict=True)]


def hunting(spec: Spec, C: Compensator) -> Experiment:
    """The controller given, and the same with Q(0) = 1, under constant torques."""
    (given, _), (integrator, push) = (
        pushed(spec, law, friction=FRICTION, seconds=SECONDS, every=EVERY) for law in (C, integrating(C))
    )
    moved = [float((run.high - run.low).max()) for run in (given, integrator)]
    worst = int(np.argmax(integrator.reversals))
    rests = moved[0] <= QUIET * given.late.max()
    hunts = back_and_forth(integrator)[worst]
    how = f"back and forth by {moved[1]:.3g} rad, {int(integrator.reversals[worst])} starts and turns then"
    seen = (
        Observation("with Q(0) < 1 it comes to rest", f"moves by {moved[0]:.3g} rad in the last quarter", bool(rests)),
        Observation("with Q(0) = 1 it hunts", how, bool(hunts)),
    )
    times = TICK * EVERY * np.arange(given.traces.shape[1], dtype=float)
    late = times > SECONDS / 3
    runs = {"Q as given": given.trace("theta", worst), "the same with Q(0) = 1": integrator.trace("theta", worst)}
    curves = tuple(Curve(name, times[late], theta[late] - theta[-1]) for name, theta in runs.items())
    return Experiment(f"Hunting under {push[worst]:g} times the friction", AXES, curves, seen)
