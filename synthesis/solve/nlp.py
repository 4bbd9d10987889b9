"""The structured controller by nonlinear programming: maximise log ω_B over its coefficients (CasADi, IPOPT).

The band's grid is scaled by ω_B, so ω_B is a variable like the others. The grid itself is a parameter: one compiled
program serves every grid, and its few points move to where the constraints are tight. Nominal stability, free and
locked, is part of the program: the first columns of both Routh tables stay positive.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import casadi as ca
import numpy as np
from flint import fmpq_poly

from ...models.closed_loop import Pencil
from ...models.rational import RationalFunction, to_float
from ..problem.constraints import constraints
from ..problem.constraints.inequality import Constraint, Inequality, Role, Source, Variable
from ..problem.grid import Evaluator
from ..problem.setting import Setting
from ..spec.model import Polynomials
from .basis import RESOLVED
from .corner import Corner
from .places import ADDED, ADDED_BAND, Casadi, Grids, Places, filled, numbered
from .split import Split
from .structure import Coefficients, Filter, Structure, add, convolve

if TYPE_CHECKING:
    from numpy.typing import NDArray

LEAST_ROUTH = 1e-6  # first-column entries of Routh's table, in normalised frequency
LIGHT = 0.3  # damping below which a pole is a resonance
IPOPT: dict[str, Any] = {
    "ipopt.print_level": 0,
    "ipopt.sb": "yes",
    "print_time": 0,
    "ipopt.max_iter": 120,
    "ipopt.tol": 1e-6,
    "ipopt.mumps_pivot_order": 0,  # minimum degree, found sooner than the default's: hundreds of rows, few unknowns
    "ipopt.min_refinement_steps": 0,  # of the linear solution; more only where its residual asks for them
}
EXPLORING = {"ipopt.mu_strategy": "adaptive"}
INTERRUPTED = ("NonIpopt_Exception_Thrown", "User_Requested_Stop")  # what CasADi makes of Ctrl-C
REFINING = {"ipopt.mu_init": 1e-5, "ipopt.bound_push": 1e-8, "ipopt.bound_frac": 1e-8}  # stay near the start


@dataclass(frozen=True)
class Candidate:
    """A controller the search proposes; nothing is proven about it. omega_B [rad/s] is the program's own figure."""

    coefficients: Polynomials
    omega_B: float
    x: NDArray[np.float64]
    corner: Corner | None = None  # of the sensor filter, where it was free


@dataclass(frozen=True)
class Rows:
    """The rows of one inequality in the program: from `start`, one for each place of the grid or of the band."""

    constraint: Constraint
    start: int
    count: int

    def inside(self, omega: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Which frequencies lie in the constraint's own interval."""
        low, high = self.constraint.band
        everywhere = self.constraint.on_band
        return np.full(omega.size, True) if everywhere else (omega >= float(low)) & (omega <= float(high or np.inf))


class Program:
    """The NLP of one setting and structure. first: the grid it begins with; omega_0 [rad/s] normalises s."""

    def __init__(self, setting: Setting, structure: Structure, first: Grids, omega_0: float) -> None:
        self.setting, self.structure, self.omega_0 = setting, structure, omega_0
        self.places = Places(first.omega.size + ADDED)
        low, high = structure.bounds
        x, log_band = ca.MX.sym("x", low.size), ca.MX.sym("log_band")
        band = ca.MX.sym("band", first.band.size + ADDED_BAND)
        self.x = ca.SX.sym("x", low.size)
        self.num, self.den = structure.polynomials(ca.vertsplit(self.x), exp=ca.exp)
        self.F = structure.sensor_filter(ca.vertsplit(self.x), exp=ca.exp)
        *C, routh = self._scalars()(x)
        self.rows: list[Rows] = []
        expressions, start = [], 0
        at_grid = Split(ca.MX(ca.DM.zeros(self.places.count)), self.places.omega, Casadi())
        at_band = Split(ca.MX(ca.DM.zeros(band.shape[0])), band * ca.exp(log_band) * omega_0, Casadi())
        for vertex in setting.vertices():
            X_grid = self._variables(vertex, C, at_grid, self.places.at)  # once: CasADi does not find what is common
            X_band = self._variables(vertex, C, at_band, numbered(lambda r: r(at_band)))
            for c in (c for c in constraints(vertex) if c.required):
                for inequality in c.inequalities:
                    if c.on_band:
                        expressions.append(self._on_band(vertex, c, inequality, X_band, at_band))
                    else:
                        expressions.append(self._on_grid(vertex, c, inequality, X_grid))
                    self.rows.append(Rows(c, start, expressions[-1].shape[0]))
                    start += self.rows[-1].count
        self.bounds = {"lbx": np.append(low, np.log(1e-3)), "ubx": np.append(high, np.log(1e3))}
        self.nlp = {
            "x": ca.vertcat(x, log_band),
            "p": ca.vertcat(*self.places.columns, band),
            "f": -log_band,
            "g": ca.vertcat(*expressions, routh),
        }
        self.slack = ca.Function("slack", [self.nlp["x"], self.nlp["p"]], [self.nlp["g"]])
        self.solvers: dict[bool, Any] = {}

    def solver(self, refining: bool) -> Any:
        """IPOPT, prepared to explore from afar or to stay near its start."""
        if refining not in self.solvers:
            options = IPOPT | (REFINING if refining else EXPLORING) | self.derivatives
            self.solvers[refining] = ca.nlpsol("synthesis", "ipopt", self.nlp, options)
        return self.solvers[refining]

    @cached_property
    def derivatives(self) -> dict[str, Any]:
        """Exact, for both solvers: the functions IPOPT asks CasADi for, by CasADi's names."""
        nlp = ca.Function("nlp", self.nlp, ["x", "p"], ["f", "g"])
        return {
            "grad_f": nlp.factory("nlp_grad_f", ["x", "p"], ["f", "grad:f:x"]),
            "jac_g": nlp.factory("nlp_jac_g", ["x", "p"], ["g", "jac:g:x"]),
            "hess_lag": nlp.factory(
                "nlp_hess_l", ["x", "p", "lam:f", "lam:g"], ["triu:hess:gamma:x:x"], {"gamma": ["f", "g"]}
            ),
        }

    def placed(self, grids: Grids) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """The program's parameters for a grid, and the least slack of each row: −∞ at places that are not used."""
        omega, used = filled(grids.omega, grids.added, self.places.count)
        band, used_band = filled(grids.band, grids.added_band, self.nlp["p"].shape[0] - self._columns)
        least = np.full(self.nlp["g"].shape[0], LEAST_ROUTH)
        for rows in self.rows:
            active = used_band if rows.constraint.on_band else used & rows.inside(omega)
            least[rows.start : rows.start + rows.count] = np.where(active, grids.back_off, -np.inf)
        return np.concatenate([self.places.values(omega), band]), least

    @property
    def _columns(self) -> int:
        return self.places.count * len(self.places.columns)

    def violation(self, x: NDArray[np.float64], omega_B: float, grids: Grids) -> float:
        """Worst shortfall of any inequality at a start: how far the search begins from feasible."""
        p, least = self.placed(grids)
        return self._shortfall(x, omega_B, p, least)

    def nearest(self, starts: Sequence[NDArray[np.float64]], omega_B: float, grids: Grids) -> list[NDArray[np.float64]]:
        """Starts in the order of their violation."""
        p, least = self.placed(grids)
        return sorted(starts, key=lambda x: self._shortfall(x, omega_B, p, least))

    def _shortfall(
        self, x: NDArray[np.float64], omega_B: float, p: NDArray[np.float64], least: NDArray[np.float64]
    ) -> float:
        missing = least - np.array(self.slack(np.append(x, np.log(omega_B / self.omega_0)), p)).ravel()
        return float(np.max(missing)) if not np.any(np.isnan(missing)) else np.inf

    def solve(
        self, x: NDArray[np.float64], omega_B: float, grids: Grids, *, refining: bool = False
    ) -> Candidate | None:
        """Search from one start. Returns None when the solver does not end at a point it calls feasible."""
        p, least = self.placed(grids)
        solver, start = self.solver(refining), np.append(x, np.log(omega_B / self.omega_0))
        result = solver(x0=start, p=p, lbg=least, ubg=np.inf, **self.bounds)
        solution, stats = np.array(result["x"]).ravel(), solver.stats()
        if stats["return_status"] in INTERRUPTED:
            raise KeyboardInterrupt
        if not stats["success"] or not np.all(np.isfinite(solution)):
            return None
        omega_B = float(np.exp(solution[-1]) * self.omega_0)
        x = solution[:-1]
        return Candidate(self.structure.rounded(x, self.omega_0), omega_B, x, self.structure.corner(x, self.omega_0))

    def violated(self, candidate: Candidate, finer: Grids) -> tuple[list[float], list[float]]:
        """Where a candidate falls short on a finer grid and around its resonances: ω [rad/s], and fractions of ω_B."""
        at = np.append(candidate.x, np.log(candidate.omega_B / self.omega_0))
        peaks = self.resonances(candidate)
        inside = peaks[peaks < candidate.omega_B] / candidate.omega_B
        finer = replace(finer, omega=np.union1d(finer.omega, peaks), band=np.union1d(finer.band, inside))
        found: tuple[list[float], list[float]] = ([], [])
        chunks = self.places.count, self.nlp["p"].shape[0] - self._columns
        for on_band, points, places in ((False, finer.omega, chunks[0]), (True, finer.band, chunks[1])):
            slack = []
            for begin in range(0, points.size, places):
                part = points[begin : begin + places]
                given, _ = filled(part, (), places)
                idle = np.full(chunks[0 if on_band else 1], 1.0)
                p = np.concatenate([self.places.values(idle), given] if on_band else [self.places.values(given), idle])
                slack.append(np.array(self.slack(at, p)).ravel())
            for rows in (r for r in self.rows if r.constraint.on_band is on_band):
                values = np.concatenate([g[rows.start : rows.start + rows.count] for g in slack])[: points.size]
                values = np.where(rows.inside(points), values, np.inf)
                lower = (values <= np.append(values[1:], np.inf)) & (values <= np.insert(values[:-1], 0, np.inf))
                found[on_band].extend(float(w) for w in points[lower & (values < 0.0)])
        return found

    def resonances(self, candidate: Candidate) -> NDArray[np.float64]:
        """Frequencies around every lightly damped pole of Q and Q̃ or of C, which a fixed grid steps over. [rad/s]."""
        num, den = self.structure.polynomials(candidate.x)
        F = self.structure.sensor_filter(candidate.x)
        closed = self._characteristic(self.setting.loop.locked(), num, den, F)
        poles = np.concatenate([np.roots(np.array(p, dtype=float)) for p in (den, closed)])
        poles = poles[(poles.imag > 0) & (-poles.real < LIGHT * np.abs(poles))]
        widths = np.exp(np.outer(-poles.real / np.abs(poles), RESOLVED))
        around: NDArray[np.float64] = np.abs(poles)[:, None] * widths * self.omega_0
        return around.ravel()

    def _scalars(self) -> Any:
        """From x to C's numerator and denominator and Routh's columns: on scalars SX is quicker than MX."""
        loops = [vertex.loop for vertex in self.setting.vertices()]
        pencils = [pencil for loop in loops for pencil in (loop.locked(), loop.free(loop.nominal))]
        routh = [entry for pencil in pencils for entry in self._routh(pencil)]
        values = [ca.SX(ca.vertcat(*part)) for part in (*self._compensator(self.num, self.den, self.F), routh)]
        return ca.Function("scalars", [self.x], values)

    def _compensator(self, num: Coefficients, den: Coefficients, F: Filter) -> tuple[Coefficients, Coefficients]:
        """Numerator and denominator of C, Q/(1−Q) or C_imp, from those of the structure, times F if it is searched."""
        observer = self.setting.spec.controller.type == "dob"
        den = add(den, [-c for c in num]) if observer else den
        return (num, den) if F is None else (convolve(F[0], num), convolve(F[1], den))

    def _characteristic(self, pencil: Pencil, num: Coefficients, den: Coefficients, F: Filter) -> Coefficients:
        """Of the closed loop, in p, from numerator and denominator of the structure."""
        num, den = self._compensator(num, den, F)
        return add(convolve(self._scaled(pencil.on_den), den), convolve(self._scaled(pencil.on_num), num))

    def _variables(self, setting: Setting, C: Sequence[Any], s: Any, at: Any) -> dict[Variable, Split]:
        """Q, Q̃, L and the command at the frequencies s (Split, in rad/s). C: numerator and denominator, as columns."""
        p = s * (1 / self.omega_0)
        num, den = (_horner(ca.vertsplit(c), p) for c in C)
        CF = at(setting.loop.filters.force) * num  # and L, times den
        L = at(setting.loop.actuator.H) * CF
        return {
            Variable.Q: CF / (den + CF),
            Variable.Q_TILDE: L / (den + L),
            Variable.L: L / den,
            Variable.COMMAND: CF / (den + L),
        }

    def _on_grid(
        self, setting: Setting, constraint: Constraint, inequality: Inequality, X: dict[Variable, Split]
    ) -> Any:
        """Slack on the fixed grid, relative to the size of the right side."""
        places, right_side = self.places, inequality.right

        def size(omega: NDArray[np.float64]) -> NDArray[np.float64]:
            sizes = np.abs(right_side.constant.at(omega)) + np.abs(right_side.slope.at(omega))
            return np.full_like(sizes, sizes.min()) if inequality.role is Role.FLOOR else sizes

        W = places.real(lambda omega: Evaluator(setting, omega).radius(inequality.source))
        left, right = inequality.sides(float(constraint.level or 0), W, X[inequality.variable], places.at)
        return (right - left) / places.real(size)

    def _on_band(
        self, setting: Setting, constraint: Constraint, inequality: Inequality, X: dict[Variable, Split], s: Split
    ) -> Any:
        """Slack on [0, ω_B], the grid scaled by the variable ω_B, relative to the right side."""

        def at(r: RationalFunction) -> Any:
            return r(s)

        W: Any = 0.0
        if inequality.source is Source.DISC:  # a table by its largest bound: it has no formula in ω
            weight, table = setting.uncertainty.weight, setting.uncertainty.table
            W = 0.0 if weight is None else abs(at(weight))
            W = W if table is None else W + (1 + W) * to_float(max(table.bound))
        left, right = inequality.sides(float(constraint.level or 0), W, X[inequality.variable], numbered(at))
        return 1.0 - left / right

    def _routh(self, pencil: Pencil) -> list[Any]:
        """First column of Routh's table of a characteristic polynomial, normalised to leading coefficient 1."""
        p = self._characteristic(pencil, self.num, self.den, self.F)
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
