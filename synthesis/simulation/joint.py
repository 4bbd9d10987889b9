"""Joint and controller as one closed loop, free to move or against a rigid wall."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..spec.model import Spec
from .block import Block, Matrix, balanced, combination, connect
from .equations import Compensator, Load, actuator_equations, controller_equations, load_equations
from .excitation import Excitation
from .march import March, Samples, power_form, propagator

MARGINAL = 1e-10  # a pole closer to the axis than this fraction of the largest is not called stable
OUTPUTS = ("theta", "velocity", "acceleration", "tau_sea", "tau_d")
READ = ("theta", "velocity", "tau_int", "tau_d")


@dataclass(frozen=True, eq=False)
class Poles:
    """Eigenvalues of a closed loop, [rad/s], and how wrong the steps of a held joint may make the worst."""

    values: NDArray[np.complex128]
    error: float = 0.0

    @property
    def worst(self) -> complex | None:
        """The eigenvalue furthest to the right; None for a loop without states."""
        return complex(self.values[np.argmax(self.values.real)]) if self.values.size else None

    @property
    def stable(self) -> bool:
        """Every eigenvalue to the left of the axis, by more than rounding and the error."""
        return self.worst is None or self.worst.real < -max(MARGINAL * float(abs(self.values).max()), self.error)

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
        return poles_of(self.system)

    def march(self, excitation: Excitation, dt: float) -> March:
        """The joint at rest and its excitation, from sample to sample: exact at any dt [s]."""
        system = connect([excitation.generator, self.system])
        rows = {signal: system.row(signal) for signal in READ}
        start = np.concatenate([excitation.start, np.zeros(len(self.A))])
        return March(dt, *propagator(system.A, power_form(rows["tau_int"], rows["velocity"]), dt), start, rows)

    def compliance(self, omega: Samples) -> NDArray[np.complex128]:
        """Steady motion `θ/τ_int` at frequencies (n,) [rad/s]."""
        return resolvent(self.A, self.b[:, None], 1j * omega)[:, :, 0] @ self.system.row("theta")

    def step_error(self, omega: Samples) -> Samples:
        """Relative error of θ/τ_int that marching in steps makes at frequencies (n,) [rad/s]: none."""
        return np.zeros(len(omega))


def free_equations(spec: Spec, compensator: Compensator, load: Load, command: str = "tau_d") -> Block:
    """Joint free to move, `command` the torque demand that reaches the actuator.

    Raises: RobimpError for a singular algebraic loop, InputError for an improper C.
    """
    laws = [*load_equations(load), *actuator_equations(spec, command), *controller_equations(spec, compensator)]
    return balanced(connect(laws, inputs=_inputs("tau_int", command), outputs=OUTPUTS))


def wall_equations(spec: Spec, compensator: Compensator, command: str = "tau_d") -> Block:
    """Joint with θ locked: a rigid wall answers the actuator, `τ_int = −τ_sea`.

    Raises: RobimpError for a singular algebraic loop, InputError for an improper C.
    """
    still = [combination(name) for name in ("theta", "velocity", "acceleration")]
    wall = [*still, combination("tau_int", tau_sea=-1)]
    laws = [*wall, *actuator_equations(spec, command), *controller_equations(spec, compensator)]
    return connect(laws, inputs=_inputs(command), outputs=OUTPUTS)


def resolvent(A: Matrix, B: Matrix, s: NDArray[np.complexfloating[Any, Any]]) -> NDArray[np.complex128]:
    """`(s − A)⁻¹ B` for each s: (n,) gives (n, states, columns)."""
    pencil = s[:, None, None] * np.eye(len(A)) - A
    return np.asarray(np.linalg.solve(pencil, np.broadcast_to(B, (len(s), *B.shape))))


def poles_of(system: Block) -> Poles:
    """Eigenvalues of `x' = A x`."""
    return Poles(np.linalg.eigvals(system.A).astype(complex))


def _inputs(*signals: str) -> list[str]:
    """Signals that no law of the loop makes."""
    return [signal for signal in signals if signal != "tau_d"]
