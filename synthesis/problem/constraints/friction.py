"""Load-side Coulomb friction cannot cause a limit cycle if `s(1−Q̃)/Z` is strictly positive real (beyond the paper).

Friction acts as a disturbance, so its loop is closed by `θ' = s(1−Q̃)/Z · d`. The inverse, `Z/(s(1−Q̃)) =
(L·G_imp + Z₀)/s` with the loop gain L, is positive real with it, and affine in the load. `Q(0) = 1` breaks it at
ω → 0 for every K_imp > 0: an integrator against stiction hunts. With nominal stability and the ends of the axis, where
the inequality says nothing about a root at s = 0 or ∞, no load of the uncertainty can move a pole across the axis.
"""

from __future__ import annotations

from fractions import Fraction

from ..setting import Setting
from .inequality import Affine, Constraint, Gain, Inequality, Role, Source, Term, Variable, X


def friction(setting: Setting) -> tuple[Constraint, ...]:
    """Reported always, required on request."""
    loop, weighted = setting.loop, setting.uncertainty.disc
    inequalities = []
    for load in setting.uncertainty.corners():
        own = Affine.of(load.rational / loop.s)
        inequalities.append(
            Inequality(
                variable=Variable.L,
                role=Role.FLOOR,
                moduli=(Term(own, Gain.RHO),) if weighted else (),
                reals=(Term(Affine.of(0), shift=own),) if weighted else (),
                right=X * (loop.G_imp / loop.s) + Affine.of(loop.Z0(load) / loop.s),
                modulus_right=False,
                source=Source.DISC if weighted else Source.NONE,
                load=load,
            )
        )
    return (
        Constraint(
            id="friction",
            equation="beyond the paper",
            form="strictly-positive-real",
            statement="Re((L·G_imp + Z₀)/jω) ≥ v > 0 for every load: Coulomb friction cannot sustain an oscillation",
            uncertainty="every load of the box" + (", each with a disc on top" if weighted else ""),
            inequalities=tuple(inequalities),
            level=Fraction(0) if setting.spec.constraints.friction == "require" else None,
            strict=True,
            positive_real=True,
        ),
    )
