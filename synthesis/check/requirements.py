"""What a certificate must contain for its specification, and what each claim's numbers must satisfy."""

from collections.abc import Callable
from fractions import Fraction
from math import inf
from typing import Any

from .joint import nominal, ranges
from .outcome import FALSE, MISMATCH, UNREADABLE, demand
from .statements import STATEMENTS

Expect = Callable[..., None]
Part = dict[str, Any]  # of a certificate
Kind = tuple[str, str]  # id and form of a claim
Interval = tuple[Fraction, Fraction | float]
PLACES = {"load": "plant", "impedance": "impedance", "actuator": "actuator"}  # of a witness: its section
ALL = tuple(PLACES.values())  # sections that may have ranges
WHOLE: Interval = (Fraction(0), inf)
FALLING = "peak", "rendering", "noise"  # smaller is better
SIGNED = {("eq12", "disc"), ("eq12", "structured")}  # the forms whose margin may be negative


def requirements(spec: dict[str, Any], omega_b: Fraction) -> dict[Kind, tuple[bool, Interval, Fraction | None]]:
    """For every claim whether the specification requires it, on which interval, and the margin that is just enough."""
    limits, error, sampled = spec["constraints"], spec["objective"]["rendering_error"], bool(spec["sampling"])
    zero, one, band = Fraction(0), Fraction(1), (Fraction(0), omega_b)
    eq12, noise = limits["eq12"] or {}, limits["noise"] or {"gain": None, "above": zero}
    eq18 = "/".join((limits["eq18"] or {}).values())
    found: dict[Kind, tuple[bool, Interval, Fraction | None]] = {}
    for name, sections in (("stability-free", ALL), ("stability-locked", ALL[2:])):
        found[name, "hurwitz"] = not sampled, WHOLE, zero
        found[name, "winding"] = sampled, WHOLE, zero
        found[name, "box"] = bool(ranges(spec, sections)), WHOLE, one
    for kind in STATEMENTS:
        level = eq12.get("margin", zero) if kind in SIGNED else one
        found[kind] = {
            "eq9": (limits["eq9"] is not None, WHOLE, one),
            "eq12": (eq12.get("form") == kind[1], eq12.get("band") or WHOLE, level),
            "eq18": (eq18 == kind[1], WHOLE, one),
            "bandwidth": (True, band, None),
            "peak": (limits["peak"] is not None, WHOLE, limits["peak"]),
            "rendering": (error is not None, band, error),
            "friction": (limits["friction"] == "require", WHOLE, zero),
            "noise": (limits["noise"] is not None, (noise["above"] or zero, inf), noise["gain"]),
        }[kind[0]]
    found["tolerance", "coefficients"] = limits["tolerance"] is not None, WHOLE, limits["tolerance"]
    return found


def compare(certificate: dict[str, Any]) -> None:
    """Check every claim's fields against the format and the specification, or CheckError; nothing is proven here."""
    asked = requirements(certificate["spec"], certificate["bandwidth"]["proven"])
    seen: set[Kind] = set()
    for claim in certificate["claims"]:
        kind = claim["id"], claim["form"]

        def expect(holds: bool, text: str, code: int = FALSE, kind: Kind = kind) -> None:
            demand(holds, f"{ascii(' '.join(kind))[1:-1][:60]}: {text}", code)

        expect(kind in asked, "no such claim", UNREADABLE)
        expect(kind not in seen, "appears twice", UNREADABLE)
        seen.add(kind)
        _compare_claim(certificate, claim, asked, expect)
        if claim["refuted_at"] is not None:
            _compare_witness(certificate, claim, asked, expect)
    for kind, (required, *_) in asked.items():
        demand(kind in seen or not required, f"{' '.join(kind)}: required by the specification and missing", MISMATCH)


def _compare_claim(certificate: Part, claim: Part, asked: dict[Kind, Any], expect: Expect) -> None:
    name, form, status, v, witness = (claim[key] for key in ("id", "form", "status", "margin", "refuted_at"))
    omega_b, (required, interval, limit) = certificate["bandwidth"]["proven"], asked[name, form]
    expect((v is not None) == (status == "proven"), f"margin does not fit the status {status}", UNREADABLE)
    fits = status == "proven" or bool(witness) == (status == "refuted")
    expect(fits, f"refuted_at does not fit the status {status}", UNREADABLE)
    expect(claim["required"] == required, "`required` disagrees with the specification", MISMATCH)
    expect(form not in ("hurwitz", "winding") or required, "not with or without sampling", MISMATCH)
    anywhere = name == "eq12" and not required
    expect(anywhere or claim["interval"] == interval, "its interval is not the specification's", MISMATCH)
    if v is not None:
        expect(v >= 0 or (name, form) in SIGNED, "a negative margin")
        expect(v > 0 or name not in ("friction", "tolerance"), "the margin must be positive")
        expect(v == omega_b > 0 or name != "bandwidth", "its margin is not bandwidth.proven", MISMATCH)
        expect(v == 0 or form != "winding", "its margin is not 0", MISMATCH)
        enough = limit is None or (v <= limit if name in FALLING else v >= limit)
        expect(enough or not required, "its margin is short of what the specification asks for", MISMATCH)
    twin = certificate["bandwidth"]["refuted_at"]
    expect(name != "bandwidth" or twin == (witness and witness["value"]), "its witness is not bandwidth.refuted_at")


def _compare_witness(certificate: Part, claim: Part, asked: dict[Kind, Any], expect: Expect) -> None:
    kind, witness = (claim["id"], claim["form"]), claim["refuted_at"]
    value, omega, about = witness["value"], witness["omega"], witness["claim"]
    lo, hi = (value, value) if kind[0] == "bandwidth" else claim["interval"]
    expect(value >= 0 or kind in SIGNED, "refuted_at.value: negative")
    expect(claim["status"] != "refuted" or asked[kind][2] in (None, value), "refuted_at.value: is not the required one")
    fits = (kind[0] == "tolerance") == (about is not None) == (witness["controller"] is not None)
    expect(fits, "refuted_at: fields")
    scale = value if kind[1] == "box" else Fraction(1)
    if about:
        kind, scale = tuple(about), Fraction(1)
        needed = kind[0] != "tolerance" and asked.get(kind, (False,))[0]
        expect(needed, "refuted_at.claim: is not a required one")
        lo, hi = asked[kind][1]
        _near(certificate, witness["controller"], value, expect)
    _inside(certificate["spec"], witness, scale, kind[1], expect)
    pointwise = kind[1] not in ("hurwitz", "winding")
    expect((omega is not None) == pointwise or kind[1] == "box", "refuted_at.omega: does not fit")
    expect(omega is None or lo <= omega <= hi, "refuted_at.omega: is outside the interval")


def _inside(spec: dict[str, Any], witness: dict[str, Any], v: Fraction, form: str, expect: Expect) -> None:
    """The witness's parameters are in their ranges, for a box scaled by v about the nominal."""
    for place, section in PLACES.items():
        expect(not witness[place] or form not in ("hurwitz", "winding"), f"refuted_at.{place}: this claim is nominal")
        for key, at in (witness[place] or {}).items():
            expect(key in spec[section], f"refuted_at.{place}: there is no {key}")
            n = nominal(spec, section, key)
            lo, hi = ranges(spec, [section], v).get((section, key), (n, n))
            expect(lo <= at <= hi, f"refuted_at.{place}: is not in the box")


def _near(certificate: dict[str, Any], given: dict[str, Any], v: Fraction, expect: Expect) -> None:
    """The witness's controller has the certificate's coefficients c as c(1 + e), |e| ≤ v."""
    controller = certificate["controller"]
    for part, c in controller["Q" if controller["type"] == "dob" else "C"].items():
        near = len(c) == len(given[part]) and all(abs(a - b) <= v * abs(b) for a, b in zip(given[part], c, strict=True))
        expect(near, "refuted_at.controller: is not within the tolerance")
