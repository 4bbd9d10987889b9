"""`control.mixsyn` (SLICOT) on the torque loop alone: |1−Q̃| under a performance weight, Q̃ rolled off beyond the loop.

What it cannot say: the load, so neither passivity nor (9) nor (18); a range; the order of the controller. A first-order
weight stands for the attenuation on [0, ω_B]; `|Q̃|` falls beyond the torque loop's natural frequency, as prudence asks.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from generalized_plant import FLOOR, natural_frequency
from task import Answer, Task
from weight_search import largest, peak_of

STEPS = 14


def solve(task: Task) -> Answer:
    """The largest weight with ‖·‖∞ ≤ 1; the norm is evaluated anew, on a grid."""
    import control
    import slycot  # noqa: F401  (control's own message does not name the package)

    H = control.ss(task.setting.loop.actuator.H.to_control())
    corner = natural_frequency(task)
    roll_off = control.ss(control.tf([1 / corner, 0.5], [1 / (100 * corner), 1]))
    effort = control.ss([], [], [], [[1e-3]])

    def design(omega_B: float) -> Any:
        try:
            K, closed, _ = control.mixsyn(H, _weight(task, omega_B), effort, roll_off)
        except Exception:  # SLICOT's word for infeasible
            return None
        return K if peak_of(task, closed) <= 1 else None

    return largest(task, design, 100 * task.omega_0, STEPS)


def _weight(task: Task, omega_B: float) -> Any:
    """W with 1/|W| = δ at omega_B [rad/s], FLOOR·δ at 0, the peak at ∞."""
    import control

    floor = task.attenuation * FLOOR
    omega_1 = omega_B / np.sqrt(task.attenuation**2 - floor**2)
    return control.ss(control.tf([1 / task.peak, omega_1], [1, omega_1 * floor]))
