"""The limit: the largest ω_B over all Q̃ in a large basis, convex and so globally solved.

At a given ω_B the least attainable level of the band's constraints is a second-order cone program; it grows with ω_B,
and where it reaches 1 is the limit. Each program sees few frequencies: those of a fine grid where its solution falls
short join it. The basis is enlarged until ω_B stops growing. Only constraints convex in Q̃ enter; the rest, if any, are
dropped, which can only raise the figure. It is a number from a solver on a grid: reported, used to start and to judge
the search, never claimed as proven.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from ...models.rational import ONE
from ..problem.constraints import constraints
from ..problem.constraints.inequality import Variable
from ..problem.grid import frequency_scale, grid
from ..problem.setting import Setting
from .basis import Basis
from .cone import Block, minimise
from .reduction import Response
from .rows import Rows

if TYPE_CHECKING:
    from numpy.typing import NDArray

Progress = Callable[[str], None]

ROUGH_TERMS, FIRST_TERMS, GROWTH, MOST_TERMS = 20, 48, 1.25, 150
NEAR, MOVES = 0.03, 4  # how close to ω_B the poles have to be placed, and how often they are moved there
CONVERGED = 0.01  # relative growth of ω_B below which the basis is large enough
NEARLY = 0.99  # of the highest frequency of the first grid: no limit was met
POINTS = 600  # of the grid around ω_B
FIRST_POINTS = 16  # of the program, for each inequality
SHORT = 1e-4  # relative shortfall that makes a frequency join the program
LEVEL, COARSE_LEVEL = 3e-4, 0.02  # |log| of the level at which ω_B is found
SLOPE = 3.0  # of log level over log ω, before two points tell
TIGHT = 1e-6  # the multiplier of a row that stays in the program when ω_B moves
BEYOND = 1.02  # the level that needs no more frequencies to say that ω_B is too high
PROGRAMS = 60


@dataclass(frozen=True)
class Bound:
    """ω_B that no controller with Q̃ in the basis exceeds on the grid, and what limits it there.

    limited: False where nothing limits ω_B as far as the joint's frequencies reach: all is feasible at omega_B still.
    terms: size of the basis; growth: what the last enlargement of the basis added, relative, None if there was none;
    binding: constraints with a multiplier at the optimum, each with the frequency [rad/s] where it is largest.
    """

    omega_B: float
    terms: int
    growth: float | None
    binding: tuple[tuple[str, float], ...]
    dropped: tuple[str, ...]
    response: Response = field(repr=False, compare=False)
    limited: bool = True

    @property
    def text(self) -> str:
        """In words."""
        figure = f"{self.omega_B:.4g} rad/s"
        return f"the bound is {figure}" if self.limited else f"nothing limits it below {figure}"

    def to_json(self) -> dict[str, Any]:
        """For scripts: all but the response."""
        shown = ("omega_B", "limited", "terms", "growth", "binding", "dropped")
        return {name: getattr(self, name) for name in shown}


def bound(setting: Setting, terms: int | None = None, progress: Progress = lambda _: None) -> Bound | None:
    """The bound, with a basis of `terms` functions or one large enough; None where even ω_B → 0 is infeasible."""
    low, high = frequency_scale(setting)
    wide = _Program(setting, grid(setting, spread=200), Basis((low * high) ** 0.5, ROUGH_TERMS, _roll_off(setting)))
    around = wide.largest_band((low * high) ** 0.5, coarse=True)
    if around is None:
        return None
    highest = float(wide.omega[-1])
    if around > NEARLY * highest:
        return wide.result(highest, limited=False)
    size, moves, before = terms or FIRST_TERMS, 0, None
    while True:
        progress(f"bound: convex program with {size} terms")
        omega = grid(setting, around=around, spread=POINTS // 4, dense=POINTS)
        program = _Program(setting, omega, Basis(around, size, _roll_off(setting)))
        found = program.largest_band(around)
        if found is None:
            return before
        if found > highest:
            return program.result(highest, limited=False)
        if abs(found / around - 1) > NEAR and moves < MOVES:
            around, moves = found, moves + 1
            continue
        growth = None if before is None else found / before.omega_B - 1
        best = program.result(found, growth)
        if before is not None and found < before.omega_B:
            best = before
        if terms is not None or (growth is not None and growth < CONVERGED) or size * GROWTH > MOST_TERMS:
            return best
        before, size, around = best, round(size * GROWTH), best.omega_B


def _roll_off(setting: Setting) -> int:
    """Relative degree of `Q̃/H` that a controller can have."""
    return 2 if setting.spec.controller.type == "dob" else max(0, setting.loop.filters.force.relative_degree)


class _Program:
    """The cone programs of one basis on one grid. X: Q̃ on the grid at the last solution, (n,)."""

    def __init__(self, setting: Setting, omega: NDArray[np.float64], basis: Basis) -> None:
        self.setting, self.omega, self.basis = setting, omega, basis
        everything = [(k, v, c) for k, v in enumerate(setting.vertices(actuators=False)) for c in constraints(v)]
        required = [(k, v, c) for k, v, c in everything if c.required]
        known = {Variable.Q_TILDE, Variable.COMMAND}
        known |= {Variable.Q} if setting.loop.actuator.H == ONE else set()  # H = 1: Q = Q̃
        kept = [e for e in required if all(q.convex and q.variable in known for q in e[2].inequalities)]
        self.dropped = [c for k, v, c in required if all(c is not other for _, _, other in kept)]
        self.band = [(k, v, c, q) for k, v, c in kept if c.on_band for q in c.inequalities]
        rows = [
            Rows.of(v, c, q, omega, k) for on in (False, True) for k, v, c in kept if c.on_band is on
            for q in c.inequalities
        ]  # fmt: skip
        self.rows = [r for r in rows if r.omega.size]  # a constraint's own interval may lie beyond the grid
        self.fixed = len(self.rows) - len(self.band)
        self.places = [np.searchsorted(omega, rows.omega) for rows in self.rows]
        self.spread = [np.unique(np.linspace(0, r.omega.size - 1, FIRST_POINTS).astype(int)) for r in self.rows]
        self.chosen = self.spread

        values = setting.loop.actuator.H.at(omega)[:, None] * basis.at(omega)
        triangle = np.linalg.qr(np.vstack([values.real, values.imag]) / np.sqrt(omega.size), mode="r")
        self.inverse = np.linalg.pinv(triangle, rcond=1e-12)
        self.values = values @ self.inverse
        self.X = np.zeros(omega.size, complex)
        self.weights: list[tuple[str, float, float]] = []
        self.tight = [np.zeros(0, int) for _ in self.rows]  # where the last solution has a multiplier

    def largest_band(self, start: float, *, coarse: bool = False) -> float | None:
        """ω_B where the least level is 1 [rad/s]: secants on the logarithms, kept between what is known."""
        low, high = np.log(self.omega[0]), np.log(self.omega[-1])
        at, before = float(np.log(start)), None
        for _ in range(30):
            level = self.level(float(np.exp(at)))
            if level is None:
                return None
            value = float(np.log(max(level, 1e-12)))
            if abs(value) < (COARSE_LEVEL if coarse else LEVEL) or high - low < LEVEL:
                break
            low, high = (at, high) if value < 0 else (low, at)
            slope = SLOPE if before is None or before[1] == value else (value - before[1]) / (at - before[0])
            before = at, value
            to = at - np.clip(value / max(slope, SLOPE / 10), -1, 1)
            at = float(to if low < to < high else (low + high) / 2)
        return float(np.exp(at)) if at > np.log(self.omega[0]) + 0.01 else None

    def level(self, omega_B: float) -> float | None:
        """Least level, in parts of what is asked, at which the band's constraints hold up to omega_B; None: no Q̃."""
        end = int(np.searchsorted(self.omega, omega_B))
        here = np.array([omega_B])
        at_edge = self.setting.loop.actuator.H.at(here)[:, None] * self.basis.at(here) @ self.inverse
        edge = [Rows.of(v, c, q, here, k) for k, v, c, q in self.band]
        self.chosen = [np.union1d(*both) for both in zip(self.spread, self.tight, strict=True)]
        objective = np.append(np.zeros(self.values.shape[1]), 1.0)
        for _ in range(PROGRAMS):
            parts = [(rows, self._chosen(index, end)) for index, rows in enumerate(self.rows)]
            blocks = [
                _block(rows, chosen, self.values[place[chosen]], index >= self.fixed)
                for index, ((rows, chosen), place) in enumerate(zip(parts, self.places, strict=True))
            ]
            parts += [(rows, np.array([0])) for rows in edge]
            blocks += [_block(rows, np.array([0]), at_edge, True) for rows in edge]
            solution = minimise(objective, blocks)
            if solution is None:
                return None
            self.X, level = self.values @ solution.y[:-1], solution.value
            self.weights = [
                (rows.id, float(w), float(omega))
                for (rows, chosen), weights in zip(parts, solution.weights, strict=True)
                for w, omega in zip(weights, rows.omega[chosen], strict=True)
            ]
            self.tight = [
                chosen[weights > TIGHT] for (_, chosen), weights in zip(parts, solution.weights, strict=False)
            ][: len(self.rows)]
            if not self._joined(level, end) or level > BEYOND:  # more frequencies can only raise the level
                break
        return level

    def _chosen(self, index: int, end: int) -> NDArray[np.int64]:
        """The places of one inequality in the program; on the band those below its end."""
        chosen = self.chosen[index]
        return chosen if index < self.fixed else chosen[chosen < end]

    def _joined(self, level: float, end: int) -> bool:
        """Whether frequencies where the solution falls short joined the program: the worst of each dip."""
        joined = False
        for index, rows in enumerate(self.rows):
            X = self.X[self.places[index]]
            slack = rows.slack(X) if index < self.fixed else rows.slack(X, level)[:end]
            dips = (slack <= np.append(slack[1:], np.inf)) & (slack <= np.insert(slack[:-1], 0, np.inf))
            new = np.setdiff1d(np.flatnonzero(dips & (slack < -SHORT)), self.chosen[index])
            self.chosen[index] = np.union1d(self.chosen[index], new)
            joined = joined or new.size > 0
        return joined

    def result(self, omega_B: float, growth: float | None = None, *, limited: bool = True) -> Bound:
        """The bound of the last solution; without a limit nothing binds."""
        dropped = tuple(dict.fromkeys(c.id for c in self.dropped))
        binding = self.binding() if limited else ()
        response = Response(self.omega, self.X)
        return Bound(omega_B, self.basis.terms, growth, binding, dropped, response, limited)

    def binding(self) -> tuple[tuple[str, float], ...]:
        """Constraints with a multiplier at the optimum, each with the frequency where it is largest."""
        found: dict[str, tuple[float, float]] = {}
        for name, weight, omega in self.weights:
            if weight > max(1e-4, found.get(name, (0.0, 0.0))[0]):
                found[name] = (weight, omega)
        return tuple((name, omega) for name, (_, omega) in sorted(found.items(), key=lambda item: -item[1][0]))


def _block(rows: Rows, chosen: NDArray[np.int64], values: NDArray[np.complex128], on_band: bool) -> Block:
    """Rows of a program in (x, level): on the band the level multiplies the right side, a number there."""
    empty = np.zeros((chosen.size, 1))

    def matrix(slope: NDArray[np.complex128]) -> NDArray[np.complex128]:
        return np.hstack([np.broadcast_to(slope, rows.omega.shape)[chosen][:, None] * values, empty])

    moduli = [(matrix(line.slope), line.constant[chosen]) for line in rows.moduli]
    B, b = matrix(rows.rest.slope).real, np.real(rows.rest.constant)[chosen]
    if on_band:
        B[:, -1], b = b, np.zeros(chosen.size)
    return Block(moduli, B, b)
