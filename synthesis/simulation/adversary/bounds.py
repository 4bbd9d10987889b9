"""How large Δ may be, `G = Ĝ(1+Δ)`: of the box, of weight and table on top of it, and of all together."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ...spec.model import Spec
from .loop import Array, Complex

Bound = Callable[[Array], Array]  # W at frequencies [rad/s]

EDGE = np.linspace(0, 1, 33)[1:-1]  # where the edges of the box are looked at


def lumped(spec: Spec) -> Bound | None:
    """The largest |Δ| about the nominal load, of box, weight and table together; None if the load is certain."""
    disc, boxed = on_top(spec), spec.uncertainty.box is not None
    if disc is None and not boxed:
        return None

    def W(omega: Array) -> Array:
        box = of_box(spec, omega) if boxed else np.zeros_like(omega)
        return box if disc is None else (1 + box) * (1 + disc(omega)) - 1

    return W


def on_top(spec: Spec) -> Bound | None:
    """The disc that lies on every load of the box: weight and table, one after the other; None without."""
    weight, table = spec.uncertainty.weight, spec.uncertainty.table
    if weight is None and table is None:
        return None

    def V(omega: Array) -> Array:
        total = np.ones_like(omega)
        if weight is not None:
            numerator, denominator = ([float(c) for c in part] for part in (weight.numerator, weight.denominator))
            total = total * (1 + abs(rational(numerator, denominator, omega)))
        if table is not None:
            points, bounds = np.array([[float(value) for value in point] for point in table.points]).T
            total = total * (1 + np.interp(omega, points, bounds))
        return np.asarray(total - 1)

    return V


def of_box(spec: Spec, omega: Array) -> Array:
    """Largest |Ĝ⁻¹/G⁻¹ − 1| over the edges of the rectangle that `G⁻¹ = K − Iω² + jωB` fills: W from below."""
    box, plant = spec.uncertainty.box, spec.plant
    assert box is not None
    (I0, I1), (B0, B1), (K0, K1) = ((float(a), float(b)) for a, b in (box.inertia, box.damping, box.stiffness))
    s = 1j * omega
    nominal = float(plant.inertia) * s**2 + float(plant.damping) * s + float(plant.stiffness)
    low, high = K0 - I1 * omega**2, K1 - I0 * omega**2
    candidates = [end + s * B for end in (low, high) for B in (B0, B1)]
    for t in EDGE:
        candidates += [low + t * (high - low) + s * B for B in (B0, B1)]
        candidates += [end + s * (B0 + t * (B1 - B0)) for end in (low, high)]
    return np.asarray(np.max([abs(nominal / value - 1) for value in candidates], axis=0))


def rational(numerator: list[float] | Array, denominator: list[float] | Array, omega: Array) -> Complex:
    """Values at jω."""
    return np.asarray(np.polyval(numerator, 1j * omega) / np.polyval(denominator, 1j * omega))
