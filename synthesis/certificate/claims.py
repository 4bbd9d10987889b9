"""Claims, each a sandwich: proven at one level, refuted just beyond it at an exact frequency."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import chain

import numpy as np
from flint import fmpq, fmpq_poly

from ...models.controller import Compensator
from ...models.rational import RationalFunction, exact, fraction
from ..problem.constraints import constraints
from ..problem.constraints.inequality import Constraint, Gain, Role, Variable
from ..problem.grid import Evaluator, grid
from ..problem.setting import Setting
from .hurwitz import decay_rate, is_hurwitz
from .lowering import SumOfRoots, lower
from .outcome import Interval, Outcome, all_of
from .positivity import holds
from .witness import Witness, fails_at, find_witness, short

TIGHTNESS = (1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1)  # how far from the float optimum a level is tried, relative
FAR = 1e5  # how far beyond the joint's own frequencies the grid reaches
LARGEST_FACTOR = 1e6  # margins on W beyond this are not searched for
NEEDLES = 3  # resonances overlooked by the grid that may shorten the band, one after another


@dataclass(frozen=True)
class Refutation:
    """A level at which a claim fails, and where."""

    value: Fraction
    witness: Witness | None


@dataclass(frozen=True)
class Claim:
    """One statement about the exact controller, its status, and how tight it is. interval: (ω low, ω high or None)."""

    id: str
    equation: str
    form: str
    statement: str
    uncertainty: str
    interval: tuple[Fraction, Fraction | None]
    required: bool
    status: Outcome
    margin: Fraction | None
    refuted_at: Refutation | None


@dataclass(frozen=True)
class Subject:
    """What is being certified: a setting and one exact compensator."""

    setting: Setting
    compensator: Compensator

    @property
    def variables(self) -> dict[Variable, RationalFunction]:
        """Q, Q̃ and L as exact functions of s."""
        loop, C = self.setting.loop, self.compensator
        return {Variable.Q: loop.Q_ideal(C), Variable.Q_TILDE: loop.Q_tilde(C), Variable.L: loop.L(C)}


def certify(setting: Setting, compensator: Compensator) -> tuple[Claim, ...]:
    """Every claim of a specification about one compensator, each proven, refuted or undecided."""
    subject = Subject(setting, compensator)
    prover = Prover.of(subject)
    band = prover.bandwidth()
    claims = [*prover.stability()]
    for constraint in constraints(setting):
        if constraint.id == "bandwidth":
            claims.append(band)
        elif constraint.on_band:
            claims.append(prover.claim(replace(constraint, band=band.interval)))
        elif constraint.largest_band:
            claims.append(prover.largest_band(constraint))
        else:
            claims.append(prover.claim(constraint))
    return tuple(claims)


@dataclass(frozen=True)
class Counterexample:
    """Where a required claim fails, for the search: a frequency [rad/s], and whether it is the objective's own band."""

    id: str
    omega: float
    on_band: bool


def counterexamples(setting: Setting, compensator: Compensator, omega_B: float) -> tuple[Counterexample, ...]:
    """Where the required claims, the objective's up to omega_B, cannot be proven; () when all are.

    A claim that fails without a frequency (stability, an undecided proof) counts at ω = ∞.
    """
    prover = Prover.of(Subject(setting, compensator))
    found = [Counterexample(c.id, np.inf, False) for c in prover.stability() if c.status is not Outcome.PROVEN]
    for asked in constraints(setting):
        if asked.level is None:
            continue
        c = replace(asked, band=(Fraction(0), short(omega_B, up=False))) if asked.on_band else asked
        if prover.decide(c, asked.level) is not Outcome.PROVEN:
            found += [Counterexample(c.id, omega, c.on_band) for omega in prover.failing(c, asked.level)]
    return tuple(found)


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
            for lowered in self._lowered(constraint, index, v):
                outcomes.append(holds(lowered, interval, strict=_strict(constraint)))
                if outcomes[-1] is Outcome.REFUTED:
                    return Outcome.REFUTED
        if constraint.positive_real and self._failing_end() is not None:
            return Outcome.REFUTED
        return all_of(outcomes)

    def _lowered(self, constraint: Constraint, index: int, v: Fraction) -> Iterator[SumOfRoots]:
        inequality = constraint.inequalities[index]
        return lower(inequality, exact(v), self.X[inequality.variable], self.subject.setting.uncertainty)

    def _failing_end(self) -> Witness | None:
        """Where Z/s fails to be positive real: its residue Z(0) at s = 0 must be ≥ 0, and lim Z/s², that at ∞."""
        setting = self.subject.setting
        for load in setting.uncertainty.corners():
            Z = setting.loop.Z(self.subject.compensator, load)
            at_zero = Z.num[0] / Z.den[0] if Z.den[0] != 0 else fmpq(-1)
            excess = Z.relative_degree
            at_infinity = Z.num.leading_coefficient() / Z.den.leading_coefficient()
            if at_zero < 0:
                return Witness(Fraction(0), load)
            if excess < -2 or (excess == -2 and at_infinity < 0):
                return Witness(None, load)
        return None

    def witness(self, constraint: Constraint, v: Fraction) -> Witness | None:
        """An exact point where the constraint fails at level v; the grid's worst frequency is tried first."""
        _, omega, worst = self.evaluator.worst(constraint, float(v), self.X)
        order = [worst, *(k for k in range(len(constraint.inequalities)) if k != worst)]
        for index in order:
            for lowered in self._lowered(constraint, index, v):
                found = find_witness(lowered, _squared(constraint.band), (omega,), strict=_strict(constraint))
                if found is not None:
                    return found
        return self._failing_end() if constraint.positive_real else None

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

    def claim(self, constraint: Constraint) -> Claim:
        """Prove at the hardest level found; if the required level cannot be proven, refute it with a witness."""
        prover = replace(self, evaluator=self.evaluator.with_ends(constraint))._focused(constraint)
        (best, _), required, harder = prover._best_level(constraint), constraint.level, constraint.role.harder
        levels = _beside(best, -harder, constraint)
        if required is not None:
            levels = [v for v in levels if harder * (v - required) > 0] + [required]
        for proven in levels:
            if _meaningful(constraint, proven) and self.decide(constraint, proven) is Outcome.PROVEN:
                return _claim(constraint, Outcome.PROVEN, proven, prover._beyond_level(constraint, best, proven))
        level = required if required is not None else _easiest(constraint)
        found = prover.witness(constraint, level)
        if found is None:
            return _claim(constraint, Outcome.UNDECIDED, None, None)
        return _claim(constraint, Outcome.REFUTED, None, Refutation(level, found))

    def _beyond_level(self, constraint: Constraint, best: float, proven: Fraction) -> Refutation | None:
        """The twin: the least harder level found at which the claim fails, and where."""
        harder = constraint.role.harder
        for v in _beside(best, harder, constraint):
            if harder * (v - proven) > 0 and (found := self.witness(constraint, v)):
                return Refutation(v, found)
        return None

    def _focused(self, constraint: Constraint) -> Prover:
        """The same prover with a grid refined twice around the constraint's worst frequency."""
        prover = self
        for _ in range(2):
            _, worst = prover._best_level(constraint)
            omega = prover.evaluator.omega
            k = int(np.searchsorted(omega, worst))
            near = np.linspace(omega[max(k - 1, 0)], omega[min(k + 1, omega.size - 1)], 64)
            prover = replace(prover, evaluator=Evaluator(self.subject.setting, np.unique([*omega, *near])))
        return prover

    def _best_level(self, constraint: Constraint) -> tuple[float, float]:
        """The hardest level that holds on the grid, in floats, and the frequency that decides it."""
        inside, harder = self.evaluator.inside(constraint), constraint.role.harder
        worst = (harder * LARGEST_FACTOR, 0.0)
        for inequality in constraint.inequalities:
            if any(term.gain is Gain.R for term in inequality.moduli):
                return float(constraint.level or 1), 0.0  # not tightened: proven at the level asked for, or not
            levels = np.where(inside, self.evaluator.levels(inequality, self.X), harder * LARGEST_FACTOR)
            levels = np.where(np.isnan(levels), harder * LARGEST_FACTOR, levels)
            k = int(np.argmin(harder * levels))
            if harder * levels[k] < harder * worst[0]:
                worst = (float(levels[k]), float(self.evaluator.omega[k]))
        return worst

    def largest_band(self, constraint: Constraint) -> Claim:
        """Prove a constraint on the widest interval where it holds; refuted everywhere if there is none."""
        v = float(_easiest(constraint))
        omega, fits = self.evaluator.omega, self.evaluator.inside(constraint)
        for inequality in constraint.inequalities:
            fits &= np.nan_to_num(self.evaluator.slack(inequality, v, self.X), nan=-1.0) > 0
        for a, b in _runs(fits, omega):
            for tightness in TIGHTNESS:
                ends = (short(a * (1 + tightness), up=True), short(b * (1 - tightness), up=False))
                if ends[0] < ends[1]:
                    narrowed = replace(constraint, band=ends)
                    if self.decide(narrowed, Fraction(1)) is Outcome.PROVEN:
                        return _claim(narrowed, Outcome.PROVEN, Fraction(1), None)
        found = self.witness(constraint, Fraction(1))
        status = Outcome.REFUTED if found else Outcome.UNDECIDED
        return _claim(constraint, status, None, Refutation(Fraction(1), found) if found else None)

    def bandwidth(self) -> Claim:
        """The largest ω_B up to which every condition of the objective holds, or the attenuation where that is none."""
        wanted = [c for c in constraints(self.subject.setting) if c.on_band and c.required]
        attenuation = next(c for c in wanted if c.id == "bandwidth")
        for conditions in (wanted, [attenuation]):
            first = min(chain.from_iterable(self._failures(c) for c in conditions), default=LARGEST_FACTOR)
            end = self._proven_end(conditions, first)
            if end is not None:
                beyond = self._beyond(attenuation, first, end)
                return _claim(replace(attenuation, band=(Fraction(0), end)), Outcome.PROVEN, end, beyond)
        nowhere = replace(attenuation, band=(Fraction(0), Fraction(0)))
        found = self.witness(nowhere, self.subject.setting.spec.objective.attenuation)
        if found is None:
            return _claim(nowhere, Outcome.UNDECIDED, None, None)
        return _claim(nowhere, Outcome.REFUTED, None, Refutation(Fraction(0), found))

    def _proven_end(self, conditions: list[Constraint], first: float, needles: int = NEEDLES) -> Fraction | None:
        """The largest ω_B below `first` up to which all conditions are proven; below a needle the grid overlooked."""
        for tightness in TIGHTNESS:
            end = short(first * (1 - tightness), digits=8, up=False)
            band = [(replace(c, band=(Fraction(0), end)), c.level or Fraction(0)) for c in conditions]
            if end > 0 and all(self.decide(c, level) is Outcome.PROVEN for c, level in band):
                return end
        found = [self.witness(c, level) for c, level in band]
        lower = min((float(w.omega) for w in found if w is not None and w.omega), default=0.0)
        return self._proven_end(conditions, lower, needles - 1) if needles and 0 < lower < first else None

    def _failures(self, constraint: Constraint) -> Iterator[float]:
        """Frequencies on the grid's refinement at which a band condition first fails."""
        for inequality in constraint.inequalities:
            omega = self.evaluator.omega
            slack = self.evaluator.slack(inequality, float(constraint.level or 0), self.X)
            failing = np.flatnonzero(slack < 0)
            if not failing.size:
                continue
            k = int(failing[0])
            a, b = (0.0 if k == 0 else float(omega[k - 1])), float(omega[k])
            for _ in range(60):
                middle = 0.5 * (a + b)
                at = Evaluator(self.subject.setting, np.array([middle]))
                a, b = (a, middle) if at.slack(inequality, float(constraint.level or 0), self.X)[0] < 0 else (middle, b)
            yield a

    def _beyond(self, attenuation: Constraint, first: float, proven: Fraction) -> Refutation | None:
        """The twin: a frequency at which the attenuation fails, close to where the band ends or else its own first."""
        level = self.subject.setting.spec.objective.attenuation
        lowered = list(self._lowered(attenuation, 0, level))
        for start in (first, *self._failures(attenuation)):
            for tightness in TIGHTNESS:
                end = short(start * (1 + tightness), digits=8, up=True)
                if any(fails_at(one, end, strict=False) for one in lowered):
                    return Refutation(end, Witness(end, None))
        found = self.witness(replace(attenuation, band=(proven, 2 * proven)), level)
        return None if found is None or found.omega is None else Refutation(found.omega, found)

    def stability(self) -> Iterator[Claim]:
        """Nominal stability free (zeros of Z) and against a rigid wall (zeros of 1+HCF), with the decay rate."""
        loop, C = self.subject.setting.loop, self.subject.compensator
        free, locked = loop.free(loop.nominal)(C), loop.locked()(C)
        yield _stability("stability-free", "denominator of (8) and (17)", "every mode in free motion", free)
        yield _stability("stability-locked", "1 + HCF", "every mode against a rigid wall", locked)


def _stability(id: str, equation: str, what: str, p: fmpq_poly) -> Claim:
    rate = decay_rate(p)
    levels = [short(rate * (1 - tightness), up=False) for tightness in TIGHTNESS] if rate > 0 else []
    proven = next((v for v in [*levels, Fraction(0)] if is_hurwitz(p, exact(v))), None)
    refuted = None
    if proven is not None:
        beyond = (short(rate * (1 + tightness), up=True) for tightness in TIGHTNESS)
        value = next((v for v in beyond if v > proven and not is_hurwitz(p, exact(v))), None)
        refuted = None if value is None else Refutation(value, None)
    return Claim(
        id=id,
        equation=equation,
        form="hurwitz",
        statement=f"{what} decays faster than exp(−v·t), nominal load",
        uncertainty="none: nominal load",
        interval=(Fraction(0), None),
        required=True,
        status=Outcome.REFUTED if proven is None else Outcome.PROVEN,
        margin=proven,
        refuted_at=Refutation(Fraction(0), None) if proven is None else refuted,
    )


def _claim(c: Constraint, status: Outcome, margin: Fraction | None, refuted_at: Refutation | None) -> Claim:
    return Claim(
        c.id, c.equation, c.form, c.statement, c.uncertainty, c.band, c.required, status, margin, refuted_at
    )


def _strict(constraint: Constraint) -> bool:
    return constraint.strict and constraint.role is Role.RADIUS


def _squared(band: tuple[Fraction, Fraction | None]) -> Interval:
    low, high = band
    return exact(low * low), None if high is None else exact(high * high)


def _easiest(constraint: Constraint) -> Fraction:
    return Fraction(0) if constraint.role is Role.FLOOR else Fraction(1)


def _meaningful(constraint: Constraint, v: Fraction) -> bool:
    return v > 0 if constraint.id == "friction" else constraint.role is Role.FLOOR or v > 0


def _beside(v: float, side: int, constraint: Constraint) -> list[Fraction]:
    """Short levels a little beside v: relative, or for levels that can be zero in absolute terms as well."""
    if not np.isfinite(v):
        return []
    scale = abs(v) + 1e-4 if constraint.role is Role.FLOOR else abs(v)
    return [short(v + side * tightness * scale, up=side > 0) for tightness in TIGHTNESS]


def _runs(fits: np.ndarray, omega: np.ndarray) -> list[tuple[float, float]]:
    """Maximal intervals of the grid on which `fits`, widest first."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], fits, [False]]).astype(int)))
    runs = [(float(omega[a]), float(omega[b - 1])) for a, b in zip(edges[::2], edges[1::2], strict=True) if b - 1 > a]
    return sorted(runs, key=lambda run: run[0] - run[1])


def _grid_of(subject: Subject, Q_tilde: RationalFunction) -> np.ndarray:
    """A dense grid, denser around every resonance of the closed loop."""
    setting = subject.setting
    middle = grid(setting, spread=1500)
    ends = np.geomspace(1, FAR, 25)  # where limits at 0 and ∞ are approached
    coarse = np.concatenate([middle, middle[0] / ends, middle[-1] * ends])
    polynomials = [subject.setting.loop.locked()(subject.compensator), Q_tilde.num, Q_tilde.den]
    polynomials += [setting.loop.free(load)(subject.compensator) for load in setting.uncertainty.corners()]
    extra = []
    for p in polynomials:
        if p.degree() <= 0:
            continue
        lead = p.leading_coefficient()
        for root in np.roots([float(fraction(c / lead)) for c in p.coeffs()[::-1]]):
            width = max(abs(root.real), 1e-9 * abs(root))
            extra.append(abs(root.imag) + width * np.linspace(-3, 3, 41))
    omega = np.concatenate([coarse, *extra]) if extra else coarse
    return np.unique(omega[(omega > 0) & np.isfinite(omega)])
