"""The sandwich: a constraint proven at the hardest level found, and its twin refuted just beyond, at a witness."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np

from ..problem.constraints.inequality import Constraint, Role
from .claim import Claim, Refutation, claim_of
from .outcome import Outcome
from .prover import Prover
from .witness import short

TIGHTNESS = (1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1)  # how far from the float optimum a level is tried, relative
COARSE = (5e-3, 2e-2, 0.1)  # where only cells decide, each further digit costs a proof more cells


def prove_hardest(prover: Prover, constraint: Constraint) -> Claim:
    """Prove at the hardest level found; if the required level cannot be proven, refute it with a witness."""
    prover, best, omega = replace(prover, evaluator=prover.evaluator.with_ends(constraint)).focused(constraint)
    required, harder = constraint.level, constraint.role.harder
    levels = _beside(best, -harder, constraint, COARSE if prover.needs_cells(constraint) else TIGHTNESS)
    if required is not None:
        levels = [v for v in levels if harder * (v - required) > 0] + [required]
    for proven in levels:
        if _meaningful(constraint, proven) and prover.decide(constraint, proven) is Outcome.PROVEN:
            return claim_of(constraint, Outcome.PROVEN, proven, _twin(prover.near(omega), constraint, best, proven))
    level = required if required is not None else _easiest(constraint)
    found = prover.witness(constraint, level)
    if found is None:
        return claim_of(constraint, Outcome.UNDECIDED, None, None)
    return claim_of(constraint, Outcome.REFUTED, None, Refutation(level, found))


def _twin(prover: Prover, constraint: Constraint, best: float, proven: Fraction) -> Refutation | None:
    """The twin: the least harder level found at which the claim fails, and where."""
    harder = constraint.role.harder
    for v in _beside(best, harder, constraint):
        if harder * (v - proven) > 0 and (found := prover.witness(constraint, v)):
            return Refutation(v, found)
    return None


def prove_largest_band(prover: Prover, constraint: Constraint) -> Claim:
    """Prove a constraint on the widest interval where it holds; refuted everywhere if there is none."""
    v = float(_easiest(constraint))
    evaluator, fits = prover.evaluator, prover.evaluator.inside(constraint)
    for inequality in constraint.inequalities:
        fits &= np.nan_to_num(evaluator.slack(inequality, v, prover.X), nan=-1.0) > 0
    for run in _runs(fits, evaluator.omega):
        a, b = (evaluator.edge(*pair, constraint.inequalities, v, prover.X) for pair in run)
        for tightness in TIGHTNESS:
            ends = (short(a * (1 + tightness), up=True), short(b * (1 - tightness), up=False))
            if ends[0] < ends[1]:
                claim = prove_hardest(prover, replace(constraint, band=ends, level=Fraction(1)))
                if claim.status is Outcome.PROVEN:
                    return replace(claim, required=constraint.required)
    found = prover.witness(constraint, Fraction(1))
    status = Outcome.REFUTED if found else Outcome.UNDECIDED
    return claim_of(constraint, status, None, Refutation(Fraction(1), found) if found else None)


def _easiest(constraint: Constraint) -> Fraction:
    return Fraction(0) if constraint.role is Role.FLOOR else Fraction(1)


def _meaningful(constraint: Constraint, v: Fraction) -> bool:
    return v > 0 if constraint.id == "friction" else constraint.role is Role.FLOOR or v > 0


def _beside(v: float, side: int, constraint: Constraint, tightness: tuple[float, ...] = TIGHTNESS) -> list[Fraction]:
    """Short levels a little beside v: relative, or for levels that can be zero in absolute terms as well."""
    if not np.isfinite(v):
        return []
    scale = abs(v) + 1e-4 if constraint.role is Role.FLOOR else abs(v)
    return [short(v + side * near * scale, up=side > 0) for near in tightness]


def _runs(fits: np.ndarray, omega: np.ndarray) -> list[tuple[tuple[float, float], tuple[float, float]]]:
    """Maximal intervals of the grid on which `fits`, widest first: each end, and the grid point beyond it if any."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], fits, [False]]).astype(int)))
    runs = [(int(a), int(b - 1)) for a, b in zip(edges[::2], edges[1::2], strict=True) if b - 1 > a]
    runs.sort(key=lambda run: float(omega[run[0]] - omega[run[1]]))
    last = omega.size - 1
    return [
        ((float(omega[a]), float(omega[max(a - 1, 0)])), (float(omega[b]), float(omega[min(b + 1, last)])))
        for a, b in runs
    ]
