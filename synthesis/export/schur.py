"""Whether every root of a polynomial lies inside the unit circle, decided in rationals or in balls."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any


def is_schur(ascending: Sequence[Any]) -> bool | None:
    """Schur and Cohn's recursion `p ← (p − (a₀/aₙ) p*)/z`, p* with reversed coefficients: |a₀| < |aₙ| at every step.

    ascending: coefficients, exact rationals or balls. None where balls are too wide to decide.
    """
    p = list(ascending)
    while len(p) > 1:
        first, last = p[0], p[-1]
        if abs(first) >= abs(last):
            return False
        if not abs(first) < abs(last):
            return None
        k, n = first / last, len(p) - 1
        p = [p[i + 1] - k * p[n - 1 - i] for i in range(n)]
    return True
