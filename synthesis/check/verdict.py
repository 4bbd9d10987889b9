"""From bytes to a verdict: read, compare with the specification, re-prove every claim."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from decimal import ROUND_FLOOR, Context, Decimal
from os.path import realpath
from pathlib import Path
from typing import Any

from .joint import validate
from .outcome import FALSE, MISMATCH, UNDECIDED, UNREADABLE, CheckError, demand, tick
from .proofs import Prover
from .reader import MAX_BYTES, read
from .requirements import WHOLE, compare

NAMES = {0: "PROVEN", UNREADABLE: "INPUT", FALSE: "REFUTED", UNDECIDED: "UNDECIDED", MISMATCH: "MISMATCH"}


@dataclass(frozen=True)
class Verdict:
    """What the checker found: exit code, one line, ω_B rounded down if everything required is proven, every claim."""

    exit_code: int
    message: str
    omega_b: str | None = None
    claims: tuple[tuple[str, str, str, str], ...] = ()  # (id, form, status, message)

    def __repr__(self) -> str:
        name = NAMES.get(self.exit_code, f"exit code {self.exit_code}")
        return f"<Verdict {name}, {self.message.replace('  ', ', ')}>"

    def _repr_html_(self) -> str:
        """The line and the claims, for a notebook."""
        from html import escape  # no notebook, no HTML

        rows = ("".join(f"<td>{escape(cell)}</td>" for cell in claim[:3]) for claim in self.claims)
        table = "".join(f"<tr>{row}</tr>" for row in rows)
        return f"<div><b>{escape(repr(self)[1:-1])}</b></div>" + (f"<table>{table}</table>" if table else "")


def check_file(path: str | Path, *, time_limit: float = 60.0) -> Verdict:
    """Re-prove the certificate in a file; `time_limit` in seconds."""
    try:
        if Path(realpath(path)).is_fifo():  # it may have no other end; a pipe of the shell has no such path
            return Verdict(UNREADABLE, "file: a named pipe, not a file")
        with Path(path).open("rb") as stream:
            data = stream.read(MAX_BYTES + 1)
    except (OSError, ValueError) as error:
        return Verdict(UNREADABLE, f"file: cannot be read: {getattr(error, 'strerror', None) or error}")
    return check_bytes(data, time_limit=time_limit)


def check_bytes(data: bytes, *, time_limit: float = 60.0) -> Verdict:
    """Re-prove every claim of a certificate from its specification and controller alone; `time_limit` in seconds."""
    deadline = time.monotonic() + time_limit
    try:
        demand(deadline == deadline, "time limit: not a number", UNDECIDED)
        certificate = read(data)
        validate(certificate, deadline)
        compare(certificate)
        decide = _decision(certificate, deadline)
    except CheckError as error:
        return Verdict(error.code, str(error))
    claims, stops = [], []
    for claim in certificate["claims"]:
        name, status = f"{claim['id']} {claim['form']}", claim["status"]
        message = f"{name}: {status}"
        try:
            _check(decide, claim)
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


def _decision(certificate: dict[str, Any], deadline: float) -> Callable[..., str]:
    """Where a claim fails: by polynomials alone, and on cells from the first claim that needs them."""
    prover = Prover(certificate, deadline)

    def fault(*claim: Any) -> str:
        nonlocal prover
        tick(deadline)  # before large polynomials are made once more
        found = prover.fault(*claim)
        if found is None:
            try:
                from .enclosure.claims import CellProver  # the only place where one tier knows of the other
            except ImportError:
                raise CheckError(UNDECIDED, "needs `enclosure`, which is absent") from None
            prover = CellProver(certificate, deadline)
            found = prover.fault(*claim)
        return found

    return fault


def _check(fault_of: Callable[..., str], claim: dict[str, Any]) -> None:
    """Re-prove one claim at its margin, and verify that it fails at its witness."""
    kind, whole = (claim["id"], claim["form"]), claim["interval"] == WHOLE
    required, status, interval, witness = (claim[key] for key in ("required", "status", "interval", "refuted_at"))
    if status == "proven":
        fault = fault_of(kind, claim["margin"], interval, whole)
        demand(not fault, f"does not hold{fault}", FALSE)
    if witness is not None:
        v, omega = witness["value"], witness["omega"]
        fault = fault_of(kind, v, interval if omega is None else (omega, omega), whole, witness)
        shown = "refutation" if status == "refuted" else "tightness"
        demand(fault != "", f"its witness of {shown} is false: it holds there", FALSE)
        demand(not required or status != "refuted", f"required, and refuted{fault}", FALSE)
    demand(not required or status != "undecided", "required, and undecided", UNDECIDED)
