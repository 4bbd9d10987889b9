"""How each claim is decided: Routh, polynomials, or cells; at a value, for everything in the ranges or at one point."""

from __future__ import annotations

from collections.abc import Iterator
from decimal import Decimal
from fractions import Fraction
from functools import reduce
from math import inf
from operator import add, mul
from typing import Any

from .cells import ZERO, Cell, Ranges, cover, roots
from .forms import UnresolvedError
from .joint import Joint, Point, ranges, stiffness
from .outcome import FALSE, UNDECIDED, CheckError, demand
from .polynomials import ONE, Poly, decays_faster
from .positivity import counterexample, square
from .requirements import ALL, SIGNED, WHOLE, Kind, asked, required_kinds
from .statements import STATEMENTS, port_ends

VIEWS = 4096  # joints on a cell that are kept for the next claim


class Prover:
    """One certificate: its specification and a controller, the certificate's or a witness of its sensitivity."""

    def __init__(self, certificate: dict[str, Any], deadline: float, controller: dict[str, Any] | None = None) -> None:
        self.spec, self.deadline, self.omega_b = certificate["spec"], deadline, certificate["bandwidth"]["proven"]
        self.controller = controller or certificate["controller"]
        self.sampled, self.table = bool(self.spec["sampling"]), self.spec["uncertainty"]["table"] or {"points": []}
        self.exact, self.views = Joint(self.spec, self.controller, {}), dict[Any, Joint]()

    def fault(self, kind: Kind, v: Fraction, interval: Any, whole: bool, witness: dict[str, Any] | None = None) -> str:
        """Where the statement fails at v, for all uncertainty or at the witness; empty if it is proven."""
        given = [(at, witness.get(name) or {}) for name, at in PLACES.items()] if witness else []
        point = {(section, key): Poly.of(part) for section, parts in given for key, part in parts.items()}
        if kind[1] == "coefficients":
            return self._perturbed(witness) if witness else self._tolerance(v)
        if kind[1] == "box" and not witness:
            return self._box(kind[0], v, {})
        if kind[0].startswith("stability"):
            return self._unstable(kind[0], ZERO if kind[1] == "box" else v, point)
        load = stiffness(witness["load"].values()) if witness and witness["load"] else None
        return self._statement(kind, v, interval, whole, load, point, {})

    def _statement(
        self, kind: Kind, v: Fraction, interval: Any, whole: bool, load: Poly | None, point: Point, extra: Ranges
    ) -> str:
        """By polynomials where there are only those and at most two roots, else on cells."""
        box, friction = self.spec["uncertainty"]["box"], kind[0] == "friction"
        family = {k: part for k, part in ranges(self.spec, ALL[1:]).items() if k not in point} | extra
        if kind[0] in ("eq9", "eq18") and load is None and box and box["stiffness"][1] > 0:
            family["edge", 0] = ZERO, Fraction(1)
        exact = not (family or self.sampled or self.table["points"])
        if exact and any(key[0] != "plant" for key in point):
            self = Prover({"spec": self.spec, "bandwidth": {"proven": self.omega_b}}, self.deadline, self.controller)
            self.exact = Joint(self.spec, self.controller, point)
        for end in (end for end in interval if whole and end in WHOLE and (friction or kind in SIGNED)):
            at = Cell(ZERO, ZERO, end == inf, family)
            j, name = self.exact if exact else self._joint(at, point), "Z at infinity" if end else "Z(0)"
            if cover([at], lambda cell, j=j: port_ends(friction, j, cell, load), self.deadline):  # type: ignore[misc]
                return f": {name} is not finite and {'>' if friction else '>='} 0"
        parts = list(STATEMENTS[kind](self.exact, v, load)) if exact else []
        if exact and all(sum(map(bool, part.terms)) < 3 for part in parts):
            return self._exactly(parts, interval)

        def on(cell: Cell) -> Iterator[Any]:
            key = (*cell.key, *point.items())
            if key not in self.views:
                self.views = self.views if len(self.views) < VIEWS else {}
                self.views[key] = self._joint(cell, point).over_locked(cell)
            return STATEMENTS[kind](self.views[key], v, load)

        return cover(roots(interval, [ω for ω, _ in self.table["points"]], family), on, self.deadline)

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

    def _joint(self, cell: Cell, point: Point) -> Joint:
        return Joint(self.spec, self.controller, {**point, **{key: cell.symbol(key) for key in cell.ranges}}, cell)

    def _unstable(self, name: str, v: Fraction, point: Point) -> str:
        """Why the roots at one point are not all at Re s < −v; empty if they are."""
        if self.sampled:
            return self._turns(name, point)
        j = Joint(self.spec, self.controller, point)
        f = add(*j.loop(name))
        if not decays_faster(f, v, self.deadline):
            return ": a root does not decay at the stated rate"
        lost = name == "stability-locked" and len(f.c) < len(j.E.c)  # a lost degree is a root at infinity
        return ": 1 + HCF vanishes at infinity" if lost else ""

    def _reference(self, name: str, point: Point, family: Ranges) -> Poly:
        """`(s + a)^n`, a a power of two, n the undelayed part's degree, above that of what the hold multiplies."""
        undelayed, delayed = self.exact.loop(name)
        f = undelayed + delayed
        p, k = undelayed if self.sampled else f, 0
        demand(bool(p) and bool(f) and f.c[0] != 0, "a root at zero", FALSE)
        k = (f.c[0].bit_length() - f.d.bit_length() - p.c[-1].bit_length() + p.d.bit_length()) // max(len(p.c) - 1, 1)
        reference: Poly = reduce(mul, [Poly.of(Fraction(2) ** k, 1)] * (len(p.c) - 1), ONE)
        if self.sampled:
            far = Cell(ZERO, ZERO, True, family)
            other = Prover({"spec": {**self.spec, "sampling": None}, "bandwidth": {"proven": ZERO}}, 0, self.controller)
            slower = far.axis(other._joint(far, point).loop(name)[1]) * far.axis(reference).inverse()
            demand(slower.bounded(), "the loop at infinity depends on the hold", UNDECIDED)
        return reference

    def _turns(self, name: str, point: Point) -> str:
        """Quarter turns of f/reference from ω = 0 to ∞: as many half-planes as there are cells, neighbours adjacent."""
        reference, path = self._reference(name, point, {}), list[int]()

        def on(cell: Cell) -> Iterator[Any]:
            z = cell.axis(add(*self._joint(cell, point).loop(name))) * cell.axis(reference).inverse()
            signs = [f.sign() == 1 for f in (z.p, z.q, -z.p, -z.q)]
            if cell.ends:  # real there
                signs = [sign and k % 2 == 0 and z.p.m == 0 for k, sign in enumerate(signs)]
            steps = (path[-1], path[-1] + 1, path[-1] - 1) if path else (0, 2)
            found = next((step for step in steps if signs[step % 4]), None)
            if found is None:
                raise UnresolvedError
            path.append(found)
            yield from ()

        cover(roots(WHOLE, [], {}), on, self.deadline)
        return f": {abs(path[-1] - path[0]) // 2} roots with Re s > 0" if path[-1] != path[0] else ""

    def _box(self, name: str, v: Fraction, extra: Ranges) -> str:
        """No root on the axis for any parameters in the box scaled by v: none crosses from the stable nominal."""
        if fault := self._unstable(name, ZERO, {}):
            return fault
        family = {**(ranges(self.spec, ALL if name == "stability-free" else ALL[2:], v) if v else {}), **extra}
        reference = self._reference(name, {}, family)

        def on(cell: Cell) -> Iterator[Any]:
            yield cell.axis(add(*self._joint(cell, {}).loop(name))) * cell.axis(reference).inverse()

        return cover(roots(WHOLE, [], family), on, self.deadline, ALL[2:])

    def _tolerance(self, v: Fraction) -> str:
        """Every required claim at its required level, for every coefficient c(1 + e), |e| ≤ v."""
        given = self.controller["Q" if self.controller["type"] == "dob" else "C"]
        extra = {(part, k): (-v, v) for part in ("denominator", "numerator") for k, c in enumerate(given[part]) if c}
        for name, form in required_kinds(self.spec):
            _, interval, level = asked(self.spec, self.omega_b, (name, form))
            if name == "tolerance":
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
        other = Prover({"spec": self.spec, "bandwidth": {"proven": self.omega_b}}, self.deadline, controller)
        (_, interval, level), ω = asked(self.spec, self.omega_b, kind), witness["omega"]
        where = interval if ω is None else (ω, ω)
        return other.fault(kind, level or ZERO, where, interval == WHOLE, witness)


PLACES = {
    "load": "plant",
    "impedance": "impedance",
    "actuator": "actuator",
}  # of a witness: its section
