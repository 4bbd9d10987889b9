"""Where joints are worst, found by their frequency response, and how bad they are there, measured from their motion."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ...spec.model import Spec
from ..equations import desired
from .loop import Array, Complex, Loop

POINTS = 400  # of the grid on which the worst frequency is looked for
ZOOMS = 6  # each ten times finer
NOISE = 1e-9  # of the complex figure a run measures


@dataclass(frozen=True)
class Quantity:
    """A figure of each frequency [rad/s]: `value(ω, *responses)`, of `output` per each of `inputs`.

    The larger its size the worse; what `resists` is worse the smaller its real part.
    """

    output: str
    inputs: tuple[str, ...]
    value: Callable[..., Complex]
    resists: bool = False

    @property
    def sign(self) -> int:
        """Of the figure itself when `worse` is turned back into it."""
        return -1 if self.resists else 1

    def worse(self, omega: Array, *responses: Complex) -> Array:
        """How bad, larger is worse: size, or real part with its sign changed."""
        value = self.value(omega, *responses)
        return np.asarray(-value.real if self.resists else abs(value))

    def of(self, loop: Loop, omega: Array) -> Array:
        """By the loop's frequency response, (n,)."""
        return self.worse(omega, *loop.response(omega, self.output, *self.inputs))


ATTENUATION = Quantity("theta", ("push", "disturbance"), lambda _, push, disturbance: disturbance / push)
"""`1 − Q̃`: what a torque past the sensor moves, as part of what the same torque at the port does."""
RESISTANCE = Quantity("theta", ("push",), lambda omega, push: 1 / (1j * omega * push), resists=True)
"""`Re(Z/jω)` [N·m·s/rad]: negative, it feeds the motion."""
DRY = Quantity("theta", ("disturbance",), lambda omega, disturbance: 1 / (1j * omega * disturbance), resists=True)
"""The same of what friction on the load meets, which no sensor feels."""
COMMAND = Quantity("tau_d", ("noise",), lambda _, noise: noise)
"""Command torque per noise of the torque sensor."""


def rendering_error(spec: Spec) -> Quantity:
    """`|Z/G_imp − 1|` for the impedance the specification wishes."""
    wish = desired(spec)
    I, B, K = float(wish.inertia), float(wish.damping), float(wish.stiffness)  # noqa: E741

    def value(omega: Array, push: Complex) -> Complex:
        return np.asarray(1 / push / (K - I * omega**2 + 1j * B * omega) - 1)

    return Quantity("theta", ("push",), value)


Badness = Callable[[Array], Array]  # of frequencies (n,) [rad/s]


def worst(
    each: Sequence[Badness], band: tuple[float, float], hints: tuple[float, ...] = ()
) -> tuple[int, float, float]:
    """Which is worst, the frequency [rad/s] in `band` where it is, and how bad: a grid, then finer and finer ones."""
    low, high = band
    grid = np.unique(np.concatenate([np.geomspace(low, high, POINTS), [h for h in hints if low <= h <= high]]))
    width = (high / low) ** (1 / POINTS)
    for _ in range(ZOOMS):
        values = np.array([badness(grid) for badness in each])
        which, at = np.unravel_index(np.nanargmax(values), values.shape)
        omega, most = float(grid[at]), float(values[which, at])
        grid = np.unique(np.clip(np.append(np.geomspace(omega / width, omega * width, 41), omega), low, high))
        width = width ** (1 / 10)
    return int(which), omega, most


@dataclass(frozen=True)
class Measured:
    """How bad it was, the size of the complex figure behind it, and the relative error of the steps."""

    worse: float
    size: float
    error: float

    @property
    def slack(self) -> float:
        """By how much `worse` may be off."""
        return (NOISE + 10 * self.error) * self.size


def measured(loop: Loop, quantity: Quantity, omega: float) -> Measured:
    """The quantity of a joint that is moved by sines at `omega` [rad/s].

    Raises: RobimpError when it does not settle.
    """
    runs = [loop.phasors(omega, given) for given in quantity.inputs]
    at, responses = np.array([omega]), [np.array([amplitudes[quantity.output]]) for amplitudes, _ in runs]
    size = abs(quantity.value(at, *responses)[0])
    return Measured(float(quantity.worse(at, *responses)[0]), float(size), sum(error for _, error in runs))
