"""A joint as one linear system, free or against a wall, coupled or not, with the hold where the controller is sampled.

Its frequency response says where to look; what is then found is its motion, from step to step: exact, with a hold to
fourth order in the step and with that error known.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from math import ceil

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from ...errors import RobimpError
from ...spec.model import Spec
from ..assembly import lags_of
from ..block import Block, Matrix, balanced, combination, connect, integrator
from ..equations import Compensator, actuator_equations, controller_equations, load_equations, loads
from ..excitation import multisine
from ..held import LONGEST_LINE, ORDER_GAIN, Lags, Steps, held_poles, pair
from ..joint import Poles, poles_of, resolvent
from ..march import Samples, trajectory

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

INPUTS = ("push", "disturbance", "noise", "unfelt")
"""Torque at the port, torque on the load past the sensor, what the sensor makes up, and what Δ adds [N·m]."""
OUTPUTS = ("theta", "tau_int", "applied", "tau_d")  # applied: all torque on the load, which Δ acts on
CYCLE, FEWEST = 64, 8  # samples of a cycle
CYCLES = 4  # that are measured
FADED = 1e-13
SLOWEST = 1e9  # steps until a transient has faded: beyond, their rounding adds up


@dataclass(frozen=True, eq=False)
class Loop:
    """Inputs and outputs as above; with `lags` also the input `held`, which is `tau_d` after hold and delay."""

    system: Block
    lags: Lags | None
    laws: tuple[Block, ...]
    of: str  # load, or wall

    def with_law(self, environment: Sequence[Block]) -> Loop:
        """The same joint in other company."""
        made = {name for law in environment for name in law.outputs}
        kept = tuple(law for law in self.laws if not made & set(law.outputs))
        return _loop((*kept, *environment), self.lags, self.of)

    def response(self, omega: Array, output: str, *inputs: str) -> tuple[Complex, ...]:
        """`output` per each input at frequencies (n,) [rad/s], (n,) each."""
        block, rows = self.system, [OUTPUTS.index(output), OUTPUTS.index("tau_d")]
        values = block.C[rows] @ resolvent(block.A, block.B, 1j * omega) + block.D[rows]
        columns = [INPUTS.index(name) for name in inputs]
        direct = np.asarray(values[:, 0, columns])
        if self.lags:
            s, T = 1j * omega, self.lags.period
            hold = np.exp(-s * self.lags.delay) * -np.expm1(-s * T) / (s * T)  # the mean of a period, a delay ago
            direct += values[:, 0, -1:] * values[:, 1, columns] * (hold / (1 - hold * values[:, 1, -1]))[:, None]
        return tuple(direct.T)

    @cached_property
    def poles(self) -> Poles:
        """Every mode [rad/s]."""
        return poles_of(self.system) if self.lags is None else held_poles(pair(self._with(()), self.lags))

    @property
    def rate(self) -> float:
        """Real part of the worst pole [rad/s]: above 0, motion grows."""
        return -self.poles.decay

    def phasors(self, omega: float, given: str) -> tuple[dict[str, complex], float]:
        """Outputs under a sine of 1 at `omega` [rad/s] on the input `given`, once everything else has faded.

        Returns: complex amplitudes by name, and the relative error that steps with a hold make.
        Raises: RobimpError when it does not settle.
        """
        if not self.poles.stable:
            raise RobimpError("nothing to measure: the joint is unstable")
        found, error = self._phasors(omega, given, 1), 0.0
        if self.lags:
            coarse = self._phasors(omega, given, 2)
            error = max(abs(found[name] / coarse[name] - 1) for name in ("theta", "tau_d") if coarse[name]) / ORDER_GAIN
        return found, error

    def _phasors(self, omega: float, given: str, coarser: int) -> dict[str, complex]:
        sine = multisine([omega])
        driven = connect([replace(sine.generator, outputs=(given,)), self._with((given,))], self._held, None)
        samples = int(np.clip(np.pi / (omega * self._shortest), FEWEST, CYCLE)) // coarser if self.lags else CYCLE
        tick = 2 * np.pi / omega / samples
        step, start = self._steps(driven, tick, coarser, np.append(sine.start, np.zeros(len(self.system.A))))
        settling = ceil(-np.log(FADED) / self.poles.decay / tick)
        if settling > SLOWEST:
            raise RobimpError(f"settles too slowly to be measured at {omega:g} rad/s: decay {self.poles.decay:.3g} /s")
        settled = np.linalg.matrix_power(step, settling) @ start
        course = trajectory(step, settled, samples * CYCLES)[:, : len(driven.A)]
        wave = np.exp(-2j * np.pi / samples * np.arange(len(course)))
        rows = {name: driven.row(name) for name in (given, *OUTPUTS)}
        amplitudes = {name: complex(wave @ (course @ row)) for name, row in rows.items()}
        return {name: value / amplitudes[given] for name, value in amplitudes.items()}

    def alone(self, omega: float, ticks: int, window: int, per_radian: float) -> tuple[float, float]:
        """Largest |θ| in a `window` after the first and the third quarter of the ticks, of a joint thrown and left.

        Against a rigid wall, where nothing turns, the largest |τ_int|.
        """
        tick = max(1 / (per_radian * omega), self._shortest)
        block = self._with(())
        step, start = self._steps(block, tick, 1, np.eye(len(block.A))[0])
        moved = block.row("theta") if block.row("theta").any() else block.row("tau_int")
        moved = np.append(moved, np.zeros(len(step) - len(block.A)))
        with np.errstate(all="ignore"):
            quarter = np.linalg.matrix_power(step, ticks // 4)
            early = quarter @ start
            late = quarter @ (quarter @ early)
            first, last = (abs(trajectory(step, z, window) @ moved).max() for z in (early, late))
        return float(first), float(last)

    def fading(self, e_folds: float, legs: int) -> Array:
        """Rates [/s] at which a joint thrown and left alone dies out, over one leg after the other, (legs − 1,).

        A leg is a whole number of half-cycles of the slowest mode, and about `e_folds` long: what else moved is gone.
        """
        worst = self.poles.worst or 0j
        half = np.pi / abs(worst.imag) if worst.imag else 1 / abs(worst.real or 1.0)
        tick = half * max(1, ceil(self._shortest / half))
        block = self._with(())
        step, z = self._steps(block, tick, 1, np.ones(len(block.A)))
        ticks = max(1, round(e_folds / max(abs(worst.real), 1e-12) / tick))
        leg, rates = np.linalg.matrix_power(step, ticks), []
        for _ in range(legs):
            z = leg @ (z / np.linalg.norm(z[: len(block.A)]))
            rates.append(-np.log(np.linalg.norm(z[: len(block.A)])) / (ticks * tick))
        return np.array(rates[1:])

    def _steps(self, block: Block, tick: float, coarser: int, start: Samples) -> tuple[Matrix, Samples]:
        """One tick [s] of a system, and its start with whatever the hold remembers."""
        if self.lags is None:
            return np.asarray(expm(block.A * tick)), start
        count = ceil(tick / (self.lags.h * coarser))
        steps = Steps(block, replace(self.lags, h=tick / count))
        return np.linalg.matrix_power(steps.transition, count), steps.start(start)

    def _with(self, inputs: tuple[str, ...]) -> Block:
        """The system with only some of its inputs."""
        names = (*inputs, *self._held)
        columns = [self.system.inputs.index(name) for name in names]
        return replace(self.system, inputs=names, B=self.system.B[:, columns], D=self.system.D[:, columns])

    @property
    def _held(self) -> tuple[str, ...]:
        return ("held",) if self.lags else ()

    @property
    def _shortest(self) -> float:
        """Step [s] below which the hold's memory grows long."""
        return (self.lags.period + self.lags.delay) / LONGEST_LINE if self.lags else 0.0


def free(spec: Spec, C: Compensator, load: Array, environment: Sequence[Block] = (), *, frozen: bool = False) -> Loop:
    """The joint with a load (inertia, damping, stiffness), `environment` as for `switched`.

    `frozen`: the paper's A_cl of the nominal load stands between command and load, whatever the load does.
    """
    I, B, K = (Fraction(float(value)) for value in load)  # noqa: E741
    laws = [
        combination("acceleration", tau_load=1 / I, velocity=-B / I, theta=-K / I),
        integrator("velocity", "acceleration"),
        integrator("theta", "velocity"),
        combination("tau_int", push=1, contact_torque=1),
        combination("applied", tau_int=1, tau_sea=1, disturbance=1),
        combination("tau_load", applied=1, unfelt_torque=1, unfelt=1),
        *(combination(name) for name in ("contact_torque", "unfelt_torque")),
        *([_frozen(spec)] if frozen else actuator_equations(spec, _command(spec))),
        *_sensing(controller_equations(spec, C)),
    ]
    alone = _loop(laws, lags_of(spec), f"I={load[0]:.4g} B={load[1]:.4g} K={load[2]:.4g}")
    return alone.with_law(environment) if environment else alone


def locked(spec: Spec, C: Compensator) -> Loop:
    """The joint against a rigid wall, which answers the actuator; a push only loads the wall."""
    still = [combination(name) for name in ("theta", "velocity", "acceleration")]
    laws = [
        *still,
        combination("tau_int", tau_sea=-1),
        combination("applied"),
        *actuator_equations(spec, _command(spec)),
    ]
    return _loop([*laws, *_sensing(controller_equations(spec, C))], lags_of(spec), "rigid wall")


def _loop(laws: Sequence[Block], lags: Lags | None, of: str) -> Loop:
    inputs = (*INPUTS, "held") if lags else INPUTS
    return Loop(balanced(connect(laws, inputs, OUTPUTS)), lags, tuple(laws), of)


def _command(spec: Spec) -> str:
    return "held" if spec.sampling else "tau_d"


def _sensing(laws: Sequence[Block]) -> list[Block]:
    """The control law fed by a torque sensor that is not perfect."""
    fed = [replace(law, inputs=tuple("sensed" if n == "tau_int" else n for n in law.inputs)) for law in laws]
    return [combination("sensed", tau_int=1, noise=1), *fed]


def _frozen(spec: Spec) -> Block:
    """`A_cl`: what the actuator's torque is when it moves the nominal load and nothing else does."""
    laws = [*load_equations(loads(spec)[0]), combination("tau_int"), *actuator_equations(spec, _command(spec))]
    return connect(laws, [_command(spec)], ["tau_sea"])
