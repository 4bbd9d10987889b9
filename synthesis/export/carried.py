"""Which claims of a certificate hold for the exported controller, and how they are said in one line each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from ...models.impedance import DynamicStiffness
from ...models.rational import fraction
from ..certificate.claim import Claim
from ..certificate.outcome import Outcome
from ..certificate.witness import Witness
from ..errors import ExitCode
from ..problem.setting import LOAD
from ..spec import number_text

LEFT = "not re-proven"


@dataclass(frozen=True)
class Carried:
    """One claim of the certificate: what became of it.

    claim: as re-proven for the shipped coefficients in the sampled loop; None where nobody tried, and `note` says why.
    certified: the margin the certificate has for the continuous controller.
    """

    id: str
    form: str
    required: bool
    certified: Fraction | None
    claim: Claim | None
    note: str = ""

    @property
    def status(self) -> str:
        """proven, refuted, undecided, or not re-proven."""
        return LEFT if self.claim is None else self.claim.status.value

    @property
    def line(self) -> str:
        """For people: the claim, its status and margin, and where it fails."""
        kind = f"{self.id} {self.form}".ljust(31)
        role = "required" if self.required else "reported"
        text = f"{kind} {role}  {self.status}"
        if self.claim is None:
            return f"{text}: {self.note}"
        low, high = self.claim.interval
        span = f"on [{float(low):.6g}, {float(high):.6g}] rad/s" if high is not None else ""
        if self.claim.status is Outcome.PROVEN and self.claim.margin is not None:
            was = "" if self.certified is None else f" (certificate {float(self.certified):.6g})"
            text += f" {span} margin {float(self.claim.margin):.6g}{was}"
        elif self.claim.refuted_at is not None and self.claim.refuted_at.witness is not None:
            text += _where(self.claim.refuted_at.witness)
        return f"{text}: {self.note}" if self.note else text

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


def _where(witness: Witness) -> str:
    frequency = "" if witness.omega is None else f" at {float(witness.omega):.6g} rad/s"
    if witness.load is None:
        return frequency
    return f"{frequency} with " + ", ".join(f"{k} {float(Fraction(v)):.6g}" for k, v in _numbers(witness.load).items())


def _numbers(load: DynamicStiffness) -> dict[str, str]:
    return {name: number_text(fraction(getattr(load, name))) for name in LOAD}


def exit_code(carried: Sequence[Carried]) -> ExitCode:
    """REFUTED if a required claim is, UNDECIDED if one is or if stability was not decided, PROVEN otherwise."""
    statuses = {each.status for each in carried if each.required}
    if Outcome.REFUTED.value in statuses:
        return ExitCode.REFUTED
    return ExitCode.UNDECIDED if statuses & {Outcome.UNDECIDED.value, LEFT} else ExitCode.PROVEN
