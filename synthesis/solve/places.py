"""The grid of the nonlinear program, and the places its numbers take among the program's parameters."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import casadi as ca
import numpy as np

from ...models.rational import RationalFunction, to_float
from ..problem.grid import grid
from ..problem.setting import Setting
from .split import Split

if TYPE_CHECKING:
    from numpy.typing import NDArray

FIRST_BACK_OFF = 3e-6
BACK_OFF_ON_CELLS = 3e-3  # a proof on cells resolves about a thousandth
SPREAD, DENSE, BAND = 16, 24, 12  # points of the first grid: over everything, around ω₀, and in the band
ADDED, ADDED_BAND = 20, 8  # places for points where the constraints turn out to be tight


@dataclass(frozen=True)
class Grids:
    """Where the program looks. omega: fixed grid [rad/s]; band: fractions of ω_B; back_off: relative slack required.

    added, added_band: the points of each that came later; the program has places for the last ADDED, ADDED_BAND.
    """

    omega: NDArray[np.float64]
    band: NDArray[np.float64]
    added: tuple[float, ...] = ()
    added_band: tuple[float, ...] = ()
    back_off: float = FIRST_BACK_OFF

    @classmethod
    def of(cls, setting: Setting, omega_0: float, finer: int = 1) -> Grids:
        """The first grid around omega_0 [rad/s], or one so many times finer."""
        fractions = np.concatenate([[1e-4], np.linspace(0.03, 1, finer * BAND)])
        back_off = FIRST_BACK_OFF if setting.polynomial else BACK_OFF_ON_CELLS
        omega = grid(setting, around=omega_0, spread=finer * SPREAD, dense=finer * DENSE)
        return cls(omega, fractions, back_off=back_off)

    def refined(self, omega: Sequence[float], band: Sequence[float]) -> Grids:
        """With further points; the oldest of those added make room."""
        added = tuple(dict.fromkeys([*self.added, *omega]))[-ADDED:]
        return replace(self, added=added, added_band=tuple(dict.fromkeys([*self.added_band, *band]))[-ADDED_BAND:])


class Casadi:
    """Elementwise arithmetic on CasADi expressions; the modulus is smooth at 0."""

    def multiply(self, a: Any, b: Any) -> Any:
        """Elementwise product."""
        return a * b

    def modulus(self, re: Any, im: Any) -> Any:
        """Elementwise `√(re² + im²)`."""
        return ca.sqrt(re * re + im * im + 1e-14)

    def exponential(self, re: Any, im: Any) -> tuple[Any, Any]:
        """Real and imaginary part of `e^{re + j·im}`."""
        return ca.exp(re) * ca.cos(im), ca.exp(re) * ca.sin(im)


class Places:
    """Columns of numbers that depend on the grid, as parameters: one place for each frequency of whatever grid."""

    def __init__(self, count: int) -> None:
        self.count = count
        self.columns: list[Any] = []
        self.fillings: list[Callable[[NDArray[np.float64]], NDArray[np.float64]]] = []
        self.known: dict[Any, Split] = {}
        self.filled: dict[bytes, NDArray[np.float64]] = {}  # grids come again with every start
        self.omega = self.real(lambda omega: omega)

    def real(self, filling: Callable[[NDArray[np.float64]], NDArray[np.float64]]) -> Any:
        """A column for a real function of the grid, (n,) to (n,)."""
        self.columns.append(ca.MX.sym("column", self.count))
        self.fillings.append(filling)
        return self.columns[-1]

    def at(self, r: RationalFunction) -> Split | float:
        """Columns for the values of a rational function."""
        return numbered(self._columns_of)(r)

    def _columns_of(self, r: RationalFunction) -> Split:
        if r not in self.known:
            parts = (self.real(lambda omega: r.at(omega).real), self.real(lambda omega: r.at(omega).imag))
            self.known[r] = Split(*parts, Casadi())
        return self.known[r]

    def values(self, omega: NDArray[np.float64]) -> NDArray[np.float64]:
        """All columns below each other, for one grid. omega: (count,)."""
        key = omega.tobytes()
        if key not in self.filled:
            self.filled[key] = np.concatenate([filling(omega) for filling in self.fillings])
        return self.filled[key]


def numbered(at: Callable[[RationalFunction], Split]) -> Callable[[RationalFunction], Split | float]:
    """The same values, but a constant is a number, with which CasADi has nothing to compute."""

    def value(r: RationalFunction) -> Split | float:
        constant = isinstance(r, RationalFunction) and max(r.num.degree(), r.den.degree()) <= 0
        return to_float(r.num[0] / r.den[0]) if constant else at(r)

    return value


def filled(
    points: NDArray[np.float64], added: Sequence[float], count: int
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Points for every place, and which are meant: the rest repeat one of them."""
    given = np.concatenate([points, np.array(added)])
    return np.concatenate([given, np.full(count - given.size, given[0])]), np.arange(count) < given.size
