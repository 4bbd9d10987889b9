"""Stability with a hold, where Routh cannot answer: the winding number of the characteristic function.

φ = f/f_ref, f_ref Hurwitz of f's degree without the hold: when φ(jω) does not turn around 0 from ω = 0 to ∞, f has no
root with Re s ≥ 0 (argument principle: f is entire, and the held part decays against the rest).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from flint import fmpq_poly

from ....models.rational import exact
from ...problem.constraints.inequality import WHOLE
from ..witness import short
from .cells import Cells, Part
from .form import Form
from .joint import JointOnCells
from .prover import CellProver
from .wave import Wave

if TYPE_CHECKING:
    from numpy.typing import NDArray

ROUNDS, MOST_CELLS = 24, 30_000
Function = Callable[[JointOnCells], Wave]
ENDS: dict[str, Function] = {"free": JointOnCells.free, "locked": JointOnCells.locked}


@np.errstate(all="ignore")
def turns(prover: CellProver, end: str) -> int | None:
    """Quarter turns of φ(jω) around 0 from ω = 0 to ∞; 0: stable. None: could not be followed."""
    reference = _reference(prover, end)
    planes: list[tuple[float, int]] = []
    for cells in prover.axis(WHOLE):
        waiting = cells
        for _ in range(ROUNDS):
            joint = JointOnCells(prover.family, waiting)
            plane = _half_planes(ENDS[end](joint) / joint.s.real_number(reference))
            known = plane >= 0
            planes += list(zip(_position(waiting)[known], plane[known], strict=True))
            waiting = waiting[~known]
            if not waiting.size:
                break
            waiting = waiting.split_frequency()
            if waiting.size > MOST_CELLS:  # such as where the behaviour at infinity depends on the hold
                return None
        if waiting.size:
            return None
    sequence = [plane for _, plane in sorted(planes)]
    total = 0
    for a, b in pairwise(sequence):
        step = (b - a + 1) % 4 - 1
        if step == 2:
            return None
        total += step
    return total if sequence[0] % 2 == 0 and sequence[-1] % 2 == 0 else None


def _reference(prover: CellProver, end: str) -> fmpq_poly:
    """`(s+a)^n`, n the degree of f without what is held, a in the middle of the joint's frequencies."""
    setting, family = prover.family.setting, prover.family
    C = setting.build(family.numerator, family.denominator)
    loop = setting.loop
    unheld = replace(loop, actuator=replace(loop.actuator, h=fmpq_poly([0])))
    f = (unheld.free(loop.nominal) if end == "free" else unheld.locked())(C)
    scales = next(cells.z for cells in prover.axis(WHOLE) if cells.part is Part.MIDDLE)
    a = exact(short(float(np.sqrt(scales.min() * scales.max()))))
    lead = f.leading_coefficient()
    p = fmpq_poly([lead])
    for _ in range(f.degree()):
        p = p * fmpq_poly([a, 1])
    return p


def _half_planes(φ: Wave) -> NDArray[np.int_]:
    """0: Re > 0, 1: Im > 0, 2: Re < 0, 3: Im < 0, −1: not known; the ends of the axis are real."""
    plane = np.full(φ.x.rho.size, -1)
    parts = [(φ.p, 0, 2)] if φ.x.z is not None else [(φ.q, 1, 3), (φ.p, 0, 2)]
    for part, positive, negative in parts:
        if isinstance(part, Form) and part.order <= 0:
            plane = np.where(part.lower > 0, positive, np.where(part.upper < 0, negative, plane))
    return plane


def _position(cells: Cells) -> NDArray[np.float64]:
    """ω in the middle of each cell; where 1/z grows without bound the order still counts."""
    z = cells.z.mean(axis=0)
    return np.asarray(1 / z if cells.part is Part.HIGH else z)
