"""(12), passivity of the port: `Re(Z/jω) ≥ 0`, in three forms.

paper       `|Ĝ(jω−G_imp)| + 2W/(1−W)·|1−Q| < |Ĝ(jω+G_imp)|`: the printed test with its two sides exchanged (printed, it
            asks `ω Im G_imp < 0` of an exact model, so no passive impedance passes). Ideal actuator. Sufficient.
disc        exact over the disc: Δ/(1+Δ) lies in the disc of centre c, radius ρ, and `G⁻¹ = Ĝ⁻¹(1 − Δ/(1+Δ))`, so
            `Re(Z/jω) ≥ Re(Z_nominal/jω) − Re(c(1−Q̃)Ĝ⁻¹/jω) − ρ|(1−Q̃)Ĝ⁻¹/ω|`.
structured  exact over the box: Z is affine in (I, B, K), so the corners decide; a weight, if any, as a disc on each.

Neither paper nor disc can hold up to ω = ∞ when the inertia is uncertain: the budget falls like 1/ω, the disc does not.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from ....models.impedance import DynamicStiffness
from ....models.rational import ONE
from ..setting import Setting
from .inequality import ONE_MINUS_X, Affine, Constraint, Gain, Inequality, Role, Source, Term, Variable, X


def eq12(setting: Setting) -> tuple[Constraint, ...]:
    """Passivity in the form asked for; beside it the printed form on the largest band where it holds."""
    asked = setting.spec.constraints.eq12
    if asked is None:
        return ()
    level = Fraction(1) if asked.form == "paper" else asked.margin
    band = (Fraction(0), None) if asked.band is None else asked.band
    if asked.form == "paper":
        return (_paper(setting, level, band),)
    both = setting.uncertainty.box is not None and setting.uncertainty.disc
    passive = _disc(setting, level, band) if asked.form == "disc" else _structured(setting, level, band)
    return (passive,) if both else (passive, _paper(setting, None, band))


def _paper(setting: Setting, level: Fraction | None, band: tuple[Fraction, Fraction | None]) -> Constraint:
    loop = setting.loop
    G_imp, nominal = loop.desired.rational, loop.nominal.rational
    inequality = Inequality(
        variable=Variable.Q,
        role=Role.RADIUS,
        moduli=(Term(Affine.of(loop.s - G_imp)), Term(ONE_MINUS_X * (2 * nominal), Gain.R)),
        right=Affine.of(loop.s + G_imp),
        modulus_right=True,
        source=Source.LUMPED,
    )
    filtered = loop.filters.position is not None or loop.filters.derivative != ONE
    ignored = "not passivity, for it leaves the position and derivative filters out"  # Re(Z/jω) < 0 is possible
    meaning = ignored if filtered else "with stability, passive behind an ideal actuator"
    return Constraint(
        id="eq12",
        equation="(12)",
        form="paper",
        statement="|Ĝ(jω−G_imp)| + 2vW/(1−vW)·|1−Q| < |Ĝ(jω+G_imp)|: " + meaning,
        uncertainty="disc of radius W < 1",
        inequalities=(inequality,),
        level=level,
        band=band,
        largest_band=level is None,
        remedy="use form: structured (exact over the box, whole axis), or give a band above ω = 0 on which W < 1",
    )


def _passive(setting: Setting, load: DynamicStiffness, source: Source) -> Inequality:
    loop = setting.loop
    residual = ONE_MINUS_X * (load.rational / loop.s)
    disc = source is not Source.NONE
    return Inequality(
        variable=Variable.Q_TILDE,
        role=Role.FLOOR,
        moduli=(Term(residual, Gain.RHO),) if disc else (),
        reals=(Term(Affine.of(0), shift=residual),) if disc else (),
        right=X * (loop.G_imp / loop.s) + ONE_MINUS_X * (loop.Z0(load) / loop.s),
        modulus_right=False,
        source=source,
        load=load,
    )


def _disc(setting: Setting, level: Fraction, band: tuple[Fraction, Fraction | None]) -> Constraint:
    return Constraint(
        id="eq12",
        equation="(12)",
        form="disc",
        statement="Re(Z/jω) ≥ v for every |Δ| ≤ W: with stability-locked, a passive port with v to spare",
        uncertainty="disc of radius W < 1",
        inequalities=(_passive(setting, setting.uncertainty.nominal, Source.LUMPED),),
        level=level,
        band=band,
        strict=False,
        positive_real=band[1] is None,
        remedy="use form: structured (exact over the box, whole axis), or give a band above ω = 0 on which W < 1",
    )


def _structured(setting: Setting, level: Fraction, band: tuple[Fraction, Fraction | None]) -> Constraint:
    source = Source.DISC if setting.uncertainty.disc else Source.NONE
    return Constraint(
        id="eq12",
        equation="(12)",
        form="structured",
        statement="Re(Z/jω) ≥ v for every load: with stability-locked, a passive port with v to spare",
        uncertainty="every load of the box" + ("" if source is Source.NONE else ", each with a disc on top"),
        inequalities=tuple(_passive(setting, load, source) for load in setting.uncertainty.corners()),
        level=level,
        band=band,
        strict=False,
        positive_real=band[1] is None,
        remedy="" if source is Source.NONE else "give a band on which the weight stays below 1, or reduce the weight",
    )


def least_at_end(A: Any, own: Any, V2: Any) -> Any:
    """At s = 0 and ∞, A > 0 given, what must not be negative for every real e = Δ, |e| ≤ V: `A² − (A − own)² V²`.

    A: value of Z, own: that of its part (1−Q̃)G⁻¹, both over a reference. `1 + e` times the value is `A + (A − own)e`.
    """
    return A * A - (A - own) * (A - own) * V2
