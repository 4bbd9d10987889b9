"""An optimum to its last digits: sequential quadratic programming on a dense grid.

IPOPT solves few rows from afar, this solves thousands from near by: each step is a quadratic program with the exact
curvature inside a trust region, which needs only the rows that the step can reach. The worst shortfall is penalised,
and a second step to where the rows turned out to be keeps the region from collapsing on curved ones.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ..problem.setting import Setting
from .nlp import Candidate, Program
from .places import Grids
from .quadratic import PENALTY, quadratic
from .structure import FARTHEST, Structure

if TYPE_CHECKING:
    from numpy.typing import NDArray

STEPS = 40
FIRST_RADIUS, WIDEST, NARROWEST = 0.1, 1.0, 1e-8  # of the region, in parts of each unknown's size
LEAST_SIZE = 0.1  # of an unknown
GAIN = 1e-7  # of log ω_B: a step that promises less is the last
SHORT = 1e-6  # relative shortfall of a point that counts as feasible
FINE, FINEST = (2, 60, 30), (12, 360, 1000)  # where it is solved, and where it is looked at: see `dense`
NEAR, BEYOND = (0.5, 4.0), (20.0, 10.0)  # parts of ω₀; from its multiple to one of the farthest pole
EXCHANGES = 10
ROOM = 120, 24  # places for further points, on the axis and in the band


@dataclass(frozen=True, eq=False)
class Polisher:
    """Refines candidates of one program. grids: where it solves; finest: where it looks at what was found.

    room: points that the program has places for, on the axis and in the band.
    """

    program: Program
    grids: Grids
    finest: Grids
    room: tuple[int, int]

    @classmethod
    def of(cls, setting: Setting, structure: Structure, omega_0: float) -> Polisher:
        """With grids as dense as a structure with far poles needs them. omega_0 [rad/s] normalises s."""
        grids = dense(setting, omega_0, *FINE)
        room = replace(grids, omega=np.resize(grids.omega, grids.omega.size + ROOM[0]))
        room = replace(room, band=np.resize(grids.band, grids.band.size + ROOM[1]))
        program = Program(setting, structure, room, omega_0)
        return cls(program, grids, dense(setting, omega_0, *FINEST), (room.omega.size, room.band.size))

    def refined(self, x: NDArray[np.float64], omega_B: float) -> Candidate | None:
        """The optimum that is reached from a point near by. x: (n,); omega_B [rad/s]. None where none is reached."""
        z = np.clip(np.append(x, np.log(omega_B / self.program.omega_0)), self._low, self._high)
        multipliers, radius = np.zeros(self._least.size), FIRST_RADIUS
        for _ in range(STEPS):
            size = np.append(np.maximum(np.abs(z[:-1]), LEAST_SIZE), 1.0)
            step = self._step(z, size, multipliers, radius)
            if step is None:
                break
            z, multipliers, radius = step
        if not np.all(np.isfinite(z)) or not self._slack(z).min() > -SHORT:
            return None
        omega_B = float(np.exp(z[-1]) * self.program.omega_0)
        return Candidate(self.program.structure.rounded(z[:-1], self.program.omega_0), omega_B, z[:-1])

    def again(self, candidate: Candidate, grids: Grids) -> tuple[Candidate, Grids] | None:
        """On another grid, from a candidate of this one, with the points of the finest where it falls short."""
        grids = self._merged(grids, grids.added, grids.added_band)
        for _ in range(EXCHANGES):
            found = replace(self, grids=grids).refined(candidate.x, candidate.omega_B)
            if found is None:
                return None
            candidate = found
            omega, band = self.program.violated(candidate, self.finest)
            if not omega and not band:
                break
            grids = self._merged(grids, omega, band)
        return candidate, grids

    def _merged(self, grids: Grids, omega: Sequence[float], band: Sequence[float]) -> Grids:
        """With points that stay, as long as there is room; then with the oldest of those added making room."""
        wanted = replace(
            grids, omega=np.union1d(grids.omega, omega), band=np.union1d(grids.band, band), added=(), added_band=()
        )
        fits = wanted.omega.size <= self.room[0] and wanted.band.size <= self.room[1]
        return wanted if fits else grids.refined(omega, band)

    def _step(
        self, z: NDArray[np.float64], size: NDArray[np.float64], multipliers: NDArray[np.float64], radius: float
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], float] | None:
        """The next point, its multipliers and radius; None where no step is worth it."""
        values, slopes = (np.asarray(part.full()) for part in self.program.derivatives["jac_g"](z, self._placed[0]))
        slack, slopes = (values.ravel() - self._least)[self._used], slopes[self._used] * size
        curvature = self._curvature(z, multipliers, size)
        merit = _merit(z, slack)
        while radius > NARROWEST:
            reached = np.flatnonzero(slack < radius * np.abs(slopes).sum(axis=1) + 1e-9)
            box = np.maximum((self._low - z) / size, -radius), np.minimum((self._high - z) / size, radius)
            solved = quadratic(curvature, slopes[reached], slack[reached], *box)
            if solved is None:
                return None
            d, short, weights = solved
            promised = merit - (PENALTY * short - z[-1] - d[-1] + d @ curvature @ d / 2)
            if not promised > GAIN:
                return None
            found = min(self._corrected(z, size, d, curvature, slopes, reached, box), key=lambda pair: pair[0])
            kept = (merit - found[0]) / promised
            if kept > 0.1:
                radius = min(WIDEST, 2 * radius) if kept > 0.75 else radius / 2 if kept < 0.3 else radius
                of_rows = np.zeros_like(multipliers)
                of_rows[self._used[reached]] = weights
                return found[1], of_rows, radius
            radius *= 0.3
        return None

    def _corrected(
        self,
        z: NDArray[np.float64],
        size: NDArray[np.float64],
        d: NDArray[np.float64],
        curvature: NDArray[np.float64],
        slopes: NDArray[np.float64],
        reached: NDArray[np.intp],
        box: tuple[NDArray[np.float64], NDArray[np.float64]],
    ) -> Iterator[tuple[float, NDArray[np.float64]]]:
        """Merit and point after the step d, and after the step with the rows as they turned out to be there."""
        there = np.clip(z + d * size, self._low, self._high)
        slack = self._slack(there)
        yield _merit(there, slack), there
        if np.all(np.isfinite(slack)):
            solved = quadratic(curvature, slopes[reached], (slack - slopes @ d)[reached], *box)
            if solved is not None:
                there = np.clip(z + solved[0] * size, self._low, self._high)
                yield _merit(there, self._slack(there)), there

    def _slack(self, z: NDArray[np.float64]) -> NDArray[np.float64]:
        """Of the rows in use, above the least. (m,)."""
        values: NDArray[np.float64] = np.array(self.program.slack(z, self._placed[0])).ravel()
        return (values - self._least)[self._used]

    def _curvature(
        self, z: NDArray[np.float64], multipliers: NDArray[np.float64], size: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Of the Lagrangian, in parts of each unknown's size, made convex."""
        upper = self.program.derivatives["hess_lag"](z, self._placed[0], 1.0, -multipliers).full()
        hessian = (upper + np.triu(upper, 1).T) * np.outer(size, size)
        if not np.all(np.isfinite(hessian)):
            return np.zeros_like(hessian)
        values, vectors = np.linalg.eigh(hessian)
        return np.asarray((vectors * np.abs(values)) @ vectors.T)

    @cached_property
    def _placed(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        return self.program.placed(self.grids)

    @cached_property
    def _used(self) -> NDArray[np.intp]:
        return np.flatnonzero(np.isfinite(self._placed[1]))

    @property
    def _least(self) -> NDArray[np.float64]:
        return self._placed[1]

    @property
    def _low(self) -> NDArray[np.float64]:
        return self.program.bounds["lbx"]

    @property
    def _high(self) -> NDArray[np.float64]:
        return self.program.bounds["ubx"]


def dense(setting: Setting, omega_0: float, times: int, around: int, beyond: int) -> Grids:
    """The search's grid so many times finer, with so many more points around ω₀, and as far out as poles may be."""
    grids, reach = Grids.of(setting, omega_0, times), float(np.exp(FARTHEST))
    near = np.geomspace(*NEAR, around)
    far = np.geomspace(BEYOND[0], BEYOND[1] * reach, beyond)
    return replace(grids, omega=np.union1d(grids.omega, omega_0 * np.concatenate([near, far])))


def _merit(z: NDArray[np.float64], slack: NDArray[np.float64]) -> float:
    """What is minimised: −log ω_B and the worst shortfall; ∞ where the program has no value."""
    short = max(0.0, -float(slack.min()))
    return float(PENALTY * short - z[-1]) if np.isfinite(short) else np.inf
