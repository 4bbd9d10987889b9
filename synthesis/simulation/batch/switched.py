"""The joint as a family of linear systems, one for each state of its contacts: physics in, flows and rows out.

What switches is left open in one interconnection of all laws, as inputs: the accelerations of load and motor, the
torque applied by the drive, the wall's. Each mode closes them by its own laws, linear equations solved for
all loads at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...spec.model import SeriesElasticActuator, Spec
from ..block import Block, Matrix, combination, connect, integrator
from ..equations import Compensator, Load, actuator_equations, controller_equations
from .dry import INPUTS, Limits

Array = NDArray[np.float64]

OPEN = ("acceleration", "motor_acceleration", "applied", "wall")
EXTERNAL = ("push", "disturbance", "held", "motion")
MODES = 16


@dataclass(frozen=True)
class Imperfections:
    """What the certificate leaves out: Coulomb friction, torque limit, rms torque noise [N·m], encoder step [rad].

    `stiction`: what friction holds at rest, over what it opposes motion with; 1: Coulomb's law.
    """

    load_friction: float = 0.0
    motor_friction: float = 0.0
    torque_limit: float = np.inf
    encoder: float = 0.0
    torque_noise: float = 0.0
    stiction: float = 1.0

    @property
    def linear(self) -> bool:
        """Whether nothing switches."""
        return not (self.load_friction or self.motor_friction) and self.torque_limit == np.inf


@dataclass(frozen=True)
class Wall:
    """A wall that pushes and never pulls: `τ = −max(0, stiffness·(θ−place) + damping·θ')` where θ > place."""

    stiffness: float
    damping: float
    place: float


@dataclass(frozen=True, eq=False)
class Switched:
    """Flows (loads, modes, n, n + m) and rows (loads, modes, 4, n + m) of the joint with each of its loads."""

    modes: tuple[int, ...]
    flows: Array
    rows: Array
    limits: Limits
    states: int
    faults: Imperfections
    environment: slice  # its states


def switched(
    spec: Spec,
    compensator: Compensator | None,
    loads: Sequence[Load] | Array,
    imperfections: Imperfections | None = None,
    *,
    environment: Sequence[Block] = (),
    wall: Wall | None = None,
    driven: bool = False,
) -> Switched:
    """The joint of `spec` with each load, in every mode.

    Args: `compensator`: C of a continuous controller; None: the torque demand is the input `held`. `environment`: laws
    that make `contact_torque` (felt by the sensor) or `unfelt_torque` of theta, velocity, acceleration; none: a free
    port. `driven`: θ'' is prescribed (`motion`) and the port's torque answers.
    """
    faults = imperfections or Imperfections()
    base, before = _base(spec, compensator, environment)
    table = _table(loads)
    actuator = spec.actuator
    motor = None
    if isinstance(actuator, SeriesElasticActuator):
        motor = (float(actuator.motor_inertia), float(actuator.motor_damping))
    modes = _modes(faults, wall, motor is not None)
    closed = [_closed(base, table, motor, wall, mode, driven) for mode in modes]
    flows, rows = (np.stack(part, axis=1) for part in zip(*closed, strict=True))
    limits = Limits(
        faults.load_friction, faults.motor_friction if motor else 0.0, faults.torque_limit,
        *((wall.stiffness, wall.damping, wall.place) if wall else (0.0, 0.0, np.inf)),
        faults.stiction, float(np.sqrt(wall.stiffness / table[:, 0].min())) if wall else 0.0,
    )  # fmt: skip
    its_states = slice(before, before + sum(len(law.A) for law in environment))
    return Switched(modes, flows, rows, limits, len(base.A), faults, its_states)


def _base(spec: Spec, compensator: Compensator | None, environment: Sequence[Block]) -> tuple[Block, int]:
    """All laws but those that switch: states velocity, theta, then the motor's; and how many before the environment."""
    demand = "held" if compensator is None else "tau_d"
    elastic = isinstance(spec.actuator, SeriesElasticActuator)
    actuator = actuator_equations(spec, demand if elastic else "applied")
    actuator = [law for law in actuator if law.outputs != ("motor_acceleration",)]
    if not elastic:
        actuator.append(combination("tau_m", **{demand: 1}))
    body = [integrator("velocity", "acceleration"), integrator("theta", "velocity"), *actuator]
    made = {name for law in environment for name in law.outputs}
    laws = [
        *body,
        combination("tau_int", push=1, contact_torque=1, wall=1),
        combination("tau_load", tau_int=1, tau_sea=1, unfelt_torque=1),
        *(combination(name) for name in ("contact_torque", "unfelt_torque") if name not in made),
        *environment,
        *([] if compensator is None else controller_equations(spec, compensator)),
    ]
    laws += [] if elastic else [combination("motor_velocity")]
    outputs = ("theta", "velocity", "motor_velocity", "tau_int", "tau_load", "tau_sea", "tau_m")
    return connect(laws, inputs=[*OPEN, *EXTERNAL], outputs=outputs), sum(len(law.A) for law in body)


def _table(loads: Sequence[Load] | Array) -> Array:
    if isinstance(loads, np.ndarray):
        return loads
    return np.array([[float(load.inertia), float(load.damping), float(load.stiffness)] for load in loads])


def _modes(faults: Imperfections, wall: Wall | None, motor: bool) -> tuple[int, ...]:
    """The modes that can be entered."""
    bits = 1 if faults.load_friction else 0
    bits |= 2 if faults.motor_friction and motor else 0
    bits |= 4 if faults.torque_limit < np.inf else 0
    bits |= 8 if wall else 0
    return tuple(mode for mode in range(MODES) if mode & ~bits == 0)


def _closed(
    base: Block, table: Array, motor: tuple[float, float] | None, wall: Wall | None, mode: int, driven: bool
) -> tuple[Array, Array]:
    """Flow and rows of one mode, for every load: the open signals by their laws, linear in signals and inputs."""
    n, u, count = len(base.A), len(EXTERNAL), len(table)
    opened = len(OPEN) + 1  # the last: the port's torque, when its motion is prescribed
    width = n + len(INPUTS)
    signal = {name: i for i, name in enumerate(base.outputs)}
    # Signals over (state, inputs) and over what is open.
    known = np.zeros((len(signal), width))
    known[:, :n], known[:, n : n + u] = base.C, base.D[:, len(OPEN) :]
    push = base.D[:, [len(OPEN) + EXTERNAL.index("push")]]
    by_open = np.hstack([base.D[:, : len(OPEN)], push if driven else 0 * push])
    unit = np.eye(width)[n:]
    on = {name: unit[i] for i, name in enumerate(INPUTS)}
    I, B, K = (table[:, i, None] for i in range(3))  # noqa: E741

    def net(parts: Matrix) -> Array:
        """Torque on the load but its inertia and friction: over (state, inputs) or over what is open."""
        return np.asarray(parts[signal["tau_load"]][None] - B * parts[signal["velocity"]] - K * parts[signal["theta"]])

    left = np.zeros((count, opened, opened))  # left · open = right · (state, inputs)
    right = np.zeros((count, opened, width))
    load_known, load_open = net(known) + on["disturbance"], net(by_open)
    law = np.eye(opened)
    if driven:
        left[:, 0], right[:, 0] = law[0], on["motion"]
        left[:, 4], right[:, 4] = I * law[0] - load_open, load_known + on["load_friction"]
    else:
        left[:, 4] = law[4]
        if mode & 1:
            left[:, 0] = law[0]
        else:
            left[:, 0], right[:, 0] = I * law[0] - load_open, load_known + on["load_friction"]
    left[:, 1] = law[1]
    if motor is not None and not mode & 2:
        J, b_m = motor
        left[:, 1] = J * law[1] - law[2] + by_open[signal["tau_sea"]]
        right[:, 1] = on["motor_friction"] - known[signal["tau_sea"]] - b_m * known[signal["motor_velocity"]]
    left[:, 2] = law[2] if mode & 4 else law[2] - by_open[signal["tau_m"]]
    right[:, 2] = on["limit"] if mode & 4 else known[signal["tau_m"]]
    left[:, 3] = law[3]
    if wall is not None and mode & 8:
        right[:, 3] = on["wall_offset"] - wall.stiffness * known[signal["theta"]]
        right[:, 3] -= wall.damping * known[signal["velocity"]]
    solved = np.linalg.solve(left, right)
    flow = np.zeros((count, n, width))
    flow[:, :, :n], flow[:, :, n : n + u] = base.A, base.B[:, len(OPEN) :]
    drive = np.hstack([base.B[:, : len(OPEN)], (base.B[:, [len(OPEN)]] if driven else np.zeros((n, 1)))])
    flow += drive @ solved
    signals = known + by_open @ solved
    holding = -(load_known + np.einsum("lo,low->lw", np.broadcast_to(load_open, (count, opened)), solved))
    motor_holding = np.zeros((count, width))
    if motor is not None:
        b = motor[1]
        motor_holding = signals[:, signal["tau_sea"]] + b * signals[:, signal["motor_velocity"]] - solved[:, 2]
    rows = np.stack([holding, motor_holding, signals[:, signal["tau_m"]], signals[:, signal["tau_int"]]], axis=1)
    return flow, rows
