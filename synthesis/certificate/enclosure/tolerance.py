"""Tolerance: how far every coefficient of the controller may be off, each on its own, and all required still hold."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import islice, product
from typing import TYPE_CHECKING

import numpy as np
from flint import fmpq_poly

from ....models.rational import descending
from ...problem.constraints.inequality import WHOLE, Constraint
from ...problem.setting import Setting
from ...spec.model import Polynomials
from ..claim import Claim
from ..stability import IDEAL
from ..witness import Witness, short
from .cells import Cells, Part
from .exclusion import excluded
from .joint import Family
from .prover import CellProver
from .search import Point

if TYPE_CHECKING:
    from numpy.typing import NDArray

Required = Sequence[tuple[Constraint, Fraction]]
TRIAL = Fraction(1, 10**9)  # perturbation whose first-order effect is measured
LARGEST = 0.5
MOST_VERTICES = 64  # of the ranges of impedances and actuators
BELOW = (2e-3, 5e-3, 0.03, 0.15, 0.5)
BEYOND = (2e-3, 5e-3, 0.03, 0.15)
COEFFICIENTS = ("numerator", "denominator")


@dataclass(frozen=True)
class Weakest:
    """Where a perturbation breaks something first, to first order: its size, the constraint, the point."""

    size: float
    constraint: Constraint
    point: Point


def holds(family: Family, required: Required, v: Fraction) -> bool:
    """Whether everything required is proven for every controller within a relative distance v."""
    if v >= family.proper_within or not CellProver(replace(family, tolerance=v)).decide(required).low > 0:
        return False
    boxed = CellProver(replace(family, tolerance=v, loads=True))
    if not (excluded(boxed, "free") and excluded(boxed, "locked")):
        return False
    banded = [IDEAL[c.id, c.form] for c, _ in required if (c.id, c.form) in IDEAL and c.band != WHOLE]
    ideal = replace(boxed.family, setting=Setting.of(family.setting.spec.behind_ideal_actuator)) if banded else None
    return ideal is None or all(excluded(CellProver(ideal), end) for end in banded)


def weakest(family: Family, required: Required) -> Weakest | None:
    """The smallest perturbation that breaks a constraint, by first-order effects on a grid refined around it."""
    best: Weakest | None = None
    for constraint, v in required:
        prover = CellProver(replace(family, tolerance=TRIAL))
        omega = np.unique(np.concatenate([_frequencies(cells) for cells in prover.axis(constraint.band)]))
        for _ in range(4 if omega.size else 0):  # a band without any cell has nothing to break
            found = _on_grid(prover, constraint, v, omega)
            if found is None:
                break
            best = found if best is None or found.size < best.size else best
            k = int(np.argmin(np.abs(omega - found.point.omega)))
            omega = np.unique(np.linspace(omega[max(k - 1, 0)], omega[min(k + 1, omega.size - 1)], 60))
    return best


def _frequencies(cells: Cells) -> NDArray[np.float64]:
    """Ends of cells [rad/s], those at 0 and ∞ apart."""
    z = cells.z[cells.z > 0]
    return 1 / z if cells.part is Part.HIGH else z


def _on_grid(prover: CellProver, constraint: Constraint, v: Fraction, omega: NDArray[np.float64]) -> Weakest | None:
    controller = _of_controller(prover.family)
    best: Weakest | None = None
    for vertex in islice(product((-1.0, 1.0), repeat=int((~controller).sum())), MOST_VERTICES):
        at_vertex = Cells.at(omega, controller.size)
        at_vertex.t[:, ~controller] = np.array(vertex)[None, :, None]
        for index, form in enumerate(prover.slacks(constraint, v, at_vertex)):
            slopes = form.c[2:]
            reach = np.abs(slopes).sum(axis=0)
            sizes = np.where(np.isfinite(form.rho) & (reach > 0), form.c[0] / reach * float(TRIAL), np.inf)
            k = int(np.argmin(sizes))
            if np.isfinite(sizes[k]) and (best is None or sizes[k] < best.size):
                corner = np.where(controller, -np.sign(slopes[:, k]), at_vertex.t[0, :, k])
                point = Point(at_vertex[[k]].points(corner[:, None]), 0, 0.0, index)
                best = Weakest(float(sizes[k]), constraint, point)
    return best


def levels(family: Family, found: Weakest | None, asked: Fraction | None) -> Iterator[Fraction]:
    """Tolerances worth trying, hardest first."""
    size = min(LARGEST, float(family.proper_within), *([] if found is None else [found.size]))
    for below in BELOW:
        v = short(size * (1 - below), up=False) if size > 0 else Fraction(0)
        if v > (asked or 0):
            yield v
    if asked is not None:
        yield asked


def largest(
    family: Family, required: Required, asked: Fraction
) -> tuple[Fraction | None, tuple[Fraction, Witness] | None]:
    """The largest tolerance that is proven, at least the one asked for, and its twin."""
    weak = weakest(family, required)
    proven = next((v for v in levels(family, weak, asked) if holds(family, required, v)), None)
    return proven, None if weak is None else twin(family, weak, proven)


def twin(family: Family, found: Weakest, proven: Fraction | None) -> tuple[Fraction, Witness] | None:
    """A controller just beyond the tolerance for which the weakest constraint fails, at an exact point."""
    point, level = found.point, found.constraint.level or Fraction(0)
    z, others = np.full((2, 1), float(short(point.omega, digits=12))), ~_of_controller(replace(family, tolerance=TRIAL))
    for beyond in BEYOND:
        v = short(found.size * (1 + beyond), up=True)
        if v >= 1 or v <= (proven or 0):
            continue
        values = replace(family, tolerance=v).point(point.cells, point.k)
        numerator, denominator = (
            fmpq_poly([values.get(f"{part}.{k}", c) for k, c in enumerate(getattr(family, part).coeffs())])
            for part in COEFFICIENTS
        )
        prover = CellProver(replace(family, numerator=numerator, denominator=denominator))
        at = replace(point, cells=Cells(Part.MIDDLE, z, point.cells.t[:, others]))
        if float(prover.slacks(found.constraint, level, at.cells)[at.form].upper[0]) < 0:
            coefficients = Polynomials(numerator=descending(numerator), denominator=descending(denominator))
            claim = (found.constraint.id, found.constraint.form)
            return v, replace(prover.witness(found.constraint, at), controller=coefficients, claim=claim)
    return None


def itself(family: Family, broken: Claim) -> tuple[Fraction, Witness] | None:
    """The controller as it is, where a claim about it is refuted at a frequency: no tolerance holds."""
    if broken.refuted_at is None or broken.refuted_at.witness is None:
        return None
    own = Polynomials(numerator=descending(family.numerator), denominator=descending(family.denominator))
    return Fraction(0), replace(broken.refuted_at.witness, controller=own, claim=(broken.id, broken.form))


def _of_controller(family: Family) -> NDArray[np.bool_]:
    """Which parameters are coefficients of the controller."""
    return np.array([name.startswith(COEFFICIENTS) for name in family.parameters])
