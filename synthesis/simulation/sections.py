"""Second-order sections as a drive computes them: direct form II transposed, every operation rounded to its precision.

`H(z) = Π (b₀ + b₁ z⁻¹ + b₂ z⁻²)/(1 + a₁ z⁻¹ + a₂ z⁻²)`, of each section in this order and nothing fused:
`y = b₀ x + z₁;  z₁ = (b₁ x − a₁ y) + z₂;  z₂ = b₂ x − a₂ y`. Exported code that does the same gives the same bits.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from ..errors import InputError
from .batch.compiled import compiled, inlined

ORDER = ("b0", "b1", "b2", "1", "a1", "a2")  # of a row
ARITHMETICS = (np.dtype(np.float64), np.dtype(np.float32))


def run(sos: NDArray[np.float64], x: NDArray[np.float64], dtype: DTypeLike = np.float64) -> NDArray[Any]:
    """The output for samples x from rest, one section after the other.

    Args: `sos` (n, 6): rows as in `ORDER`; `x` (samples,); both are rounded to `dtype`, float64 or float32, first.

    Returns: (samples,) of that `dtype`.

    Raises: InputError for another precision, another shape, or a section whose fourth coefficient is not 1.
    """
    precision = np.dtype(dtype)
    if precision not in ARITHMETICS:
        raise InputError(f"sections run in float64 or float32, not in {precision}")
    rows = np.ascontiguousarray(sos, dtype=precision)
    if rows.ndim != 2 or rows.shape[1] != len(ORDER) or not (rows[:, 3] == 1).all():
        raise InputError(f"sections are rows {', '.join(ORDER)}; got {np.shape(sos)}, fourth column not all 1?")
    state = np.zeros((len(rows), 2), dtype=precision)
    y = np.array(x, dtype=precision)
    _run(rows, state, y)
    return y


@compiled
def _run(sos: NDArray[Any], state: NDArray[Any], y: NDArray[Any]) -> None:
    for k in range(len(y)):
        y[k] = advanced(sos, state, y[k])


@inlined
def advanced(sos: NDArray[Any], state: NDArray[Any], x: Any) -> Any:
    """One sample through all sections; `state` (n, 2) moves on."""
    for i in range(len(sos)):
        y = sos[i, 0] * x + state[i, 0]
        state[i, 0] = (sos[i, 1] * x - sos[i, 4] * y) + state[i, 1]
        state[i, 1] = sos[i, 2] * x - sos[i, 5] * y
        x = y
    return x
