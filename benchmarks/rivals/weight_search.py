"""What the H∞ solvers share: the search for the largest performance weight, and the reduction to the order asked."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np
from gridded import Gridded, Pair
from task import Answer, Task

RETREATS = (1.0, 0.6, 0.4, 0.25, 0.15, 0.1)  # shares of the largest weight


def largest(task: Task, design: Callable[[float], Any], high: float, steps: int) -> Answer:
    """Bisection for the largest weight, then retreats until the controller of the order asked for passes the grid.

    design: ω_B of the weight [rad/s] → compensator in state space, or None where the design fails.
    """
    low, deadline, found = task.omega_0 / 100, time.monotonic() + task.limit, None
    for _ in range(steps):
        if time.monotonic() < deadline:
            middle = float(np.sqrt(low * high))
            K = design(middle)
            low, high, found = (low, middle, found) if K is None else (middle, high, K)
    if found is None:
        return Answer(None, "the design fails at every weight tried")
    gridded, first, deadline = Gridded(task), None, time.monotonic() + task.limit
    for share in RETREATS:
        K = found if share == 1 else design(share * low)
        if K is not None:
            Q, note = (
                reduced_q(task, K),
                f"{_claimed(task, K):.4g} rad/s at order {K.nstates}; reduced from {share:g} of that",
            )
            if gridded.slack(Q).min() >= 0 and gridded.growth(Q) < 0:
                return Answer(gridded.candidate(Q), note)
            first = first or Answer(gridded.candidate(Q), f"{note}, violates its own grid; smaller shares too")
        if time.monotonic() > deadline:
            break
    return first or Answer(None, "no design to reduce")


def reduced_q(task: Task, C: Any) -> Pair:
    """`Q = C/(1+C)` in powers of s/ω₀, by balanced truncation if its order is larger than asked for."""
    import control

    Q = control.minreal(control.feedback(control.ss(C), 1), verbose=False)
    if Q.nstates > task.order:
        Q = control.balred(Q, task.order, method="truncate")
    tf = control.ss2tf(control.ss(Q.A / task.omega_0, Q.B / task.omega_0, Q.C, 0 * Q.D))
    numerator = np.asarray(tf.num[0][0], dtype=float)
    numerator[np.abs(numerator) < 1e-12 * np.abs(numerator).max()] = 0
    return np.trim_zeros(numerator, "f"), np.asarray(tf.den[0][0], dtype=float)


def peak_of(task: Task, closed: Any) -> float:
    """Largest singular value of a closed loop on a grid; infinite if it is unstable."""
    if closed.poles().real.max() >= 0:
        return float("inf")
    response = closed(1j * np.geomspace(task.omega_0 / 1e4, task.omega_0 * 1e4, 600))
    return float(np.linalg.svd(np.moveaxis(response, -1, 0), compute_uv=False).max())


def _claimed(task: Task, C: Any) -> float:
    """Bandwidth [rad/s] of the compensator before reduction, on a grid."""
    omega = np.geomspace(task.omega_0 / 300, task.omega_0 * 300, 1500)
    left = np.abs(1 / (1 + task.setting.loop.actuator.H.at(omega) * C(1j * omega)))
    beyond = np.flatnonzero(left > task.attenuation)
    return float(omega[max(0, (beyond[0] if beyond.size else omega.size) - 1)])
