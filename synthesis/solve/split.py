"""Complex numbers as pairs of real expressions, so that CasADi and cvxpy evaluate the constraints as NumPy does."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np


class Arithmetic(Protocol):
    """What differs between expression libraries."""

    def multiply(self, a: Any, b: Any) -> Any:
        """Elementwise product of a real array and an expression, or of two expressions."""

    def modulus(self, re: Any, im: Any) -> Any:
        """Elementwise `√(re² + im²)`."""

    def exponential(self, re: Any, im: Any) -> tuple[Any, Any]:
        """Elementwise real and imaginary part of `e^{re + j·im}`."""


@dataclass(frozen=True, eq=False)
class Split:
    """`re + j·im` of expressions; mixes with complex NumPy arrays and floats."""

    re: Any
    im: Any
    arithmetic: Arithmetic

    __array_ufunc__ = None  # a NumPy array on the left defers to the methods here

    @property
    def real(self) -> Any:
        """Real part."""
        return self.re

    def _lift(self, other: Any) -> tuple[Any, Any]:
        if isinstance(other, Split):
            return other.re, other.im
        if isinstance(other, np.ndarray | complex | float | int):
            return np.real(other), np.imag(other)
        return other, 0.0  # a real expression

    def __add__(self, other: Any) -> Split:
        re, im = self._lift(other)
        return Split(self.re + re, self.im + im, self.arithmetic)

    __radd__ = __add__

    def __neg__(self) -> Split:
        return Split(-self.re, -self.im, self.arithmetic)

    def __sub__(self, other: Any) -> Split:
        re, im = self._lift(other)
        return Split(self.re - re, self.im - im, self.arithmetic)

    def __rsub__(self, other: Any) -> Split:
        return (-self).__add__(other)

    def __mul__(self, other: Any) -> Split:
        times = self.arithmetic.multiply
        re, im = self._lift(other)
        if isinstance(im, float | int) and im == 0:
            return Split(times(re, self.re), times(re, self.im), self.arithmetic)
        return Split(times(re, self.re) - times(im, self.im), times(re, self.im) + times(im, self.re), self.arithmetic)

    __rmul__ = __mul__

    def __truediv__(self, other: Split) -> Split:
        times = self.arithmetic.multiply
        scale = times(other.re, other.re) + times(other.im, other.im)
        numerator = self * Split(other.re, -other.im, self.arithmetic)
        return Split(numerator.re / scale, numerator.im / scale, self.arithmetic)

    def exp(self) -> Split:
        """`e^{re + j·im}`."""
        return Split(*self.arithmetic.exponential(self.re, self.im), self.arithmetic)

    def __abs__(self) -> Any:
        return self.arithmetic.modulus(self.re, self.im)
