"""How θ, θ' and θ'' of the control law are formed from samples of the encoder, without a tick of lag in the loop.

A filter of relative degree r has r zeros at z = −1 under Tustin's rule: a mean `M = ((1 + z⁻¹)/2)^r` of the newest
samples, which stands before the filter here, for the torque as well. Then Tustin's own derivative
`t = c (1 − z⁻¹)/(1 + z⁻¹)` needs no more than three samples: `M t = c (1 − z⁻²)/4`, `M t² = c² (1 − z⁻¹)²/4` for r = 2.
Where r is smaller, what is missing is a backward difference; the velocity for r = 0 is that of the parabola through
three samples, `(1 − z⁻¹)(3 − z⁻¹)/(2T)`, as half a tick of lag there costs passivity.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from flint import fmpq, fmpq_poly

from ...models.impedance import DynamicStiffness
from ...models.rational import exact, to_float

MEAN, STEP = fmpq_poly([1, 1]) / 2, fmpq_poly([1, -1])  # polynomials of z⁻¹
SLOPE = {0: fmpq_poly([3, -1]), 1: fmpq_poly([1]), 2: fmpq_poly([1, 1])}  # V over a step, by r
MOST = 2  # derivatives in a dynamic stiffness


@dataclass(frozen=True)
class Motion:
    """Signals before a filter with r zeros at z = −1 taken out. velocity, acceleration: factors of the differences."""

    r: int
    velocity: fmpq
    acceleration: fmpq

    @classmethod
    def of(cls, r: int, c: fmpq, period: fmpq, rounded: Callable[[float], float]) -> Motion:
        """For Tustin's rule with constant c [rad/s]; both factors as the code holds them."""
        r = min(r, MOST)
        first = {2: c / 4, 1: c / 2, 0: 1 / period / 2}[r]
        second = {2: c * c / 4, 1: c / 2 / period, 0: 1 / period**2}[r]
        return cls(r, *(exact(float(rounded(to_float(value)))) for value in (first, second)))

    @property
    def M(self) -> fmpq_poly:
        """The mean, of z⁻¹."""
        return MEAN**self.r

    @property
    def V(self) -> fmpq_poly:
        """`M θ'` per θ, of z⁻¹."""
        return STEP * SLOPE[self.r] * self.velocity

    @property
    def A(self) -> fmpq_poly:
        """`M θ''` per θ, of z⁻¹."""
        return STEP * STEP * self.acceleration

    def stiffness(self, g: DynamicStiffness) -> fmpq_poly:
        """`M (I θ'' + B θ' + K θ)` per θ, of z⁻¹."""
        found: fmpq_poly = self.A * g.inertia + self.V * g.damping + self.M * g.stiffness
        return found
