"""The search and its loop with the proof: solve on the grid, prove on the axis, add each refuting frequency, repeat."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Protocol

import numpy as np

from ..errors import UndecidedError
from ..interruption import demand_none
from ..problem.setting import Setting
from ..spec.model import Polynomials
from .nlp import Candidate, Grids, Program
from .structure import Structure, structure_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

SCALES = (1.0, 1 / 8, 1 / 64)  # of the expected bandwidth, tried in turn: a bound that nothing limits is far too high
DRAWN = 300  # random points; of those without a simpler structure to start from, the nearest to feasible are used
STARTS = 12
FIRST_STARTS = 30
NEARBY = (0.0, 0.1, 0.2, 0.4, 0.4, 0.4)  # how far starts lie from one that was given: relative changes of x
AGREE = 5  # stop when this many starts end at the same best figure
REFINED = 8  # distinct optima of the coarse grid that are carried to the fine one
EXTENDED = 3  # of them, how many the next larger structure starts from
COARSE = {"spread": 14, "dense": 20, "band": 10}
FINE = {"spread": 40, "dense": 60, "band": 30}
ROUNDS = 10
REACHED = 0.9995  # of the program's ω_B: what the proof has to reach


class Counterexample(Protocol):
    """Where the proof failed: which claim, at which frequency [rad/s], whether on the objective's own band."""

    @property
    def id(self) -> str: ...  # noqa: D102
    @property
    def omega(self) -> float: ...  # noqa: D102
    @property
    def on_band(self) -> bool: ...  # noqa: D102


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
    deadline: float | None = None  # of time.monotonic()
    starts: tuple[tuple[Polynomials, float], ...] = ()  # controllers of similar joints, and their ω_B [rad/s]

    def run(self) -> Found | None:
        """Best controller of the specified structure that survives the proof; None when the search finds none."""
        for factor in SCALES:
            structure: Structure | None = structure_of(self.setting.spec)
            while structure is not None:  # a controller of lower order is one of this order, too
                found = replace(self, omega_0=self.omega_0 * factor)._at_scale(structure)
                if found is not None:
                    return found
                structure = structure.simpler
        return None

    def _at_scale(self, structure: Structure) -> Found | None:
        coarse = self._candidates(structure, np.random.default_rng(self.seed))
        if not coarse:
            return None
        grids = Grids.of(self.setting, self.omega_0, **FINE)
        program = Program(self.setting, structure, grids, self.omega_0, refining=True)
        refined = self._solve_all(program, [(c.x, 0.99 * c.omega_B) for c in coarse])
        for candidate in _distinct(refined):
            found = self._prove(structure, candidate, grids)
            if found is not None:
                return found
        return None

    def _candidates(self, structure: Structure, rng: np.random.Generator) -> list[Candidate]:
        """Distinct optima on the coarse grid, best first: from the simpler structure's, and from random starts where
        those give none."""
        found: list[Candidate] = []
        grids = Grids.of(self.setting, self.omega_0, **COARSE)
        program = Program(self.setting, structure, grids, self.omega_0)
        found = self._solve_all(program, self._around_starts(structure, rng))
        if found:
            return _distinct(found)[:REFINED]
        if structure.simpler is not None:
            below = self._candidates(structure.simpler, rng)[:EXTENDED]
            self.progress(f"searching {structure}")
            each = STARTS // max(1, len(below))
            starts = [(structure.extended(c.x, rng), 0.95 * c.omega_B) for c in below for _ in range(each)]
            found = self._solve_all(program, starts)
            if not found:  # the starts are feasible: stay near them, and be at least as good as the simpler structure
                near = Program(self.setting, structure, grids, self.omega_0, refining=True)
                found = self._solve_all(near, starts)
        if not found:
            self.progress(f"searching {structure} from random starts")
            omega_B = 0.1 * self.omega_0
            drawn = [structure.start(rng) for _ in range(DRAWN)]
            drawn.sort(key=lambda x: program.violation(x, omega_B))
            found = self._solve_all(program, [(x, omega_B) for x in drawn[:FIRST_STARTS]])
        return _distinct(found)[:REFINED]

    def _around_starts(self, structure: Structure, rng: np.random.Generator) -> list[tuple[NDArray[np.float64], float]]:
        """The controllers given to start from, each with a few in its neighbourhood."""
        known = [(structure.parameters(c, self.omega_0), omega_B) for c, omega_B in self.starts]
        low, high = structure.bounds
        return [
            (np.clip(x * np.exp(spread * rng.normal(size=x.size)), low, high), (1 - spread) * omega_B)
            for x, omega_B in known if x is not None for spread in NEARBY
        ]  # fmt: skip

    def _solve_all(self, program: Program, starts: list[tuple[NDArray[np.float64], float]]) -> list[Candidate]:
        """Solve from every start, or until several agree on the best."""
        found: list[Candidate] = []
        for x, omega_B in starts:
            self._in_time()
            candidate = program.solve(x, omega_B)
            if candidate is not None:
                found.append(candidate)
            best = max((c.omega_B for c in found), default=0.0)
            if sum(c.omega_B > 0.999 * best for c in found) >= AGREE:
                break
        return found

    def _in_time(self) -> None:
        demand_none()  # CasADi's callbacks into Python swallow exceptions
        if self.deadline is not None and time.monotonic() > self.deadline:
            raise UndecidedError("out of time: no controller was proven within the time limit")

    def _prove(self, structure: Structure, candidate: Candidate, grids: Grids) -> Found | None:
        """Counterexample loop: refuting frequencies join the grid with their neighbours, the slack required grows."""
        total = 0
        for rounds in range(1, ROUNDS + 1):
            self._in_time()
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
            for refining in (True, False):  # near the last optimum if IPOPT can, else from it
                program = Program(self.setting, structure, grids, self.omega_0, refining=refining)
                again = program.solve(candidate.x, candidate.omega_B)
                if again is not None:
                    break
            else:
                return None
            candidate = again
        return None


def _distinct(candidates: list[Candidate]) -> list[Candidate]:
    kept: list[Candidate] = []
    for c in sorted(candidates, key=lambda c: -c.omega_B):
        if not kept or c.omega_B < 0.999 * kept[-1].omega_B:
            kept.append(c)
    return kept
