"""From bytes to a verdict: read, compare with the specification, re-prove every claim."""

import time
from dataclasses import dataclass
from decimal import ROUND_FLOOR, Context, Decimal
from fractions import Fraction
from itertools import chain
from pathlib import Path
from typing import Any

from .joint import Joint, stiffness
from .outcome import FALSE, MISMATCH, UNDECIDED, UNREADABLE, CheckError, demand
from .polynomials import Poly
from .positivity import counterexample, square
from .reader import MAX_BYTES, read
from .requirements import SIGNED, WHOLE, Interval, compare
from .statements import STATEMENTS, port_ends


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
        return Verdict(UNREADABLE, f"file: cannot be read: {getattr(error, 'strerror', None) or error}")
    return check_bytes(data, time_limit=time_limit)


def check_bytes(data: bytes, *, time_limit: float = 60.0) -> Verdict:
    """Re-prove every claim of a certificate from its specification and controller alone; `time_limit` in seconds."""
    deadline = time.monotonic() + time_limit
    try:
        certificate = read(data)
        compare(certificate)
        joint = Joint(certificate, deadline)
    except CheckError as error:
        return Verdict(error.code, str(error))
    claims, stops = [], []
    for claim in certificate["claims"]:
        name, status = f"{claim['id']} {claim['form']}", claim["status"]
        message = f"{name}: {status}"
        try:
            _check(joint, claim)
        except CheckError as error:
            status, message = "not verified", f"{name}: {error}"
            stops.append((error.code, message))
        claims.append((claim["id"], claim["form"], status, message))
    if stops:  # the gravest, and of these the first
        return Verdict(*min(stops, key=lambda stop: (FALSE, MISMATCH, UNDECIDED).index(stop[0])), None, tuple(claims))
    proven = sum(claim["status"] == "proven" for claim in certificate["claims"])
    exact, six_digits = certificate["bandwidth"]["proven"], Context(prec=6, rounding=ROUND_FLOOR)
    omega_b = f"{six_digits.divide(Decimal(exact.numerator), Decimal(exact.denominator)).normalize():f}"
    return Verdict(0, f"ω_B ≥ {omega_b} rad/s  {proven} claims", omega_b, tuple(claims))


def _check(joint: Joint, claim: dict[str, Any]) -> None:
    """Re-prove one claim at its margin, and verify that it fails at its witness."""
    required, status, interval, witness = (claim[key] for key in ("required", "status", "interval", "refuted_at"))
    if status == "proven":
        fault = _fault(joint, claim, claim["margin"], interval)
        demand(not fault, f"does not hold{fault}", FALSE)
    if witness is not None:
        v, omega, load = witness.values()
        place = interval if omega is None else (omega, omega)
        fault = _fault(joint, claim, v, place, load and stiffness(load.values()))
        demand(fault != "", "refuted_at: it holds there", FALSE)
        demand(not required or status != "refuted", f"required, and refuted{fault}", FALSE)
    demand(not required or status != "undecided", "required, and undecided", UNDECIDED)


def _fault(joint: Joint, claim: dict[str, Any], v: Fraction, interval: Interval, load: Poly | None = None) -> str:
    """Where the statement fails at v, as text; empty if it is proven. Undecided only if no part fails."""
    kind, undecided = (claim["id"], claim["form"]), None
    lo, hi = map(square, interval)
    whole = claim["interval"] == WHOLE and (kind in SIGNED or kind[0] == "friction")
    ends = port_ends(kind[0] == "friction", joint, load, interval) if whole else ()
    for part in chain(STATEMENTS[kind](joint, v, load), ends):
        if isinstance(part, str):
            return f": {part}"
        try:
            at = counterexample(part, lo, hi, joint.deadline)
        except CheckError as error:
            undecided = error
        else:
            if at is not None:
                frequency = "inf" if at[1] == 0 else format((Decimal(at[0]) / Decimal(at[1])).sqrt(), ".6g")
                return f" at ω = {frequency} rad/s"
    if undecided:
        raise undecided
    return ""
