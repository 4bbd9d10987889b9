"""The search and its loop with the proof: solve on the grid, prove on the axis, add each refuting frequency, repeat.

Order by order: the optima of the next simpler structure, with a section added, are starts for the next; so is the
bound's own Q̃, reduced to the order asked for; so are random points.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cache, cached_property

import numpy as np

from ..errors import UndecidedError
from ..interruption import demand_none
from ..problem.grid import frequency_scale
from ..problem.setting import Setting
from ..spec.model import Polynomials
from .filtered import structure_of
from .nearby import best_nearby
from .nlp import Candidate, Program
from .optima import Again, Found, Optima, Progress, Refute, Start
from .places import Grids
from .polish import Polisher
from .reduction import Response, reduced
from .structure import Structure, contained

HIGHEST = 30.0  # of the joint's highest frequency: farther out no bandwidth is looked for
SCALES = (1.0, 1 / 8, 1 / 64, 1 / 512)  # of the expected bandwidth, tried in turn: a bound may be far too high
FAR_BELOW, ABOVE = 1 / 8, 2.0  # ω_B in parts of ω₀ that is searched again nearby, from an ω₀ so far above it
DRAWN = 200  # random points, of which the nearest to feasible are used
RANDOM, FIRST_RANDOM = 6, 30  # of those: beside other starts, and where nothing simpler was found
FEW = 2  # of those in a short search
EXTENDED = (0.99, 0.9, 0.95)  # parts of the simpler structure's ω_B at which its best three are extended
REDUCED = 2  # random points from which the bound's Q̃ is approximated
AGREE, FIRST_AGREE = 3, 5  # stop when this many starts end at the same best figure; with random ones alone
WORTHWHILE = 0.9  # of the best figure: what may still rise above it on the finer grid
KEPT = 4  # distinct optima that are kept
FINER = 8  # the grid that optima are looked at between solutions
EXCHANGES = 8
AGAIN = ((0.99, True), (0.99, False), (0.9, False), (0.7, False))  # parts of ω_B to solve again from, and whether near
ROUNDS = 12
OVERTIME = 10.0  # [s] for the proof of one structure's optima when time is up
BACK_OFF_GROWTH = 1.5
SAME = 1e-3  # relative difference of ω_B below which two optima are one
REACHED = 0.9995  # of the program's ω_B: what the proof has to reach


@dataclass(frozen=True)
class Search:
    """One search: deterministic for a seed. omega_0: where the bandwidth is expected [rad/s]; refute: the prover.

    ideal: a frequency response of Q̃ to begin from, the bound's. starts: controllers of similar joints with their ω_B
    [rad/s], to begin from as well. known: optima of structures already searched, shared by searches of other orders.
    short: at one scale, from few random starts, and content with the simplest structure that will do.
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
    short: bool = False

    def run(self) -> Found | None:
        """Best controller of the specified structure that survives the proof; None when the search finds none.

        Out of time it is the best that was known, or of lower order. Raises: UndecidedError when nothing was.
        """
        expected = min(self.omega_0, HIGHEST * frequency_scale(self.setting)[1])
        for k, omega_0 in enumerate(factor * expected for factor in SCALES[: 1 if self.short else None]):
            found = replace(self, short=self.short or (k > 0 and self.ideal is not None))._around(omega_0)
            if found is not None:
                return self._nearby(found) if found.candidate.omega_B < FAR_BELOW * omega_0 else found
            if self._late:
                raise UndecidedError("out of time: no controller was proven within the time limit")
        return None

    def _around(self, omega_0: float) -> Found | None:
        return replace(self, omega_0=omega_0)._from_simple(contained(structure_of(self.setting.spec)))

    def _nearby(self, found: Found) -> Found:
        """The better of what was found and what a search around it finds, where the grid is dense."""
        again = self._around(ABOVE * found.candidate.omega_B)
        better = found if again is None or again.candidate.omega_B < found.candidate.omega_B else again
        return replace(better, late=self._late)

    def _from_simple(self, chain: list[Structure]) -> Found | None:
        """Search structure after structure, each from the optima of those it contains; prove the last one's."""
        first, includes = Grids.of(self.setting, self.omega_0), chain[-1].includes
        program_of = cache(lambda structure: Program(self.setting, structure, first, self.omega_0))
        found: dict[Structure, Optima] = {}
        for structure in chain:
            if self._late:
                break
            key, asked = (structure, self.omega_0), structure == chain[-1]
            if key in self.known and not (self.starts and asked):
                found[structure] = self.known[key]
            else:
                self.progress(f"searching {structure}")
                found[structure] = self._optima(program_of(structure), self._below(structure, found, first), asked)
                if not self._late:  # else it is not all there is to know
                    self.known[key] = found[structure]
            if self.short and not asked and includes(structure):
                early = self._best(program_of(structure), found[structure])
                if early is not None:
                    return early
        late = self._late
        for structure in filter(includes, reversed(found)):  # one of lower order is one of this order, too
            program = program_of(structure)
            best = self._overtime._best(program, found[structure])
            if best is None and structure != chain[-1] and found[structure].candidates and not late:
                self.progress(f"nothing proven; searching {structure} for its own sake")  # so far it only gave starts
                best = self._best(program, self._optima(program, self._below(structure, found, first), asked=True))
            if best is not None:
                best = self._farther(structure, best, found[structure])
                return replace(best, late=late or self._late)
        return None

    def _below(self, structure: Structure, found: dict[Structure, Optima], first: Grids) -> Optima:
        return Optima.all_of([found[simpler] for simpler in structure.simpler if simpler in found], first)

    def _farther(self, structure: Structure, proven: Found, optima: Optima) -> Found:
        """The better of what is proven and what can be with poles farther out, where that is worth a search."""
        if structure.wider is None or not self.setting.polynomial or self._late:
            return proven  # a proof on cells loses more than this wins
        self.progress(f"searching {structure} with poles farther out")
        polisher = Polisher.of(self.setting, structure.wider, self.omega_0)
        best = best_nearby(polisher, optima.candidates, self.ideal, self.seed, lambda: self._late)
        found = None if best is None else self._prove(polisher.again, *best)
        return proven if found is None or found.candidate.omega_B < proven.candidate.omega_B else found

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
            if self._late:
                break
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
        kept = _distinct([c for c, _ in found])[:KEPT]
        return Optima(kept, found[0][1] if found else below.grids, (program.structure,) * len(kept))

    def _starts(self, program: Program, below: Optima, asked: bool) -> Iterator[Start]:
        structure, rng = program.structure, np.random.default_rng(self.seed)
        low, high = structure.bounds
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
            for candidate, simpler in [*zip(below.candidates, below.structures, strict=True)][: len(EXTENDED)]:
                x = structure.extended(candidate.x, rng, simpler)
                inside = bool(np.all((low < x) & (x < high)))  # from a bound the search may not get away
                yield Start(x, share * candidate.omega_B, near=True, votes=inside)
        omega_B = 0.1 * self.omega_0
        drawn = program.nearest([structure.start(rng) for _ in range(DRAWN)], omega_B, below.grids)
        for x in drawn[: FEW if self.short else RANDOM if below.candidates else FIRST_RANDOM]:
            yield Start(x, omega_B)

    def _exchanged(self, program: Program, candidate: Candidate, grids: Grids) -> list[tuple[Candidate, Grids]]:
        """Solve again with the points of a finer grid where it falls short, until it does nowhere; [] if it cannot."""
        again = candidate
        for _ in range(EXCHANGES):
            omega, band = program.violated(again, self._finer)
            if (not omega and not band) or self._late:
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
            if self._late:
                break
            refuting = self.refute(candidate, REACHED * candidate.omega_B)
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

    @property
    def _late(self) -> bool:
        demand_none()  # CasADi's callbacks into Python swallow exceptions
        return self.deadline is not None and time.monotonic() > self.deadline

    @property
    def _overtime(self) -> Search:
        """The same with time enough to prove what was found."""
        return replace(
            self, deadline=None if self.deadline is None else max(self.deadline, time.monotonic() + OVERTIME)
        )


def _same(one: float, other: float) -> bool:
    return abs(one - other) < SAME * other


def _distinct(candidates: list[Candidate]) -> tuple[Candidate, ...]:
    kept: list[Candidate] = []
    for c in candidates:
        if not kept or c.omega_B < 0.9998 * kept[-1].omega_B:
            kept.append(c)
    return tuple(kept)
