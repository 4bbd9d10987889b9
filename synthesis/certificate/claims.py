"""Every claim of a specification about one controller; and, for the search, where the required ones fail."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np

from ...models.controller import Compensator
from ..problem.constraints import constraints
from ..problem.setting import Setting
from .band import prove_bandwidth
from .claim import Claim, Refutation
from .enclosure.claims import (
    prove_boxes,
    prove_constraints,
    prove_tolerance,
    prove_winding,
    required_of,
    tolerant,
)
from .enclosure.exclusion import excluded
from .enclosure.joint import family_of
from .enclosure.prover import CellProver
from .enclosure.tolerance import Required, holds, weakest
from .outcome import Outcome
from .prover import Prover, Subject
from .sandwich import prove_hardest, prove_largest_band
from .stability import prove_stability, unstable_behind_ideal
from .witness import Witness, short


@np.errstate(all="ignore")
def certify(setting: Setting, compensator: Compensator) -> tuple[Claim, ...]:
    """Every claim of a specification about one compensator, each proven, refuted or undecided.

    Questions about polynomials are decided by polynomials, on the whole axis; the others on cells.
    """
    hold = setting.loop.actuator.hold
    claims = [*(prove_stability(setting, compensator) if hold is None else prove_winding(setting, compensator))]
    claims += prove_boxes(setting, compensator)
    found = (_by_polynomials if setting.polynomial else prove_constraints)(setting, compensator)
    claims += (_refuted_behind_ideal(setting, compensator, claim) for claim in found)
    return (*claims, *prove_tolerance(setting, compensator, claims))


def _refuted_behind_ideal(setting: Setting, C: Compensator, claim: Claim) -> Claim:
    """A claim that supposes a nominal joint stable behind an ideal actuator: refuted at every frequency without it."""
    if not unstable_behind_ideal(setting, C, (claim.id, claim.form)):
        return claim
    anywhere = Refutation(Fraction(1), Witness(claim.interval[0], None))
    return replace(claim, status=Outcome.REFUTED, margin=None, refuted_at=anywhere)


def _by_polynomials(setting: Setting, compensator: Compensator) -> Iterator[Claim]:
    prover = Prover.of(Subject(setting, compensator))
    band = tolerant(setting, compensator, prove_bandwidth(prover))
    for constraint in constraints(setting):
        if constraint.id == "bandwidth":
            yield band
        elif constraint.on_band:
            yield prove_hardest(prover, replace(constraint, band=band.interval))
        elif constraint.largest_band:
            yield prove_largest_band(prover, constraint)
        else:
            yield prove_hardest(prover, constraint)


@dataclass(frozen=True)
class Counterexample:
    """Where a required claim fails, for the search: a frequency [rad/s], and whether it is the objective's own band."""

    id: str
    omega: float
    on_band: bool


@np.errstate(all="ignore")
def counterexamples(setting: Setting, compensator: Compensator, omega_B: float) -> tuple[Counterexample, ...]:
    """Where the required claims, the objective's up to omega_B, cannot be proven; () when all are.

    A claim that fails without a frequency (stability, an undecided proof) counts at ω = ∞.
    """
    claims = prove_stability if setting.loop.actuator.hold is None else prove_winding
    found = [
        Counterexample(c.id, np.inf, False) for c in claims(setting, compensator) if c.status is not Outcome.PROVEN
    ]
    required = required_of(setting, short(omega_B, up=False))
    ideal = [c for c, _ in required if unstable_behind_ideal(setting, compensator, (c.id, c.form))]
    found += [Counterexample(c.id, np.inf, False) for c in ideal]
    if setting.polynomial:
        prover = Prover.of(Subject(setting, compensator))
        for c, level in required:
            if prover.decide(c, level) is not Outcome.PROVEN:
                found += [Counterexample(c.id, omega, c.on_band) for omega in prover.failing(c, level)]
    else:
        found += _on_cells(CellProver(family_of(setting, compensator)), required)
    return tuple(found) or _beyond_constraints(setting, compensator, required)


def _on_cells(prover: CellProver, required: Required) -> list[Counterexample]:
    found = []
    for c, level in required:
        decided = prover.decide([(c, level)])
        if not decided.low > 0:
            at = decided.at if decided.high < 0 else None
            found.append(Counterexample(c.id, np.inf if at is None else at.omega, c.on_band))
    return found


def _beyond_constraints(setting: Setting, C: Compensator, required: Required) -> tuple[Counterexample, ...]:
    """What is looked at once every constraint holds: stability of the boxes, and the tolerance asked for."""
    family, asked = family_of(setting, C), setting.spec.constraints.tolerance
    boxes = CellProver(replace(family, loads=True))
    found = [
        Counterexample(f"stability-{end}", np.inf, False) for end in ("free", "locked") if not excluded(boxes, end)
    ]
    if not found and asked is not None and not holds(family, required, asked):
        weak = weakest(family, required)
        place = (np.inf, False) if weak is None else (weak.point.omega, weak.constraint.on_band)
        found.append(Counterexample("tolerance", *place))
    return tuple(found)
