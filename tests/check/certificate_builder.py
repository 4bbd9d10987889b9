"""Specifications and certificates for the tests; margins come from float grids and a step to the safe side."""

from __future__ import annotations

import copy
import hashlib
import json
from collections.abc import Iterator
from fractions import Fraction
from functools import cache
from itertools import product
from typing import Any

from claim_floats import Joint, Json, num

TEXTS = dict.fromkeys(("equation", "statement", "uncertainty"), "...")


def text(value: float | Fraction | int, digits: int = 6) -> str:
    return str(Fraction(f"{value:.{digits}g}") if isinstance(value, float) else Fraction(value))


def spec(**changes: Any) -> Json:
    """The series-elastic joint of the documentation; `changes` replace whole sections, or keys of a section."""
    base: Json = {
        "robimp": 1,
        "name": "joint",
        "motion": "rotary",
        "plant": {"inertia": "3/100", "damping": "1/5", "stiffness": "0"},
        "uncertainty": {
            "box": {"inertia": ["3/125", "9/250"], "damping": ["3/25", "7/25"], "stiffness": ["0", "0"]},
            "weight": None,
        },
        "actuator": {
            "type": "series-elastic",
            "motor_inertia": "1/100",
            "motor_damping": "1/20",
            "spring_stiffness": "24/5",
            "torque_loop": {"kp": "10", "kd": "1/4", "derivative_corner": "1000", "feedforward": "1"},
        },
        "impedance": {"inertia": "3/100", "damping": "7/20", "stiffness": "5/4"},
        "controller": {
            "type": "dob",
            "order": None,
            "form": None,
            "coefficients": None,
            "filters": {"force": None, "position": None, "derivative": None},
        },
        "objective": {"maximize": "bandwidth", "attenuation": "3/10", "rendering_error": None},
        "constraints": {
            "eq9": {},
            "eq12": {"form": "structured", "band": None, "margin": "0"},
            "eq18": {"form": "half-plane", "coupling": "physical"},
            "peak": "2",
            "friction": "report",
        },
    }
    for key, value in changes.items():
        base[key] = {**(base.get(key) or {}), **value} if isinstance(value, dict) and key != "actuator" else value
    return base


def dob(numerator: list[str], denominator: list[str]) -> Json:
    padded = ["0"] * (len(denominator) - len(numerator)) + numerator
    below = [str(Fraction(d) - Fraction(n)) for n, d in zip(padded, denominator, strict=True)]
    while below[0] == "0":
        below.pop(0)
    Q = {"numerator": numerator, "denominator": denominator}
    return {"type": "dob", "Q": Q, "C": {"numerator": numerator, "denominator": below}}


EQ23 = dob(["2000"], ["1", "283/4", "2500"])  # the hand-tuned form (23): α = 0.8, ω = 50


def grid(lo: float, hi: float, n: int = 400) -> Iterator[float]:
    lo = max(lo, 1e-2)
    return (lo * (hi / lo) ** (k / (n - 1)) for k in range(n))


def points(s: Json, steps: int = 2) -> list[Json]:
    """Parameters on a grid of their ranges: nothing, or the impedance's and the actuator's."""
    ranged = [("impedance", k, v) for k, v in s["impedance"].items() if isinstance(v, list)]
    ranged += [("actuator", k, v) for k, v in (s["uncertainty"].get("actuator") or {}).items()]
    found: list[Json] = []
    for shares in product(range(steps), repeat=len(ranged)):
        point: Json = {}
        for (section, key, (lo, hi)), share in zip(ranged, shares, strict=True):
            point.setdefault(section, {})[key] = num(lo) + (num(hi) - num(lo)) * share / (steps - 1)
        found.append(point)
    return found


FALLING = ("peak", "rendering", "noise")


def worst(s: Json, controller: Json, kind: str, form: str, lo: float, hi: float, steps: int = 2) -> float:
    """The extreme on a grid, and on a fine one around its worst frequencies."""
    sign = -1 if kind in FALLING else 1

    def at(w: float) -> float:
        return min(sign * Joint(s, controller, w, point).margin(kind, form) for point in points(s, steps))

    found = sorted((at(w), w) for w in grid(lo, hi, 400 if steps == 2 else 150))[:3]
    fine = {min(max(w * (1 + k * 2e-3), lo, 1e-2), hi) for _, w in found for k in range(-12, 13)}
    return sign * min(found[0][0], *map(at, fine))


def claim(kind: str, form: str, interval: list[str], margin: str | None, required: bool, **more: Any) -> Json:
    return {
        "id": kind,
        "form": form,
        **TEXTS,
        "interval": interval,
        "required": required,
        "status": "proven",
        "margin": margin,
        "refuted_at": None,
        "hints": {},
        **more,
    }


def slack_of(s: Json) -> float:
    """Relative distance of a margin from the grid's; tight ones take long on a box of three nonlinear parameters."""
    return 0.2 if s["uncertainty"].get("actuator") else 2e-3


def omega_b(s: Json, controller: Json) -> float:
    return _omega_b(json.dumps([s, controller]))


@cache
def _omega_b(key: str) -> float:
    s, controller = json.loads(key)
    delta, low, high = num(s["objective"]["attenuation"]), 0.0, None

    def attenuated(w: float) -> bool:
        return all(Joint(s, controller, w, point).margin("bandwidth", "") <= delta for point in points(s))

    for w in grid(1e-2, 1e4, 500):
        if not attenuated(w):
            high = w
            break
        low = w
    assert high is not None
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (middle, high) if attenuated(middle) else (low, middle)
    return low


Extra = tuple[str, str, list[str]]


def certificate(s: Json, controller: Json, extra: list[Extra] | None = None, decay: str = "1") -> Json:
    """All claims the specification asks for, and `extra` ones that it does not: (id, form, interval)."""
    limits = s["constraints"]
    proven = text(omega_b(s, controller) * (1 - slack_of(s) / 200), 5)
    whole, band = ["0", "inf"], ["0", proven]
    wanted: list[tuple[str, str, list[str], bool]] = []
    if limits["eq9"] is not None:
        wanted.append(("eq9", "printed", whole, True))
    if limits["eq12"] is not None:
        wanted.append(("eq12", limits["eq12"]["form"], limits["eq12"]["band"] or whole, True))
    if limits["eq18"] is not None:
        wanted.append(("eq18", f"{limits['eq18']['form']}/{limits['eq18']['coupling']}", whole, True))
    if limits["peak"] is not None:
        wanted.append(("peak", "sensitivity", whole, True))
    if s["objective"]["rendering_error"] is not None:
        wanted.append(("rendering", "every-load", band, True))
    if limits.get("noise"):
        wanted.append(("noise", "command", [limits["noise"].get("above") or "0", "inf"], True))
    if limits["friction"] == "require":
        wanted.append(("friction", "strictly-positive-real", whole, True))
    wanted += [(*entry, False) for entry in extra or []]
    form, decay = ("winding", "0") if s.get("sampling") else ("hurwitz", decay)
    claims = [claim(f"stability-{end}", form, whole, decay, True) for end in ("free", "locked")]
    claims.append(claim("bandwidth", "attenuation", band, proven, True))
    if points(s)[0] or any(lo != hi for lo, hi in (s["uncertainty"].get("box") or {}).values()):
        claims.append(claim("stability-free", "box", whole, "1", True))
    if s["uncertainty"].get("actuator"):
        claims.append(claim("stability-locked", "box", whole, "1", True))
    if limits.get("tolerance"):
        claims.append(claim("tolerance", "coefficients", whole, limits["tolerance"], True))
    for kind, form, interval, required in wanted:
        hi = 1e5 if interval[1] == "inf" else num(interval[1])
        value = worst(s, controller, kind, form, num(interval[0]), hi)
        slack = abs(value) * slack_of(s)
        margin = value + slack if kind in FALLING else value - slack
        claims.append(claim(kind, form, interval, text(margin, 9), required))
    return seal(
        {
            "robimp_certificate": 1,
            "spec": s,
            "controller": controller,
            "bandwidth": {"proven": proven, "refuted_at": None, "bound": None},
            "claims": claims,
            "assumptions": [],
            "not_claimed": [],
            "producer": {"robimp": "test"},
        }
    )


def canonical(value: Json) -> bytes:
    return json.dumps(value, sort_keys=True, separators=(",", ":"), ensure_ascii=True, allow_nan=False).encode()


def seal(body: Json) -> Json:
    """Digests and end record, whatever was edited before."""
    body = copy.deepcopy({key: part for key, part in body.items() if key != "end"})
    body["spec_sha256"] = hashlib.sha256(canonical(body["spec"])).hexdigest()
    digest = hashlib.sha256(canonical(body)).hexdigest()
    body["end"] = {"claims": len(body["claims"]), "body_sha256": digest}
    return body


def data(cert: Json) -> bytes:
    return json.dumps(cert, indent=1).encode()


def find(cert: Json, kind: str, form: str | None = None) -> Json:
    return next(c for c in cert["claims"] if c["id"] == kind and form in (None, c["form"]))
