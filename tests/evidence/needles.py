"""Joints that are wrong only within a part in 10⁹ of one frequency, or only touch: truth by construction.

With an ideal actuator `1 − Q̃ = 1 − Q` and the nominal port is exactly the desired impedance: Q and W can be anything.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray
from random_specs import Json

Row = list[Fraction]
LOW, HIGH = 1e-2, 1e5  # rad/s, where a grid would look
NOMINAL = {"inertia": "0.05", "damping": "0.3", "stiffness": "2"}


def row(*values: int | str | Fraction) -> Row:
    return [Fraction(v) for v in values]


def times(p: Row, q: Row) -> Row:
    out = [Fraction(0)] * (len(p) + len(q) - 1)
    for i, a in enumerate(p):
        for j, b in enumerate(q):
            out[i + j] += a * b
    return out


def plus(p: Row, q: Row) -> Row:
    n = max(len(p), len(q))
    p, q = [Fraction(0)] * (n - len(p)) + p, [Fraction(0)] * (n - len(q)) + q
    return [a + b for a, b in zip(p, q, strict=True)]


@dataclass(frozen=True)
class Ratio:
    """A rational function, descending powers of s."""

    n: Row
    d: Row

    def __add__(self, other: Ratio) -> Ratio:
        return Ratio(plus(times(self.n, other.d), times(other.n, self.d)), times(self.d, other.d))

    def times(self, other: Ratio) -> Ratio:
        return Ratio(times(self.n, other.n), times(self.d, other.d))

    def by(self, factor: Fraction) -> Ratio:
        return Ratio([factor * c for c in self.n], self.d)

    def written(self) -> Json:
        return {"numerator": [str(c) for c in self.n], "denominator": [str(c) for c in self.d]}

    def at(self, omega: NDArray[np.float64]) -> NDArray[np.complex128]:
        s = 1j * omega
        return np.polyval([float(c) for c in self.n], s) / np.polyval([float(c) for c in self.d], s)


def resonance(zeta: Fraction, omega: Fraction) -> Ratio:
    """`2ζωs/(s² + 2ζωs + ω²)`: a circle through 0, exactly 1 at ω, about 0 a few ζω away."""
    width = 2 * zeta * omega
    return Ratio(row(width, 0), row(1, width, omega**2))


def between(points: int, near: float = 40.0) -> Fraction:
    """A frequency in the middle, in logarithms, between two points of the grid."""
    grid = np.geomspace(LOW, HIGH, points)
    k = int(np.searchsorted(grid, near))
    return Fraction(float(np.sqrt(grid[k - 1] * grid[k]))).limit_denominator(10**9)


def joint(constraints: Json, *, Q: Ratio | None = None, C: Ratio | None = None, weight: Ratio | None = None) -> Json:
    """An ideal actuator, the load as it is as the desired impedance, a box of one load or a weight."""
    box = {key: [value, value] for key, value in NOMINAL.items()}
    return {
        "robimp": 1,
        "name": "needle",
        "motion": "rotary",
        "plant": NOMINAL,
        "uncertainty": {"weight": weight.written()} if weight else {"box": box},
        "actuator": {"type": "ideal"},
        "impedance": NOMINAL,
        "controller": {
            "type": "dob" if Q else "dynamic-feedback",
            "coefficients": (Q or C or Ratio(row(1), row(1))).written(),
        },
        "objective": {"maximize": "bandwidth", "attenuation": "0.9"},
        "constraints": constraints,
    }


@dataclass(frozen=True)
class Needle:
    """A joint, the claim in question, whether it is true, and what a grid compares: proven there if all are ≥ 0."""

    name: str
    spec: Json
    id: str
    truth: bool
    slack: Callable[[NDArray[np.float64]], NDArray[Any]]


def _peak(name: str, X: Ratio, limit: Fraction, truth: bool) -> Needle:
    """`|1 − Q̃| ≤ limit` with `1 − Q̃ = 1 − Q = X`."""
    Q = Ratio(plus(X.d, [-c for c in X.n]), X.d)
    while Q.n[0] == 0 and len(Q.n) > 1:
        Q = Ratio(Q.n[1:], Q.d)
    spec = joint({"peak": str(limit)}, Q=Q)
    return Needle(name, spec, "peak", truth, lambda w: float(limit) - np.abs(X.at(w)))


def _weighted(name: str, W: Ratio, truth: bool) -> Needle:
    """(9) with C = 1, Q = 1/2 and m = ĝ is `|W| < 2`."""
    return Needle(name, joint({"eq9": {}}, weight=W), "eq9", truth, lambda w: 2 - np.abs(W.at(w)))


def peaked(t: Fraction) -> tuple[Ratio, Fraction]:
    """`X = s²/(s² + ks + ω²)` and its exact peak `L = (t + 1/t)/2`: |X|² = x²/(x² − (2ω² − k²)x + ω⁴)."""
    L, root = (t + 1 / t) / 2, (t - 1 / t) / 2  # root² = L² − 1
    return Ratio(row(1, 0, 0), row(1, 5, 25 / (2 * (1 - root / L)))), L


def needles(points: int = 1_000_000) -> list[Needle]:
    """Every needle, at a frequency between two points of a grid of that many."""
    sharp, tiny, at = Fraction(1, 10**9), Fraction(1, 10**12), between(points)
    bump, lag = resonance(sharp, at), Ratio(row("1/2"), row(1, 1))
    at_zero, at_infinity = Ratio(row(3), row(1, 3)), Ratio(row(1, 0), row(1, 3))
    (flat, above_one), (high, quarter) = peaked(1 + Fraction(1, 10**6)), peaked(Fraction(2))

    def ringing(height: Fraction) -> Ratio:
        """`1.25 high` at its peak, and about `1 + height` within a part in 10⁹ of one frequency."""
        return high.times(Ratio(row(1), row(1)) + bump.by(height))

    return [
        _weighted("W = 0.5/(s+1) + 5 resonance", lag + bump.by(Fraction(5)), False),
        _weighted("W = 0.5/(s+1) + 1.9 resonance", lag + bump.by(Fraction("1.9")), True),
        _weighted("W = (2 + 1e-12) resonance", bump.by(2 + tiny), False),
        _weighted("W = 2 resonance: touching where < is meant", bump.by(Fraction(2)), False),
        _weighted("W = (2 - 1e-12) resonance", bump.by(2 - tiny), True),
        _weighted("W = 2 at 0 only", at_zero.by(Fraction(2)), False),
        _weighted("W = 2 - 1e-12 at 0", at_zero.by(2 - tiny), True),
        _weighted("W = 2 at infinity only", at_infinity.by(Fraction(2)), False),
        _weighted("W = 2 - 1e-12 at infinity", at_infinity.by(2 - tiny), True),
        _peak("peak of 5 in a resonance", ringing(Fraction(4)), Fraction(2), False),
        _peak("peak of 1.9 in a resonance", ringing(Fraction("0.9")), Fraction(2), True),
        _peak("peak of 5/4 against 5/4: a double root", high, quarter, True),
        _peak("peak of 5/4 against 5/4 - 1e-12", high, quarter - tiny, False),
        _peak("peak of 5/4 against 5/4 - 1e-30", high, quarter - Fraction(1, 10**30), False),
        _peak("peak of 1 + 5e-13 against it: a double root", flat, above_one, True),
        _peak("peak of 1 + 5e-13 against 1 + 1e-15", flat, 1 + Fraction(1, 10**15), False),
        _peak("peak of 1 + 5e-13 against 1e-40 less", flat, above_one - Fraction(1, 10**40), False),
    ]
