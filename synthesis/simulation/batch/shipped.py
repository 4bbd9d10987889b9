"""The control law as it is exported: filters as second-order sections, each operation rounded to their precision.

`τ_d = C (F a·τ_int − F_θ b·θ) + F_d c·θ`, with a, b, c weights of the newest three samples and C, F, F_θ, F_d sections.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..sections import ORDER, advanced
from .compiled import inlined
from .law import Arithmetic


class Cascades(NamedTuple):
    """`taps` (3, 3): rows a, b, c, newest sample first; sections (n, 6) in order b0, b1, b2, 1, a1, a2; n = 0: 1."""

    taps: NDArray[Any]
    compensator: NDArray[Any]
    force: NDArray[Any]
    position: NDArray[Any]
    derivative: NDArray[Any]


@dataclass(frozen=True, eq=False)
class ShippedLaw:
    """The law every `tick` [s], held, `delay` ticks later."""

    cascades: Cascades
    tick: float
    delay: int

    @classmethod
    def of(
        cls, taps: ArrayLike, compensator: ArrayLike, tick: float, *, force: ArrayLike = (), position: ArrayLike = (),
        derivative: ArrayLike = (), delay: int = 0, arithmetic: Arithmetic = "float64",
    ) -> ShippedLaw:  # fmt: skip
        """With every number rounded to `arithmetic`."""

        def sections(rows: ArrayLike) -> NDArray[Any]:
            return np.array(rows, dtype=arithmetic).reshape(-1, len(ORDER))

        filters = [sections(rows) for rows in (compensator, force, position, derivative)]
        return cls(Cascades(np.array(taps, dtype=arithmetic), *filters), tick, delay)


@inlined
def at_rest(law: Cascades) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any], NDArray[Any]]:
    """States of compensator, force, position and derivative."""
    kind = law.taps.dtype
    return (
        np.zeros((len(law.compensator), 2), dtype=kind), np.zeros((len(law.force), 2), dtype=kind),
        np.zeros((len(law.position), 2), dtype=kind), np.zeros((len(law.derivative), 2), dtype=kind),
    )  # fmt: skip


@inlined
def shipped(
    law: Cascades, states: tuple[NDArray[Any], NDArray[Any], NDArray[Any], NDArray[Any]],
    past: NDArray[Any], sensed: NDArray[Any],
) -> float:  # fmt: skip
    """The law's output for what is sensed (τ_int, θ); `past` (2, 3) and the states of the sections move on."""
    taps = law.taps
    for signal in range(2):
        past[signal, 2], past[signal, 1], past[signal, 0] = past[signal, 1], past[signal, 0], sensed[signal]
    torque = taps[0, 0] * past[0, 0] + taps[0, 1] * past[0, 1] + taps[0, 2] * past[0, 2]
    wish = taps[1, 0] * past[1, 0] + taps[1, 1] * past[1, 1] + taps[1, 2] * past[1, 2]
    inner = taps[2, 0] * past[1, 0] + taps[2, 1] * past[1, 1] + taps[2, 2] * past[1, 2]
    error = advanced(law.force, states[1], torque) - advanced(law.position, states[2], wish)
    return float(advanced(law.compensator, states[0], error) + advanced(law.derivative, states[3], inner))
