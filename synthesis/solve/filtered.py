"""A structure behind a sensor filter whose corner is searched with it, and the structure a specification asks for."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from ..spec.model import FREE, Spec
from .classical import FARTHEST_CORNER, FORMS
from .corner import Corner
from .structure import FAR, Coefficients, Feedback, Filter, QFilter, Structure, few_digits

if TYPE_CHECKING:
    from numpy.typing import NDArray

AT_END = 0.1  # of a corner to the end of those searched, on the logarithmic scale: it is at that end


@dataclass(frozen=True)
class Filtered(Structure):
    """A family behind a sensor filter `F = 1/(1 + s/ω_f)` of free corner, which acts on the whole dynamic error.

    x: log ω_f, then the parameters of the controller, which is the family's own: F is no part of Q or C_imp.
    """

    family: Structure

    @property
    def simpler(self) -> tuple[Structure, ...]:
        """Simpler families behind a filter as well, and the family without one, which is the limit of a far corner."""
        return (*(Filtered(family) for family in self.family.simpler), self.family)

    def extended(self, x: NDArray[np.float64], rng: np.random.Generator, of: Structure) -> NDArray[np.float64]:
        """With the same corner, or with one as far out as it may be."""
        if isinstance(of, Filtered):
            return np.array([x[0], *self.family.extended(x[1:], rng, of.family)])
        return np.array([FARTHEST_CORNER, *x])

    def includes(self, other: Structure) -> bool:
        """Not without a filter: there has to be a corner."""
        return isinstance(other, Filtered) and self.family.includes(other.family)

    @property
    def bounds(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """See `Structure`."""
        low, high = self.family.bounds
        return np.array([-FAR, *low]), np.array([FARTHEST_CORNER, *high])

    def start(self, rng: np.random.Generator) -> NDArray[np.float64]:
        """A corner around and above ω₀: the best may lie below, and most starts far above end at the highest."""
        return np.array([rng.uniform(-1, 3), *self.family.start(rng)])

    def polynomials(self, x: Any, exp: Any = np.exp) -> tuple[Coefficients, Coefficients]:
        """See `Structure`."""
        return self.family.polynomials(x[1:], exp)

    def sensor_filter(self, x: Any, exp: Any = np.exp) -> Filter:
        """See `Structure`."""
        corner = exp(x[0])
        return [corner], [1.0, corner]

    def corner(self, x: NDArray[np.float64], omega_0: float) -> Corner:
        """See `Structure`."""
        highest, lowest = x[0] > FARTHEST_CORNER - AT_END, x[0] < AT_END - FAR
        end: Literal["", "lowest", "highest"] = "highest" if highest else "lowest" if lowest else ""
        return Corner(few_digits(float(np.exp(x[0])) * omega_0), end)


def structure_of(spec: Spec) -> Structure:
    """The structure a specification asks for; it has `order` or `form`."""
    controller = spec.controller
    if controller.form is not None:
        family = FORMS[controller.form]
    else:
        family = (QFilter if controller.type == "dob" else Feedback)(controller.order or 0)
    return Filtered(family) if controller.filters.force == FREE else family
