"""`control.hinfsyn` (SLICOT) on the generalized plant of the nominal joint: attenuation and passivity of that one load.

What it can and cannot say: generalized_plant.py; on top of that the box of loads is missing. The γ that `hinfsyn`
returns lies below the norm of the loop it returns, so the norm is evaluated anew, on a grid.
"""

from __future__ import annotations

from typing import Any

from generalized_plant import CONTROLS, MEASUREMENTS, JointModel
from task import Answer, Task
from weight_search import largest, peak_of

STEPS = 14


def solve(task: Task) -> Answer:
    """The largest ω_B of the weight with ‖·‖∞ ≤ 1."""
    import control
    import slycot  # noqa: F401  (control's own message does not name the package)

    def design(omega_B: float) -> Any:
        P = JointModel(task, omega_B).generalized_plant(uncertain=False)
        try:
            K, closed, _, _ = control.hinfsyn(P, MEASUREMENTS, CONTROLS)
        except Exception:  # SLICOT's word for infeasible
            return None
        return K if peak_of(task, closed) <= 1 else None

    return largest(task, design, 100 * task.omega_0, STEPS)
