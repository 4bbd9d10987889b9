"""The same differential evolution with a penalty on closed-loop poles (NumPy's roots) in the right half-plane."""

from __future__ import annotations

from task import Answer, Task

from solvers import scipy_evolution


def solve(task: Task) -> Answer:
    """Stability as a penalty."""
    return scipy_evolution.solve(task, stable=True)
