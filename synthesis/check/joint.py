"""The joint a certificate speaks about, as polynomials in s that every statement is made of."""

from collections.abc import Iterable
from fractions import Fraction
from typing import Any

from .outcome import MISMATCH, demand
from .polynomials import ONE, ZERO, Poly, decays_faster, norm2

Rational = tuple[Poly, Poly]  # numerator, denominator


class Joint:
    """`Z(g) = (E g + M)/locked`, `1 − Q̃ = E/locked`; with an ideal actuator `1 − Q_i = E_i/D_i`, `U = U_n/D_i`.
    E g + M is the characteristic polynomial in free motion, locked the one against a wall; a filter of its own on θ
    makes the feedback C F_θ."""

    def __init__(self, certificate: dict[str, Any], deadline: float) -> None:
        spec = self.spec = certificate["spec"]
        self.deadline = deadline
        self.nominal, self.desired = stiffness(spec["plant"].values()), stiffness(spec["impedance"].values())
        self.n_H, self.n_Z, self.d = _actuator(spec["actuator"])
        n_C, d_C = _compensator(certificate["controller"], spec["controller"])
        filters = spec["controller"]["filters"] or {"force": None, "position": None, "derivative": None}
        own, d_F, d_Fd = filters["position"], _lag(filters["force"]), _lag(filters["derivative"])
        d_θ = _lag(None if own == "none" else own)
        direct = d_C * d_F * d_θ
        feedback = n_C * d_F if own is not None else n_C
        self.E_i = direct * d_Fd
        self.U_n = feedback * d_Fd * self.desired - direct * (self.nominal - self.desired)
        self.D_i = d_Fd * d_θ * (d_C * d_F + n_C)
        self.E = self.d * self.E_i
        self.M = self.n_Z * self.E_i + self.n_H * self.U_n
        self.locked = d_Fd * d_θ * (self.d * d_C * d_F + self.n_H * n_C)
        self.box, weight = spec["uncertainty"]["box"], spec["uncertainty"]["weight"]
        # Corners of the rectangle that g(jω) moves in; its edge v = B_lo ω, a segment of loads, if K_hi > 0.
        self.corners: list[Poly] = [self.nominal]
        self.edge: list[Poly] = []
        if self.box:
            demand(contains(spec, spec["plant"]), "spec.uncertainty.box: does not contain the nominal load")
            (I_lo, I_hi), B, (K_lo, K_hi) = self.box.values()
            corners = [stiffness((I, b, K)) for b in B for I, K in ((I_hi, K_lo), (I_lo, K_hi))]  # noqa: E741
            self.corners, self.edge = list(dict.fromkeys(corners)), corners[:2] if K_hi > 0 else []
        n_w, d_w = _rational(weight) if weight else (ZERO, ONE)
        usable = len(n_w.c) <= len(d_w.c) and decays_faster(d_w, Fraction(0), deadline)
        demand(usable, "spec.uncertainty.weight: must be stable and proper")
        self.weight = norm2(n_w), norm2(d_w)  # |W_w|², polynomials in x

    def free(self, g: Poly) -> Poly:
        """`free` for the dynamic stiffness of a load: numerator of Z over `locked`."""
        return self.E * g + self.M

    def loads(self, load: Poly | None) -> list[Poly]:
        """The one load of a witness, or those that decide a condition affine or convex in the load."""
        return self.corners if load is None else [load]


def contains(spec: dict[str, Any], load: dict[str, Fraction]) -> bool:
    """Whether the box contains a load; without one, whether it is the nominal load."""
    box = spec["uncertainty"]["box"] or {key: (part, part) for key, part in spec["plant"].items()}
    return all(lo <= load[key] <= hi for key, (lo, hi) in box.items())


def stiffness(load: Iterable[Fraction]) -> Poly:
    """`g = I s² + B s + K`, from I, B, K."""
    return Poly.of(*reversed(tuple(load)))


def _lag(corner: Fraction | None) -> Poly:
    """Denominator of `1/(1 + s/corner)`; 1 without a filter."""
    return ONE if corner is None else Poly.of(1, 1 / corner)


def _actuator(section: dict[str, Any]) -> tuple[Poly, Poly, Poly]:
    """`n_H, n_Z, d`: torque transfer and output impedance of (13)-(15) over one denominator."""
    if section["type"] == "ideal":
        return ONE, ZERO, ONE
    loop, K_sp = section["torque_loop"], Poly.of(section["spring_stiffness"])
    lag = _lag(loop["derivative_corner"])
    C_t = Poly.of(loop["kp"]) * lag + Poly.of(0, loop["kd"])
    motor = Poly.of(0, section["motor_damping"], section["motor_inertia"]) * lag
    return K_sp * (C_t + Poly.of(loop["feedforward"]) * lag), K_sp * motor, motor + K_sp * (lag + C_t)


def _compensator(given: dict[str, Any], asked: dict[str, Any]) -> Rational:
    """`n_C, d_C`, after checking that the controller is one the specification allows."""
    demand(given["type"] == asked["type"], "controller.type: is not the specification's", MISMATCH)
    name = "Q" if given["type"] == "dob" else "C"
    (n, d), C = _rational(given[name]), _rational(given["C"])
    order, place = max(len(n.c), len(d.c)) - 1, f"controller.{name}"
    if name == "Q":
        demand(len(n.c) <= len(d.c) and n != d, "controller.Q: must be proper and not 1")
        trimmed = all(len(c) == 1 or c[-1] != 0 for c in given["C"].values())
        demand(trimmed and _monic(C) == _monic((n, d - n)), "controller.C: is not Q/(1-Q)", MISMATCH)
    if asked["coefficients"] is not None:
        same = _monic((n, d)) == _monic(_rational(asked["coefficients"]))
        demand(same, f"{place}: is not the one the specification gives", MISMATCH)
    demand(asked["order"] is None or order <= asked["order"], f"{place}: is above the specification's order", MISMATCH)
    demand(asked["form"] is None or (len(n.c) <= 1 and len(d.c) == 3), f"{place}: is not of the form (23)", MISMATCH)
    return C


def _rational(section: dict[str, Any]) -> Rational:
    return Poly.of(*section["numerator"]), Poly.of(*section["denominator"])


def _monic(p: Rational) -> Rational:
    """The same two polynomials up to one common factor: nothing is cancelled."""
    scale = Poly.of(Fraction(p[1].d, p[1].c[-1]))
    return p[0] * scale, p[1] * scale
