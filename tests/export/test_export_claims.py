"""What is proven of the shipped law, against (★) evaluated in floats with that law; what is lost is named."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from export_joints import JOINT, compensator, in_q, law_of, replaced, setting_of

from robimp.models.impedance import DynamicStiffness
from robimp.models.rational import exact, to_float
from robimp.synthesis.certificate.outcome import Outcome
from robimp.synthesis.certificate.witness import short
from robimp.synthesis.errors import ExitCode
from robimp.synthesis.export.carried import LEFT, LOST, NEEDLESS, Carried, bandwidth, exit_code, verdict
from robimp.synthesis.export.law import Law
from robimp.synthesis.export.proofs import carried_over
from robimp.synthesis.export.sections import Section, Sections
from robimp.synthesis.problem.setting import Setting

GRID = np.geomspace(0.01, 0.99 * np.pi * 1000, 20_000)
PAPER = "{type: dob, coefficients: {numerator: [2000], denominator: [1, 70.75, 2500]}}"
FILTERED = replaced(
    JOINT,
    (PAPER, PAPER.replace("]}}", "]}, filters: {force: 700, position: 900, derivative: 800}}")),
    ("{inertia: nominal,", "{inertia: 0.028,"),
)


def written(id_: str, form: str, margin: str | None = None) -> dict[str, Any]:
    return {"id": id_, "form": form, "required": True, "margin": margin}


def carried(setting: Setting, law: Law, *claims: tuple[str, str]) -> dict[str, Carried]:
    found = carried_over(setting, compensator(setting), law, [written(*claim) for claim in claims], lambda _: None)
    return {each.id: each for each in found}


def responses(setting: Setting, law: Law, load: DynamicStiffness) -> tuple[np.ndarray, np.ndarray]:
    """`1 − Q̃` and Z of joint and shipped law by elimination: `τ_d = a τ_int − b θ` with a, b of z, (1), (13)."""
    s, q, hold = 1j * GRID, np.exp(-1j * GRID / 1000), setting.loop.actuator.hold
    assert hold is not None
    port = setting.loop.actuator
    H = in_s(port.h, s) / in_s(port.d, s) * np.exp(-s * to_float(hold.delay)) * (1 - np.exp(-s / 1000)) / (s / 1000)
    Z_a = in_s(port.z, s) / in_s(port.d, s)
    C, F, F_theta, F_d = (cascade(f, q) for f in (law.compensator, law.force, law.position, law.derivative))
    wish = in_q(law.error.stiffness(law.desired), q)
    inner = in_q(law.compensated.stiffness(law.nominal) - law.compensated.stiffness(law.desired), q)
    a, b = C * F * in_q(law.error.M, q), C * F_theta * wish - F_d * inner
    # load: g θ = τ_int + H (a τ_int − b θ) − Z_a θ
    return 1 / (1 + H * a), (in_s(load.polynomial, s) + Z_a + H * b) / (1 + H * a)


def in_s(p: Any, s: np.ndarray) -> np.ndarray:
    return np.asarray(sum(to_float(c) * s**k for k, c in enumerate(p.coeffs())))


def cascade(sections: Sections, q: np.ndarray) -> np.ndarray:
    rows = sections.sos
    z = np.array([q**0, q, q**2])
    return np.prod([(row[:3] @ z) / (row[3:] @ z) for row in rows], axis=0) if len(rows) else np.ones_like(q)


@pytest.mark.parametrize("text", [JOINT, FILTERED])
def test_proven_margins_are_just_below_what_the_law_does(text: str) -> None:
    setting = setting_of(text)
    law = law_of(setting)
    kinds = [("eq12", "structured"), ("bandwidth", "attenuation"), ("peak", "sensitivity"), ("rendering", "every-load")]
    found = carried(setting, law, *kinds)
    sensitivity = np.abs(responses(setting, law, setting.loop.nominal)[0])
    impedances = [responses(setting, law, load)[1] for load in setting.uncertainty.corners()]
    peak, passive, band, rendering = (found[k].claim for k in ("peak", "eq12", "bandwidth", "rendering"))
    assert peak is not None and passive is not None and band is not None and rendering is not None
    assert peak.margin is not None and sensitivity.max() <= float(peak.margin) <= sensitivity.max() * 1.01
    least = min((Z / (1j * GRID)).real.min() for Z in impedances)
    proven = passive.margin or Fraction(found["eq12"].note.removeprefix("holds only with margin "))
    assert passive.status is (Outcome.PROVEN if least > 0 else Outcome.REFUTED)
    assert float(proven) - 1e-5 <= least <= float(proven) + 0.01 * abs(least) + 1e-5
    first = GRID[np.argmax(sensitivity > 0.3)]
    assert band.margin is not None and first * 0.999 <= float(band.margin) <= first
    inside = float(band.margin) >= GRID
    wish = in_s(setting.loop.desired.polynomial, 1j * GRID)
    error = max(np.abs(Z / wish - 1)[inside].max() for Z in impedances)
    assert rendering.margin is not None and error <= float(rendering.margin) <= error * 1.01


def test_a_claim_that_is_lost_is_refuted_with_its_frequency_and_what_still_holds() -> None:
    """Eight milliseconds of delay, which the continuous claims know nothing of."""
    late = replaced(JOINT, ("delay: 1 ms", "delay: 8 ms"))
    setting = setting_of(late)
    law = law_of(setting)
    lost = carried(setting, law, ("eq12", "structured"))["eq12"]
    assert lost.claim is not None and lost.claim.refuted_at is not None and lost.claim.refuted_at.witness is not None
    omega = lost.claim.refuted_at.witness.omega
    assert lost.status == "refuted" and omega is not None
    passivity = min((responses(setting, law, g)[1] / (1j * GRID)).real.min() for g in setting.uncertainty.corners())
    assert passivity < 0
    assert f"{float(omega):.6g} rad/s" in lost.line
    held = float(lost.note.removeprefix("holds only with margin "))
    assert held == pytest.approx(passivity, rel=0.02)
    assert exit_code([lost]) is ExitCode.REFUTED


@pytest.mark.parametrize(("certified", "status"), [(1.005, "proven"), (1.02, LOST)])
def test_a_bandwidth_is_carried_over_only_if_almost_all_of_it_is(certified: float, status: str) -> None:
    """0.99 of the certificate's ω_B; with less the export is refuted, and the figures are said."""
    setting = setting_of(JOINT)
    found = carried(setting, law_of(setting), ("bandwidth", "attenuation"))["bandwidth"]
    assert found.claim is not None and found.claim.margin is not None
    margin = short(float(found.claim.margin) * certified)
    before = replace(found, certified=margin)
    assert before.status == status
    assert exit_code([before]) is (ExitCode.REFUTED if status == LOST else ExitCode.PROVEN)
    reached = f"{float(short(float(found.claim.margin), up=False)):g}"
    assert f"ω_B ≥ {reached} rad/s (certificate {float(margin):.6g})" in bandwidth([before])
    assert verdict([before]).startswith("NOT PROVEN: bandwidth attenuation lost" if status == LOST else "PROVEN")
    assert ("98.04% is left, 99.00% is asked for" in before.line) is (status == LOST)


def test_a_wrong_coefficient_is_seen() -> None:
    """The control: a section with half its gain has half the bandwidth or less, and no claim says otherwise."""
    setting = setting_of(JOINT)
    law = law_of(setting)
    section = law.compensator.sections[0]
    weak = replace(law, compensator=Sections((replace(section, b0=section.b0 / 2),)))
    right, wrong = (carried(setting, each, ("bandwidth", "attenuation"))["bandwidth"] for each in (law, weak))
    assert right.claim is not None and right.claim.margin is not None
    assert wrong.claim is None or wrong.claim.margin is None or wrong.claim.margin < right.claim.margin / 2


def test_nothing_is_proven_of_an_unstable_loop() -> None:
    setting = setting_of(JOINT)
    law = law_of(setting)
    section = law.compensator.sections[0]
    wild = replace(law, compensator=Sections((replace(section, b0=section.b0 * 40),)))
    found = carried_over(
        setting,
        compensator(setting),
        wild,
        [written("stability-free", "winding"), written("stability-free", "box", "1")],
        lambda _: None,
    )
    assert [each.status for each in found] == ["refuted", LEFT]
    assert exit_code(found) is ExitCode.REFUTED


def test_what_is_not_proven_again_is_said_and_is_no_proof() -> None:
    setting = setting_of(JOINT)
    found = carried(setting, law_of(setting), ("eq12", "paper"), ("tolerance", "coefficients"))
    assert (found["eq12"].status, found["tolerance"].status) == (LEFT, NEEDLESS)
    assert "printed form" in found["eq12"].line
    assert exit_code([found["eq12"]]) is ExitCode.UNDECIDED
    assert exit_code([found["tolerance"]]) is ExitCode.PROVEN, "nothing is asked of coefficients that are exact"


def test_noise_beyond_half_the_sampling_rate_is_not_claimed() -> None:
    text = replaced(JOINT, ("peak: 2", "peak: 2, noise: {gain: 3, above: 4000}"))
    setting = setting_of(text)
    found = carried(setting, law_of(setting), ("noise", "command"))["noise"]
    assert found.status == LEFT
    assert "half the sampling rate" in found.line


def test_rounding_to_single_precision_changes_what_is_proven() -> None:
    """The claims are about the shipped numbers: a filter far below the rate moves with them, and its claims do."""
    text = replaced(JOINT, (PAPER, PAPER.replace("[2000]", "[0.02]").replace("[1, 70.75, 2500]", "[1, 0.22, 0.025]")))
    setting = setting_of(text)
    margins = []
    for precision in ("double", "float"):
        claim = carried(setting, law_of(setting, precision), ("peak", "sensitivity"))["peak"].claim
        assert claim is not None
        margins.append(claim.margin)
    assert margins[0] != margins[1]


def test_sections_are_exact_numbers() -> None:
    section = Section(0.1, 0.2, 0.3, -1.9, 0.91)
    assert section.num[0] == exact(0.1)
    assert Fraction(str(section.den[1])) == Fraction(-1.9)
