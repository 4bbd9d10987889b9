"""SciPy's SLSQP on the gridded inequalities from random starts: the band's grid scales with ω_B, itself a variable."""

from __future__ import annotations

import time

import numpy as np
from gridded import BACK_OFF, Array, Gridded
from task import Answer, Task


def solve(task: Task, *, stable: bool = False) -> Answer:
    """The best of as many random starts as the time limit allows."""
    from scipy.optimize import minimize

    gridded, deadline = Gridded(task), time.monotonic() + task.limit
    low, high = np.array(gridded.bounds).T
    rng, starts, best = np.random.default_rng(0), 0, None

    def slack(z: Array) -> Array:
        Q, omega_B = gridded.q(z[:-1]), task.omega_0 * np.exp(z[-1])
        attenuated = 1 - gridded.sensitivity(Q, gridded.band * omega_B) / task.attenuation
        rows = [gridded.slack(Q) - BACK_OFF, np.nan_to_num(attenuated, nan=-1e3, neginf=-1e3)]
        return np.concatenate([*rows, [-gridded.growth(Q) - BACK_OFF]] if stable else rows)

    def in_time(_: Array) -> None:
        if time.monotonic() > deadline:
            raise StopIteration

    while time.monotonic() < deadline:
        starts += 1
        end = minimize(
            lambda z: -z[-1],
            np.append(_start(task.order, rng), np.log(0.1)),
            method="SLSQP",
            bounds=[*zip(low, high, strict=True), (-6.0, 6.0)],
            constraints={"type": "ineq", "fun": slack},
            callback=in_time,
            options={"maxiter": 200},
        )
        Q = gridded.q(np.clip(end.x[:-1], low, high))
        feasible = gridded.slack(Q).min() >= 0 and (not stable or gridded.growth(Q) < 0)
        if feasible and (best is None or gridded.omega_B(Q) > gridded.omega_B(best)):
            best = Q
    if best is None:
        return Answer(None, f"no feasible point from {starts} starts")
    return Answer(gridded.candidate(best), f"{starts} starts")


def _start(order: int, rng: np.random.Generator) -> Array:
    """Poles around ω₀, and Q a multiple below 1 of an all-pole low-pass."""
    n = order // 2
    alpha = rng.uniform(0.2, 0.9)
    return np.concatenate([rng.uniform(-1, 2, n), rng.uniform(0.2, 1, n), np.full(order - 1, alpha)])
