"""Every claim of a certificate, proven again for the shipped coefficients in the sampled loop."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from typing import Any

import numpy as np

from ...models.controller import Compensator
from ..certificate.claim import Claim, claim_of
from ..certificate.enclosure.band import prove_bandwidth
from ..certificate.enclosure.joint import family_of
from ..certificate.outcome import Outcome
from ..certificate.stability import MODES
from ..problem.constraints import constraints
from ..problem.constraints.inequality import Constraint
from ..problem.setting import Setting
from .box import Box
from .carried import Carried
from .law import Law
from .pulse import prove_sampled
from .sampled_joint import SampledProver

Written = dict[str, Any]
NOMINAL = ("hurwitz", "winding")
NOT_NEEDED = "the shipped coefficients themselves are what is proven here"
PRINTED = "the printed form speaks of the continuous law"


@dataclass(frozen=True)
class Reproof:
    """One exported law against the claims of its certificate."""

    setting: Setting
    C: Compensator
    law: Law

    @cached_property
    def prover(self) -> SampledProver:
        """Of frequency responses."""
        return SampledProver(family_of(self.setting, self.C), law=self.law)

    @cached_property
    def _nominal(self) -> dict[str, Claim]:
        return {end: prove_sampled(self.setting, self.law, end) for end in MODES}

    @cached_property
    def band(self) -> Claim:
        """The bandwidth that is left."""
        return prove_bandwidth(self.prover)

    def carried(self, written: Written) -> Carried:
        """What becomes of one claim of the certificate."""
        kind = written["id"], written["form"]
        margin = None if written["margin"] is None else Fraction(written["margin"])
        left = Carried(*kind, written["required"], margin, None)
        if kind[0].startswith("stability"):
            end = kind[0].removeprefix("stability-")
            if kind[1] in NOMINAL:
                return replace(left, claim=self._nominal[end])
            if self._nominal[end].status is not Outcome.PROVEN:
                return replace(left, note="the nominal loop is not proven stable")
            return replace(left, claim=Box(family_of(self.setting, self.C), self.law, end).prove(margin))
        if kind[0] == "tolerance":
            return replace(left, note=NOT_NEEDED, needless=True)
        if kind == ("eq12", "paper"):
            return replace(left, note=PRINTED)
        if kind[0] == "bandwidth":
            return replace(left, claim=self.band)
        found = (c for c in constraints(self.setting, kind[0]) if (c.id, c.form) == kind)
        return self._constraint(next(found), left)

    def _constraint(self, constraint: Constraint, left: Carried) -> Carried:
        if constraint.on_band and self.band.margin is None:
            return replace(left, note="there is no bandwidth left")
        band = self.band.interval if constraint.on_band else self.prover.clipped(constraint.band)
        if band[1] is not None and band[0] >= band[1]:
            return replace(left, note="lies beyond half the sampling rate")
        constraint = replace(constraint, band=band)
        claim = self.prover.hardest(constraint)
        if claim.status is Outcome.UNDECIDED and constraint.level is not None:
            found = self.prover.decide([(constraint, constraint.level)])
            if found.low > 0:
                claim = claim_of(constraint, Outcome.PROVEN, constraint.level, None)
        if claim.status is Outcome.PROVEN or constraint.level is None:
            return replace(left, claim=claim)
        weaker = self.prover.hardest(replace(constraint, level=None)).margin
        still = "" if weaker is None else f"holds only with margin {float(weaker):.6g}"
        return replace(left, claim=claim, note=still)


@np.errstate(all="ignore")
def carried_over(
    setting: Setting, C: Compensator, law: Law, claims: list[Written], progress: Callable[[str], None]
) -> tuple[Carried, ...]:
    """What becomes of every claim of a certificate whose controller C is shipped as `law`."""

    def each() -> Iterator[Carried]:
        reproof = Reproof(setting, C, law)
        for written in claims:
            progress(f"proving {written['id']} {written['form']} for the discrete controller")
            yield reproof.carried(written)

    return tuple(each())
