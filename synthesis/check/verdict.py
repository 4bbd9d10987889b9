"""From bytes to a verdict: read, compare with the specification, re-prove every claim."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from decimal import ROUND_FLOOR, Context, Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any

from .joint import Joint, Load, joint
from .outcome import Clock, FalseClaimError, MismatchError, UndecidedError, UnreadableError
from .positivity import Point, decide, holds_at, square
from .reader import MAX_BYTES, read
from .requirements import SIGNED, WHOLE, compare, threshold, title
from .statements import STATEMENTS, Fact, Query

PROVEN, INPUT, REFUTED, UNDECIDED, MISMATCH = 0, 2, 4, 5, 6
EXIT_CODES = {UnreadableError: INPUT, FalseClaimError: REFUTED, UndecidedError: UNDECIDED, MismatchError: MISMATCH}


@dataclass(frozen=True)
class Verdict:
    """What the checker found: exit code, one line, ω_B rounded down if everything required is proven, every claim."""

    exit_code: int
    message: str
    omega_b: str | None = None
    claims: tuple[tuple[str, str, str, str], ...] = ()  # (id, form, status, message)


def check_file(path: str | Path, *, time_limit: float = 60.0) -> Verdict:
    """Re-prove the certificate in a file; `time_limit` in seconds."""
    try:
        with Path(path).open("rb") as stream:
            data = stream.read(MAX_BYTES + 1)
    except (OSError, ValueError) as error:
        return Verdict(INPUT, f"file: cannot be read: {getattr(error, 'strerror', None) or error}")
    return check_bytes(data, time_limit=time_limit)


def check_bytes(data: bytes, *, time_limit: float = 60.0) -> Verdict:
    """Re-prove every claim of a certificate from its specification and controller alone; `time_limit` in seconds."""
    clock = Clock(time_limit)
    try:
        certificate = read(data)
        compare(certificate)
        model = joint(certificate, clock)
    except tuple(EXIT_CODES) as error:
        return Verdict(EXIT_CODES[type(error)], str(error))
    outcomes = [_outcome(_check, certificate, model, claim, clock) for claim in certificate["claims"]]
    outcomes.append(_outcome(_bandwidth_twin, certificate))
    claims = tuple(
        (claim["id"], claim["form"], claim["status"] if code == PROVEN else "not verified", message)
        for claim, (code, message) in zip(certificate["claims"], outcomes, strict=False)
    )
    for code in (REFUTED, MISMATCH, UNDECIDED):
        if message := next((message for found, message in outcomes if found == code), None):
            return Verdict(code, message, None, claims)
    proven = sum(claim["status"] == "proven" for claim in certificate["claims"])
    omega_b = decimal(certificate["bandwidth"]["proven"])
    return Verdict(PROVEN, f"ω_B ≥ {omega_b} rad/s  {proven} claims", omega_b, claims)


def decimal(value: Fraction) -> str:
    """Six significant digits, rounded down."""
    quotient = Context(prec=6, rounding=ROUND_FLOOR).divide(Decimal(value.numerator), Decimal(value.denominator))
    text = format(quotient, "f")
    return text.rstrip("0").rstrip(".") if "." in text else text


def _outcome(step: Callable[..., str], *arguments: Any) -> tuple[int, str]:
    try:
        return PROVEN, step(*arguments)
    except tuple(EXIT_CODES) as error:
        return EXIT_CODES[type(error)], str(error)


def _bandwidth_twin(certificate: dict[str, Any]) -> str:
    """`bandwidth.refuted_at` says the same as the bandwidth claim."""
    twin = next(claim["refuted_at"] for claim in certificate["claims"] if claim["id"] == "bandwidth")
    if certificate["bandwidth"]["refuted_at"] != (twin and twin["value"]):
        raise FalseClaimError("bandwidth.refuted_at: is not the bandwidth claim's")
    return ""


def _check(certificate: dict[str, Any], model: Joint, claim: dict[str, Any], clock: Clock) -> str:
    """Re-prove one claim and re-verify its witness."""
    name, spec = title(claim), certificate["spec"]

    def query(v: Fraction, load: Load | None = None) -> Query:
        ends, attenuation = claim["interval"] == WHOLE, spec["objective"]["attenuation"]
        return Query(model, claim["form"], v, load, ends, attenuation, clock)

    try:
        if claim["status"] == "proven":
            _prove(claim, query(claim["margin"]))
        if claim["refuted_at"] is not None:
            _refute(spec, claim, model, query)
    except (FalseClaimError, UndecidedError, MismatchError) as error:
        raise type(error)(f"{name}: {error}") from None
    if claim["required"] and claim["status"] == "refuted":
        raise FalseClaimError(f"{name}: required, and refuted{_where(claim['refuted_at']['omega'])}")
    if claim["required"] and claim["status"] == "undecided":
        raise UndecidedError(f"{name}: required, and undecided")
    return f"{name}: {claim['status']}"


def _prove(claim: dict[str, Any], query: Query) -> None:
    """The statement at its margin, on its interval."""
    lo, hi = map(square, claim["interval"])
    undecided = False
    for part in STATEMENTS[claim["id"]][1](query):
        if isinstance(part, Fact):
            if not part.holds:
                raise FalseClaimError(f"does not hold: {part.text}")
            continue
        result = decide(part, lo, hi, query.clock)
        if result.status == "refuted":
            raise FalseClaimError(f"does not hold at its margin near ω = {_omega(result.at)} rad/s")
        undecided |= result.status == "undecided"
    if undecided:
        raise UndecidedError("neither proven nor refuted")


def _refute(spec: dict[str, Any], claim: dict[str, Any], model: Joint, query: Callable[..., Query]) -> None:
    """The witness: the statement fails at `value`, at `omega`, for `load`."""
    witness, limit = claim["refuted_at"], threshold(spec, claim)
    v, load = witness["value"], witness["load"] and tuple(witness["load"].values())
    if v < 0 and (claim["id"], claim["form"]) not in SIGNED:
        raise FalseClaimError("refuted_at.value: negative")
    if claim["status"] == "refuted" and limit is not None and v != limit:
        raise FalseClaimError("refuted_at.value: is not the required one")
    if load is not None and not _member(model, load, spec):
        raise FalseClaimError("refuted_at.load: is not in the box")
    hurwitz = claim["form"] == "hurwitz"
    if hurwitz != (witness["omega"] is None):
        raise FalseClaimError("refuted_at.omega: does not fit the claim")
    omega = None if hurwitz else witness["omega"][0]
    lo, hi = (v, v) if claim["id"] == "bandwidth" else claim["interval"]
    if not hurwitz and not (hi is None if omega is None else lo <= omega and (hi is None or omega <= hi)):
        raise FalseClaimError("refuted_at.omega: is outside the interval")
    unclear = False
    for part in STATEMENTS[claim["id"]][1](query(v, load)):
        if isinstance(part, Fact):
            place = {"0": Fraction(0), "inf": None}.get(part.at or "", omega)
            holds: bool | None = part.holds or place != omega
        else:
            holds = True if len(part.bound) > 1 else holds_at(part, square(omega))
        if holds is False:
            return
        unclear |= holds is None
    raise UndecidedError("refuted_at: cannot be told") if unclear else FalseClaimError("refuted_at: it holds there")


def _member(model: Joint, load: Load, spec: dict[str, Any]) -> bool:
    if model.box is None:
        return load == tuple(spec["plant"].values())
    return all(lo <= part <= hi for part, (lo, hi) in zip(load, model.box, strict=True))


def _omega(x: Point | None) -> str:
    if x is None:
        return "?"
    return "inf" if x[1] == 0 else format((Decimal(x[0]) / Decimal(x[1])).sqrt(), ".6g")


def _where(omega: tuple[Fraction | None] | None) -> str:
    if omega is None:
        return ""
    return f" at ω = {'inf' if omega[0] is None else decimal(omega[0])} rad/s"
