"""Certificates of the golden corpus as the adversary takes them: specification, compensator, claims as written."""

from __future__ import annotations

import json
from fractions import Fraction
from pathlib import Path
from typing import Any, NamedTuple

from robimp.models.actuator import SeriesElastic
from robimp.models.impedance import DynamicStiffness
from robimp.models.rational import ZERO, exact
from robimp.synthesis.certificate.claim import Claim, Refutation
from robimp.synthesis.certificate.outcome import Outcome
from robimp.synthesis.certificate.witness import Witness
from robimp.synthesis.simulation import Compensator
from robimp.synthesis.spec import from_canonical
from robimp.synthesis.spec.model import Polynomials, Spec

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
    spec, C = from_canonical(content["spec"]), controller["C"]
    claims = tuple(claim(each) for each in content["claims"])
    return Certified(spec, (C.numerator, C.denominator), claims, controller.get("Q", C))


def polynomials(written: dict[str, list[str]]) -> Polynomials:
    """Numerator and denominator."""
    return Polynomials(**{part: tuple(map(Fraction, row)) for part, row in written.items()})


def claim(written: dict[str, Any]) -> Claim:
    """A claim as the prover had it."""
    low, high = written["interval"]
    beyond = written["refuted_at"]
    return Claim(
        **{key: written[key] for key in ("id", "equation", "form", "statement", "uncertainty", "required")},
        interval=(Fraction(low), None if high == "inf" else Fraction(high)),
        status=Outcome(written["status"]),
        margin=None if written["margin"] is None else Fraction(written["margin"]),
        refuted_at=None if beyond is None else Refutation(Fraction(beyond["value"]), witness(beyond)),
    )


def witness(written: dict[str, Any]) -> Witness | None:
    """Where it fails."""
    drive = written.get("actuator")
    load, wish = ((part := written.get(key)) and DynamicStiffness.of(*part.values()) for key in ("load", "impedance"))
    return Witness(
        None if written["omega"] in (None, "inf") else Fraction(written["omega"]),
        load,
        wish,
        actuator=drive and SeriesElastic(*map(exact, map(Fraction, drive.values())), C_t=ZERO, feedforward=exact(1)),
        controller=written.get("controller") and polynomials(written["controller"]),
        claim=written.get("claim") and tuple(written["claim"]),
    )  # fmt: skip
