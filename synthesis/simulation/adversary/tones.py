"""Where a joint is worst, found by its frequency response, and how bad it is there, measured from its motion."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...errors import RobimpError
from ...spec.model import Spec
from ..batch.environment import sine
from ..batch.run import simulate_batch
from ..batch.switched import switched
from ..equations import Compensator, desired

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

POINTS = 400  # of the grid on which the worst frequency is looked for
ZOOMS = 6  # each ten times finer
CYCLE = 64  # ticks
FADED = 1e-13
LONGEST = 400_000  # ticks of a measurement
PUSH, DISTURBANCE = 0, 1  # of the inputs


@dataclass(frozen=True)
class Tone:
    """One load (inertia, damping, stiffness) at one frequency [rad/s]: `Z = τ_int/θ` and `1 − Q̃` measured.

    1 − Q̃: how much a disturbance of the load moves it, as part of what the same torque at the port does.
    """

    load: tuple[float, float, float]
    omega: float
    Z: complex
    attenuation: complex

    @property
    def resistance(self) -> float:
        """`Re(Z/jω)` [N·m·s/rad]: negative, it feeds the motion."""
        return (self.Z / (1j * self.omega)).real


def responses(spec: Spec, C: Compensator, loads: Array, omega: Array) -> tuple[Complex, Complex]:
    """`Z` and `1 − Q̃` of each load at each frequency, (loads, frequencies), from the simulated joint's own flow."""
    joint = switched(spec, C, loads)
    n = joint.states
    A, B = joint.flows[:, 0, :, :n], joint.flows[:, 0, :, n : n + 2]
    pencil = 1j * omega[None, :, None, None] * np.eye(n) - A[:, None]
    theta = np.linalg.solve(pencil, np.broadcast_to(B[:, None], (*pencil.shape[:3], 2)))[:, :, 1]
    return np.asarray(1 / theta[:, :, PUSH]), np.asarray(theta[:, :, DISTURBANCE] / theta[:, :, PUSH])


Badness = Callable[[Array, Complex, Complex], Array]  # of frequencies, Z, 1 − Q̃: larger is worse


def worst(
    spec: Spec, C: Compensator, loads: Array, badness: Badness, band: tuple[float, float], hints: tuple[float, ...] = ()
) -> tuple[Array, float]:
    """The load and the frequency [rad/s] in `band` where `badness` is largest: a grid, then finer and finer ones."""
    low, high = band
    grid = np.unique(np.concatenate([np.geomspace(low, high, POINTS), [h for h in hints if low <= h <= high]]))
    width = (high / low) ** (1 / POINTS)
    for _ in range(ZOOMS):
        Z, attenuation = responses(spec, C, loads, grid)
        at = np.unravel_index(np.argmax(badness(grid, Z, attenuation)), Z.shape)
        load, omega = loads[at[0]], float(grid[at[1]])
        grid = np.unique(np.clip(np.append(np.geomspace(omega / width, omega * width, 41), omega), low, high))
        width = width ** (1 / 10)
    return load, omega


def measured(spec: Spec, C: Compensator, load: Array, omega: float) -> Tone:
    """Push the joint from rest with a sine at `omega` [rad/s], through the port and then past its sensor, and compare.

    Raises: RobimpError when it does not settle.
    """
    phasors = [_phasors(spec, C, load, omega, signal) for signal in ("contact_torque", "unfelt_torque")]
    (theta, tau), (disturbed, _) = phasors
    I, B, K = (float(value) for value in load)  # noqa: E741
    return Tone((I, B, K), omega, complex(tau / theta), complex(disturbed / (theta / tau)))


def _phasors(spec: Spec, C: Compensator, load: Array, omega: float, signal: str) -> Complex:
    laws, begun = sine(omega, signal)
    joint = switched(spec, C, load[None], environment=laws)
    n = joint.states
    poles = np.linalg.eigvals(joint.flows[0, 0, :, :n])
    decay = -max(
        pole.real for pole in poles if abs(pole - 1j * omega) > 1e-9 * omega and abs(pole + 1j * omega) > 1e-9 * omega
    )
    if decay <= 0:
        raise RobimpError(f"nothing to measure: the joint is unstable, load {load.tolist()}")
    tick = 2 * np.pi / omega / CYCLE
    settling = int(np.ceil(-np.log(FADED) / decay / tick / CYCLE)) * CYCLE
    if settling > LONGEST:
        raise RobimpError(f"settles too slowly to be measured at {omega:g} rad/s: decay {decay:.3g} /s")
    start = np.zeros(n)
    start[joint.environment] = begun
    ticks = settling + 4 * CYCLE
    run = simulate_batch(
        joint, tick, np.zeros(ticks), start=start, sines=np.array([omega]), since=settling, levels=LEVELS
    )
    theta, tau = run.phasors[0, 0]
    return np.array([theta, tau if signal == "contact_torque" else 1.0 + 0j])


LEVELS = 5  # nothing switches: the ladder only makes the exponential


def rendering_error(spec: Spec) -> Badness:
    """`|Z/G_imp − 1|` for the impedance the specification wishes."""
    wish = desired(spec)
    I, B, K = float(wish.inertia), float(wish.damping), float(wish.stiffness)  # noqa: E741

    def badness(omega: Array, Z: Complex, _: Complex) -> Array:
        return np.asarray(abs(Z / (K - I * omega**2 + 1j * B * omega) - 1))

    return badness


def yielding(omega: Array, Z: Complex, _: Complex) -> Array:
    """`−Re(Z/jω)`."""
    return np.asarray(-(Z / (1j * omega)).real)


def disturbed(_: Array, __: Complex, attenuation: Complex) -> Array:
    """`|1 − Q̃|`."""
    return np.asarray(abs(attenuation))
