"""Real affine forms on many cells at once: `z^order·(c₀ + Σ cᵢ tᵢ ± ρ)` for every |tᵢ| ≤ 1, z the cell's own variable.

t₀ is the frequency, the others are uncertain parameters. Every operation is exact to first order; what is left out, and
every rounding of a double, goes into ρ. What is not finite says nothing: nothing is proven with it, and callers compute
under `np.errstate(all="ignore")`.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import fmpq

from ....models.rational import to_float

if TYPE_CHECKING:
    from numpy.typing import NDArray

ROUNDING = 2.0**-49  # of one operation on forms, relative to the sizes that meet in it
SUMS = 1 + 1e-13  # what adding up to 50 sizes in doubles can lose
TINY = 1e-290  # what underflow can lose
Number = int | float | Fraction | fmpq


def nearest(value: Number) -> tuple[float, float]:
    """The nearest double and a bound on its distance."""
    if isinstance(value, int) and abs(value) < 2**53:
        return float(value), 0.0
    double = to_float(value) if isinstance(value, fmpq) else float(value)
    return double, abs(double) * 2.0**-52 + TINY


@dataclass(frozen=True, eq=False)
class Form:
    """A real quantity on n cells. c: (1+m, n), rho: (n,) ≥ 0, z: the form of the cell's variable (ends only)."""

    c: NDArray[np.float64]
    rho: NDArray[np.float64]
    order: int = 0
    z: Form | None = None

    __array_ufunc__ = None

    @cached_property
    def reach(self) -> NDArray[np.float64]:
        """`Σ |cᵢ|`, (n,)."""
        return np.asarray(np.add.reduce(np.abs(self.c[1:]), axis=0))

    @cached_property
    def size(self) -> NDArray[np.float64]:
        """`|c₀| + Σ |cᵢ|`, (n,)."""
        return np.asarray(np.abs(self.c[0]) + self.reach)

    @property
    def spread(self) -> NDArray[np.float64]:
        """`Σ |cᵢ| + ρ`: how far from c₀ the quantity can be, without z^order. (n,)."""
        return np.asarray((self.reach + self.rho) * SUMS)

    @property
    def lower(self) -> NDArray[np.float64]:
        """Lower bound of the form without z^order, which is positive. (n,)."""
        return np.asarray(self.c[0] - self.spread - ROUNDING * np.abs(self.c[0]))

    @property
    def upper(self) -> NDArray[np.float64]:
        """Upper bound of the form without z^order. (n,)."""
        return np.asarray(self.c[0] + self.spread + ROUNDING * np.abs(self.c[0]))

    def _like(self, c: NDArray[np.float64], rho: NDArray[np.float64], order: int | None = None) -> Form:
        return Form(c, rho * SUMS + TINY, self.order if order is None else order, self.z)

    def __getitem__(self, which: Any) -> Form:
        """On some of the cells."""
        return Form(self.c[:, which], self.rho[which], self.order, None if self.z is None else self.z[which])

    def constant(self, value: Number) -> Form:
        """A number on the same cells."""
        double, error = nearest(value)
        c = np.zeros_like(self.c)
        c[0] = double
        return Form(c, np.full_like(self.rho, error), 0, self.z)

    def shifted(self, order: int) -> Form:
        """The same quantity with a lower order: z^k is multiplied into the form."""
        if order == self.order:
            return self
        form = self
        for _ in range(self.order - order):
            assert self.z is not None
            form = form._like(*_product(form, self.z))
        return Form(form.c, form.rho, order, self.z)

    def __add__(self, other: Any) -> Form:
        if not isinstance(other, Form):
            return self._plus(other) if isinstance(other, Number) else NotImplemented
        order = min(self.order, other.order)
        a, b = self.shifted(order), other.shifted(order)
        rho = a.rho + b.rho
        return self._like(a.c + b.c, rho + ROUNDING * (a.size + b.size + rho), order)

    def _plus(self, number: Number) -> Form:
        if number == 0:
            return self
        if self.order < 0:
            return self + self.constant(number)
        form, (double, error) = self.shifted(0), nearest(number)
        c = form.c.copy()
        c[0] += double
        return form._like(c, form.rho + error + ROUNDING * (form.size + form.rho + abs(double)))

    def __mul__(self, other: Any) -> Form:
        if isinstance(other, Form):
            return self._like(*_product(self, other), self.order + other.order)
        if not isinstance(other, Number):
            return NotImplemented
        k, error = nearest(other)
        return self._like(k * self.c, abs(k) * self.rho + (error + ROUNDING * abs(k)) * (self.size + self.rho))

    def __neg__(self) -> Form:
        return Form(-self.c, self.rho, self.order, self.z)

    def __sub__(self, other: Any) -> Form:
        return self + -other  # type: ignore[no-any-return]

    def __rsub__(self, other: Any) -> Form:
        return -self + other  # type: ignore[no-any-return]

    def __truediv__(self, other: Any) -> Form:
        return self * other.inverse()  # type: ignore[no-any-return]

    def __pow__(self, n: int) -> Form:
        assert n == 2
        return self * self

    __radd__, __rmul__ = __add__, __mul__

    def inverse(self) -> Form:
        """`1/x` on [a, b]: between the chord `1/a + 1/b − x/(ab)` and the tangent `2/√(ab) − x/(ab)` parallel to it."""
        sign = np.sign(self.c[0])
        a, b = np.where(sign > 0, self.lower, -self.upper), np.where(sign > 0, self.upper, -self.lower)
        slope, chord, tangent = 1 / a / b, 1 / a + 1 / b, 2 / np.sqrt(a * b)
        c = -slope * self.c
        c[0] += sign * (chord + tangent) / 2
        rho = slope * self.rho + (chord - tangent) / 2 + ROUNDING * (chord + slope * b)
        return self._like(c, np.where(a > 0, rho, np.inf), -self.order)

    def sqrt(self) -> Form:
        """`√x` on [a, b]: above the chord with slope `1/(√a+√b)`, by at most `(√b−√a)²/(4(√a+√b))`; x is never < 0."""
        even = self if self.order % 2 == 0 else self.shifted(self.order - 1)
        a, b = np.sqrt(np.maximum(even.lower, 0.0)), np.sqrt(np.maximum(even.upper, 0.0))
        slope, bulge = 1 / np.maximum(a + b, TINY), (b - a) ** 2 / (4 * np.maximum(a + b, TINY)) / 2
        c = slope * even.c
        c[0] += a - slope * a**2 + bulge
        return even._like(c, slope * even.rho + bulge + ROUNDING * (a + b), even.order // 2)

    def where(self, which: NDArray[np.bool_], value: float) -> Form:
        """With another value, instead of the form's, on some of the cells."""
        c = np.where(which, 0.0, self.c)
        c[0] = np.where(which, value, self.c[0])
        return Form(c, np.where(which, 0.0, self.rho), self.order, self.z)

    def where_below_one(self, value: Form) -> Form:
        """A value that means something only where this form is certainly below 1."""
        bounded = self.shifted(min(self.order, 0))
        sure = (bounded.upper < 1) & (bounded.order == 0)
        return Form(value.c, np.where(sure, value.rho, np.inf), value.order, value.z)


def _product(a: Form, b: Form) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Coefficients and ρ of a product; tᵢ² lies in [0, 1], which halves its share."""
    a0, b0 = a.c[0], b.c[0]
    c = a0 * b.c
    c += b0 * a.c
    squares = a.c[1:] * b.c[1:]
    c[0] = a0 * b0 + np.add.reduce(squares, axis=0) / 2
    rho = a.reach * b.reach - np.add.reduce(np.abs(squares), axis=0) / 2
    rho += a.size * b.rho + (b.size + b.rho) * a.rho
    return c, rho + ROUNDING * a.size * b.size
