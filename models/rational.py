"""Exact rational functions of s, the number type of the models; `control` objects at the edges."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from numbers import Rational
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import fmpq, fmpq_poly

if TYPE_CHECKING:
    import control
    from numpy.typing import NDArray

Scalar = int | float | str | Rational | fmpq


def exact(value: Scalar) -> fmpq:
    """The rational number a scalar stands for: text is decimal or p/q, a float is the double it is.

    Raises: ValueError if the text is not a number or the float is not finite.
    """
    if isinstance(value, fmpq):
        return value
    number = Fraction(value)
    return fmpq(number.numerator, number.denominator)


def fraction(value: fmpq) -> Fraction:
    """The same number as a standard-library fraction."""
    return Fraction(int(value.p), int(value.q))


def to_float(value: fmpq) -> float:
    """The nearest double; numerator and denominator may be far beyond double range, ±inf if the quotient is."""
    try:
        return int(value.p) / int(value.q)
    except OverflowError:
        return math.inf if value > 0 else -math.inf


def polynomial(descending: Iterable[Scalar]) -> fmpq_poly:
    """Polynomial of s from coefficients in descending powers, the order engineers write them in."""
    return fmpq_poly([exact(c) for c in descending][::-1])


def descending(poly: fmpq_poly) -> tuple[Fraction, ...]:
    """Coefficients in descending powers; (0,) for the zero polynomial."""
    return tuple(fraction(c) for c in poly.coeffs()[::-1]) or (Fraction(0),)


def evaluate(poly: fmpq_poly, s: Any) -> Any:
    """Value at s by Horner's rule; s is a NumPy array or any object that adds and multiplies with floats."""
    value = 0.0 * s
    for c in poly.coeffs()[::-1]:
        value = value * s + to_float(c)
    return value


@dataclass(frozen=True)
class RationalFunction:
    """`num(s)/den(s)` with exact rational coefficients, in lowest terms."""

    num: fmpq_poly
    den: fmpq_poly

    def __post_init__(self) -> None:
        if self.den.degree() < 0:
            raise ZeroDivisionError("rational function with a zero denominator")
        common = self.num.gcd(self.den)
        if common.degree() > 0:
            object.__setattr__(self, "num", self.num // common)
            object.__setattr__(self, "den", self.den // common)

    @classmethod
    def of(cls, numerator: Sequence[Scalar], denominator: Sequence[Scalar] = (1,)) -> RationalFunction:
        """From coefficients in descending powers of s."""
        return cls(polynomial(numerator), polynomial(denominator))

    @classmethod
    def lift(cls, value: Any) -> Any:
        """A scalar or polynomial as a rational function; what has an arithmetic of its own stays what it is."""
        if isinstance(value, RationalFunction) or not isinstance(value, OPERAND):
            return value
        return cls(value if isinstance(value, fmpq_poly) else fmpq_poly([exact(value)]), fmpq_poly([1]))  # type: ignore[arg-type]

    @classmethod
    def from_control(cls, system: control.TransferFunction) -> RationalFunction:
        """From a SISO continuous `control.TransferFunction`; its doubles are taken as the exact numbers they are."""
        if not system.issiso() or system.isdtime(strict=True):
            raise ValueError("expected a single-input single-output continuous-time transfer function")
        return cls.of([float(c) for c in system.num[0][0]], [float(c) for c in system.den[0][0]])

    def to_control(self) -> control.TransferFunction:
        """The nearest `control.TransferFunction`."""
        import control

        return control.tf([float(c) for c in descending(self.num)], [float(c) for c in descending(self.den)])

    def __call__(self, s: Any) -> Any:
        """Value at s (array of complex numbers, or a symbolic complex number)."""
        return evaluate(self.num, s) / evaluate(self.den, s)

    def at(self, omega: NDArray[np.float64]) -> NDArray[np.complex128]:
        """Frequency response. omega: (n,) [rad/s]. Returns (n,) complex."""
        response: NDArray[np.complex128] = self(1j * np.asarray(omega, dtype=float))
        return response

    def __add__(self, other: Operand) -> RationalFunction:
        if not isinstance(other, OPERAND):
            return NotImplemented
        o = self.lift(other)
        return RationalFunction(self.num * o.den + o.num * self.den, self.den * o.den)

    def __mul__(self, other: Operand) -> RationalFunction:
        if not isinstance(other, OPERAND):
            return NotImplemented
        o = self.lift(other)
        return RationalFunction(self.num * o.num, self.den * o.den)

    def __truediv__(self, other: Operand) -> RationalFunction:
        if not isinstance(other, OPERAND):
            return NotImplemented
        o = self.lift(other)
        return RationalFunction(self.num * o.den, self.den * o.num)

    def __neg__(self) -> RationalFunction:
        return RationalFunction(-self.num, self.den)

    def __sub__(self, other: Operand) -> RationalFunction:
        if not isinstance(other, OPERAND):
            return NotImplemented
        return self + (-self.lift(other))  # type: ignore[no-any-return]

    def __radd__(self, other: Operand) -> RationalFunction:
        return self + other

    def __rsub__(self, other: Operand) -> RationalFunction:
        return self.lift(other) - self  # type: ignore[no-any-return]

    def __rmul__(self, other: Operand) -> RationalFunction:
        return self * other

    def __rtruediv__(self, other: Operand) -> RationalFunction:
        return self.lift(other) / self  # type: ignore[no-any-return]

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, RationalFunction):
            return NotImplemented
        return bool(self.num * other.den == other.num * self.den)

    def __hash__(self) -> int:
        lead = self.den[self.den.degree()]
        return hash((tuple(map(str, (self.num / lead).coeffs())), tuple(map(str, (self.den / lead).coeffs()))))

    @property
    def relative_degree(self) -> int:
        """Degree of the denominator minus degree of the numerator."""
        return int(self.den.degree() - self.num.degree())


def at_zero(r: RationalFunction) -> fmpq | None:
    """`r(0)`; None for a pole there."""
    return None if r.den[0] == 0 else r.num[0] / r.den[0]


def at_infinity(r: RationalFunction) -> fmpq | None:
    """`r(∞)`; None for a pole there."""
    if r.relative_degree > 0 or r.num.degree() < 0:
        return fmpq(0)
    return None if r.relative_degree < 0 else r.num.leading_coefficient() / r.den.leading_coefficient()


Operand = RationalFunction | fmpq_poly | Scalar
OPERAND = (RationalFunction, fmpq_poly, fmpq, Rational, int, float, str)  # anything else brings its own arithmetic


def ratio(num: Any, den: Any) -> Any:
    """`num/den`: of polynomials a rational function, of values of polynomials their quotient."""
    return RationalFunction(num, den) if isinstance(num, fmpq_poly) else num / den


def value(poly: fmpq_poly, s: Any) -> Any:
    """A polynomial at s: itself where s is the polynomial s, by the arithmetic of s where s is a value of its own."""
    return poly if isinstance(s, fmpq_poly) else s.polynomial(poly)


ONE = RationalFunction(fmpq_poly([1]), fmpq_poly([1]))
ZERO = RationalFunction(fmpq_poly([0]), fmpq_poly([1]))
S = RationalFunction(fmpq_poly([0, 1]), fmpq_poly([1]))
