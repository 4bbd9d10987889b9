"""Zero exclusion: f(jω) ≠ 0 at every ω and for all parameters, cell by cell.

f is affine in load, impedance and the controller's coefficients: at a fixed actuator it fills a zonotope. In each of
the actuator's parameters it is affine as well, one at a time, so that all its values lie in the convex hull of the
zonotopes at the corners of their box. 0 is outside if some direction of the plane says so.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np

from ...problem.constraints.inequality import WHOLE
from .cells import Cells, Part
from .form import Form
from .joint import JointOnCells
from .prover import CellProver
from .wave import Wave
from .winding import ENDS, MOST_CELLS, ROUNDS

if TYPE_CHECKING:
    from numpy.typing import NDArray

CERTAIN = 0.999  # a zonotope of which this share reaches 0 holds it, whatever the floats lose


@dataclass(frozen=True)
class Crossing:
    """Where f may be 0: parameters t in [−1, 1], (m,), at ω [rad/s].

    share: how much of the zonotope at this actuator reaches 0; 1 where none was found to.
    """

    t: NDArray[np.float64]
    omega: float
    share: float


def excluded(prover: CellProver, end: str) -> bool:
    """Whether f(jω) ≠ 0 on [0, ∞] for every parameter of the family."""
    return crossing(prover, end) is None


@np.errstate(all="ignore")
def crossing(prover: CellProver, end: str) -> Crossing | None:
    """None if f(jω) ≠ 0 on [0, ∞] for every parameter of the family; else where that could not be shown."""
    drive = [k for k, name in enumerate(prover.family.parameters) if name.startswith("actuator.")]
    for waiting in prover.axis(WHOLE):
        for _ in range(ROUNDS):
            corners = waiting.corners(drive)
            waves = [ENDS[end](JointOnCells(prover.family, corner)) for corner in corners]
            doubtful = ~off_zero(waves, waiting)
            if not doubtful.any():
                break
            cells, middles = waiting[doubtful], [_at_middle(f, doubtful) for f in waves]
            inside = ~off_zero(middles, cells)
            found = _reached(middles, [corner[doubtful] for corner in corners], inside)
            waiting = _halved(cells, middles, inside, drive)
            if found.share < CERTAIN or waiting.size > MOST_CELLS:
                return found
        else:
            return found
    return None


def off_zero(waves: list[Wave], cells: Cells) -> NDArray[np.bool_]:
    """On which cells 0 is outside of the hull of f's values at the corners."""
    return _separated(waves) if cells.part is Part.MIDDLE else _leading(waves, cells)


def _leading(waves: list[Wave], cells: Cells) -> NDArray[np.bool_]:
    """At the ends the leading of the two parts must keep its sign; a cell away from the end may use either."""
    away = np.zeros(cells.size, dtype=bool)
    order, size = np.array([orders(f, cells.part) for f in waves]).min(axis=0), cells.size
    for parts, leads in (([f.p for f in waves], order[0] <= order[1]), ([f.q for f in waves], order[1] <= order[0])):
        forms = [part for part in parts if isinstance(part, Form)]
        if len(forms) == len(waves) and len({form.order for form in forms}) == 1:
            above, below = np.ones(size, dtype=bool), np.ones(size, dtype=bool)
            for form in forms:
                above, below = above & (form.lower > 0), below & (form.upper < 0)
            away |= (above | below) & (leads | (cells.z[0] > 0))
    return away


def orders(f: Wave, part: Part) -> tuple[int, int]:
    """Orders in z of real and imaginary part; ω itself is z or 1/z."""
    p, q = (side.order if isinstance(side, Form) else 10**6 for side in (f.p, f.q))
    return p, q + (1 if part is Part.LOW else -1)


def plane(f: Wave) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Coefficients (1+m, n) of p and q, and their ρ."""
    zero = f.x.constant(0)
    p, q = (part if isinstance(part, Form) else zero for part in (f.p, f.q))
    return p.c, q.c, p.rho, q.rho


def _separated(waves: list[Wave]) -> NDArray[np.bool_]:
    """Whether a direction separates all zonotopes from 0 in the plane (p, q): the centres', or a normal of an edge."""
    p, q, p_rho, q_rho = (np.stack(part) for part in zip(*map(plane, waves), strict=True))
    unit = np.maximum(np.abs(q).max(axis=(0, 1)), 1e-300) / np.maximum(np.abs(p).max(axis=(0, 1)), 1e-300)
    p, p_rho = p * unit, p_rho * unit  # both of one size, or directions lose their digits
    away, rest = np.zeros(p.shape[2], dtype=bool), np.arange(p.shape[2])
    normals = [partial(_normal, corner, edge) for edge in range(p.shape[1]) for corner in range(len(waves))]
    for normal in [*normals, *(partial(_across, *pair) for pair in combinations(range(len(waves)), 2))]:
        a, b = normal(p, q)
        if not (a.any() or b.any()):
            continue
        along = a * p + b * q
        reach = np.abs(along[:, 1:]).sum(axis=1) + np.abs(a) * p_rho + np.abs(b) * q_rho
        lost = np.abs(a) * np.abs(p).sum(axis=1) + np.abs(b) * np.abs(q).sum(axis=1)
        reach = reach * (1 + 1e-9) + 1e-13 * lost
        done = (along[:, 0] > reach).all(axis=0) | (along[:, 0] < -reach).all(axis=0)
        away[rest[done]] = True
        rest, p, q, p_rho, q_rho = rest[~done], p[..., ~done], q[..., ~done], p_rho[:, ~done], q_rho[:, ~done]
        if not rest.size:
            break
    return away


def _normal(corner: int, edge: int, p: NDArray[np.float64], q: NDArray[np.float64]) -> tuple[Any, Any]:
    """The direction of a zonotope's centre, or a normal of one of its edges."""
    return (q[corner, edge], -p[corner, edge]) if edge else (p[corner, 0], q[corner, 0])


def _across(one: int, other: int, p: NDArray[np.float64], q: NDArray[np.float64]) -> tuple[Any, Any]:
    """A normal of the line between two centres, an edge of the hull where the zonotopes are small."""
    return q[one, 0] - q[other, 0], p[other, 0] - p[one, 0]


def _at_middle(f: Wave, which: NDArray[np.bool_]) -> Wave:
    """f in the middle of the frequencies of some cells, without what is not known of it there."""

    def fixed(part: Form | int) -> Form | int:
        if not isinstance(part, Form):
            return part
        c = part.c[:, which]
        c[1] = 0.0
        return Form(c, np.zeros(c.shape[1]), part.order)

    return Wave(fixed(f.p), fixed(f.q), Form(f.x.c[:, which], f.x.rho[which]))


def _reached(middles: list[Wave], corners: list[Cells], inside: NDArray[np.bool_]) -> Crossing:
    """The cell and corner whose zonotope, in the middle of the frequencies, needs least of itself to hold 0.

    Where none gets there, or nothing is left of the zonotopes: the one whose centre is nearest to 0.
    """
    found = []
    for f, cells in zip(middles, corners, strict=True):
        x, y = _values(f, cells)
        share, t = entering(x, y)
        share, near = np.where(inside, share, np.inf), np.hypot(x[0], y[0])
        k = int(np.argmin(share if np.isfinite(share).any() else near))
        z, moving = float(cells.z[:, k].mean()), cells.t[1, :, k] > cells.t[0, :, k]
        omega = z if cells.part is not Part.HIGH else 1 / z if z else np.inf
        at = Crossing(np.where(moving, t[:, k], cells.t[0, :, k]), omega, min(float(share[k]), 1.0))
        found.append((float(share[k]), float(near[k]), at))
    return min(found, key=lambda one: one[:2])[2]


def _values(f: Wave, cells: Cells) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Coefficients of real and imaginary part of f; at the ends of the axis of its leading part, as if it were real."""
    p, q, _, _ = plane(f)
    if cells.part is Part.MIDDLE:
        return p, cells.z.mean(axis=0) * q
    real, imaginary = orders(f, cells.part)
    return (p, 0 * p) if real <= imaginary else (q, 0 * q)


def _halved(cells: Cells, middles: list[Wave], inside: NDArray[np.bool_], drive: list[int]) -> Cells:
    """Where 0 is outside in the middle of the frequencies, these are halved; else the actuator's that moves f most."""
    by_drive = inside & (len(drive) > 0)
    if not by_drive.any():
        return cells.split_frequency()
    centres = np.stack([plane(f)[0][0] + 1j * cells.z.mean(axis=0) * plane(f)[1][0] for f in middles])
    centres = centres.reshape(*[2] * len(drive), -1)
    moved = np.stack([np.abs(np.diff(centres, axis=k)).max(axis=tuple(range(len(drive)))) for k in range(len(drive))])
    chosen = np.array(drive)[np.argmax(moved, axis=0)]
    parts = [cells[by_drive].split_parameter(chosen[by_drive])]
    parts += [cells[~by_drive].split_frequency()] if not by_drive.all() else []
    return Cells.joined(parts)


def entering(
    p: NDArray[np.float64], q: NDArray[np.float64], offset: NDArray[np.float64] | float = 0.0
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Least v with 0 in `f_n + v·(f_d + zonotope)`, (n,), and the t in [−1, 1] that gets there, (m, n).

    p, q: (2+m, n), of the whole box; offset: its centre from the nominal joint, in halves of its widths, (m,).
    Normal to edge j all other parameters are at ±1; the j-th then has to cancel what is left along the edge.
    """
    f = np.delete(p + 1j * q, 1, axis=0)  # without the frequency's own coefficient
    f_d = (f[1:] * np.reshape(offset, (-1, 1))).sum(axis=0)
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
