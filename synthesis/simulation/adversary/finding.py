"""What one attack found, beside what was proven."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict, dataclass
from math import isfinite
from typing import Any, Literal

Side = Literal["inside", "outside", "information"]


@dataclass(frozen=True)
class Finding:
    """One attack on one claim.

    `inside` the claim it must fail, `outside` it must succeed; `information` decides nothing. `measured` and
    `bound` in the claim's own unit, of an attack outside the level at which it succeeded beside the proven one.
    `agrees`: None where an attack outside does not succeed and `why` it could not be expected to is said: not shown.
    """

    claim: str
    side: Side
    what: str
    measured: float | None
    bound: float | None
    agrees: bool | None
    why: str = ""

    @property
    def not_shown(self) -> bool:
        """An attack outside that neither succeeded nor contradicts."""
        return self.side == "outside" and self.agrees is None

    @property
    def tightness(self) -> float | None:
        """Measured over bound, the smaller over the larger: 1 where a run reaches the bound."""
        if self.measured is None or not self.bound or self.measured * self.bound <= 0:
            return None
        return min(self.measured / self.bound, self.bound / self.measured)

    def to_json(self) -> dict[str, Any]:
        """Plain values; what ran away has none."""
        measured = self.measured if self.measured is not None and isfinite(self.measured) else None
        return {**asdict(self), "measured": measured, "tightness": self.tightness}

    def __str__(self) -> str:
        bound = "" if self.bound is None else f", proven {self.bound:.6g}"
        measured = "" if self.measured is None else f": {self.measured:.6g}"
        why = f"; NOT SHOWN: {self.why}" if self.not_shown else ""
        return f"{self.claim}, {self.side}: {self.what}{measured}{bound}{why}"


def outside(
    claim: str, what: str, succeeded: bool, *, measured: float | None = None, bound: float | None = None, why: str = ""
) -> Finding:
    """An attack outside what is proven: if it does not succeed that contradicts, unless `why` excuses it.

    measured: the level at which it succeeded, beside the proven `bound`.
    """
    if succeeded:
        return Finding(claim, "outside", what, measured, bound, True)
    return Finding(claim, "outside", what, None, bound, None if why else False, why)


@dataclass(frozen=True)
class Reached:
    """How near simulation came to one proven bound: the finding nearest to it, inside or just outside."""

    claim: str
    proven: float
    simulated: float
    share: float | None

    def to_json(self) -> dict[str, Any]:
        """Plain values."""
        return asdict(self)


def reached(findings: Iterable[Finding]) -> tuple[Reached, ...]:
    """Of every claim with a bound, the finding nearest to it, in the order of the claims."""
    nearest: dict[str, Finding] = {}
    for finding in findings:
        decided = finding.side != "information" and finding.measured is not None and finding.bound is not None
        known = nearest.get(finding.claim)
        if decided and (known is None or (finding.tightness or 0) > (known.tightness or 0)):
            nearest[finding.claim] = finding
    return tuple(
        Reached(name, each.bound, each.measured, each.tightness)
        for name, each in nearest.items() if each.bound is not None and each.measured is not None
    )  # fmt: skip
