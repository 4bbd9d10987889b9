"""The bandwidth on cells: how far the objective's conditions hold for every actuator and impedance."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np

from ...problem.constraints import constraints
from ...problem.constraints.inequality import WHOLE, Constraint
from ...problem.grid import Evaluator
from ..claim import Claim, Refutation, claim_of
from ..outcome import Outcome
from ..witness import short
from .cells import Cells, Part
from .prover import NEAR, CellProver
from .search import Point

LEAVING = 1e-3  # of the band: what leaves a rendering error for every joint room enough to be proven quickly
NEEDLES = 4  # resonances that the grid of frequencies overlooked


def prove_bandwidth(prover: CellProver) -> Claim:
    """The largest ω_B up to which every condition of the objective holds, or the attenuation where that is none."""
    wanted = [c for c in constraints(prover.family.setting) if c.on_band and c.required]
    attenuation = next(c for c in wanted if c.id == "bandwidth")
    for conditions in (wanted, [attenuation]):
        first = _first_failure(prover, conditions)
        end, first = _proven_end(prover, conditions, first)
        if end is not None:
            return claim_of(
                replace(attenuation, band=(Fraction(0), end)), Outcome.PROVEN, end, _twin(prover, attenuation, first)
            )
    nowhere = replace(attenuation, band=(Fraction(0), Fraction(0)))
    found = prover.decide([(nowhere, prover.family.setting.spec.objective.attenuation)])
    if found.high < 0 and found.at is not None:
        beyond = replace(prover.witness(attenuation, found.at), impedance=None)
        return claim_of(nowhere, Outcome.REFUTED, None, Refutation(Fraction(0), beyond))
    return claim_of(nowhere, Outcome.UNDECIDED, None, None)


def _first_failure(prover: CellProver, conditions: list[Constraint]) -> float:
    """Where on the grid, at the vertices of the ranges, a condition first fails."""
    setting, family = prover.family.setting, prover.family
    omega = np.geomspace(*_middle(prover), num=4000)
    first, ids = float(omega[-1]), {condition.id for condition in conditions}
    for vertex in setting.vertices():
        evaluator = Evaluator(vertex, omega)
        X = vertex.variables(vertex.build(family.numerator, family.denominator))
        for c in (c for c in constraints(vertex) if c.id in ids):
            found = (evaluator.first_failure(inequality, float(c.level or 0), X) for inequality in c.inequalities)
            first = min([first, *(omega for omega in found if omega is not None)])
    return first


def _middle(prover: CellProver) -> tuple[float, float]:
    cells = next(cells for cells in prover.axis(WHOLE) if cells.part is Part.MIDDLE)
    return float(cells.z.min()), float(cells.z.max())


def _proven_end(prover: CellProver, conditions: list[Constraint], first: float) -> tuple[Fraction | None, float]:
    closest = LEAVING if len(conditions) > 1 and prover.halving.which.any() else 0.0
    for _ in range(NEEDLES):
        point: Point | None = None
        for tightness in (near for near in NEAR if near >= closest):
            end = short(first * (1 - tightness), digits=8, up=False)
            found = prover.decide([(replace(c, band=(Fraction(0), end)), c.level or Fraction(0)) for c in conditions])
            if found.low > 0:
                return end, first
            if found.high < 0 and found.at is not None:
                point = found.at
                break
        if point is None or point.omega >= first:
            break
        first = point.omega
    return None, first


def _twin(prover: CellProver, attenuation: Constraint, first: float) -> Refutation | None:
    """A frequency just beyond at which the attenuation fails, for some actuator."""
    level = prover.family.setting.spec.objective.attenuation
    m = len(prover.family.parameters)
    for tightness in NEAR:
        omega = short(first * (1 + tightness), digits=8, up=True)
        cells = Cells.at(float(omega), m)
        steepest = -np.sign(prover.slacks(attenuation, level, cells)[0].c[2:])
        for corner in (steepest, -np.ones((m, 1)), np.ones((m, 1))):
            at = cells.points(corner)
            if float(prover.slacks(attenuation, level, at)[0].upper[0]) < 0:
                found = prover.witness(attenuation, Point(at, 0, 0.0, 0))
                return Refutation(omega, replace(found, omega=omega, impedance=None))
    return None
