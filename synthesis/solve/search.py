"""The search and its loop with the proof: solve on the grid, prove on the axis, add each refuting frequency, repeat."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np

from ..problem.grid import grid
from ..problem.setting import Setting
from ..spec.model import Polynomials
from .nlp import Candidate, Grids, Program
from .structure import Structure, structure_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

STARTS = 12
AGREE = 3  # stop when this many starts end at the same best figure
ROUNDS = 10
REACHED = 0.9995  # of the program's ω_B: what the proof has to reach


class Counterexample(Protocol):
    """Where the proof failed."""

    id: str
    omega: float
    on_band: bool


Refute = Callable[[Polynomials, float], Sequence[Counterexample]]  # coefficients, ω_B → () when all required is proven
Progress = Callable[[str], None]


@dataclass(frozen=True)
class Found:
    """A controller every required claim was proven for, and what it took."""

    candidate: Candidate
    rounds: int
    counterexamples: int


@dataclass(frozen=True)
class Search:
    """One search: deterministic for a seed. omega_0: where the bandwidth is expected [rad/s]; refute: the prover."""

    setting: Setting
    refute: Refute
    omega_0: float
    progress: Progress
    seed: int = 0

    def run(self) -> Found | None:
        """Best controller of the specified structure that survives the proof; None when the search finds none."""
        structure = structure_of(self.setting.spec)
        grids = Grids.of(grid(self.setting, around=self.omega_0, spread=40, dense=60))
        for candidate in self._candidates(structure, grids, np.random.default_rng(self.seed)):
            found = self._prove(structure, candidate, grids)
            if found is not None:
                return found
        return None

    def _candidates(self, structure: Structure, grids: Grids, rng: np.random.Generator) -> list[Candidate]:
        """Distinct optima, best first: from the simpler structure's, and from random starts where those give none."""
        found: list[Candidate] = []
        program = Program(self.setting, structure, grids, self.omega_0)
        if structure.simpler is not None:
            below = self._candidates(structure.simpler, grids, rng)[:2]
            self.progress(f"searching {structure}")
            each = STARTS // max(1, len(below))
            found = _solve_all(
                program, [(structure.extended(c.x, rng), 0.95 * c.omega_B) for c in below for _ in range(each)]
            )
        if not found:
            self.progress(f"searching {structure} from random starts")
            found = _solve_all(program, [(structure.start(rng), 0.1 * self.omega_0) for _ in range(2 * STARTS)])
        return _distinct(found)

    def _prove(self, structure: Structure, candidate: Candidate, grids: Grids) -> Found | None:
        """Counterexample loop: each refuting frequency joins the grid with neighbours, and the slack asked for grows."""
        total = 0
        for rounds in range(1, ROUNDS + 1):
            refuting = self.refute(candidate.coefficients, REACHED * candidate.omega_B)
            if not refuting:
                return Found(candidate, rounds, total)
            total += len(refuting)
            named = ", ".join(f"{c.id} at {c.omega:.4g}" for c in refuting[:3])
            self.progress(f"proof {rounds} fails: {named} rad/s; solving again")
            grids = grids.refined(
                [c.omega for c in refuting if not c.on_band and 0 < c.omega < np.inf],
                [c.omega / candidate.omega_B for c in refuting if c.on_band],
            )
            again = Program(self.setting, structure, grids, self.omega_0).solve(candidate.x, candidate.omega_B)
            if again is None:
                return None
            candidate = again
        return None


def _solve_all(program: Program, starts: list[tuple[NDArray[np.float64], float]]) -> list[Candidate]:
    found: list[Candidate] = []
    for x, omega_B in starts:
        candidate = program.solve(x, omega_B)
        if candidate is not None:
            found.append(candidate)
        best = max((c.omega_B for c in found), default=0.0)
        if sum(c.omega_B > 0.999 * best for c in found) >= AGREE:
            break
    return found


def _distinct(candidates: list[Candidate]) -> list[Candidate]:
    kept: list[Candidate] = []
    for c in sorted(candidates, key=lambda c: -c.omega_B):
        if not kept or c.omega_B < 0.999 * kept[-1].omega_B:
            kept.append(c)
    return kept
