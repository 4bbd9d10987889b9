"""One file per solver, each with `solve(task) -> Answer`. To add one: its file, and its name here."""

from __future__ import annotations

from importlib import import_module

from task import Answer, Task

NAMES = (
    "robimp",
    "paper_tuning",
    "scipy_evolution",
    "scipy_evolution_stable",
    "scipy_slsqp",
    "scipy_slsqp_stable",
    "cvxpy_reduced",
    "control_mixsyn",
    "control_hinfsyn",
    "dkpy_dk",
)


def solve(name: str, task: Task) -> Answer:
    """Run one solver. Raises: ImportError when a package it needs is missing."""
    answer: Answer = import_module(f"solvers.{name}").solve(task)
    return answer
