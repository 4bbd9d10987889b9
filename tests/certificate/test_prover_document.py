"""The certificate's text: canonical numbers, digests, and what an edited and re-sealed one can still say."""

from __future__ import annotations

import copy
import hashlib
import json
import re
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from typing import Any

import pytest
from certificate_joints import PAPER_Q, rational, reference

from robimp.models.rational import exact
from robimp.synthesis.certificate.claims import certify
from robimp.synthesis.certificate.document import document, verdict
from robimp.synthesis.certificate.enclosure.exclusion import excluded
from robimp.synthesis.certificate.enclosure.joint import family_of
from robimp.synthesis.certificate.enclosure.prover import CellProver
from robimp.synthesis.certificate.hurwitz import is_hurwitz
from robimp.synthesis.certificate.outcome import Outcome
from robimp.synthesis.certificate.prover import Prover, Subject
from robimp.synthesis.check import check_bytes
from robimp.synthesis.problem.constraints import constraints
from robimp.synthesis.problem.setting import Setting
from robimp.synthesis.spec import canonical, canonical_json, from_canonical, spec_sha256

NUMBER = re.compile(r"-?(0|[1-9][0-9]*)(/[1-9][0-9]*)?")
Path = tuple[str | int, ...]


def written(**changes: Any) -> dict[str, Any]:
    setting, C = reference(**changes)
    claims = certify(setting, C)
    return document(setting, rational(*PAPER_Q), claims, bound=Fraction(51, 1), producer={"robimp": "test"})


REFERENCE = written()


def sealed(body: dict[str, Any]) -> bytes:
    """Digests and end record made anew, as a forger would."""
    body = {key: part for key, part in body.items() if key != "end"}
    body["spec_sha256"] = hashlib.sha256(canonical_json(body["spec"])).hexdigest()
    end = {"claims": len(body["claims"]), "body_sha256": hashlib.sha256(canonical_json(body)).hexdigest()}
    return json.dumps({**body, "end": end}).encode()


def leaves(value: Any, path: Path = ()) -> Iterator[tuple[Path, Any]]:
    if isinstance(value, dict):
        for key, item in value.items():
            yield from leaves(item, (*path, key))
    elif isinstance(value, list):
        for k, item in enumerate(value):
            yield from leaves(item, (*path, k))
    else:
        yield path, value


def numbers(certificate: dict[str, Any]) -> list[Path]:
    words = {"equation", "statement", "uncertainty", "form", "id", "name", "robimp"}
    return [p for p, v in leaves(certificate) if isinstance(v, str) and NUMBER.fullmatch(v) and p[-1] not in words]


def put(certificate: dict[str, Any], path: Path, value: str) -> dict[str, Any]:
    changed = copy.deepcopy(certificate)
    place: Any = changed
    for key in path[:-1]:
        place = place[key]
    place[path[-1]] = value
    return changed


def get(certificate: dict[str, Any], path: Path) -> str:
    place: Any = certificate
    for key in path:
        place = place[key]
    return place


def test_numbers_are_exact_text_in_lowest_terms():
    found = numbers(REFERENCE)
    assert len(found) > 60
    for path in found:
        text = get(REFERENCE, path)
        assert str(Fraction(text)) == text
    assert not any(isinstance(v, float) for _, v in leaves(REFERENCE))


def test_digests_are_of_the_canonical_text():
    body = {key: part for key, part in REFERENCE.items() if key != "end"}
    assert REFERENCE["end"] == {
        "claims": len(body["claims"]),
        "body_sha256": hashlib.sha256(canonical_json(body)).hexdigest(),
    }
    spec = from_canonical(REFERENCE["spec"])
    assert (canonical(spec), spec_sha256(spec)) == (REFERENCE["spec"], REFERENCE["spec_sha256"])
    assert written() == REFERENCE  # the same twice
    assert sealed(REFERENCE) == json.dumps(REFERENCE).encode()


def test_controller_is_the_given_one_and_its_compensator_uncancelled():
    controller = REFERENCE["controller"]
    assert controller["Q"] == {"numerator": ["2000"], "denominator": ["1", "283/4", "2500"]}
    assert controller["C"] == {"numerator": ["2000"], "denominator": ["1", "283/4", "500"]}


def test_bandwidth_stands_beside_its_claim():
    claim = next(c for c in REFERENCE["claims"] if c["id"] == "bandwidth")
    band = REFERENCE["bandwidth"]
    assert (band["proven"], band["refuted_at"], band["bound"]) == (claim["margin"], claim["refuted_at"]["value"], "51")
    assert claim["interval"] == ["0", band["proven"]]


def test_verdict_is_that_of_the_required_claims():
    claims = certify(*reference())
    assert verdict(claims) is Outcome.PROVEN
    assert any(c.status is Outcome.REFUTED and not c.required for c in claims)  # reported, not required
    failing = certify(*reference(impedance={"damping": "0.25", "stiffness": "3"}))
    assert verdict(failing) is Outcome.REFUTED


def one_digit(text: str, place: int) -> str:
    """The number with one digit of its text replaced, in lowest terms again."""
    digits = [k for k, c in enumerate(text) if c.isdigit()]
    k = digits[place % len(digits)]
    new = str((int(text[k]) + 1) % 10)
    try:
        return str(Fraction(text[:k] + new + text[k + 1 :]))
    except ZeroDivisionError:
        return text


def reproven(certificate: dict[str, Any]) -> bool:
    """Whether the prover itself, from the edited specification and controller, proves every claim as it is written."""
    setting = Setting.of(from_canonical(certificate["spec"]))
    Q = certificate["controller"]["Q"]
    C = setting.compensator(rational(Q["numerator"], Q["denominator"]))
    prover = Prover.of(Subject(setting, C))
    known = {(c.id, c.form): c for c in constraints(setting)}
    pencils = {"stability-free": setting.loop.free(setting.loop.nominal), "stability-locked": setting.loop.locked()}
    for claim in certificate["claims"]:
        if claim["status"] != "proven":
            continue
        v = Fraction(claim["margin"])
        if claim["form"] == "hurwitz":
            holds = is_hurwitz(pencils[claim["id"]](C), exact(v))
        elif claim["form"] == "box":
            holds = excluded(CellProver(replace(family_of(setting, C), spread=v, loads=True)), "free")
        else:
            low, high = claim["interval"]
            band = (Fraction(low), None if high == "inf" else Fraction(high))
            level = setting.spec.objective.attenuation if claim["id"] == "bandwidth" else v
            constraint = replace(known[claim["id"], claim["form"]], band=band)
            holds = prover.decide(constraint, level) is Outcome.PROVEN
        if not holds:
            return False
    return True


@pytest.mark.parametrize("path", numbers(REFERENCE), ids=lambda p: ".".join(map(str, p)))
def test_a_changed_digit_is_caught_or_the_claim_is_true(path):
    changed = put(REFERENCE, path, one_digit(get(REFERENCE, path), len(path)))
    assert changed != REFERENCE
    assert check_bytes(json.dumps(changed).encode()).exit_code == 2  # the digest sees it
    if check_bytes(sealed(changed)).exit_code == 0:
        assert reproven(changed)


def test_most_changed_digits_are_caught():
    """Control of the test above: it is not that everything passes, nor that nothing does."""
    codes = [
        check_bytes(sealed(put(REFERENCE, p, one_digit(get(REFERENCE, p), len(p))))).exit_code
        for p in numbers(REFERENCE)
    ]
    assert codes.count(0) < len(codes) / 2
    assert codes.count(0) > 0
    assert {4, 6} <= set(codes)


@pytest.mark.parametrize("kind", ["eq9", "eq12", "peak", "stability-free", "bandwidth"])
def test_a_larger_claim_is_caught(kind):
    changed = copy.deepcopy(REFERENCE)
    claim = next(c for c in changed["claims"] if c["id"] == kind)
    claim["margin"] = claim["refuted_at"]["value"]
    if kind == "bandwidth":
        old, changed["bandwidth"]["proven"] = changed["bandwidth"]["proven"], claim["margin"]
        for other in changed["claims"]:
            other["interval"] = ["0", claim["margin"]] if other["interval"] == ["0", old] else other["interval"]
    assert check_bytes(sealed(changed)).exit_code == 4
