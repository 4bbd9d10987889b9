"""(18), robust stability with the actuator: no zero of `D = 1 − Q + (1+Δ)T` crosses the axis, `D₀ = 1 − Q + T`.

coupling  frozen:   `T = A_cl(Ω+Q)` as printed; A_cl, which contains the true load, is kept at the nominal one.
          physical: `T = (1−Q)Z_aĜ + H(Ω+Q)`, from `Z(1+HCF)(1−Q)G`: the load appears only in Δ.
form      one small-gain test `|D₀ − M| + W|T| < |M|` with three choices of the reference M:
          paper `M = 1`, which needs |Ω| < 1 wherever A_cl ≈ 1: impossible at ω → 0 when K̂ = 0 and K_imp > 0;
          lumped `M = 1+Ω`: (9) with the weight `|A_cl−1| + W|A_cl|`;
          half-plane `M = D₀`: `W|T| < |D₀|`, exact over the disc.
All multiplied by `Ĝ⁻¹ + Z_a` (frozen) or `Ĝ⁻¹` (physical), which leaves nothing to divide by.
"""

from __future__ import annotations

from fractions import Fraction

from ..setting import Setting
from .inequality import ONE_MINUS_X, Affine, Constraint, Gain, Inequality, Role, Source, Term, Variable
from .small_gain import compensated_error

STATEMENT = {
    "paper": "|D₀−1| + v·W·|T| < 1",
    "lumped": "|D₀−(1+Ω)| + v·W·|T| < |1+Ω|",
    "half-plane": "v·W·|T| < |D₀|",
}


REMEDY = {
    "paper": "the printed form needs |Ω| < 1 where A_cl ≈ 1, and |Ω| → ∞ at ω → 0 when K̂ = 0 and K_imp > 0; "
    "use form: half-plane (exact over the disc) or form: lumped",
    "lumped": "use form: half-plane (exact over the disc)",
    "half-plane": "reduce the uncertainty",
}


def eq18(setting: Setting) -> tuple[Constraint, ...]:
    """Robust stability with actuator dynamics."""
    asked = setting.spec.constraints.eq18
    if asked is None:
        return ()
    loop = setting.loop
    H, Z_a, nominal = loop.actuator.H, loop.actuator.Z_a, loop.nominal.rational
    unit = nominal + Z_a if asked.coupling == "frozen" else nominal
    T = compensated_error(loop) * H
    if asked.coupling == "physical":
        T = T + ONE_MINUS_X * Z_a
    D0 = ONE_MINUS_X * unit + T
    reference = {
        "paper": Affine.of(unit),
        "lumped": Affine.of(unit * loop.desired.rational / nominal),
        "half-plane": D0,
    }[asked.form]
    offset = () if asked.form == "half-plane" else (Term(D0 + reference * -1),)
    inequality = Inequality(
        variable=Variable.Q,
        role=Role.RADIUS,
        moduli=(*offset, Term(T, Gain.W)),
        right=reference,
        modulus_right=True,
        source=Source.LUMPED,
    )
    meaning = "A_cl at the nominal load" if asked.coupling == "frozen" else "load and actuator coupled as they are"
    return (
        Constraint(
            id="eq18",
            equation="(18)",
            form=f"{asked.form}/{asked.coupling}",
            statement=f"{STATEMENT[asked.form]}: robustly stable with actuator, {meaning}",
            uncertainty="disc of radius W",
            inequalities=(inequality,),
            level=Fraction(1),
            remedy=REMEDY[asked.form],
        ),
    )
