"""What bounds `1−Q̃`, the factor left of a load disturbance: the bandwidth (the objective) and the peak."""

from __future__ import annotations

from fractions import Fraction

from ....models.rational import ONE
from ..setting import Setting
from .inequality import ONE_MINUS_X, Affine, Constraint, Inequality, Role, Term, Variable

_SENSITIVITY = Inequality(
    variable=Variable.Q_TILDE,
    role=Role.CEILING,
    moduli=(Term(ONE_MINUS_X),),
    right=Affine.of(ONE),
    modulus_right=True,
)


def bandwidth(setting: Setting) -> tuple[Constraint, ...]:
    """`|1−Q̃| ≤ attenuation` on [0, ω_B]; ω_B is what synthesis maximises."""
    return (
        Constraint(
            id="bandwidth",
            equation="(7)",
            form="attenuation",
            statement=f"|1−Q̃| ≤ {setting.spec.objective.attenuation} on [0, ω_B]: load disturbances are attenuated",
            uncertainty="none: Q̃ does not depend on the load",
            inequalities=(_SENSITIVITY,),
            level=setting.spec.objective.attenuation,
            on_band=True,
            strict=False,
        ),
    )


def peak(setting: Setting) -> tuple[Constraint, ...]:
    """`|1−Q̃| ≤ peak` at every frequency."""
    level: Fraction | None = setting.spec.constraints.peak
    return (
        Constraint(
            id="peak",
            equation="(7)",
            form="sensitivity",
            statement="|1−Q̃| ≤ v: no disturbance is amplified by more",
            uncertainty="none: Q̃ does not depend on the load",
            inequalities=(_SENSITIVITY,),
            level=level,
            strict=False,
        ),
    )
