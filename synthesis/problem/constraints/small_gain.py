"""Shared by (9) and (18): the loop seen by a multiplicative Δ. `1 − Q + (1+Δ)T = 0` are the poles in free motion."""

from __future__ import annotations

from ....models.closed_loop import ImpedanceLoop
from .inequality import ONE_MINUS_X, Affine, X


def compensated_error(loop: ImpedanceLoop) -> Affine:
    """`(Ω+Q)·Ĝ⁻¹ = Q·G_imp − (1−Q)·F_d(Ĝ⁻¹ − G_imp)`; multiplied by Ĝ⁻¹ so that K̂ = 0 is no pole at 0."""
    error: Affine = X * loop.G_imp + ONE_MINUS_X * (-loop.compensation)
    return error
