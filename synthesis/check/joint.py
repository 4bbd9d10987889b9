"""The joint a certificate speaks about: the quantities that every statement is made of, as polynomials."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from typing import Any

from .outcome import MISMATCH, demand
from .polynomials import ONE, ZERO, Poly, decays_faster, norm2
from .positivity import Inequality
from .reader import FORMS

Section = dict[str, Any]  # of the certificate
Point = dict[tuple[str, Any], Fraction]  # parameters, (section, key), at values
Ranges = dict[tuple[str, Any], tuple[Fraction, Fraction]]  # parameters that vary
Parts = Iterator[Inequality]  # to be proven
Value = Any  # a Poly in s, or an Axis on a cell
Real = Any  # a Poly in x = ω², or a Form on a cell
S = Poly.of(0, 1)


class Joint:
    """`Z(g) = (E g + M)/locked`, `1 − Q̃ = E/locked`; with an ideal actuator `1 − Q_i = E_i/D_i`, `U = U_n/D_i`.
    E g + M is the characteristic function in free motion, locked the one against a wall; a filter of its own on θ
    makes the feedback C F_θ. The hold multiplies `rest` and `driven`; parameters are affine in all of them."""

    def __init__(self, spec: Section, controller: Section, point: Point) -> None:
        self.spec, self.nominal = spec, stiffness(spec["plant"].values())
        self.load, self.desired = _stiffness_at(spec, point, "plant"), _stiffness_at(spec, point, "impedance")
        self.n_H, self.n_Z, self.d = _actuator(spec, point)
        n_C, d_C = rational(controller["C"])
        filters = spec["controller"]["filters"] or {"force": None, "position": None, "derivative": None}
        own, d_F, d_Fd = filters["position"], _lag(filters["force"]), _lag(filters["derivative"])
        d_θ = _lag(None if own == "none" else own)
        direct, feedback = d_C * (d_F * d_θ), n_C * d_F if own is not None else n_C
        self.command, self.rest = n_C * (self.d * d_Fd * d_θ), n_C * (self.n_H * (d_Fd * d_θ))
        self.E_i, self.D_i = direct * d_Fd, direct * d_Fd + n_C * (d_Fd * d_θ)
        self.U_n = feedback * d_Fd * self.desired - direct * (self.nominal - self.desired)
        self.E, self.driven, self.carried = self.d * self.E_i, self.n_H * self.U_n, self.n_Z * self.E_i
        self.M, self.locked = self.carried + self.driven, self.E + self.rest
        self.box, weight = spec["uncertainty"]["box"], spec["uncertainty"]["weight"]
        # Corners of the rectangle that g(jω) moves in, its edge v = B_lo ω, and a load there that is a parameter.
        self.corners, self.edge, self.place = [self.nominal], list[Poly](), list[Poly]()
        if self.box:
            (I_lo, I_hi), B, (K_lo, K_hi) = self.box.values()
            corners = [stiffness((I, b, K)) for b in B for I, K in ((I_hi, K_lo), (I_lo, K_hi))]  # noqa: E741
            self.corners, self.edge = list(dict.fromkeys(corners)), corners[:2] if K_hi else []
        # The disc on top of every load: |Δ|² ≤ V² = gap/size.
        n_w, d_w = rational(weight) if weight else (ZERO, ONE)
        self.disc: tuple[Real, Real] = (norm2(n_w), norm2(d_w))

    def free(self, g: Value) -> Value:
        """`free` for the dynamic stiffness of a load: numerator of Z over `locked`."""
        return self.E * g + self.M

    def loads(self, load: Poly | None) -> list[Poly]:
        """The one load of a witness, or those that decide a condition affine or convex in the load."""
        return self.corners if load is None else [load]

    def ratios(self, load: Poly | None, edge: bool = False) -> list[tuple[Real, Real]]:
        """`|ĝ − g|²` and `|g|²` for every load that can decide; on the edge where it is a parameter."""
        loads = [*self.loads(load), *(self.place if edge and load is None else [])]
        return [(norm2(self.nominal - g), norm2(g)) for g in loads]

    def loop(self, name: str, g: Value | None = None) -> tuple[Value, Value]:
        """The characteristic function, of a load g, as two summands, without and with the hold."""
        free = self.E * (self.load if g is None else g) + self.carried, self.driven
        return (self.E, self.rest) if name == "stability-locked" else free

    def weighed(self, w: Real, a: Real, b: Real, c: Real, size: Real) -> Parts:
        """`√w (√a + √b + √c) < √(c size)`, w < size; squared: `2w √(ab) + 2c √(w size) < c (size + w) − w (a + b)`."""
        left, four = c * (size + w) - w * (a + b), Poly.of(4)
        yield Inequality([], left, over=c * size)
        yield Inequality([four * w * w * a * b, four * c * c * w * size], left * left)

    def both(self, a2: Real, b2: Real, p2: Real, load: Poly | None) -> Parts:
        """`|p| + W |a| < |b|` where a box and a disc make W: in `enclosure`, it has three roots."""
        raise NotImplementedError


def ranges(spec: Section, sections: Any, v: Fraction = Fraction(1)) -> Ranges:
    """The parameters a specification gives a range, scaled by v about the nominal."""
    given = spec["uncertainty"]
    boxes = {"plant": given["box"], "impedance": spec["impedance"], "actuator": given["actuator"]}
    found = {(name, key): part for name in sections for key, part in (boxes[name] or {}).items()}
    return {
        key: (n - v * (n - part[0]), n + v * (part[1] - n))
        for key, part in found.items()
        if isinstance(part, tuple) and part[0] < part[1]
        for n in [nominal(spec, *key)]
    }


def nominal(spec: Section, section: str, key: str) -> Fraction:
    """A parameter's nominal value: of an interval its midpoint."""
    part = spec[section][key]
    return (part[0] + part[1]) / 2 if isinstance(part, tuple) else part  # type: ignore[no-any-return]


def stiffness(load: Any) -> Poly:
    """`g = I s² + B s + K`, from I, B, K."""
    return Poly.of(*reversed(tuple(load)))


def rational(section: Section) -> tuple[Poly, Poly]:
    """Numerator, denominator."""
    return Poly.of(*section["numerator"]), Poly.of(*section["denominator"])


def _value(spec: Section, point: Point, section: str, key: str) -> Poly:
    return Poly.of(point[section, key] if (section, key) in point else nominal(spec, section, key))


def _stiffness_at(spec: Section, point: Point, section: str) -> Poly:
    powers = ("inertia", S * S), ("damping", S), ("stiffness", ONE)
    return sum((_value(spec, point, section, key) * power for key, power in powers), ZERO)


def _lag(corner: Fraction | None) -> Poly:
    """Denominator of `1/(1 + s/corner)`; 1 without a filter."""
    return ONE if corner is None else Poly.of(1, 1 / corner)


def _actuator(spec: Section, point: Point) -> tuple[Value, Value, Value]:
    """`n_H, n_Z, d`: torque transfer and output impedance over one denominator, from (13)-(15) or as given."""
    section = spec["actuator"]
    if section["type"] == "ideal":
        return ONE, ZERO, ONE
    if section["type"] == "two-port":
        (n_H, d_H), (n_Z, d_Z) = rational(section["transfer"]), rational(section["impedance"])
        return (n_H, n_Z, d_H) if d_H == d_Z else (n_H * d_Z, n_Z * d_H, d_H * d_Z)
    J, b, K_sp, loop = (*(_value(spec, point, "actuator", key) for key in MOTOR), section["torque_loop"])
    lag = _lag(loop["derivative_corner"])
    C_t, motor = Poly.of(loop["kp"]) * lag + Poly.of(0, loop["kd"]), J * (S * S * lag) + b * (S * lag)
    return K_sp * (C_t + Poly.of(loop["feedforward"]) * lag), K_sp * motor, motor + K_sp * (lag + C_t)


MOTOR = "motor_inertia", "motor_damping", "spring_stiffness"


def validate(certificate: Section, deadline: float) -> None:
    """Check that the specification makes sense, and that it allows the controller; or CheckError."""
    spec, given, asked = certificate["spec"], certificate["controller"], certificate["spec"]["controller"]
    for name, section in (("box", "plant"), ("actuator", "actuator")):
        for key, (lo, hi) in (spec["uncertainty"][name] or {}).items():
            inside = key in spec[section] and lo <= spec[section][key] <= hi
            demand(inside, f"spec.uncertainty.{name}: does not contain the nominal {key}")
    weight, actuator = spec["uncertainty"]["weight"], spec["actuator"]
    for key in ("transfer", "impedance") if actuator["type"] == "two-port" else ():
        n, d = rational(actuator[key])
        demand(len(n.c) <= len(d.c), f"spec.actuator.{key}: not proper")
    n, d = rational(weight) if weight else (ZERO, ONE)
    usable = len(n.c) <= len(d.c) and decays_faster(d, Fraction(0), deadline)
    demand(usable, "spec.uncertainty.weight: must be stable and proper")
    demand(given["type"] == asked["type"], "controller.type: is not the specification's", MISMATCH)
    name = "Q" if given["type"] == "dob" else "C"
    (n, d), C = rational(given[name]), rational(given["C"])
    order, place = max(len(n.c), len(d.c)) - 1, f"controller.{name}"
    if name == "Q":
        demand(len(n.c) <= len(d.c) and n != d, "controller.Q: must be proper and not 1")
        trimmed = all(len(c) == 1 or c[-1] != 0 for c in given["C"].values())
        demand(trimmed and _monic(C) == _monic((n, d - n)), "controller.C: is not Q/(1-Q)", MISMATCH)
    same = asked["coefficients"] is None or _monic((n, d)) == _monic(rational(asked["coefficients"]))
    demand(same, f"{place}: is not the one the specification gives", MISMATCH)
    demand(asked["order"] is None or order <= asked["order"], f"{place}: is above the specification's order", MISMATCH)
    zeros, least, most, integral = FORMS.get(asked["form"], (len(n.c), 0, len(d.c), False))
    fits = len(n.c) - 1 <= zeros and least <= len(d.c) - 1 <= most and (not integral or d.c[0] == 0)
    demand(fits, f"{place}: is not of the form {asked['form']}", MISMATCH)
    demand(len(C[0].c) <= len(C[1].c), "controller.C: must be proper")


def _monic(p: tuple[Poly, Poly]) -> tuple[Poly, Poly]:
    """The same two polynomials up to one common factor: nothing is cancelled."""
    scale = Poly.of(Fraction(p[1].d, p[1].c[-1]))
    return p[0] * scale, p[1] * scale
