"""Joints that once were certified and should not have been, or could be: kept so that they never are again."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from robimp.synthesis import ExitCode, InputError, parse, synthesize
from robimp.synthesis.certificate.claim import Claim
from robimp.synthesis.certificate.claims import certify
from robimp.synthesis.certificate.document import NOMINAL_ONLY, OUTSIDE, document, robustly_stable
from robimp.synthesis.certificate.outcome import Outcome
from robimp.synthesis.check import check_bytes
from robimp.synthesis.cli.entry import _interrupted
from robimp.synthesis.problem.setting import Setting

SOFT_IN_THE_BOX = """
robimp: 1
name: soft-in-the-box
motion: rotary
plant: {inertia: 0.05, damping: 0.3, stiffness: 20}
uncertainty: {box: {inertia: ±10 %, damping: ±30 %, stiffness: [LOW, 30]}}
actuator: {type: ideal}
impedance: {inertia: nominal, damping: 0.5, stiffness: 0.5}
controller: {type: dob, coefficients: {numerator: [0.1], denominator: [1, 1]}}
objective: {maximize: bandwidth, attenuation: 0.95}
constraints: {CONSTRAINTS}
"""


def claims_of(low: str, constraints: str, wish: str = "0.5") -> tuple[Setting, tuple[Claim, ...], dict[str, Any]]:
    text = SOFT_IN_THE_BOX.replace("stiffness: 0.5", f"stiffness: {wish}")
    spec = parse(text.replace("LOW", low).replace("CONSTRAINTS", constraints))
    setting, coefficients = Setting.of(spec), spec.controller.coefficients
    assert coefficients is not None
    claims = certify(setting, setting.compensator(coefficients))
    return setting, claims, document(setting, coefficients, claims, bound=None, producer={})


def worst_pole(setting: Setting) -> float:
    """Largest real part of the free poles over the corners of the box, in floats."""
    coefficients = setting.spec.controller.coefficients
    assert coefficients is not None
    C = setting.compensator(coefficients)
    polynomials = [setting.loop.free(load)(C) for load in setting.uncertainty.corners()]
    return max(np.roots([float(Fraction(str(c))) for c in p.coeffs()[::-1]]).real.max() for p in polynomials)


def test_friction_sees_a_root_that_passes_through_zero() -> None:
    """`Re(N/(D s)) > 0` on the axis for every load, and yet the soft corner is unstable: N(0) changes sign."""
    setting, claims, _ = claims_of("1", "peak: 3, friction: require")
    assert worst_pole(setting) > 10
    friction = next(c for c in claims if c.id == "friction")
    assert friction.status is Outcome.REFUTED
    assert friction.refuted_at is not None and friction.refuted_at.witness is not None
    assert friction.refuted_at.witness.omega == 0


def test_friction_is_still_proven_where_no_root_moves() -> None:
    setting, claims, certificate = claims_of("19.9", "peak: 3, friction: require")
    assert worst_pole(setting) < 0
    assert next(c for c in claims if c.id == "friction").status is Outcome.PROVEN
    assert check_bytes(json.dumps(certificate).encode()).exit_code == 0


def test_the_checker_refuses_the_false_friction_claim_by_itself() -> None:
    setting, claims, _ = claims_of("1", "peak: 3, friction: require")
    forged = tuple(
        replace(c, status=Outcome.PROVEN, margin=Fraction(1, 1000), refuted_at=None) if c.id == "friction" else c
        for c in claims
    )
    coefficients = setting.spec.controller.coefficients
    assert coefficients is not None
    verdict = check_bytes(json.dumps(document(setting, coefficients, forged, bound=None, producer={})).encode())
    assert verdict.exit_code == 4
    assert ("friction", "not verified") in {(id, status) for id, _, status, _ in verdict.claims}


def test_an_unstable_load_inside_the_box_is_never_called_proven() -> None:
    """No constraint about the box was asked for; stability of the box is required all the same."""
    result = synthesize(parse(SOFT_IN_THE_BOX.replace("LOW", "1").replace("CONSTRAINTS", "peak: 3")))
    assert result.exit_code == ExitCode.REFUTED
    box = next(c for c in result.claims if c.form == "box")
    assert box.status is Outcome.REFUTED and box.refuted_at is not None and box.refuted_at.value == 1


@pytest.mark.parametrize(
    ("constraints", "covered"),
    [
        ("peak: 3", False),
        ("eq9: {}", True),
        ("eq18: {form: half-plane, coupling: physical}", True),
        ("eq18: {form: half-plane, coupling: frozen}", False),
        ("eq12: {form: structured}", True),
        ("eq12: {form: structured, band: [0, 100]}", False),
    ],
)
def test_the_certificate_says_whether_the_box_is_covered(constraints: str, covered: bool) -> None:
    setting, claims, certificate = claims_of("19.9", constraints, wish="20")
    assert all(c.status is Outcome.PROVEN for c in claims if c.required), "else the case shows nothing"
    aside = tuple(c for c in claims if c.id != "friction" and c.form != "box")
    assert robustly_stable(setting, aside) is covered
    assert robustly_stable(setting, claims)
    level = {"eq12": Fraction(0)}  # nothing to spare: a root may be on the axis
    touching = tuple(replace(c, margin=level.get(c.id, c.margin)) for c in aside)
    assert robustly_stable(setting, touching) is (covered and "eq12" not in constraints)
    expected = OUTSIDE if robustly_stable(setting, claims) else NOMINAL_ONLY
    assert certificate["not_claimed"][-1] == expected


def test_an_interrupt_inside_a_library_is_an_interrupt() -> None:
    wrapped = SystemError("returned a result with an exception set")
    wrapped.__cause__ = KeyboardInterrupt()
    assert _interrupted(wrapped) and not _interrupted(SystemError("of its own"))


def test_a_named_pipe_is_refused_at_once(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe.json"
    os.mkfifo(pipe)
    command = [sys.executable, "-c", "from robimp.synthesis.cli import main; main()", "check", str(pipe)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=20, check=False)
    assert done.returncode == 2 and "named pipe" in done.stderr


@pytest.mark.parametrize(("factor", "fits"), [("1e40", False), ("1e-42", False), ("1e30", True)])
def test_single_precision_has_a_largest_and_a_smallest_number(factor: str, fits: bool) -> None:
    """A relative error of 2⁻²⁴ is what rounding costs only between them."""
    text = SOFT_IN_THE_BOX.replace("LOW", "19.9").replace("CONSTRAINTS", "peak: 3, tolerance: float32")
    text = text.replace("[0.1]", f"[0.1{factor[1:]}]").replace("[1, 1]", f"[{factor}, {factor}]")
    if fits:
        assert synthesize(parse(text)).exit_code == ExitCode.PROVEN
    else:
        with pytest.raises(InputError, match="single precision"):
            synthesize(parse(text))
