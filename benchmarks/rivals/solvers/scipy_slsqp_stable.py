"""The same SLSQP with the largest real part of the closed-loop poles (NumPy's roots) as one more constraint."""

from __future__ import annotations

from task import Answer, Task

from solvers import scipy_slsqp


def solve(task: Task) -> Answer:
    """Stability as a constraint."""
    return scipy_slsqp.solve(task, stable=True)
