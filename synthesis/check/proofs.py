"""How each claim is decided: Routh, polynomials, or cells; at a value, for everything in the ranges or at one point."""

from __future__ import annotations

from collections.abc import Iterator
from decimal import Decimal
from fractions import Fraction
from itertools import chain
from math import inf
from typing import Any

from .cells import Cell, Ranges, bounded, cover, roots
from .forms import Axis, UnresolvedError
from .joint import Joint, Point, nominal, ranges, stiffness
from .outcome import FALSE, UNDECIDED, CheckError, demand
from .polynomials import ONE, Poly, decays_faster
from .positivity import counterexample, square
from .requirements import SIGNED, WHOLE, Kind, asked, required_kinds
from .statements import STATEMENTS, port_ends

VIEWS = 4096  # joints on a cell that are kept


class Prover:
    """One certificate: its specification and a controller, the certificate's or a witness of its sensitivity."""

    def __init__(self, certificate: dict[str, Any], deadline: float, controller: dict[str, Any] | None = None) -> None:
        self.spec, self.deadline, self.omega_b = certificate["spec"], deadline, certificate["bandwidth"]["proven"]
        self.controller = controller or certificate["controller"]
        uncertainty, self.sampled = self.spec["uncertainty"], self.spec["sampling"] is not None
        ranged = bool(ranges(self.spec, "impedance", "actuator"))
        self.polynomials = not (self.sampled or ranged or uncertainty["table"])
        self.exact = Joint(self.spec, self.controller, {})
        self.views: dict[Any, Joint] = {}

    def fault(self, kind: Kind, v: Fraction, interval: Any, whole: bool, witness: dict[str, Any] | None = None) -> str:
        """Where the statement fails at v, for all uncertainty or at the witness; empty if it is proven."""
        point, load = _point(witness or {}), witness and witness["load"]
        if kind[1] == "coefficients":
            return self._perturbed(v, witness) if witness else self._tolerance(v)
        if kind[0].startswith("stability"):
            if kind[1] == "box" and not witness:
                return self._box(kind[0], v, {})
            at = {**point, **{("plant", key): Poly.of(part) for key, part in (load or {}).items()}}
            return self._unstable(kind[0], Fraction(0) if kind[1] == "box" else v, at)
        return self._statement(kind, v, interval, whole, load and stiffness(load.values()), point, {})

    def _statement(
        self, kind: Kind, v: Fraction, interval: Any, whole: bool, load: Poly | None, point: Point, extra: Ranges
    ) -> str:
        ends = [end for end in interval if end in WHOLE] if whole and (kind in SIGNED or kind[0] == "friction") else []
        box, family = self.spec["uncertainty"]["box"], {**ranges(self.spec, "impedance", "actuator"), **extra}
        family = {key: part for key, part in family.items() if key not in point}
        if kind[0] in ("eq9", "eq18") and load is None and box and box["stiffness"][1] > 0:
            family["edge", 0] = (Fraction(0), Fraction(1))
        simple = self.polynomials and not family
        parts = list(STATEMENTS[kind](self.exact, v, load)) if simple else []
        for end in ends:
            at = Cell(Fraction(0), Fraction(0), end == inf, family)
            j = self.exact if simple else self._joint(at, point)
            if text := cover([at], lambda cell, j=j: port_ends(kind[0] == "friction", j, cell, load), self.deadline):
                return text if text[0] == ":" else f": {'Z at infinity' if end else 'Z(0)'} is not finite and >= 0"
        if simple and all(sum(term.c != () for term in part.terms) < 3 for part in parts):
            return self._exactly(parts, interval)
        table = self.spec["uncertainty"]["table"] or {"points": []}
        breaks = [ω for ω, _ in table["points"]]

        def on(cell: Cell) -> Iterator[Any]:
            return STATEMENTS[kind](self._view(cell, point), v, load)

        return cover(roots(interval, breaks, family), on, self.deadline)

    def _exactly(self, parts: list[Any], interval: Any) -> str:
        undecided, (lo, hi) = None, map(square, interval)
        for part in parts:
            try:
                at = counterexample(part, lo, hi, self.deadline)
            except CheckError as error:
                undecided = error
            else:
                if at is not None:
                    frequency = "inf" if at[1] == 0 else format((Decimal(at[0]) / Decimal(at[1])).sqrt(), ".6g")
                    return f" at ω = {frequency} rad/s"
        if undecided:
            raise undecided
        return ""

    def _joint(self, cell: Cell, point: Point) -> Joint:
        symbols = {key: cell.symbol(key) for key in cell.ranges}
        return Joint(self.spec, self.controller, {**point, **symbols}, cell)

    def _view(self, cell: Cell, point: Point) -> Joint:
        """The joint on a cell over `locked`, kept for the next claim."""
        key = (*cell.key(), *point.items())
        if key not in self.views:
            if len(self.views) > VIEWS:
                self.views.clear()
            self.views[key] = self._joint(cell, point).over_locked()
        return self.views[key]

    def _unstable(self, name: str, v: Fraction, point: Point) -> str:
        """Why the roots at one point are not all at Re s < −v; empty if they are."""
        j = Joint(self.spec, self.controller, point)
        f = _characteristic(name, j)
        if self.sampled:
            return self._turns(name, point)
        if not decays_faster(f, v, self.deadline):
            return ": a root does not decay at the stated rate"
        lost = name == "stability-locked" and len(f.c) < len(j.E.c)  # a lost degree is a root at infinity
        return ": 1 + HCF vanishes at infinity" if lost else ""

    def _reference(self, name: str) -> Poly:
        """`(s + a)^n` of the degree n of the undelayed part, a power of two near the mean of its roots."""
        j = self.exact
        undelayed = j.E if name == "stability-locked" else j.E * j.load + (j.n_Z * j.E_i if self.sampled else j.M)
        if name == "stability-locked" and not self.sampled:
            undelayed = j.locked
        f, n = _characteristic(name, j), len(undelayed.c) - 1
        demand(n >= 0 and bool(f.c) and f.c[0] != 0, "a root at zero", FALSE)
        k = (f.c[0].bit_length() - undelayed.c[-1].bit_length() + undelayed.d.bit_length() - f.d.bit_length()) // max(n, 1)
        found = ONE
        for _ in range(n):
            found = found * Poly.of(Fraction(2) ** k, 1)
        return found

    def _retarded(self, name: str, reference: Poly, point: Point, family: Ranges) -> None:
        """Demand that what the hold multiplies does not grow faster than the reference: then hold · … → 0."""
        if self.sampled:
            far = Cell(Fraction(0), Fraction(0), True, family)
            symbols = {key: far.symbol(key) for key in family}
            j = Joint({**self.spec, "sampling": None}, self.controller, {**point, **symbols}, far)
            delayed = far.axis(j.rest if name == "stability-locked" else j.n_H * j.U_n)
            slower = bounded(delayed * far.axis(reference).inverse())
            demand(slower, "the loop at infinity depends on the hold", UNDECIDED)

    def _turns(self, name: str, point: Point) -> str:
        """Quarter turns of f/reference from ω = 0 to ∞: as many half-planes as there are cells, neighbours adjacent."""
        reference = self._reference(name)
        self._retarded(name, reference, point, {})
        path: list[int] = []

        def on(cell: Cell) -> Iterator[Any]:
            z = cell.axis(_characteristic(name, self._joint(cell, point))) * cell.axis(reference).inverse()
            signs = [z.p.sign() == 1, False, (-z.p).sign() == 1, False]
            if not cell.ends:
                signs[1::2] = z.q.sign() == 1, (-z.q).sign() == 1
            elif z.p.m:
                signs = []
            last = path[-1] if path else next((k for k in (0, 2) if any(signs) and signs[k]), 1)
            turn = next((k for k in (0, 1, -1) if signs and signs[(last + k) % 4]), None)
            if turn is None or (not path and last == 1):
                raise UnresolvedError(z.p, z.q)
            path.append(last + turn)
            yield from ()

        cover(roots(WHOLE, [], {}), on, self.deadline)
        return f": {abs(path[-1] - path[0]) // 2} roots on the right" if path[-1] != path[0] else ""

    def _box(self, name: str, v: Fraction, extra: Ranges) -> str:
        """No root on the axis for any parameters in the box scaled by v: none crosses from the stable nominal."""
        sections = ("plant", "impedance", "actuator") if name == "stability-free" else ("actuator",)
        family = {**(scaled(self.spec, v, *sections) if v else {}), **extra}
        reference = self._reference(name)
        self._retarded(name, reference, {}, family)

        def on(cell: Cell) -> Iterator[Axis]:
            yield cell.axis(_characteristic(name, self._joint(cell, {}))) * cell.axis(reference).inverse()

        return cover(roots(WHOLE, [], family), on, self.deadline, ("actuator",))

    def _tolerance(self, v: Fraction) -> str:
        """Every required claim at its required level, for every coefficient c(1 + e), |e| ≤ v."""
        given = self.controller["Q" if self.controller["type"] == "dob" else "C"]
        extra = {(part, k): (-v, v) for part in ("denominator", "numerator") for k, c in enumerate(given[part]) if c}
        for name, form in required_kinds(self.spec):
            _, interval, level = asked(self.spec, self.omega_b, (name, form))
            if name.startswith("stability"):
                text = self._box(name, Fraction(form == "box"), extra)
            elif name != "tolerance":
                text = self._statement((name, form), level or Fraction(0), interval, True, None, {}, extra)
            if text:
                return f": {name} {form}{text}"
        return ""

    def _perturbed(self, v: Fraction, witness: dict[str, Any]) -> str:
        """The required claim that fails for the witness's controller."""
        kind, given = tuple(witness["claim"]), witness["controller"]
        controller = {"type": self.controller["type"], "C": given}
        if self.controller["type"] == "dob":
            n, d = Poly.of(*given["numerator"]), Poly.of(*given["denominator"])
            rest = [Fraction(a, (d - n).d) for a in (d - n).c]
            controller = {**controller, "Q": given, "C": {"numerator": given["numerator"], "denominator": rest}}
        other = Prover({"spec": self.spec, "bandwidth": {"proven": self.omega_b}}, self.deadline, controller)
        _, interval, level = asked(self.spec, self.omega_b, kind)
        ω = witness["omega"]
        where = interval if ω is None or kind[0].startswith("stability") else (ω, ω)
        return other.fault(kind, level or Fraction(0), where, interval == WHOLE, witness)


def scaled(spec: dict[str, Any], v: Fraction, *sections: str) -> Ranges:
    """The box scaled by v about the nominal."""
    found = {}
    for (section, key), (lo, hi) in ranges(spec, *sections).items():
        n = nominal(spec, section, key)
        found[section, key] = n - v * (n - lo), n + v * (hi - n)
    return found


def _characteristic(name: str, j: Joint) -> Any:
    return j.locked if name == "stability-locked" else j.free(j.load)


def _point(witness: dict[str, Any]) -> dict[tuple[str, str], Poly]:
    """The parameters a witness gives."""
    sections = ("impedance", "actuator")
    return {(name, key): Poly.of(part) for name in sections for key, part in (witness.get(name) or {}).items()}
