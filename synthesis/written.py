"""Claims and controllers as a certificate says them, not as a prover would find them now."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from ..models.actuator import SeriesElastic
from ..models.impedance import DynamicStiffness
from ..models.rational import ZERO, exact
from .certificate.claim import Claim, Refutation
from .certificate.outcome import Outcome
from .certificate.witness import Witness
from .spec.model import Polynomials

TEXTS = ("id", "equation", "form", "statement", "uncertainty", "required")


def claims_of(content: dict[str, Any]) -> tuple[Claim, ...]:
    """Every claim of a certificate whose format was checked."""
    return tuple(map(_claim, content["claims"]))


def polynomials(written: dict[str, list[str]]) -> Polynomials:
    """Numerator and denominator of a controller."""
    return Polynomials(
        numerator=tuple(map(Fraction, written["numerator"])), denominator=tuple(map(Fraction, written["denominator"]))
    )


def _claim(written: dict[str, Any]) -> Claim:
    low, high = written["interval"]
    beyond = written["refuted_at"]
    return Claim(
        **{key: written[key] for key in TEXTS},
        interval=(Fraction(low), None if high == "inf" else Fraction(high)),
        status=Outcome(written["status"]),
        margin=None if written["margin"] is None else Fraction(written["margin"]),
        refuted_at=None if beyond is None else Refutation(Fraction(beyond["value"]), _witness(beyond)),
    )


def _witness(written: dict[str, Any]) -> Witness | None:
    """None where only a level is written."""
    if written.get("omega") is None and not any(written.get(key) for key in ("load", "impedance", "actuator")):
        return None
    omega, drive, controller = (written.get(key) for key in ("omega", "actuator", "controller"))
    return Witness(
        None if omega in (None, "inf") else Fraction(omega),
        _stiffness(written.get("load")),
        _stiffness(written.get("impedance")),
        None if drive is None else _actuator(drive),
        None if controller is None else polynomials(controller),
        None if (claim := written.get("claim")) is None else (claim[0], claim[1]),
    )


def _actuator(written: dict[str, str]) -> SeriesElastic:
    """Motor and spring; the torque loop is the specification's."""
    J, b_m, K_sp = (exact(Fraction(written[name])) for name in ("motor_inertia", "motor_damping", "spring_stiffness"))
    return SeriesElastic(J, b_m, K_sp, C_t=ZERO, feedforward=exact(1))


def _stiffness(written: dict[str, str] | None) -> DynamicStiffness | None:
    if written is None:
        return None
    return DynamicStiffness.of(*(Fraction(written[name]) for name in ("inertia", "damping", "stiffness")))
