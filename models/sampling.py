"""Zero-order hold and computation delay of a sampled controller, inside H and exact: `e^{−sT_d}(1−e^{−sT})/(sT)`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import fmpq

from .rational import OPERAND, Operand, RationalFunction, to_float

if TYPE_CHECKING:
    from numpy.typing import NDArray


@dataclass(frozen=True)
class Hold:
    """`e^{−sT_d}(1−e^{−sT})/(sT)`. period T [s] > 0, delay T_d [s] ≥ 0."""

    period: fmpq
    delay: fmpq

    def __call__(self, s: Any) -> Any:
        """Value at s ≠ 0: an array, or an object with `exp` and arithmetic of its own."""
        exp = np.exp if isinstance(s, np.ndarray) else type(s).exp
        T, T_d = to_float(self.period), to_float(self.delay)
        return exp(s * -T_d) * ((exp(s * -T) * -1.0 + 1.0) / (s * T))


@dataclass(frozen=True)
class Held:
    """`rational + held·hold`: what a loop with a hold is made of; closed under sums and rational factors."""

    rational: RationalFunction
    held: RationalFunction
    hold: Hold

    @property
    def at_rest(self) -> RationalFunction:
        """What it tends to where s → 0: the hold becomes 1."""
        return self.rational + self.held

    def __call__(self, s: Any) -> Any:
        """Value at s (array of complex numbers, or a symbolic complex number)."""
        return self.rational(s) + self.held(s) * self.hold(s)

    def at(self, omega: NDArray[np.float64]) -> NDArray[np.complex128]:
        """Frequency response. omega: (n,) [rad/s] > 0. Returns (n,) complex."""
        response: NDArray[np.complex128] = self(1j * np.asarray(omega, dtype=float))
        return response

    def __add__(self, other: Held | Operand) -> Held:
        if isinstance(other, Held):
            return Held(self.rational + other.rational, self.held + other.held, self.hold)
        if not isinstance(other, OPERAND):
            return NotImplemented
        return Held(self.rational + other, self.held, self.hold)

    def __mul__(self, factor: Operand) -> Held:
        if not isinstance(factor, OPERAND):
            return NotImplemented
        return Held(self.rational * factor, self.held * factor, self.hold)

    def __truediv__(self, factor: Operand) -> Held:
        if not isinstance(factor, OPERAND):
            return NotImplemented
        return Held(self.rational / factor, self.held / factor, self.hold)

    def __neg__(self) -> Held:
        return self * -1

    def __sub__(self, other: Held | Operand) -> Held:
        return self + (other * -1 if isinstance(other, Held) else -RationalFunction.lift(other))

    def __rsub__(self, other: Operand) -> Held:
        return -self + other

    __radd__ = __add__
    __rmul__ = __mul__


@dataclass(frozen=True)
class Closed:
    """`forward/(1+L)` of a loop gain with a hold (forward: L itself): not rational, but with a frequency response."""

    L: Held
    forward: RationalFunction | None = None

    def at(self, omega: NDArray[np.float64]) -> NDArray[np.complex128]:
        """Frequency response. omega: (n,) [rad/s] > 0. Returns (n,) complex."""
        L = self.L.at(omega)
        return np.asarray((L if self.forward is None else self.forward.at(omega)) / (1 + L))
