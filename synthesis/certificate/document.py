"""The certificate file: exact text for every number, digests against accidents. Format 1: synthesis/check/README.md."""

from __future__ import annotations

import json
from fractions import Fraction
from hashlib import sha256
from typing import Any

from ...models.actuator import IDEAL
from ...models.controller import Compensator
from ...models.rational import descending, fraction
from ..problem.setting import ACTUATOR, LOAD, Setting
from ..spec import canonical, canonical_json, number_text, spec_sha256
from ..spec.model import Polynomials
from .claim import Claim, Refutation
from .outcome import Outcome

FORMAT = 1
PHYSICS = "the joint obeys (1) and, with a series-elastic actuator, (13) with motor damping: linear and time-invariant"
CONTINUOUS = "the controller runs in continuous time with exactly the coefficients printed here"
TOLERANT = "the controller runs in continuous time; its coefficients are those printed here, within the tolerance"
HELD = "between command and torque lie a hold of one period and the stated delay; the aliases of sampling are left out"
LIMITS = "torques stay within the actuator's limits"
BOUND = "bandwidth.bound is a solver's figure on a frequency grid"
UNSAMPLED = "sampling, computation delay, quantisation and saturation"
SAMPLED = "aliasing, quantisation and saturation"
OUTSIDE = "stability of loads outside the stated uncertainty"
NOMINAL_ONLY = "stability of any load but the nominal one: no claim here covers the stated uncertainty"


def document(
    setting: Setting,
    coefficients: Polynomials,
    claims: tuple[Claim, ...],
    *,
    bound: Fraction | None,
    producer: dict[str, str],
) -> dict[str, Any]:
    """The certificate of one controller as the JSON object that is written."""
    band, held = next(claim for claim in claims if claim.id == "bandwidth"), setting.spec.sampling is not None
    tolerant = any(claim.id == "tolerance" and claim.status is Outcome.PROVEN for claim in claims)
    body: dict[str, Any] = {
        "robimp_certificate": FORMAT,
        "spec": canonical(setting.spec),
        "spec_sha256": spec_sha256(setting.spec),
        "controller": _controller(setting, coefficients),
        "bandwidth": {
            "proven": number_text(band.margin or Fraction(0)),
            "refuted_at": None if band.refuted_at is None else number_text(band.refuted_at.value),
            "bound": None if bound is None else number_text(bound),
        },
        "claims": [_claim(claim) for claim in claims],
        "assumptions": [PHYSICS, HELD if held else TOLERANT if tolerant else CONTINUOUS, LIMITS],
        "not_claimed": [
            BOUND,
            SAMPLED if held else UNSAMPLED,
            OUTSIDE if robustly_stable(setting, claims) else NOMINAL_ONLY,
        ],
        "producer": producer,
    }
    digest = sha256(canonical_json(body)).hexdigest()
    return {**body, "end": {"claims": len(claims), "body_sha256": digest}}


def encoded(certificate: dict[str, Any]) -> bytes:
    """The file of a certificate."""
    return (json.dumps(certificate, indent=1, ensure_ascii=False) + "\n").encode()


def _controller(setting: Setting, coefficients: Polynomials) -> dict[str, Any]:
    C: Compensator = setting.compensator(coefficients)
    written = {"type": setting.spec.controller.type}
    if setting.spec.controller.type == "dob":
        written["Q"] = _polynomials(coefficients.numerator, coefficients.denominator)
    written["C"] = _polynomials(descending(C.num), descending(C.den))
    return written


def _polynomials(numerator: tuple[Fraction, ...], denominator: tuple[Fraction, ...]) -> Any:
    return {"numerator": [number_text(c) for c in numerator], "denominator": [number_text(c) for c in denominator]}


def _claim(claim: Claim) -> dict[str, Any]:
    low, high = claim.interval
    return {
        "id": claim.id,
        "equation": claim.equation,
        "form": claim.form,
        "statement": claim.statement,
        "interval": [number_text(low), "inf" if high is None else number_text(high)],
        "uncertainty": claim.uncertainty,
        "required": claim.required,
        "status": claim.status.value,
        "margin": None if claim.margin is None else number_text(claim.margin),
        "refuted_at": None if claim.refuted_at is None else _refutation(claim.refuted_at),
        "hints": {},
    }


def _refutation(refutation: Refutation) -> dict[str, Any]:
    witness = refutation.witness
    if witness is None:
        return {"value": number_text(refutation.value), "omega": None, "load": None}
    written: dict[str, Any] = {
        "value": number_text(refutation.value),
        "omega": "inf" if witness.omega is None else number_text(witness.omega),
        "load": _numbers(witness.load, {name: name for name in LOAD}),
    }
    if witness.impedance is not None:
        written["impedance"] = _numbers(witness.impedance, {name: name for name in LOAD})
    if witness.actuator is not None:
        written["actuator"] = _numbers(witness.actuator, ACTUATOR)
    if witness.controller is not None:
        written["controller"] = _polynomials(witness.controller.numerator, witness.controller.denominator)
    if witness.claim is not None:
        written["claim"] = list(witness.claim)
    return written


def _numbers(values: object, names: dict[str, str]) -> dict[str, str] | None:
    """Exact texts of an object's numbers by their names in a specification."""
    if values is None:
        return None
    return {name: number_text(fraction(getattr(values, attribute))) for name, attribute in names.items()}


def robustly_stable(setting: Setting, claims: tuple[Claim, ...]) -> bool:
    """Whether the proven claims make every load of the uncertainty stable: nominal stability and one robust claim.

    The claim about the box if there is no disc on top; (18) with physical coupling; passivity on the whole axis with
    something to spare, structured or over the disc; friction; (9), about an ideal actuator, if the actuator is ideal.
    """
    whole = [c for c in claims if c.status is Outcome.PROVEN and c.interval == (Fraction(0), None)]
    proven = {(c.id, c.form) for c in whole if c.id != "eq12" or (c.margin or 0) > 0}
    robust = {("eq12", "structured"), ("eq12", "disc"), ("friction", "strictly-positive-real")}
    robust |= {("eq18", f"{form}/physical") for form in ("paper", "lumped", "half-plane")}
    if setting.loop.actuator == IDEAL:
        robust.add(("eq9", "printed"))
    if not setting.uncertainty.disc:
        robust.add(("stability-free", "box"))
    form = "hurwitz" if setting.loop.actuator.hold is None else "winding"
    nominal = {("stability-free", form), ("stability-locked", form)}
    alone = not setting.boxed and not setting.uncertainty.disc  # there is no other load
    return nominal <= proven and (alone or bool(proven & robust))


def verdict(claims: tuple[Claim, ...]) -> Outcome:
    """Refuted if a required claim is, undecided if one is, proven otherwise."""
    statuses = {claim.status for claim in claims if claim.required}
    for status in (Outcome.REFUTED, Outcome.UNDECIDED):
        if status in statuses:
            return status
    return Outcome.PROVEN
