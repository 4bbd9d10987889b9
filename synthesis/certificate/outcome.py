"""What an exact test can say."""

from __future__ import annotations

from enum import Enum

from flint import fmpq


class Outcome(Enum):
    """What an exact test can say."""

    PROVEN = "proven"
    REFUTED = "refuted"
    UNDECIDED = "undecided"


Interval = tuple[fmpq, fmpq | None]  # the upper end None is ∞


def all_of(outcomes: list[Outcome]) -> Outcome:
    """Proven if all are, refuted if one is."""
    if Outcome.REFUTED in outcomes:
        return Outcome.REFUTED
    return Outcome.UNDECIDED if Outcome.UNDECIDED in outcomes else Outcome.PROVEN
