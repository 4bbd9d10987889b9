"""Exact proofs of one controller's constraints; the grid only says where to try."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np

from ...models.controller import Compensator
from ...models.rational import ONE, ZERO, RationalFunction, S, at_infinity, at_zero, exact
from ..problem.constraints.eq12 import least_at_end
from ..problem.constraints.inequality import Constraint, Role, Variable
from ..problem.grid import Evaluator, float_roots, grid
from ..problem.setting import Setting
from .enclosure.joint import family_of
from .enclosure.prover import CellProver
from .lowering import SumOfRoots, abs2, lower, strip
from .outcome import Interval, Outcome, all_of
from .positivity import holds
from .witness import Witness, find_witness

FAR = 1e5  # how far beyond the joint's own frequencies the grid reaches
LARGEST_LEVEL = 1e6  # levels beyond this are not searched for
BASINS = 4  # local minima of the margin around which the grid is refined


@dataclass(frozen=True)
class Subject:
    """What is being certified: a setting and one exact compensator."""

    setting: Setting
    compensator: Compensator

    @property
    def variables(self) -> dict[Variable, Any]:
        """Q, Q̃, L and the noise gain as exact functions of s."""
        return self.setting.variables(self.compensator)


@dataclass(frozen=True)
class Prover:
    """Exact proofs of one subject's constraints; the grid only says where to try."""

    subject: Subject
    X: dict[Variable, RationalFunction]
    evaluator: Evaluator

    @classmethod
    def of(cls, subject: Subject) -> Prover:
        """Prepare the transfer functions and the grid that suggests levels and witnesses."""
        X = subject.variables
        return cls(subject, X, Evaluator(subject.setting, _grid_of(subject, X[Variable.Q_TILDE])))

    def decide(self, constraint: Constraint, v: Fraction) -> Outcome:
        """Whether a constraint holds at level v on its whole interval."""
        interval = _squared(constraint.band)
        outcomes = []
        for index in range(len(constraint.inequalities)):
            for lowered in self.lowered(constraint, index, v):
                outcomes.append(holds(lowered, interval, strict=_strict(constraint)))
                if outcomes[-1] is Outcome.REFUTED:
                    return Outcome.REFUTED
        if Outcome.UNDECIDED in outcomes:  # three roots or more, or two sides that touch along a segment
            outcomes = [self.on_cells(constraint, v)]
        if constraint.positive_real and self._failing_end(constraint) is not None:
            return Outcome.REFUTED
        return all_of(outcomes)

    def needs_cells(self, constraint: Constraint) -> bool:
        """Whether a constraint is about three roots or more, or about a segment of loads."""
        sides = [one for k in range(len(constraint.inequalities)) for one in self.lowered(constraint, k, Fraction(1))]
        return any(len(strip(one).radicands) > 2 or len(one.right) > 1 for one in sides)

    def on_cells(self, constraint: Constraint, v: Fraction) -> Outcome:
        """The same by enclosures, which know no equality."""
        subject = self.subject
        found = CellProver(family_of(subject.setting, subject.compensator)).decide([(constraint, v)])
        if found.low > 0:
            return Outcome.PROVEN
        return Outcome.REFUTED if found.high < 0 else Outcome.UNDECIDED

    def lowered(self, constraint: Constraint, index: int, v: Fraction) -> Iterator[SumOfRoots]:
        """One inequality of a constraint at level v, as polynomials."""
        inequality = constraint.inequalities[index]
        return lower(inequality, exact(v), self.X[inequality.variable], self.subject.setting.uncertainty)

    def _failing_end(self, constraint: Constraint) -> Witness | None:
        """An end of [0, ∞] where `Re(Z/jω)` is silent about the pole of Z/s: Z(0) and lim Z/s² must be ≥ 0.

        A strict constraint (friction) wants Z over its nominal value > 0 there instead, so that no load moves a root
        through 0 or ∞.
        """
        setting, C = self.subject.setting, self.subject.compensator
        loop, weight = setting.loop, setting.uncertainty.weight
        nominal, left = loop.Z(C, loop.nominal), 1 - self.X[Variable.Q_TILDE]
        V2 = ZERO if weight is None else RationalFunction(abs2(weight.num), abs2(weight.den))
        for load in setting.uncertainty.corners():
            Z, own = loop.Z(C, load), left * load.rational
            for omega, limit, unit in ((Fraction(0), at_zero, ONE), (None, at_infinity, S * S)):
                reference = nominal if constraint.strict else unit
                A, B, V = limit(Z / reference), limit(own / reference), limit(V2)
                if A is None or B is None or V is None:
                    return Witness(omega, load)
                least = min(A, least_at_end(A, B, V))
                if least < 0 or (constraint.strict and least == 0):
                    return Witness(omega, load)
        return None

    def witness(self, constraint: Constraint, v: Fraction) -> Witness | None:
        """An exact point where the constraint fails at level v; the grid's worst frequency is tried first."""
        _, omega, worst = self.evaluator.worst(constraint, float(v), self.X)
        order = [worst, *(k for k in range(len(constraint.inequalities)) if k != worst)]
        for index in order:
            for lowered in self.lowered(constraint, index, v):
                found = find_witness(lowered, _squared(constraint.band), (omega,), strict=_strict(constraint))
                if found is not None:
                    return found
        return self._failing_end(constraint) if constraint.positive_real else None

    def failing(self, constraint: Constraint, v: Fraction) -> tuple[float, ...]:
        """Frequencies where a constraint fails worst: each local minimum of its slack on the grid, or the witness."""
        evaluator = self.evaluator.with_ends(constraint)
        inside = evaluator.inside(constraint)
        found: list[float] = []
        for inequality in constraint.inequalities:
            slack = np.where(inside, evaluator.slack(inequality, float(v), self.X), np.inf)
            padded = np.concatenate([[np.inf], slack, [np.inf]])
            lowest = (slack < 0) & (slack <= padded[:-2]) & (slack <= padded[2:])
            found += [float(omega) for omega in evaluator.omega[lowest]]
        if not found:
            witness = self.witness(constraint, v)
            found = [np.inf if witness is None or witness.omega is None else float(witness.omega)]
        return tuple(found)

    def focused(self, constraint: Constraint) -> tuple[Prover, float, float]:
        """A prover with a grid refined twice where the constraint is tightest; the hardest level that holds, and its ω.

        Level and ω are floats: they say what to try. Only new frequencies are evaluated.
        """
        setting, omega, tight = self.subject.setting, self.evaluator.omega, self._tightness(constraint)
        for _ in range(2):
            padded = np.concatenate([[np.inf], tight, [np.inf]])
            lowest = np.flatnonzero((tight <= padded[:-2]) & (tight <= padded[2:]))
            lowest = lowest[np.argsort(tight[lowest])[:BASINS]]
            ends = [(omega[max(k - 1, 0)], omega[min(k + 1, omega.size - 1)]) for k in lowest.tolist()]
            between = np.concatenate([np.linspace(low, high, 64)[1:-1] for low, high in ends])
            omega, first = np.unique(np.concatenate([omega, between]), return_index=True)
            refined = replace(self, evaluator=Evaluator(setting, between))
            tight = np.concatenate([tight, refined._tightness(constraint)])[first]
        k = int(np.argmin(tight))
        prover = replace(self, evaluator=Evaluator(setting, omega))
        return prover, constraint.role.harder * float(tight[k]), float(omega[k])

    def near(self, omega: float) -> Prover:
        """A prover that looks for witnesses from one frequency."""
        return replace(self, evaluator=Evaluator(self.subject.setting, np.array([omega])))

    def _tightness(self, constraint: Constraint) -> np.ndarray:
        """The hardest level that holds at each ω, over all inequalities, negative for a CEILING: the least decides."""
        inside, harder = self.evaluator.inside(constraint), constraint.role.harder
        levels = [harder * self.evaluator.levels(inequality, self.X) for inequality in constraint.inequalities]
        tight = np.min([np.where(np.isnan(level), LARGEST_LEVEL, level) for level in levels], axis=0)
        return np.where(inside, tight, LARGEST_LEVEL)


def _strict(constraint: Constraint) -> bool:
    return constraint.strict and constraint.role is Role.RADIUS


def _squared(band: tuple[Fraction, Fraction | None]) -> Interval:
    low, high = band
    return exact(low * low), None if high is None else exact(high * high)


def _grid_of(subject: Subject, Q_tilde: RationalFunction) -> np.ndarray:
    """A dense grid, denser around every resonance of the closed loop."""
    setting = subject.setting
    middle = grid(setting, spread=1500)
    ends = np.geomspace(1, FAR, 25)  # where limits at 0 and ∞ are approached
    coarse = np.concatenate([middle, middle[0] / ends, middle[-1] * ends])
    polynomials = [subject.setting.loop.locked()(subject.compensator), Q_tilde.num, Q_tilde.den]
    polynomials += [setting.loop.free(load)(subject.compensator) for load in setting.uncertainty.corners()]
    extra = []
    for root in (root for p in polynomials for root in float_roots(p)):
        width = max(abs(root.real), 1e-9 * abs(root))
        extra.append(abs(root.imag) + width * np.linspace(-3, 3, 41))
    omega = np.concatenate([coarse, *extra])
    return np.unique(omega[(omega > 0) & np.isfinite(omega)])
