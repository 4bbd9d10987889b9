"""The search and its loop with the proof: solve on the grid, prove on the axis, add each refuting frequency, repeat.

Order by order: the optima of the next simpler structure, with a section added, are starts for the next; so is the
bound's own Q̃, reduced to the order asked for; so are random points.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Protocol

import numpy as np

from ..errors import UndecidedError
from ..interruption import demand_none
from ..problem.grid import frequency_scale
from ..problem.setting import Setting
from ..spec.model import Polynomials
from .nearby import best_nearby
from .nlp import Candidate, Program
from .places import Grids
from .polish import Polisher
from .reduction import Response, reduced
from .structure import Structure, structure_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

HIGHEST = 30.0  # of the joint's highest frequency: farther out no bandwidth is looked for
SCALES = (1.0, 1 / 8, 1 / 64, 1 / 512)  # of the expected bandwidth, tried in turn: a bound may be far too high
FAR_BELOW, ABOVE = 1 / 8, 2.0  # ω_B in parts of ω₀ that is searched again nearby, from an ω₀ so far above it
DRAWN = 200  # random points, of which the nearest to feasible are used
RANDOM, FIRST_RANDOM = 6, 30  # of those: beside other starts, and where nothing simpler was found
EXTENDED = (0.99, 0.9, 0.95)  # parts of the simpler structure's ω_B at which its best three are extended
REDUCED = 2  # random points from which the bound's Q̃ is approximated
AGREE, FIRST_AGREE = 3, 5  # stop when this many starts end at the same best figure; with random ones alone
WORTHWHILE = 0.9  # of the best figure: what may still rise above it on the finer grid
KEPT = 4  # distinct optima that are kept
FINER = 8  # the grid that optima are looked at between solutions
EXCHANGES = 8
AGAIN = ((0.99, True), (0.99, False), (0.9, False), (0.7, False))  # parts of ω_B to solve again from, and whether near
ROUNDS = 12
BACK_OFF_GROWTH = 1.5
SAME = 1e-3  # relative difference of ω_B below which two optima are one
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
Again = Callable[[Candidate, Grids], tuple[Candidate, Grids] | None]  # an optimum on another grid, and the grid it took
Progress = Callable[[str], None]


@dataclass(frozen=True, eq=False)
class Start:
    """Parameters and ω_B [rad/s] to begin from; near: stay near them; votes: whether its agreement counts."""

    x: NDArray[np.float64]
    omega_B: float
    near: bool = False
    votes: bool = True


@dataclass(frozen=True)
class Found:
    """A controller every required claim was proven for, and what it took."""

    candidate: Candidate
    rounds: int
    counterexamples: int


@dataclass(frozen=True)
class Optima:
    """Of one structure: distinct candidates, best first, and the grid on which the best is tight."""

    candidates: tuple[Candidate, ...]
    grids: Grids


@dataclass(frozen=True)
class Search:
    """One search: deterministic for a seed. omega_0: where the bandwidth is expected [rad/s]; refute: the prover.

    ideal: a frequency response of Q̃ to begin from, the bound's. starts: controllers of similar joints with their ω_B
    [rad/s], to begin from as well. known: optima of structures already searched, shared by searches of other orders.
    """

    setting: Setting
    refute: Refute
    omega_0: float
    progress: Progress
    ideal: Response | None = None
    seed: int = 0
    deadline: float | None = None  # of time.monotonic()
    starts: tuple[tuple[Polynomials, float], ...] = ()
    known: dict[tuple[Structure, float], Optima] = field(default_factory=dict)

    def run(self) -> Found | None:
        """Best controller of the specified structure that survives the proof; None when the search finds none."""
        expected = min(self.omega_0, HIGHEST * frequency_scale(self.setting)[1])
        for omega_0 in (factor * expected for factor in SCALES):
            found = self._around(omega_0)
            if found is not None:
                return self._nearby(found) if found.candidate.omega_B < FAR_BELOW * omega_0 else found
        return None

    def _around(self, omega_0: float) -> Found | None:
        return replace(self, omega_0=omega_0)._at_scale(structure_of(self.setting.spec))

    def _nearby(self, found: Found) -> Found:
        """The better of what was found and what a search around it finds, where the grid is dense."""
        try:
            again = self._around(ABOVE * found.candidate.omega_B)
        except UndecidedError:  # out of time
            again = None
        return found if again is None or again.candidate.omega_B < found.candidate.omega_B else again

    def _at_scale(self, structure: Structure) -> Found | None:
        chain = [structure]
        while (simpler := chain[0].simpler) is not None:
            chain.insert(0, simpler)
        return self._from_simple(chain)

    def _from_simple(self, chain: list[Structure]) -> Found | None:
        """Search structure after structure, each from the optima of the one before; prove the last one's."""
        first = Grids.of(self.setting, self.omega_0)
        found = [Optima((), first)]
        for structure in chain:
            key, asked = (structure, self.omega_0), structure == chain[-1]
            if key not in self.known or (self.starts and asked):
                self.progress(f"searching {structure}")
                program = Program(self.setting, structure, first, self.omega_0)
                self.known[key] = self._optima(program, found[-1], asked)
            found.append(self.known[key])
        for k, structure in reversed([*enumerate(chain, 1)]):  # one of lower order is one of this order, too
            program = Program(self.setting, structure, first, self.omega_0)
            best = self._best(program, found[k])
            if best is None and structure != chain[-1] and found[k].candidates:  # so far it only gave starts
                self.progress(f"nothing proven; searching {structure} for its own sake")
                best = self._best(program, self._optima(program, found[k - 1], asked=True))
            if best is not None:
                return self._farther(structure, best, found[k])
        return None

    def _farther(self, structure: Structure, proven: Found, optima: Optima) -> Found:
        """The better of what is proven and what can be with poles farther out, where that is worth a search."""
        if structure.wider is None or not self.setting.polynomial:  # a proof on cells loses more than this wins
            return proven
        self.progress(f"searching {structure} with poles farther out")
        polisher = Polisher.of(self.setting, structure.wider, self.omega_0)
        try:
            best = best_nearby(polisher, optima.candidates, self.ideal, self.seed, self._in_time)
            found = None if best is None else self._prove(polisher.again, *best)
        except UndecidedError:  # out of time
            found = None
        return max((f for f in (proven, found) if f is not None), key=lambda f: f.candidate.omega_B)

    def _best(self, program: Program, optima: Optima) -> Found | None:
        """The best that can be proven of one structure's optima."""
        best: Found | None = None
        for candidate in optima.candidates:
            if best is not None and best.candidate.omega_B >= REACHED * candidate.omega_B:
                break  # the others, too, would have to lose less to their proofs
            found = self._prove(lambda c, grids: self._solved_again(program, c, grids), candidate, optima.grids)
            if best is None or (found is not None and found.candidate.omega_B > best.candidate.omega_B):
                best = found
        return best

    def _optima(self, program: Program, below: Optima, asked: bool) -> Optima:
        """Distinct optima of one structure, and the grid on which the best is tight; not `asked`: for starts only."""
        found: list[tuple[Candidate, Grids]] = []
        ends: list[tuple[float, float]] = []  # ω_B of a solution on a grid, which flatters, and what is left
        best, votes, grids = 0.0, list[float](), below.grids
        agree = FIRST_AGREE if asked and not (below.candidates or self.starts) else AGREE
        for start in self._starts(program, below, asked):
            self._in_time()
            explored = program.solve(start.x, start.omega_B, grids, refining=start.near)
            if explored is None:
                continue
            left = next((left for end, left in ends if _same(explored.omega_B, end)), None)
            if left is None:
                worthwhile = explored.omega_B > (WORTHWHILE if asked else 1.0) * best
                exchanged = self._exchanged(program, explored, grids) if worthwhile else []
                found += exchanged
                left = exchanged[0][0].omega_B if exchanged else 0.0
                ends += [(explored.omega_B, left), (left, left)]
                if left > best:  # the others look where it is tight, too: what flatters less is sooner known
                    grids = exchanged[0][1]
            best = max(best, left)
            votes += [left] if start.votes else []
            if best > 0 and sum(_same(vote, best) for vote in votes) >= agree:
                break
        found.sort(key=lambda pair: -pair[0].omega_B)
        return Optima(_distinct([c for c, _ in found])[:KEPT], found[0][1] if found else below.grids)

    def _starts(self, program: Program, below: Optima, asked: bool) -> Iterator[Start]:
        structure, rng = program.structure, np.random.default_rng(self.seed)
        for coefficients, omega_B in self.starts if asked else ():
            response = Response.of(self.setting, coefficients, below.grids.omega)
            x = reduced(program, response, structure.start(rng))
            yield Start(x, 0.95 * omega_B, near=True)
            yield Start(x, 0.8 * omega_B)
        if self.ideal is not None and asked:
            for k in range(REDUCED):
                x = reduced(program, self.ideal, structure.start(rng))
                yield Start(x, 0.8 * self.omega_0, votes=k == 0)
        for share in EXTENDED:
            for candidate in below.candidates[: len(EXTENDED)]:
                yield Start(structure.extended(candidate.x, rng), share * candidate.omega_B, near=True)
        omega_B = 0.1 * self.omega_0
        drawn = program.nearest([structure.start(rng) for _ in range(DRAWN)], omega_B, below.grids)
        for x in drawn[: RANDOM if below.candidates else FIRST_RANDOM]:
            yield Start(x, omega_B)

    def _exchanged(self, program: Program, candidate: Candidate, grids: Grids) -> list[tuple[Candidate, Grids]]:
        """Solve again with the points of a finer grid where it falls short, until it does nowhere; [] if it cannot."""
        again = candidate
        for _ in range(EXCHANGES):
            omega, band = program.violated(again, self._finer)
            if not omega and not band:
                break
            grids = grids.refined(omega, band)
            solved = self._again(program, again, grids)
            if solved is None:
                return []
            again = solved
        return [(again, grids)]

    @cached_property
    def _finer(self) -> Grids:
        return Grids.of(self.setting, self.omega_0, FINER)

    def _again(self, program: Program, candidate: Candidate, grids: Grids) -> Candidate | None:
        """Solve on another grid, near the last optimum if IPOPT can, else from it, or from the same with less ω_B."""
        for share, near in AGAIN:
            self._in_time()
            again = program.solve(candidate.x, share * candidate.omega_B, grids, refining=near)
            if again is not None:
                return again
        return None

    def _solved_again(self, program: Program, candidate: Candidate, grids: Grids) -> tuple[Candidate, Grids] | None:
        again = self._again(program, candidate, grids)
        exchanged = [] if again is None else self._exchanged(program, again, grids)
        return exchanged[0] if exchanged else None

    def _prove(self, again: Again, candidate: Candidate, grids: Grids) -> Found | None:
        """Counterexample loop: refuting frequencies join the grid, the slack required grows."""
        total = 0
        for rounds in range(1, ROUNDS + 1):
            self._in_time()
            refuting = self.refute(candidate.coefficients, REACHED * candidate.omega_B)
            if not refuting:
                return Found(candidate, rounds, total)
            total += len(refuting)
            named = ", ".join(f"{c.id} at {c.omega:.4g}" for c in refuting[:3])
            self.progress(f"proof {rounds} fails: {named} rad/s; solving again")
            grids = replace(grids, back_off=grids.back_off * BACK_OFF_GROWTH).refined(
                [c.omega for c in refuting if not c.on_band and 0 < c.omega < np.inf],
                [c.omega / candidate.omega_B for c in refuting if c.on_band],
            )
            solved = again(candidate, grids)
            if solved is None:
                return None
            candidate, grids = solved
        return None

    def _in_time(self) -> None:
        demand_none()  # CasADi's callbacks into Python swallow exceptions
        if self.deadline is not None and time.monotonic() > self.deadline:
            raise UndecidedError("out of time: no controller was proven within the time limit")


def _same(one: float, other: float) -> bool:
    return abs(one - other) < SAME * other


def _distinct(candidates: list[Candidate]) -> tuple[Candidate, ...]:
    kept: list[Candidate] = []
    for c in candidates:
        if not kept or c.omega_B < 0.9998 * kept[-1].omega_B:
            kept.append(c)
    return tuple(kept)
