"""How the claims are decided that polynomials do not decide: on cells of ω, and of what varies."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from fractions import Fraction
from functools import partial, reduce
from itertools import combinations
from math import inf
from operator import mul
from typing import Any

from ..joint import Joint, Point, Ranges, ranges, rational
from ..outcome import FALSE, UNDECIDED, demand, tick
from ..polynomials import ONE, Poly
from ..proofs import Prover
from ..requirements import ALL, WHOLE, Kind, requirements
from ..statements import EDGE, IDEAL, STATEMENTS, Limit, port_ends
from .cells import ZERO, Cell, roots
from .forms import UnresolvedError
from .joint import PLACE, VariedJoint, View, filtered, square_on
from .search import cover

VIEWS = 4096  # joints on a cell that are kept for the next claim
PAIRED = 64  # ranges of which all pairs are formed


class CellProver(Prover):
    """One certificate, its claims decided by polynomials where these can, else on cells."""

    nominal: VariedJoint

    def __init__(self, certificate: dict[str, Any], deadline: float) -> None:
        self.joints, self.views, self.cells = dict[Any, VariedJoint](), dict[Any, View](), dict[Any, Cell]()
        super().__init__(certificate, deadline)
        self.asked = requirements(self.spec, certificate["bandwidth"]["proven"])
        self.table = self.spec["uncertainty"]["table"] or {"points": []}

    def joint(self, point: Point, symbols: Ranges | None = None) -> VariedJoint:
        """The joint where parameters have these values, and symbols are in the middle of their ranges."""
        symbols = symbols or {}
        key = *point.items(), *symbols.items()
        if key not in self.joints:
            self.joints = self.joints if len(self.joints) < VIEWS else {}
            middle = point | {name: (lo + hi) / 2 for name, (lo, hi) in symbols.items()}
            joint = VariedJoint(self.spec, self.certificate["controller"], middle)
            joint.others = [self.joint(middle | {name: hi}) for name, (_, hi) in symbols.items()]
            self.joints[key] = joint  # now: the others may have emptied the store
        return self.joints[key]

    def view(self, cell: Cell, point: Point) -> View:
        """The joint on a cell, kept for the next claim."""
        if len(self.views) > VIEWS:
            self.views, self.cells = {}, {}
            cell.cache.clear()
        cell = self.cells.setdefault(cell.key, cell)
        key = (*cell.key, *point.items())
        if key not in self.views:
            self.views[key] = View(self.joint(point, cell.ranges), self.nominal, cell)
        return self.views[key]

    def fault(self, kind: Kind, v: Fraction, interval: Any, whole: bool, witness: dict[str, Any] | None = None) -> str:
        """Where the statement fails at v, for all uncertainty or at the witness; empty if it is proven."""
        exact = super().fault(kind, v, interval, whole, witness)
        if exact is not None:
            return exact
        point, load = self.place(witness)
        if kind[1] == "coefficients":
            return self._perturbed(witness) if witness else self._tolerance(v)
        if kind[1] == "box" and not witness:
            return self._box(kind[0], v, {})
        if kind[0].startswith("stability"):
            return self._unstable(kind[0], v, point)
        return self._on_cells(kind, v, interval, whole, load, point, {})

    def _on_cells(
        self, kind: Kind, v: Fraction, interval: Any, whole: bool, load: Poly | None, point: Point, symbols: Ranges
    ) -> str:
        (statement, sections), given = STATEMENTS[kind], self.spec["uncertainty"]
        family = {k: part for k, part in ranges(self.spec, ALL[1:]).items() if k[0] in sections and k not in point}
        if EDGE in sections and load is None and self.nominal.edge:
            family[PLACE] = ZERO, Fraction(1)
        # Where two moduli are added, or a margin is squared, the degree in a parameter is 4.
        disc = given["weight"] or self.table["points"] or kind[1] == "disc"
        twice = PLACE in family or kind[0] in ("eq12", "rendering", "friction")
        degree = 4 if kind[1].startswith(("paper", "lumped")) or (disc and twice) else 2
        for end, name, text in self.ends(kind, interval, whole):

            def at_end(cell: Cell, there: Point, name: str = name) -> Iterator[Any]:
                j = self.joint({**point, **there}, cell.ranges)
                V2 = square_on(cell, *map(cell.real, j.disc_on(cell)))
                return port_ends(name, cell.far, j, self._limits_on(cell, name, j), V2, load)

            if cover([Cell(ZERO, ZERO, end == inf, symbols)], at_end, self.deadline, family, degree):
                return text

        def on(cell: Cell, there: Point) -> Iterator[Any]:
            return statement(self.view(cell, {**point, **there}), v, load)

        cells = roots(interval, [ω for ω, _ in self.table["points"]], symbols)
        return cover(cells, on, self.deadline, family, degree)

    def _limits_on(self, cell: Cell, name: str, j: VariedJoint) -> Limit:
        """Limits of a part of the joint over the nominal's function and a power of s, on the cell that is a point."""
        by = self.nominal.on(cell, partial(Joint.loop, name=name, g=self.nominal.nominal)).inverse()

        def limit(part: Callable[[Joint], Any], power: Poly) -> Any:
            z = j.on(cell, part) * by * cell.axis(power).inverse()
            return z.p.at(0) if z.bounded() else None

        return limit

    def _unstable(self, name: str, v: Fraction, point: Point) -> str:
        return self._turns(name, point) if self.spec["sampling"] else super()._unstable(name, v, point)

    def _turns(self, name: str, point: Point) -> str:
        """Quarter turns of f/(s + a)^n from ω = 0 to ∞: as many half-planes as there are cells, neighbours adjacent.

        a is a power of two, n the degree of what the hold does not multiply, which has to be the larger one."""
        j, path = self.joint(point), list[int]()
        undelayed, delayed = j.loop(name)
        f = undelayed + delayed
        demand(bool(undelayed) and bool(f) and f.c[0] != 0, "a root at zero", FALSE)
        demand(len(delayed.c) <= len(undelayed.c), "the loop at infinity depends on the hold", UNDECIDED)
        n, low, high = len(undelayed.c) - 1, Fraction(f.c[0], f.d), Fraction(undelayed.c[-1], undelayed.d)
        k = (abs(low / high).numerator.bit_length() - abs(low / high).denominator.bit_length()) // max(n, 1)
        reference: Poly = reduce(mul, [Poly.of(Fraction(2) ** k, 1)] * n, ONE)

        def on(cell: Cell, _: Point) -> list[Any]:
            z = j.on(cell, partial(Joint.loop, name=name)) * cell.axis(reference).inverse()
            signs = [f.sign() == 1 for f in (z.p, z.q, -z.p, -z.q)]
            if cell.ends:  # real there
                signs = [sign and k % 2 == 0 and z.p.m == 0 for k, sign in enumerate(signs)]
            steps = (path[-1], path[-1] + 1, path[-1] - 1) if path else (0, 2)
            found = next((step for step in steps if signs[step % 4]), None)
            if found is None:
                raise UnresolvedError
            path.append(found)
            return []

        cover(roots(WHOLE, [], {}), on, self.deadline)
        return f": {abs(path[-1] - path[0]) // 2} roots with Re s > 0" if path[-1] != path[0] else ""

    def _box(self, name: str, v: Fraction, symbols: Ranges) -> str:
        """No root on the axis for any parameters in the box scaled by v: none crosses from the stable nominal."""
        if fault := self._unstable(name, ZERO, {}):
            return fault
        family = ranges(self.spec, ALL if name == "stability-free" else ALL[2:], v) if v else {}
        motor = {key: part for key, part in family.items() if key[0] == "actuator"}
        linear = {key: part for key, part in family.items() if key not in motor} | symbols
        zonotopes: dict[Any, list[tuple[Poly, Poly]]] = {}

        def on(cell: Cell, there: Point) -> list[Any]:
            if (corner := tuple(there.items())) not in zonotopes:
                zonotopes[corner] = [*self.generators(name, there, linear).values()]
            found = [self.nominal.enclose(cell, pair) for pair in zonotopes[corner]]
            if cell.ends:  # where it is finite, and real, over the nominal's
                if "by" not in cell.cache:
                    cell.cache["by"] = self.nominal.on(cell, partial(Joint.loop, name=name)).inverse()
                found = [f * cell.cache["by"] for f in found]
            return [found]

        return cover(roots(WHOLE, [], {}), on, self.deadline, motor, 1)

    def generators(self, name: str, there: Point, ranges: Ranges) -> dict[Any, tuple[Poly, Poly]]:
        """The characteristic function at the middle of ranges, and what one parameter, or two at once, change by half
        of theirs: no three of loads, impedances and coefficients are multiplied."""
        demand(len(ranges) <= PAIRED, "too many ranges at once", UNDECIDED)
        found: dict[Any, tuple[Poly, Poly]] = {}
        for up in [(), *combinations(ranges, 1), *combinations(ranges, 2)]:
            tick(self.deadline)
            at = {key: hi if key in up else (lo + hi) / 2 for key, (lo, hi) in ranges.items()}
            value = self.joint(there | at).loop(name)
            for part in (part for part in [(), *combinations(up, 1)] if part != up):
                value = value[0] - found[part][0], value[1] - found[part][1]
            found[up] = value
        return {up: pair for up, pair in found.items() if not up or any(pair)}

    def _tolerance(self, v: Fraction) -> str:
        """Every required claim at its required level, for every coefficient c(1 + e), |e| ≤ v."""
        controller = self.certificate["controller"]
        given = controller["Q" if controller["type"] == "dob" else "C"]
        n, d = rational(given)
        below, above = d.c[-1] * n.d, n.c[-1] * d.d if len(n.c) == len(d.c) and controller["type"] == "dob" else 0
        if abs(below - above) <= v * (abs(below) + abs(above)):
            return ": C is not proper for all of them"
        extra = {(part, k): (-v, v) for part in ("denominator", "numerator") for k, c in enumerate(given[part]) if c}
        for (name, form), (required, interval, level) in self.asked.items():
            if not required or name == "tolerance":
                continue
            if name.startswith("stability"):
                text = self._box(name, Fraction(form == "box"), extra)
            else:
                text = self._on_cells((name, form), level or ZERO, interval, interval == WHOLE, None, {}, extra)
            if not text and (name, form) in IDEAL and interval != WHOLE:  # where it excludes no root on the axis
                text = CellProver(self.ideal(), self.deadline)._box(IDEAL[name, form], ZERO, extra)
            if text:
                return f": {name} {form}{text}"
        return ""

    def _perturbed(self, witness: dict[str, Any]) -> str:
        """How the required claim that the witness names fails for its controller."""
        kind, given = tuple(witness["claim"]), self.certificate["controller"]
        controller = filtered(given["type"], witness["controller"])
        other = CellProver(self.certificate | {"controller": controller}, self.deadline)
        (_, interval, level), ω = self.asked[kind], witness["omega"]
        where = interval if ω is None else (ω, ω)
        return other.fault(kind, level or ZERO, where, interval == WHOLE, witness)
