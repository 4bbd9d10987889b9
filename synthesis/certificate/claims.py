"""Every claim of a specification about one controller; and, for the search, where the required ones fail."""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np

from ...models.controller import Compensator
from ..problem.constraints import constraints
from ..problem.setting import Setting
from .band import prove_bandwidth
from .claim import Claim
from .outcome import Outcome
from .prover import Prover, Subject
from .sandwich import prove_hardest, prove_largest_band
from .stability import prove_stability
from .witness import short


def certify(setting: Setting, compensator: Compensator) -> tuple[Claim, ...]:
    """Every claim of a specification about one compensator, each proven, refuted or undecided."""
    prover = Prover.of(Subject(setting, compensator))
    band = prove_bandwidth(prover)
    claims = [*prove_stability(setting, compensator)]
    for constraint in constraints(setting):
        if constraint.id == "bandwidth":
            claims.append(band)
        elif constraint.on_band:
            claims.append(prove_hardest(prover, replace(constraint, band=band.interval)))
        elif constraint.largest_band:
            claims.append(prove_largest_band(prover, constraint))
        else:
            claims.append(prove_hardest(prover, constraint))
    return tuple(claims)


@dataclass(frozen=True)
class Counterexample:
    """Where a required claim fails, for the search: a frequency [rad/s], and whether it is the objective's own band."""

    id: str
    omega: float
    on_band: bool


def counterexamples(setting: Setting, compensator: Compensator, omega_B: float) -> tuple[Counterexample, ...]:
    """Where the required claims, the objective's up to omega_B, cannot be proven; () when all are.

    A claim that fails without a frequency (stability, an undecided proof) counts at ω = ∞.
    """
    prover = Prover.of(Subject(setting, compensator))
    found = [
        Counterexample(c.id, np.inf, False)
        for c in prove_stability(setting, compensator)
        if c.status is not Outcome.PROVEN
    ]
    for asked in constraints(setting):
        if asked.level is None:
            continue
        c = replace(asked, band=(Fraction(0), short(omega_B, up=False))) if asked.on_band else asked
        if prover.decide(c, asked.level) is not Outcome.PROVEN:
            found += [Counterexample(c.id, omega, c.on_band) for omega in prover.failing(c, asked.level)]
    return tuple(found)
