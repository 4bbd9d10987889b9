"""Exact steps of a linear system, and of every half, quarter, … of them, from one exponential.

`D_ℓ = e^{F h/2^ℓ} − 1` of the flow F = [A B; 0 0]. The finest is a short Taylor series; each coarser one is
`D_{ℓ−1} = 2 D_ℓ + D_ℓ²`. Without the 1 nothing cancels: the motion of one step keeps sixteen digits however short it
is, and a conservative system its energy over millions of steps.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .compiled import compiled

Array = NDArray[np.float64]

SMALL = 0.5  # norm of a flow over a step whose series is short


@compiled
def ladder(flow: Array, h: float, steps: Array) -> None:
    """Fill `steps` (levels, n, n + m) with D_ℓ of `flow` (n, n + m), ℓ = 0 the whole step h [s]."""
    levels, n, width = steps.shape
    finest = h / 2 ** (levels - 1)
    size, beyond = np.abs(flow).max() * n * finest, 0
    while size > SMALL:
        size, beyond = size / 2, beyond + 1
    D = _series(flow, finest / 2**beyond)
    for _ in range(beyond):
        D = 2 * D + _times(D, D)
    for level in range(levels - 1, -1, -1):
        for i in range(n):
            for j in range(width):
                steps[level, i, j] = D[i, j]
        D = 2 * D + _times(D, D)


@compiled
def _series(flow: Array, h: float) -> Array:
    """`e^{F h} − 1` by its series; h short enough that few terms count."""
    term = flow * h
    total = term.copy()
    for k in range(2, 60):
        term = _times(flow * (h / k), term)
        total += term
        if np.abs(term).max() <= 1e-18 * np.abs(total).max():
            break
    return total


@compiled
def _times(left: Array, right: Array) -> Array:
    """Product of flows: what is below their n rows is zero."""
    n, width = left.shape
    product = np.zeros((n, width))
    for i in range(n):
        for k in range(n):
            factor = left[i, k]
            if factor != 0.0:
                for j in range(width):
                    product[i, j] += factor * right[k, j]
    return product
