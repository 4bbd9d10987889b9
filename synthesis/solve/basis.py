"""What the bound's Q̃ is made of: `Q̃ = H·Σ x_k φ_k`, φ_k with fixed stable poles, real ones and resonant pairs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

REAL = 10  # real poles, spread over everything; the rest of the terms are pairs
SHARE = 0.5  # of the pairs lie just beyond ω_B, where the best Q̃ turns sharply
NARROW, WIDE, SLOWEST = (0.98, 1.12), (0.1, 12.0), 0.03  # in parts of ω_B
OVERLAP = 1.6  # damping of a pair, in spacings to its neighbour
PAIRED = 1.5  # pairs reach so far beyond the joint's highest frequency
ROLL_OFF = 100.0, 20.0  # the common pole that gives the relative degree, in parts of ω_B and of that frequency
RESOLVED = np.arange(-9, 10) / 3  # where a resonance is looked at, in widths ζω from its centre


@dataclass(frozen=True)
class Basis:
    """Poles placed for a bandwidth `around` [rad/s]; `roll_off` the relative degree of every function.

    highest: frequency up to which the joint does anything [rad/s]. Where poles end below it, what limits ω_B is the
    basis: on joints with a fast torque loop by a third. slowest: the slowest pole, in parts of `around`.
    """

    around: float
    terms: int
    roll_off: int
    highest: float
    slowest: float = SLOWEST

    def at(self, omega: NDArray[np.float64]) -> NDArray[np.complex128]:
        """Values of all functions. omega: (n,) [rad/s]. Returns (n, terms)."""
        s: NDArray[Any] = 1j * omega / self.around
        columns: list[Any] = [np.ones_like(s), *(1 / (1 + s / pole) for pole in self._real)]
        for pole, zeta in self._pairs():
            resonance = 1 / ((s / pole) ** 2 + 2 * zeta * s / pole + 1)
            columns += [resonance, resonance * s / pole]
        return np.asarray(np.stack(columns, axis=1) / ((1 + s / self._fastest) ** self.roll_off)[:, None], complex)

    def resonances(self) -> NDArray[np.float64]:
        """Frequencies [rad/s] that a grid needs to see every resonance: between coarser ones it could hide a peak."""
        return self.around * np.concatenate([pole * np.exp(zeta * RESOLVED) for pole, zeta in self._pairs()])

    @property
    def _fastest(self) -> float:
        return max(ROLL_OFF[0], ROLL_OFF[1] * self.highest / self.around)

    @property
    def _real(self) -> NDArray[np.float64]:
        return np.geomspace(self.slowest, self._fastest / 2, REAL - 1 + self.terms % 2)

    def _pairs(self) -> Iterator[tuple[float, float]]:
        """Frequency, in parts of ω_B, and ζ of each pair."""
        pairs = (self.terms - 1 - self._real.size) // 2
        dense = round(SHARE * pairs)
        wide = WIDE[0], max(WIDE[1], PAIRED * self.highest / self.around)
        for (low, high), count in ((NARROW, dense), (wide, pairs - dense)):
            zeta = min(0.7, OVERLAP * np.log(high / low) / count)
            for pole in np.geomspace(low, high, count):
                yield float(pole), float(zeta)
