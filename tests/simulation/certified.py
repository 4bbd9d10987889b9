"""Certificates of the golden corpus as the adversary takes them: specification, compensator, claims as written."""

from __future__ import annotations

import json
from pathlib import Path
from typing import NamedTuple

from robimp.synthesis.certificate.claim import Claim
from robimp.synthesis.simulation import Compensator
from robimp.synthesis.spec import from_canonical
from robimp.synthesis.spec.model import Polynomials, Spec
from robimp.synthesis.written import claims_of, polynomials

GOLDEN = Path(__file__).parents[1] / "data" / "golden"


class Certified(NamedTuple):
    """What a certificate says."""

    spec: Spec
    C: Compensator
    claims: tuple[Claim, ...]
    coefficients: Polynomials


def golden(name: str) -> Certified:
    """One of the golden corpus."""
    content = json.loads((GOLDEN / f"{name}.json").read_bytes())
    controller = {key: polynomials(part) for key, part in content["controller"].items() if key in "QC"}
    C = controller["C"]
    return Certified(
        from_canonical(content["spec"]), (C.numerator, C.denominator), claims_of(content), controller.get("Q", C)
    )
