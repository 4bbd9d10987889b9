"""Stability where Routh cannot answer: with a hold (winding number), and of every joint of a box (zero exclusion).

winding  φ = f/f_ref, f_ref Hurwitz of f's degree without the hold: when φ(jω) does not turn around 0 from ω = 0 to ∞,
         f has no root with Re s ≥ 0 (argument principle: f is entire, and the held part decays against the rest).
box      with a stable nominal joint, no root crosses the axis if f(jω) ≠ 0 for every ω and every parameter. f is affine
         in load and impedance, so on a cell it fills a zonotope; 0 is outside if a normal of one of its edges says so.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from flint import fmpq_poly

from ....models.rational import exact
from ..hurwitz import is_hurwitz
from ..outcome import Outcome
from ..witness import Witness, short
from .cells import Cells, Part
from .form import Form
from .joint import Family, JointOnCells
from .prover import CellProver
from .wave import Wave

if TYPE_CHECKING:
    from numpy.typing import NDArray

WHOLE = (Fraction(0), None)
ROUNDS, MOST_CELLS = 24, 8_000
LARGEST_SPREAD = 1000.0
DECADES = np.geomspace(0.1, 1e-8, 8)  # towards the ends of the axis
Function = Callable[[JointOnCells], Wave]
ENDS: dict[str, Function] = {"free": JointOnCells.free, "locked": JointOnCells.locked}


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


@dataclass(frozen=True)
class Spread:
    """How far every parameter interval may be stretched about its nominal value: proven, and where it is too far."""

    outcome: Outcome
    proven: Fraction | None
    refuted: Fraction | None
    witness: Witness | None


def largest_spread(family: Family, end: str) -> Spread:
    """The robust stability margin of a box: the factor on it that keeps every joint stable."""
    critical = list(_critical(family, end))
    v, t, omega = min(critical, key=lambda found: found[0], default=(LARGEST_SPREAD, None, 0.0))
    proven = None
    for tightness in (1e-3, 4e-3, 1e-2, 0.1):
        value = short(min(v * (1 - tightness), LARGEST_SPREAD), up=False)
        if value >= 1 and excluded(CellProver(replace(family, spread=value, loads=True)), end):
            proven = value
            break
    if proven is None and v > 1 and excluded(CellProver(replace(family, spread=Fraction(1), loads=True)), end):
        proven = Fraction(1)
    refuted, witness = None, None
    if t is not None:
        for tightness in (1e-3, 4e-3, 1e-2, 0.05):
            value = max(short(v * (1 + tightness), up=True), Fraction(1) if v < 1 else Fraction(0))
            witness = _unstable(family, end, value, t * float(value) / v, omega)
            if witness is not None:
                refuted = value
                break
    if proven is not None and proven >= 1:
        return Spread(Outcome.PROVEN, proven, refuted, witness)
    return Spread(
        Outcome.REFUTED if refuted is not None and refuted <= 1 else Outcome.UNDECIDED, None, refuted, witness
    )


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
    m = len(prover.family.parameters)
    omega = np.concatenate([cells.z.mean(axis=0) for cells in prover.axis(WHOLE) if cells.part is Part.MIDDLE])
    omega = np.concatenate([omega[0] * DECADES[::-1], omega, omega[-1] / DECADES])
    for _ in range(4):
        t = np.ones((2, m, omega.size))
        t[0] = -1.0
        cells = Cells(Part.MIDDLE, np.vstack([omega, omega]), t)
        p, q, _, _ = _plane(ENDS[end](JointOnCells(prover.family, cells)))
        best = _entering(p, omega * q)
        k = int(np.argmin([v for v, _ in best]))
        yield best[k][0], best[k][1], float(omega[k])
        omega = np.geomspace(omega[max(k - 1, 0)], omega[min(k + 1, omega.size - 1)], 200)
    for part, end_of_axis in ((Part.LOW, 0.0), (Part.HIGH, np.inf)):
        t = np.ones((2, m, 1))
        t[0] = -1.0
        f = ENDS[end](JointOnCells(prover.family, Cells(part, np.zeros((2, 1)), t)))
        leading = f.p if _orders(f, part)[0] <= _orders(f, part)[1] else f.q
        if isinstance(leading, Form):
            slopes = leading.c[2:, 0]
            v = abs(leading.c[0, 0]) / max(float(np.abs(slopes).sum()), 1e-300)
            yield float(v), -np.sign(slopes) * np.sign(leading.c[0, 0]) * v, end_of_axis


def _entering(p: NDArray[np.float64], q: NDArray[np.float64]) -> list[tuple[float, NDArray[np.float64]]]:
    """Least v with 0 in `f₀ + v·zonotope`, by its edge normals, and the t that gets there. p, q: (2+m, n)."""
    p, q = np.delete(p, 1, axis=0), np.delete(q, 1, axis=0)  # without the frequency's own coefficient
    found = []
    for k in range(p.shape[1]):
        f = p[:, k] + 1j * q[:, k]
        best: tuple[float, NDArray[np.float64]] = (0.0, np.zeros(f.size - 1))
        for j in range(1, f.size):
            if f[j] == 0:
                continue
            across = np.imag(f * np.conj(f[j]))
            reach = np.abs(across[1:]).sum()
            v = abs(across[0]) / reach if reach > 0 else np.inf
            t = -np.sign(across[1:]) * np.sign(across[0]) * v
            along = np.real(f * np.conj(f[j]))
            t[j - 1] = 0.0
            t[j - 1] = -(along[0] + along[1:] @ t) / abs(f[j]) ** 2
            v = max(v, float(np.abs(t).max())) if np.isfinite(v) else np.inf
            if v > best[0] and abs(t[j - 1]) <= abs(v) * (1 + 1e-9):
                best = (float(v), t)
        sizes = np.abs(np.real(f)), np.abs(np.imag(f))
        if sizes[1].max() < 1e-12 * sizes[0].max():  # on the real line
            v = sizes[0][0] / max(sizes[0][1:].sum(), 1e-300)
            best = (float(v), -np.sign(np.real(f[1:])) * np.sign(np.real(f[0])) * v)
        found.append(best if best[0] > 0 else (np.inf, best[1]))
    return found


def _unstable(family: Family, end: str, value: Fraction, t: NDArray[np.float64], omega: float) -> Witness | None:
    """The joint at parameters t (in units of the box) if it lies in the stretched box and is proven unstable."""
    whole = replace(family, spread=Fraction(1), loads=True)
    values = {}
    for (name, (low, high)), share in zip(whole.parameters.items(), t, strict=True):
        share = max(min(share, float(value)), -float(value))
        values[name] = (low + high) / 2 + (high - low) / 2 * exact(short(share, digits=9) if share else Fraction(0))
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
    named = {k.split(".")[0] for k in values}
    return Witness(
        short(omega) if np.isfinite(omega) else None,
        load if "load" in named else None,
        impedance=setting.loop.desired if "impedance" in named else None,
        actuator=setting.elastic if "actuator" in named else None,
    )
