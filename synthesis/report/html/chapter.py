"""One certificate's part of the page: everything the template shows, as text and figures."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

from ...written import polynomials
from .figure import Figure
from .impedance import impedance
from .margins import margins, sensitivity
from .mathml import transfer
from .motion import motion
from .nyquist import nyquist_plots
from .words import described, margin, number, span

if TYPE_CHECKING:
    from .study import CheckedClaim, Study


@dataclass(frozen=True)
class Section:
    """A heading with plots under it."""

    title: str
    figures: tuple[Figure, ...]


@dataclass(frozen=True)
class Chapter:
    """A part of the page about one certificate."""

    study: Study
    controller: tuple[Markup, ...]
    described: list[tuple[str, str]]
    sections: tuple[Section, ...]
    claims: list[dict[str, Any]]
    facts: list[tuple[str, str]]
    provenance: list[tuple[str, str]]


def chapter(study: Study) -> Chapter:
    """Everything to show of one certificate."""
    sections = [
        Section("Disturbances", (sensitivity(study),)),
        Section("Margins at every frequency", tuple(margins(study))),
        Section("Apparent impedance over the loads", tuple(impedance(study))),
        Section("Stability", tuple(nyquist_plots(study))),
        Section("In the time domain", tuple(motion(study))),
    ]
    return Chapter(
        study, _controller(study), described(study.spec), tuple(sections), [_row(study, c) for c in study.claims],
        _facts(study), _provenance(study),
    )  # fmt: skip


def _controller(study: Study) -> tuple[Markup, ...]:
    C = transfer("C", polynomials(study.content["controller"]["C"]))
    if study.spec.controller.type != "dob":
        return (transfer("C_imp", study.coefficients),)
    return (transfer("Q", study.coefficients), C)


def _facts(study: Study) -> list[tuple[str, str]]:
    """The figures of the first screen."""
    band = study.content["bandwidth"]
    facts = [("bandwidth ω_B, stated but not proven", f"{number(Fraction(band['proven']))} rad/s")]
    if study.proven:
        facts = [("bandwidth, proven", f"ω_B ≥ {study.verdict.omega_b} rad/s")]
    if band["bound"] is not None:
        facts.append(("bound, of a solver on a grid", f"{number(Fraction(band['bound']))} rad/s"))
    counted = Counter(checked.word for checked in study.claims)
    confirmed = "all" if all(checked.confirmed for checked in study.claims) else "not all"
    facts.append((f"claims, {confirmed} confirmed by the checker", ", ".join(f"{n} {w}" for w, n in counted.items())))
    return facts


def _row(study: Study, checked: CheckedClaim) -> dict[str, Any]:
    claim, failing = checked.claim, ""
    if claim.refuted_at is not None:
        failing = number(claim.refuted_at.value)
        if claim.refuted_at.witness is not None:
            omega = claim.refuted_at.witness.omega
            failing += f" at {'∞' if omega is None else number(omega)} rad/s"
    return {
        "id": claim.id, "equation": claim.equation, "form": claim.form, "statement": claim.statement,
        "uncertainty": claim.uncertainty, "interval": span(*claim.interval),
        "margin": margin(claim, study.spec.motion), "failing": failing,
        "required": claim.required, "word": checked.word, "message": "" if checked.confirmed else checked.message,
        "exact": "" if claim.margin is None else str(claim.margin),
    }  # fmt: skip


def _provenance(study: Study) -> list[tuple[str, str]]:
    producer = ", ".join(f"{name} {version}" for name, version in study.content["producer"].items())
    return [
        ("certificate", study.file),
        ("SHA-256 of the certificate's body", study.content["end"]["body_sha256"]),
        ("SHA-256 of its specification", study.content["spec_sha256"]),
        ("produced with", producer),
        ("re-checked by", "the independent checker, in exact integers, when this page was made"),
    ]
