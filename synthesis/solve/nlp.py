"""The structured controller by nonlinear programming: maximise log ω_B over its coefficients (CasADi, IPOPT).

The band's grid is scaled by ω_B, so ω_B is a variable like the others. Nominal stability, free and locked, is part of
the program: the first columns of both Routh tables stay positive.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import casadi as ca
import numpy as np
from flint import fmpq_poly

from ...models.closed_loop import Pencil
from ...models.rational import RationalFunction, to_float
from ..problem.constraints import constraints
from ..problem.constraints.inequality import Constraint, Inequality, Role, Source, Variable
from ..problem.grid import Evaluator, grid
from ..problem.setting import Setting
from ..spec.model import Polynomials
from .split import Split
from .structure import Coefficients, Structure, convolve

if TYPE_CHECKING:
    from numpy.typing import NDArray

FIRST_BACK_OFF = 1e-5
BACK_OFF_GROWTH = 2.0
LEAST_ROUTH = 1e-6  # first-column entries of Routh's table, in normalised frequency
IPOPT: dict[str, Any] = {
    "ipopt.print_level": 0,
    "ipopt.sb": "yes",
    "print_time": 0,
    "ipopt.max_iter": 200,
    "ipopt.tol": 1e-6,
}
EXPLORING = {"ipopt.mu_strategy": "adaptive"}
INTERRUPTED = ("NonIpopt_Exception_Thrown", "User_Requested_Stop")  # what CasADi makes of Ctrl-C
REFINING = {"ipopt.mu_init": 1e-5, "ipopt.bound_push": 1e-8, "ipopt.bound_frac": 1e-8}  # stay near the start


@dataclass(frozen=True)
class Grids:
    """Where the program looks. omega: fixed grid [rad/s]; band: fractions of ω_B; back_off: relative slack required."""

    omega: NDArray[np.float64]
    band: NDArray[np.float64]
    back_off: float = FIRST_BACK_OFF

    @classmethod
    def of(cls, setting: Setting, omega_0: float, spread: int, dense: int, band: int) -> Grids:
        """`spread` points over everything, `dense` ones around omega_0 [rad/s], `band` ones on [0, ω_B]."""
        fractions = np.concatenate([[1e-4], np.linspace(0.03, 1, band)])
        return cls(grid(setting, around=omega_0, spread=spread, dense=dense), fractions)

    def refined(self, omega: Sequence[float], band: Sequence[float]) -> Grids:
        """With further points, each with two neighbours, and a larger slack."""
        return Grids(
            np.unique(np.concatenate([self.omega, *(near(w) for w in omega)])),
            np.unique(np.concatenate([self.band, *(np.minimum(near(u), 1.0) for u in band)])),
            self.back_off * BACK_OFF_GROWTH,
        )


def near(x: float) -> NDArray[np.float64]:
    """A point and its neighbours at 1 %."""
    return x * np.array([0.99, 1.0, 1.01])


@dataclass(frozen=True)
class Candidate:
    """A controller the search proposes; nothing is proven about it. omega_B [rad/s] is the program's own figure."""

    coefficients: Polynomials
    omega_B: float
    x: NDArray[np.float64]


class _Casadi:
    """Elementwise arithmetic on CasADi expressions; the modulus is smooth at 0."""

    def multiply(self, a: Any, b: Any) -> Any:
        return _column(a) * b

    def modulus(self, re: Any, im: Any) -> Any:
        return ca.sqrt(re * re + im * im + 1e-14)

    def exponential(self, re: Any, im: Any) -> tuple[Any, Any]:
        return ca.exp(re) * ca.cos(im), ca.exp(re) * ca.sin(im)


def _column(a: Any) -> Any:
    return ca.DM(a) if isinstance(a, np.ndarray) else a


class Program:
    """The NLP of one setting and structure on given grids. omega_0 [rad/s] normalises s."""

    def __init__(
        self, setting: Setting, structure: Structure, grids: Grids, omega_0: float, *, refining: bool = False
    ) -> None:
        self.setting, self.structure, self.omega_0 = setting, structure, omega_0
        self.evaluator = Evaluator(setting, grids.omega)
        low, high = structure.bounds
        x, log_band = ca.MX.sym("x", low.size), ca.MX.sym("log_band")
        parameters = [x[i] for i in range(low.size)]
        self.num, self.den = structure.polynomials(parameters, exp=ca.exp)
        rows, routh = [], []
        for vertex in setting.vertices():
            required = [c for c in constraints(vertex) if c.required]
            band, fixed = (
                [(c, q) for c in required if c.on_band == on for q in c.inequalities] for on in (True, False)
            )
            rows += [self._on_band(vertex, c, q, log_band, grids.band) for c, q in band]
            rows += [self._on_grid(vertex, c, q) for c, q in fixed]
            routh += [*self._routh(vertex.loop.locked()), *self._routh(vertex.loop.free(vertex.loop.nominal))]
        g = ca.vertcat(*rows, *routh)
        least = np.concatenate([np.full(g.shape[0] - len(routh), grids.back_off), np.full(len(routh), LEAST_ROUTH)])
        self.arguments = {
            "lbx": np.append(low, np.log(1e-3)),
            "ubx": np.append(high, np.log(1e3)),
            "lbg": least,
            "ubg": np.full(least.size, np.inf),
        }
        nlp = {"x": ca.vertcat(x, log_band), "f": -log_band, "g": g}
        self.solver = ca.nlpsol("synthesis", "ipopt", nlp, IPOPT | (REFINING if refining else EXPLORING))
        self.slack = ca.Function("slack", [nlp["x"]], [g - ca.DM(least)])

    def violation(self, x: NDArray[np.float64], omega_B: float) -> float:
        """Worst shortfall of any inequality at a start: how far the search begins from feasible."""
        slack = np.array(self.slack(np.append(x, np.log(omega_B / self.omega_0)))).ravel()
        return float(np.max(-slack)) if np.all(np.isfinite(slack)) else np.inf

    def solve(self, x: NDArray[np.float64], omega_B: float) -> Candidate | None:
        """Search from one start. Returns None when the solver does not end at a point it calls feasible."""
        result = self.solver(x0=np.append(x, np.log(omega_B / self.omega_0)), **self.arguments)
        solution, stats = np.array(result["x"]).ravel(), self.solver.stats()
        if stats["return_status"] in INTERRUPTED:
            raise KeyboardInterrupt
        if not stats["success"] or not np.all(np.isfinite(solution)):
            return None
        omega_B = float(np.exp(solution[-1]) * self.omega_0)
        return Candidate(self.structure.rounded(solution[:-1], self.omega_0), omega_B, solution[:-1])

    def _compensator(self) -> tuple[Coefficients, Coefficients]:
        """Numerator and denominator of C: Q/(1−Q) or C_imp."""
        if self.setting.spec.controller.type == "dob":
            return self.num, _add(self.den, [-c for c in self.num])
        return self.num, self.den

    def _variables(self, setting: Setting, s: Any, at: Any) -> dict[Variable, Split]:
        """Q, Q̃ and L at the frequencies s (Split, in rad/s)."""
        p = s * (1 / self.omega_0)
        num, den = (_horner(c, p) for c in self._compensator())
        loop = setting.loop
        CF = num / den * at(loop.filters.force)
        L = CF * at(loop.actuator.H)
        return {
            Variable.Q: CF / (1.0 + CF),
            Variable.Q_TILDE: L / (1.0 + L),
            Variable.L: L,
            Variable.COMMAND: CF / (1.0 + L),
        }

    def _on_grid(self, setting: Setting, constraint: Constraint, inequality: Inequality) -> Any:
        """Slack on the fixed grid, inside the constraint's own band, relative to the size of the right side."""
        omega = self.evaluator.omega
        low, high = constraint.band
        omega = omega[(omega >= float(low)) & (omega <= (np.inf if high is None else float(high)))]
        evaluator = Evaluator(setting, omega)

        def at(r: RationalFunction) -> Any:
            return r.at(omega)

        s = Split(np.zeros_like(omega), omega, _Casadi())
        X = self._variables(setting, Split(ca.DM(s.re), ca.DM(s.im), _Casadi()), at)[inequality.variable]
        left, right = inequality.sides(float(constraint.level or 0), evaluator.radius(inequality.source), X, at)
        size = np.abs(at(inequality.right.constant)) + np.abs(at(inequality.right.slope))
        size = np.full_like(size, size.min()) if inequality.role is Role.FLOOR else size
        return (_column(right) - _column(left)) / ca.DM(size)

    def _on_band(
        self, setting: Setting, constraint: Constraint, inequality: Inequality, log_band: Any, band: NDArray[np.float64]
    ) -> Any:
        """Slack on [0, ω_B], the grid scaled by the variable ω_B, relative to the right side."""
        omega = ca.DM(band) * ca.exp(log_band) * self.omega_0
        s = Split(ca.MX(ca.DM.zeros(band.size)), omega, _Casadi())

        def at(r: RationalFunction) -> Any:
            return r(s)

        W: Any = 0.0
        if inequality.source is Source.DISC:  # a table by its largest bound: it has no formula in ω
            weight, table = setting.uncertainty.weight, setting.uncertainty.table
            W = 0.0 if weight is None else abs(at(weight))
            W = W if table is None else W + (1 + W) * to_float(max(table.bound))
        X = self._variables(setting, s, at)[inequality.variable]
        left, right = inequality.sides(float(constraint.level or 0), W, X, at)
        return 1.0 - left / right

    def _routh(self, pencil: Pencil) -> list[Any]:
        """First column of Routh's table of a characteristic polynomial, normalised to leading coefficient 1."""
        num, den = self._compensator()
        on_den, on_num = self._scaled(pencil.on_den), self._scaled(pencil.on_num)
        p = _add(convolve(on_den, den), convolve(on_num, num))
        p = [c / p[0] for c in p]
        above, row = p[0::2], p[1::2]
        column = [row[0]] if row else []
        for _ in range(len(p) - 2):
            ratio = above[0] / row[0]
            padded = [*row[1:], *[0.0] * (len(above) - len(row))]
            above, row = row, [a - ratio * b for a, b in zip(above[1:], padded, strict=True)]
            column.append(row[0])
        return column

    def _scaled(self, poly: fmpq_poly) -> list[float]:
        """Descending coefficients in p = s/ω₀."""
        return [to_float(c) * self.omega_0**k for k, c in enumerate(poly.coeffs())][::-1]


def _horner(coefficients: Coefficients, p: Split) -> Split:
    value: Any = p * 0.0
    for c in coefficients:
        value = value * p + c
    return value  # type: ignore[no-any-return]


def _add(p: Coefficients, q: Coefficients) -> Coefficients:
    n = max(len(p), len(q))
    p, q = ([0.0] * (n - len(r)) + list(r) for r in (p, q))
    return [a + b for a, b in zip(p, q, strict=True)]
