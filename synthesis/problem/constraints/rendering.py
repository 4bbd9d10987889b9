"""Rendering error `|Z − G_imp| ≤ ε|G_imp|` on [0, ω_B] for every load. Z is affine in the load, so the corners decide.

A weight on top moves Z by `−(1−Q̃)G⁻¹·e`, e in the disc of Δ/(1+Δ): centre c, radius ρ.
"""

from __future__ import annotations

from ..setting import Setting
from .inequality import ONE_MINUS_X, Affine, Constraint, Gain, Inequality, Role, Source, Term, Variable, X


def rendering(setting: Setting) -> tuple[Constraint, ...]:
    """Relative rendering error: required when the objective names one, reported otherwise."""
    loop, weighted = setting.loop, setting.uncertainty.disc
    wish = loop.desired.rational
    inequalities = []
    for load in setting.uncertainty.corners():
        residual = ONE_MINUS_X * load.rational
        nominal_error = X * loop.G_imp + ONE_MINUS_X * loop.Z0(load) + Affine.of(-wish)
        error = Term(nominal_error, shift=residual * -1 if weighted else None)
        unmodelled = Term(residual, Gain.RHO)
        inequalities.append(
            Inequality(
                variable=Variable.Q_TILDE,
                role=Role.CEILING,
                moduli=(error, unmodelled) if weighted else (error,),
                right=Affine.of(wish),
                modulus_right=True,
                source=Source.DISC if weighted else Source.NONE,
                load=load,
            )
        )
    return (
        Constraint(
            id="rendering",
            equation="(★)",
            form="every-load",
            statement="|Z − G_imp| ≤ v·|G_imp| on [0, ω_B], for every load",
            uncertainty="every load of the box" + (", each with a disc on top" if weighted else ""),
            inequalities=tuple(inequalities),
            level=setting.spec.objective.rendering_error,
            on_band=True,
            strict=False,
        ),
    )
