"""Controllers of the paper as compensators `C` of the dynamic error: (2), (10), (20), and the Q-filter (23)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from flint import fmpq_poly

from .rational import ONE, RationalFunction, Scalar, exact, polynomial, ratio


@dataclass(frozen=True)
class Compensator:
    """`C = num/den` of `τ_d = C(F τ_int − G_imp F_θ θ) + F_d(Ĝ⁻¹ − G_imp)θ`, (10) and (20); never cancelled.

    Cancelling would hide a mode of the controller that stability has to account for.
    """

    num: Any  # polynomials of s, or their values somewhere
    den: Any

    @property
    def rational(self) -> Any:
        """C(s) in lowest terms."""
        return ratio(self.num, self.den)


def disturbance_observer(Q_num: Any, Q_den: Any) -> Compensator:
    """`C = Q/(1−Q)`, (10). Raises ValueError when Q is a polynomial pair that is 1 identically or improper."""
    if isinstance(Q_num, fmpq_poly):
        if Q_num.degree() > Q_den.degree():
            raise ValueError("Q must be proper: its numerator has the higher degree")
        if Q_num == Q_den:
            raise ValueError("Q = 1 identically: C = Q/(1−Q) does not exist")
    return Compensator(Q_num, Q_den - Q_num)


def dynamic_error_feedback(C_num: Any, C_den: Any) -> Compensator:
    """`C = C_imp`, (20)."""
    return Compensator(C_num, C_den)


def inverse_dynamics() -> Compensator:
    """`C = 0`: inverse dynamic compensation alone, (2)."""
    return Compensator(fmpq_poly([0]), fmpq_poly([1]))


def eq23(alpha: Scalar, omega: Scalar, damping: Scalar = "1.415") -> tuple[fmpq_poly, fmpq_poly]:
    """The paper's filter `Q = α ω²/(s² + damping·ω s + ω²)`, (23); printed with damping = 2ζ = 1.415. omega [rad/s]."""
    a, w, d = exact(alpha), exact(omega), exact(damping)
    return fmpq_poly([a * w * w]), fmpq_poly([w * w, d * w, 1])


def low_pass(corner: Scalar) -> RationalFunction:
    """`1/(1 + s/corner)`. corner [rad/s]."""
    return RationalFunction(fmpq_poly([1]), polynomial([1 / exact(corner), 1]))


@dataclass(frozen=True)
class Filters:
    """Sensor filters: `force` on τ_int, `position` on θ in the dynamic error, `derivative` in the inner compensation.

    `position=None`: one filter, `force`, acts on the whole dynamic error.
    """

    force: RationalFunction = ONE
    position: RationalFunction | None = None
    derivative: RationalFunction = ONE

    @property
    def ratio(self) -> RationalFunction:
        """`F_θ/F`: 1 unless the two channels are filtered differently."""
        return ONE if self.position is None else self.position / self.force
