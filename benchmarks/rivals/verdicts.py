"""The verdict on anybody's Q: robimp's prover, then the independent checker on the certificate."""

from __future__ import annotations

import json
import time
from dataclasses import dataclass
from typing import Any

import numpy as np
from task import Candidate, Task

from robimp.synthesis import RobimpError
from robimp.synthesis.certificate.claim import Claim
from robimp.synthesis.certificate.claims import certify
from robimp.synthesis.certificate.document import document, verdict
from robimp.synthesis.certificate.outcome import Outcome
from robimp.synthesis.check import check_bytes
from robimp.synthesis.pipeline import realizable
from robimp.synthesis.problem.constraints import constraints
from robimp.synthesis.problem.grid import Evaluator, float_roots

GRID = 4000  # points that say by how much a refuted claim fails


@dataclass(frozen=True)
class Judgement:
    """outcome: proven, unstable, refuted or undecided; omega_B [rad/s]: proven, if everything required is."""

    outcome: str
    omega_B: float | None
    why: str
    checker: str
    seconds: float


def judge(task: Task, candidate: Candidate) -> Judgement:
    """Certify a candidate's coefficients against everything the specification requires, twice."""
    began = time.monotonic()
    try:
        C = realizable(task.setting, candidate.coefficients)
    except RobimpError as error:
        return Judgement("refuted", None, str(error), "not asked", time.monotonic() - began)
    claims = certify(task.setting, C)
    status = verdict(claims)
    certificate = document(task.setting, candidate.coefficients, claims, bound=None, producer={})
    second = check_bytes(json.dumps(certificate).encode())
    checker = f"exit {int(second.exit_code)}"
    seconds = time.monotonic() - began
    if status is Outcome.PROVEN:
        band = next(c for c in claims if c.id == "bandwidth").margin
        return Judgement("proven", float(band or 0), "", checker, seconds)
    worst = next(c for c in claims if c.required and c.status is status)
    if worst.id.startswith("stability") and status is Outcome.REFUTED:
        return Judgement("unstable", None, _instability(task, C, worst), checker, seconds)
    return Judgement(status.value, None, _failure(task, C, worst), checker, seconds)


def _failure(task: Task, C: Any, claim: Claim) -> str:
    """Which claim fails, where, and by how much of what a dense grid sees: floats, while the refutation is exact."""
    if claim.id == "bandwidth":
        return f"bandwidth: not even at ω → 0 is |1−Q̃| ≤ {task.attenuation:g}"
    omega = np.geomspace(task.omega_0 / 1e4, task.omega_0 * 1e4, GRID)
    shortfalls = [
        Evaluator(vertex, omega).worst(c, float(c.level or 0), vertex.variables(C))
        for vertex in task.setting.vertices()
        for c in constraints(vertex, only=claim.id)
        if c.form == claim.form
    ]
    if not shortfalls:
        return f"{claim.id} {claim.form}"
    slack, at, _ = min(shortfalls)
    return f"{claim.id} {claim.form} by {-slack:.2g} at {at:.4g} rad/s" if slack < 0 else f"{claim.id} {claim.form}"


def _instability(task: Task, C: Any, claim: Claim) -> str:
    """Where the poles are, for the reader: floats, while the refutation is exact."""
    loop = task.setting.loop
    pencil = loop.locked() if claim.id == "stability-locked" else loop.free(loop.nominal)
    real = max((root.real for root in float_roots(pencil(C))), default=0.0)
    return f"{claim.id}: a pole at Re s = {real:+.3g} /s"
