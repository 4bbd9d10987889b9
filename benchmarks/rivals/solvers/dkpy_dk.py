"""dkpy's D–K iteration on the generalized plant: uncertain inertia and damping, attenuation and passivity as blocks.

What it can and cannot say: generalized_plant.py. Inertia and damping are complex here where they are real, which costs
bandwidth, and the μ of the iteration is an upper bound on a grid.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from generalized_plant import CONTROLS, MEASUREMENTS, JointModel
from task import Answer, Task
from weight_search import largest

POINTS, ITERATIONS, FIT_ORDER, STEPS = 21, 2, 2, 6
TOLERANCE, ACCEPTED = 1e-2, 1.05  # of μ: of its bisection, and what counts as reached


def solve(task: Task) -> Answer:
    """The largest ω_B of the weight with μ ≤ 1.05; each step is a whole D–K iteration."""
    import dkpy

    omega = np.geomspace(task.omega_0 / 100, task.omega_0 * 100, POINTS)
    blocks = [dkpy.ComplexFullBlock(n, n) for n in (1, 1, 1, 2)]
    ssv = dkpy.SsvLmiBisection(bisection_atol=TOLERANCE, bisection_rtol=TOLERANCE, n_jobs=None)

    def design(omega_B: float) -> Any:
        iteration = dkpy.DkIterFixedOrder(
            controller_synthesis=dkpy.HinfSynSlicot(),
            structured_singular_value=ssv,
            d_scale_fit=dkpy.DScaleFitSlicot(),
            n_iterations=ITERATIONS,
            fit_order=FIT_ORDER,
        )
        P = JointModel(task, omega_B).generalized_plant(uncertain=True)
        K, _, mu, *_ = iteration.synthesize(P, MEASUREMENTS, CONTROLS, omega, blocks)
        return K if K is not None and mu <= ACCEPTED else None

    return largest(task, design, 10 * task.omega_0, STEPS)
