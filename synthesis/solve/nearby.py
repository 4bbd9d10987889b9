"""The best of the optima beside each other: they differ in where the constraints touch.

The bound's Q̃, reduced, is where to look; small random steps away from an optimum and back find the better ones.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from .nlp import Candidate
from .places import Grids
from .polish import LEAST_SIZE, Polisher
from .reduction import Response, reduced

if TYPE_CHECKING:
    from numpy.typing import NDArray

AWAY, LESS = 0.03, 0.95  # a random step away from an optimum: relative, and the part of ω_B that is kept
DRAWN, TRIED, AGREE = 6, 12, 2  # points from the ideal; random steps; how many of those have to end at the best
BETTER = 1e-4  # relative difference of ω_B above which one optimum is better than another


def best_nearby(
    polisher: Polisher,
    candidates: Sequence[Candidate],
    ideal: Response | None,
    seed: int,
    late: Callable[[], bool],
) -> tuple[Candidate, Grids] | None:
    """The best optimum near the ideal reduced, near the best candidate, and near those, and the grid where it is tight.

    ideal: a response of Q̃. seed: of the random numbers. late: whether time is up.
    """
    rng, structure = np.random.default_rng(seed), polisher.program.structure
    best: tuple[Candidate, Grids] | None = None

    def better(x: NDArray[np.float64], omega_B: float) -> tuple[Candidate, Grids] | None:
        """Refined, if that is better than the best on the grid where it is tight, and still is where it is itself."""
        if late():
            return None
        on = polisher if best is None else replace(polisher, grids=best[1])
        refined = on.refined(x, omega_B)
        if refined is None or (best is not None and refined.omega_B < (1 - BETTER) * best[0].omega_B):
            return None
        if best is not None and _same(refined, best[0]):
            return refined, best[1]
        exchanged = on.again(refined, on.grids)
        lost = exchanged is None or (best is not None and exchanged[0].omega_B < best[0].omega_B)
        return None if lost else exchanged

    ideals = (reduced(polisher.program, ideal, structure.start(rng)) for _ in range(DRAWN)) if ideal is not None else ()
    for x in ideals:
        best = better(x, 0.8 * polisher.program.omega_0) or best
    for c in candidates[:1]:
        best = better(c.x, c.omega_B) or best
    votes = 0
    for _ in range(TRIED):
        if best is None or votes == AGREE or late():
            break
        c = best[0]
        away = AWAY * rng.normal(size=c.x.size) * np.maximum(np.abs(c.x), LEAST_SIZE)
        found = better(c.x + away, LESS * c.omega_B)
        votes = votes if found is None else votes + 1 if _same(found[0], c) else 0
        best = found or best
    return best


def _same(one: Candidate, other: Candidate) -> bool:
    return abs(one.omega_B - other.omega_B) <= BETTER * other.omega_B
