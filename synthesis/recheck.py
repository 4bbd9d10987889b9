"""The independent checker's word on a certificate: what it cannot confirm is claimed nearer to what is required."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from math import ceil
from time import monotonic
from typing import Any

from .certificate.claim import Claim
from .certificate.document import encoded, verdict
from .certificate.outcome import Outcome
from .certificate.witness import short
from .check import Verdict, check_bytes
from .errors import ExitCode, RobimpError, UndecidedError
from .problem.constraints import constraints
from .problem.constraints.inequality import Role
from .problem.setting import Setting

UNSURE = "proven, but the independent checker cannot confirm it: "
ROUNDS = 12
SECONDS, PATIENCE = 60.0, 600.0  # for a check [s]; in the end: whoever waited for the search will wait for its proof
SLOWER = 3  # than this machine, now: how slow another may be on which the certificate is checked
DOUBTS = ("time limit", "neither proven nor refuted", "too large", "depends on the hold")  # anything else contradicts
VERDICT_CODE = {
    Outcome.PROVEN: ExitCode.PROVEN,
    Outcome.REFUTED: ExitCode.REFUTED,
    Outcome.UNDECIDED: ExitCode.UNDECIDED,
}
Written = dict[str, Any]


def recheck(
    setting: Setting, claims: tuple[Claim, ...], write: Callable[[tuple[Claim, ...]], Written]
) -> tuple[tuple[Claim, ...], Written, Verdict, float]:
    """Compare prover and checker claim by claim; where the checker is unsure of a margin, concede half of it.

    Returns: the claims both confirm, their certificate, the checker's verdict and how long it took [s]. Raises:
    RobimpError when the two contradict each other, UndecidedError when the checker cannot decide what is required.
    """
    said, seconds = "", SECONDS
    for attempt in range(ROUNDS):
        certificate, began = write(claims), monotonic()
        second = check_bytes(encoded(certificate), time_limit=seconds)
        took = monotonic() - began
        outcome = verdict(claims)
        short_of = {(c.id, c.form) for c in claims if c.required and c.status is not Outcome.PROVEN}
        unsure = {(id, form): text for id, form, status, text in second.claims if status == "not verified"}
        more = {kind: text for kind, text in unsure.items() if kind not in short_of}
        if second.exit_code == VERDICT_CODE[outcome] and unsure.keys() == short_of:
            return claims, certificate, second, took
        said = next(iter(more.values()), second.message)
        unsure_only = all(any(doubt in text for doubt in DOUBTS) for text in more.values())
        if second.exit_code != ExitCode.UNDECIDED and not (second.exit_code == VERDICT_CODE[outcome] and unsure_only):
            raise RobimpError(f"prover says {outcome.value}, the independent checker says: {said}")
        if not more:
            break
        doubted = next(c for c in claims if (c.id, c.form) in more)  # one at a time: out of time, all that follow are
        weaker = conceded(setting, doubted) if attempt != ROUNDS - 2 else None  # the last attempt is a patient one
        if weaker is not None:
            claims = tuple(weaker if c is doubted else c for c in claims)
        elif seconds == PATIENCE:
            break
        else:
            seconds = PATIENCE
    raise UndecidedError(UNSURE + said)


def advised_limit(seconds: float) -> int:
    """The time limit [s] for a check that took so long here: enough on a slower machine, in whole minutes."""
    return 60 * max(1, ceil(SLOWER * seconds / 60))


def conceded(setting: Setting, claim: Claim) -> Claim | None:
    """The same claim halfway to the level that is required: what only is reported becomes undecided, else None."""
    entered = _required(setting, claim)
    if entered is None or claim.margin is None or claim.margin == entered[1]:
        if claim.required or claim.id == "bandwidth":
            return None
        return replace(claim, status=Outcome.UNDECIDED, margin=None, refuted_at=None)
    role, level = entered
    halfway = claim.margin * Fraction(11, 10) if level is None else (claim.margin + level) / 2
    margin = short(float(halfway), up=role is Role.CEILING)
    near = level is not None and abs(claim.margin - level) <= Fraction(1, 100) * max(level, Fraction(1, 10**9))
    return replace(claim, margin=level if near else margin)


def _required(setting: Setting, claim: Claim) -> tuple[Role, Fraction | None] | None:
    """How a claim's level enters, and the one that is required; None where there is nothing to concede."""
    if claim.form == "box":  # it is stretched as a radius is
        return Role.RADIUS, Fraction(1)
    if claim.id == "tolerance":
        return Role.RADIUS, setting.spec.constraints.tolerance or Fraction(0)
    found = [c for c in constraints(setting, claim.id) if (c.id, c.form) == (claim.id, claim.form)]
    if not found or claim.id == "bandwidth":  # the intervals of other claims end at ω_B
        return None
    least = Fraction(0) if found[0].role is Role.FLOOR else Fraction(1)
    asked = found[0].level if found[0].level is not None else least
    return found[0].role, asked if claim.required or found[0].role is not Role.CEILING else None
