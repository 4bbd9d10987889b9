"""Certificates edited anywhere and sealed again: with the specification none passes that says more than is true."""

from __future__ import annotations

import copy
import json
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from fractions import Fraction
from functools import cache
from pathlib import Path
from random import Random
from typing import Any

from judge import judge
from tally import Tally, command
from tampering import sealed, written

from robimp.synthesis.check import check_bytes
from robimp.synthesis.judgement import judge as judged

TITLE = "certificates edited and sealed again"
FULL, SMALL = 4000, 60
SECONDS = 5.0  # allowed to the checker for one certificate
GOLDEN = Path(__file__).parents[1] / "data" / "golden"

Json = Any
Place = tuple[str | int, ...]


@cache
def golden() -> list[tuple[str, Json]]:
    return [(path.stem, json.loads(path.read_bytes())) for path in sorted(GOLDEN.glob("*.json"))]


def places(value: Json, path: Place = ()) -> Iterator[Place]:
    """Every node below the root."""
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, item in items:
        yield (*path, key)
        yield from places(item, (*path, key))


def at(document: Json, path: Place) -> Json:
    for key in path:
        document = document[key]
    return document


def _number(rng: Random, text: str) -> str:
    value = Fraction(text)
    how = rng.random()
    if how < 0.35:
        return str(value * (1 + rng.choice([-1, 1]) * Fraction(1, 10 ** rng.randint(1, 8))))
    if how < 0.5:
        return str(value * Fraction(rng.choice(["2", "1/2", "10", "1/10", "1000", "-1"])))
    if how < 0.65:
        return str(value + rng.choice([-1, 1]) * Fraction(1, 10 ** rng.randint(0, 6)))
    if how < 0.75:
        return rng.choice(["0", "1", "-1", "inf", "1/3", "100"])
    k = rng.randrange(len(text))
    return text[:k] + str(rng.randint(0, 9)) + text[k + 1 :]


def _value(rng: Random, value: Json) -> Json:
    if isinstance(value, bool):
        return not value
    if isinstance(value, str):
        try:
            return _number(rng, value)
        except ValueError:
            words = ["proven", "refuted", "undecided", "structured", "disc", "paper", "eq9", "eq12", "eq18", "peak"]
            words += ["half-plane/physical", "half-plane/frozen", "half-plane", "frozen", "ideal", "dob", "require"]
            return rng.choice([*words, "report", "inf", "none", "friction", "bandwidth", ""])
    if value is None:
        return rng.choice(["0", "1", "2", {}, [], "eq23"])
    if isinstance(value, list) and value:
        return rng.choice([value[1:], value[:-1], value[::-1], value * 2, None])
    return rng.choice([None, {}, []])


def _together(rng: Random, c: Json) -> None:
    """Edits that keep the certificate consistent with itself: what a forger would do."""
    claim = rng.choice(c["claims"])
    how = rng.randrange(6)
    if how == 0:  # the bandwidth, everywhere it is written
        proven = str(Fraction(c["bandwidth"]["proven"]) * (1 + Fraction(rng.randint(-50, 90), 1000)))
        c["bandwidth"].update(proven=proven, refuted_at=None)
        for other in c["claims"]:
            if other["id"] == "bandwidth":
                other.update(margin=proven, refuted_at=None)
            if other["id"] in ("bandwidth", "rendering"):
                other["interval"] = ["0", proven]
    elif how == 1:  # a required claim turned into one that is not, with the specification
        c["spec"]["constraints"][claim["id"] if claim["id"] in c["spec"]["constraints"] else "peak"] = None
        claim["required"] = False
    elif how == 2 and claim["margin"] is not None:  # a margin without the twin that contradicts it
        claim.update(margin=_number(rng, claim["margin"]), refuted_at=None)
    elif how == 3:  # the controller, Q and C together
        pair = c["controller"].get("Q", c["controller"]["C"])
        k = rng.randrange(len(pair["denominator"]))
        pair["denominator"][k] = str(Fraction(pair["denominator"][k]) * (1 + Fraction(rng.randint(-99, 99), 1000)))
        if "Q" in c["controller"]:
            n, d = ([Fraction(v) for v in pair[key]] for key in ("numerator", "denominator"))
            below = [b - a for a, b in zip([Fraction(0)] * (len(d) - len(n)) + n, d, strict=True)]
            while len(below) > 1 and below[0] == 0:
                below.pop(0)
            c["controller"]["C"] = {"numerator": [str(a) for a in n], "denominator": [str(a) for a in below]}
        if c["spec"]["controller"]["coefficients"] and rng.random() < 0.7:
            c["spec"]["controller"]["coefficients"] = copy.deepcopy(pair)
    elif how == 4:
        c["claims"].remove(claim)
    else:  # refuted or undecided written as proven, and the other way round
        proven = claim["status"] != "proven"
        claim.update(status="proven" if proven else "undecided", margin="1" if proven else None, refuted_at=None)


def edited(seed: int) -> tuple[str, Json, Json]:
    """What was edited, the certificate it was, and the sealed result."""
    rng = Random(seed)
    name, original = golden()[seed % len(golden())]
    c, told = copy.deepcopy(original), []
    edits = rng.choice([1, 1, 1, 2])
    if rng.random() < 0.35:
        _together(rng, c)
        told.append("together")
        edits -= 1
    for _ in range(edits):
        section = rng.choice(["spec", "controller", "claims", "claims", "bandwidth"])
        path = rng.choice([(section, *p) for p in places(c[section])])
        place = at(c, path[:-1])
        if rng.random() < 0.05:
            del place[path[-1]]
        else:
            place[path[-1]] = _value(rng, place[path[-1]])
        told.append(".".join(map(str, path)))
    return f"{seed} {name}: {', '.join(told)}", original, sealed(c) if isinstance(c["claims"], list) else c


def without_null(value: Json) -> Json:
    """An absent option and one that is null mean the same."""
    if isinstance(value, dict):
        return {key: without_null(item) for key, item in value.items() if item is not None}
    return value


def examine(seeds: Sequence[int]) -> Tally:
    found = Tally()
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "certificate.json"
        for seed in seeds:
            told, original, changed = edited(seed)
            found.count("certificates")
            if changed == original:
                found.count("  of these as before")
                continue
            file.write_bytes(written(changed))
            began = time.process_time()
            verdict = check_bytes(file.read_bytes(), time_limit=SECONDS)
            found.measure("seconds of one check", time.process_time() - began)
            found.count(f"without the specification: exit code {verdict.exit_code}")
            told_with_spec = judged(str(file), file.read_bytes(), original["spec"], None, SECONDS)
            code, message = told_with_spec.exit_code, told_with_spec.message
            found.count(f"with the specification: exit code {int(code)}")
            if verdict.exit_code == 0:
                _, faults = judge(changed, seed, points=300)
                found.count("accepted without it, and true by floats", not faults)
                for fault in faults:
                    found.fault(f"{told}: accepted, but {fault}")
            if code == 0:
                same = without_null(changed["spec"]) == without_null(original["spec"])
                found.expect(same, f"{told}: another specification accepted: {message}")
                missing = {c["id"] for c in original["claims"] if c["required"]} - {c["id"] for c in changed["claims"]}
                found.expect(not missing, f"{told}: accepted without {missing}")
                found.count(f"accepted with it, true: {_kind(changed, original)}")
    return found


def _kind(changed: Json, original: Json) -> str:
    """What distinguishes an accepted certificate of the same specification from the one it was made of."""
    if changed["controller"] != original["controller"]:
        return "another controller"
    now, before = ({(c["id"], c["form"]): c for c in d["claims"]} for d in (changed, original))
    if set(now) != set(before):
        return "a claim nobody asked for left out"
    for key in ("status", "margin", "interval"):
        if any(now[kind][key] != before[kind][key] for kind in now):
            return f"another {key}"
    return "a witness, or a text that is not checked"


if __name__ == "__main__":
    sys.exit(command(TITLE, examine, FULL))
