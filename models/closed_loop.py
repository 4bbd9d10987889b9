"""The closed loop of every controller in the paper: (★), from which (5), (7), (8), (17) and (21) follow.

    Z = τ_int/θ = Q̃·G_imp + (1−Q̃)·Z₀,    Q̃ = HCF/(1+HCF),    Z₀ = G⁻¹ + Z_a − H F_d (Ĝ⁻¹ − G_imp)        (★)

Derivation: the load obeys `G⁻¹θ = τ_int + τ_sea`, the actuator `τ_sea = H τ_d − Z_a θ`, the controller
`τ_d = C F (τ_int − G_imp θ) + F_d (Ĝ⁻¹ − G_imp) θ`. Eliminate τ_sea and τ_d, collect θ and τ_int:
`(Z₀ + HCF·G_imp) θ = (1 + HCF) τ_int`. With separate filters the θ channel carries `F_θ`, i.e. `G_imp F_θ/F`.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from .actuator import IDEAL, TwoPort
from .controller import Compensator, Filters
from .impedance import DynamicStiffness, inverse_dynamic_compensation
from .rational import S, at_infinity, ratio
from .sampling import Closed

if TYPE_CHECKING:
    from numpy.typing import NDArray


@dataclass(frozen=True)
class Pencil:
    """A characteristic polynomial, linear in the compensator: `on_den·C.den + on_num·C.num`."""

    on_den: Any
    on_num: Any

    def __call__(self, C: Compensator) -> Any:
        """The polynomial for one compensator."""
        return self.on_den * C.den + self.on_num * C.num


@dataclass(frozen=True)
class ImpedanceLoop:
    """Everything around the compensator: actuator, load model, desired impedance and sensor filters."""

    actuator: TwoPort
    nominal: DynamicStiffness
    desired: DynamicStiffness
    filters: Filters = field(default_factory=Filters)
    s: Any = field(default=S, repr=False, compare=False)

    @cached_property
    def G_imp(self) -> Any:
        """Desired dynamic stiffness as the θ channel sees it: `G_imp·F_θ/F`."""
        return self.desired.rational * self.filters.ratio

    @cached_property
    def compensation(self) -> Any:
        """`F_d (Ĝ⁻¹ − G_imp)`, (2)."""
        return self.filters.derivative * inverse_dynamic_compensation(self.nominal, self.desired)

    def Z0(self, load: DynamicStiffness) -> Any:
        """`Z₀ = G⁻¹ + Z_a − H F_d (Ĝ⁻¹ − G_imp)`: what the port renders without force feedback."""
        return load.rational + self.actuator.Z_a - self.actuator.H * self.compensation

    def L(self, C: Compensator) -> Any:
        """Loop gain `H C F`."""
        return self.actuator.H * C.rational * self.filters.force

    def return_difference(self, C: Compensator, end: str) -> Any:
        """`1 + HCF` against a wall ("locked"), `1 + HA/(Ĝ⁻¹ + Z_a)` in free motion, A what τ_d answers to −θ."""
        if end == "locked":
            return 1 + self.L(C)
        return (self.Z0(self.nominal) + self.L(C) * self.G_imp) / (self.nominal.rational + self.actuator.Z_a)

    def well_posed(self, C: Compensator, end: str) -> bool:
        """Whether it is > 0 at ∞: at 0 a root is there, below it any lag, H/(1+εs), makes one at about +1/ε."""
        if self.actuator.hold is not None:  # it decays
            return True
        limit = at_infinity(self.return_difference(C, end))
        return limit is None or limit > 0

    def Q_tilde(self, C: Compensator) -> Any:
        """`Q̃ = L/(1+L)`; disturbances are attenuated by `1−Q̃`. It does not depend on the load."""
        port, F = self.actuator, self.filters.force
        if port.hold is not None:
            return Closed(self.L(C))
        closed = port.h * C.num * F.num
        return ratio(closed, port.d * C.den * F.den + closed)

    def Q_ideal(self, C: Compensator) -> Any:
        """`CF/(1+CF)`: Q̃ behind an ideal actuator; the Q of (9), (12) and (18). Equals Q for an unfiltered DOB."""
        F = self.filters.force
        return ratio(C.num * F.num, C.den * F.den + C.num * F.num)

    def noise_gain(self, C: Compensator) -> Any:
        """`CF/(1+HCF)`: command torque per noise of the torque sensor, output locked."""
        port, F = self.actuator, self.filters.force
        if port.hold is not None:
            return Closed(self.L(C), C.rational * F)
        command = C.num * F.num
        return ratio(port.d * command, port.d * C.den * F.den + port.h * command)

    def Z(self, C: Compensator, load: DynamicStiffness) -> Any:
        """Apparent impedance `τ_int/θ`, (★) [N·m/rad]."""
        X = self.Q_tilde(C)
        return X * self.G_imp + (1 - X) * self.Z0(load)

    def Z_at(self, C: Compensator, load: DynamicStiffness, omega: NDArray[np.float64]) -> NDArray[np.complex128]:
        """Values of Z, (★) [N·m/rad], with a hold too, where Z is no function of s alone. omega: (n,) [rad/s]."""
        if self.actuator.hold is None:
            return np.asarray(self.Z(C, load).at(omega))
        X = self.Q_tilde(C).at(omega)
        return np.asarray(X * self.G_imp.at(omega) + (1 - X) * self.Z0(load).at(omega))

    def dynamic_error_gain(self, load: DynamicStiffness) -> Any:
        """`N = G G_imp/(1 − G(Ĝ⁻¹ − G_imp))`, (22), ideal actuator: (21) reads `θ/τ_int = G_imp⁻¹ (1+C)N/(1+CN)`."""
        G = 1 / load.rational
        return G * self.desired.rational / (1 - G * (self.nominal.rational - self.desired.rational))

    def locked(self) -> Pencil:
        """Poles against a rigid wall: zeros of `1 + HCF` and the poles of filters that feed the motor."""
        port, F, rest = self.actuator, self.filters.force, self._filters_beside_force()
        return Pencil(rest * port.d * F.den, rest * port.h * F.num)

    def free(self, load: DynamicStiffness) -> Pencil:
        """Poles in free motion: zeros of Z, with every mode of actuator, filters and controller counted."""
        port, F, F_d = self.actuator, self.filters.force, self.filters.derivative
        F_theta = self.filters.position or F
        difference = self.nominal.polynomial - self.desired.polynomial
        uncontrolled = (port.d * load.polynomial + port.z) * F_d.den - port.h * F_d.num * difference
        if self.filters.position is None:
            return Pencil(F.den * uncontrolled, F.num * F_d.den * port.h * self.desired.polynomial)
        return Pencil(
            F.den * F_theta.den * uncontrolled, F_theta.num * F.den * F_d.den * port.h * self.desired.polynomial
        )

    def _filters_beside_force(self) -> Any:
        rest = self.filters.derivative.den
        return rest if self.filters.position is None else rest * self.filters.position.den

    def with_ideal_actuator(self) -> ImpedanceLoop:
        """The same loop around `τ_act = τ_d`, for the paper's sections II and III."""
        return ImpedanceLoop(IDEAL, self.nominal, self.desired, self.filters)
