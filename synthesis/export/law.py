"""The controller as it is shipped: difference equations with rounded coefficients, and exactly what they compute.

    τ_d = C (F M τ_int − F_θ (I_imp A + B_imp V + K_imp M) θ) + F_d (ΔI A_d + ΔB V_d + ΔK M_d) θ,   Δ = Ĝ⁻¹ − G_imp

is (10)/(20) from the samples of τ_int and θ, with their means M and differences V and A of `motion`. C and the filters
are those of the certificate under Tustin's rule `s → c (z−1)/(z+1)`, `c = ω_B/tan(ω_B T/2)`: at ω_B, where
the certificate's claims are tight, a discrete filter has exactly the response of the continuous one, and every stable
mode stays stable.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from math import pi, tan
from typing import Any

from flint import fmpq, fmpq_poly

from ...models.controller import Compensator
from ...models.impedance import DynamicStiffness
from ...models.rational import RationalFunction, exact, fraction, to_float
from ..errors import InputError
from ..problem.setting import LOAD, Setting
from .motion import Motion
from .schur import is_schur
from .sections import DTYPE, Sections, sections_of

NEAR_NYQUIST = 0.5  # part of π/T beyond which Tustin's rule has little of the continuous filter left


@dataclass(frozen=True)
class Law:
    """The shipped controller; means are taken out of C and F_d.

    period [s]; prewarp: frequency [rad/s] at which discrete and continuous filters agree; nominal, desired: Ĝ⁻¹ and
    G_imp as rounded. A cascade without sections is a factor 1.
    """

    period: fmpq
    precision: str
    prewarp: float
    nominal: DynamicStiffness
    desired: DynamicStiffness
    error: Motion  # M, V, A before the compensator
    compensated: Motion  # M_d, V_d, A_d before F_d
    compensator: Sections
    force: Sections
    position: Sections
    derivative: Sections

    @property
    def rate(self) -> Fraction:
        """Samples per second [Hz]."""
        return 1 / fraction(self.period)

    @property
    def filters(self) -> dict[str, Sections]:
        """Every filter by its name in the exported files."""
        names = ("compensator", "force", "position", "derivative")
        return {name: getattr(self, name) for name in names}

    def feedback(self, end: str, at: Any, wish: Any, compensation: Any) -> tuple[Any, Any]:
        """`−τ_d` per θ in free motion, per τ_sea against a rigid wall: numerator and denominator.

        at: turns a polynomial of z⁻¹ into what is calculated with; wish, compensation: `M (I θ'' + B θ' + K θ)` of
        G_imp and of Ĝ⁻¹ − G_imp, in the same kind.
        """
        C, F, F_theta, F_d = self.compensator, self.force, self.position, self.derivative
        if end == "locked":
            return at(C.num * self.error.M * F.num), at(C.den * F.den)
        error, inner = at(C.num * F_theta.num * F_d.den) * wish, at(F_d.num * C.den * F_theta.den) * compensation
        return error - inner, at(C.den * F_theta.den * F_d.den)

    def idle(self, end: str) -> fmpq_poly:
        """Denominators of the filters outside that loop, of z⁻¹."""
        return self.force.den if end == "free" else self.position.den * self.derivative.den

    @cached_property
    def back_calculation(self) -> fmpq:
        """k of the anti-windup `e + k·(τ_sent − τ_d)`, a tick later: largest of 1, 1/2, … with stable `1 + k z⁻¹ C`.

        With k = 1 and no delay a disturbance observer's C = Q/(1−Q) becomes Q, fed by the torque that was really sent.
        """
        num, den = self.compensator.num, self.compensator.den
        k = fmpq(1)
        while k > fmpq(1, 10**6):
            closed = den + num * fmpq_poly([0, k])
            if is_schur([*reversed(closed.coeffs())]):
                return k
            k /= 2
        return fmpq(0)


def discretised(setting: Setting, C: Compensator, rate: Fraction, precision: str, prewarp: float) -> Law:
    """The law of a certified compensator at a rate [Hz], agreeing with it at `prewarp` [rad/s].

    Raises: InputError for a rate too low for that frequency.
    """
    nyquist = pi * float(rate)
    if prewarp > NEAR_NYQUIST * nyquist:
        least = 2 * prewarp / pi
        raise InputError(
            f"--rate {float(rate):g} Hz is too low for a bandwidth of {prewarp:.4g} rad/s: take at least {least:.3g} Hz"
        )
    c = exact(prewarp / tan(prewarp / float(rate) / 2))
    filters, loop = setting.loop.filters, setting.loop

    def of(filter_: RationalFunction) -> Sections:
        return sections_of(filter_.num, filter_.den, c, precision)

    def motion(relative_degree: int) -> Motion:
        return Motion.of(relative_degree, c, 1 / exact(rate), DTYPE[precision])

    common = filters.position is None  # one filter for the whole dynamic error belongs to C
    num, den = (C.num * filters.force.num, C.den * filters.force.den) if common else (C.num, C.den)
    error, compensated = motion(den.degree() - num.degree()), motion(filters.derivative.relative_degree)
    return Law(
        period=1 / exact(rate),
        precision=precision,
        prewarp=prewarp,
        nominal=rounded_stiffness(loop.nominal, precision),
        desired=rounded_stiffness(loop.desired, precision),
        error=error,
        compensated=compensated,
        compensator=sections_of(num, den, c, precision, error.r),
        force=Sections(()) if common else of(filters.force),
        position=Sections(()) if filters.position is None else of(filters.position),
        derivative=sections_of(filters.derivative.num, filters.derivative.den, c, precision, compensated.r),
    )


def rounded_stiffness(g: DynamicStiffness, precision: str) -> DynamicStiffness:
    """Inertia, damping and stiffness in the arithmetic of the exported code."""
    return DynamicStiffness(*(exact(float(DTYPE[precision](to_float(getattr(g, name))))) for name in LOAD))
