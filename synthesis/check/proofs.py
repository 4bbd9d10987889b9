"""How each claim is decided: Routh, polynomials, or cells; at a value, for everything in the ranges or at one point."""

from __future__ import annotations

from collections.abc import Iterator
from decimal import Decimal
from fractions import Fraction
from functools import reduce
from itertools import combinations
from math import inf
from operator import add, mul
from typing import Any

from .cells import ZERO, Cell, Point, Ranges, roots
from .forms import UnresolvedError
from .joint import EDGE, Joint, View, ranges, stiffness
from .outcome import FALSE, UNDECIDED, CheckError, demand
from .polynomials import ONE, Poly, decays_faster
from .positivity import counterexample, square
from .requirements import ALL, SIGNED, WHOLE, Kind, requirements
from .search import cover
from .statements import STATEMENTS, port_ends

VIEWS = 4096  # joints on a cell that are kept for the next claim


class Prover:
    """One certificate: its specification and a controller, the certificate's or a witness of its sensitivity."""

    def __init__(self, certificate: dict[str, Any], deadline: float, controller: dict[str, Any] | None = None) -> None:
        self.certificate, self.spec, self.deadline = certificate, certificate["spec"], deadline
        self.asked = requirements(self.spec, certificate["bandwidth"]["proven"])
        self.controller = controller or certificate["controller"]
        self.sampled, self.table = bool(self.spec["sampling"]), self.spec["uncertainty"]["table"] or {"points": []}
        self.joints, self.views, self.cells = dict[Any, Joint](), dict[Any, View](), dict[Any, Cell]()
        self.nominal = self.joint({})

    def joint(self, point: Point, symbols: Ranges | None = None) -> Joint:
        """The joint where parameters have these values, and symbols are in the middle of their ranges."""
        symbols = symbols or {}
        key = *point.items(), *symbols.items()
        if key not in self.joints:
            self.joints = self.joints if len(self.joints) < VIEWS else {}
            middle = point | {name: (lo + hi) / 2 for name, (lo, hi) in symbols.items()}
            joint = Joint(self.spec, self.controller, middle)
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
        given = [(at, witness.get(name) or {}) for name, at in PLACES.items()] if witness else []
        point = {(section, key): part for section, parts in given for key, part in parts.items()}
        if kind[1] == "coefficients":
            return self._perturbed(witness) if witness else self._tolerance(v)
        if kind[1] == "box" and not witness:
            return self._box(kind[0], v, {})
        if kind[0].startswith("stability"):
            return self._unstable(kind[0], ZERO if kind[1] == "box" else v, point)
        load = stiffness(witness["load"].values()) if witness and witness["load"] else None
        point = {key: part for key, part in point.items() if key[0] != "plant"}
        return self._statement(kind, v, interval, whole, load, point, {})

    def _statement(
        self, kind: Kind, v: Fraction, interval: Any, whole: bool, load: Poly | None, point: Point, symbols: Ranges
    ) -> str:
        """By polynomials where there are only those and at most two roots, else on cells."""
        (statement, sections), given, friction = STATEMENTS[kind], self.spec["uncertainty"], kind[0] == "friction"
        family = {k: part for k, part in ranges(self.spec, ALL[1:]).items() if k[0] in sections and k not in point}
        if EDGE[0] in sections and load is None and given["box"] and given["box"]["stiffness"][1] > 0:
            family[EDGE] = ZERO, Fraction(1)
        # Where two moduli are added, or a margin is squared, the degree in a parameter is 4.
        disc = given["weight"] or self.table["points"] or kind[1] == "disc"
        twice = EDGE in family or kind[0] in ("eq12", "rendering", "friction")
        degree = 4 if kind[1].startswith(("paper", "lumped")) or (disc and twice) else 2
        for end in (end for end in interval if whole and end in WHOLE and (friction or kind in SIGNED)):
            at, name = Cell(ZERO, ZERO, end == inf, symbols), "Z at infinity" if end else "Z(0)"

            def ends(cell: Cell, there: Point) -> Iterator[Any]:
                return port_ends(friction, self.joint({**point, **there}, cell.ranges), self.nominal, cell, load)

            if cover([at], ends, self.deadline, family, degree):
                return f": {name} is not finite and {'>' if friction else '>='} 0"
        several = kind == ("eq12", "paper") or (EDGE[0] in sections and given["box"] and given["weight"])
        if not (family or symbols or self.sampled or self.table["points"] or several):
            return self._exactly(list(statement(self.joint(point), v, load)), interval)

        def on(cell: Cell, there: Point) -> Iterator[Any]:
            return statement(self.view(cell, {**point, **there}), v, load)

        cells = roots(interval, [ω for ω, _ in self.table["points"]], symbols)
        return cover(cells, on, self.deadline, family, degree)

    def _exactly(self, parts: list[Any], interval: Any) -> str:
        undecided, (lo, hi) = None, map(square, interval)
        for part in parts:
            try:
                at = counterexample(part, lo, hi, self.deadline)
            except CheckError as error:
                undecided = error  # only if no part fails
            else:
                if at is not None:
                    return f" at ω = {(Decimal(at[0]) / at[1]).sqrt() if at[1] else inf:.6g} rad/s"
        if undecided:
            raise undecided
        return ""

    def _unstable(self, name: str, v: Fraction, point: Point) -> str:
        """Why the roots at one point are not all at Re s < −v; empty if they are."""
        if self.sampled:
            return self._turns(name, point)
        j = self.joint(point)
        f = add(*j.loop(name))
        if not decays_faster(f, v, self.deadline):
            return ": a root does not decay at the stated rate"
        lost = name == "stability-locked" and len(f.c) < len(j.E.c)  # a lost degree is a root at infinity
        return ": 1 + HCF vanishes at infinity" if lost else ""

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
            z = j.value(cell, name) * cell.axis(reference).inverse()
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
            found = [self.nominal.on(cell, pair) for pair in zonotopes[corner]]
            if cell.ends:  # where it is finite, and real, over the nominal's
                if "by" not in cell.cache:
                    cell.cache["by"] = self.nominal.value(cell, name).inverse()
                found = [f * cell.cache["by"] for f in found]
            return [found]

        return cover(roots(WHOLE, [], {}), on, self.deadline, motor, 1)

    def generators(self, name: str, there: Point, ranges: Ranges) -> dict[Any, tuple[Poly, Poly]]:
        """The characteristic function at the middle of ranges, and what one parameter, or two at once, change by half
        of theirs: no three of loads, impedances and coefficients are multiplied."""
        found: dict[Any, tuple[Poly, Poly]] = {}
        for up in [(), *combinations(ranges, 1), *combinations(ranges, 2)]:
            at = {key: hi if key in up else (lo + hi) / 2 for key, (lo, hi) in ranges.items()}
            value = self.joint(there | at).loop(name)
            for part in (part for part in [(), *combinations(up, 1)] if part != up):
                value = value[0] - found[part][0], value[1] - found[part][1]
            found[up] = value
        return {up: pair for up, pair in found.items() if not up or any(pair)}

    def _tolerance(self, v: Fraction) -> str:
        """Every required claim at its required level, for every coefficient c(1 + e), |e| ≤ v."""
        given = self.controller["Q" if self.controller["type"] == "dob" else "C"]
        extra = {(part, k): (-v, v) for part in ("denominator", "numerator") for k, c in enumerate(given[part]) if c}
        for (name, form), (required, interval, level) in self.asked.items():
            if not required or name == "tolerance":
                continue
            if name.startswith("stability"):
                text = self._box(name, Fraction(form == "box"), extra)
            else:
                text = self._statement((name, form), level or ZERO, interval, interval == WHOLE, None, {}, extra)
            if text:
                return f": {name} {form}{text}"
        return ""

    def _perturbed(self, witness: dict[str, Any]) -> str:
        """How the required claim that the witness names fails for its controller."""
        kind, given = tuple(witness["claim"]), witness["controller"]
        controller = {"type": self.controller["type"], "C": given}
        if controller["type"] == "dob":
            below = Poly.of(*given["denominator"]) - Poly.of(*given["numerator"])
            rest = {"numerator": given["numerator"], "denominator": [Fraction(a, below.d) for a in below.c]}
            controller = {**controller, "Q": given, "C": rest}
        other = Prover(self.certificate, self.deadline, controller)
        (_, interval, level), ω = self.asked[kind], witness["omega"]
        where = interval if ω is None else (ω, ω)
        return other.fault(kind, level or ZERO, where, interval == WHOLE, witness)


PLACES = {
    "load": "plant",
    "impedance": "impedance",
    "actuator": "actuator",
}  # of a witness: its section
