"""The stability claims: both ends, free and locked, with every mode counted."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

from flint import fmpq_poly

from ...models.controller import Compensator
from ...models.rational import exact
from ..problem.constraints.inequality import WHOLE
from ..problem.setting import Setting
from .claim import Claim, Refutation
from .hurwitz import decay_rate, is_hurwitz
from .outcome import Outcome
from .sandwich import TIGHTNESS
from .witness import short

MODES = {  # equation and meaning of the characteristic function at each end
    "free": ("denominator of (8) and (17)", "every mode in free motion"),
    "locked": ("1 + HCF", "every mode against a rigid wall"),
}


def prove_stability(setting: Setting, C: Compensator) -> Iterator[Claim]:
    """Nominal stability free (zeros of Z) and against a rigid wall (zeros of 1+HCF), with the decay rate."""
    loop = setting.loop
    for end, pencil in (("free", loop.free(loop.nominal)), ("locked", loop.locked())):
        yield _stability(end, pencil(C), loop.well_posed(C, end))


IDEAL = {("eq9", "printed"): "free", ("eq12", "paper"): "locked"}  # stated for an ideal actuator: the end that decides


def unstable_behind_ideal(setting: Setting, C: Compensator, kind: tuple[str, str]) -> bool:
    """Whether a claim is about the joint behind an ideal actuator, whose nominal is not stable there."""
    if kind not in IDEAL:
        return False
    ideal, end = setting.loop.with_ideal_actuator(), IDEAL[kind]
    pencil = ideal.free(ideal.nominal) if end == "free" else ideal.locked()
    return not (is_hurwitz(pencil(C)) and ideal.well_posed(C, end))


def _stability(end: str, p: fmpq_poly, well_posed: bool) -> Claim:
    equation, what = MODES[end]
    rate = decay_rate(p)
    levels = [short(rate * (1 - tightness), up=False) for tightness in TIGHTNESS] if rate > 0 else []
    proven = next((v for v in [*levels, Fraction(0)] if well_posed and is_hurwitz(p, exact(v))), None)
    refuted = None
    if proven is not None:
        beyond = (short(rate * (1 + tightness), up=True) for tightness in TIGHTNESS)
        value = next((v for v in beyond if v > proven and not is_hurwitz(p, exact(v))), None)
        refuted = None if value is None else Refutation(value, None)
    return Claim(
        id=f"stability-{end}",
        equation=equation,
        form="hurwitz",
        statement=f"{what} decays faster than exp(−v·t), nominal load",
        uncertainty="none: nominal load",
        interval=WHOLE,
        required=True,
        status=Outcome.REFUTED if proven is None else Outcome.PROVEN,
        margin=proven,
        refuted_at=Refutation(Fraction(0), None) if proven is None else refuted,
    )
