"""Every claim's statement written directly with complex numbers: what a witness is judged by."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from mpmath import mpc, mpf

from robimp.synthesis.spec.model import Filters, IdealActuator, Impedance, Plant, Polynomials, Spec


def number(value: Fraction) -> mpf:
    return mpf(value.numerator) / value.denominator


def horner(coefficients: Sequence[Fraction], s: mpc) -> mpc:
    value = mpc(0)
    for c in coefficients:
        value = value * s + number(c)
    return value


class Loop:
    """The joint and its controller at one frequency. `load`: (I, B, K) of the true load, nominal if None."""

    def __init__(self, spec: Spec, given: Polynomials, omega: mpf, load: tuple[Fraction, ...] | None) -> None:
        s = self.s = mpc(0, omega)
        ratio = horner(given.numerator, s) / horner(given.denominator, s)
        C = ratio / (1 - ratio) if spec.controller.type == "dob" else ratio
        F, F_theta, F_d = _filters(spec.controller.filters, s)
        self.H, self.Z_a = _actuator(spec, s)
        self.nominal, self.m = _stiffness(spec.plant, s), _stiffness(spec.impedance, s)
        self.g = self.nominal if load is None else sum(number(c) * s**k for c, k in zip(load, (2, 1, 0), strict=True))
        self.R, self.L = F_theta / F, self.H * C * F
        self.Q_tilde, self.Q = self.L / (1 + self.L), C * F / (1 + C * F)
        self.Z_0 = self.g + self.Z_a - self.H * F_d * (self.nominal - self.m)
        self.Z = self.Q_tilde * self.R * self.m + (1 - self.Q_tilde) * self.Z_0
        self.U = self.Q * self.R * self.m - (1 - self.Q) * F_d * (self.nominal - self.m)
        weight = spec.uncertainty.weight
        self.W_w = mpf(0) if weight is None else abs(horner(weight.numerator, s) / horner(weight.denominator, s))
        W_b = abs(self.nominal / self.g - 1)
        self.W = W_b + self.W_w + W_b * self.W_w


def _filters(filters: Filters, s: mpc) -> tuple[Any, Any, Any]:
    def low_pass(corner: Fraction | str | None) -> Any:
        return mpf(1) if corner is None or isinstance(corner, str) else 1 / (1 + s / number(corner))

    F = low_pass(filters.force)
    return F, F if filters.position is None else low_pass(filters.position), low_pass(filters.derivative)


def _stiffness(section: Plant | Impedance, s: mpc) -> mpc:
    return number(section.inertia) * s**2 + number(section.damping) * s + number(section.stiffness)


def _actuator(spec: Spec, s: mpc) -> tuple[Any, Any]:
    a = spec.actuator
    if isinstance(a, IdealActuator):
        return mpf(1), mpf(0)
    loop, K_sp = a.torque_loop, number(a.spring_stiffness)
    C_t = number(loop.kp) + number(loop.kd) * s / (1 + s / number(loop.derivative_corner))
    P = 1 / (number(a.motor_inertia) * s**2 + number(a.motor_damping) * s)
    below = 1 + K_sp * P * (1 + C_t)
    return K_sp * P * (C_t + number(loop.feedforward)) / below, K_sp / below


def slack(loop: Loop, id: str, form: str, v: mpf, attenuation: mpf) -> mpf:
    """Right minus left side of a claim's statement at value v; negative where it fails."""
    s, h = loop.s, (1 - loop.Q) * loop.nominal
    if id == "bandwidth":
        return attenuation - abs(1 - loop.Q_tilde)
    if id == "peak":
        return v - abs(1 - loop.Q_tilde)
    if id == "eq9":
        return abs(h + loop.U) - v * loop.W * abs(loop.U)
    if id == "eq18":
        return _eq18(loop, *form.split("/"), v)
    if form == "paper":
        W = v * loop.W
        return mpf("-inf") if W >= 1 else abs(s + loop.m) - abs(s - loop.m) - 2 * W / (1 - W) * abs(h)
    V, g, Z = (
        (loop.W, loop.nominal, loop.Z + (1 - loop.Q_tilde) * (loop.nominal - loop.g))
        if form == "disc"
        else (loop.W_w, loop.g, loop.Z)
    )
    if V >= 1:
        return mpf("-inf")
    c, rho = -(V**2) / (1 - V**2), V / (1 - V**2)
    rest = (1 - loop.Q_tilde) * g
    if id == "rendering":
        return v * abs(loop.m) - abs(Z - loop.m - c * rest) - rho * abs(rest)
    if id == "friction":
        Z, rest = loop.L * loop.R * loop.m + loop.Z_0, g
    return (Z / s).real - rho * abs(rest / s) - (c * rest / s).real - v


def _eq18(loop: Loop, form: str, coupling: str, v: mpf) -> mpf:
    if coupling == "frozen":
        T = loop.H * loop.U / (loop.nominal + loop.Z_a)
    else:
        T = ((1 - loop.Q) * loop.Z_a + loop.H * loop.U) / loop.nominal
    D0 = 1 - loop.Q + T
    M = {"paper": mpc(1), "lumped": loop.m / loop.nominal, "half-plane": D0}[form]
    return abs(M) - abs(D0 - M) - v * loop.W * abs(T)
