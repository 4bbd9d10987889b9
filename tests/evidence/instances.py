"""Concrete joints out of a specification with ranges: impedance, actuator and load drawn from their intervals."""

from __future__ import annotations

import copy
from collections.abc import Iterator
from fractions import Fraction
from random import Random
from typing import Any

Json = Any
LOAD = ("inertia", "damping", "stiffness")
INSIDE = 4  # draws besides the midpoint


def middle(value: Json) -> Fraction:
    """A number, or the midpoint of a range."""
    return sum(map(Fraction, value), Fraction(0)) / 2 if isinstance(value, list) else Fraction(value)


def _drawn(rng: Random, nominal: Fraction, ends: Json, v: Fraction) -> str:
    """A value of the interval scaled by v about the nominal one, often an end."""
    if not isinstance(ends, list):
        return str(Fraction(ends))
    lo, hi = (nominal + v * (Fraction(end) - nominal) for end in ends)
    share = rng.choice([Fraction(0), Fraction(1), Fraction(rng.randint(0, 100), 100)])
    return str(lo + share * (hi - lo))


def nominal(spec: Json) -> Json:
    """The specification at the midpoint of its impedance and with its nominal actuator."""
    return at(spec, None)


def at(spec: Json, witness: Json | None) -> Json:
    """The specification at the impedance and actuator of a witness; what it does not give is nominal."""
    s, given = copy.deepcopy(spec), witness or {}
    s["impedance"] = {key: str(middle(value)) for key, value in spec["impedance"].items()}
    s["impedance"].update(given.get("impedance") or {})
    s["actuator"].update(given.get("actuator") or {})
    return s


def ranges(spec: Json) -> bool:
    """Whether there is more than one impedance or actuator."""
    several = any(isinstance(value, list) for value in spec["impedance"].values())
    return several or bool(spec["uncertainty"].get("actuator"))


def instances(spec: Json, rng: Random, v: Fraction = Fraction(1), *, loads: bool = False) -> Iterator[Json]:
    """The nominal joint, then some of the box scaled by v; with `loads` the plant is drawn from its box as well."""
    yield nominal(spec)
    boxed = loads and spec["uncertainty"]["box"]
    for _ in range(INSIDE * (3 if loads else 1) if ranges(spec) or boxed else 0):
        s = nominal(spec)
        for key in LOAD:
            s["impedance"][key] = _drawn(rng, middle(spec["impedance"][key]), spec["impedance"][key], v)
        for key, ends in (spec["uncertainty"].get("actuator") or {}).items():
            s["actuator"][key] = _drawn(rng, Fraction(spec["actuator"][key]), ends, v)
        if boxed:
            s["true load"] = {
                key: _drawn(rng, Fraction(spec["plant"][key]), spec["uncertainty"]["box"][key], v) for key in LOAD
            }
        yield s


def perturbed(controller: Json, rng: Random, size: Fraction) -> Json:
    """The controller with every coefficient of Q (or C) wrong by up to `size`, often by all of it."""
    c = copy.deepcopy(controller)
    name = "Q" if c["type"] == "dob" else "C"
    for row in c[name].values():
        row[:] = [str(Fraction(a) * (1 + size * rng.choice([-1, 1, Fraction(rng.randint(-99, 99), 100)]))) for a in row]
    if name == "Q":
        n, d = ([Fraction(a) for a in c["Q"][key]] for key in ("numerator", "denominator"))
        n = [Fraction(0)] * (len(d) - len(n)) + n
        c["C"] = {"numerator": [str(a) for a in n], "denominator": [str(b - a) for a, b in zip(n, d, strict=True)]}
    return c
