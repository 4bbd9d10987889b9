"""Branch and bound on cells: the hardest level at which a constraint holds everywhere, from both sides.

On each cell the level v that just holds is enclosed as a form. Its lower bounds over all cells prove; its value at a
point, an exact frequency with exact parameters, refutes. Cells that could still hold the worst point are halved.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .cells import Cells, Part
from .form import Form

if TYPE_CHECKING:
    from numpy.typing import NDArray

GAP = 8e-3  # relative distance of the two sides that is small enough
ROUNDS, MOST_CELLS = 40, 60_000
HUGE = 1e300  # a bound beyond this says nothing
TRIED = 48  # of the most doubtful cells, points are looked at
Evaluate = Callable[[Cells], Sequence[Form]]


@dataclass(frozen=True)
class Point:
    """Where a quantity is smallest: a degenerate cell of its own (k), and the upper bound there."""

    cells: Cells
    k: int
    value: float
    form: int  # which of the forms it is

    @property
    def omega(self) -> float:
        """Frequency [rad/s]; inf at the end of the axis."""
        z = float(self.cells.z[0, self.k])
        if self.cells.part is Part.HIGH:
            return np.inf if z == 0 else 1 / z
        return z


@dataclass(frozen=True)
class Minimum:
    """`low ≤ min ≤ high`, the latter attained at a point. low is −inf where nothing could be proven."""

    low: float
    high: float
    at: Point | None


@dataclass(frozen=True)
class Halving:
    """Which parameters may be halved, (m,), and the offset for which each is proportional to t + offset, (m,)."""

    which: NDArray[np.bool_]
    offset: NDArray[np.float64]

    def widest(self, cells: Cells) -> NDArray[np.int_]:
        """The parameter of which most is left."""
        width = (cells.t[1] - cells.t[0]) * self.which[:, None]
        return np.asarray(np.argmax(width, axis=0))

    def apply(self, cells: Cells) -> Cells:
        """Cells halved along that."""
        return cells.split_parameter(self.widest(cells), self.offset)


def minimum(
    evaluate: Evaluate,
    axis: Sequence[Cells],
    *,
    floor: float | None = None,
    hopeless: float = -np.inf,
    scale: float = 0.0,
    gap: float = GAP,
    halving: Halving | None = None,
) -> Minimum:
    """Least value of several forms over cells, to a relative `gap`; stops early once `floor` is proven or refuted.

    hopeless: a point below ends the search; scale: absolute size below which differences do not matter;
    halving: which parameters may be halved, and where.
    """
    open_cells, low, best = list(axis), np.inf, Minimum(-np.inf, np.inf, None)
    enough = np.inf if floor is None else float(np.nextafter(floor, np.inf))
    for rounds in range(ROUNDS):
        views = []
        for cells in open_cells:
            bound, slopes = _lowest(evaluate(cells), cells)
            doubtful = ~(bound >= enough)
            low = min(low, float(bound[~doubtful].min(initial=np.inf)))
            if doubtful.any():
                view = _view(evaluate, cells[doubtful], bound[doubtful], slopes[:, doubtful], halving)
                views.append(view)
                if view.point is not None and view.point.value < best.high:
                    best = Minimum(-np.inf, view.point.value, view.point)
        if best.high < (hopeless if floor is None else floor):
            return best
        if floor is None and np.isfinite(best.high):
            enough = float(np.nextafter(best.high - gap * (abs(best.high) + scale), np.inf))
        open_cells = []
        for view in views:
            done = view.bound >= enough
            low = min(low, float(view.bound[done].min(initial=np.inf)))
            if not done.all():
                open_cells.append(_halved(view, ~done, rounds, halving))
        if not open_cells:
            return Minimum(low, best.high, best.at)
        if sum(cells.size for cells in open_cells) > MOST_CELLS:
            break
    undone = min(float(view.bound.min()) for view in views)
    return Minimum(min(low, undone) if floor is None else -np.inf, best.high, best.at)


@dataclass(frozen=True)
class View:
    """What is known of n doubtful cells: lower bounds, (n,), the best point seen, and what each halving would gain.

    gain: (1+m, n), by how much the bound rises where the frequency, or a parameter, is fixed at its worst end.
    """

    cells: Cells
    bound: NDArray[np.float64]
    point: Point | None
    gain: NDArray[np.float64] | None


def _view(
    evaluate: Evaluate,
    cells: Cells,
    bound: NDArray[np.float64],
    slopes: NDArray[np.float64],
    halving: Halving | None,
) -> View:
    """Points and fixed ends of cells, evaluated together: a call costs little more for many cells than for few."""
    tried = np.argsort(bound)[:TRIED]
    points = cells[tried].points(-np.sign(slopes[1:, tried]))
    if halving is None or not halving.which.any():
        return View(cells, bound, _best(evaluate(points), points), None)
    known, indices = np.where(bound > -HUGE, slopes, 0.0), [-1, *np.flatnonzero(halving.which).tolist()]
    ends = Cells.joined([cells.at_end(index, known[1 + index] > 0) for index in indices])
    forms = evaluate(Cells.joined([points, ends]))
    point = _best([form[: tried.size] for form in forms], points)
    fixed, _ = _lowest([form[tried.size :] for form in forms], ends)
    gain = np.full((1 + halving.which.size, cells.size), -np.inf)
    gain[[1 + index for index in indices]] = np.maximum(fixed, -HUGE).reshape(-1, cells.size) - np.maximum(bound, -HUGE)
    return View(cells, bound, point, gain)


def _best(forms: Sequence[Form], points: Cells) -> Point | None:
    """The point of least upper bound."""
    best: Point | None = None
    for index, form in enumerate(forms):
        upper = -_scaled(form, -form.upper, points)
        upper = np.where(np.isfinite(form.rho), upper, np.inf)
        k = int(np.argmin(np.nan_to_num(upper, nan=np.inf)))
        if np.isfinite(upper[k]) and (best is None or upper[k] < best.value):
            best = Point(points, k, float(upper[k]), index)
    return best


def _lowest(forms: Sequence[Form], cells: Cells) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Lower bound of all forms on every cell, (n,), and the slopes (1+m, n) of the form that is lowest there."""
    lowest, slopes = np.full(cells.size, np.inf), np.zeros((1 + cells.t.shape[1], cells.size))
    for form in forms:
        lower = _scaled(form, form.lower, cells)
        smaller = lower < lowest
        lowest = np.where(smaller, lower, lowest)
        slopes = np.where(smaller, form.c[1:], slopes)
    return lowest, slopes


def _scaled(form: Form, lower: NDArray[np.float64], cells: Cells) -> NDArray[np.float64]:
    """A lower bound of z^order·form from one of the form, over every z of the cell."""
    lower = np.nan_to_num(lower, nan=-np.inf)
    if form.order == 0:
        return lower
    with np.errstate(all="ignore"):
        ends = np.nan_to_num(lower * cells.z**form.order, nan=-np.inf if form.order < 0 else 0.0)
    return np.asarray(np.where(lower < 0, ends.min(axis=0), np.maximum(ends.min(axis=0), 0.0)))


def _halved(view: View, which: NDArray[np.bool_], rounds: int, halving: Halving | None) -> Cells:
    """Some cells, each halved along what raises its bound by most, or by turns."""
    cells, bound = view.cells[which], view.bound[which]
    if halving is None or view.gain is None:
        return cells.split_frequency()
    gain, lost = view.gain[:, which], ~(bound > -HUGE)
    gain[0] = np.where(lost, -np.inf, gain[0])  # where nothing is known yet, a parameter is to blame, now and then ω
    turn = np.zeros(cells.size, dtype=int) if rounds % 3 == 2 else 1 + halving.widest(cells)
    useful = (gain.max(axis=0) > 0) & np.where(lost, rounds % 3 != 2, rounds % 6 != 5)
    chosen = np.where(useful, gain.argmax(axis=0), turn)
    frequency = chosen == 0
    halves = [cells[frequency].split_frequency()] if frequency.any() else []
    halves += [cells[~frequency].split_parameter(chosen[~frequency] - 1, halving.offset)] if not frequency.all() else []
    return Cells.joined(halves)
