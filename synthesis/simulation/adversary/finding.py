"""What one attack found, beside what was proven."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, Literal

Side = Literal["inside", "outside", "information"]


@dataclass(frozen=True)
class Finding:
    """One attack on one claim.

    `inside` the claim it must fail, `outside` it must succeed; `information` decides nothing. `measured` and
    `bound` in the claim's own unit; `agrees`: None where an attack outside could not be built.
    """

    claim: str
    side: Side
    what: str
    measured: float | None
    bound: float | None
    agrees: bool | None

    @property
    def tightness(self) -> float | None:
        """Measured over bound, the smaller over the larger: 1 where a run reaches the bound."""
        if self.measured is None or not self.bound or self.measured * self.bound <= 0:
            return None
        return min(self.measured / self.bound, self.bound / self.measured)

    def to_json(self) -> dict[str, Any]:
        """Plain values."""
        return {**asdict(self), "tightness": self.tightness}

    def __str__(self) -> str:
        bound = "" if self.bound is None else f", proven {self.bound:.6g}"
        measured = "" if self.measured is None else f": {self.measured:.6g}"
        return f"{self.claim}, {self.side}: {self.what}{measured}{bound}"
