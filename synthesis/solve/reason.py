"""What a user is told when no controller can exist."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..errors import InfeasibleError
from ..problem.constraints.inequality import Constraint

PLAIN = {"bandwidth": "attenuation", "rendering": "rendering error"}


@dataclass(frozen=True)
class Impossible:
    """Requirements that no X meets at ω: which, where [rad/s], why, and what to do instead. whose: of which family."""

    what: str
    omega: float
    why: str
    remedy: str
    whose: str = "any controller"

    def __str__(self) -> str:
        place = {0.0: "ω → 0", np.inf: "ω → ∞"}.get(self.omega, f"ω = {self.omega:.4g} rad/s")
        together = " together" if " and " in self.what else ""
        return f"{self.what} cannot hold{together} at {place} for {self.whose}: {self.why}; {self.remedy}"

    def error(self) -> InfeasibleError:
        """The error to raise for it."""
        return InfeasibleError(str(self), self.what)


def name(constraint: Constraint) -> str:
    """A constraint by its equation and form, or by the word the specification has for it."""
    if constraint.id in ("eq9", "eq12", "eq18"):
        return f"{constraint.equation} {constraint.form}"
    return PLAIN.get(constraint.id, constraint.id)
