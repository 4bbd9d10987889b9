"""How each claim is decided by polynomials: Routh, positivity; at a value, for all uncertainty or at one point."""

from __future__ import annotations

import itertools
from decimal import Decimal
from fractions import Fraction
from math import inf
from operator import add
from typing import Any

from .joint import Joint, Point, ranges, stiffness
from .outcome import CheckError
from .polynomials import Poly, X, decays_faster, limit, norm2, on_axis, product
from .positivity import Inequality, counterexample, one_is_positive, square
from .requirements import ALL, PLACES, SIGNED, WHOLE, Kind, Part
from .statements import EDGE, IDEAL, STATEMENTS, Limit, port_ends

NOUGHT = Fraction(0)


class Prover:
    """One certificate: its specification and its controller."""

    def __init__(self, certificate: dict[str, Any], deadline: float) -> None:
        self.certificate, self.spec, self.deadline = certificate, certificate["spec"], deadline
        self.nominal = self.joint({})

    def joint(self, point: Point) -> Joint:
        """The joint where parameters have these values."""
        return Joint(self.spec, self.certificate["controller"], point)

    def fault(self, kind: Kind, v: Fraction, interval: Any, whole: bool, witness: Part | None = None) -> str | None:
        """Where a statement fails at v, for all uncertainty or at the witness; empty: it is proven; None: undecided."""
        (name, form), (point, load) = kind, self.place(witness)
        if kind in IDEAL and (fault := Prover(self.ideal(), self.deadline)._unstable(IDEAL[kind], NOUGHT, point)):
            return ": behind an ideal actuator" + fault[1:]
        if self.spec["sampling"] or form == "coefficients":
            return None
        if name.startswith("stability"):
            fault = self._unstable(name, NOUGHT if form == "box" else v, point)
            return None if form == "box" and not witness and not fault and not self._excluded(name, v) else fault
        sections, given = STATEMENTS[kind][1], self.spec["uncertainty"]
        varied = any(key not in point for key in ranges(self.spec, [at for at in ALL[1:] if at in sections]))
        if varied or given["table"] or (EDGE in sections and given["box"] and given["weight"]):
            return None
        fault = self._statement(kind, v, interval, whole, load, point)
        edge = EDGE in sections and load is None and self.nominal.edge
        return None if edge and not fault and not self._along(kind, v, interval, point) else fault

    def ideal(self) -> Part:
        """The same certificate for an ideal actuator, with nothing sampled."""
        spec = self.spec | {"actuator": {"type": "ideal"}, "sampling": None}
        return self.certificate | {"spec": spec | {"uncertainty": spec["uncertainty"] | {"actuator": None}}}

    def place(self, witness: Part | None) -> tuple[Point, Poly | None]:
        """A witness's parameters, and the dynamic stiffness of its load."""
        given = [(section, (witness or {}).get(name) or {}) for name, section in PLACES.items()]
        load = stiffness(witness["load"].values()) if witness and witness["load"] else None
        return {(at, key): v for at, parts in given for key, v in parts.items()}, load

    def _statement(self, kind: Kind, v: Fraction, interval: Any, whole: bool, load: Poly | None, point: Point) -> str:
        j = self.joint(point)
        for end, name, text in self.ends(kind, interval, whole):
            far = end == inf
            parts = port_ends(name, far, j, self._limits(name, far, j), limit(*j.disc, far), load)
            if self._exactly([*parts], (NOUGHT, NOUGHT)):
                return text
        return self._exactly([*STATEMENTS[kind][0](j, v, load)], interval)

    def _limits(self, name: str, far: bool, j: Joint) -> Limit:
        denominator = add(*self.nominal.loop(name, self.nominal.nominal))
        return lambda part, power: limit(add(*part(j)), denominator * power, far)

    def ends(self, kind: Kind, interval: Any, whole: bool) -> list[tuple[Any, str, str]]:
        """Ends of ω at which the port is looked at apart, by which function, and what is said if it is wrong there."""
        friction = kind[0] == "friction"
        name, above = ("stability-free", ">") if friction else ("stability-locked", ">=")
        return [
            (end, name, f": {'Z at infinity' if end else 'Z(0)'} is not finite and {above} 0")
            for end in interval
            if whole and end in WHOLE and (friction or kind in SIGNED)
        ]

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
        j = self.joint(point)
        undelayed, delayed = j.loop(name)
        f = undelayed + delayed
        if not decays_faster(f, v, self.deadline):
            return ": a root does not decay at the stated rate"
        end = limit(f, undelayed, far=True)  # 1 + HCF, or 1 + HA/(g + Z_a)
        return ": any lag of the actuator makes it unstable" if end is not None and not (end and end.c[0] > 0) else ""

    def _along(self, kind: Kind, v: Fraction, interval: Any, point: Point) -> bool:
        """Whether `vW|a| < |b|` is shown for loads on the edge, too: a quadratic in the place t on it, with ends > 0,
        `b_0 (1−t)² + 2 b_1 t (1−t) + b_2 t²`, which is positive where b_1 > 0, and where b_1² < b_0 b_2."""
        j, half, slacks = self.joint(point), Poly.of(Fraction(1, 2)), list[Poly]()
        first, last = j.edge
        for g in (first, (first + last) * half, last):
            (part,) = STATEMENTS[kind][0](j, v, g)
            if part.terms[0]:  # |p|
                return False
            slacks.append(part.bound - part.terms[1])
        b_0, middle, b_2 = slacks
        *ends, b_1 = Inequality([b_0, b_2], middle + middle - (b_0 + b_2) * half, strict=False).rows()
        if not all((interval[0] or row[0] > 0) and (interval[1] < inf or row[-1] > 0) for row in ends):
            return False
        rest = [u - w for u, w in zip(product(*ends), product(b_1, b_1), strict=True)]
        lo, hi = map(square, interval)
        return one_is_positive([b_1, rest], lo, hi, self.deadline)

    def _excluded(self, name: str, v: Fraction) -> bool:
        """Whether E g + M is shown to have no root on [0, ∞] for any load of the box scaled by v, if only loads vary.

        0 and ∞: one sign at all corners. Between: −M/E is on one of the four sides of the rectangle of g."""
        j, varied = self.nominal, ranges(self.spec, ALL if name == "stability-free" else ALL[2:], v)
        if any(section != "plant" for section, _ in varied):
            return False
        if not varied:
            return True
        box = [varied.get(("plant", key), (n, n)) for key, n in self.spec["plant"].items()]
        corners = [j.free(stiffness(load)) for load in itertools.product(*box)]
        signs = {(len(f.c), f.c[0] > 0, f.c[-1] > 0) if f and f.c[0] else () for f in corners}
        if len(signs) > 1 or () in signs:
            return False
        E2, (re, im) = norm2(j.E), on_axis(j.M, j.E)
        (I_lo, I_hi), (B_lo, B_hi), (K_lo, K_hi) = box
        right, left = (re + E2 * (Poly.of(at) - X * Poly.of(inertia)) for at, inertia in ((K_lo, I_hi), (K_hi, I_lo)))
        above, below = (im + E2 * Poly.of(damping) for damping in (B_lo, B_hi))
        sides = (side.c for side in (right, -left, above, -below) if side)
        rows = [c[next(k for k, a in enumerate(c) if a) :] for c in sides]  # over x^k > 0
        return one_is_positive(rows, (0, 1), (1, 0), self.deadline)
