"""Constraints on a frequency grid as rows of a convex program: one inequality, `constant + slope·X` at each frequency.

X is the inequality's own variable, except that what speaks of the command `CF/(1+HCF) = Q̃/H` becomes rows in Q̃.

The numbers come from `Inequality.sides`, evaluated with lines in an X yet unknown. A right side `|g + hX|` becomes the
half-plane `Re(m̄(g + hX))` with m its own direction at a given X, which never admits an X the inequality excludes.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..problem.constraints.inequality import Constraint, Inequality, Role, Variable
from ..problem.grid import Evaluator
from ..problem.setting import Setting

if TYPE_CHECKING:
    from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Line:
    """`constant + slope·X`; mixes with NumPy arrays and numbers. Each: (n,) or scalar, complex."""

    constant: Any
    slope: Any

    __array_ufunc__ = None  # a NumPy array on the left defers to the methods here

    def __add__(self, other: Any) -> Line:
        if isinstance(other, Line):
            return Line(self.constant + other.constant, self.slope + other.slope)
        return Line(self.constant + other, self.slope)

    def __mul__(self, factor: Any) -> Line:
        return Line(self.constant * factor, self.slope * factor)

    __radd__ = __add__
    __rmul__ = __mul__

    def __abs__(self) -> Side:
        return Side((self,), Line(0.0, 0.0))

    @property
    def real(self) -> Side:
        """Its real part, as a side of an inequality."""
        return Side((), self)

    def at(self, X: NDArray[np.complex128]) -> Any:
        """Values for given X. (n,)."""
        return self.constant + self.slope * X


@dataclass(frozen=True, eq=False)
class Side:
    """`Σ|moduli| + Re(rest)`."""

    moduli: tuple[Line, ...]
    rest: Line

    __array_ufunc__ = None

    def __add__(self, other: Any) -> Side:
        if isinstance(other, Side):
            return Side(self.moduli + other.moduli, self.rest + other.rest)
        return Side(self.moduli, self.rest + other)

    def __mul__(self, factor: Any) -> Side:
        return Side(tuple(line * factor for line in self.moduli), self.rest * factor)

    __radd__ = __add__
    __rmul__ = __mul__


@dataclass(frozen=True, eq=False)
class Rows:
    """`Σ|moduli| ≤ Re(rest) + |right|` at the frequencies omega, (m,) [rad/s], all divided by the row's size."""

    id: str
    variable: Variable
    vertex: int
    omega: NDArray[np.float64]
    moduli: tuple[Line, ...]
    rest: Line
    right: Line | None
    floor: float | None = None  # of a level that is added: the size; of the others, that multiply, None
    unit: float = 1.0  # in sizes: by how much a floor is lowered when it is eased by one

    @classmethod
    def of(
        cls,
        setting: Setting,
        constraint: Constraint,
        inequality: Inequality,
        omega: NDArray[np.float64],
        vertex: int = 0,
    ) -> Rows:
        """One inequality of a constraint at given frequencies; only those inside the constraint's own interval."""
        evaluator = Evaluator(setting, omega)
        omega = omega if constraint.on_band else omega[evaluator.inside(constraint)]
        W = Evaluator(setting, omega).radius(inequality.source)
        per_Q = 1 / setting.loop.actuator.H.at(omega) if inequality.variable is Variable.COMMAND else 1.0
        X, zero = Line(np.zeros(omega.size, complex), per_Q * np.ones(omega.size, complex)), np.zeros(omega.size)

        def at(r: Any) -> Any:
            return r.at(omega)

        left, right = (
            side if isinstance(side, Side) else Side((), Line(side + zero, zero))
            for side in inequality.sides(float(constraint.level or 0), W, X, at)
        )
        size = np.abs(at(inequality.right.constant)) + np.abs(at(inequality.right.slope))
        size = np.full_like(size, size.min(initial=np.inf)) if inequality.role is Role.FLOOR else size
        scale = 1 / size
        return cls(
            constraint.id,
            inequality.variable,
            vertex,
            omega,
            tuple(line * scale for line in left.moduli),
            (right.rest + left.rest * -1.0) * scale,
            right.moduli[0] * scale if right.moduli else None,
            float(size.min(initial=np.inf)) if inequality.role is Role.FLOOR else None,
        )

    def slack(self, X: NDArray[np.complex128], level: float = 1.0) -> NDArray[np.float64]:
        """Right side, eased to `level`, minus left side; negative where violated. X at omega. (m,).

        At level 1 as it is asked; what has a floor is lowered by `level − 1` units, of the rest the right side grows.
        """
        rest = np.real(self.rest.at(X))
        rest = level * rest if self.floor is None else rest + (level - 1) * self.unit
        slack = rest - sum(np.abs(line.at(X)) for line in self.moduli)
        return np.asarray(slack if self.right is None else slack + np.abs(self.right.at(X)))
