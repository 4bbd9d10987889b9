"""`G = Ĝ(1+Δ)` (3): a box of loads, a disc `|Δ(jω)| ≤ |W(jω)|`, or the disc on top of every load of the box."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import fmpq

from .impedance import DynamicStiffness, LoadBox
from .rational import RationalFunction, to_float

if TYPE_CHECKING:
    from numpy.typing import NDArray

Segment = tuple[DynamicStiffness, DynamicStiffness]


def Omega(nominal: DynamicStiffness, desired: DynamicStiffness) -> RationalFunction:
    """`Ω = G_imp Ĝ − 1`, the known difference between wish and model, (4) (printed there as G_imn)."""
    return desired.rational / nominal.rational - 1  # type: ignore[no-any-return]


@dataclass(frozen=True)
class Table:
    """Bound on |Δ| between points, linear in ω; beyond the first and the last, their values hold."""

    omega: tuple[fmpq, ...]
    bound: tuple[fmpq, ...]

    def __call__(self, omega: NDArray[np.float64]) -> NDArray[np.float64]:
        """Values. omega: (n,) [rad/s]. Returns (n,)."""
        return np.interp(omega, *self._floats)

    def extremes(
        self, low: NDArray[np.float64], high: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Least and greatest value on each interval [low, high]. (n,) each."""
        points, values = self._floats
        ends = np.array([self(low), self(high)])
        inside = (points > low[:, None]) & (points < high[:, None])
        least = np.minimum(ends.min(axis=0), np.where(inside, values, np.inf).min(axis=1))
        return least, np.maximum(ends.max(axis=0), np.where(inside, values, -np.inf).max(axis=1))

    def straight(self, low: NDArray[np.float64], high: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Whether the bound is linear on each interval. (n,)."""
        points, _ = self._floats
        return np.asarray(~((points > low[:, None]) & (points < high[:, None])).any(axis=1))

    @property
    def _floats(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        return np.array([to_float(w) for w in self.omega]), np.array([to_float(b) for b in self.bound])


@dataclass(frozen=True)
class Uncertainty:
    """What is known of the true load: `G = G_box(1+Δ_w)(1+Δ_t)`, `|Δ_w| ≤ |weight|`, `|Δ_t| ≤ table`."""

    nominal: DynamicStiffness
    box: LoadBox | None = None
    weight: RationalFunction | None = None
    table: Table | None = None

    def __post_init__(self) -> None:
        if self.box is not None and not self.box.contains(self.nominal):
            raise ValueError("the box of loads does not contain the nominal load")

    @property
    def disc(self) -> bool:
        """Whether a disc lies on top of every load."""
        return self.weight is not None or self.table is not None

    def corners(self) -> tuple[DynamicStiffness, ...]:
        """Loads that decide whatever is affine in `G⁻¹`; the nominal load when there is no box."""
        return (self.nominal,) if self.box is None else self.box.corners()

    def segments(self) -> tuple[Segment, ...]:
        """Segments of loads that decide `|Ĝ⁻¹ − g| < θ|g|` at every threshold θ, so claims with the radius W(ω).

        In the plane of g = G⁻¹(jω) the box is a rectangle. For θ ≤ 1 the set {g: |ĝ−g| < θ|g|} is a disc: convex, so
        the corners decide. For θ > 1 its complement is a disc centred at −ĝ/(θ²−1), below the rectangle and on the
        other side of the imaginary axis than ĝ: the nearest point of the rectangle lies on its edge of least damping,
        and is a corner unless the real part K − Iω² changes sign in the box, which it cannot when K is 0 throughout.
        """
        points = tuple((load, load) for load in self.corners())
        if self.box is None or self.box.stiffness[1] == 0:
            return points
        return (*points, self.box.lower_edge())

    def box_radius(self, omega: NDArray[np.float64]) -> NDArray[np.float64]:
        """Exact maximum of `|Ĝ⁻¹/G⁻¹ − 1|` over the box. omega: (n,) [rad/s] > 0. Returns (n,)."""
        radius = np.zeros_like(omega)
        if self.box is None:
            return radius
        s = 1j * omega
        nominal = _at(self.nominal, s)
        for load in self.corners():
            radius = np.maximum(radius, np.abs(nominal / _at(load, s) - 1))
        start, end = self.box.lower_edge()
        if start == end:
            return radius
        # On the edge v = const the radius is stationary in u = Re g where û u² + (v² − û² − (v̂−v)²) u − û v² = 0.
        first, last = _at(start, s), _at(end, s)
        u_hat, v = nominal.real, first.imag
        linear = v**2 - u_hat**2 - (nominal.imag - v) ** 2
        with np.errstate(divide="ignore", invalid="ignore"):
            root = np.sqrt(linear**2 + 4 * u_hat**2 * v**2)
            for sign in (1.0, -1.0):
                u = (-linear + sign * root) / (2 * u_hat)
                u = np.clip(np.nan_to_num(u), first.real, last.real)
                value = np.abs(nominal / (u + 1j * v) - 1)
                radius = np.maximum(radius, np.where(np.isnan(value), np.inf, value))
        return radius

    def disc_radius(self, omega: NDArray[np.float64]) -> NDArray[np.float64]:
        """Radius V of the disc on top of every load, `1 + V = (1+|weight|)(1+table)`. omega: (n,) [rad/s]."""
        weight = np.zeros_like(omega) if self.weight is None else np.abs(self.weight.at(omega))
        table = np.zeros_like(omega) if self.table is None else self.table(omega)
        return weight + table + weight * table

    def radius(self, omega: NDArray[np.float64]) -> NDArray[np.float64]:
        """Radius W(ω) of the smallest disc around 0 that is known to hold Δ(jω): `W_b + V + W_b V`."""
        box, disc = self.box_radius(omega), self.disc_radius(omega)
        return box + disc + box * disc


def _at(load: DynamicStiffness, s: NDArray[Any]) -> NDArray[Any]:
    inertia, damping, stiffness = (to_float(v) for v in (load.inertia, load.damping, load.stiffness))
    return inertia * s**2 + damping * s + stiffness
