"""Every claim of a certificate under attack in the time domain."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from ..certificate.claim import Claim
from ..simulation.adversary.finding import Finding, Reached, reached
from ..simulation.adversary.population import Population, Reality, population
from ..simulation.equations import Compensator
from ..spec.model import Polynomials, Spec
from .company import drawn_joints, environments, friction, real_joints
from .levels import levels
from .limits import boxes, deltas, discs, partners
from .perturbed import tolerance
from .proven import Subject

NEAR = 0.95  # of a bound
SECONDS = 10.0  # that a joint drawn is moved, at least
IDEAL = Reality()

Progress = Callable[[str], None]


@dataclass(frozen=True, eq=False)
class Challenge:
    """All findings, and the joints that were drawn; `real`: the same joints in the reality asked for."""

    findings: tuple[Finding, ...]
    drawn: Population
    real: Population | None = None

    @property
    def contradictions(self) -> tuple[str, ...]:
        """Findings against what was proven, in words."""
        return tuple(str(finding) for finding in self.findings if finding.agrees is False)

    @property
    def not_shown(self) -> tuple[Finding, ...]:
        """Attacks just outside that did not succeed, and could not be expected to."""
        return tuple(finding for finding in self.findings if finding.not_shown)

    @property
    def reached(self) -> tuple[Reached, ...]:
        """How near the runs came to each proven bound."""
        return reached(self.findings)

    def summary(self) -> str:
        """One line for a person."""
        decided = [finding for finding in self.findings if finding.agrees is not None and finding.side != "information"]
        inside = sum(finding.side == "inside" for finding in decided)
        shown, open_ = len(decided) - inside, len(self.not_shown)
        tight = sum((each.share or 0) >= NEAR for each in self.reached)
        return (
            f"{len(self.drawn.loads)} joints drawn, {inside} attacks inside the claims fail "
            f"({tight} of {len(self.reached)} bounds reached within 5 %), {shown} just outside succeed"
            + (f", {open_} could not be shown" if open_ else "")
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
    reality: Reality = IDEAL,
) -> Challenge:
    """Attack every claim of a nominally stable joint; `count` loads are drawn with `seed`.

    Linear attacks move the loop that the claims are about: with `sampling`, C behind hold and delay. The joints drawn,
    friction and the wall then meet the controller as it is sampled. `coefficients`: of Q or C_imp, for the tolerance.
    `reality`: what the certificate leaves out, and the joints drawn then meet as well, for information.
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
    told = in_shares(progress, f"{count} joints drawn")
    found, real = population(spec, C, count, SECONDS, seed, told), None
    findings += drawn_joints(subject, found)
    if reality != IDEAL:
        told = in_shares(progress, f"{count} joints with {reality}")
        real = population(spec, C, count, SECONDS, seed, told, reality)
        findings += real_joints(reality, real, found)
    return Challenge(tuple(findings), found, real)


def in_shares(progress: Progress, what: str) -> Callable[[float], None]:
    """Progress in shares of one piece of work."""
    return lambda share: progress(f"{what}: {share:.0%} moved")
