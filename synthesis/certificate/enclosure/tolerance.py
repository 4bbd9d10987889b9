"""Tolerance: how far every coefficient of the controller may be off, each on its own, and all required still hold."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import islice, product
from typing import TYPE_CHECKING

import numpy as np

from ....models.rational import descending, exact, polynomial
from ...problem.constraints.inequality import Constraint
from ...spec.model import Polynomials
from ..witness import Witness, short
from .box import excluded
from .cells import Cells, Part
from .joint import Family
from .prover import CellProver, witness_at
from .search import Point

if TYPE_CHECKING:
    from numpy.typing import NDArray

Required = Sequence[tuple[Constraint, Fraction]]
TRIAL = Fraction(1, 10**9)  # perturbation whose first-order effect is measured
LARGEST = 0.5
MOST_VERTICES = 64  # of the ranges of impedances and actuators
BELOW = (2e-3, 5e-3, 0.03, 0.15, 0.5)
COEFFICIENTS = ("numerator", "denominator")


@dataclass(frozen=True)
class Weakest:
    """Where a perturbation breaks something first, to first order: its size, the constraint, the cell and the form."""

    size: float
    constraint: Constraint
    point: Point
    signs: NDArray[np.float64]


def holds(family: Family, required: Required, v: Fraction) -> bool:
    """Whether everything required is proven for every controller within a relative distance v."""
    perturbed = CellProver(replace(family, tolerance=v))
    if not perturbed.decide(required).low > 0:
        return False
    boxed = CellProver(replace(family, tolerance=v, loads=True))
    return excluded(boxed, "free") and excluded(boxed, "locked")


def weakest(family: Family, required: Required) -> Weakest | None:
    """The smallest perturbation that breaks a constraint, by first-order effects on a grid refined around it."""
    best: Weakest | None = None
    for constraint, v in required:
        prover = CellProver(replace(family, tolerance=TRIAL))
        omega = np.concatenate([c.z.ravel() for c in prover.axis(constraint.band) if c.part is Part.MIDDLE])
        ends = [float(end) for end in constraint.band if end]
        omega = np.unique([*omega, *ends])
        for _ in range(4):
            found = _on_grid(prover, constraint, v, omega)
            if found is None:
                break
            best = found if best is None or found.size < best.size else best
            k = int(np.argmin(np.abs(omega - found.point.omega)))
            omega = np.unique(np.linspace(omega[max(k - 1, 0)], omega[min(k + 1, omega.size - 1)], 60))
    return best


def _on_grid(prover: CellProver, constraint: Constraint, v: Fraction, omega: NDArray[np.float64]) -> Weakest | None:
    names = list(prover.family.parameters)
    controller = np.array([name.startswith(COEFFICIENTS) for name in names])
    best: Weakest | None = None
    for vertex in islice(product((-1.0, 1.0), repeat=int((~controller).sum())), MOST_VERTICES):
        t = np.ones((2, len(names), omega.size))
        t[0] = -1.0
        t[:, ~controller] = np.array(vertex)[None, :, None]
        at_vertex = Cells(Part.MIDDLE, np.vstack([omega, omega]), t)
        for index, form in enumerate(prover.slacks(constraint, v, at_vertex)):
            slopes = form.c[2:]
            reach = np.abs(slopes).sum(axis=0)
            sizes = np.where(np.isfinite(form.rho) & (reach > 0), form.c[0] / reach * float(TRIAL), np.inf)
            k = int(np.argmin(sizes))
            if np.isfinite(sizes[k]) and (best is None or sizes[k] < best.size):
                signs = np.where(controller, -np.sign(slopes[:, k]), t[0, :, k])
                point = Point(at_vertex[[k]].points(signs[:, None]), 0, 0.0, index)
                best = Weakest(float(sizes[k]), constraint, point, signs)
    return best


def levels(found: Weakest | None, asked: Fraction | None) -> Iterator[Fraction]:
    """Tolerances worth trying, hardest first."""
    size = min(LARGEST if found is None else found.size, LARGEST)
    for below in BELOW:
        v = short(size * (1 - below), up=False) if size > 0 else Fraction(0)
        if v > (asked or 0):
            yield v
    if asked is not None:
        yield asked


def twin(family: Family, found: Weakest, proven: Fraction | None) -> tuple[Fraction, Witness] | None:
    """A controller just beyond the tolerance for which the weakest constraint fails, at an exact point."""
    omega = short(found.point.omega, digits=12)
    names = list(family_names(family))
    for beyond in (2e-3, 5e-3, 0.03, 0.15):
        v = short(found.size * (1 + beyond), up=True)
        if v >= 1 or v <= (proven or 0):
            continue
        numerator, denominator = (
            _moved(getattr(family, part).coeffs(), part, names, found.signs, v) for part in COEFFICIENTS
        )
        moved = replace(family, numerator=numerator, denominator=denominator)
        prover = CellProver(moved)
        z = np.full((2, 1), float(omega))
        others = [k for k, name in enumerate(names) if not name.startswith(COEFFICIENTS)]
        t = np.repeat(found.signs[others][None, :, None], 2, axis=0)
        level = next(v for c, v in [(found.constraint, found.constraint.level or Fraction(0))])
        at = Cells(Part.MIDDLE, z, t)
        forms = prover.slacks(found.constraint, level, at)
        if float(forms[found.point.form].upper[0]) < 0:
            joint = prover.joint(at)
            loads = [q.load for q in prover.inequalities(found.constraint, joint) for _ in joint.sides(q, 1)]
            witness = witness_at(moved, Point(at, 0, 0.0, found.point.form), omega, loads[found.point.form])
            controller = Polynomials(numerator=descending(numerator), denominator=descending(denominator))
            return v, replace(witness, controller=controller, claim=(found.constraint.id, found.constraint.form))
    return None


def family_names(family: Family) -> list[str]:
    """Names of the parameters when coefficients are among them."""
    return list(replace(family, tolerance=TRIAL).parameters)


def _moved(coefficients: list, part: str, names: list[str], signs: NDArray[np.float64], v: Fraction):  # type: ignore[no-untyped-def, type-arg]
    """The polynomial with each coefficient at the end of its interval that does harm."""
    moved = []
    for k, c in enumerate(coefficients):
        name = f"{part}.{k}"
        sign = int(signs[names.index(name)]) if name in names else 0
        moved.append(c + abs(c) * exact(v) * sign)
    return polynomial(moved[::-1])
