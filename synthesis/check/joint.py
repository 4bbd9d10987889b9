"""The joint a certificate speaks about: the quantities that every statement is made of, as polynomials or on a cell."""

from collections.abc import Mapping
from fractions import Fraction
from functools import reduce
from operator import add
from typing import Any

from .cells import Cell, Ranges
from .outcome import MISMATCH, demand
from .polynomials import ONE, ZERO, Poly, decays_faster, norm2

Value = Any  # a Poly in s, or an Axis on a cell
Real = Any  # a Poly in x = ω², or a Form on a cell
Point = Mapping[tuple[str, Any], Any]  # (section, parameter) to its value where it is not the nominal one
S = Poly.of(0, 1)
SHAPE = "inertia", "damping", "stiffness"
MOTOR = "motor_inertia", "motor_damping", "spring_stiffness"


class Joint:
    """`Z(g) = (E g + M)/locked`, `1 − Q̃ = E/locked`; with an ideal actuator `1 − Q_i = E_i/D_i`, `U = U_n/D_i`.
    E g + M is the characteristic function in free motion, locked the one against a wall; a filter of its own on θ
    makes the feedback C F_θ. The hold multiplies n_H."""

    def __init__(self, spec: dict[str, Any], controller: dict[str, Any], point: Point, cell: Cell | None = None) -> None:
        self.spec, self.cell = spec, cell

        def shape(section: str) -> Value:
            I, B, K = (_value(spec, point, section, key) for key in SHAPE)  # noqa: E741
            return I * (S * S) + B * S + K

        self.nominal, self.load, self.desired = stiffness(spec["plant"].values()), shape("plant"), shape("impedance")
        self.n_H, self.n_Z, self.d = _actuator(spec, point)
        if cell and spec["sampling"]:
            self.n_H = self.n_H * cell.hold(*spec["sampling"].values())
        n_C, d_C = compensator(controller, point)
        filters = spec["controller"]["filters"] or {"force": None, "position": None, "derivative": None}
        own, d_F, d_Fd = filters["position"], _lag(filters["force"]), _lag(filters["derivative"])
        d_θ = _lag(None if own == "none" else own)
        direct = d_C * (d_F * d_θ)
        feedback = n_C * d_F if own is not None else n_C
        self.command = self.d * (d_Fd * d_θ) * n_C
        self.rest = self.n_H * (d_Fd * d_θ) * n_C
        self.E_i = direct * d_Fd
        self.U_n = feedback * d_Fd * self.desired - direct * (self.nominal - self.desired)
        self.D_i = self.E_i + n_C * (d_Fd * d_θ)
        self.E = self.d * self.E_i
        self.M = self.n_Z * self.E_i + self.n_H * self.U_n
        self.locked = self.E + self.rest
        self.box, weight, table = (spec["uncertainty"][key] for key in ("box", "weight", "table"))
        # Corners of the rectangle that g(jω) moves in; its edge v = B_lo ω, a segment of loads, if K_hi > 0.
        self.corners: list[Value] = [self.nominal]
        self.edge: Value = None
        if self.box:
            (I_lo, I_hi), B, (K_lo, K_hi) = self.box.values()
            corners = [stiffness((I, b, K)) for b in B for I, K in ((I_hi, K_lo), (I_lo, K_hi))]  # noqa: E741
            self.corners = list(dict.fromkeys(corners))
            if ("edge", 0) in point:
                self.edge = corners[0] + point["edge", 0] * (corners[1] - corners[0])
        # Sources of a disc, |Δ|² each as gap/size; together V² = gap/size.
        n_w, d_w = rational(weight) if weight else (ZERO, ONE)
        self.sources: list[tuple[Real, Real]] = [(norm2(n_w), norm2(d_w))] if weight else []
        self.disc: tuple[Real, Real] = (norm2(n_w), norm2(d_w))
        if cell and table:
            bound = _table(table["points"], cell)
            W_w = (cell.real(self.disc[0]) * cell.real(self.disc[1]).inverse()).at(0).root()
            V = (W_w + ONE) * (bound + ONE) - ONE
            self.sources.append((bound * bound, ONE))
            self.disc = V * V, ONE

    def free(self, g: Value) -> Value:
        """`free` for the dynamic stiffness of a load: numerator of Z over `locked`."""
        return self.E * g + self.M

    def loads(self, load: Poly | None) -> list[Value]:
        """The one load of a witness, or those that decide a condition affine or convex in the load."""
        return self.corners if load is None else [load]

    def over_locked(self) -> "Joint":
        """On a cell: everything over `locked`, which changes no statement and varies little on it."""
        assert self.cell is not None
        by = self.cell.axis(self.locked).inverse()
        self.D_i, self.E_i, self.U_n = self.D_i * by, self.E_i * by, self.U_n * by
        self.E, self.M, self.command, self.locked = ONE - self.rest * by, self.M * by, self.command * by, ONE
        return self


def ranges(spec: dict[str, Any], *sections: str) -> Ranges:
    """The intervals that a specification gives."""
    boxes = {"plant": spec["uncertainty"]["box"], "impedance": spec["impedance"], "actuator": spec["uncertainty"]["actuator"]}
    found = {(name, key): part for name in sections for key, part in (boxes[name] or {}).items()}
    return {key: part for key, part in found.items() if isinstance(part, tuple) and part[0] < part[1]}


def nominal(spec: dict[str, Any], section: str, key: str) -> Fraction:
    """A parameter's nominal value: of an interval its midpoint."""
    part = spec[section][key]
    return sum(part) / 2 if isinstance(part, tuple) else part  # type: ignore[no-any-return]


def stiffness(load: Any) -> Poly:
    """`g = I s² + B s + K`, from I, B, K."""
    return Poly.of(*reversed(tuple(load)))


def rational(section: dict[str, Any]) -> tuple[Poly, Poly]:
    """Numerator, denominator."""
    return Poly.of(*section["numerator"]), Poly.of(*section["denominator"])


def _value(spec: dict[str, Any], point: Point, section: str, key: str) -> Value:
    found = point.get((section, key))
    return Poly.of(nominal(spec, section, key)) if found is None else found


def _lag(corner: Fraction | None) -> Poly:
    """Denominator of `1/(1 + s/corner)`; 1 without a filter."""
    return ONE if corner is None else Poly.of(1, 1 / corner)


def _actuator(spec: dict[str, Any], point: Point) -> tuple[Value, Value, Value]:
    """`n_H, n_Z, d`: torque transfer and output impedance over one denominator, from (13)-(15) or as given."""
    section = spec["actuator"]
    if section["type"] == "ideal":
        return ONE, ZERO, ONE
    if section["type"] == "two-port":
        (n_H, d_H), (n_Z, d_Z) = rational(section["transfer"]), rational(section["impedance"])
        return (n_H, n_Z, d_H) if d_H == d_Z else (n_H * d_Z, n_Z * d_H, d_H * d_Z)
    loop, (J, b, K_sp) = section["torque_loop"], (_value(spec, point, "actuator", key) for key in MOTOR)
    lag = _lag(loop["derivative_corner"])
    C_t = Poly.of(loop["kp"]) * lag + Poly.of(0, loop["kd"])
    motor = J * (S * S * lag) + b * (S * lag)
    return K_sp * (C_t + Poly.of(loop["feedforward"]) * lag), K_sp * motor, motor + K_sp * (lag + C_t)


def compensator(given: dict[str, Any], point: Point) -> tuple[Value, Value]:
    """`n_C, d_C`; with every nonzero coefficient c of Q, or of C, as c(1 + e) if the point says so."""
    name = "Q" if given["type"] == "dob" and any(key[0] == "denominator" for key in point) else "C"
    n, d = (
        reduce(add, [Poly.of(*given[name][part]), *(
            point[part, k] * Poly.of(*[0] * k, c) for k, c in enumerate(given[name][part]) if (part, k) in point
        )])
        for part in ("numerator", "denominator")
    )
    return (n, d - n) if name == "Q" else (n, d)


def _table(points: list[list[Fraction]], cell: Cell) -> Real:
    """W_t, linear in ω between the points, which are ends of cells."""
    square = [ω * ω for ω, _ in points]
    k = len(points) if cell.far else sum(x <= cell.lo for x in square)
    if k in (0, len(points)):
        return cell.form(points[min(k, len(points) - 1)][1])
    (a, u), (b, v) = points[k - 1 : k + 1]
    return (cell.omega() - Poly.of(a)) * Poly.of((v - u) / (b - a)) + Poly.of(u)


def validate(certificate: dict[str, Any], deadline: float) -> None:
    """Check that the specification makes sense, and that it allows the controller; or CheckError."""
    spec, given = certificate["spec"], certificate["controller"]
    box, weight, part = (spec["uncertainty"][key] for key in ("box", "weight", "actuator"))
    for name, inner in (("box", box), ("actuator", part)):
        section = "plant" if name == "box" else "actuator"
        for key, (lo, hi) in (inner or {}).items():
            demand(key in spec[section], f"spec.uncertainty.{name}: not for this actuator")
            demand(lo <= spec[section][key] <= hi, f"spec.uncertainty.{name}: does not contain the nominal {key}")
    n_w, d_w = rational(weight) if weight else (ZERO, ONE)
    usable = len(n_w.c) <= len(d_w.c) and decays_faster(d_w, Fraction(0), deadline)
    demand(usable, "spec.uncertainty.weight: must be stable and proper")
    for key in ("transfer", "impedance") if spec["actuator"]["type"] == "two-port" else ():
        n, d = rational(spec["actuator"][key])
        demand(len(n.c) <= len(d.c), f"spec.actuator.{key}: must be proper")
    asked = spec["controller"]
    demand(given["type"] == asked["type"], "controller.type: is not the specification's", MISMATCH)
    name = "Q" if given["type"] == "dob" else "C"
    (n, d), C = rational(given[name]), rational(given["C"])
    order, place = max(len(n.c), len(d.c)) - 1, f"controller.{name}"
    if name == "Q":
        demand(len(n.c) <= len(d.c) and n != d, "controller.Q: must be proper and not 1")
        trimmed = all(len(c) == 1 or c[-1] != 0 for c in given["C"].values())
        demand(trimmed and _monic(C) == _monic((n, d - n)), "controller.C: is not Q/(1-Q)", MISMATCH)
    if asked["coefficients"] is not None:
        same = _monic((n, d)) == _monic(rational(asked["coefficients"]))
        demand(same, f"{place}: is not the one the specification gives", MISMATCH)
    demand(asked["order"] is None or order <= asked["order"], f"{place}: is above the specification's order", MISMATCH)
    demand(asked["form"] is None or (len(n.c) <= 1 and len(d.c) == 3), f"{place}: is not of the form (23)", MISMATCH)


def _monic(p: tuple[Poly, Poly]) -> tuple[Poly, Poly]:
    """The same two polynomials up to one common factor: nothing is cancelled."""
    scale = Poly.of(Fraction(p[1].d, p[1].c[-1]))
    return p[0] * scale, p[1] * scale
