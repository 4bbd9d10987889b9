"""What a user is told when no controller can exist."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..errors import InfeasibleError, RobimpError, UndecidedError
from ..problem.constraints.inequality import Constraint, Role

PLAIN = {"bandwidth": "attenuation", "rendering": "rendering error"}


@dataclass(frozen=True)
class Impossible:
    """Requirements that no X meets at ω: which, where [rad/s], why, and what to do instead. whose: of which family.

    shared: whether ω is where all of them fail; else `why` says where each does.
    """

    what: str
    omega: float
    why: str
    remedy: str
    whose: str = "any controller"
    shared: bool = True

    def __str__(self) -> str:
        at = f" at {place(self.omega)}" if self.shared else ""
        return f"{self.what} cannot hold{self._together}{at} for {self.whose}: {self._rest}"

    @property
    def _together(self) -> str:
        return " together" if " and " in self.what else ""

    @property
    def _rest(self) -> str:
        return f"{self.why}; {self.remedy}" if self.remedy else self.why

    def error(self) -> RobimpError:
        """The error to raise for it."""
        return InfeasibleError(str(self), self.what)


@dataclass(frozen=True)
class Unmet(Impossible):
    """Requirements that a solver finds no Q̃ for, of a family that is not every controller: evidence, and no proof."""

    def __str__(self) -> str:
        return (
            f"no controller was found, and by the solver's word {self.what} cannot hold{self._together} for "
            f"{self.whose}, on a grid, which is evidence but no proof: {self._rest}"
        )

    def error(self) -> RobimpError:
        """The error to raise for it: nothing is decided."""
        return UndecidedError(str(self))


def place(omega: float) -> str:
    """A frequency [rad/s], or one of the ends of the axis."""
    return {0.0: "ω → 0", np.inf: "ω → ∞"}.get(omega, f"ω = {omega:.4g} rad/s")


def name(constraint: Constraint) -> str:
    """A constraint by its equation and form, or by the word the specification has for it."""
    if constraint.id in ("eq9", "eq12", "eq18"):
        return f"{constraint.equation} {constraint.form}"
    return PLAIN.get(constraint.id, constraint.id)


def shortfall(constraint: Constraint, best: float, who: str = "any X") -> str:
    """What is asked of a constraint and the best level that is within reach; nan where none is."""
    asked = float(constraint.level or 0)
    if np.isnan(best):
        return f"no level is within reach of {who} there"
    if constraint.role is Role.CEILING:
        return f"at most {asked:.4g} is asked, the least {who} reaches is {best:.4g}"
    if constraint.role is Role.FLOOR:
        return f"at least {asked:.4g} is asked, the most {who} reaches is {best:.4g}"
    return f"holds at best for {best:.4g} × the uncertainty"
