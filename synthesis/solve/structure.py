"""Controller structures: which numbers are searched, where the search starts, and what polynomials they stand for.

Everything is in the normalised variable p = s/ω₀. A structure is one class: adding one is the class, its test, and its
line in `FORMS` of classical.py.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from ..spec.model import Polynomials
from .corner import Corner

if TYPE_CHECKING:
    from numpy.typing import NDArray

DIGITS = 6  # significant digits that coefficients are rounded to before anything is certified
LEAST_DAMPING, MOST_DAMPING = 0.02, 5.0  # of pairs of poles; more damping is a pole far beyond the actuator
FAR, ZEROS = float(np.log(100.0)), 100.0  # poles within a factor 100 of ω₀; bounds on the coefficients of zeros
FARTHEST, MOST_APART = float(np.log(1e4)), 10.0  # where they may be `far`: the same, and the damping of pairs
LEAST_WIDER = 8  # order from which on far poles are looked for: it takes as long as the search before it

Coefficients = list[Any]  # descending powers; floats or symbolic expressions
Filter = tuple[Coefficients, Coefficients] | None


class Structure(ABC):
    """A family of controllers `num(p)/den(p)` (of Q or of C_imp) with a box of parameters x."""

    @property
    def simpler(self) -> tuple[Structure, ...]:
        """Smaller families whose optima `extended` turns into starts for this one, so that it ends no lower."""
        return ()

    def extended(self, x: NDArray[np.float64], rng: np.random.Generator, of: Structure) -> NDArray[np.float64]:
        """The same controller as a member of this family, from parameters x of a simpler one."""
        raise NotImplementedError

    def includes(self, other: Structure) -> bool:
        """Whether controllers of a simpler family are of this one as they are written, or only in the limit."""
        return True

    @property
    def wider(self) -> Structure | None:
        """The same family with poles allowed farther out; None where that is not worth a search."""
        return None

    @property
    @abstractmethod
    def bounds(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Lower and upper bounds of x. Each: (n,)."""

    @abstractmethod
    def start(self, rng: np.random.Generator) -> NDArray[np.float64]:
        """A random start. Returns (n,)."""

    @abstractmethod
    def polynomials(self, x: Any, exp: Any = np.exp) -> tuple[Coefficients, Coefficients]:
        """Numerator and denominator in descending powers of p. x: (n,) numbers or symbols."""

    def sensor_filter(self, x: Any, exp: Any = np.exp) -> Filter:
        """Numerator and denominator of F in descending powers of p, where its corner is searched, too."""
        return None

    def corner(self, x: NDArray[np.float64], omega_0: float) -> Corner | None:
        """The sensor filter's corner, if it is searched."""
        return None

    def rounded(self, x: NDArray[np.float64], omega_0: float) -> Polynomials:
        """The controller as it will be shipped: coefficients of s with few digits, exactly what is then certified."""
        num, den = self.polynomials(x)
        top = len(den) - 1
        return Polynomials(numerator=_in_s(num, top, omega_0), denominator=_in_s(den, top, omega_0))


def _in_s(coefficients: Coefficients, top: int, omega_0: float) -> tuple[Fraction, ...]:
    """Coefficients of `ω₀^top · poly(s/ω₀)`, rounded."""
    powers = range(len(coefficients) - 1, -1, -1)
    return tuple(few_digits(float(c) * omega_0 ** (top - k)) for c, k in zip(coefficients, powers, strict=True))


def few_digits(value: float) -> Fraction:
    """A number as it is shipped."""
    return Fraction(f"{value:.{DIGITS - 1}e}")


@dataclass(frozen=True)
class Sections(Structure):
    """Poles and zeros as first- and second-order sections and the gain at s = 0, which keeps every order well scaled.

    x: log ω of each pair of poles, their ζ, log of the real pole if the order is odd, the gain, then for each pair of
    zeros `b₂p² + b₁p + 1` its b₁ and b₂, and for a single zero `b₁p + 1` its b₁.
    """

    order: int
    far: bool = field(default=False, repr=False)

    least_order: ClassVar[int]
    relative_degree: ClassVar[int]
    gains: ClassVar[tuple[float, float]]  # bounds of the parameter that stands for the gain

    @abstractmethod
    def gain(self, parameter: Any, exp: Any) -> Any:
        """Value at s = 0."""

    @abstractmethod
    def first_gain(self, rng: np.random.Generator) -> float:
        """The gain's parameter at a random start."""

    @property
    def simpler(self) -> tuple[Structure, ...]:
        """One section less, or without the real pole."""
        step = 1 if self.order % 2 else 2
        return (type(self)(self.order - step),) if self.order - step >= self.least_order else ()

    def extended(self, x: NDArray[np.float64], rng: np.random.Generator, of: Structure) -> NDArray[np.float64]:
        """Multiply by a random section (or real pole) over itself: the same controller, free to move from there."""
        log_omega, zeta = rng.uniform(-1, 2.5), rng.uniform(LEAST_DAMPING, 1.0)
        n = self.order // 2
        if self.order % 2:
            return np.array([*x[: 2 * n], log_omega, *x[2 * n :], np.exp(-log_omega)])
        if isinstance(of, Sections) and of.order == self.order - 1:
            return self._paired(x, log_omega)
        pair = 2 * zeta * np.exp(-log_omega), np.exp(-2 * log_omega)
        return np.array([*x[: n - 1], log_omega, *x[n - 1 : 2 * n - 2], zeta, *x[2 * n - 2 :], *pair])

    def _paired(self, x: NDArray[np.float64], log_pole: float) -> NDArray[np.float64]:
        """From one order less: a second real pole over itself, paired with the one there is, and so their zeros."""
        n = self.order // 2
        own, single = x[2 * n - 2], x[-1]
        log_pole = float(np.clip(log_pole, own - 4, own + 4))
        middle, zeta = (own + log_pole) / 2, np.cosh((own - log_pole) / 2)
        zeros = single + np.exp(-log_pole), single * np.exp(-log_pole)
        return np.array([*x[: n - 1], middle, *x[n - 1 : 2 * n - 2], zeta, *x[2 * n - 1 : -1], *zeros])

    @property
    def bounds(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """See `Structure`."""
        n, odd, zeros = self.order // 2, self.order % 2, self.order - self.relative_degree
        far = FARTHEST if self.far else FAR
        most = [1.0] + [MOST_APART] * (n - 1) if self.far else [MOST_DAMPING] * n  # the first pair is the roll-off
        low = [-FAR] * n + [LEAST_DAMPING] * n + [-FAR] * odd + [self.gains[0]] + [-ZEROS] * zeros
        high = [far] * n + most + [far] * odd + [self.gains[1]] + [ZEROS] * zeros
        return np.array(low), np.array(high)

    def start(self, rng: np.random.Generator) -> NDArray[np.float64]:
        """Poles and zeros around and above ω₀; if far, one pair is far out, and one is a slow and a fast pole."""
        n, odd, zeros = self.order // 2, self.order % 2, self.order - self.relative_degree
        poles = np.concatenate([rng.uniform(-1, 2, n), rng.uniform(0.2, 1.0, n), rng.uniform(-1, 2, odd)])
        if self.far:
            poles[0], poles[1] = rng.uniform(FARTHEST - 1, FARTHEST), rng.uniform(1.8, 2.6)
            poles[n + 1] = rng.uniform(3, 8)
        inverse, damping = np.exp(rng.uniform(-2, 0.5, (zeros + 1) // 2)), rng.uniform(0.2, 1.0, (zeros + 1) // 2)
        pairs = np.stack([2 * damping * inverse, inverse**2], axis=1).ravel()[:zeros]
        return np.concatenate([poles, [self.first_gain(rng)], pairs])

    def polynomials(self, x: Any, exp: Any = np.exp) -> tuple[Coefficients, Coefficients]:
        """See `Structure`."""
        n, odd, zeros = self.order // 2, self.order % 2, self.order - self.relative_degree
        den: Coefficients = [1.0]
        for i in range(n):
            omega = exp(x[i])
            den = convolve(den, [1.0, 2 * x[n + i] * omega, omega * omega])
        if odd:
            den = convolve(den, [1.0, exp(x[2 * n])])
        at = 2 * n + odd
        num = [self.gain(x[at], exp) * den[-1]]
        for i in range(at + 1, at + zeros, 2):
            num = convolve(num, [x[i + 1], x[i], 1.0])
        return (convolve(num, [x[at + zeros], 1.0]) if zeros % 2 else num), den


class QFilter(Sections):
    """Q of order ≥ 2 and relative degree 2. Order 2 is the paper's (23), `α ω²/(s² + 2ζω s + ω²)`."""

    least_order = 2
    relative_degree = 2
    gains = (0.0, 2.0)

    @property
    def wider(self) -> QFilter | None:
        """From some order on, so that zeros can be free and the roll-off begins beyond everything else."""
        return replace(self, far=True) if self.order >= LEAST_WIDER and not self.far else None

    def gain(self, parameter: Any, exp: Any) -> Any:
        """`Q(0)`, which may be 1."""
        return parameter

    def first_gain(self, rng: np.random.Generator) -> float:
        """Below 1."""
        return rng.uniform(0.2, 0.9)


class Feedback(Sections):
    """`C_imp` of (20), proper, of any order; order 0 is a gain."""

    least_order = 0
    relative_degree = 0
    gains = (-np.log(1e4), np.log(1e6))

    @property
    def simpler(self) -> tuple[Structure, ...]:
        """One section less, or without the real pole; of even order also one order less, lest it end below that."""
        below = super().simpler
        return (*below, Feedback(self.order - 1)) if below and self.order % 2 == 0 else below

    def gain(self, parameter: Any, exp: Any) -> Any:
        """`C(0) > 0`."""
        return exp(parameter)

    def first_gain(self, rng: np.random.Generator) -> float:
        """Of order one."""
        return float(np.log(rng.uniform(0.1, 3.0)))


def contained(structure: Structure) -> list[Structure]:
    """All simpler families and theirs, each after those it contains, and the structure itself as the last."""
    found: list[Structure] = []
    for simpler in structure.simpler:
        found += [s for s in contained(simpler) if s not in found]
    return [*found, structure]


def convolve(p: Coefficients, q: Coefficients) -> Coefficients:
    """Product of two polynomials, numbers or symbols."""
    product: Coefficients = [0.0] * (len(p) + len(q) - 1)
    for i, a in enumerate(p):
        for j, b in enumerate(q):
            product[i + j] = product[i + j] + a * b
    return product


def add(p: Coefficients, q: Coefficients) -> Coefficients:
    """Sum of two polynomials, numbers or symbols."""
    n = max(len(p), len(q))
    p, q = ([0.0] * (n - len(r)) + list(r) for r in (p, q))
    return [a + b for a, b in zip(p, q, strict=True)]
