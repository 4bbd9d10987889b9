"""A certificate back in the time domain: its controller on its own specification's joint, against its own claims."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import Any

from .agreement import Agreement, compare
from .certificate.claims import certify
from .certificate.document import verdict
from .check import Verdict
from .errors import MismatchError
from .pipeline import VERDICT_CODE, realizable, setting_of
from .simulation import Trials, verify
from .spec import from_canonical
from .spec.model import Polynomials


def replay(
    content: dict[str, Any], checked: Verdict, file: str, progress: Callable[[str], None]
) -> tuple[Trials, Agreement]:
    """Simulate every load of a certificate whose format was already checked, and compare with its claims.

    Raises: MismatchError when the certificate does not say what the prover finds for its controller.
    """
    spec = from_canonical(content["spec"], file)
    setting = setting_of(spec)
    C = realizable(setting, _polynomials(content["controller"]["Q" if spec.controller.type == "dob" else "C"]))
    claims = certify(setting, C)
    found = {(claim.id, claim.form): claim.status.value for claim in claims}
    for claim in content["claims"]:
        status = found.get((claim["id"], claim["form"]), claim["status"])
        if claim["status"] != status:
            raise MismatchError(
                f"{file}: {claim['id']} {claim['form']} is written as {claim['status']}, but is {status}"
            )
    if checked.exit_code != VERDICT_CODE[verdict(claims)]:
        raise MismatchError(f"{file}: {checked.message}")
    compensator = _polynomials(content["controller"]["C"])
    trials = verify(spec, (compensator.numerator, compensator.denominator), progress=progress)
    return trials, compare(setting, C, claims, trials)


def _polynomials(written: dict[str, list[str]]) -> Polynomials:
    return Polynomials(
        numerator=tuple(map(Fraction, written["numerator"])), denominator=tuple(map(Fraction, written["denominator"]))
    )
