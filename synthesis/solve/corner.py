"""The corner of a sensor filter that the search found."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Literal


@dataclass(frozen=True)
class Corner:
    """A corner that was found, of few digits [rad/s], and at which end of those searched it is, if at one."""

    omega: Fraction
    end: Literal["", "lowest", "highest"] = ""

    @property
    def note(self) -> str:
        """What to make of a corner at an end of those searched, "" for one between them."""
        if not self.end:
            return ""
        advice = {"highest": "without a filter it may do as well or better", "lowest": "a lower one may do better"}
        return f"the corner found is the {self.end} that is searched, {float(self.omega):.6g} rad/s: {advice[self.end]}"
