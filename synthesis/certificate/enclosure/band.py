"""The bandwidth on cells: how far the objective's conditions hold for every actuator and impedance."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np

from ...problem.constraints import constraints
from ...problem.constraints.inequality import Constraint
from ...problem.grid import Evaluator
from ..claim import Claim, Refutation, claim_of
from ..outcome import Outcome
from ..witness import short
from .cells import Cells, Part
from .prover import NEAR, CellProver, witness_at
from .search import Point

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
    return claim_of(replace(attenuation, band=(Fraction(0), Fraction(0))), Outcome.UNDECIDED, None, None)


def _first_failure(prover: CellProver, conditions: list[Constraint]) -> float:
    """Where on the grid, at the vertices of the ranges, a condition first fails."""
    setting, family = prover.family.setting, prover.family
    omega = np.geomspace(*_middle(prover), num=4000)
    first = float(omega[-1])
    for vertex in setting.vertices():
        X = vertex.variables(vertex.build(family.numerator, family.denominator))
        for c in constraints(vertex):
            if c.id not in {condition.id for condition in conditions}:
                continue
            for inequality in c.inequalities:
                slack = Evaluator(vertex, omega).slack(inequality, float(c.level or 0), X)
                failing = np.flatnonzero(slack < 0)
                if not failing.size:
                    continue
                k = int(failing[0])
                a, b = float(omega[max(k - 1, 0)]), float(omega[k])
                for _ in range(50):
                    m = (a + b) / 2
                    at = Evaluator(vertex, np.array([m])).slack(inequality, float(c.level or 0), X)[0]
                    a, b = (a, m) if at < 0 else (m, b)
                first = min(first, a)
    return first


def _middle(prover: CellProver) -> tuple[float, float]:
    cells = next(cells for cells in prover.axis((Fraction(0), None)) if cells.part is Part.MIDDLE)
    return float(cells.z.min()), float(cells.z.max())


def _proven_end(prover: CellProver, conditions: list[Constraint], first: float) -> tuple[Fraction | None, float]:
    for _ in range(NEEDLES):
        point: Point | None = None
        for tightness in NEAR:
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
        z = np.full((2, 1), float(omega))
        for signs in [np.zeros((m, 1))] if m == 0 else [np.full((m, 1), s) for s in (0.0, -1.0, 1.0)]:
            wide = np.stack([-np.ones((m, 1)), np.ones((m, 1))])
            cells = Cells(Part.MIDDLE, z, wide)
            slopes = prover.slacks(attenuation, level, cells)[0].c[2:]
            at = cells.points(signs if signs.any() else -np.sign(slopes))
            if float(prover.slacks(attenuation, level, at)[0].upper[0]) < 0:
                found = witness_at(prover.family, Point(at, 0, 0.0, 0), omega, None)
                return Refutation(omega, replace(found, impedance=None))
    return None
