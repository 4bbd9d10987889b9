"""Every claim of a certificate under attack in the time domain."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from ..certificate.claim import Claim
from ..simulation.adversary.finding import Finding, Reached, reached
from ..simulation.adversary.population import Population, population
from ..simulation.equations import Compensator
from ..spec.model import Polynomials, Spec
from .company import drawn_joints, environments, friction
from .levels import levels
from .limits import boxes, deltas, discs, partners
from .perturbed import tolerance
from .proven import Subject

NEAR = 0.95  # of a bound

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

    @property
    def reached(self) -> tuple[Reached, ...]:
        """How near the runs came to each proven bound."""
        return reached(self.findings)

    def summary(self) -> str:
        """One line for a person."""
        decided = [finding for finding in self.findings if finding.agrees is not None and finding.side != "information"]
        inside = sum(finding.side == "inside" for finding in decided)
        tight = sum((each.share or 0) >= NEAR for each in self.reached)
        return (
            f"{len(self.drawn.loads)} joints drawn, {inside} attacks inside the claims fail "
            f"({tight} of {len(self.reached)} bounds reached within 5 %), {len(decided) - inside} just outside succeed"
        )


def challenge(
    spec: Spec,
    C: Compensator,
    claims: tuple[Claim, ...],
    *,
    count: int,
    seed: int,
    progress: Progress,
    coefficients: Polynomials | None = None,
) -> Challenge:
    """Attack every claim of a nominally stable joint; `count` loads are drawn with `seed`.

    Linear attacks move the loop that the claims are about: with `sampling`, C behind hold and delay. The joints drawn,
    friction and the wall then meet the controller as it is sampled. `coefficients`: of Q or C_imp, for the tolerance.
    """
    subject = Subject(spec, C, {(claim.id, claim.form): claim for claim in claims})
    attacks: list[tuple[str, Callable[[], Iterable[Finding]]]] = [
        ("measuring where the joint is worst", lambda: levels(subject)),
        ("looking for a Δ just outside the claims", lambda: (*deltas(subject), *discs(subject))),
        ("stretching the boxes", lambda: boxes(subject)),
        ("looking for a partner just outside the claims", lambda: partners(subject)),
        ("coupling to passive environments", lambda: environments(subject)),
        ("adding friction", lambda: friction(subject)),
        ("getting the coefficients wrong", lambda: tolerance(subject, coefficients, seed) if coefficients else ()),
    ]
    findings: list[Finding] = []
    for what, attack in attacks:
        progress(what)
        findings += attack()
    found = population(spec, C, count, 10.0, seed, lambda share: progress(f"{count} joints drawn: {share:.0%} moved"))
    return Challenge((*findings, *drawn_joints(subject, found)), found)
