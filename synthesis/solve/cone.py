"""Second-order cone programs as they arise here, handed to Clarabel directly: nothing is compiled or canonicalised.

minimise c·y   subject to   Σ_i |A_i y + a_i| ≤ B y + b   in every row of every block, A_i and a_i complex.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

ACCURACY = 1e-6  # asked of the solver; with less it stops early, with more it stops at rounding, "almost" done
REGULARIZED = 1e-7  # on the diagonal of its linear systems: with the 1e-8 it has by itself it breaks off on some bases
SOLVED, EMPTY = ("Solved", "AlmostSolved"), ("PrimalInfeasible", "AlmostPrimalInfeasible")


class Failure(Enum):
    """Why there is no solution, by the solver's word."""

    INFEASIBLE = "nothing satisfies the constraints"
    UNSOLVED = "the solver did not find a point it vouches for"


@dataclass(frozen=True, eq=False)
class Block:
    """Rows of one kind. moduli: pairs (A: (m, n), a: (m,)) complex; B: (m, n), b: (m,) real."""

    moduli: Sequence[tuple[NDArray[np.complex128], NDArray[np.complex128]]]
    B: NDArray[np.float64]
    b: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Solution:
    """What the solver says. y: (n,); weights: of each block, the multipliers of its rows, (m,)."""

    y: NDArray[np.float64]
    value: float
    weights: tuple[NDArray[np.float64], ...]


def minimise(c: NDArray[np.float64], blocks: Sequence[Block]) -> Solution | Failure:
    """Solve. c: (n,). How well the solution holds is for the caller to see: an inaccurate one is returned, too."""
    import clarabel
    from scipy import sparse

    n, cones, rows, constants, places = c.size, [], [], [], []
    extra = sum(len(block.moduli) * block.b.size for block in blocks if len(block.moduli) > 1)
    column = n
    at = 0
    for block in blocks:
        m = block.b.size
        if len(block.moduli) <= 1:
            stacked = _interleaved(block.B, [A for A, _ in block.moduli])
            rows.append(_placed(stacked, extra))
            constants.append(_interleaved(block.b, [a for _, a in block.moduli]))
            size = 1 + 2 * len(block.moduli)
            cones += [clarabel.NonnegativeConeT(m)] if size == 1 else [clarabel.SecondOrderConeT(3)] * m
            places.append(at + size * np.arange(m))
            at += size * m
            continue
        total = sparse.lil_matrix((m, extra))
        for A, a in block.moduli:  # a bound t on each modulus, the bounds add up
            bound = sparse.lil_matrix((3 * m, extra))
            for k in range(m):
                bound[3 * k, column - n + k] = 1.0
                total[k, column - n + k] = -1.0
            rows.append(sparse.hstack([_interleaved(np.zeros((m, n)), [A]), bound]))
            constants.append(_interleaved(np.zeros(m), [a]))
            cones += [clarabel.SecondOrderConeT(3)] * m
            at += 3 * m
            column += m
        rows.append(sparse.hstack([block.B, total]))
        constants.append(block.b)
        cones.append(clarabel.NonnegativeConeT(m))
        places.append(at + np.arange(m))
        at += m
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.tol_feas = settings.tol_gap_abs = settings.tol_gap_rel = ACCURACY
    settings.static_regularization_constant = REGULARIZED
    matrix = sparse.csc_matrix(sparse.vstack(rows)) if extra else sparse.csc_matrix(np.vstack(rows))
    right = np.concatenate(constants)
    if not (np.all(np.isfinite(matrix.data)) and np.all(np.isfinite(right))):
        return Failure.UNSOLVED
    objective = np.concatenate([c, np.zeros(extra)])
    empty = sparse.csc_matrix((n + extra, n + extra))
    found = clarabel.DefaultSolver(empty, objective, -matrix, right, cones, settings).solve()
    y, status = np.array(found.x)[:n], str(found.status)
    if status not in SOLVED or not np.all(np.isfinite(y)):
        return Failure.INFEASIBLE if status in EMPTY else Failure.UNSOLVED
    z = np.array(found.z)
    return Solution(y, float(c @ y), tuple(z[place] for place in places))


def _interleaved(real: NDArray[np.float64], parts: list[NDArray[np.complex128]]) -> Any:
    """Row by row: the bound, then real and imaginary part of what it bounds."""
    stacked = [real, *(part for z in parts for part in (z.real, z.imag))]
    return np.stack(stacked, axis=1).reshape(-1, *real.shape[1:])


def _placed(rows: NDArray[np.float64], extra: int) -> Any:
    from scipy import sparse

    return sparse.hstack([rows, sparse.csc_matrix((rows.shape[0], extra))]) if extra else rows
