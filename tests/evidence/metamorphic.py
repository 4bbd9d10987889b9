"""What must not change, or change in a known way, when a joint is written otherwise: on random joints."""

from __future__ import annotations

import copy
import json
import sys
from collections.abc import Sequence
from fractions import Fraction
from random import Random

from random_specs import Json, certified, parsed, random_spec
from tally import Tally, command
from tampering import sealed

from robimp.synthesis.check import Verdict, check_bytes
from robimp.synthesis.spec import canonical, from_canonical

TITLE = "metamorphic: joints written otherwise"
FULL, SMALL = 300, 8
CLOSE = 1e-3  # how far two searches for the same margin may be apart, relative; proofs are at what is printed
FACTORS = {"eq9", "eq18"}  # claims whose margin is a factor on W


def checked(certificate: Json) -> Verdict:
    return check_bytes(json.dumps(certificate).encode())


def statuses(certificate: Json) -> dict[tuple[str, str], str]:
    return {(c["id"], c["form"]): c["status"] for c in certificate["claims"]}


def margins(certificate: Json) -> dict[tuple[str, str], Fraction]:
    return {(c["id"], c["form"]): Fraction(c["margin"]) for c in certificate["claims"] if c["margin"] is not None}


def _times(text: str, factor: Fraction, power: int) -> str:
    return text if text == "none" else str(Fraction(text) * factor**power)


def _rational(section: Json, a: Fraction) -> Json:
    """`p(s/a)`: the coefficient of s^k over a^k."""
    return {key: [_times(c, a, k - len(row) + 1) for k, c in enumerate(row)] for key, row in section.items()}


def faster(spec: Json, a: Fraction) -> Json:
    """The canonical specification with every frequency times a: s → s/a; stiffnesses and ratios stay."""
    s = copy.deepcopy(spec)
    for load in (s["plant"], s["impedance"]):
        load.update(inertia=_times(load["inertia"], a, -2), damping=_times(load["damping"], a, -1))
    if box := s["uncertainty"]["box"]:
        box["inertia"] = [_times(v, a, -2) for v in box["inertia"]]
        box["damping"] = [_times(v, a, -1) for v in box["damping"]]
    if s["uncertainty"]["weight"]:
        s["uncertainty"]["weight"] = _rational(s["uncertainty"]["weight"], a)
    if s["actuator"]["type"] == "series-elastic":
        actuator, loop = s["actuator"], s["actuator"]["torque_loop"]
        actuator["motor_inertia"] = _times(actuator["motor_inertia"], a, -2)
        actuator["motor_damping"] = _times(actuator["motor_damping"], a, -1)
        loop.update(kd=_times(loop["kd"], a, -1), derivative_corner=_times(loop["derivative_corner"], a, 1))
    s["controller"]["coefficients"] = _rational(s["controller"]["coefficients"], a)
    filters = s["controller"]["filters"]
    filters.update({key: value and _times(value, a, 1) for key, value in filters.items()})
    if eq12 := s["constraints"]["eq12"]:
        eq12["margin"] = _times(eq12["margin"], a, -1)
        eq12["band"] = eq12["band"] and [_times(v, a, 1) for v in eq12["band"]]
    return s


PRINTED = ("eq12", "paper")
POWER = {"stability-free": 1, "stability-locked": 1, "bandwidth": 1, "friction": -1}


def _same(found: Tally, told: str, before: Json, after: Json, a: Fraction = Fraction(1)) -> None:
    """The same verdicts, and margins scaled with time."""
    one, other = statuses(before), statuses(after)
    if a != 1:  # |s + m| has a unit of damping in it, 1·s: (12) as printed is about a port of that unit
        one.pop(PRINTED, None), other.pop(PRINTED, None)
    found.expect(one == other, f"{told}: {one} became {other}")
    old, new = margins(before), margins(after)
    for kind in old.keys() & new.keys() & one.keys():
        power = -1 if kind in (("eq12", "disc"), ("eq12", "structured")) else POWER.get(kind[0], 0)
        power = 0 if kind[1] == "box" else power
        expected = old[kind] * a**power
        gap = abs(float(new[kind] - expected)) / max(abs(float(expected)), 1e-9)
        found.expect(gap < CLOSE, f"{told}: {kind}: {float(expected):.9g} became {float(new[kind]):.9g}")
        found.count("margins compared")
    if a == 1 or not (required := before["spec"]["constraints"]["eq12"]) or required["form"] != "paper":
        found.expect(checked(before).exit_code == checked(after).exit_code, f"{told}: the checker says something else")


def _time(seed: int, spec: Json, certificate: Json, found: Tally) -> None:
    a = Random(seed).choice([Fraction(7), Fraction(1, 64), Fraction(1000, 3)])
    if next(c for c in certificate["claims"] if c["id"] == "bandwidth")["refuted_at"] is None:
        found.count("time not scaled: attenuated at every frequency looked at")
        return
    _same(found, f"{seed}: time over {a}", certificate, certified(from_canonical(faster(spec, a))), a)
    found.count("time scaled")


def _factor(seed: int, spec: Json, certificate: Json, found: Tally) -> None:
    """A stable common factor of numerator and denominator changes no statement but the decay rates."""
    root = Random(seed).choice([Fraction(10**5), Fraction(3), Fraction(777, 10)])
    for factor, stable in (([Fraction(1), root], True), ([Fraction(1), -root], False)):
        s = copy.deepcopy(spec)
        given = s["controller"]["coefficients"]
        for key, row in given.items():
            p = [Fraction(c) for c in row]
            given[key] = [str(x + y * factor[1]) for x, y in zip([*p, 0], [0, *p], strict=True)]
        after = certified(from_canonical(s))
        if stable:
            whole = copy.deepcopy(certificate)
            for c in (whole, after):
                c["claims"] = [claim for claim in c["claims"] if not claim["id"].startswith("stability")]
                c["spec"]["controller"]["coefficients"] = None
            _same(found, f"{seed}: common factor s + {root}", whole, after)
        else:
            unstable = {c["id"] for c in after["claims"] if c["form"] == "hurwitz" and c["status"] == "refuted"}
            found.expect(len(unstable) == 2, f"{seed}: common factor s − {root}: refuted are {unstable}")
            found.expect(checked(after).exit_code == 4, f"{seed}: common factor s − {root} accepted")
    found.count("common factors")


def _order(seed: int, certificate: Json, found: Tally) -> None:
    """Claims and keys in another order."""
    c = copy.deepcopy(certificate)
    Random(seed).shuffle(c["claims"])
    c["claims"] = [dict(reversed(claim.items())) for claim in c["claims"]]
    before, after = checked(certificate), checked(sealed(dict(reversed(c.items()))))
    found.expect(before.exit_code == after.exit_code, f"{seed}: claims in another order: {after.message}")
    found.expect(set(before.claims) == set(after.claims), f"{seed}: claims in another order say something else")
    found.count("claims in another order")


def _bigger(seed: int, spec: Json, certificate: Json, found: Tally) -> None:
    """W times k > 1: nothing refuted becomes proven, and the factors on W are divided by k."""
    if not spec["uncertainty"]["weight"]:
        return
    k, s = Random(seed).choice([Fraction(3, 2), Fraction(10), Fraction(101, 100)]), copy.deepcopy(spec)
    s["uncertainty"]["weight"]["numerator"] = [_times(c, k, 1) for c in s["uncertainty"]["weight"]["numerator"]]
    after = certified(from_canonical(s))
    old, new = statuses(certificate), statuses(after)
    healed = [kind for kind in old if kind in new and old[kind] == "refuted" and new[kind] == "proven"]
    healed = [kind for kind in healed if kind != ("eq12", "paper") or spec["constraints"]["eq12"]]
    found.expect(not healed, f"{seed}: W times {k}: {healed} became true")
    found.count("bigger weights")
    alone = spec["uncertainty"]["box"] is None
    for kind, margin in margins(after).items():
        if alone and kind[0] in FACTORS and kind in margins(certificate):
            expected = float(margins(certificate)[kind] / k)
            found.expect(
                abs(float(margin) / expected - 1) < CLOSE, f"{seed}: {kind}: {expected} became {float(margin)}"
            )
            found.count("factors on W compared")
    for claim in certificate["claims"]:  # also what the checker says, at the old margins
        kind = (claim["id"], claim["form"])
        if kind[0] in FACTORS and alone and kind in margins(certificate):
            forged = copy.deepcopy(after)
            own = next(c for c in forged["claims"] if (c["id"], c["form"]) == kind)
            own.update(status="proven", margin=str(margins(certificate)[kind] / k), refuted_at=None)
            said = {c[:2]: c[2] for c in checked(sealed(forged)).claims}
            found.expect(said.get(kind, "proven") == "proven", f"{seed}: {kind}: the checker does not scale with W")


def examine(seeds: Sequence[int]) -> Tally:
    found = Tally()
    for seed in seeds:
        parsed_spec = parsed(random_spec(seed))
        certificate, spec = certified(parsed_spec), json.loads(json.dumps(canonical(parsed_spec)))
        found.count("joints")
        _order(seed, certificate, found)
        _time(seed, spec, certificate, found)
        _factor(seed, spec, certificate, found)
        _bigger(seed, spec, certificate, found)
    return found


if __name__ == "__main__":
    sys.exit(command(TITLE, examine, FULL))
