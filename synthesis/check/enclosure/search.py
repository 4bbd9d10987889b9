"""The search: cells of ω and boxes of parameters are halved until every inequality is decided on all of them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from fractions import Fraction
from functools import reduce
from itertools import product
from operator import add
from typing import Any

from ..joint import Point, Ranges
from ..outcome import UNDECIDED, CheckError, demand, tick
from ..polynomials import Poly
from ..positivity import Inequality
from .cells import Cell
from .forms import Axis, Form, UnresolvedError, excludes_zero

CELLS, DEPTH, POINTS = 40_000, 60, 4_096  # limits
CONTROL = {  # from values at 0, 1/n, …, 1 of a polynomial of degree n to its Bernstein coefficients, times [0][0]
    1: ((1, 0), (0, 1)),
    2: ((2, 0, 0), (-1, 4, -1), (0, 0, 2)),
    4: (
        (36, 0, 0, 0, 0),
        (-39, 144, -108, 48, -9),
        (26, -128, 240, -128, 26),
        (-9, 48, -108, 144, -39),
        (0, 0, 0, 0, 36),
    ),
}
LEBESGUE = {1: (1, 1), 2: (5, 2), 4: (80, 1)}  # of these points, times [0][0]: fractions, rounded up


def cover(
    cells: list[Cell],
    parts: Callable[[Cell, Point], Iterable[Any]],
    deadline: float,
    box: Ranges | None = None,
    degree: int = 2,
) -> str:
    """Where a part fails; empty if all are proven on all cells, in the order of ω, for all parameters of the box.

    In every parameter a part is a polynomial of degree 2, with two terms or degree 4 if so; terms are squares of moduli
    of what is affine."""
    stack = [(cell, box or {}, 0) for cell in reversed(cells)]
    for _ in range(CELLS):
        if not stack:
            return ""
        tick(deadline)
        cell, around, depth = stack.pop()
        said, axes = _look(cell, around, parts, degree, deadline)
        if said < 0:
            return str(cell)
        if said == 0:
            wide = cell.lo < cell.hi
            demand(depth < DEPTH and (wide or bool(around)), f"neither proven nor refuted{cell}", UNDECIDED)
            if depth % 4 == 3:  # now and then the other one: which of them matters is a guess
                axes = [] if axes or depth % 8 == 3 else [*range(len(around))]
            if axes or not wide:
                key = [*around][(axes or range(len(around)))[depth % len(axes or around)]]
                lo, hi = around[key]
                halves = [(cell, {**around, key: half}) for half in ((lo, (lo + hi) / 2), ((lo + hi) / 2, hi))]
            else:
                halves = [(half, around) for half in cell.halves()]
            stack += [(*half, depth + 1) for half in reversed(halves)]
    raise CheckError(UNDECIDED, "neither proven nor refuted")


def _look(cell: Cell, box: Ranges, parts: Any, degree: int, deadline: float) -> tuple[int, list[int]]:
    """1: every part is proven; −1: one fails; 0, and the parameters to halve, if not ω."""
    values = [[lo + (hi - lo) * Fraction(k, degree) for k in range(degree + 1)] for lo, hi in box.values()]
    demand((degree + 1) ** len(box) <= POINTS, "too many ranges at once", UNDECIDED)
    found, at = (1, list[int]()), []
    try:
        for point in product(*values):
            tick(deadline)
            at.append(list(parts(cell, dict(zip(box, point, strict=True)))))
        for same in zip(*at, strict=True):
            said = _hull(same, len(box)) if isinstance(same[0], list) else compare(cell, same, degree, len(box))
            if said[0] < 0:
                return said
            found = found if said[0] or not found[0] else said
    except UnresolvedError:
        return 0, []
    return found


def _hull(zonotopes: Sequence[Sequence[Axis]], n: int) -> tuple[int, list[int]]:
    """A function that is affine in every parameter stays in the convex hull of its values at the corners."""
    everywhere, middle = excludes_zero(zonotopes)
    return (1, []) if everywhere else (0, [] if middle else list(range(n)))


def compare(cell: Cell, same: Sequence[Inequality], degree: int = 2, n: int = 0) -> tuple[int, list[int]]:
    """Whether `Σ √terms < √bound` on the cell, from values at a grid of n parameters: 1; −1 at a corner; 0: unknown."""
    strict, digits = same[0].strict, list(product(range(degree + 1), repeat=n))
    rows = [[*map(cell.real, part.terms), cell.real(part.bound)] for part in same]
    used = [k for k, column in enumerate(zip(*rows, strict=True)) if any(column) or k + 1 == len(rows[0])]
    rows, over = [[row[k] for k in used] for row in rows], [cell.real(part.over) for part in same]
    if cell.ends and strict and any(f and row[-1].m > f.m for f, row in zip(over, rows, strict=True)):
        return -(n == 0 and 1 in (over[0].sign(), (-over[0]).sign())), []  # zero in the limit
    present = [f for row in rows for f in row if f] or [rows[0][-1]]
    m = min(f.m for f in present) if cell.ends else max(present, key=Form.size).m
    rows = [
        [Form(cell, 0, f.e, f.c, f.l, f.q, f.r) for f in (-g.at(m) if m % 2 else g.at(m) for g in row)] for row in rows
    ]
    if len(rows[0]) > (3 if n == 0 or degree == 4 else 2):
        return _moduli(rows, degree, n)
    inner = [[i for i in range(n) if 0 < place[i] < degree] for place in digits]
    for values in _conditions(rows):
        for way in (control, levelled) if n else (control,):  # the first decides equality at a corner
            slacks = way(values, degree, n)
            good = n == 1 and degree == 2 and _quadratic(slacks, strict)
            said = (1, list[int]()) if good else _verdict([*zip(inner, slacks, strict=True)], strict)
            if said[0]:
                break
        if said[0] != 1:
            return said
    return 1, []


def _moduli(rows: list[list[Form]], degree: int, n: int) -> tuple[int, list[int]]:
    """By roots: the bound is at least its smallest Bernstein coefficient, a sum of moduli largest at a corner."""
    digits, cell = list(product(range(degree + 1), repeat=n)), rows[0][0].cell
    bounds = (levelled if n else control)([row[-1] for row in rows], degree, n)
    if n and any(f.sign() != 1 for f in bounds):
        return 0, list(range(n))
    found = []
    for corner, row in zip(digits, rows, strict=True):
        if all(d in (0, degree) for d in corner):
            terms = (f.scaled(CONTROL[degree][0][0] ** n).root() for f in row[:-1] if f)
            total = reduce(add, terms, cell.form())
            for place, bound in zip(digits, bounds, strict=True):
                found.append(([i for i in range(n) if corner[i] != place[i]], bound.root() - total))
    return _verdict(found, True)


def _verdict(slacks: list[tuple[list[int], Form]], strict: bool) -> tuple[int, list[int]]:
    """From Bernstein coefficients, or other lower bounds, with the parameters in which they are not true values."""
    doubtful = [entry for entry in slacks if entry[1].sign(strict) != 1]
    if not doubtful:
        return 1, []
    if any(f.sign(strict) < 0 for axes, f in doubtful if not axes):
        return -1, []
    least, width, axes = min((f.middle(), f.width(), axes) for axes, f in doubtful)
    return 0, axes if min(f.middle() for axes, f in slacks if not axes) - least > width else []


def _conditions(rows: list[list[Form]]) -> Iterator[list[Form]]:
    """What has to be positive at all points: b − a for `√a < √b`, `h = b − a1 − a2` and `h² − 4 a1 a2` for two."""
    differences = [reduce(add, [-f for f in terms], bound) for *terms, bound in rows]
    yield differences
    if len(rows[0]) == 3:
        yield [h * h - Poly.of(4) * a * b for h, (a, b, _) in zip(differences, rows, strict=True)]


def _quadratic(b: list[Form], strict: bool) -> bool:
    """Whether `b_0 (1−t)² + 2 b_1 t (1−t) + b_2 t² > 0` on [0, 1], also where b_1 < 0: b_1² < b_0 b_2."""
    ends = b[0].sign() == b[2].sign() == 1
    return ends and (b[1].sign(strict) == 1 or (b[0] * b[2] - b[1] * b[1]).sign() == 1)


def control(values: list[Form], degree: int, n: int) -> list[Form]:
    """Bernstein coefficients of a polynomial of this degree in each of n parameters, times a positive number."""
    for _ in range(n):  # the first parameter becomes the last
        width = len(values) // (degree + 1)
        values = [
            reduce(add, [f.scaled(w) for w, f in zip(row, values[k::width], strict=True) if w])
            for k in range(width)
            for row in CONTROL[degree]
        ]
    return values


def levelled(values: list[Form], degree: int, n: int) -> list[Form]:
    """The same for a polynomial below, where these are of the values' known part, less a bound of what is unknown.

    The unknown part is a polynomial of this degree too, on the grid within the forms' r, so everywhere within r times
    the Lebesgue constant; its coefficients, which `control` bounds, may be many times larger."""
    e, (over, under) = max(f.e for f in values), LEBESGUE[degree]
    unknown = max(((f.r >> e - f.e) + 1 for f in values if f), default=0) * over**n // under**n + 1
    rest = Form(values[0].cell, 0, e, 0, [0] * len(values[0].l), 0, unknown)
    known = [Form(f.cell, 0, f.e, f.c, f.l, f.q, 0) for f in values]
    return [f + rest for f in control(known, degree, n)]
