"""Complex quantities `p + jω·q` with real forms p, q: `Re(Z/jω) = q(Z)` loses nothing at ω → 0, as `q/ω` would."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from flint import fmpq_poly

from ....models.rational import RationalFunction
from .form import Form, Number

Real = Form | int  # the int is 0: exactly zero, whatever the order


@dataclass(frozen=True, eq=False)
class Wave:
    """`p + jω·q` on cells; x: the form of ω²."""

    p: Real
    q: Real
    x: Form

    __array_ufunc__ = None

    def real_number(self, value: Any) -> Wave | None:
        """A number, a form, a rational function or a polynomial as a wave on the same cells."""
        if isinstance(value, Wave):
            return value
        if isinstance(value, RationalFunction):
            num, den = self.polynomial(value.num), self.polynomial(value.den)
            return num if value.den.degree() == 0 and value.den[0] == 1 else num / den
        if isinstance(value, fmpq_poly):
            return self.polynomial(value)
        if isinstance(value, Form):
            return Wave(value, 0, self.x)
        return Wave(self._real(value), 0, self.x) if isinstance(value, Number) else None

    def polynomial(self, poly: fmpq_poly | Sequence[Any]) -> Wave:
        """A polynomial of s: even and odd part by Horner in x. Coefficients ascending, numbers or forms."""
        ascending = poly.coeffs() if isinstance(poly, fmpq_poly) else list(poly)
        parts: list[Real] = []
        for start in (0, 1):
            value: Any = 0
            for k in reversed(range(start, len(ascending), 2)):
                c = ascending[k] if (k // 2) % 2 == 0 else -ascending[k]
                value = c if isinstance(value, Number) and value == 0 else value * self.x + c
            parts.append(value if isinstance(value, Form) else self._real(value))
        return Wave(parts[0], parts[1], self.x)

    def _real(self, number: Any) -> Real:
        return self.x.constant(number) if number != 0 else 0

    def __add__(self, other: Any) -> Wave:
        number = _number(other)
        if number is not None:
            return Wave(self.p + number if isinstance(self.p, Form) else self._real(number), self.q, self.x)
        o = self.real_number(other)
        return NotImplemented if o is None else Wave(self.p + o.p, self.q + o.q, self.x)

    def __mul__(self, other: Any) -> Wave:
        number = _number(other)
        if number is not None:
            return self if number == 1 else Wave(_scaled(self.p, number), _scaled(self.q, number), self.x)
        o = self.real_number(other)
        if o is None:
            return NotImplemented
        return Wave(_minus(_times(self.p, o.p), _times(_times(self.q, o.q), self.x)), _cross(self, o), self.x)

    def __neg__(self) -> Wave:
        return Wave(-self.p, -self.q, self.x)

    def __sub__(self, other: Any) -> Wave:
        o = self.real_number(other)
        return NotImplemented if o is None else self + -o

    def __rsub__(self, other: Any) -> Wave:
        return -self + other  # type: ignore[no-any-return]

    def __truediv__(self, other: Any) -> Wave:
        o = self.real_number(other)
        return NotImplemented if o is None else self * o.inverse()

    def __rtruediv__(self, other: Any) -> Wave:
        return self.inverse() * other  # type: ignore[no-any-return]

    __radd__, __rmul__ = __add__, __mul__

    def inverse(self) -> Wave:
        """`conj/|·|²`; of a real or imaginary quantity directly."""
        if isinstance(self.q, int) and isinstance(self.p, Form):
            return Wave(self.p.inverse(), 0, self.x)
        if isinstance(self.p, int) and isinstance(self.q, Form):
            return Wave(0, -(self.q * self.x).inverse(), self.x)
        scale = self.square().inverse()
        return Wave(_times(self.p, scale), -_times(self.q, scale), self.x)

    def square(self) -> Form:
        """`|p + jωq|² = p² + x q²`."""
        total = _times(self.p, self.p) + _times(_times(self.q, self.q), self.x)
        return total if isinstance(total, Form) else self.x.constant(0)

    def __abs__(self) -> Form:
        if isinstance(self.q, int) and isinstance(self.p, Form) and self.p.c.shape[1] and (self.p.lower >= 0).all():
            return self.p
        return self.square().sqrt()

    @property
    def real(self) -> Form:
        """Real part."""
        return self.p if isinstance(self.p, Form) else self.x.constant(0)


def _number(value: Any) -> Number | None:
    """The number that a value is, also as a polynomial or a rational function."""
    if isinstance(value, Number):
        return value
    if isinstance(value, RationalFunction) and value.den.degree() == 0:
        return None if value.num.degree() > 0 else value.num[0] / value.den[0]
    return value[0] if isinstance(value, fmpq_poly) and value.degree() <= 0 else None


def _scaled(a: Real, number: Number) -> Real:
    return a * number if isinstance(a, Form) and number != 0 else 0


def _times(a: Real, b: Real) -> Real:
    return a * b if isinstance(a, Form) and isinstance(b, Form) else 0


def _minus(a: Real, b: Real) -> Real:
    return a - b if isinstance(b, Form) else a


def _cross(a: Wave, b: Wave) -> Real:
    return _times(a.p, b.q) + _times(a.q, b.p)
