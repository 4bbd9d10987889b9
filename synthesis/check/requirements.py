"""What a certificate must contain for its specification, and what each claim's numbers must satisfy."""

from collections.abc import Callable
from fractions import Fraction
from math import inf
from typing import Any

from .joint import nominal, ranges
from .outcome import FALSE, MISMATCH, UNREADABLE, demand
from .statements import STATEMENTS

Expect = Callable[..., None]
Kind = tuple[str, str]  # id and form of a claim
Interval = tuple[Fraction, Fraction | float]
ALL = "plant", "impedance", "actuator"  # sections that may have ranges
WHOLE: Interval = (Fraction(0), inf)
FALLING = "peak", "rendering", "noise"  # smaller is better
SIGNED = {("eq12", "disc"), ("eq12", "structured")}  # the forms whose margin may be negative


KINDS: list[Kind] = [
    *((f"stability-{end}", form) for end in ("free", "locked") for form in ("hurwitz", "winding", "box")),
    *STATEMENTS,
    ("tolerance", "coefficients"),
]


def asked(spec: dict[str, Any], omega_b: Fraction, kind: Kind) -> tuple[bool, Interval, Fraction | None]:
    """Whether the specification requires a claim, on which interval, and the margin that is just enough."""
    limits, error, band = spec["constraints"], spec["objective"]["rendering_error"], (Fraction(0), omega_b)
    zero, one, eq12, eq18 = Fraction(0), Fraction(1), limits["eq12"] or {}, limits["eq18"] or {}
    noise, sampled, (name, form) = limits["noise"] or {"gain": None, "above": zero}, bool(spec["sampling"]), kind
    needed = {
        "hurwitz": not sampled,
        "winding": sampled,
        "box": bool(ranges(spec, ALL[2 * (name != "stability-free") :])),
    }
    table: dict[str, tuple[bool, Interval, Fraction | None]] = {
        "bandwidth": (True, band, None),
        "eq9": (limits["eq9"] is not None, WHOLE, one),
        "eq12": (
            eq12.get("form") == form,
            eq12.get("band") or WHOLE,
            eq12.get("margin", zero) if kind in SIGNED else one,
        ),
        "eq18": ("/".join(eq18.values()) == form, WHOLE, one),
        "peak": (limits["peak"] is not None, WHOLE, limits["peak"]),
        "rendering": (error is not None, band, error),
        "friction": (limits["friction"] == "require", WHOLE, zero),
        "noise": (limits["noise"] is not None, (noise["above"] or zero, inf), noise["gain"]),
        "tolerance": (limits["tolerance"] is not None, WHOLE, limits["tolerance"]),
    }
    return table.get(name) or (needed[form], WHOLE, one if form == "box" else zero)


def required_kinds(spec: dict[str, Any]) -> list[Kind]:
    """The claims that a specification requires."""
    return [kind for kind in KINDS if asked(spec, Fraction(0), kind)[0]]


def compare(certificate: dict[str, Any]) -> None:
    """Check every claim's fields against the format and the specification, or CheckError; nothing is proven here."""
    seen: set[Kind] = set()
    for claim in certificate["claims"]:
        _compare_claim(certificate, claim, seen)
    for kind in required_kinds(certificate["spec"]):
        demand(kind in seen, f"{' '.join(kind)}: required by the specification and missing", MISMATCH)


def _compare_claim(certificate: dict[str, Any], claim: dict[str, Any], seen: set[Kind]) -> None:
    name, form, status, v, witness = (claim[key] for key in ("id", "form", "status", "margin", "refuted_at"))
    kind, spec, (omega_b, twin, _) = (name, form), certificate["spec"], certificate["bandwidth"].values()

    def expect(holds: bool, text: str, code: int = FALSE) -> None:
        demand(holds, f"{ascii(' '.join(kind))[1:-1][:60]}: {text}", code)

    expect(kind in KINDS, "no such claim", UNREADABLE)
    expect(kind not in seen, "appears twice", UNREADABLE)
    seen.add(kind)
    expect((v is not None) == (status == "proven"), f"margin does not fit the status {status}", UNREADABLE)
    fits = status == "proven" or bool(witness) == (status == "refuted")
    expect(fits, f"refuted_at does not fit the status {status}", UNREADABLE)
    required, interval, limit = asked(spec, omega_b, kind)
    expect(claim["required"] == required, "`required` disagrees with the specification", MISMATCH)
    other = {"hurwitz": "winding", "winding": "hurwitz"}.get(form)
    expect(not asked(spec, omega_b, (name, other))[0] if other else True, "not with or without sampling", MISMATCH)
    anywhere = name == "eq12" and not required
    expect(anywhere or claim["interval"] == interval, "its interval is not the specification's", MISMATCH)
    if v is not None:
        expect(v >= 0 or kind in SIGNED, "a negative margin")
        expect(v > 0 or name not in ("friction", "tolerance"), "the margin must be positive")
        expect(v == omega_b > 0 or name != "bandwidth", "its margin is not bandwidth.proven", MISMATCH)
        expect(v == 0 or form != "winding", "its margin is not 0", MISMATCH)
        enough = limit is None or (v <= limit if name in FALLING else v >= limit)
        expect(enough or not required, "its margin is short of what the specification asks for", MISMATCH)
    expect(name != "bandwidth" or twin == (witness and witness["value"]), "its witness is not bandwidth.refuted_at")
    if witness is not None:
        value, omega, about = witness["value"], witness["omega"], witness["claim"]
        lo, hi = (value, value) if name == "bandwidth" else claim["interval"]
        expect(value >= 0 or kind in SIGNED, "refuted_at.value: negative")
        expect(status != "refuted" or limit in (None, value), "refuted_at.value: is not the required one")
        expect(
            (name == "tolerance") == (about is not None) == (witness["controller"] is not None), "refuted_at: fields"
        )
        if about:
            expect(len(about) == 2 and tuple(about) in required_kinds(spec), "refuted_at.claim: is not a required one")
            name, form = about
            expect(name != "tolerance", "refuted_at.claim: is not a required one")
            lo, hi = asked(spec, omega_b, (name, form))[1]
            _near(certificate, witness["controller"], value, expect)
        _inside(spec, witness, (Fraction(1) if about else value) if form == "box" else Fraction(1), form, expect)
        expect((omega is None) == (form in ("hurwitz", "winding")) or form == "box", "refuted_at.omega: does not fit")
        expect(omega is None or lo <= omega <= hi, "refuted_at.omega: is outside the interval")


def _inside(spec: dict[str, Any], witness: dict[str, Any], v: Fraction, form: str, expect: Expect) -> None:
    """The witness's parameters are in their ranges, for a box scaled by v about the nominal."""
    for place, section in (("load", "plant"), ("impedance", "impedance"), ("actuator", "actuator")):
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
