"""The joint on a cell of ω: behind the hold, with symbols for what varies, the table, and the edge of the box."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from operator import add

from ..joint import Joint, Parts, Point, Real, Section, Value, ranges, rational
from ..polynomials import ONE, ZERO, Poly
from ..positivity import Inequality
from ..statements import EDGE, LOADED
from .cells import Cell
from .forms import Axis

PLACE = EDGE, 0  # the key of a load's place on the edge of the box


class VariedJoint(Joint):
    """One of a family: its parameters may be at the middle of their ranges, coefficients c of Q, or of C, c(1 + e)."""

    def __init__(self, spec: Section, controller: Section, point: Point) -> None:
        super().__init__(spec, _perturbed(controller, point), point)
        self.others: list[VariedJoint] = []  # where one symbol is 1
        if PLACE in point:
            first, last = self.edge
            self.place = [first + Poly.of(point[PLACE]) * (last - first)]

    def on(self, cell: Cell, part: Callable[[Joint], tuple[Poly, Poly]]) -> Axis:
        """A sum of two polynomials, the second behind the hold, on a cell: linear in every symbol."""
        return self.enclose(cell, *map(part, (self, *self.others)))

    def enclose(self, cell: Cell, *pairs: tuple[Poly, Poly]) -> Axis:
        """The same from pairs: the first where symbols are 0, each of the others where one of them is 1."""
        undelayed, delayed = zip(*pairs, strict=True)
        if not (sampling := self.spec["sampling"]):
            return cell.spread(*map(add, undelayed, delayed))
        if "hold" not in cell.cache:
            cell.cache["hold"] = cell.hold(*sampling.values())
        return cell.spread(*undelayed) + cell.spread(*delayed) * cell.axis(cell.cache["hold"])

    def disc_on(self, cell: Cell) -> tuple[Real, Real]:
        """The disc together with the table: 1 + V = (1 + W_w)(1 + W_t)."""
        if not (table := self.spec["uncertainty"]["table"]):
            return self.disc
        V = (square_on(cell, *self.disc).root() + ONE) * (_table(table["points"], cell) + ONE) - ONE
        return V * V, ONE


class View(VariedJoint):
    """A joint on a cell, with the hold, over the nominal's `locked`: changes no statement, and at ∞ nothing cancels."""

    def __init__(self, j: VariedJoint, nominal: VariedJoint, cell: Cell) -> None:
        self.__dict__.update(j.__dict__)
        if "by" not in cell.cache:
            cell.cache["by"] = nominal.on(cell, lambda o: (o.E, o.rest)).inverse()

        def over(part: Callable[[Joint], tuple[Poly, Poly]]) -> Value:
            pairs = tuple(map(part, (j, *j.others)))
            if pairs not in cell.cache:  # not once more for every impedance
                cell.cache[pairs] = j.enclose(cell, *pairs) * cell.cache["by"] if any(map(any, pairs)) else ZERO
            return cell.cache[pairs]

        self.cell, self.disc = cell, j.disc_on(cell)
        self.D_i, self.E_i = over(lambda o: (o.D_i, ZERO)), over(lambda o: (o.E_i, ZERO))
        self.U_n, self.command = over(lambda o: (o.U_n, ZERO)), over(lambda o: (o.command, ZERO))
        self.rest, self.driven = over(lambda o: (ZERO, o.rest)), over(lambda o: (ZERO, o.driven))
        self.locked = ONE + over(lambda o: (o.E - nominal.E, o.rest - nominal.rest))
        self.M, self.E = over(lambda o: (o.carried, ZERO)) + self.driven, self.locked - self.rest

    def weighed(self, w: Real, a: Real, b: Real, c: Real, size: Real) -> Parts:
        """Not squared: three roots of lower degree in the parameters."""
        yield Inequality([w * a, w * b, w * c], c * size)

    def both(self, a2: Real, b2: Real, p2: Real, load: Poly | None) -> Parts:
        """`|p| + W |a| < |b|`, 1 + W = (1 + W_b)(1 + V): √(V² |a|²) and W_b (1 + V) |a|, times |g|."""
        V2 = square_on(self.cell, *self.disc)
        V = V2.root()
        for k, (gap, size) in enumerate(self.ratios(load, edge=True)):
            ratio = self.cell.real(gap) * self.cell.real(size).inverse()
            if k < len(self.loads(load)) and (ratio.m >= 0 or not self.cell.ends):
                W = (ratio.at(0).root() + ONE) * (V + ONE) - ONE
                yield Inequality([p2, W * W * a2], b2)
            elif not p2 or ranges(self.spec, LOADED):
                yield Inequality([p2 * size, V2 * a2 * size, (V + ONE) * (V + ONE) * a2 * gap], b2 * size)
            else:  # a polynomial along the edge, not in other parameters
                most, last = ((norm * b2.inverse()).at(0) for norm in (p2, a2))
                P = most.root() + V * last.root()
                yield Inequality([P * P * size, (V + ONE) * (V + ONE) * last * gap], size)


def square_on(cell: Cell, gap: Real, size: Real) -> Real:
    """A quotient of two polynomials in x on a cell, finite there."""
    return (cell.real(gap) * cell.real(size).inverse()).at(0)


def filtered(kind: str, given: Section) -> Section:
    """The controller with these coefficients, of Q for a disturbance observer: C = n/(d − n)."""
    if kind != "dob":
        return {"type": kind, "C": given}
    n, d = rational(given)
    below = d - n
    C = {"numerator": given["numerator"], "denominator": [Fraction(a, below.d) for a in below.c]}
    return {"type": kind, "Q": given, "C": C}


def _perturbed(controller: Section, point: Point) -> Section:
    if not any(part in ("numerator", "denominator") for part, _ in point):
        return controller
    given = controller["Q" if controller["type"] == "dob" else "C"]
    at = {part: [c * (1 + point.get((part, k), 0)) for k, c in enumerate(row)] for part, row in given.items()}
    return filtered(controller["type"], at)


def _table(points: list[list[Fraction]], cell: Cell) -> Real:
    """W_t, linear in ω between the points, which are ends of cells."""
    k = len(points) if cell.far else sum(ω * ω <= cell.lo for ω, _ in points)
    if k in (0, len(points)):
        return cell.form(points[min(k, len(points) - 1)][1])
    (a, u), (b, v) = points[k - 1 : k + 1]
    return cell.omega() * Poly.of((v - u) / (b - a)) + Poly.of(u - a * (v - u) / (b - a))
