"""A minimum-phase weight W(s) of chosen order with `|W(jω)| ≥` a bound given in steps of ω: fitted, rounded, proven.

|W|² is a ratio P/R of polynomials in x = ω². For a given factor γ, `b² R ≤ P ≤ γ² b² R` at sampled frequencies is a
linear program in the coefficients of P and R; the smallest γ is found by halving, and then the mean of log |W| is made
small. The stable spectral factors of P and R, rounded, are the weight. What counts is the last step: `|W|² ≥ b²`
between exact polynomials, on every step, 0 and ∞ included.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from math import comb, sqrt

import numpy as np
from flint import fmpq_poly
from numpy.typing import NDArray

from ...models.rational import exact, polynomial
from ..certificate.hurwitz import is_hurwitz
from ..certificate.lowering import abs2
from ..certificate.outcome import Outcome
from ..certificate.positivity import positive_univariate
from ..spec.model import Polynomials
from ..spec.record import Bounds

MOST_STEPS = 100  # of a linear program
DIGITS = 5  # of a coefficient of W
MOST_ORDER = 6
HALVINGS = 24  # of the logarithm of γ
FLOOR = 0.02  # of the largest bound: below it, W need not follow the data
SPARE = (1.0, 1.0005, 1.002, 1.01, 1.03, 1.1, 1.3)  # what rounding and sampling may cost
SLACK = (0.001, 0.01, 0.05, 0.2, 0.5, 1.0, 2.0)  # of the logarithm of γ: room between the sampled frequencies

NOTHING = Fraction(1, 1000)  # a weight where nothing deviates: a specification's weight is not zero
ROUNDS, IMPROVEMENT = 12, 1e-3  # of tightening

Rows = NDArray[np.float64]
Pair = tuple[Rows, Rows]  # coefficients of P and of R


@dataclass(frozen=True)
class Step:
    """`|Δ| ≤ bound` for ω in [low, high], both [rad/s]; high None: up to ∞."""

    low: Fraction
    high: Fraction | None
    bound: Fraction


def steps(bounds: Bounds, below: Fraction, above: Fraction) -> tuple[Step, ...]:
    """The larger of two neighbours between them; outside of the band what is stated. Equal neighbours are merged."""
    omega = [point[0] for point in bounds]
    levels = [below, *(max(a[1], b[1]) for a, b in pairwise(bounds)), above]
    found: list[Step] = []
    for low, high, level in zip([Fraction(0), *omega], [*omega, None], levels, strict=True):
        if found and found[-1].bound == level:
            found[-1] = Step(found[-1].low, high, level)
        else:
            found.append(Step(low, high, level))
    return tuple(found)


def covers(weight: Polynomials, wanted: tuple[Step, ...]) -> bool:
    """Whether W is stable, minimum phase, and `|W(jω)| ≥ bound` on every step: exact, at every ω."""
    N, D = polynomial(weight.numerator), polynomial(weight.denominator)
    if not (is_hurwitz(D) and is_hurwitz(N)):
        return False
    numerator, denominator = abs2(N), abs2(D)
    degree = max(numerator.degree(), denominator.degree())
    return all(_covered(numerator - exact(step.bound**2) * denominator, step, degree) for step in wanted)


def _covered(gap: fmpq_poly, step: Step, degree: int) -> bool:
    interval = (exact(step.low**2), None if step.high is None else exact(step.high**2))
    return positive_univariate(gap, interval, strict=False, D=degree) is Outcome.PROVEN


def cover(wanted: tuple[Step, ...], order: int) -> Polynomials:
    """A weight that covers the steps closely: of this order, of a lower one where that fails, of order 0 at worst."""
    largest = max(step.bound for step in wanted)
    for lower in range(order if largest else 0, 0, -1):
        for weight in _candidates(_Program(_coarser(wanted), lower)):
            if covers(weight, wanted):
                return weight
    return Polynomials(numerator=(largest or NOTHING,), denominator=(Fraction(1),))


def _coarser(wanted: tuple[Step, ...]) -> tuple[Step, ...]:
    """No more steps than a linear program is quick with: neighbours become one, with the larger bound."""
    size = -(-len(wanted) // MOST_STEPS)
    groups = (wanted[k : k + size] for k in range(0, len(wanted), size))
    return tuple(Step(group[0].low, group[-1].high, max(step.bound for step in group)) for group in groups)


def _candidates(program: _Program) -> Iterator[Polynomials]:
    """Rounded weights, larger and larger."""
    low, high = 0.0, program.widest
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        low, high = (low, middle) if program.within(middle) is not None else (middle, high)
    for slack in SLACK:
        squared = program.within(high + slack)
        if squared is None:
            continue
        factors = [_stable_factor(part, program.centre) for part in program.tightened(squared)]
        if factors[0] is None or factors[1] is None:
            continue
        numerator, denominator = factors[0], factors[1]
        gain = numerator[0] / denominator[0]
        for spare in SPARE:
            yield Polynomials(
                numerator=tuple(_rounded(c / numerator[0] * gain * spare) for c in numerator),
                denominator=tuple(_rounded(c / denominator[0]) for c in denominator),
            )


class _Program:
    """The linear programs at their sampled frequencies; polynomials in Bernstein's basis of t = x/(x + centre)."""

    def __init__(self, wanted: tuple[Step, ...], order: int) -> None:
        ends = [float(step.low) for step in wanted[1:]] or [1.0]
        self.order, self.centre = order, ends[0] * ends[-1]
        largest = max(float(step.bound) for step in wanted)
        covering, middles = [(0.0, float(wanted[0].bound))], []
        for step in wanted:
            low = float(step.low) or ends[0] / 1e3
            high = ends[-1] * 1e3 if step.high is None else float(step.high)
            covering += [(w, float(step.bound)) for w in np.geomspace(low, high, _count(high / low))]
            middles.append((sqrt(low * high), max(float(step.bound), FLOOR * largest)))
        covering.append((np.inf, float(wanted[-1].bound)))
        (self.basis, self.bound), (self.middle, self.target) = self._rows(covering), self._rows(middles)
        self.widest = float(np.log(2 * largest / self.target.min()) + 1)

    def _rows(self, points: list[tuple[float, float]]) -> tuple[Rows, Rows]:
        omega, bound = np.array(points).T
        t, n = 1 / (1 + self.centre / np.maximum(omega, 1e-150) ** 2), self.order
        return np.column_stack([comb(n, k) * t**k * (1 - t) ** (n - k) for k in range(n + 1)]), bound

    def within(self, log_factor: float) -> Pair | None:
        """P and R that exceed the middles by at most a factor γ, R as large as it can be; None: there are none."""
        top = (self.target * np.exp(log_factor))[:, None] ** 2
        above = np.hstack([self.middle / top, -self.middle, np.zeros((len(self.middle), 1))])  # P ≤ γ² b² R
        return self._solved(np.array([0.0] * (2 * self.order + 2) + [-1.0]), above)

    def tightened(self, found: Pair) -> Pair:
        """P and R with a small sum of `log P − log R` over the middles: the factor γ alone leaves slack elsewhere.

        Linearised, in steps that change no value at a middle by more than a share, halved when a step does not help.
        """
        share = 0.5
        for _ in range(ROUNDS):
            rows = [np.hstack([m, np.zeros((len(m), 1))]) for m in self._relative(found)]
            trust = np.vstack([sign * row for row in rows for sign in (1, -1)])
            room = np.repeat([1 + share, share - 1, 1 + share, share - 1], len(self.middle))
            step = self._solved(rows[0].sum(axis=0) - rows[1].sum(axis=0), trust, room)
            if step is None or self._excess(step) > self._excess(found) - IMPROVEMENT:
                share /= 2
            found = found if step is None or self._excess(step) > self._excess(found) else step
        return found

    def _relative(self, found: Pair) -> tuple[Rows, Rows]:
        """Rows that give P and R at the middles relative to what they are."""
        P, R = ((self.middle @ part)[:, None] for part in found)
        zero = np.zeros_like(self.middle)
        return np.hstack([self.middle / P, zero]), np.hstack([zero, self.middle / R])

    def _excess(self, found: Pair) -> float:
        P, R = (self.middle @ part for part in found)
        return float(np.log(P / R).mean())

    def _solved(self, goal: Rows, above: Rows, room: Rows | None = None) -> Pair | None:
        """The least `goal` over P, R and the least value of R, with `b² R ≤ P` and `above·(P, R, least) ≤ room`."""
        from scipy.optimize import linprog

        n, squared, zero = self.order + 1, (self.bound**2)[:, None], np.zeros((len(self.basis), 1))
        scale = np.maximum(squared, 1e-12)
        covered = np.hstack([-self.basis / scale, self.basis * squared / scale, zero])
        positive = np.hstack([np.zeros_like(self.basis), -self.basis, zero + 1])
        right = np.concatenate([np.zeros(2 * len(self.basis)), np.zeros(len(above)) if room is None else room])
        total = np.hstack([np.zeros(n), self.basis.mean(axis=0), 0.0])[None, :]
        bounds = [(None, None)] * (2 * n) + [(1e-6, None)]
        A = np.vstack([covered, positive, above])
        found = linprog(goal, A_ub=A, b_ub=right, A_eq=total, b_eq=[1.0], bounds=bounds, method="highs")
        return (found.x[:n], found.x[n : 2 * n]) if found.status == 0 else None


def _count(ratio: float) -> int:
    """How many frequencies a step is sampled at; odd, so that its middle is one of them."""
    return int(np.clip(10 * np.log10(ratio), 3, 25)) | 1


def _stable_factor(bernstein: NDArray[np.float64], centre: float) -> NDArray[np.float64] | None:
    """Coefficients of f(s), roots on the left, with `|f(jω)|²` that polynomial; None if it changes sign for ω > 0."""
    n = len(bernstein) - 1
    # Σ cₖ·C(n,k)·tᵏ(1−t)ⁿ⁻ᵏ = Σ cₖ·C(n,k)·(x/centre)ᵏ / (1 + x/centre)ⁿ
    ascending = np.array([comb(n, k) * c for k, c in enumerate(bernstein)])
    if ascending[-1] <= 0:
        return None
    x = np.roots(ascending[::-1]) * centre
    if ((abs(x.imag) <= 1e-9 * abs(x)) & (x.real >= 0)).any():
        return None
    roots = np.sqrt((-x).astype(complex))  # s² = −x
    roots = np.where(roots.real > 0, -roots, roots)
    return np.asarray(np.sqrt(ascending[-1]) * np.atleast_1d(np.poly(roots)).real * centre ** (-n / 2))


def _rounded(value: float) -> Fraction:
    return Fraction(f"{value:.{DIGITS - 1}e}")
