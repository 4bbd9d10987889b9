"""Controller structures: which numbers are searched, where the search starts, and what polynomials they stand for.

Everything is in the normalised variable p = s/ω₀. A structure is one class: adding one is the class, its test, and its
line in `structure_of`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import numpy as np

from ..spec.model import Polynomials, Spec

if TYPE_CHECKING:
    from numpy.typing import NDArray

DIGITS = 6  # significant digits that coefficients are rounded to before anything is certified
LEAST_DAMPING, MOST_DAMPING = 0.05, 5.0  # of the sections of Q; more damping is a pole far beyond the actuator

Coefficients = list[Any]  # descending powers; floats or symbolic expressions


class Structure(ABC):
    """A family of controllers `num(p)/den(p)` (of Q or of C_imp) with a box of parameters x."""

    @property
    def simpler(self) -> Structure | None:
        """A smaller family whose optimum `extended` turns into a start for this one."""
        return None

    def extended(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        """The same controller as a member of this family, from parameters x of the simpler one."""
        raise NotImplementedError

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

    @abstractmethod
    def parameters(self, coefficients: Polynomials, omega_0: float) -> NDArray[np.float64] | None:
        """The inverse of `rounded`: x of a given controller, moved into the bounds; None for one of another order."""

    def rounded(self, x: NDArray[np.float64], omega_0: float) -> Polynomials:
        """The controller as it will be shipped: coefficients of s with few digits, exactly what is then certified."""
        num, den = self.polynomials(x)
        top = len(den) - 1
        return Polynomials(numerator=_in_s(num, top, omega_0), denominator=_in_s(den, top, omega_0))


def _in_s(coefficients: Coefficients, top: int, omega_0: float) -> tuple[Fraction, ...]:
    """Coefficients of `ω₀^top · poly(s/ω₀)`, rounded."""
    powers = range(len(coefficients) - 1, -1, -1)
    return tuple(
        Fraction(f"{float(c) * omega_0 ** (top - k):.{DIGITS - 1}e}") for c, k in zip(coefficients, powers, strict=True)
    )


def _in_p(coefficients: tuple[Fraction, ...], top: int, omega_0: float, lead: Fraction) -> list[float]:
    """The inverse of `_in_s`, divided by the denominator's leading coefficient."""
    powers = range(len(coefficients) - 1, -1, -1)
    return [float(c / lead) / omega_0 ** (top - k) for c, k in zip(coefficients, powers, strict=True)]


@dataclass(frozen=True)
class QFilter(Structure):
    """Q of any order ≥ 2 and relative degree 2: second-order sections (log ω, ζ), a real pole if odd, free zeros.

    Order 2 is the paper's (23), `α ω²/(s² + 2ζω s + ω²)`.
    """

    order: int

    @property
    def simpler(self) -> QFilter | None:
        """One section less, or without the real pole."""
        step = 1 if self.order % 2 else 2
        return QFilter(self.order - step) if self.order > 2 else None

    def extended(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        """Multiply Q by a random section (or real pole) over itself: the same Q, free to move from there."""
        omega, zeta = rng.uniform(-1, 2), rng.uniform(0.2, 1.0)
        if self.order % 2:
            n = self._sections
            zeros = convolve(list(x[2 * n :]), [1.0, np.exp(omega)])
            return np.array([*x[: 2 * n], omega, *zeros])
        n = self._sections - 1
        zeros = convolve(list(x[2 * n :]), [1.0, 2 * zeta * np.exp(omega), np.exp(2 * omega)])
        return np.array([*x[:n], omega, *x[n : 2 * n], zeta, *zeros])

    def parameters(self, coefficients: Polynomials, omega_0: float) -> NDArray[np.float64] | None:
        """See `Structure`."""
        num, den = (_in_p(c, self.order, omega_0, coefficients.denominator[0]) for c in (
            coefficients.numerator, coefficients.denominator))  # fmt: skip
        if len(den) != self.order + 1 or len(num) > self.order - 1:
            return None
        roots = np.roots(den)
        upper, real = roots[roots.imag > 0], np.sort(roots[roots.imag == 0].real)
        odd, paired = real[len(real) - self.order % 2 :], real[: len(real) - self.order % 2]
        omega = np.concatenate([np.abs(upper), np.sqrt(paired[::2] * paired[1::2])])
        zeta = np.concatenate([-upper.real, -(paired[::2] + paired[1::2]) / 2]) / omega
        zeros = [0.0] * (self.order - 1 - len(num)) + num
        if np.any(omega <= 0) or np.any(odd >= 0):
            return None
        return np.asarray(np.clip([*np.log(omega), *zeta, *np.log(-odd), *zeros], *self.bounds))

    @property
    def _sections(self) -> int:
        return self.order // 2

    @property
    def bounds(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """See `Structure`."""
        n, odd, zeros = self._sections, self.order % 2, self.order - 1
        far, free = np.log(100.0), 10.0 ** max(4, self.order)  # holds every start
        low = [-far] * n + [LEAST_DAMPING] * n + [-far] * odd + [-free] * zeros
        high = [far] * n + [MOST_DAMPING] * n + [far] * odd + [free] * zeros
        return np.array(low), np.array(high)

    def start(self, rng: np.random.Generator) -> NDArray[np.float64]:
        """Poles around ω₀, zeros such that Q starts as a multiple below 1 of an all-pole low-pass."""
        n, odd = self._sections, self.order % 2
        poles = np.concatenate([rng.uniform(-1, 2, n), rng.uniform(0.2, 1.0, n), rng.uniform(-1, 2, odd)])
        _, den = self.polynomials(np.concatenate([poles, np.zeros(self.order - 1)]))
        return np.concatenate([poles, np.array(den[2:], dtype=float) * rng.uniform(0.2, 0.9)])

    def polynomials(self, x: Any, exp: Any = np.exp) -> tuple[Coefficients, Coefficients]:
        """See `Structure`."""
        n, odd = self._sections, self.order % 2
        den: Coefficients = [1.0]
        for i in range(n):
            omega = exp(x[i])
            den = convolve(den, [1.0, 2 * x[n + i] * omega, omega * omega])
        if odd:
            den = convolve(den, [1.0, exp(x[2 * n])])
        return [x[2 * n + odd + k] for k in range(self.order - 1)], den


@dataclass(frozen=True)
class Feedback(Structure):
    """`C_imp` of (20): a gain (order 0) or `(b₁ s + b₀)/(s + a)` (order 1)."""

    order: int

    @property
    def bounds(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """See `Structure`."""
        if self.order == 0:
            return np.array([0.0]), np.array([1e4])
        return np.array([-np.log(1e3), -1e4, 0.0]), np.array([np.log(1e3), 1e4, 1e6])

    def start(self, rng: np.random.Generator) -> NDArray[np.float64]:
        """A gain of order one; with a pole around ω₀."""
        gain = rng.uniform(0.1, 3.0)
        if self.order == 0:
            return np.array([gain])
        pole = rng.uniform(-2, 2)
        return np.array([pole, 0.1 * gain, gain * np.exp(pole)])

    def parameters(self, coefficients: Polynomials, omega_0: float) -> NDArray[np.float64] | None:
        """See `Structure`."""
        num, den = (_in_p(c, self.order, omega_0, coefficients.denominator[0]) for c in (
            coefficients.numerator, coefficients.denominator))  # fmt: skip
        if len(den) != self.order + 1:
            return None
        if self.order == 0:
            return np.clip(num, *self.bounds)
        return None if den[1] <= 0 else np.clip([np.log(den[1]), *[0.0] * (2 - len(num)), *num], *self.bounds)

    def polynomials(self, x: Any, exp: Any = np.exp) -> tuple[Coefficients, Coefficients]:
        """See `Structure`."""
        if self.order == 0:
            return [x[0]], [1.0]
        return [x[1], x[2]], [1.0, exp(x[0])]


def structure_of(spec: Spec) -> Structure:
    """The structure a specification asks for; it has `order` or `form`."""
    controller = spec.controller
    if controller.type == "dynamic-feedback":
        return Feedback(controller.order or 0)
    return QFilter(2 if controller.form == "eq23" else controller.order or 2)


def convolve(p: Coefficients, q: Coefficients) -> Coefficients:
    """Product of two polynomials, numbers or symbols."""
    product: Coefficients = [0.0] * (len(p) + len(q) - 1)
    for i, a in enumerate(p):
        for j, b in enumerate(q):
            product[i + j] = product[i + j] + a * b
    return product
