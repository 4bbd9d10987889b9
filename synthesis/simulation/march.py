"""Linear systems from sample to sample: exact transitions, trajectories, and integrals of quadratic forms."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, log2

import numpy as np
from scipy.linalg import expm

from .block import Matrix

Samples = Matrix


@dataclass(frozen=True, eq=False)
class March:
    """`z⁺ = Φ z` every `dt` [s] from `start`; `zᵀ W z` is the energy of the step; `rows` read signals from z."""

    dt: float
    transition: Matrix
    work: Matrix
    start: Samples
    rows: dict[str, Samples]


def propagator(A: Matrix, M: Matrix, dt: float) -> tuple[Matrix, Matrix]:
    """`Φ = e^{A dt}` and `W = ∫₀^dt e^{Aᵀt} M e^{At} dt`.

    Van Loan's block exponential on a step short enough that e^{−Aᵀt} stays moderate, then doubled up to dt.
    """
    n = len(A)
    doublings = ceil(log2(max(float(np.linalg.norm(A, 1)) * dt, 1.0)))
    exponential = expm(np.block([[-A.T, M], [np.zeros((n, n)), A]]) * (dt / 2**doublings))
    transition = exponential[n:, n:]
    work = transition.T @ exponential[:n, n:]
    for _ in range(doublings):
        work = work + transition.T @ work @ transition
        transition = transition @ transition
    return transition, work


def repeated(transition: Matrix, work: Matrix, count: int) -> tuple[Matrix, Matrix]:
    """`Φ^count` and `Σ (Φ^k)ᵀ W Φ^k`, k = 0 … count − 1, by doubling."""
    whole, total = np.eye(len(transition)), np.zeros_like(work)
    while count:
        if count & 1:
            total = total + whole.T @ work @ whole
            whole = transition @ whole
        work = work + transition.T @ work @ transition
        transition = transition @ transition
        count >>= 1
    return whole, total


def trajectory(transition: Matrix, start: Samples, count: int) -> Matrix:
    """States `Φ^k z₀`, k = 0 … count − 1, (count, n); each pass doubles the part already known."""
    states = start[None, :]
    while len(states) < count:
        states = np.vstack([states, states @ transition.T])
        transition = transition @ transition
    return states[:count]


def power_form(tau_int: Samples, velocity: Samples) -> Matrix:
    """The quadratic form `zᵀ M z = τ_int θ'`."""
    return np.asarray((np.outer(tau_int, velocity) + np.outer(velocity, tau_int)) / 2)
