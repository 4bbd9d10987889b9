"""SciPy's differential evolution on the gridded inequalities, violations as a penalty; stability not asked for."""

from __future__ import annotations

import time

import numpy as np
from gridded import BACK_OFF, Array, Gridded
from task import Answer, Task

WEIGHT = 100.0  # of the worst violation, beside log ω_B


def solve(task: Task, *, stable: bool = False) -> Answer:
    """Maximise log ω_B − WEIGHT·violation until the time limit."""
    from scipy.optimize import differential_evolution

    gridded, deadline = Gridded(task), time.monotonic() + task.limit

    def cost(x: Array) -> float:
        Q = gridded.q(x)
        violation = max(0.0, BACK_OFF - float(gridded.slack(Q).min()))
        if stable:
            violation += max(0.0, BACK_OFF + gridded.growth(Q))
        return WEIGHT * violation - float(np.log(gridded.omega_B(Q) / task.omega_0))

    found = differential_evolution(
        cost,
        gridded.bounds,
        maxiter=1_000_000,
        tol=1e-8,
        rng=0,
        polish=False,
        callback=lambda intermediate_result: time.monotonic() > deadline,
    )
    Q, note = gridded.q(found.x), f"{found.nfev} evaluations"
    if gridded.slack(Q).min() < 0:
        return Answer(None, f"no feasible point, {note}")
    return Answer(gridded.candidate(Q), note)
