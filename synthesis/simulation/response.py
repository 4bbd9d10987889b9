"""Trajectories of the joint under a torque at its port, and the energy that passes the port.

Joint and excitation together are `z' = A z`, so samples follow from the matrix exponential, and the port energy
`E = ∫ τ_int θ' dt` from the quadratic form `∫ e^{Aᵀt} M e^{At} dt`: both are exact up to rounding, at any dt. With a
hold the same is true of the held joint's own steps (`held.py`), whose error is known.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..errors import RobimpError
from .excitation import Excitation, Frequencies, multisine, step
from .joint import Joint
from .march import Samples, trajectory


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
    """Response from rest, sampled every dt [s] on [0, duration]; with a hold dt is rounded to its steps.

    The energy at each sample is exact up to rounding; between samples it is not looked at.

    Raises: RobimpError when the motion overflows, with the joint's worst pole.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        march = joint.march(excitation, dt)
        z = trajectory(march.transition, march.start, round(duration / march.dt) + 1)
        increments = np.einsum("ti,ti->t", z[:-1] @ march.work, z[:-1])
    energy = np.concatenate([[0.0], np.cumsum(increments)])
    if not (np.isfinite(z).all() and np.isfinite(energy).all()):
        raise RobimpError(f"the motion overflows: worst pole {joint.poles.worst:.6g} rad/s, load {joint.load}")
    theta, speed, tau, demand = (z @ march.rows[signal] for signal in ("theta", "velocity", "tau_int", "tau_d"))
    return Response(march.dt * np.arange(len(z)), theta, speed, tau, demand, energy)
