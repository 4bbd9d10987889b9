"""Noise: `|CF/(1+HCF)| ≤ gain`, command torque per noise of the torque sensor with the output locked.

The law (10)/(20) on a locked output is `τ_d = CF(n − Hτ_d)`. What the noise costs in torque limits how fast C may be.
"""

from __future__ import annotations

from ....models.rational import ONE
from ..setting import Setting
from .inequality import Affine, Constraint, Inequality, Role, Term, Variable, X


def noise(setting: Setting) -> tuple[Constraint, ...]:
    """Bound on the command torque, from a frequency upwards; only on request."""
    asked = setting.spec.constraints.noise
    if asked is None:
        return ()
    inequality = Inequality(
        variable=Variable.COMMAND,
        role=Role.CEILING,
        moduli=(Term(X),),
        right=Affine.of(ONE),
        modulus_right=True,
    )
    return (
        Constraint(
            id="noise",
            equation="(10)",
            form="command",
            statement="|CF/(1+HCF)| ≤ v: command torque per noise of the torque sensor, output locked",
            uncertainty="none: it does not depend on the load",
            inequalities=(inequality,),
            level=asked.gain,
            band=(asked.above, None),
            strict=False,
        ),
    )
