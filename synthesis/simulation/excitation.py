"""Torques applied at the port, as autonomous systems: they are integrated with the joint, without a hold."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag

from ..errors import InputError
from ..spec.model import SeriesElasticActuator, Spec, TwoPortActuator
from .block import Block
from .equations import desired

Frequencies = Sequence[float] | NDArray[np.float64]  # (n,) [rad/s]

REMEMBERED = 32.0  # rad that the fastest sine turns within hold and delay: steps as fine as it needs are remembered
SPAN = 250  # highest over lowest default frequency: bounds the samples a period of the lowest one takes


@dataclass(frozen=True, eq=False)
class Excitation:
    """`τ_int = Σ Re(amplitude · e^{jωt})` from t = 0: frequencies (n,) [rad/s], complex amplitudes (n,) [N·m]."""

    frequencies: NDArray[np.float64]
    amplitudes: NDArray[np.complex128]

    @property
    def start(self) -> NDArray[np.float64]:
        """Initial state of the generator, (2n,): real and imaginary part of each phasor."""
        return np.column_stack([self.amplitudes.real, self.amplitudes.imag]).ravel()

    @property
    def generator(self) -> Block:
        """The oscillators, one per frequency; their real parts add up to τ_int."""
        n = len(self.frequencies)
        A = block_diag(*(omega * np.array([[0.0, -1.0], [1.0, 0.0]]) for omega in self.frequencies))
        return Block((), ("tau_int",), A, np.zeros((2 * n, 0)), np.tile([1.0, 0.0], n)[None, :], np.zeros((1, 0)))


def step(torque: float = 1.0) -> Excitation:
    """A constant torque [N·m] from t = 0: an oscillator of frequency zero."""
    return Excitation(np.zeros(1), np.array([torque + 0j]))


def multisine(frequencies: Frequencies, torque: float = 1.0) -> Excitation:
    """Sines of equal amplitude with the rms of one sine of amplitude `torque`, phases chosen for a low crest factor.

    Of the quadratic phases `π c k²/n` (Schroeder's: c = 1), those flattest over a period of the lowest frequency.

    Args: `frequencies`: (n,) [rad/s], positive and distinct; `torque`: [N·m].
    Raises: InputError for a frequency that is not positive and finite.
    """
    omega = np.asarray(frequencies, dtype=float)
    if not (omega.size and (omega > 0).all() and np.isfinite(omega).all()):
        raise InputError("a multisine needs at least one frequency, all of them positive and finite")
    k = np.arange(len(omega))
    candidates = np.exp(1j * np.pi * np.outer(np.linspace(0, 2, 65), k**2) / len(omega))
    times = np.linspace(0, 2 * np.pi / omega.min(), 4096)
    peaks = abs((candidates @ np.exp(1j * np.outer(omega, times))).real).max(axis=1)
    return Excitation(omega, torque / np.sqrt(len(omega)) * candidates[np.argmin(peaks)])


def default_frequencies(spec: Spec, count: int = 12) -> NDArray[np.float64]:
    """About `count` frequencies [rad/s], log-spaced from below the wished impedance to above the drive's resonance.

    Modes of a two-port count as far as the lowest frequency allows. They are harmonics of the lowest
    one, so that whole periods exist and the crest factor means something.
    """
    wish, actuator = desired(spec), spec.actuator
    I, B, K = (float(value) for value in (wish.inertia, wish.damping, wish.stiffness))  # noqa: E741
    marks = [a / b for a, b in ((K, B), (B, I)) if a > 0 and b > 0]
    marks += [np.sqrt(K / I)] if K > 0 and I > 0 else []
    low, high = min(marks, default=4.0) / 4, 10 * max(marks, default=1.0)
    if isinstance(actuator, SeriesElasticActuator):
        closed = float(actuator.spring_stiffness * (1 + actuator.torque_loop.kp) / actuator.motor_inertia)
        high = max(high, 3 * np.sqrt(closed))
    if isinstance(actuator, TwoPortActuator):
        high = max([high, *(top for mode in _modes(actuator) if (top := 3 * mode) <= SPAN * low)])
    if spec.sampling is not None:
        high = min(high, REMEMBERED / float(1 / spec.sampling.rate + spec.sampling.delay))
        low = min(low, high / 10)
    low = max(low, high / SPAN)
    return low * np.unique(np.round(np.geomspace(1, high / low, count)))


def _modes(actuator: TwoPortActuator) -> list[float]:
    """Natural frequencies [rad/s] of the pairs of poles of a two-port."""
    denominators = (actuator.transfer.denominator, actuator.impedance.denominator)
    roots = np.concatenate([np.roots([float(c / max(map(abs, den))) for c in den]) for den in denominators])
    return [float(abs(root)) for root in roots if root.imag > 0]
