"""The limit: the largest ω_B over all Q̃ in a large basis, convex and so globally solved (cvxpy, Clarabel).

`Q̃ = H·Σ x_k φ_k` with Laguerre functions φ_k of one pole, of relative degree 2 or more (so that the compensator is
realizable). Only constraints convex in Q̃ enter; the rest, if any, are dropped, which can only raise the figure. It is a
number from a solver on a grid: reported, used to start and to judge the search, never claimed as proven.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ...models.rational import ONE
from ..problem.constraints import constraints
from ..problem.constraints.inequality import Constraint, Inequality, Variable
from ..problem.grid import Evaluator, frequency_scale, grid
from ..problem.setting import Setting
from .split import Split

if TYPE_CHECKING:
    from numpy.typing import NDArray

SPACING = 0.005  # relative distance of grid points where the bound is decided


@dataclass(frozen=True)
class Bound:
    """ω_B that no controller with Q̃ in the basis exceeds on the grid, and what limits it there."""

    omega_B: float
    terms: int
    pole: float
    binding: tuple[tuple[str, float], ...]
    dropped: tuple[str, ...]


class _Cvx:
    """Elementwise arithmetic on cvxpy expressions."""

    def multiply(self, a: Any, b: Any) -> Any:
        import cvxpy as cp

        return cp.multiply(a, b)

    def modulus(self, re: Any, im: Any) -> Any:
        import cvxpy as cp

        return cp.norm(cp.vstack([re, im]), 2, axis=0)

    def exponential(self, re: Any, im: Any) -> tuple[Any, Any]:
        raise NotImplementedError("frequencies are numbers here")


def bound(setting: Setting, terms: int = 40) -> Bound | None:
    """The bound with `terms` Laguerre functions; None where even ω_B → 0 is infeasible on the grid."""
    around = _locate(setting)
    if around is None:
        return None
    fine = np.exp(np.arange(np.log(around / 1.2), np.log(around * 1.5), SPACING))
    omega = np.unique(np.concatenate([grid(setting, around=around, spread=80, dense=160), fine]))
    program = _Program(setting, omega, terms, pole=2 * around)
    k = program.largest_band(around)
    if k is None:
        return None
    limit = float(omega[min(k + 1, omega.size - 1)])
    return Bound(limit, terms, 2 * around, program.binding(), tuple(dict.fromkeys(c.id for c in program.dropped)))


def _locate(setting: Setting) -> float | None:
    """Rough ω_B, with few terms on a coarse grid: poles over the whole range first, then twice the best ω_B."""
    low, high = frequency_scale(setting)
    omega = np.geomspace(low / 3, high * 3, 160)
    best: float | None = None
    for poles in (np.geomspace(low, high, 4)[1:3], None):
        for pole in poles if poles is not None else [2 * (best or 1.0)]:
            k = _Program(setting, omega, 12, float(pole)).largest_band()
            if k is not None:
                best = max(best or 0.0, float(omega[k]))
    return best


def laguerre(s: NDArray[Any], pole: float, terms: int, relative_degree: int) -> NDArray[Any]:
    """`(p/(s+p))^r ((p−s)/(p+s))^k`, k = 0 … terms−1. s: (n,). Returns (n, terms)."""
    all_pass = (pole - s) / (pole + s)
    return np.asarray((pole / (s + pole))[:, None] ** relative_degree * all_pass[:, None] ** np.arange(terms))


@dataclass(frozen=True)
class _Row:
    """One inequality on its part of the grid: the cone, what it was multiplied by, and its frequencies, (n,)."""

    id: str
    cone: Any
    scale: NDArray[np.float64]
    omega: NDArray[np.float64]


class _Program:
    """One SOCP whose attenuation bound on the grid is a parameter, so that bisection re-uses its compiled form."""

    def __init__(self, setting: Setting, omega: NDArray[np.float64], terms: int, pole: float) -> None:
        import cvxpy as cp

        self.omega, self.evaluator = omega, Evaluator(setting, omega)
        everything = [c for v in setting.vertices(actuators=False) for c in constraints(v) if c.required]
        same = {Variable.Q_TILDE, Variable.Q} if setting.loop.actuator.H == ONE else {Variable.Q_TILDE}  # H = 1: Q = Q̃
        self.kept = [c for c in everything if all(q.convex and q.variable in same for q in c.inequalities)]
        self.dropped = [c for c in everything if c not in self.kept]

        degree = 2 if setting.spec.controller.type == "dob" else max(0, setting.loop.filters.force.relative_degree)
        basis = setting.loop.actuator.H.at(omega)[:, None] * laguerre(1j * omega, pole, terms, degree)
        stacked = np.vstack([basis.real, basis.imag])
        orthonormal, _ = np.linalg.qr(stacked)
        orthonormal *= np.sqrt(omega.size)
        x = cp.Variable(terms)
        self.X = Split(orthonormal[: omega.size] @ x, orthonormal[omega.size :] @ x, _Cvx())
        self.beyond_band = cp.Parameter(omega.size, nonneg=True)  # 0 on the band, large outside it
        self.rows: list[_Row] = []
        for c in self.kept:
            for inequality in c.inequalities:
                self.rows.append(self._row(c, inequality))
        self.problem = cp.Problem(cp.Minimize(0), [row.cone for row in self.rows])

    def _row(self, c: Constraint, inequality: Inequality) -> _Row:
        import cvxpy as cp

        inside = np.flatnonzero(self.evaluator.inside(c))
        omega = self.omega[inside]
        X = Split(self.X.re[inside], self.X.im[inside], self.X.arithmetic)
        W = self.evaluator.radius(inequality.source)[inside]
        left, right = inequality.sides(float(c.level or 0), W, X, lambda r: r.at(omega))
        scale = 1 / np.maximum(np.abs(inequality.right.constant.at(omega)), 1e-300)
        excess = cp.multiply(scale, left) - cp.multiply(scale, right)
        return _Row(c.id, excess <= (self.beyond_band[inside] if c.on_band else 0.0), scale, omega)

    def feasible(self, k: int) -> bool:
        """Whether attenuation up to the k-th grid point is feasible, by the solver's word."""
        import cvxpy as cp

        self.beyond_band.value = np.where(np.arange(self.omega.size) <= k, 0.0, 1e3)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # an inaccurate optimum is judged by its status, below
                self.problem.solve(solver=cp.CLARABEL)
        except (cp.SolverError, ValueError):  # ValueError: data that are not finite
            return False
        return self.problem.status in (cp.OPTIMAL, cp.OPTIMAL_INACCURATE)

    def largest_band(self, around: float | None = None) -> int | None:
        """Index of the last grid point up to which attenuation is feasible; None if not even the first is."""
        low, high = 0, self.omega.size
        if around is not None and self.feasible(k := int(np.searchsorted(self.omega, 0.95 * around))):
            low = k
            while low + 1 < high and self.feasible(k := min(low + 32, high - 1)):
                low = k
            high = min(low + 32, high)
        elif not self.feasible(0):
            return None
        while high - low > 1:
            middle = (low + high) // 2
            low, high = (middle, high) if self.feasible(middle) else (low, middle)
        self.feasible(low)
        return low

    def binding(self) -> tuple[tuple[str, float], ...]:
        """Constraints with a multiplier at the optimum, each with the frequency where it is largest."""
        found: dict[str, tuple[float, float]] = {}
        for row in self.rows:
            dual = row.cone.dual_value
            effect = np.abs(np.atleast_1d(dual)) * row.scale if dual is not None else np.zeros(1)  # per unit, unscaled
            k = int(np.argmax(effect))
            if effect[k] > found.get(row.id, (0.0, 0.0))[0]:
                found[row.id] = (float(effect[k]), float(row.omega[k]))
        return tuple((name, omega) for name, (_, omega) in sorted(found.items(), key=lambda item: -item[1][0]))
