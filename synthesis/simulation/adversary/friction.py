"""Coulomb friction on the load: whether the joint comes to rest under a constant torque, or hunts.

Joint and friction are scale-free: torques in units of the friction say everything.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...spec.model import Spec
from ..batch.law import law_and_compensator
from ..batch.run import simulate_batch
from ..batch.switched import Imperfections, switched
from ..equations import Compensator
from .loop import Array
from .stretched import vertices

SECONDS = 60.0
TICK = 1e-3
STICTION = 1.5  # with 1, Coulomb's law, an integrator creeps to rest as well
PUSHES = (0.5, 1.5, 3.0, 10.0)  # of the friction
QUIET = 1e-9  # of the largest angle: smaller a range is rest


@dataclass(frozen=True)
class Rest:
    """How it ended: the largest range [rad per N·m of friction] in the last quarter, and its reversals and starts.

    `hunting`: pushes, in units of the friction, under which some corner of the box still moved back and forth.
    """

    range: float
    reversals: int
    hunting: tuple[float, ...]


def rest_under_friction(spec: Spec, C: Compensator, loads: Array | None = None, seconds: float = SECONDS) -> Rest:
    """For every load (the box's corners) pushes that are three times as large for the first tenth of the time."""
    table = vertices(spec) if loads is None else loads
    law, continuous = law_and_compensator(spec, C)
    tick = law.tick if law else TICK
    ticks = round(seconds / tick)
    courses = np.outer(PUSHES, np.where(np.arange(ticks) < ticks // 10, 3.0, 1.0))
    joints = switched(
        spec, continuous, np.repeat(table, len(PUSHES), axis=0), Imperfections(load_friction=1.0, stiction=STICTION)
    )
    chosen = np.tile(np.arange(len(PUSHES)), len(table)).astype(np.int64)
    run = simulate_batch(joints, tick, courses, chosen=chosen, law=law)
    moved = run.high - run.low
    hunts = (run.reversals > 1) & (moved > QUIET * np.maximum(run.early, run.late))
    return Rest(
        float(moved.max()), int(run.reversals.max()), tuple(sorted({PUSHES[i] for i in chosen[hunts]})),
    )  # fmt: skip
