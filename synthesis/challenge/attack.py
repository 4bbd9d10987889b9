"""Every claim of a certificate under attack in the time domain."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from ..certificate.claim import Claim
from ..simulation.adversary.finding import Finding
from ..simulation.adversary.population import Population, population
from ..simulation.equations import Compensator
from ..simulation.members import members
from ..spec.model import Spec
from .company import drawn_joints, environments, friction
from .levels import levels
from .limits import boxes, deltas, partners

Progress = Callable[[str], None]


@dataclass(frozen=True, eq=False)
class Challenge:
    """All findings, and the joints that were drawn."""

    findings: tuple[Finding, ...]
    drawn: Population

    @property
    def contradictions(self) -> tuple[str, ...]:
        """Findings against what was proven, in words."""
        return tuple(str(finding) for finding in self.findings if finding.agrees is False)

    def summary(self) -> str:
        """One line for a person."""
        decided = [finding for finding in self.findings if finding.agrees is not None and finding.side != "information"]
        inside = sum(finding.side == "inside" for finding in decided)
        tight = sum((finding.tightness or 0) >= 0.95 for finding in decided if finding.side == "inside")
        return (
            f"{len(self.drawn.loads)} joints drawn, {inside} attacks inside the claims fail "
            f"({tight} bounds reached within 5 %), {len(decided) - inside} just outside succeed"
        )


def challenge(
    spec: Spec, C: Compensator, claims: tuple[Claim, ...], *, count: int, seed: int, progress: Progress
) -> Challenge:
    """Attack every claim of a nominally stable joint; `count` loads are drawn with `seed`.

    With `sampling` the linear attacks are left out, and the joints drawn run the sampled controller.
    """
    by_kind = {(claim.id, claim.form): claim for claim in claims}
    findings: list[Finding] = []
    if spec.sampling is None:
        progress("measuring where the joint is worst")
        findings += levels(spec, C, by_kind)
        if len(list(members(spec))) == 1:
            progress("looking for a Δ, a box, a partner just outside the claims")
            findings += [*deltas(spec, C, by_kind), *boxes(spec, C, by_kind), *partners(spec, C, by_kind)]
            progress("coupling to passive environments, with and without friction")
            findings += [*environments(spec, C, by_kind), *friction(spec, C, by_kind)]
    found = population(spec, C, count, 10.0, seed, lambda share: progress(f"{count} joints drawn: {share:.0%} moved"))
    return Challenge((*findings, *drawn_joints(spec, found, by_kind)), found)
