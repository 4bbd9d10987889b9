"""The port's impedance, measured from its response to a multisine."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lstsq

from ..errors import InputError, RobimpError
from .excitation import Excitation
from .joint import Joint
from .march import Samples
from .response import Response, simulate

SAMPLES_PER_CYCLE = 20  # of the highest frequency
FADED = 1e-13  # a transient below this fraction is rounding
LIMIT = 200_000  # samples of a record
EPSILON = float(np.finfo(float).eps)


@dataclass(frozen=True, eq=False)
class MeasuredImpedance:
    """`Z = τ_int/θ` [N·m/rad] at `frequencies` (n,) [rad/s], and its own estimate of its relative error, (n,)."""

    frequencies: Samples
    Z: NDArray[np.complex128]
    accuracy: Samples


def measure_impedance(joint: Joint, excitation: Excitation, periods: float = 4) -> tuple[Response, MeasuredImpedance]:
    """Excite a stable joint from rest, wait for its transients, then fit sines to τ_int and θ.

    The fit lasts `periods` of the smallest distance between frequencies (or of the lowest one).
    Waiting ends when transients have faded, or after as long again: modes still alive are then fitted along.
    The error estimate is the disagreement between the two halves of the fitted time, the residual, and what the steps
    of a held joint cost.

    Raises: InputError when the frequencies are too close, or too far apart, for a record of bounded length;
    RobimpError, with the worst pole, when the joint is not stable and so has no steady state.
    """
    if not joint.poles.stable:
        raise RobimpError(f"nothing to measure: worst pole {joint.poles.worst:.6g} rad/s, load {joint.load}")
    omega = excitation.frequencies
    distance = np.diff(np.sort(omega), prepend=0).min()
    dt = 2 * np.pi / omega.max() / SAMPLES_PER_CYCLE
    if distance * LIMIT / 2 * dt < 2 * np.pi * periods:
        band = f"{omega.min():g} to {omega.max():g} rad/s"
        raise InputError(f"frequencies within {band} cannot be told apart in {LIMIT} samples")
    window = 2 * np.pi * periods / distance
    settling = min(-np.log(FADED) / joint.poles.decay, window)
    response = simulate(joint, excitation, settling + window, dt)
    alive = joint.poles.values[np.exp(joint.poles.values.real * settling) > FADED]
    first = int(np.ceil(settling / response.times[1]))
    middle = (first + len(response.times)) // 2
    parts = (slice(first, middle), slice(middle, None), slice(first, None))
    early, late, whole = (_fitted(response, part, omega, alive) for part in parts)
    accuracy = abs(early.Z - late.Z) / abs(whole.Z) + whole.accuracy + joint.step_error(omega)
    return response, MeasuredImpedance(omega, whole.Z, accuracy)


def _fitted(response: Response, part: slice, omega: Samples, modes: NDArray[np.complex128]) -> MeasuredImpedance:
    """Ratio of the least-squares phasors of τ_int and θ, with decaying `modes` as further regressors.

    Its accuracy is what the fit leaves of each record, rms, relative to the phasor.
    """
    t = response.times[part]
    records = np.column_stack([response.tau_int[part], response.theta[part]])
    waves = np.exp(1j * np.outer(t, omega))
    decays = np.exp(np.outer(t - t[0], modes[modes.imag >= 0]))
    basis = np.hstack([waves.real, -waves.imag, decays.real, decays.imag])
    fit = lstsq(basis, records, cond=EPSILON * len(t), lapack_driver="gelsy")[0]
    residual = np.sqrt(np.mean((records - basis @ fit) ** 2, axis=0))
    n = len(omega)
    phasors = fit[:n] + 1j * fit[n : 2 * n]
    return MeasuredImpedance(omega, phasors[:, 0] / phasors[:, 1], (residual / abs(phasors)).sum(axis=1))
