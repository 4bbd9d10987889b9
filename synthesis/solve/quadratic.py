"""The quadratic program of one step, handed to Clarabel directly."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

PENALTY = 10.0  # of the worst shortfall, relative, against log ω_B; the sum of the multipliers stays near 2


def quadratic(
    curvature: NDArray[np.float64],
    slopes: NDArray[np.float64],
    slack: NDArray[np.float64],
    low: NDArray[np.float64],
    high: NDArray[np.float64],
) -> tuple[NDArray[np.float64], float, NDArray[np.float64]] | None:
    """The d that minimises `½dᵀBd − d_n + PENALTY·v` with `slack + slopes·d + v ≥ 0`, `v ≥ 0` and `low ≤ d ≤ high`.

    curvature B: (n, n), positive semidefinite; slopes: (m, n); slack: (m,). Returns d (n,), v and the multipliers of
    the rows, or None where Clarabel does not vouch for a solution.
    """
    import clarabel
    from scipy import sparse

    m, n = slopes.shape
    scale = 1 / np.maximum(1.0, np.abs(slopes).max(axis=1, initial=0.0))  # rows at high frequencies are steep
    unit = np.eye(n)
    rows = np.zeros((m + 2 * n + 1, n + 1))
    rows[:m, :n], rows[:m, n] = -slopes * scale[:, None], -scale
    rows[m : m + n, :n], rows[m + n : -1, :n], rows[-1, n] = unit, -unit, -1.0
    right = np.concatenate([slack * scale, high, -low, [0.0]])
    cost = np.zeros((n + 1, n + 1))
    cost[:n, :n] = np.triu(curvature)
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    linear = np.append(-unit[-1], PENALTY)
    cones = [clarabel.NonnegativeConeT(right.size)]
    solution = clarabel.DefaultSolver(
        sparse.csc_matrix(cost), linear, sparse.csc_matrix(rows), right, cones, settings
    ).solve()
    if str(solution.status) not in ("Solved", "AlmostSolved"):
        return None
    d = np.array(solution.x)
    return d[:n], max(0.0, float(d[n])), np.array(solution.z)[:m] * scale
