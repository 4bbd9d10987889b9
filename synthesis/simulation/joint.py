"""Joint and controller as one closed loop, free to move or against a rigid wall."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..spec.model import Spec
from .block import Block, Matrix, balanced, combination, connect
from .equations import Compensator, Load, actuator_equations, controller_equations, load_equations

MARGINAL = 1e-10  # a pole closer to the axis than this fraction of the largest is not called stable
OUTPUTS = ("theta", "velocity", "acceleration", "tau_sea", "tau_d")


@dataclass(frozen=True, eq=False)
class Poles:
    """Eigenvalues of a closed loop, [rad/s]."""

    values: NDArray[np.complex128]

    @property
    def worst(self) -> complex | None:
        """The eigenvalue furthest to the right; None for a loop without states."""
        return complex(self.values[np.argmax(self.values.real)]) if self.values.size else None

    @property
    def stable(self) -> bool:
        """Every eigenvalue to the left of the axis, by more than rounding."""
        return self.worst is None or self.worst.real < -MARGINAL * float(abs(self.values).max())

    @property
    def decay(self) -> float:
        """Decay rate of the slowest mode [rad/s]; not positive when unstable."""
        return np.inf if self.worst is None else -self.worst.real


@dataclass(frozen=True, eq=False)
class Joint:
    """Physical joint and controller as one linear system: input τ_int, outputs θ, θ', θ'', τ_sea, τ_d."""

    load: Load
    system: Block

    @property
    def A(self) -> Matrix:
        """State matrix of `x' = A x + b τ_int`, (n, n)."""
        return self.system.A

    @property
    def b(self) -> Matrix:
        """Input vector of `x' = A x + b τ_int`, (n,)."""
        return np.asarray(self.system.B[:, 0])

    @cached_property
    def poles(self) -> Poles:
        """Poles in free motion."""
        return _poles(self.system)


def assemble(spec: Spec, compensator: Compensator, load: Load) -> Joint:
    """The joint that `spec` describes, carrying `load`, under the controller with compensator C.

    Raises: RobimpError for a singular algebraic loop, InputError for an improper C.
    """
    blocks = [*load_equations(load), *actuator_equations(spec), *controller_equations(spec, compensator)]
    return Joint(load, balanced(connect(blocks, inputs=["tau_int"], outputs=OUTPUTS)))


def poles_against_wall(spec: Spec, compensator: Compensator) -> Poles:
    """Poles with θ locked: a rigid wall answers the actuator, `τ_int = −τ_sea`.

    Raises: RobimpError for a singular algebraic loop, InputError for an improper C.
    """
    still = [combination(name) for name in ("theta", "velocity", "acceleration")]
    wall = [*still, combination("tau_int", tau_sea=-1)]
    return _poles(connect([*wall, *actuator_equations(spec), *controller_equations(spec, compensator)]))


def _poles(system: Block) -> Poles:
    return Poles(np.linalg.eigvals(system.A).astype(complex))
