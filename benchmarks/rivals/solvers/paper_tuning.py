"""The paper's hand tuning: (23) with α = 0.8, ω = 50 rad/s, 2ζ = 1.415.

The paper tunes one joint. On others ω keeps its ratio to the torque loop's natural frequency √(K_sp(1+kp)/J), and the
order is always 2.
"""

from __future__ import annotations

from generalized_plant import natural_frequency
from task import PROBLEMS, Answer, Candidate, Task, exact_q

ALPHA, OMEGA, TWICE_ZETA = 0.8, 50.0, 1.415


def solve(task: Task) -> Answer:
    """No search at all."""
    tuned = Task.of(PROBLEMS["haninger2016"], task.order, task.limit)
    omega = OMEGA * natural_frequency(task) / natural_frequency(tuned)
    Q = exact_q([ALPHA * omega**2], [1, TWICE_ZETA * omega, omega**2])
    return Answer(Candidate(Q, None), f"order 2, ω = {omega:.4g}")
