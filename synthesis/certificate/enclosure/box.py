"""Robust stability of a box: how far it may be stretched about the nominal joint, proven by zero exclusion.

With a stable nominal joint no root crosses the axis if f(jω) ≠ 0 for every ω and every parameter. f is affine in load
and impedance, so on a cell it fills a zonotope; 0 is outside if a normal of one of its edges says so.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import islice, product
from typing import TYPE_CHECKING, Any

import numpy as np

from ....models.rational import exact, to_float
from ...problem.constraints.inequality import WHOLE
from ...problem.grid import float_roots
from ..hurwitz import is_hurwitz
from ..outcome import Outcome
from ..witness import Witness, short
from .cells import Cells, Part
from .form import Form
from .joint import Family, JointOnCells
from .prover import CellProver, witness_of
from .wave import Wave
from .winding import ENDS, MOST_CELLS, ROUNDS, turns

if TYPE_CHECKING:
    from numpy.typing import NDArray

LARGEST_SPREAD = 1000.0
REFINEMENTS, BASINS = 5, 8  # of the grid around its lowest minima
MOST_VERTICES = 128
DENSE = 6000  # frequencies where the spread is looked for first
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
    centre = _unstable(family, end, Fraction(0), np.zeros(len(replace(family, loads=True).parameters)), 0.0)
    if centre is not None:  # nothing has to cross the axis
        return Spread(Outcome.REFUTED, None, Fraction(1), centre)
    critical = list(_critical(family, end))
    v, t, omega = min(critical, key=_size, default=(LARGEST_SPREAD, None, 0.0))
    proven = None
    for tightness in (6e-3, 2e-2, 0.1):
        value = short(min(v * (1 - tightness), LARGEST_SPREAD), up=False)
        if value >= 1 and excluded(CellProver(replace(family, spread=value, loads=True)), end):
            proven = value
            break
    if proven is None and v > 1 and excluded(CellProver(replace(family, spread=Fraction(1), loads=True)), end):
        proven = _bisected(family, end, min(v, LARGEST_SPREAD))
    refuted, witness = None, None
    if t is not None:
        for tightness in (1e-3, 4e-3, 1e-2, 0.05):
            value = max(short(v * (1 + tightness), up=True), Fraction(1) if v < 1 else Fraction(0))
            witness = _unstable(family, end, value, t, omega)
            if witness is not None:
                refuted = value
                break
    if refuted is None and proven is not None:
        refuted, witness = _unstable_vertex(family, end, proven)
    if proven is not None and proven >= 1:
        return Spread(Outcome.PROVEN, proven, refuted, witness)
    return Spread(
        Outcome.REFUTED if refuted is not None and refuted <= 1 else Outcome.UNDECIDED, None, refuted, witness
    )


def _unstable_vertex(family: Family, end: str, proven: Fraction) -> tuple[Fraction | None, Witness | None]:
    """A vertex of the box, stretched a little further, that is unstable: where f is not affine in the parameters."""
    m = len(replace(family, loads=True).parameters)
    for beyond in (2e-3, 8e-3, 0.03, 0.1, 0.5):
        value = short(float(proven) * (1 + beyond), up=True)
        for signs in islice(product((-1.0, 1.0), repeat=m), MOST_VERTICES):
            witness = _unstable(family, end, value, np.array(signs), np.inf)
            if witness is not None:
                return value, witness
    return None, None


def _bisected(family: Family, end: str, v: float) -> Fraction:
    """The largest spread below v that a few proofs reach, given that 1 is proven."""
    low, high = 1.0, v
    for _ in range(7):
        middle = short((low * high) ** 0.5, up=False)
        if middle > 1 and excluded(CellProver(replace(family, spread=middle, loads=True)), end):
            low = float(middle)
        else:
            high = float(middle)
    return short(low, up=False)


@np.errstate(all="ignore")
def excluded(prover: CellProver, end: str) -> bool:
    """Whether f(jω) ≠ 0 on [0, ∞] for every parameter of the family."""
    for cells in prover.axis(WHOLE):
        waiting = cells
        for _ in range(ROUNDS):
            f = ENDS[end](JointOnCells(prover.family, waiting))
            away = _leading(f, waiting) if waiting.part is not Part.MIDDLE else _separated(f)
            waiting = waiting[~away]
            if not waiting.size:
                break
            waiting = waiting.split_frequency()
            if waiting.size > MOST_CELLS:
                return False
        if waiting.size:
            return False
    return True


def _leading(f: Wave, cells: Cells) -> NDArray[np.bool_]:
    """At the ends the leading of the two parts must keep its sign; a cell away from the end may use either."""
    away = np.zeros(f.x.rho.size, dtype=bool)
    real, imaginary = _orders(f, cells.part)
    for part, leads in ((f.p, real <= imaginary), (f.q, imaginary <= real)):
        if isinstance(part, Form):
            signed = (part.lower > 0) | (part.upper < 0)
            away |= signed & (leads | (cells.z[0] > 0))
    return away


def _orders(f: Wave, part: Part) -> tuple[int, int]:
    """Orders in z of real and imaginary part; ω itself is z or 1/z."""
    p, q = (side.order if isinstance(side, Form) else 10**6 for side in (f.p, f.q))
    return p, q + (1 if part is Part.LOW else -1)


def _plane(f: Wave) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Coefficients (1+m, n) of p and q, and their ρ."""
    zero = f.x.constant(0)
    p, q = (part if isinstance(part, Form) else zero for part in (f.p, f.q))
    return p.c, q.c, p.rho, q.rho


def _separated(f: Wave) -> NDArray[np.bool_]:
    """Whether a direction separates the zonotope from 0 in the plane (p, q): its centre's, or a normal of an edge."""
    p, q, p_rho, q_rho = _plane(f)
    unit = np.maximum(np.abs(q).max(axis=0), 1e-300) / np.maximum(np.abs(p).max(axis=0), 1e-300)
    p, p_rho = p * unit, p_rho * unit  # both of one size, or directions lose their digits
    away = np.zeros(p.shape[1], dtype=bool)
    for a, b in [(p[0], q[0]), *((q[i], -p[i]) for i in range(1, len(p)))]:
        along = a * p + b * q
        reach = np.abs(along[1:]).sum(axis=0) + np.abs(a) * p_rho + np.abs(b) * q_rho
        reach = reach * (1 + 1e-9) + 1e-13 * (np.abs(a) * np.abs(p).sum(axis=0) + np.abs(b) * np.abs(q).sum(axis=0))
        away |= np.abs(along[0]) > reach
    return away


def _critical(family: Family, end: str) -> Iterator[tuple[float, NDArray[np.float64], float]]:
    """For each frequency of a grid: the spread at which 0 enters, its parameters t in units of the box, and ω."""
    prover = CellProver(replace(family, loads=True))
    m, offset = len(prover.family.parameters), _offset(prover.family)
    omega = np.concatenate([cells.z.mean(axis=0) for cells in prover.axis(WHOLE) if cells.part is Part.MIDDLE])
    dense = np.geomspace(omega[0], omega[-1], DENSE)
    omega = np.unique([*(omega[0] * DECADES), *omega, *dense, *(omega[-1] / DECADES), *_resonances(family, end)])
    grids = [omega]
    for _ in range(REFINEMENTS):
        lowest: list[tuple[Any, ...]] = []
        for grid in grids:
            p, q, _, _ = _plane(ENDS[end](JointOnCells(prover.family, Cells.at(grid, m))))
            v, entering = _entering(p, grid * q, offset)
            padded = np.concatenate([[np.inf], v, [np.inf]])
            for k in np.flatnonzero((v <= padded[:-2]) & (v <= padded[2:]) & np.isfinite(v)).tolist():
                around = grid[max(k - 1, 0)], grid[min(k + 1, v.size - 1)]
                lowest.append((float(v[k]), entering[:, k], float(grid[k]), *around))
        lowest = sorted(lowest, key=_size)[:BASINS]
        yield from ((v, t, omega) for v, t, omega, *_ in lowest)
        grids = [np.geomspace(low, high, 60) for *_, low, high in lowest]
    for part, end_of_axis in ((Part.LOW, 0.0), (Part.HIGH, np.inf)):
        t = np.ones((2, m, 1))
        t[0] = -1.0
        f = ENDS[end](JointOnCells(prover.family, Cells(part, np.zeros((2, 1)), t)))
        leading = f.p if _orders(f, part)[0] <= _orders(f, part)[1] else f.q
        if isinstance(leading, Form):
            v, t_end = _entering(leading.c, 0 * leading.c, offset)
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


def _entering(
    p: NDArray[np.float64], q: NDArray[np.float64], offset: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Least v with 0 in `f_n + v·(f_d + zonotope)`, (n,), and the t in [−1, 1] that gets there, (m, n).

    p, q: (2+m, n), of the whole box; offset: its centre from the nominal joint, in halves of its widths, (m,).
    Normal to edge j all other parameters are at ±1; the j-th then has to cancel what is left along the edge.
    """
    f = np.delete(p + 1j * q, 1, axis=0)  # without the frequency's own coefficient
    f_d = (f[1:] * offset[:, None]).sum(axis=0)
    f_n = f[0] - f_d
    best, best_t = np.zeros(f.shape[1]), np.zeros((len(f) - 1, f.shape[1]))
    real = np.abs(f.imag).max(axis=0) < 1e-12 * np.abs(f.real).max(axis=0)
    for j in range(1, len(f) + 1):
        edge = f[j] if j < len(f) else np.where(real, 1j, 0)  # on the real line, any other direction
        across, away = np.imag(f[1:] * np.conj(edge)), np.imag(f_n * np.conj(edge))
        t = -np.sign(across) * np.sign(away)
        v = np.abs(away) / (np.abs(across).sum(axis=0) - np.sign(away) * np.imag(f_d * np.conj(edge)))
        if j < len(f):
            t[j - 1] = 0.0
            rest = f_n / v + f_d + (f[1:] * t).sum(axis=0)
            t[j - 1] = -np.real(rest * np.conj(edge)) / np.abs(edge) ** 2
            reached = (np.abs(t[j - 1]) <= 1 + 1e-9) & ~real
        else:
            reached = real
        better = reached & (v > best) & np.isfinite(v)
        best, best_t = np.where(better, v, best), np.where(better, t, best_t)
    return np.where(best > 0, best, np.inf), best_t


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
