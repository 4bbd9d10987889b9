"""Coulomb friction on the load: whether the joint comes to rest under a constant torque, or hunts.

Joint and friction are scale-free: torques in units of the friction say everything.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...spec.model import Spec
from ..batch.law import SampledLaw, law_and_compensator
from ..batch.run import Runs, simulate_batch
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
    """How it ended: the most reversals and starts in the last quarter.

    `hunting`: pushes, in units of the friction, under which some corner of the box still moved back and forth.
    """

    reversals: int
    hunting: tuple[float, ...]


def pushed(
    spec: Spec, C: Compensator, law: SampledLaw | None = None, *,
    friction: float = 1.0, seconds: float = SECONDS, every: int = 0,
) -> tuple[Runs, Array]:  # fmt: skip
    """Every corner of the box under each of `PUSHES`, three times as large for the first tenth of the time [s].

    Returns: the runs, and the push of each, in units of the friction [N·m], (corners · pushes,).
    """
    tick = law.tick if law else TICK
    ticks, corners = round(seconds / tick), vertices(spec)
    courses = friction * np.outer(PUSHES, np.where(np.arange(ticks) < ticks // 10, 3.0, 1.0))
    faults = Imperfections(load_friction=friction, stiction=STICTION)
    joints = switched(spec, None if law else C, np.repeat(corners, len(PUSHES), axis=0), faults)
    chosen = np.tile(np.arange(len(PUSHES)), len(corners)).astype(np.int64)
    runs = simulate_batch(joints, tick, courses, chosen=chosen, law=law, every=every)
    return runs, np.array(PUSHES)[chosen]


def back_and_forth(runs: Runs) -> NDArray[np.bool_]:
    """Whether each still moved to and fro in the last quarter, by more than rounding."""
    return (runs.reversals > 1) & (runs.high - runs.low > QUIET * np.maximum(runs.early, runs.late))


def rest_under_friction(spec: Spec, C: Compensator) -> Rest:
    """What becomes of every corner of the box under constant pushes; with `sampling` of the sampled controller."""
    law, _ = law_and_compensator(spec, C)
    runs, push = pushed(spec, C, law)
    return Rest(int(runs.reversals.max()), tuple(sorted({float(p) for p in push[back_and_forth(runs)]})))
