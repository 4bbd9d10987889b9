"""Which claims of a certificate hold for the exported controller, and how they are said in one line each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from ...models.impedance import DynamicStiffness
from ...models.rational import fraction
from ..certificate.claim import Claim
from ..certificate.outcome import Outcome
from ..certificate.witness import Witness, short
from ..errors import ExitCode
from ..problem.setting import LOAD
from ..spec import number_text

LEFT, LOST, NEEDLESS = "not re-proven", "lost", "not needed"
DECAY = "sampled"  # form of the claims whose margin is a rate of decay [1/s]; the certificate has none to compare
KEPT = Fraction(99, 100)  # of the certificate's ω_B; measured: a hold at 1 kHz costs 0.2 to 0.4 % of 9 to 18 rad/s


@dataclass(frozen=True)
class Carried:
    """One claim of the certificate: what became of it.

    claim: as re-proven for the shipped coefficients in the sampled loop; None where nobody tried, and `note` says why.
    certified: the margin the certificate has for the continuous controller. needless: there is nothing to prove.
    """

    id: str
    form: str
    required: bool
    certified: Fraction | None
    claim: Claim | None
    note: str = ""
    needless: bool = False

    @property
    def status(self) -> str:
        """proven, refuted, undecided, lost (a bandwidth of which too little is left), not re-proven, or not needed."""
        if self.claim is None:
            return NEEDLESS if self.needless else LEFT
        return LOST if self.is_bandwidth and self.share < KEPT else self.claim.status.value

    @property
    def is_bandwidth(self) -> bool:
        """Whether the margin is an ω_B that was found again, beside that of the certificate."""
        found = self.claim is not None and self.claim.margin is not None
        return self.id == "bandwidth" and found and bool(self.certified)

    @property
    def share(self) -> Fraction:
        """What is left of the certificate's margin: 1 is all."""
        assert self.claim is not None and self.claim.margin is not None and self.certified
        return self.claim.margin / self.certified

    @property
    def line(self) -> str:
        """For people: the claim, its status and margin, and where it fails."""
        kind = f"{self.id} {self.form}".ljust(31)
        return f"{kind} {'required' if self.required else 'reported'}  {self.said}"

    @property
    def said(self) -> str:
        """Status and margin, and where the claim fails."""
        if self.claim is None:
            return f"{self.status}: {self.note}"
        text = self.status + self._margin(self.claim)
        return f"{text}: {self.note}" if self.note else text

    def _margin(self, claim: Claim) -> str:
        low, high = claim.interval
        if claim.status is not Outcome.PROVEN or claim.margin is None:
            witness = None if claim.refuted_at is None else claim.refuted_at.witness
            return "" if witness is None else _where(witness)
        if claim.form == DECAY:
            return f" decay ≥ {_at_least(claim.margin)} /s"
        span = f"on [{float(low):.6g}, {float(high):.6g}] rad/s" if high is not None else ""
        was = "" if self.certified is None else f" (certificate {float(self.certified):.6g})"
        left = f": {float(self.share):.2%} is left, {float(KEPT):.2%} is asked for" if self.status == LOST else ""
        return f" {span} margin {float(claim.margin):.6g}{was}{left}"

    def to_json(self) -> dict[str, object]:
        """Exact texts, as in a certificate."""
        found: dict[str, object] = {"id": self.id, "form": self.form, "required": self.required, "status": self.status}
        found["certified_margin"] = None if self.certified is None else number_text(self.certified)
        if self.claim is not None:
            low, high = self.claim.interval
            found["statement"] = self.claim.statement
            found["interval"] = [number_text(low), "inf" if high is None else number_text(high)]
            found["margin"] = None if self.claim.margin is None else number_text(self.claim.margin)
            beyond = self.claim.refuted_at
            witness = None if beyond is None else beyond.witness
            omega, load = (None, None) if witness is None else (witness.omega, witness.load)
            found["refuted_at"] = None if beyond is None else number_text(beyond.value)
            found["refuted_at_omega"] = None if omega is None else number_text(omega)
            found["refuted_at_load"] = None if load is None else _numbers(load)
        found["note"] = self.note
        return found


def _at_least(margin: Fraction) -> str:
    """Six digits, rounded down."""
    return f"{float(short(float(margin), up=False)):g}"


def _where(witness: Witness) -> str:
    frequency = "" if witness.omega is None else f" at {float(witness.omega):.6g} rad/s"
    if witness.load is None:
        return frequency
    return f"{frequency} with " + ", ".join(f"{k} {float(Fraction(v)):.6g}" for k, v in _numbers(witness.load).items())


def _numbers(load: DynamicStiffness) -> dict[str, str]:
    return {name: number_text(fraction(getattr(load, name))) for name in LOAD}


def lost(carried: Sequence[Carried]) -> list[Carried]:
    """The required claims that do not hold for the exported controller, or are not proven to."""
    return [each for each in carried if each.required and each.status not in (Outcome.PROVEN.value, NEEDLESS)]


def bandwidth(carried: Sequence[Carried]) -> str:
    """ω_B of the exported controller beside the certificate's; nothing where no claim speaks of it."""
    texts = (
        f"ω_B ≥ {_at_least(each.claim.margin)} rad/s (certificate {float(each.certified):.6g})"
        for each in carried
        if each.is_bandwidth and each.claim and each.claim.margin and each.certified
    )
    return next(texts, "no ω_B proven")


def verdict(carried: Sequence[Carried]) -> str:
    """The first line of every file: PROVEN, or NOT PROVEN and what is lost; with ω_B."""
    missing = ", ".join(f"{each.id} {each.form} {each.status}" for each in lost(carried))
    return f"{f'NOT PROVEN: {missing}' if missing else 'PROVEN: every required claim'}; {bandwidth(carried)}"


def exit_code(carried: Sequence[Carried]) -> ExitCode:
    """REFUTED if a required claim is, or too little of ω_B is left; UNDECIDED if one is not decided; or PROVEN."""
    statuses = {each.status for each in lost(carried)}
    if statuses & {Outcome.REFUTED.value, LOST}:
        return ExitCode.REFUTED
    return ExitCode.UNDECIDED if statuses else ExitCode.PROVEN
