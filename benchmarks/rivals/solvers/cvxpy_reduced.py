"""The convex program written straightforwardly with cvxpy: rebuilt at each step of the bisection, then reduced.

`Q̃ = H·X`, X in a Laguerre basis; attenuation, peak, and passivity at the corners of the box are convex in Q̃. (9) and
(18) are about Q and stay out. `Q = X/(1+X(1−H))` has the order of basis and actuator together; balanced truncation
(SLICOT) brings it to the order asked for. Nothing tells the reduction about the constraints, so smaller ω_B are tried
until the reduced Q passes the gridded inequalities.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from gridded import Gridded, Pair
from task import Answer, Task

TERMS, POINTS, STEPS = 20, 300, 10
RETREATS = (1.0, 0.8, 0.6, 0.4, 0.25, 0.15, 0.1)  # shares of the largest ω_B
BACK_OFF = 1e-3


def solve(task: Task) -> Answer:
    """Bisection on ω_B for STEPS or until the time limit, then reductions for as long again."""
    omega, pole = np.geomspace(task.omega_0 / 300, task.omega_0 * 300, POINTS), 2 * task.omega_0
    deadline, low, high, steps = time.monotonic() + task.limit, task.omega_0 / 30, task.omega_0 * 30, 0
    while steps < STEPS and time.monotonic() < deadline:
        steps += 1
        middle = float(np.sqrt(low * high))
        low, high = (middle, high) if _feasible(task, omega, middle, pole) is not None else (low, middle)
    gridded, first, deadline = Gridded(task), None, time.monotonic() + task.limit
    for share in RETREATS:
        x = _feasible(task, omega, share * low, pole)
        if x is None or time.monotonic() > deadline:
            break
        Q = _reduced(task, x, pole)
        note = f"{low:.4g} rad/s at order {TERMS + 2} + actuator; reduced from {share:g} of that"
        if gridded.slack(Q).min() >= 0 and gridded.growth(Q) < 0:
            return Answer(gridded.candidate(Q), note)
        first = first or Answer(gridded.candidate(Q), f"{note}, violates its own grid; smaller shares tried")
    return first or Answer(None, f"infeasible at every bandwidth tried, {steps} steps")


def _feasible(task: Task, omega: Any, omega_B: float, pole: float) -> Any:
    """Coefficients of X that attenuate up to omega_B [rad/s] on the grid, or None."""
    import cvxpy as cp

    s, loop = 1j * omega, task.setting.loop
    basis = [(pole / (s + pole)) ** 2 * ((pole - s) / (pole + s)) ** k for k in range(TERMS)]
    x = cp.Variable(TERMS)
    Q_tilde = (loop.actuator.H.at(omega)[:, None] * np.array(basis).T) @ x
    left = cp.abs(1 - Q_tilde)
    demands = [left[omega <= omega_B] <= task.attenuation * (1 - BACK_OFF), left <= task.peak * (1 - BACK_OFF)]
    for vertex in task.setting.vertices(actuators=False):
        for load in task.setting.uncertainty.corners():
            wish, rest = vertex.loop.G_imp.at(omega) / s, vertex.loop.Z0(load).at(omega) / s
            scale = 1 / np.abs(rest)
            passive = cp.real(cp.multiply(scale * (wish - rest), Q_tilde)) + scale * rest.real
            demands.append(passive >= BACK_OFF * scale.min())
    problem = cp.Problem(cp.Minimize(cp.norm(x)), demands)
    try:
        problem.solve(solver=cp.CLARABEL)
    except cp.SolverError:
        return None
    return x.value if problem.status in (cp.OPTIMAL, cp.OPTIMAL_INACCURATE) else None


def _reduced(task: Task, x: Any, pole: float) -> Pair:
    """Q = X/(1 + X(1−H)) in state space, truncated to the order asked for, in powers of s/ω₀."""
    import control

    low_pass = control.ss([[-pole]], [[1]], [[pole]], [[0]])
    all_pass = control.ss([[-pole]], [[1]], [[2 * pole]], [[-1]])
    X = control.ss([], [], [], [[0.0]])
    for c in x[::-1]:  # Horner: one copy of the chain
        X = all_pass * X + float(c)
    H = control.ss(task.setting.loop.actuator.H.to_control())
    Q = control.balred(control.feedback(low_pass * low_pass * X, 1 - H), task.order, method="truncate")
    tf = control.ss2tf(control.ss(Q.A / task.omega_0, Q.B / task.omega_0, Q.C, 0 * Q.D))
    return np.trim_zeros(tf.num[0][0], "f"), tf.den[0][0]
