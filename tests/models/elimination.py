"""The joint's equations of motion in the Laplace domain, and their elimination: the tests' own derivation of theory."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import sympy as sp

from robimp.models.rational import RationalFunction, descending

s = sp.Symbol("s")
I, B, K = sp.symbols("I B K", positive=True)  # noqa: E741
J, b_m, K_sp, feedforward = sp.symbols("J b_m K_sp lambda", positive=True)
C, Q, C_t, H, Z_a = sp.symbols("C Q C_t H Z_a")
F, F_theta, F_d = sp.symbols("F F_theta F_d")
g_hat, G_imp = sp.symbols("g_hat G_imp")  # g_hat: the nominal dynamic stiffness Ĝ⁻¹
theta, phi, tau_int, tau_sea, tau_m, tau_d, d = sp.symbols("theta phi tau_int tau_sea tau_m tau_d d")

LOAD = sp.Eq((I * s**2 + B * s + K) * theta, tau_int + tau_sea + d)  # (1); the actuator's torque is tau_sea
SPRING = sp.Eq(tau_sea, K_sp * (phi - theta))
MOTOR = sp.Eq((J * s**2 + b_m * s) * phi, tau_m - tau_sea)
TORQUE_LOOP = sp.Eq(tau_m, feedforward * tau_d + C_t * (tau_d - tau_sea))
SERIES_ELASTIC = (SPRING, MOTOR, TORQUE_LOOP)
TWO_PORT = (sp.Eq(tau_sea, H * tau_d - Z_a * theta),)
IDEAL_ACTUATOR = (sp.Eq(tau_sea, tau_d),)
LAW = sp.Eq(tau_d, C * (F * tau_int - F_theta * G_imp * theta) + F_d * (g_hat - G_imp) * theta)  # (10), (20)

g = I * s**2 + B * s + K


def eliminate(equations: Iterable[sp.Eq], unknowns: Sequence[sp.Symbol]) -> dict[sp.Symbol, sp.Expr]:
    """The unknowns as functions of the inputs."""
    (solution,) = sp.linsolve(list(equations), list(unknowns))
    return dict(zip(unknowns, solution, strict=True))


def ratio(response: sp.Expr, stimulus: sp.Symbol) -> sp.Expr:
    """Transfer function from one input; responses are linear in the inputs."""
    return sp.together(sp.diff(response, stimulus))


def expression(r: RationalFunction) -> sp.Expr:
    """A rational function of the models as a SymPy expression."""

    def poly(p: object) -> sp.Expr:
        return sp.Poly([sp.Rational(c.numerator, c.denominator) for c in descending(p)], s).as_expr()  # type: ignore[arg-type]

    return poly(r.num) / poly(r.den)


def identical(a: sp.Expr, b: sp.Expr | RationalFunction) -> bool:
    """Equal as functions: their difference has the numerator zero."""
    other = expression(b) if isinstance(b, RationalFunction) else b
    numerator, _ = sp.fraction(sp.together(a - other))
    return bool(sp.expand(numerator) == 0)
