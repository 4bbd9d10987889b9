"""The specification's inequalities on a frequency grid in NumPy, as somebody without a prover would use them.

Q is a pair of polynomials in p = s/ω₀, descending powers.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from task import Candidate, Task, exact_q

from robimp.models.closed_loop import Pencil
from robimp.models.rational import ZERO, descending
from robimp.synthesis.problem.constraints import constraints
from robimp.synthesis.problem.constraints.inequality import Affine, Inequality, Role, Term, Variable
from robimp.synthesis.problem.grid import Evaluator, grid
from robimp.synthesis.solve.structure import QFilter

Array = NDArray[Any]
Pair = tuple[Array, Array]
SPREAD, DENSE, BAND = 80, 160, 40  # more than twice the frequencies of robimp's own search
BACK_OFF = 1e-3  # relative slack asked for on the grid, so that what lies between its points has some room
LARGEST_RATIO = 2.0  # of coefficients of numerator and denominator


class _Values:
    """Values of a rational function on the grid in its place: never the zero function, which stays what it is."""

    def __init__(self, values: Array) -> None:
        self.values = values


@dataclass(frozen=True)
class _Row:
    inequality: Inequality
    level: float
    W: Array
    scale: Array

    def slack(self, X: dict[Variable, Array]) -> Array:
        left, right = self.inequality.sides(self.level, self.W, X[self.inequality.variable], _on_grid)
        return np.asarray((right - left) / self.scale)


def _on_grid(r: Any) -> Any:
    return r.values if isinstance(r, _Values) else 0.0


class Gridded:
    """Every required inequality of a task at fixed frequencies."""

    def __init__(self, task: Task) -> None:
        self.task = task
        self.omega = grid(task.setting, around=task.omega_0, spread=SPREAD, dense=DENSE)
        self.band = np.concatenate([[1e-4], np.linspace(0.03, 1, BAND)])
        self.fine = np.geomspace(task.omega_0 / 300, task.omega_0 * 300, 600)
        port = task.setting.loop.actuator
        self.h, self.d = (np.array([float(c) for c in descending(p)]) for p in (port.h, port.d))
        vertices = list(task.setting.vertices())
        required = [
            (c, q) for v in vertices for c in constraints(v) if c.required and not c.on_band for q in c.inequalities
        ]
        self.rows = [self._row(c.level, q) for c, q in required]
        self.pencils = [_floats(p) for v in vertices for p in (v.loop.locked(), v.loop.free(v.loop.nominal))]

    @property
    def bounds(self) -> list[tuple[float, float]]:
        """Of x: log of each section's ω/ω₀, its ζ, and ratios of numerator to denominator coefficients."""
        n, ratios = self.task.order // 2, self.task.order - 1
        return [(-3.5, 5.0)] * n + [(0.05, 5.0)] * n + [(-LARGEST_RATIO, LARGEST_RATIO)] * ratios

    def q(self, x: Array) -> Pair:
        """Q of the parameters x: second-order sections, so always stable itself."""
        n = 2 * (self.task.order // 2)
        _, den = QFilter(self.task.order).polynomials(np.concatenate([x[:n], np.zeros(self.task.order - 1)]))
        return np.array(den[2:]) * x[n:], np.array(den)

    def slack(self, Q: Pair) -> Array:
        """Right minus left side of every inequality at every frequency, relative to the right; ≥ 0 where it holds."""
        X = self._variables(Q, self.omega)
        slack = np.concatenate([row.slack(X) for row in self.rows])
        return np.asarray(np.nan_to_num(slack, nan=-1e3, posinf=1e3, neginf=-1e3))

    def sensitivity(self, Q: Pair, omega: Array) -> Array:
        """`|1−Q̃|`. omega: (n,) [rad/s]."""
        return np.asarray(np.abs(1 - self._variables(Q, omega)[Variable.Q_TILDE]))

    def omega_B(self, Q: Pair) -> float:
        """Largest frequency of a fine grid up to which disturbances are attenuated [rad/s]."""
        beyond = np.flatnonzero(~(self.sensitivity(Q, self.fine) <= self.task.attenuation))
        return float(self.fine[max(0, (beyond[0] if beyond.size else self.fine.size) - 1)])

    def growth(self, Q: Pair) -> float:
        """Largest real part of any closed-loop pole, free or against a wall, over ω₀; what NumPy's roots say."""
        num, den = self._in_s(Q)
        open_loop: Array = np.polysub(den, num)
        polynomials = (np.polyadd(np.polymul(a, open_loop), np.polymul(b, num)) for a, b in self.pencils)
        return max(float(np.roots(p).real.max()) for p in polynomials) / self.task.omega_0

    def candidate(self, Q: Pair) -> Candidate:
        """With the bandwidth of the fine grid as the claim."""
        return Candidate(exact_q(*self._in_s(Q)), self.omega_B(Q))

    def _in_s(self, Q: Pair) -> Pair:
        num, den = Q
        powers = self.task.omega_0 ** np.arange(den.size)
        return num * powers[den.size - num.size :], den * powers

    def _row(self, level: Any, inequality: Inequality) -> _Row:
        def at(affine: Affine) -> Affine:
            values = (r if r == ZERO else _Values(r.at(self.omega)) for r in (affine.constant, affine.slope))
            return Affine(*values)

        def terms(given: tuple[Term, ...]) -> tuple[Term, ...]:
            return tuple(replace(t, affine=at(t.affine), shift=t.shift and at(t.shift)) for t in given)

        right = at(inequality.right)
        size = np.abs(_on_grid(right.constant)) + np.abs(_on_grid(right.slope))
        on_grid = replace(inequality, moduli=terms(inequality.moduli), reals=terms(inequality.reals), right=right)
        W = Evaluator(self.task.setting, self.omega).radius(inequality.source)
        scale = np.full_like(size, size.min()) if inequality.role is Role.FLOOR else size
        return _Row(on_grid, float(level), W, scale)

    def _variables(self, Q: Pair, omega: Array) -> dict[Variable, Array]:
        s, p = 1j * omega, 1j * omega / self.task.omega_0
        of_p, H = np.polyval(Q[0], p) / np.polyval(Q[1], p), np.polyval(self.h, s) / np.polyval(self.d, s)
        return {Variable.Q: of_p, Variable.Q_TILDE: H * of_p / (1 - of_p + H * of_p)}


def _floats(pencil: Pencil) -> Pair:
    on_den, on_num = (np.array([float(c) for c in descending(p)]) for p in (pencil.on_den, pencil.on_num))
    return on_den, on_num
