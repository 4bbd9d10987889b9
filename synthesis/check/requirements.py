"""What a certificate must contain for its specification, and what each claim's numbers must satisfy."""

from fractions import Fraction
from math import inf
from typing import Any

from .joint import contains
from .outcome import FALSE, MISMATCH, UNREADABLE, demand
from .statements import STATEMENTS

Kind = tuple[str, str]  # id and form of a claim
Interval = tuple[Fraction, Fraction | float]
WHOLE: Interval = (Fraction(0), inf)
SIGNED = {("eq12", "disc"), ("eq12", "structured")}  # the forms whose margin may be negative


def asked(spec: dict[str, Any], omega_b: Fraction, kind: Kind) -> tuple[bool, Interval, Fraction | None]:
    """Whether the specification requires a claim, on which interval, and the margin that is just enough."""
    limits, error, band = spec["constraints"], spec["objective"]["rendering_error"], (Fraction(0), omega_b)
    zero, one, eq12, eq18 = Fraction(0), Fraction(1), limits["eq12"] or {}, limits["eq18"] or {}
    table: dict[str, tuple[bool, Interval, Fraction | None]] = {
        "bandwidth": (True, band, None),
        "eq9": (limits["eq9"] is not None, WHOLE, one),
        "eq12": (eq12.get("form") == kind[1], eq12.get("band") or WHOLE, one),
        "eq18": ("/".join(eq18.values()) == kind[1], WHOLE, one),
        "peak": (limits["peak"] is not None, WHOLE, limits["peak"]),
        "rendering": (error is not None, band, error),
        "friction": (limits["friction"] == "require", WHOLE, zero),
    }
    required, interval, limit = table.get(kind[0], (True, WHOLE, zero))
    return required, interval, eq12.get("margin", zero) if kind in SIGNED else limit


def compare(certificate: dict[str, Any]) -> None:
    """Check every claim's fields against the format and the specification, or CheckError; nothing is proven here."""
    seen: set[Kind] = set()
    for claim in certificate["claims"]:
        _compare_claim(certificate, claim, seen)
    for kind in STATEMENTS:
        needless = kind in seen or not asked(certificate["spec"], Fraction(0), kind)[0]
        demand(needless, f"{' '.join(kind)}: required by the specification and missing", MISMATCH)


def _compare_claim(certificate: dict[str, Any], claim: dict[str, Any], seen: set[Kind]) -> None:
    name, form, status, v, witness = (claim[key] for key in ("id", "form", "status", "margin", "refuted_at"))
    kind, spec, (omega_b, twin, _) = (name, form), certificate["spec"], certificate["bandwidth"].values()

    def expect(holds: bool, text: str, code: int = FALSE) -> None:
        demand(holds, f"{ascii(' '.join(kind))[1:-1][:60]}: {text}", code)

    expect(kind in STATEMENTS, "no such claim", UNREADABLE)
    expect(kind not in seen, "appears twice", UNREADABLE)
    seen.add(kind)
    expect((v is not None) == (status == "proven"), f"margin does not fit the status {status}", UNREADABLE)
    fits = status == "proven" or bool(witness) == (status == "refuted")
    expect(fits, f"refuted_at does not fit the status {status}", UNREADABLE)
    required, interval, limit = asked(spec, omega_b, kind)
    expect(claim["required"] == required, "`required` disagrees with the specification", MISMATCH)
    anywhere = name == "eq12" and not required
    expect(anywhere or claim["interval"] == interval, "its interval is not the specification's", MISMATCH)
    if v is not None:
        expect(v >= 0 or kind in SIGNED, "a negative margin")
        expect(v > 0 or name != "friction", "the margin must be positive")
        expect(v == omega_b > 0 or name != "bandwidth", "its margin is not bandwidth.proven", MISMATCH)
        enough = limit is None or (v <= limit if name in ("peak", "rendering") else v >= limit)
        expect(enough or not required, "its margin is short of what the specification asks for", MISMATCH)
    expect(name != "bandwidth" or twin == (witness and witness["value"]), "its witness is not bandwidth.refuted_at")
    if witness is not None:
        value, omega, load = witness.values()
        lo, hi = (value, value) if name == "bandwidth" else claim["interval"]
        expect(value >= 0 or kind in SIGNED, "refuted_at.value: negative")
        expect(status != "refuted" or limit in (None, value), "refuted_at.value: is not the required one")
        expect(load is None or contains(spec, load), "refuted_at.load: is not in the box")
        expect((omega is None) == (form == "hurwitz"), "refuted_at.omega: does not fit the claim")
        expect(omega is None or lo <= omega <= hi, "refuted_at.omega: is outside the interval")
