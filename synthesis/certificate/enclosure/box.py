"""Robust stability of a box: how far it may be stretched about the nominal joint, proven by zero exclusion.

With a stable nominal joint no root crosses the axis if f(jω) ≠ 0 for every ω and every parameter (`exclusion`). Where f
is affine in all of them, floats find the margin and one proof does; with uncertain actuators it is narrowed from both
sides, by proofs and by joints proven unstable where a proof fails.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import numpy as np

from ....models.rational import exact, to_float
from ...problem.constraints.inequality import WHOLE
from ...problem.grid import float_roots
from ..hurwitz import is_hurwitz
from ..outcome import Outcome
from ..witness import Witness, short
from .cells import Cells, Part
from .exclusion import crossing, entering, orders, plane
from .form import Form
from .joint import Family, JointOnCells
from .prover import CellProver, witness_of
from .winding import ENDS, turns

if TYPE_CHECKING:
    from numpy.typing import NDArray

LARGEST_SPREAD = 1000.0
REFINEMENTS, BASINS = 3, 8  # of the grid around its lowest minima
PROOFS = 14  # of a box, most of them short
BELOW = 6e-3  # how far below the spread that floats find a proof is tried first
CLOSE = 1 + 9e-3  # a sandwich of this ratio is close enough
DENSE = 3000  # frequencies where the spread is looked for first
DECADES = np.geomspace(0.1, 1e-8, 8)  # towards the ends of the axis


@dataclass(frozen=True)
class Spread:
    """How far every parameter interval may be stretched about its nominal value: proven, and where it is too far."""

    outcome: Outcome
    proven: Fraction | None
    refuted: Fraction | None
    witness: Witness | None


@np.errstate(all="ignore")
def largest_spread(family: Family, end: str) -> Spread:
    """The robust stability margin of a box: the factor on it that keeps every joint stable."""
    names = replace(family, loads=True).parameters
    centre = _unstable(family, end, Fraction(0), np.zeros(len(names)), 0.0)
    if centre is not None:  # nothing has to cross the axis
        return Spread(Outcome.REFUTED, None, Fraction(1), centre)
    v, t, omega = min(_critical(family, end), key=_size, default=(LARGEST_SPREAD, None, 0.0))
    low, high, witness = None, *(_beyond(family, end, v, t, omega) if t is not None else (None, None))
    blocked, value = high or Fraction(LARGEST_SPREAD), short(min(v, LARGEST_SPREAD) * (1 - BELOW), up=False)
    for _ in range(PROOFS):
        value = max(value, Fraction(1))
        found = crossing(CellProver(replace(family, spread=value, loads=True)), end)
        if found is None:
            low = value
        else:
            blocked = min(blocked, value)
            worse = _beyond(family, end, float(value) * min(found.share, 1), found.t, found.omega)
            if worse[0] is not None and (high is None or worse[0] < high):
                high, witness = worse
        if blocked <= 1 or (low is not None and blocked <= low * CLOSE):
            break
        value = _between(low, blocked, None if found is None else found.share)
    if low is not None:
        return Spread(Outcome.PROVEN, low, high, witness)
    return Spread(Outcome.REFUTED if high is not None and high <= 1 else Outcome.UNDECIDED, None, high, witness)


def _between(low: Fraction | None, blocked: Fraction, share: float | None) -> Fraction:
    """The next value to try: a little below where a zonotope would just reach 0, or half way."""
    half = min((float(low or 1) * float(blocked)) ** 0.5, 2 * float(low or 1))
    near = float(blocked) * (share or 0.0) * (1 - BELOW)
    return short(max(near, half), up=False) if near < 0.99 * float(blocked) else short(half, up=False)


def _beyond(
    family: Family, end: str, v: float, t: NDArray[np.float64], omega: float
) -> tuple[Fraction | None, Witness | None]:
    """The first spread a little beyond v, and at least 1 where v is below, at which the joint at t is unstable."""
    for further in (1e-3, 4e-3, 1e-2, 0.05):
        value = max(short(v * (1 + further), up=True), Fraction(1) if v < 1 else Fraction(0))
        witness = _unstable(family, end, value, t, omega)
        if witness is not None:
            return value, witness
    return None, None


def _critical(family: Family, end: str) -> Iterator[tuple[float, NDArray[np.float64], float]]:
    """For each frequency of a grid: the spread at which 0 enters, its parameters t in units of the box, and ω."""
    prover = CellProver(replace(family, loads=True))
    m, offset = len(prover.family.parameters), _offset(prover.family)
    omega = np.concatenate([cells.z.mean(axis=0) for cells in prover.axis(WHOLE) if cells.part is Part.MIDDLE])
    dense = np.geomspace(omega[0], omega[-1], DENSE)
    omega = np.unique([*(omega[0] * DECADES), *omega, *dense, *(omega[-1] / DECADES), *_resonances(family, end)])
    for _ in range(REFINEMENTS):
        p, q, _, _ = plane(ENDS[end](JointOnCells(prover.family, Cells.at(omega, m))))
        v, there = entering(p, omega * q, offset)
        padded = np.concatenate([[np.inf], v, [np.inf]])
        lowest = np.flatnonzero((v <= padded[:-2]) & (v <= padded[2:]) & np.isfinite(v))
        lowest = lowest[np.argsort(v[lowest])[:BASINS]]
        yield from ((float(v[k]), there[:, k], float(omega[k])) for k in lowest.tolist())
        around = [(omega[max(k - 1, 0)], omega[min(k + 1, v.size - 1)]) for k in lowest.tolist()]
        omega = np.unique([z for low, high in around for z in np.geomspace(low, high, 60)])
        if not omega.size:
            break
    for part, end_of_axis in ((Part.LOW, 0.0), (Part.HIGH, np.inf)):
        t = np.ones((2, m, 1))
        t[0] = -1.0
        f = ENDS[end](JointOnCells(prover.family, Cells(part, np.zeros((2, 1)), t)))
        leading = f.p if orders(f, part)[0] <= orders(f, part)[1] else f.q
        if isinstance(leading, Form):
            v, t_end = entering(leading.c, 0 * leading.c, offset)
            if np.isfinite(v[0]):
                yield float(v[0]), t_end[:, 0], end_of_axis


def _offset(family: Family) -> NDArray[np.float64]:
    """How far the centre of each parameter's interval is from its nominal value, in halves of the interval. (m,)."""
    shares = [
        ((low + high) / 2 - family.middle(name)) / ((high - low) / 2) for name, (low, high) in family.parameters.items()
    ]
    return np.array([to_float(share) for share in shares])


def _size(found: tuple[Any, ...]) -> float:
    return float(found[0])


def _resonances(family: Family, end: str) -> list[float]:
    """Frequencies near the roots of the joints at the corners, without hold: where f comes close to 0."""
    setting, found = family.setting, []
    C = setting.build(family.numerator, family.denominator)
    for vertex in setting.vertices():
        loads = setting.uncertainty.corners() if end == "free" else (setting.loop.nominal,)
        for load in loads:
            f = (vertex.loop.free(load) if end == "free" else vertex.loop.locked())(C)
            for root in float_roots(f):
                width = max(abs(root.real), 1e-6 * abs(root))
                found += [abs(root.imag) + width * x for x in np.linspace(-3, 3, 13)]
    return [omega for omega in found if omega > 0]


def _unstable(family: Family, end: str, value: Fraction, t: NDArray[np.float64], omega: float) -> Witness | None:
    """The joint at parameters t, in [−1, 1], of the box stretched by `value`, if it is proven unstable."""
    whole = replace(family, spread=Fraction(1), loads=True)
    values = {}
    for (name, (low, high)), share in zip(whole.parameters.items(), t, strict=True):
        nominal_value, at = whole.middle(name), exact(min(max(short(share, digits=9), Fraction(-1)), Fraction(1)))
        values[name] = nominal_value + exact(value) * ((low + high) / 2 + (high - low) / 2 * at - nominal_value)
    setting = family.setting.at({k: v for k, v in values.items() if not k.startswith("load.")})
    nominal = setting.loop.nominal
    load = replace(nominal, **{k.split(".")[1]: v for k, v in values.items() if k.startswith("load.")})
    C = setting.build(family.numerator, family.denominator)
    if setting.loop.actuator.hold is None:
        stable = is_hurwitz((setting.loop.free(load) if end == "free" else setting.loop.locked())(C))
    else:
        one = Family(setting, family.numerator, family.denominator, single=True, load=load)
        stable = turns(CellProver(one), end) in (0, None)
    if stable:
        return None
    frequency = short(omega) if np.isfinite(omega) else None
    return witness_of(setting, values, frequency, load if any(k.startswith("load.") for k in values) else None)
