"""The bandwidth claim: how far the objective's conditions hold together."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from itertools import chain

from ..problem.constraints import constraints
from ..problem.constraints.inequality import Constraint
from .claim import Claim, Refutation, claim_of
from .outcome import Outcome
from .prover import LARGEST_LEVEL, Prover
from .sandwich import TIGHTNESS
from .witness import Witness, fails_at, short

NEEDLES = 3  # resonances overlooked by the grid that may shorten the band, one after another


def prove_bandwidth(prover: Prover) -> Claim:
    """The largest ω_B up to which every condition of the objective holds, or the attenuation where that is none."""
    wanted = [c for c in constraints(prover.subject.setting) if c.on_band and c.required]
    attenuation = next(c for c in wanted if c.id == "bandwidth")
    for conditions in (wanted, [attenuation]):
        first = min(chain.from_iterable(_failures(prover, c) for c in conditions), default=LARGEST_LEVEL)
        end = _proven_end(prover, conditions, first)
        if end is not None:
            beyond = _twin(prover, attenuation, first, end)
            return claim_of(replace(attenuation, band=(Fraction(0), end)), Outcome.PROVEN, end, beyond)
    nowhere = replace(attenuation, band=(Fraction(0), Fraction(0)))
    found = prover.witness(nowhere, prover.subject.setting.spec.objective.attenuation)
    if found is None:
        return claim_of(nowhere, Outcome.UNDECIDED, None, None)
    return claim_of(nowhere, Outcome.REFUTED, None, Refutation(Fraction(0), found))


def _proven_end(prover: Prover, conditions: list[Constraint], first: float, needles: int = NEEDLES) -> Fraction | None:
    """The largest ω_B below `first` up to which all conditions are proven; below a needle the grid overlooked."""
    for tightness in TIGHTNESS:
        end = short(first * (1 - tightness), digits=8, up=False)
        band = [(replace(c, band=(Fraction(0), end)), c.level or Fraction(0)) for c in conditions]
        if end > 0 and all(prover.decide(c, level) is Outcome.PROVEN for c, level in band):
            return end
    found = [prover.witness(c, level) for c, level in band]
    lower = min((float(w.omega) for w in found if w is not None and w.omega), default=0.0)
    return _proven_end(prover, conditions, lower, needles - 1) if needles and 0 < lower < first else None


def _failures(prover: Prover, constraint: Constraint) -> Iterator[float]:
    """Frequencies on the grid's refinement at which a band condition first fails."""
    for inequality in constraint.inequalities:
        first = prover.evaluator.first_failure(inequality, float(constraint.level or 0), prover.X)
        if first is not None:
            yield first


def _twin(prover: Prover, attenuation: Constraint, first: float, proven: Fraction) -> Refutation | None:
    """The twin: a frequency at which the attenuation fails, close to where the band ends or else its own first."""
    level = prover.subject.setting.spec.objective.attenuation
    lowered = list(prover.lowered(attenuation, 0, level))
    for start in (first, *_failures(prover, attenuation)):
        for tightness in TIGHTNESS:
            end = short(start * (1 + tightness), digits=8, up=True)
            if any(fails_at(one, end, strict=False) for one in lowered):
                return Refutation(end, Witness(end, None))
    found = prover.witness(replace(attenuation, band=(proven, 2 * proven)), level)
    return None if found is None or found.omega is None else Refutation(found.omega, found)
