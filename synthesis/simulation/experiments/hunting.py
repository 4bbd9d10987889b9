"""Why the paper takes α = 0.8 in (23): with Q(0) = 1 an integrator works against stiction, and the joint hunts."""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from ...errors import InputError
from ...spec.model import Spec
from ..adversary.stretched import vertices
from ..batch.run import Runs, simulate_batch
from ..batch.switched import Imperfections, switched
from ..equations import Compensator
from .experiment import FRICTION, Curve, Experiment, Observation

TICK = 1e-3
SECONDS = 200.0
EVERY = 200  # ticks between points of a curve
STICTION = 1.5  # with Coulomb's law alone an integrator creeps to rest as well
PUSHES = (0.5, 1.5, 3.0, 10.0)  # of the friction, three times as large for the first tenth of the time
QUIET = 1e-9  # of the largest angle: a smaller range is rest
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


def pushed(spec: Spec, C: Compensator) -> Runs:
    """Every corner of the box under each push, with friction and stiction."""
    ticks = round(SECONDS / TICK)
    courses = FRICTION * np.outer(PUSHES, np.where(np.arange(ticks) < ticks // 10, 3.0, 1.0))
    faults = Imperfections(load_friction=FRICTION, stiction=STICTION)
    corners = vertices(spec)
    joints = switched(spec, C, np.repeat(corners, len(PUSHES), axis=0), faults)
    return simulate_batch(joints, TICK, courses, chosen=np.tile(np.arange(len(PUSHES)), len(corners)), every=EVERY)


def hunting(spec: Spec, C: Compensator) -> Experiment:
    """The controller given, and the same with Q(0) = 1, under constant torques."""
    given, integrator = pushed(spec, C), pushed(spec, integrating(C))
    moved = [float((run.high - run.low).max()) for run in (given, integrator)]
    worst = int(np.argmax(integrator.reversals))
    rests = moved[0] <= QUIET * given.late.max()
    hunts = moved[1] > QUIET * integrator.late[worst] and integrator.reversals[worst] > 1
    how = f"back and forth by {moved[1]:.3g} rad, {int(integrator.reversals[worst])} starts and turns then"
    seen = (
        Observation("with Q(0) < 1 it comes to rest", f"moves by {moved[0]:.3g} rad in the last quarter", bool(rests)),
        Observation("with Q(0) = 1 it hunts", how, bool(hunts)),
    )
    times = TICK * EVERY * np.arange(given.traces.shape[1], dtype=float)
    late = times > SECONDS / 3
    runs = {"Q as given": given.trace("theta", worst), "the same with Q(0) = 1": integrator.trace("theta", worst)}
    curves = tuple(Curve(name, times[late], theta[late] - theta[-1]) for name, theta in runs.items())
    return Experiment(f"Hunting under {PUSHES[worst % len(PUSHES)]:g} times the friction", AXES, curves, seen)
