"""Compensators of classical form, P to PI-lead with a filter, and the names of all forms that may be asked for."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from .structure import FAR, Coefficients, Feedback, QFilter, Structure, convolve

if TYPE_CHECKING:
    from numpy.typing import NDArray

FARTHEST_CORNER = float(np.log(1e5))  # of a filter: as good as the form without one


@dataclass(frozen=True)
class Classical(Structure):
    """`C_imp = k·(1 + ω_i/s)·(1 + s/ω_z)/(1 + s/ω_p)·1/(1 + s/ω_f)`: gain, integrator, lead or lag, filter.

    x: the logarithms of k and of the frequencies of the factors it has.
    """

    integral: bool = False
    lead: bool = False
    filtered: bool = False

    @property
    def simpler(self) -> tuple[Structure, ...]:
        """The same without one of its factors, which is its limit; an integrator is none of any other form's."""
        return tuple(replace(self, **{name: False}) for name in ("filtered", "lead") if getattr(self, name))

    def extended(self, x: NDArray[np.float64], rng: np.random.Generator, of: Structure) -> NDArray[np.float64]:
        """With a lead whose pole cancels its zero, or with a filter as far out as it may be."""
        if self.filtered and not getattr(of, "filtered", False):
            return np.array([*x, FARTHEST_CORNER])
        at = 1 + self.integral
        return np.array([*x[:at], *[rng.uniform(-1, 3)] * 2, *x[at:]])

    @property
    def bounds(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """See `Structure`."""
        corners = self.integral + 2 * self.lead
        return (
            np.array([Feedback.gains[0]] + [-FAR] * (corners + self.filtered)),
            np.array([Feedback.gains[1]] + [FAR] * corners + [FARTHEST_CORNER] * self.filtered),
        )

    def includes(self, other: Structure) -> bool:
        """Not without its filter."""
        return isinstance(other, Classical) and other.filtered == self.filtered

    def start(self, rng: np.random.Generator) -> NDArray[np.float64]:
        """A gain of order one; the integrator acts below ω₀, the others above."""
        above = rng.uniform(0, 3, 2 * self.lead + self.filtered)
        return np.concatenate([[np.log(rng.uniform(0.1, 3.0))], rng.uniform(-3, 0, self.integral * 1), above])

    def polynomials(self, x: Any, exp: Any = np.exp) -> tuple[Coefficients, Coefficients]:
        """See `Structure`."""
        corners = [exp(x[i]) for i in range(1, self.bounds[0].size)]
        num: Coefficients = [exp(x[0])]
        den: Coefficients = [1.0]
        if self.integral:
            num, den = convolve(num, [1.0, corners.pop(0)]), [1.0, 0.0]
        if self.lead:
            zero, pole = corners.pop(0), corners.pop(0)
            num, den = convolve(num, [pole / zero, pole]), convolve(den, [1.0, pole])
        if self.filtered:
            num, den = convolve(num, [corners[0]]), convolve(den, [1.0, corners[0]])
        return num, den


FORMS: dict[str, Structure] = {"eq23": QFilter(2)}
"""What `controller.form` may ask for."""
FORMS |= {
    name + ending: Classical("pi" in name, "lead" in name, bool(ending))
    for name in ("p", "pi", "lead-lag", "pi-lead")
    for ending in ("", "-filtered")
}
