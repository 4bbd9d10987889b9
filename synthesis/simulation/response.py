"""Trajectories of the joint under a torque at its port, and the energy that passes the port.

Joint and excitation together are `z' = A z`, so samples follow from the matrix exponential, and the port energy
`E = ∫ τ_int θ' dt` from the quadratic form `∫ e^{Aᵀt} M e^{At} dt`: both are exact up to rounding, at any dt.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, log2

import numpy as np
from scipy.linalg import expm

from ..errors import RobimpError
from .block import Matrix, connect
from .excitation import Excitation, Frequencies, multisine, step
from .joint import Joint

Samples = Matrix


@dataclass(frozen=True, eq=False)
class Response:
    """Samples from rest, all (n,): times [s], θ [rad], θ' [rad/s], τ_int and τ_d [N·m], port energy [J] since t = 0."""

    times: Samples
    theta: Samples
    velocity: Samples
    tau_int: Samples
    tau_d: Samples
    energy: Samples

    @property
    def energy_scale(self) -> float:
        """Largest energy, in either direction, that had passed the port: what rounding is relative to."""
        return float(abs(self.energy).max())


def step_response(joint: Joint, duration: float, dt: float, torque: float = 1.0) -> Response:
    """Response from rest to a constant τ_int [N·m]; duration and dt in s.

    Raises: RobimpError when the motion overflows, with the joint's worst pole.
    """
    return simulate(joint, step(torque), duration, dt)


def multisine_response(
    joint: Joint, frequencies: Frequencies, duration: float, dt: float, torque: float = 1.0
) -> Response:
    """Response from rest to `multisine(frequencies, torque)`: (n,) [rad/s], [N·m]; duration and dt in s.

    Raises: RobimpError when the motion overflows, with the joint's worst pole.
    """
    return simulate(joint, multisine(frequencies, torque), duration, dt)


def simulate(joint: Joint, excitation: Excitation, duration: float, dt: float) -> Response:
    """Response from rest, sampled every dt [s] on [0, duration].

    The energy at each sample is exact up to rounding; between samples it is not looked at.

    Raises: RobimpError when the motion overflows, with the joint's worst pole.
    """
    system = connect([excitation.generator, joint.system])
    start = np.concatenate([excitation.start, np.zeros(len(joint.A))])
    tau_int, velocity = system.row("tau_int"), system.row("velocity")
    power = (np.outer(tau_int, velocity) + np.outer(velocity, tau_int)) / 2
    with np.errstate(over="ignore", invalid="ignore"):
        transition, work = propagator(system.A, power, dt)
        z = trajectory(transition, start, round(duration / dt) + 1)
        increments = np.einsum("ti,ti->t", z[:-1] @ work, z[:-1])
    energy = np.concatenate([[0.0], np.cumsum(increments)])
    if not (np.isfinite(z).all() and np.isfinite(energy).all()):
        raise RobimpError(f"the motion overflows: worst pole {joint.poles.worst:.6g} rad/s, load {joint.load}")
    theta, speed, tau, demand = (z @ system.row(signal) for signal in ("theta", "velocity", "tau_int", "tau_d"))
    return Response(dt * np.arange(len(z)), theta, speed, tau, demand, energy)


def propagator(A: Matrix, M: Matrix, dt: float) -> tuple[Matrix, Matrix]:
    """`Φ = e^{A dt}` and `W = ∫₀^dt e^{Aᵀt} M e^{At} dt`.

    Van Loan's block exponential on a step short enough that e^{−Aᵀt} stays moderate, then doubled up to dt.
    """
    n = len(A)
    doublings = ceil(log2(max(float(np.linalg.norm(A, 1)) * dt, 1.0)))
    exponential = expm(np.block([[-A.T, M], [np.zeros((n, n)), A]]) * (dt / 2**doublings))
    transition = exponential[n:, n:]
    work = transition.T @ exponential[:n, n:]
    for _ in range(doublings):
        work = work + transition.T @ work @ transition
        transition = transition @ transition
    return transition, work


def trajectory(transition: Matrix, start: Samples, count: int) -> Matrix:
    """States `Φ^k z₀`, k = 0 … count − 1, (count, n); each pass doubles the part already known."""
    states = start[None, :]
    while len(states) < count:
        states = np.vstack([states, states @ transition.T])
        transition = transition @ transition
    return states[:count]
