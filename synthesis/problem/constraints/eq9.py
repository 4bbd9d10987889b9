"""(9), robust stability with an ideal actuator: `W|Ω+Q| < |1+Ω|`, convex in Q.

From (8) the poles in free motion are the zeros of `1 − Q + (1+Δ)(Ω+Q) = 1 + Ω + Δ(Ω+Q)`; with a stable nominal loop no
Δ of the disc can move one across the axis. Multiplied by |Ĝ⁻¹|, which leaves K̂ = 0 without a pole. With a derivative
filter the right side is `|1 − Q + F_d…|`, still the nominal loop.
"""

from __future__ import annotations

from fractions import Fraction

from ..setting import Setting
from .inequality import ONE_MINUS_X, Constraint, Gain, Inequality, Role, Source, Term, Variable
from .small_gain import compensated_error


def eq9(setting: Setting) -> tuple[Constraint, ...]:
    """Robust stability, ideal actuator."""
    if setting.spec.constraints.eq9 is None:
        return ()
    loop = setting.loop
    U = compensated_error(loop)
    inequality = Inequality(
        variable=Variable.Q,
        role=Role.RADIUS,
        moduli=(Term(U, Gain.W),),
        right=ONE_MINUS_X * loop.nominal.rational + U,
        modulus_right=True,
        source=Source.LUMPED,
    )
    return (
        Constraint(
            id="eq9",
            equation="(9)",
            form="printed",
            statement="v·W·|Ω+Q| < |1+Ω|: robustly stable behind an ideal actuator for every |Δ| ≤ v·W",
            uncertainty="disc of radius W",
            inequalities=(inequality,),
            level=Fraction(1),
            remedy="reduce the uncertainty: where Q cannot act, W must stay below 1",
        ),
    )
