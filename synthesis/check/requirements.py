"""What a certificate must contain for its specification, and what each claim's numbers must satisfy."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from .outcome import FalseClaimError, MismatchError, UnreadableError
from .statements import STATEMENTS

Interval = tuple[Fraction, Fraction | None]
WHOLE: Interval = (Fraction(0), None)
SIGNED = {("eq12", "disc"), ("eq12", "structured")}  # the forms whose margin may be negative


def required_claims(spec: dict[str, Any], omega_b: Fraction) -> dict[tuple[str, str], Interval]:
    """(id, form) of every claim the specification asks for, with its interval."""
    limits, band = spec["constraints"], (Fraction(0), omega_b)
    eq12, eq18 = limits["eq12"], limits["eq18"]
    found = {("stability-free", "hurwitz"): WHOLE, ("stability-locked", "hurwitz"): WHOLE}
    found[("bandwidth", "attenuation")] = band
    if limits["eq9"] is not None:
        found[("eq9", "printed")] = WHOLE
    if eq12 is not None:
        found[("eq12", eq12["form"])] = eq12["band"] or WHOLE
    if eq18 is not None:
        found[("eq18", f"{eq18['form']}/{eq18['coupling']}")] = WHOLE
    if limits["peak"] is not None:
        found[("peak", "sensitivity")] = WHOLE
    if spec["objective"]["rendering_error"] is not None:
        found[("rendering", "every-load")] = band
    if limits["friction"] == "require":
        found[("friction", "strictly-positive-real")] = WHOLE
    return found


def threshold(spec: dict[str, Any], claim: dict[str, Any]) -> Fraction | None:
    """The value at which the claim's statement meets the specification; None where it names none."""
    limits, kind = spec["constraints"], (claim["id"], claim["form"])
    if kind in SIGNED:
        return limits["eq12"]["margin"] if limits["eq12"] is not None else Fraction(0)
    if claim["id"] in ("eq9", "eq12", "eq18"):
        return Fraction(1)
    found: Fraction | None = {"peak": limits["peak"], "rendering": spec["objective"]["rendering_error"]}.get(
        claim["id"], None if claim["id"] == "bandwidth" else Fraction(0)
    )
    return found


def compare(certificate: dict[str, Any]) -> None:
    """Check ids, forms, intervals, flags and margins against the specification; nothing is proven here.

    Raises:
        UnreadableError: a claim that contradicts the format. MismatchError: one that the specification does not ask for
        as it stands, or one that it asks for and that is not there.
    """
    spec, omega_b = certificate["spec"], certificate["bandwidth"]["proven"]
    wanted = required_claims(spec, omega_b)
    seen: set[tuple[str, str]] = set()
    for claim in certificate["claims"]:
        kind = (claim["id"], claim["form"])
        name = title(claim)
        if claim["id"] not in STATEMENTS or claim["form"] not in STATEMENTS[claim["id"]][0]:
            raise UnreadableError(f"{name}: no such claim")
        if kind in seen:
            raise UnreadableError(f"{name}: appears twice")
        seen.add(kind)
        _shape(claim)
        if claim["required"] != (kind in wanted):
            raise MismatchError(f"{name}: `required` disagrees with the specification")
        expected = wanted.get(kind) or ((Fraction(0), omega_b) if claim["id"] == "rendering" else WHOLE)
        if claim["interval"] != expected and not (claim["id"] == "eq12" and not claim["required"]):
            raise MismatchError(f"{name}: its interval is not the specification's")
        if claim["status"] == "proven":
            _margin(spec, claim, omega_b)
    for kind in wanted:
        if kind not in seen:
            raise MismatchError(f"{'/'.join(kind)}: required by the specification and missing")


def title(claim: dict[str, Any]) -> str:
    """Claim name for messages: its id and form, made safe to print."""
    return ascii(f"{claim['id']} {claim['form']}")[1:-1][:60]


def _shape(claim: dict[str, Any]) -> None:
    """Which of margin and witness a status comes with."""
    proven, refuted = claim["status"] == "proven", claim["status"] == "refuted"
    if (claim["margin"] is None) == proven:
        raise UnreadableError(f"{title(claim)}: margin does not fit the status {claim['status']}")
    if (refuted and claim["refuted_at"] is None) or (not proven and not refuted and claim["refuted_at"] is not None):
        raise UnreadableError(f"{title(claim)}: refuted_at does not fit the status {claim['status']}")


def _margin(spec: dict[str, Any], claim: dict[str, Any], omega_b: Fraction) -> None:
    """A margin the statement makes sense at, and for a required claim one that is enough."""
    v, limit, kind = claim["margin"], threshold(spec, claim), (claim["id"], claim["form"])
    if v < 0 and kind not in SIGNED:
        raise FalseClaimError(f"{title(claim)}: a negative margin")
    if claim["id"] == "friction" and v == 0:
        raise FalseClaimError(f"{title(claim)}: the margin must be positive")
    if claim["id"] == "bandwidth" and (v != omega_b or v == 0):
        raise MismatchError("bandwidth attenuation: its margin is not bandwidth.proven")
    if claim["required"] and limit is not None and (v > limit if claim["id"] in ("peak", "rendering") else v < limit):
        raise MismatchError(f"{title(claim)}: its margin is short of what the specification asks for")
