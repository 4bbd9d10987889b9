"""Controllers that are one number, `C_imp = k`: every gain of the search is tried, in intervals that miss none.

At one frequency all that constraints speak of is a Möbius function of k. Evaluated on an interval of gains it is its
value at the middle, off by at most a radius: where even the best value within the radius fails at some frequency, no
gain of the interval will do, and the others are divided.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..problem.constraints.inequality import Variable
from ..problem.grid import frequency_scale
from ..problem.setting import Setting
from .classical import Classical
from .conflict import Group, groups_of
from .filtered import structure_of
from .plane import ROUNDING, Demand, Disc, Plane
from .reason import Impossible, name, place
from .structure import Feedback

if TYPE_CHECKING:
    from numpy.typing import NDArray

POINTS, CELLS, DIVISIONS = 300, 100, 8
BEYOND = 3e3  # times the joint's highest frequency: where the loop of the highest gain crosses over
REMEDY = "give the controller dynamics: form: pi, p-filtered or lead-lag, or an order"


def excluded(setting: Setting) -> Impossible | None:
    """Why no gain of the search meets what is required, where the controller asked for is one; None: some might."""
    if setting.spec.controller.coefficients is not None or structure_of(setting.spec) not in (Classical(), Feedback(0)):
        return None
    low, high = frequency_scale(setting)
    omega = np.geomspace(low / 30, high * BEYOND, POINTS)
    line, least = _Gains(setting, omega), groups_of(setting)
    found = line.excluded(least)
    if found is None:
        return None
    for group in list(least):
        rest = [other for other in least if other is not group]
        if rest and (again := line.excluded(rest)) is not None:
            least, found = rest, again
    return _described(least, *found)


class _Gains(Plane):
    """The line of gains k at every frequency of `omega`: X of `Plane` is k."""

    def __init__(self, setting: Setting, omega: NDArray[np.float64]) -> None:
        super().__init__(setting, omega)
        self.F = setting.loop.filters.force.at(omega) * np.ones_like(omega)

    def _variable(self, variable: Variable, H_v: Any, k: NDArray[np.int_], X: Disc) -> Disc:
        F = self.F[k]
        values: dict[Variable, Callable[[], Disc]] = {
            Variable.Q: lambda: X.moebius(F, F, 1.0),
            Variable.Q_TILDE: lambda: X.moebius(H_v * F, H_v * F, 1.0),
            Variable.L: lambda: X * (H_v * F),
            Variable.COMMAND: lambda: X.moebius(F, H_v * F, 1.0),
        }
        return values[variable]()

    def excluded(self, groups: Sequence[Group]) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
        """Intervals of gains that cover all, each with where which group fails; None where some gain is left."""
        edges = np.exp(np.linspace(*Feedback.gains, CELLS + 1))
        cells, done = np.stack([edges[:-1], edges[1:]]), []
        for _ in range(DIVISIONS):
            fails = self.failing(cells, groups)
            out = np.any(fails > 0, axis=0)
            done.append((cells[:, out], fails[:, out]))
            cells = cells[:, ~out]
            if not cells.size:
                return np.concatenate([c for c, _ in done], axis=1), np.concatenate([f for _, f in done], axis=1)
            middle = np.sqrt(cells[0] * cells[1])
            cells = np.concatenate([np.stack([cells[0], middle]), np.stack([middle, cells[1]])], axis=1)
        return None

    def failing(self, cells: NDArray[np.float64], groups: Sequence[Group]) -> NDArray[np.float64]:
        """For each group and interval of gains (2, m): a frequency [rad/s] at which all of it fails, or 0. (groups, m).

        What is asked on the objective's own band counts at the lowest frequency only: the band may be short.
        """
        found = np.zeros((len(groups), cells.shape[1]))
        for row, group in enumerate(groups):
            for demand in group:
                places = np.arange(1 if demand.constraint.on_band else self.omega.size)
                worst = self._worst(demand, cells, places)
                k = np.argmin(worst, axis=1)
                fails = worst[np.arange(k.size), k] < 0
                found[row] = np.where((found[row] == 0) & fails, self.omega[places[k]], found[row])
        return found

    def _worst(self, demand: Demand, cells: NDArray[np.float64], places: NDArray[np.int_]) -> NDArray[np.float64]:
        """The best slack any gain of an interval can have, at each place, of the worst inequality. (m, places)."""
        m, worst = cells.shape[1], np.full((cells.shape[1], places.size), np.inf)
        middle, radius = (np.repeat(part, places.size) for part in (cells.mean(axis=0), np.ptp(cells, axis=0) / 2))
        for inequality in demand.constraint.inequalities:
            slack, size = self._slack(demand, inequality, np.tile(places, m), Disc(middle, radius))
            with np.errstate(invalid="ignore"):
                best = np.nan_to_num(slack.centre + slack.radius + ROUNDING * size, nan=np.inf)
            worst = np.minimum(worst, best.reshape(m, places.size))
        return worst


def _described(least: Sequence[Group], cells: NDArray[np.float64], fails: NDArray[np.float64]) -> Impossible:
    """Which gains each constraint excludes, and where the one among them fails that comes nearest to meeting it."""
    low, high = np.exp(Feedback.gains)
    names, said, places = [name(group[0].constraint) for group in least], [], []
    for group, n, row in zip(least, names, fails, strict=True):
        out, omega = cells[:, row > 0], row[row > 0]
        first, last = np.argmin(out[0]), np.argmax(out[1])
        upwards = out[0][first] > 2 * low  # what is excluded begins there, with larger gains; else it ends
        nearest, k = (first, out[0][first]) if upwards else (last, out[1][last])
        places.append(0.0 if group[0].constraint.on_band else float(omega[nearest]))
        excluded = f"excludes every k from {out[0][first]:.3g} to {out[1][last]:.3g}"
        said.append(f"{n} {excluded} (k = {k:.3g} at {place(places[-1])})")
    family = f"any C_imp = k, {low:g} ≤ k ≤ {high:g}"
    return Impossible(" and ".join(names), max(places), "; ".join(said), REMEDY, family, shared=len(set(places)) == 1)
