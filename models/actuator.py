"""Actuators as load-independent two-ports `τ_sea = H(s) τ_d − Z_a(s) θ`, (13)-(16)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

from flint import fmpq, fmpq_poly

from .impedance import DynamicStiffness
from .rational import ONE, ZERO, RationalFunction, S, Scalar, exact, ratio, value
from .sampling import Held, Hold


@dataclass(frozen=True)
class TwoPort:
    """`H = h/d`: torque transfer with the output locked. `Z_a = z/d`: output impedance. One denominator, uncancelled.

    `d` is the actuator's own characteristic polynomial with the output locked, so a mode that cancels in `H` or `Z_a`
    still counts for stability.
    """

    h: Any  # polynomials of s, or their values somewhere
    z: Any
    d: Any
    hold: Hold | None = None

    @classmethod
    def of(cls, H: RationalFunction, Z_a: RationalFunction) -> TwoPort:
        """From transfer functions of any order; the state is taken to be that of their common denominator."""
        d = H.den * (Z_a.den // H.den.gcd(Z_a.den))
        return cls(H.num * (d // H.den), Z_a.num * (d // Z_a.den), d)

    @classmethod
    def given(cls, H: tuple[fmpq_poly, fmpq_poly], Z_a: tuple[fmpq_poly, fmpq_poly]) -> TwoPort:
        """From numerators and denominators as they stand, over the product of the two (or the one, if they agree)."""
        (h, d), (z, d_z) = H, Z_a
        return cls(h, z, d) if d == d_z else cls(h * d_z, z * d, d * d_z)

    @cached_property
    def H(self) -> Any:
        """Torque transfer with the output locked, the hold of a sampled controller included."""
        H = ratio(self.h, self.d)
        return H if self.hold is None else Held(ZERO, H, self.hold)

    @cached_property
    def Z_a(self) -> Any:
        """Output impedance: torque per angle, with τ_d = 0."""
        return ratio(self.z, self.d)

    def A_cl(self, load: DynamicStiffness) -> Any:
        """`τ_sea/τ_d` on a free load, (15): `H G⁻¹/(G⁻¹ + Z_a)`."""
        return self.H * load.rational / (load.rational + self.Z_a)

    def A_int(self, load: DynamicStiffness) -> Any:
        """`τ_sea/τ_int` on a free load, (16) with its sign corrected: `−Z_a/(G⁻¹ + Z_a)`.

        Pushing the load pulls on the spring: with the printed + sign the load would accelerate more than `τ_int/I`.
        """
        return -self.Z_a / (load.rational + self.Z_a)


IDEAL = TwoPort(fmpq_poly([1]), fmpq_poly([0]), fmpq_poly([1]))
"""`τ_act = τ_d`: H = 1, Z_a = 0."""


def torque_loop(kp: Scalar, kd: Scalar, derivative_corner: Scalar) -> RationalFunction:
    """`C_t = kp + kd·s/(1 + s/derivative_corner)`. kp [-], kd [s], derivative_corner [rad/s]."""
    return exact(kp) + exact(kd) * S / (1 + S / exact(derivative_corner))


@dataclass(frozen=True)
class SeriesElastic:
    """Motor `P_m = 1/(J s² + b_m s)` behind a spring, with `τ_m = λ τ_d + C_t (τ_d − τ_sea)`, Fig. 6 and (13).

    J [kg·m²], b_m [N·m·s/rad], K_sp [N·m/rad], C_t and λ [-].
    """

    J: Any  # exact numbers, or enclosures of uncertain ones
    b_m: Any
    K_sp: Any
    C_t: RationalFunction
    feedforward: fmpq

    @property
    def two_port(self) -> TwoPort:
        """`H = K_sp P_m (C_t+λ)/(1+K_sp P_m (1+C_t))`, `Z_a = K_sp/(1+K_sp P_m (1+C_t))`."""
        return self.over(fmpq_poly([0, 1]))

    def over(self, s: Any) -> TwoPort:
        """The two-port at a value of s."""
        n, d = value(self.C_t.num, s), value(self.C_t.den, s)
        motor = s * s * self.J + s * self.b_m
        return TwoPort(
            h=(n + d * self.feedforward) * self.K_sp,
            z=motor * d * self.K_sp,
            d=motor * d + (n + d) * self.K_sp,
        )


def A(I: Scalar, J: Scalar, K_sp: Scalar) -> RationalFunction:  # noqa: E741 (the paper's symbol)
    """`A(s) = 1/(K_sp⁻¹ s² + I⁻¹ + J⁻¹)`, (14): the undamped spring between two inertias."""
    return ONE / (S * S / exact(K_sp) + (1 / exact(I) + 1 / exact(J)))
