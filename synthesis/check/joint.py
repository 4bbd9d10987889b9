"""The joint a certificate speaks about, as polynomials in s that every statement is made of."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from .hurwitz import decays_faster
from .outcome import Clock, MismatchError, UnreadableError
from .polynomials import ONE, ZERO, Poly, norm2

Load = tuple[Fraction, Fraction, Fraction]  # I, B, K
Box = tuple[tuple[Fraction, Fraction], ...]  # [lo, hi] of I, B, K


@dataclass(frozen=True)
class Joint:
    """`Z(g) = (E g + M)/locked`, `1 − Q̃ = E/locked`; with an ideal actuator `1 − Q_i = E_i/D_i`, `U = U_n/D_i`.

    E g + M is the characteristic polynomial in free motion, locked the one against a wall.
    """

    nominal: Poly
    desired: Poly
    E: Poly
    M: Poly
    locked: Poly
    E_i: Poly
    U_n: Poly
    D_i: Poly
    n_H: Poly
    n_Z: Poly
    d: Poly
    corners: tuple[Load, ...]  # corners of the rectangle that g(jω) moves in; the nominal load alone without a box
    edge: tuple[Load, Load] | None  # the segment v = B_lo ω, where K_hi > 0 makes it matter
    box: Box | None
    weight: tuple[Poly, Poly] | None  # |n_w|² and |d_w|², polynomials in x
    damping: Fraction  # B_imp

    def free(self, load: Poly) -> Poly:
        """`free` for the dynamic stiffness of a load: numerator of Z over `locked`."""
        return self.E * load + self.M


def stiffness(load: Load) -> Poly:
    """`g = I s² + B s + K`."""
    return Poly.of(*reversed(load))


def joint(certificate: dict[str, Any], clock: Clock) -> Joint:
    """Build every polynomial from specification and controller alone."""
    spec = certificate["spec"]
    nominal, desired = _load(spec["plant"]), stiffness(_load(spec["impedance"]))
    n_H, n_Z, d = _actuator(spec["actuator"])
    n_C, d_C = _compensator(certificate["controller"], spec["controller"])
    filters = spec["controller"]["filters"] or {"force": None, "position": None, "derivative": None}
    d_F, d_Fd = _lag(filters["force"]), _lag(filters["derivative"])
    # With one filter on the error F appears once; a filter of its own on θ makes the feedback C F_θ, over d_F.
    own = filters["position"] is not None
    d_θ = _lag(None if filters["position"] == "none" else filters["position"]) if own else ONE
    direct = d_C * d_F * d_θ
    feedback = n_C * d_F if own else n_C

    g = stiffness(nominal)
    E_i = direct * d_Fd
    U_n = feedback * d_Fd * desired - direct * (g - desired)
    corners, edge, box = _box(spec["uncertainty"]["box"], nominal)
    return Joint(
        nominal=g,
        desired=desired,
        E=d * E_i,
        M=n_Z * E_i + n_H * U_n,
        locked=d_Fd * d_θ * (d * d_C * d_F + n_H * n_C),
        E_i=E_i,
        U_n=U_n,
        D_i=d_Fd * d_θ * (d_C * d_F + n_C),
        n_H=n_H,
        n_Z=n_Z,
        d=d,
        corners=corners,
        edge=edge,
        box=box,
        weight=_weight(spec["uncertainty"]["weight"], clock),
        damping=spec["impedance"]["damping"],
    )


def _load(section: dict[str, Fraction]) -> Load:
    return section["inertia"], section["damping"], section["stiffness"]


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


def _compensator(given: dict[str, Any], asked: dict[str, Any]) -> tuple[Poly, Poly]:
    """`n_C, d_C`, after checking that the controller is one the specification allows."""
    if given["type"] != asked["type"]:
        raise MismatchError(f"controller.type: {given['type']}, the specification asks for {asked['type']}")
    name = "Q" if given["type"] == "dob" else "C"
    n, d = _rational(given[name])
    n_C, d_C = _rational(given["C"])
    if name == "Q":
        if n.degree > d.degree or not (d - n).c:
            raise UnreadableError("controller.Q: must be proper and not 1")
        padded = any(len(c) > 1 and c[-1] == 0 for c in given["C"].values())
        if padded or not _proportional((n_C, d_C), (n, d - n)):
            raise MismatchError("controller.C: is not Q/(1-Q)")
    if asked["coefficients"] is not None and not _proportional((n, d), _rational(asked["coefficients"])):
        raise MismatchError(f"controller.{name}: is not the one the specification gives")
    if asked["order"] is not None and max(n.degree, d.degree) > asked["order"]:
        raise MismatchError(f"controller.{name}: its order is above the specification's {asked['order']}")
    if asked["form"] == "eq23" and (n.degree > 0 or d.degree != 2):
        raise MismatchError(f"controller.{name}: is not of the form (23)")
    return n_C, d_C


def _rational(section: dict[str, Any]) -> tuple[Poly, Poly]:
    return Poly.of(*section["numerator"]), Poly.of(*section["denominator"])


def _proportional(a: tuple[Poly, Poly], b: tuple[Poly, Poly]) -> bool:
    """Equal up to one common rational factor: no cancellation, in either direction."""
    scale_a, scale_b = (Poly((p[1].c[-1],), p[1].d) for p in (a, b))
    return all(p * scale_b == q * scale_a for p, q in zip(a, b, strict=True))


def _box(
    section: dict[str, Any] | None, nominal: Load
) -> tuple[tuple[Load, ...], tuple[Load, Load] | None, Box | None]:
    if section is None:
        return (nominal,), None, None
    box = (section["inertia"], section["damping"], section["stiffness"])
    for key, (lo, hi), value in zip(section, box, nominal, strict=True):
        if not lo <= value <= hi:
            raise UnreadableError(f"spec.uncertainty.box.{key}: does not contain the nominal value")
    (I_lo, I_hi), (B_lo, B_hi), (K_lo, K_hi) = box
    corners = (I_hi, B_lo, K_lo), (I_hi, B_hi, K_lo), (I_lo, B_lo, K_hi), (I_lo, B_hi, K_hi)
    return tuple(dict.fromkeys(corners)), (corners[0], corners[2]) if K_hi > 0 else None, box


def _weight(section: dict[str, Any] | None, clock: Clock) -> tuple[Poly, Poly] | None:
    if section is None:
        return None
    n, d = _rational(section)
    if n.degree > d.degree or not decays_faster(d, Fraction(0), clock):
        raise UnreadableError("spec.uncertainty.weight: must be stable and proper")
    return norm2(n), norm2(d)
