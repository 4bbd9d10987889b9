"""The limit: the largest ω_B over all Q̃ in a large basis, convex and so globally solved.

At a given ω_B the least attainable level of the band's constraints is a second-order cone program; it grows with ω_B,
and where it reaches 1 is the limit. The basis is enlarged until ω_B stops growing, on a grid that resolves its
resonances: on one that does not, a larger basis hides its peaks between the points and the figure grows for ever. Only
constraints convex in Q̃ enter; the rest, if any, are dropped, which can only raise the figure. It is a number from a
solver on a grid: reported, used to start and to judge the search, never claimed as proven.
"""

from __future__ import annotations

from collections.abc import Callable, Container
from dataclasses import asdict, dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import UndecidedError
from ..problem.grid import frequency_scale, grid
from ..problem.setting import Setting
from ..spec.model import FREE
from .band import BandProgram, Binding
from .basis import Basis
from .cone import Failure
from .reduction import Response

if TYPE_CHECKING:
    from numpy.typing import NDArray

Progress = Callable[[str], None]

ROUGH_TERMS, FIRST_TERMS, GROWTH, MOST_TERMS = 20, 48, 1.25, 150
NEAR, MOVES = 0.1, 4  # how close to ω_B the poles have to be placed, and how often they are moved there
CONVERGED = 0.01  # relative growth of ω_B below which the basis is large enough
NEARLY = 0.99  # of the highest frequency that is looked at: no limit was met
SPREAD, DENSE, FINER = 300, 600, 4  # points over everything and around ω_B, besides resonances; then so many times more
RESPONSE = 8  # one point of the grid in so many is enough to begin a search from
SLOW = 1e3  # so many times slower poles, before it is said that nothing is feasible
BEYOND, TAIL = 1e3, 30  # how far beyond the joint's frequencies Q̃ is watched as it dies out, at so many points


@dataclass(frozen=True)
class Bound:
    """ω_B that no controller with Q̃ in the basis exceeds on the grid, and what limits it there.

    limited: False where nothing limits ω_B as far as the joint's frequencies reach: all is feasible at omega_B still.
    terms: size of the basis; growth: what the last enlargement of the basis added, relative, None if there was none;
    stopped: why it was not enlarged further although it may grow, "" where it converged.
    """

    omega_B: float
    terms: int
    growth: float | None
    binding: tuple[Binding, ...]
    dropped: tuple[str, ...]
    response: Response = field(repr=False, compare=False)
    limited: bool = True
    stopped: str = ""

    @property
    def text(self) -> str:
        """In words."""
        figure = f"{self.omega_B:.4g} rad/s"
        return f"the bound is {figure}" if self.limited else f"nothing limits it below {figure}"

    @property
    def binds(self) -> str:
        """Which constraints set it, where each of them most; "" where nothing limits it."""
        most = " and ".join(
            f"{b.constraint} at {b.most:.4g} rad/s" for b in self.binding if b.constraint != "bandwidth"
        )
        return f", set by {most}" if most else ""

    def to_json(self) -> dict[str, Any]:
        """For scripts: all but the response."""
        shown = ("omega_B", "limited", "terms", "growth", "dropped", "stopped")
        return {name: getattr(self, name) for name in shown} | {"binding": [asdict(b) for b in self.binding]}


def bound(setting: Setting, terms: int | None = None, progress: Progress = lambda _: None) -> Bound | None:
    """The bound, with a basis of `terms` functions or one large enough; None where even ω_B → 0 is infeasible.

    Raises: UndecidedError where the solver fails before there is any figure.
    """
    high = frequency_scale(setting)[1]
    wide = wide_program(setting, ROUGH_TERMS)
    around = wide.largest_band(wide.basis.around, coarse=True)
    if around is Failure.INFEASIBLE:  # not unless slow poles are of no help, either
        wide = wide_program(setting, FIRST_TERMS, slow=SLOW)
        around = wide.largest_band(wide.basis.around, coarse=True)
        if around is Failure.INFEASIBLE:
            return None
    if isinstance(around, Failure):
        raise _undecided(around, wide.basis.terms)
    highest = float(grid(setting)[-1])
    if around > NEARLY * highest:
        return _result(wide, highest, limited=False)
    size, moves, before, program = terms or FIRST_TERMS, 0, None, wide
    while True:
        progress(f"bound: convex program with {size} terms")
        basis = Basis(around, size, _roll_off(setting), high)
        program = BandProgram(setting, resolving(setting, basis, FINER), basis, like=program)
        found = program.largest_band(around)
        if isinstance(found, Failure):
            if before is None and terms is None:
                before = _with_fewer(setting, size, progress)
            if before is None:
                raise _undecided(found, size)
            return replace(before, stopped=f"{found.value} ({size} terms)")
        if found > highest:
            return _result(program, highest, limited=False)
        if abs(found / around - 1) > NEAR and moves < MOVES:
            around, moves = found, moves + 1
            continue
        growth = None if before is None else found / before.omega_B - 1
        best = _result(program, found, growth)
        if before is not None and found < before.omega_B:  # the larger basis contains the smaller one but for its poles
            best = replace(before, growth=growth)
        if terms is not None or (growth is not None and abs(growth) < CONVERGED):
            return best
        if size * GROWTH > MOST_TERMS:
            return replace(best, stopped="the basis is as large as it may be")
        before, size, around = best, round(size * GROWTH), best.omega_B


def _with_fewer(setting: Setting, size: int, progress: Progress) -> Bound | None:
    """The bound of the largest basis of fewer terms that the solver is up to."""
    while (size := round(size / GROWTH)) > MOST_TERMS / 10:
        try:
            return bound(setting, size, progress)
        except UndecidedError:
            continue
    return None


def wide_program(setting: Setting, terms: int, among: Container[str] | None = None, slow: float = 1.0) -> BandProgram:
    """The cone programs of a basis that is spread over everything the joint does, with poles so many times slower.

    among: as `BandProgram` has it.
    """
    low, high = frequency_scale(setting)
    basis = Basis((low * high) ** 0.5, terms, _roll_off(setting), high)
    basis = replace(basis, slowest=basis.slowest / slow)
    return BandProgram(setting, resolving(setting, basis), basis, among=among)


def resolving(setting: Setting, basis: Basis, finer: int = 1) -> NDArray[np.float64]:
    """A grid on which no resonance of the basis hides between two points, or one so many times finer. [rad/s]."""
    coarse = grid(setting, around=basis.around, spread=SPREAD, dense=DENSE)
    coarse = np.union1d(coarse, basis.resonances())
    coarse = np.append(coarse, coarse[-1] * np.geomspace(1, BEYOND, TAIL)[1:])
    places = np.arange(finer * (coarse.size - 1) + 1) / finer
    return np.interp(places, np.arange(coarse.size), coarse)


def _result(program: BandProgram, omega_B: float, growth: float | None = None, *, limited: bool = True) -> Bound:
    """The bound of the last solution; without a limit nothing binds."""
    dropped = tuple(dict.fromkeys(c.id for c in program.dropped))
    binding = program.binding() if limited else ()
    response = Response(program.omega[::RESPONSE], program.X[::RESPONSE])
    return Bound(omega_B, program.basis.terms, growth, binding, dropped, response, limited)


def _undecided(failure: Failure, terms: int) -> UndecidedError:
    return UndecidedError(f"no bound: {failure.value} ({terms} terms); try other --terms")


def _roll_off(setting: Setting) -> int:
    """Relative degree of `Q̃/H` that a controller can have; of a filter that is free like that of any given one.

    Behind a filter C may be anything proper, so Q̃ is the same set whatever the corner is.
    """
    if setting.spec.controller.type == "dob":
        return 2
    return 1 if setting.spec.controller.filters.force == FREE else max(0, setting.loop.filters.force.relative_degree)
