"""What a claim is: one statement about the exact controller, its status, and how tight it is."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from ..problem.constraints.inequality import Constraint
from .outcome import Outcome
from .witness import Witness


@dataclass(frozen=True)
class Refutation:
    """A level at which a claim fails, and where."""

    value: Fraction
    witness: Witness | None


@dataclass(frozen=True)
class Claim:
    """One statement about the exact controller, its status, and how tight it is. interval: (ω low, ω high or None)."""

    id: str
    equation: str
    form: str
    statement: str
    uncertainty: str
    interval: tuple[Fraction, Fraction | None]
    required: bool
    status: Outcome
    margin: Fraction | None
    refuted_at: Refutation | None


def claim_of(c: Constraint, status: Outcome, margin: Fraction | None, refuted_at: Refutation | None) -> Claim:
    """The claim a constraint makes, with what was found of it."""
    return Claim(c.id, c.equation, c.form, c.statement, c.uncertainty, c.band, c.required, status, margin, refuted_at)
