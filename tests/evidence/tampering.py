"""Tampered twins of a valid certificate: each with the exit code it must get, and why."""

from __future__ import annotations

import copy
import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from hashlib import sha256
from typing import Any

Json = Any
UNREADABLE, FALSE, UNDECIDED, MISMATCH = 2, 4, 5, 6


@dataclass(frozen=True)
class Twin:
    """A file that must not pass."""

    name: str
    data: bytes
    exit_code: int
    why: str


def canonical(value: Json) -> bytes:
    return json.dumps(value, sort_keys=True, separators=(",", ":"), ensure_ascii=True, allow_nan=False).encode()


def sealed(certificate: Json) -> Json:
    """Both digests and the count of claims made right again, whatever was edited."""
    body = {key: part for key, part in certificate.items() if key != "end"}
    body["spec_sha256"] = sha256(canonical(body["spec"])).hexdigest()
    return {**body, "end": {"claims": len(body["claims"]), "body_sha256": sha256(canonical(body)).hexdigest()}}


def written(certificate: Json) -> bytes:
    return json.dumps(certificate, indent=1).encode() + b"\n"


def scaled(text: str, factor: str) -> str:
    return str(Fraction(text) * Fraction(factor))


def claimed(data: bytes) -> bytes:
    """A certificate in which what is required and refuted is claimed to be proven, just as asked."""
    certificate = json.loads(data)
    for claim in certificate["claims"]:
        if claim["required"] and claim["status"] == "refuted":
            claim.update(status="proven", margin=claim["refuted_at"]["value"], refuted_at=None)
    return written(sealed(certificate))


def find(certificate: Json, id: str) -> Json:
    return next(claim for claim in certificate["claims"] if claim["id"] == id)


def _bytes(data: bytes) -> Iterator[tuple[str, bytes, str]]:
    """Damage below the format: name, bytes, why."""
    text = data.decode()
    margin = '"margin": "'
    at = text.index(margin) + len(margin)
    digit = str((int(text[at]) % 9) + 1) if text[at].isdigit() else "1"
    yield "empty", b"", "nothing in it"
    yield "truncated", data[: len(data) * 2 // 3], "the second part of the file is missing"
    yield "last-byte", data.rstrip()[:-1], "the closing brace is missing"
    yield "garbage", data + b"x", "something after the end"
    yield "twice", data + data, "two certificates in one file"
    yield "digit-flipped", (text[:at] + digit + text[at + 1 :]).encode(), "one digit of a margin; the digest differs"
    yield "duplicate-key", text.replace('"bound":', '"bound": null, "bound":', 1).encode(), "a key twice"
    yield "float", text.replace('"robimp_certificate": 1', '"robimp_certificate": 1.0').encode(), "a JSON float"
    yield "nan", text.replace('"bound": null', '"bound": NaN').encode(), "NaN is not JSON"
    yield "infinity", text.replace('"bound": null', '"bound": Infinity').encode(), "Infinity is not JSON"
    yield "utf-16", data.decode().encode("utf-16"), "not UTF-8"
    yield "latin-1", data.replace(b"ideal", b"id\xe9al", 1), "not UTF-8"
    yield "nested", b"[" * 5000 + b"]" * 5000, "nested deeper than the format"
    yield "array", b"[" + data + b"]", "an array, not an object"
    yield "null", b"null\n", "no object"


Edit = Callable[[Json], object]


def _set(*path: str | int, value: Json) -> Edit:
    def edit(certificate: Json) -> None:
        place = certificate
        for key in path[:-1]:
            place = place[key]
        place[path[-1]] = value

    return edit


def _claim(id: str, /, **changes: Json) -> Edit:
    return lambda certificate: find(certificate, id).update(changes)


def _moved(id: str, factor: str) -> Edit:
    return lambda certificate: find(certificate, id).update(margin=scaled(find(certificate, id)["margin"], factor))


def _wider(certificate: Json) -> None:
    _narrower("11/10")(certificate)


def _narrower(factor: str) -> Edit:
    return lambda certificate: _banded(certificate, scaled(certificate["bandwidth"]["proven"], factor))


def _banded(certificate: Json, proven: str) -> None:
    certificate["bandwidth"].update(proven=proven, refuted_at=None)
    for claim in certificate["claims"]:
        if claim["id"] == "bandwidth":
            claim.update(margin=proven, interval=["0", proven], refuted_at=None)
        if claim["id"] == "rendering":
            claim.update(interval=["0", proven], refuted_at=None)


def _without(id: str) -> Edit:
    return lambda certificate: certificate["claims"].remove(find(certificate, id))


TEXTS = {
    "decimal": ("0.3", "a decimal"),
    "exponent": ("3e-1", "an exponent"),
    "not-lowest": ("6/20", "not in lowest terms"),
    "over-one": ("1/1", "a denominator of 1"),
    "minus-zero": ("-0", "minus zero"),
    "leading-zero": ("03/10", "a leading zero"),
    "plus": ("+3/10", "a plus sign"),
    "space": ("3/10 ", "a space"),
    "other-digits": ("٣/10", "digits of another script"),
    "zero-denominator": ("1/0", "a zero denominator"),
    "double-minus": ("3/-10", "a negative denominator"),
    "empty-number": ("", "no number"),
    "nan-text": ("NaN", "no number"),
    "inf-text": ("inf", "infinity where a number is meant"),
    "huge": ("1" * 100_000 + "/3", "100,000 digits"),
    "negative": ("-3/10", "a negative damping"),
}


def _format(c: Json) -> Iterator[tuple[str, Edit, str]]:
    """Fields that the format does not allow, sealed again: name, edit, why; all unusable."""
    yield "version-2", _set("robimp_certificate", value=2), "a version this checker does not know"
    yield "version-true", _set("robimp_certificate", value=True), "true is not 1"
    yield "spec-version", _set("spec", "robimp", value=2), "a specification of another version"
    yield "unknown-field", _set("note", value="trust me"), "an unknown field"
    yield "unknown-spec-field", _set("spec", "plant", "mass", value="1"), "an unknown field in the specification"
    yield "unknown-claim-field", _claim("peak", proof="trust me"), "an unknown field in a claim"
    yield "missing-field", lambda c: find(c, "peak").pop("interval"), "a claim without an interval"
    yield "number-as-integer", _set("spec", "plant", "damping", value=3), "a number that is no text"
    for name, (text, why) in TEXTS.items():
        yield name, _set("spec", "plant", "damping", value=text), why
    yield "zero-polynomial", _set("controller", "C", "denominator", value=["0", "0"]), "C has a zero denominator"
    yield "no-coefficients", _set("controller", "C", "denominator", value=[]), "C has no denominator"
    yield "degree", _set("controller", "C", "denominator", value=["1"] * 200), "a degree above the limit"
    yield "claim-twice", lambda c: c["claims"].append(find(c, "peak")), "a claim twice"
    yield "claim-renamed", _claim("peak", id="peek"), "a claim that does not exist"
    yield "form-renamed", _claim("peak", form="relaxed"), "a form that does not exist"
    yield "status", _claim("peak", status="trusted"), "a status that does not exist"
    yield "no-margin", _claim("peak", margin=None), "proven without a margin"
    yield "interval-reversed", _claim("peak", interval=["2", "1"]), "an interval whose low end is above"
    yield "interval-three", _claim("peak", interval=["0", "1", "inf"]), "an interval of three ends"
    yield "box-off", _box_off, "a box without the nominal load"
    yield (
        "unstable-weight",
        _set("spec", "uncertainty", "weight", value={"numerator": ["1/9"], "denominator": ["1", "-1"]}),
        "an unstable weight",
    )


def _meaning(c: Json) -> Iterator[tuple[str, Edit, int, str]]:
    """What the format allows but is not true, or not enough, sealed again: name, edit, exit code, why."""
    ids = [claim["id"] for claim in c["claims"] if claim["required"]]
    for id in dict.fromkeys(ids):
        yield f"without-{id}", _without(id), MISMATCH, f"the required claim {id} is missing"
    for id in ("stability-free", "stability-locked", "eq9", "eq18"):
        if id in ids and Fraction(find(c, id)["margin"]) > 0:
            yield f"{id}-raised", _moved(id, "11/10"), FALSE, f"{id} at a margin at which it fails"
    if "peak" in ids:
        yield "peak-lowered", _moved("peak", "9/10"), FALSE, "a peak lower than the true one"
    if "noise" in ids:
        yield "noise-lowered", _moved("noise", "9/10"), FALSE, "less noise than the true gain"
    if "tolerance" in ids:
        yield "tolerance-raised", _moved("tolerance", "3/2"), FALSE, "a tolerance beyond the one that breaks a claim"
    if "friction" in ids:
        yield "friction-zero", _claim("friction", margin="0", refuted_at=None), FALSE, "friction needs a margin above 0"
    yield "bandwidth-zero", _narrower("0"), MISMATCH, "no bandwidth at all"
    yield "bandwidth-raised", _wider, FALSE, "a bandwidth 10 % above the true one"
    yield "not-required", _claim("bandwidth", required=False), MISMATCH, "a required claim said not to be"
    yield (
        "stability-undecided",
        _claim("stability-free", status="undecided", margin=None, refuted_at=None),
        UNDECIDED,
        "a required claim is undecided",
    )
    yield "no-claims", lambda c: c["claims"].clear(), MISMATCH, "no claims at all"


def _meaning_of_base(c: Json) -> Iterator[tuple[str, Edit, int, str]]:
    yield "eq9-below-1", _claim("eq9", margin="999/1000", refuted_at=None), MISMATCH, "less than was asked for"
    yield "peak-above", _claim("peak", margin="3", refuted_at=None), MISMATCH, "a peak above what was asked for"
    yield "narrower", _claim("eq9", interval=["1", "inf"]), MISMATCH, "an interval narrower than was asked for"
    yield "on-a-band", _claim("eq12", interval=["0", "100"]), MISMATCH, "passivity on a band; the whole axis was asked"
    yield "claimed-negative", _claim("peak", margin="-2", refuted_at=None), FALSE, "a negative peak"
    yield (
        "box-wider",
        _set("spec", "uncertainty", "box", "damping", value=["1/1000", "3"]),
        FALSE,
        "a box for which the claims do not hold",
    )
    yield "other-plant", _set("spec", "plant", "stiffness", value="5/2"), FALSE, "claims of another plant"
    yield "other-c", _set("controller", "C", "numerator", value=["2001"]), MISMATCH, "C is not Q/(1 − Q)"
    yield "other-q", _other_q, MISMATCH, "not the controller the specification gives"
    yield "free-q", _free_q, FALSE, "another Q than the claims are about"
    yield "witness-elsewhere", _witness(omega="1/1000"), FALSE, "a witness at which the claim holds"
    yield "witness-easier", _witness(value="10"), FALSE, "a witness for a value at which the claim holds"
    yield "load-outside", _load_outside, FALSE, "a witness with a load outside the box"
    yield "bandwidth-apart", _set("bandwidth", "proven", value="1"), MISMATCH, "not the margin of the claim"
    yield "feedback", _set("controller", "type", value="dynamic-feedback"), UNREADABLE, "Q given for a feedback"


def _other_q(c: Json, keep: bool = True) -> None:
    n, d = ["1800"], ["1", "283/4", "2500"]
    c["controller"].update(
        Q={"numerator": n, "denominator": d}, C={"numerator": n, "denominator": ["1", "283/4", "700"]}
    )
    if not keep:
        c["spec"]["controller"]["coefficients"] = {"numerator": n, "denominator": d}


def _free_q(c: Json) -> None:
    _other_q(c, keep=False)


def _witness(**changes: str) -> Edit:
    def edit(c: Json) -> None:
        find(c, "peak")["refuted_at"].update(changes)

    return edit


def _box_off(c: Json) -> None:
    c["spec"]["uncertainty"]["box"]["inertia"] = ["1", "2"]
    for claim in c["claims"]:  # nothing else is wrong with it
        claim["refuted_at"] = None
    c["bandwidth"]["refuted_at"] = None


def _load_outside(c: Json) -> None:
    find(c, "eq9")["refuted_at"]["load"] = {"inertia": "1", "damping": "3/10", "stiffness": "2"}


def weaker(c: Json) -> Iterator[tuple[str, Edit, str]]:
    """True statements weaker than the certificate's, at the very edge of what its specification asks for."""
    required = {claim["id"] for claim in c["claims"] if claim["required"]}
    for id, level in (("peak", c["spec"]["constraints"]["peak"]), ("eq9", "1"), ("eq18", "1")):
        if id in required:
            yield f"{id}-at-the-limit", _claim(id, margin=level, refuted_at=None), f"{id} at exactly what is asked for"
    if (eq12 := c["spec"]["constraints"]["eq12"]) and eq12["form"] != "paper":
        yield "eq12-at-the-limit", _claim("eq12", margin=eq12["margin"], refuted_at=None), "eq12 at what is asked for"
    yield "no-decay", _claim("stability-free", margin="0", refuted_at=None), "stable, and no more said"
    yield "narrow", _narrower("1/2"), "half the bandwidth"


def valid(data: bytes) -> Iterator[Twin]:
    """Certificates that must pass, made of one that does."""
    certificate = json.loads(data)
    for name, edit, why in weaker(certificate):
        changed = copy.deepcopy(certificate)
        edit(changed)
        yield Twin(name, written(sealed(changed)), 0, why)


def twins(data: bytes, every: bool) -> Iterator[Twin]:
    """The tampered twins of a valid certificate: those that fit any, or every one there is."""
    certificate = json.loads(data)

    def edited(edit: Edit) -> bytes:
        changed = copy.deepcopy(certificate)
        edit(changed)
        return written(sealed(changed))

    if every:
        yield from (Twin(name, damaged, UNREADABLE, why) for name, damaged, why in _bytes(data))
        yield from (Twin(name, edited(edit), UNREADABLE, why) for name, edit, why in _format(certificate))
        yield from (Twin(name, edited(edit), code, why) for name, edit, code, why in _meaning_of_base(certificate))
    for name, edit, code, why in _meaning(certificate):
        if every or name in (
            "bandwidth-raised",
            "eq9-raised",
            "peak-lowered",
            "noise-lowered",
            "tolerance-raised",
            "without-tolerance",
            "without-stability-free",
            "friction-zero",
        ):
            yield Twin(name, edited(edit), code, why)
