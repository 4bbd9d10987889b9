"""The frequency grid and the values of constraints on it (the grid finds; the proof decides)."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import fmpq_poly

from ...models.rational import RationalFunction, to_float
from .constraints.inequality import Constraint, Inequality, Role, Source, Variable
from .setting import Setting

if TYPE_CHECKING:
    from numpy.typing import NDArray

ROUNDS, PARTS = 10, 64  # an interval of the grid is divided to the last digit of a double


def frequency_scale(setting: Setting) -> tuple[float, float]:
    """Lowest and highest frequency at which anything in the joint happens [rad/s]."""
    loop, uncertainty = setting.loop, setting.uncertainty
    polynomials = [loop.actuator.d, loop.desired.polynomial, loop.nominal.polynomial, loop.free(loop.nominal).on_den]
    polynomials += [load.polynomial for load in uncertainty.corners()]
    for vertex in setting.vertices():
        polynomials += [vertex.loop.actuator.d, vertex.loop.desired.polynomial]
    if uncertainty.weight is not None:
        polynomials += [uncertainty.weight.num, uncertainty.weight.den]
    relevant = [abs(root) for p in polynomials for root in float_roots(p) if root != 0]
    return (min(relevant), max(relevant)) if relevant else (1.0, 1.0)


def float_roots(p: fmpq_poly) -> list[complex]:
    """Roots in floats, to look near; none for coefficients too far apart for floats."""
    if p.degree() <= 0:
        return []
    lead = p.leading_coefficient()
    coefficients = np.array([to_float(c / lead) for c in p.coeffs()[::-1]])
    if not np.all(np.isfinite(coefficients)):
        return []
    with np.errstate(all="ignore"):
        return [complex(root) for root in np.roots(coefficients) if np.isfinite(root)]


def grid(setting: Setting, *, around: float | None = None, spread: int = 100, dense: int = 0) -> NDArray[np.float64]:
    """Logarithmic grid over everything the joint does, with `dense` extra points within a factor 5 of `around`.

    Returns (n,) [rad/s], increasing, > 0.
    """
    low, high = frequency_scale(setting)
    low, high = (min(low, around), max(high, around)) if around else (low, high)
    omega = np.geomspace(low / 30, high * 30, spread)
    if around and dense:
        omega = np.concatenate([omega, np.geomspace(around / 5, around * 5, dense)])
    return np.unique(omega)


@dataclass(frozen=True)
class Evaluator:
    """Values of one inequality's sides on a grid. omega: (n,) [rad/s]."""

    setting: Setting
    omega: NDArray[np.float64]
    _values: dict[Any, Any] = field(default_factory=dict, init=False, repr=False, compare=False)

    def at(self, r: Any) -> Any:
        """A rational function on the grid, evaluated once."""
        if id(r) not in self._values:
            self._values[id(r)] = (r, r.at(self.omega))  # held, so that its id stays its own
        return self._values[id(r)][1]

    def with_ends(self, constraint: Constraint) -> Evaluator:
        """The grid with the ends of a constraint's interval on it."""
        ends = [float(end) for end in constraint.band if end]
        return Evaluator(self.setting, np.unique(np.concatenate([self.omega, ends])))

    def radius(self, source: Source) -> NDArray[np.float64]:
        """W(ω) of the Δ an inequality speaks of."""
        if source not in self._values:
            uncertainty = self.setting.uncertainty
            of = uncertainty.radius if source is Source.LUMPED else uncertainty.disc_radius
            self._values[source] = of(self.omega)
        return self._values[source]  # type: ignore[no-any-return]

    def slack(self, inequality: Inequality, v: float, X: dict[Variable, RationalFunction]) -> NDArray[np.float64]:
        """Right minus left side, relative to the scale of both at each ω; positive where it holds. Returns (n,)."""
        with np.errstate(all="ignore"):
            W, variable = self.radius(inequality.source), self.at(X[inequality.variable])
            left, right = inequality.sides(v, W, variable, self.at)
            left = left + 0 * self.omega
            scale = 1.0 if inequality.role is Role.FLOOR else np.abs(right) + np.abs(left)
            return np.asarray((right - left) / scale)

    def levels(self, inequality: Inequality, X: dict[Variable, RationalFunction]) -> NDArray[np.float64]:
        """The hardest level v that holds at each ω, negative where none does. Returns (n,)."""
        with np.errstate(all="ignore"):
            W, variable = self.radius(inequality.source), self.at(X[inequality.variable])
            numerator, denominator = inequality.level(W, variable, self.at)
            return np.asarray(numerator / denominator)

    def first_failure(self, inequality: Inequality, v: float, X: dict[Variable, RationalFunction]) -> float | None:
        """The lowest frequency [rad/s] from which an inequality fails; None where it holds on the whole grid."""
        failing = np.flatnonzero(self.slack(inequality, v, X) < 0)
        if not failing.size:
            return None
        k = int(failing[0])
        return self.edge(0.0 if k == 0 else float(self.omega[k - 1]), float(self.omega[k]), (inequality,), v, X)

    def edge(
        self,
        holds: float,
        fails: float,
        inequalities: tuple[Inequality, ...],
        v: float,
        X: dict[Variable, RationalFunction],
    ) -> float:
        """The last frequency [rad/s], from one where all inequalities hold towards one where one fails."""
        for _ in range(ROUNDS):
            omega = np.linspace(holds, fails, PARTS + 1)
            at = Evaluator(self.setting, omega[1:-1])
            bad = ~np.all([at.slack(inequality, v, X) >= 0 for inequality in inequalities], axis=0)
            k = int(np.argmax(bad)) if bad.any() else PARTS - 1
            holds, fails = float(omega[k]), float(omega[k + 1])
        return holds

    def inside(self, constraint: Constraint) -> NDArray[np.bool_]:
        """Which grid points lie in a constraint's interval. Returns (n,)."""
        low, high = constraint.band
        return (self.omega >= float(low)) & (self.omega <= (np.inf if high is None else float(high)))

    def worst(self, constraint: Constraint, v: float, X: dict[Variable, RationalFunction]) -> tuple[float, float, int]:
        """Smallest slack of a constraint: (slack, ω, index of the inequality)."""
        inside = self.inside(constraint)
        best = (np.inf, float(self.omega[inside][0]) if inside.any() else float(constraint.band[0]), 0)
        for index, inequality in enumerate(constraint.inequalities):
            slack = np.where(inside, self.slack(inequality, v, X), np.inf)
            slack = np.where(np.isnan(slack), -np.inf, slack)
            k = int(np.argmin(slack))
            if slack[k] < best[0]:
                best = (float(slack[k]), float(self.omega[k]), index)
        return best
