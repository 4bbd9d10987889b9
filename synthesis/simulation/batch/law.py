"""The control law as a drive computes it: once per tick, from an encoder and a torque sensor, in its own arithmetic."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from ...spec.model import Spec
from ..block import connect
from ..equations import Compensator, controller_equations
from ..sampled import RATE, differences, tustin

Arithmetic = Literal["float64", "float32"]


@dataclass(frozen=True, eq=False)
class SampledLaw:
    """`ξ⁺ = A ξ + B (τ_int, θ)`, `τ_d = C ξ + D (τ_int, θ)` every `tick` [s], held, `delay` ticks later."""

    A: NDArray[Any]
    B: NDArray[Any]
    C: NDArray[Any]
    D: NDArray[Any]
    tick: float
    delay: int


def sampled_law(
    spec: Spec,
    compensator: Compensator,
    *,
    rate: float | None = None,
    delay: int | None = None,
    arithmetic: Arithmetic = "float64",
) -> SampledLaw:
    """(20) by Tustin's rule with θ', θ'' by backward differences; `rate` [Hz], `delay` [ticks].

    By default those of the specification, a delay rounded up to ticks, or 1 kHz and none.

    Raises: RobimpError for a singular algebraic loop, InputError for an improper C.
    """
    sampling = spec.sampling
    rate = rate or (float(sampling.rate) if sampling else RATE)
    delay = delay if delay is not None else ceil(sampling.delay * sampling.rate) if sampling else 0
    law = connect(controller_equations(spec, compensator), ["tau_int", "theta", "velocity", "acceleration"], ["tau_d"])
    loop = connect([differences(1 / rate), tustin(law, 1 / rate)], ["tau_int", "theta"], ["tau_d"])
    A, B, C, D = (np.ascontiguousarray(part, dtype=arithmetic) for part in (loop.A, loop.B, loop.C, loop.D))
    return SampledLaw(A, B, C, D, 1 / rate, delay)


def law_and_compensator(
    spec: Spec, compensator: Compensator, rate: float | None = None, arithmetic: Arithmetic = "float64"
) -> tuple[SampledLaw | None, Compensator | None]:
    """The sampled law where the specification or `rate` [Hz] says so, for `simulate_batch`; else C, for `switched`."""
    if spec.sampling is None and rate is None:
        return None, compensator
    return sampled_law(spec, compensator, rate=rate, arithmetic=arithmetic), None
