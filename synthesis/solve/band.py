"""The cone programs of the bound: how well one basis meets the band's constraints up to a given ω_B.

Each program sees few frequencies. Those of the grid where its solution falls short join it, those it does not rest on
leave it, until it falls short nowhere: what counts is what the solution attains on the whole grid, not the solver's
word for it.
"""

from __future__ import annotations

from collections.abc import Container
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from ...models.rational import ONE
from ..problem.constraints import constraints
from ..problem.constraints.inequality import Variable
from ..problem.setting import Setting
from .basis import Basis
from .cone import Block, Failure, minimise
from .rows import Rows

if TYPE_CHECKING:
    from numpy.typing import NDArray

FIRST_POINTS = 8  # of the program, for each inequality
SHORT = 3e-4  # relative shortfall that makes a frequency join the program
INACCURATE = 1e-3  # shortfall, or distance from the level promised, at which a solution is none
LEVEL, COARSE_LEVEL = 1e-3, 0.02  # |log| of the level at which ω_B is found
SLOPE = 2.0  # of log level over log ω, before two points tell
SHARE, CLOSE = 0.2, 0.01  # of the level's distance from 1: a shortfall small enough for the next step, for a figure
STEPS = 30  # of the search for ω_B
TIGHT = 1e-6  # the multiplier of a row that stays in the program
MEANINGFUL = 0.1  # the level from which on multipliers say which rows the solution rests on
BINDS = 1e-3  # of the largest multiplier of a constraint: where it binds
BEYOND = 1.02  # the level that needs no more frequencies to say that ω_B is too high
PROGRAMS = 60


@dataclass(frozen=True)
class Binding:
    """A constraint with multipliers at the optimum. most: where they are largest; low, high: between which [rad/s]."""

    constraint: str
    most: float
    low: float
    high: float


@dataclass(eq=False)
class _Watched:
    """An inequality on the grid. places: of its frequencies in the grid; chosen: of those, the program's.

    left, stays: those that have left the program at this ω_B, and those of them that have come back.
    """

    rows: Rows
    on_band: bool
    places: NDArray[np.int_]
    spread: NDArray[np.int_]
    chosen: NDArray[np.int_] = field(default_factory=lambda: np.zeros(0, int))
    tight: NDArray[np.int_] = field(default_factory=lambda: np.zeros(0, int))  # where the last solution has multipliers
    left: NDArray[np.int_] = field(default_factory=lambda: np.zeros(0, int))
    stays: NDArray[np.int_] = field(default_factory=lambda: np.zeros(0, int))
    eased: bool = False

    def begin(self, eased: str = "") -> None:
        """For another ω_B or another constraint to ease: what was tight before."""
        self.eased = eased == self.rows.id if eased else self.on_band
        self.chosen, self.left, self.stays = np.union1d(self.spread, self.tight), np.zeros(0, int), np.zeros(0, int)

    def release(self) -> None:
        """What is not tight leaves: the solution is the same without, and the next found sooner. But only once."""
        kept = np.union1d(self.tight, self.stays)
        self.left = np.union1d(self.left, np.setdiff1d(self.chosen, kept))
        self.chosen = kept

    def join(self, short: NDArray[np.int_]) -> bool:
        """Where the solution falls short; whether any of it is new to the program. What comes back stays."""
        new = np.setdiff1d(short, self.chosen)
        self.chosen, self.stays = np.union1d(self.chosen, new), np.union1d(self.stays, np.intersect1d(new, self.left))
        return new.size > 0

    def until(self, end: int) -> NDArray[np.int_]:
        """The program's frequencies; on the band those below its end."""
        return self.chosen[self.chosen < end] if self.on_band else self.chosen


class BandProgram:
    """One basis on one grid [rad/s]. like: another one of the same setting, whose tight frequencies are begun with.

    among: ids of the constraints that count, by default all that are required and convex in Q̃; the rest is `dropped`.
    X: Q̃ on the grid at the last solution, (n,).
    """

    def __init__(
        self,
        setting: Setting,
        omega: NDArray[np.float64],
        basis: Basis,
        like: BandProgram | None = None,
        among: Container[str] | None = None,
    ) -> None:
        self.setting, self.omega, self.basis = setting, omega, basis
        everything = [(k, v, c) for k, v in enumerate(setting.vertices(actuators=False)) for c in constraints(v)]
        required = [(k, v, c) for k, v, c in everything if c.required and (among is None or c.id in among)]
        known = {Variable.Q_TILDE, Variable.COMMAND}
        known |= {Variable.Q} if setting.loop.actuator.H == ONE else set()  # H = 1: Q = Q̃
        kept = [e for e in required if all(q.convex and q.variable in known for q in e[2].inequalities)]
        self.dropped = [c for k, v, c in required if all(c is not other for _, _, other in kept)]
        self.band = [(k, v, c, q) for k, v, c in kept if c.on_band for q in c.inequalities]
        self.watched = []
        for k, v, c in kept:
            for q in c.inequalities:
                rows = Rows.of(v, c, q, omega, k)
                if not rows.omega.size:  # its interval may lie beyond the grid
                    continue
                spread = np.unique(np.linspace(0, rows.omega.size - 1, FIRST_POINTS).astype(int))
                self.watched.append(_Watched(rows, c.on_band, np.searchsorted(omega, rows.omega), spread))
        for watched in self.watched:  # one unit for all inequalities of a constraint
            watched.rows = replace(watched.rows, unit=self.unit(watched.rows.id) / (watched.rows.floor or 1.0))
        for here, there in zip(self.watched, like.watched if like is not None else (), strict=False):
            near = np.searchsorted(here.rows.omega, there.rows.omega[there.tight])
            here.tight = np.unique(np.clip(near, 0, here.rows.omega.size - 1))

        values = setting.loop.actuator.H.at(omega)[:, None] * basis.at(omega)
        triangle = np.linalg.qr(np.vstack([values.real, values.imag]) / np.sqrt(omega.size), mode="r")
        self.inverse = np.linalg.pinv(triangle, rcond=1e-12)
        self.values = values @ self.inverse
        self.X = np.zeros(omega.size, complex)
        self.weights: list[tuple[str, float, float]] = []

    def unit(self, id: str) -> float:
        """What a level that is added is eased in, in its own unit; 1 for those that multiply."""
        return max((w.rows.floor or 1.0 for w in self.watched if w.rows.id == id), default=1.0)

    def largest_band(self, start: float, *, coarse: bool = False) -> float | Failure:
        """ω_B where the least level is 1 [rad/s]: secants on the logarithms, kept between what is known."""
        low, high = np.log(self.omega[0]), np.log(self.omega[-1])
        at, before = float(np.log(start)), None
        for _ in range(STEPS):
            level = self.level(float(np.exp(at)))
            if isinstance(level, Failure):
                return level
            value = float(np.log(max(level, 1e-12)))
            if abs(value) < (COARSE_LEVEL if coarse else LEVEL) or high - low < LEVEL:
                break
            low, high = (at, high) if value < 0 else (low, at)
            slope = SLOPE if before is None or before[1] == value else (value - before[1]) / (at - before[0])
            before = at, value
            to = at - np.clip(value / max(slope, SLOPE / 10), -1, 1)
            at = float(to if low < to < high else (low + high) / 2)
        else:
            return Failure.UNSOLVED
        return float(np.exp(at)) if at > np.log(self.omega[0]) + 0.01 else Failure.INFEASIBLE

    def level(self, omega_B: float, eased: str = "") -> float | Failure:
        """Least level, in parts of what is asked, at which the band's constraints hold up to omega_B [rad/s].

        eased: id of a constraint that is eased instead, while the band's hold as they are asked.
        """
        end = int(np.searchsorted(self.omega, omega_B))
        here = np.array([omega_B])
        at_edge = self.setting.loop.actuator.H.at(here)[:, None] * self.basis.at(here) @ self.inverse
        edge = [Rows.of(v, c, q, here, k) for k, v, c, q in self.band]
        for watched in self.watched:
            watched.begin(eased)
        objective = np.append(np.zeros(self.values.shape[1]), 1.0)
        for _ in range(PROGRAMS):
            parts = [(w.rows, w.until(end)) for w in self.watched]
            blocks = [
                _block(w.rows, chosen, self.values[w.places[chosen]], w.eased)
                for w, (_, chosen) in zip(self.watched, parts, strict=True)
            ]
            parts += [(rows, np.array([0])) for rows in edge]
            blocks += [_block(rows, np.array([0]), at_edge, eased in ("", rows.id)) for rows in edge]
            solution = minimise(objective, blocks)
            if isinstance(solution, Failure):
                return solution
            self.X = self.values @ solution.y[:-1]
            self.weights = [
                (rows.id, float(w), float(omega))
                for (rows, chosen), weights in zip(parts, solution.weights, strict=True)
                for w, omega in zip(weights, rows.omega[chosen], strict=True)
            ]
            for watched, (_, chosen), weights in zip(self.watched, parts, solution.weights, strict=False):
                watched.tight = chosen[weights > TIGHT]
                if solution.value > MEANINGFUL:
                    watched.release()
            joined, short = self._joined(solution.value, end)
            far = abs(solution.value - 1)
            if (solution.value > BEYOND and not eased) or short < (CLOSE if eased else SHARE) * far:
                return solution.value  # more frequencies can only raise the level
            if not joined:
                return Failure.UNSOLVED if short > INACCURATE else solution.value
        return Failure.UNSOLVED

    def _joined(self, level: float, end: int) -> tuple[bool, float]:
        """Whether frequencies joined the program, the worst of each dip; and by how much the solution falls short."""
        joined, short = False, 0.0
        for watched in self.watched:
            rows, X = watched.rows, self.X[watched.places]
            slack = rows.slack(X, level if watched.eased else 1.0)
            slack = slack[:end] if watched.on_band else slack
            dips = (slack <= np.append(slack[1:], np.inf)) & (slack <= np.insert(slack[:-1], 0, np.inf))
            joined |= watched.join(np.flatnonzero(dips & (slack < -SHORT)))
            short = max(short, -float(slack.min(initial=np.inf)))
        return joined, short

    def binding(self) -> tuple[Binding, ...]:
        """Constraints with multipliers at the optimum, the heaviest first."""
        heaviest: dict[str, float] = {}
        for name, weight, _ in self.weights:
            heaviest[name] = max(weight, heaviest.get(name, 0.0))
        found = []
        for name, most in sorted(heaviest.items(), key=lambda item: -item[1]):
            on = [(weight, omega) for id, weight, omega in self.weights if id == name and weight > BINDS * most]
            if most > 1e-4:
                ends = [omega for _, omega in on]
                found.append(Binding(name, max(on)[1], min(ends), max(ends)))
        return tuple(found)


def _block(rows: Rows, chosen: NDArray[np.int_], values: NDArray[np.complex128], eased: bool) -> Block:
    """Rows of a program in (x, level), the level where they are eased: it multiplies the right side, a number there."""
    empty = np.zeros((chosen.size, 1))

    def matrix(slope: NDArray[np.complex128]) -> NDArray[np.complex128]:
        return np.hstack([np.broadcast_to(slope, rows.omega.shape)[chosen][:, None] * values, empty])

    moduli = [(matrix(line.slope), line.constant[chosen]) for line in rows.moduli]
    B, b = matrix(rows.rest.slope).real, np.real(rows.rest.constant)[chosen]
    if eased and rows.floor is not None:
        B[:, -1], b = rows.unit, b - rows.unit
    elif eased:
        B[:, -1], b = b, np.zeros(chosen.size)
    return Block(moduli, B, b)
