"""Whether any complex number X = Q̃ meets given demands at one frequency: a search of the plane that misses nothing.

At one frequency a controller is a complex number, `CF = X/(H(1−X))`, and everything constraints speak of is a Möbius
function of it. A demand evaluated on a disc of X is its value at the centre, off by at most a radius: where even the
best value within the radius fails, the disc holds no answer, and the others are divided. In the end there is nothing
left (no X exists), or a centre that meets everything, or, after many divisions, a doubt of which nothing is claimed.
Convexity is not needed, and no solver is asked.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

from ..problem.constraints.inequality import Constraint, Inequality, Variable
from ..problem.grid import Evaluator
from ..problem.setting import Setting

if TYPE_CHECKING:
    from numpy.typing import NDArray

FARTHEST = 1e4  # of 1−X: no controller amplifies a disturbance as much
DIVISIONS = 30
MOST_DISCS = 40_000
ROUNDING = 1e-10  # relative: what floating point may be off by, with much to spare
EXISTS, NONE, DOUBT = 1, -1, 0
LIKELY = (1.0, 0.0, 0.8, 0.5, 0.5 + 0.5j, 0.5 - 0.5j, 1 - 0.5j, 1.5, -0.5j)  # X that often do
QUARTERS = np.array([-1 - 1j, -1 + 1j, 1 - 1j, 1 + 1j])


@dataclass(frozen=True)
class Disc:
    """Numbers within `radius` of `centre`, elementwise; real ones where the centre is real. (m,) each."""

    centre: Any
    radius: Any

    __array_ufunc__ = None  # an array on the left defers to the methods here

    def __add__(self, other: Any) -> Disc:
        if isinstance(other, Disc):
            return Disc(self.centre + other.centre, self.radius + other.radius)
        return Disc(self.centre + other, self.radius)

    __radd__ = __add__

    def __neg__(self) -> Disc:
        return Disc(-self.centre, self.radius)

    def __sub__(self, other: Any) -> Disc:
        return self.__add__(-other)

    def __rsub__(self, other: Any) -> Disc:
        return (-self).__add__(other)

    def __mul__(self, factor: Any) -> Disc:
        return Disc(self.centre * factor, self.radius * np.abs(factor))

    __rmul__ = __mul__

    def __abs__(self) -> Disc:
        return Disc(np.abs(self.centre), self.radius)

    @property
    def real(self) -> Disc:
        """Real parts."""
        return Disc(self.centre.real, self.radius)

    def moebius(self, p: Any, s: Any, t: Any) -> Disc:
        """`pX/(sX + t)`; off its centre by `pt·δ/(D D₀)`, D₀ and D the denominators there."""
        denominator = s * self.centre + t
        nearest = np.abs(denominator) - np.abs(s) * self.radius
        with np.errstate(all="ignore"):
            off = np.abs(p * t) * self.radius / (np.abs(denominator) * nearest)
            return Disc(p * self.centre / denominator, np.where(nearest > 0, off, np.inf))


@dataclass(frozen=True)
class Demand:
    """A constraint, for one vertex of the ranges, at a level v: what is asked, or one for each frequency, (n,)."""

    constraint: Constraint
    vertex: Setting
    level: Any

    @property
    def key(self) -> tuple[str, str]:
        """Which constraint it is, whatever the vertex."""
        return self.constraint.id, self.constraint.form


class Plane:
    """The plane of X at every frequency of `omega`, (n,) [rad/s]."""

    def __init__(self, setting: Setting, omega: NDArray[np.float64]) -> None:
        self.omega, self.H = omega, setting.loop.actuator.H.at(omega)
        self.at = cache(lambda r: np.broadcast_to(r.at(omega), omega.shape))
        self.radius = cache(Evaluator(setting, omega).radius)

    def search(self, demands: Sequence[Demand]) -> NDArray[np.int_]:
        """EXISTS, NONE or DOUBT at each frequency. Returns (n,)."""
        found, everywhere = np.full(self.omega.size, DOUBT), np.arange(self.omega.size)
        for X in LIKELY:
            k = everywhere[found != EXISTS]
            self._test(demands, found, k, Disc(np.full(k.size, X), np.zeros(k.size)))
        k = everywhere[found != EXISTS]
        centre, half = np.ones(k.size, complex), np.full(k.size, FARTHEST)
        for _ in range(DIVISIONS):
            open_ = self._test(demands, found, k, Disc(centre, np.sqrt(2) * half))
            k, centre, half = k[open_], centre[open_], half[open_] / 2
            if k.size == 0 or k.size > MOST_DISCS:
                break
            k, half = np.repeat(k, 4), np.repeat(half, 4)
            centre = np.repeat(centre, 4) + half * np.tile(QUARTERS, centre.size)
        left = np.isin(everywhere, k)
        return np.where(found == EXISTS, EXISTS, np.where(left, DOUBT, NONE))

    def relative_slack(self, demand: Demand, X: complex) -> float:
        """Least slack of a demand at the first frequency for one X, relative to the size of its sides."""
        k, point = np.zeros(1, int), Disc(np.full(1, complex(X)), np.zeros(1))
        found = (self._slack(demand, inequality, k, point) for inequality in demand.constraint.inequalities)
        return float(min(slack.centre[0] / max(float(np.max(size)), 1e-300) for slack, size in found))

    def _test(self, demands: Sequence[Demand], found: Any, k: NDArray[np.int_], X: Disc) -> NDArray[np.bool_]:
        """Mark the frequencies k where a centre meets every demand; which discs may still hold an answer. (m,)."""
        met, open_ = np.ones(k.size, bool), np.ones(k.size, bool)
        for demand in demands:
            for inequality in demand.constraint.inequalities:
                slack, size = self._slack(demand, inequality, k, X)
                met &= slack.centre >= 0
                with np.errstate(invalid="ignore"):  # no value at a pole: nothing is excluded
                    open_ &= ~(slack.centre + slack.radius < -ROUNDING * size)
        found[k[met]] = EXISTS
        return np.asarray(open_ & (found[k] != EXISTS))

    def _variable(self, variable: Variable, H_v: Any, k: NDArray[np.int_], X: Disc) -> Disc:
        """What an inequality speaks of, from X; H_v: of the vertex, at the frequencies k."""
        H = self.H[k]
        return {
            Variable.Q: lambda: X.moebius(1.0, 1 - H, H),
            Variable.Q_TILDE: lambda: X.moebius(H_v, H_v - H, H),
            Variable.L: lambda: X.moebius(H_v, -H, H),
            Variable.COMMAND: lambda: X.moebius(1.0, H_v - H, H),
        }[variable]()

    def _slack(self, demand: Demand, inequality: Inequality, k: NDArray[np.int_], X: Disc) -> tuple[Disc, Any]:
        """Right minus left side, and the size of both; met wherever the constraint does not apply."""
        at = self.at
        variable = self._variable(inequality.variable, at(demand.vertex.loop.actuator.H)[k], k, X)
        level = np.broadcast_to(demand.level, self.omega.shape)[k]
        with np.errstate(all="ignore"):
            left, right = inequality.sides(level, self.radius(inequality.source)[k], variable, lambda r: at(r)[k])
            slack = Disc(0.0, 0.0) + right - left
            size = sum(np.abs(side.centre) if isinstance(side, Disc) else np.abs(side) for side in (left, right))
        low, high = demand.constraint.band
        outside = (self.omega[k] < float(low)) | (self.omega[k] > (np.inf if high is None else float(high)))
        centre = np.where(outside, np.inf, np.nan_to_num(slack.centre, nan=-np.inf))
        return Disc(centre, np.where(outside, 0.0, slack.radius)), size
