"""Dynamic stiffness `I s² + B s + K` of loads and desired impedances (1), and boxes of loads."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from flint import fmpq, fmpq_poly

from .rational import RationalFunction, Scalar, exact


@dataclass(frozen=True)
class DynamicStiffness:
    """`I s² + B s + K`, torque per angle: the load's `G⁻¹` of (1) or the desired `G_imp` of (2)."""

    inertia: Any  # exact numbers, or enclosures of uncertain ones
    damping: Any
    stiffness: Any
    s: Any = field(default_factory=lambda: fmpq_poly([0, 1]), repr=False, compare=False)

    @classmethod
    def of(cls, inertia: Scalar, damping: Scalar, stiffness: Scalar) -> DynamicStiffness:
        """From any numbers. inertia [kg·m²], damping [N·m·s/rad], stiffness [N·m/rad]."""
        return cls(exact(inertia), exact(damping), exact(stiffness))

    @cached_property
    def polynomial(self) -> Any:
        """`I s² + B s + K`."""
        return self.s * self.s * self.inertia + self.s * self.damping + self.stiffness

    @cached_property
    def rational(self) -> Any:
        """The same as a rational function."""
        return RationalFunction.lift(self.polynomial)


def inverse_dynamic_compensation(nominal: DynamicStiffness, desired: DynamicStiffness) -> RationalFunction:
    """`τ_act/θ = Ĝ⁻¹ − G_imp` of inverse dynamic compensation, (2)."""
    return nominal.rational - desired.rational  # type: ignore[no-any-return]


@dataclass(frozen=True)
class LoadBox:
    """All loads with inertia, damping and stiffness in intervals, independently. Each: (low, high)."""

    inertia: tuple[fmpq, fmpq]
    damping: tuple[fmpq, fmpq]
    stiffness: tuple[fmpq, fmpq]

    def corners(self) -> tuple[DynamicStiffness, ...]:
        """The loads at the corners of the rectangle that `G⁻¹(jω) = (K − Iω²) + jωB` fills at each ω.

        Four of the box's eight vertices: those with extreme real part. Whatever is affine (or has its maximum at an
        extreme point) in `G⁻¹` is decided by them at every frequency.
        """
        (i_lo, i_hi), (b_lo, b_hi), (k_lo, k_hi) = self.inertia, self.damping, self.stiffness
        pairs = {(str(i), str(k)): (i, k) for i, k in ((i_hi, k_lo), (i_lo, k_hi))}
        dampings = {str(b): b for b in (b_lo, b_hi)}
        return tuple(DynamicStiffness(i, b, k) for i, k in pairs.values() for b in dampings.values())

    def lower_edge(self) -> tuple[DynamicStiffness, DynamicStiffness]:
        """Ends of the segment of loads that traces the rectangle's edge of least damping."""
        return (
            DynamicStiffness(self.inertia[1], self.damping[0], self.stiffness[0]),
            DynamicStiffness(self.inertia[0], self.damping[0], self.stiffness[1]),
        )

    def contains(self, load: DynamicStiffness) -> bool:
        """Whether a load lies in the box, ends included."""
        return all(
            lo <= value <= hi
            for (lo, hi), value in zip(
                (self.inertia, self.damping, self.stiffness), (load.inertia, load.damping, load.stiffness), strict=True
            )
        )
