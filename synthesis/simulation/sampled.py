"""What sampling the controller would change: information beside the continuous simulation, not part of any claim.

The controller runs as it would on a drive. At each tick it reads τ_int and the encoder's θ, forms θ' and θ'' by
backward differences, advances its filters and C by Tustin's rule, and holds τ_d until the next tick; `delay` ticks may
pass between reading and output. The torque loop belongs to the drive and stays continuous. The joint between ticks is
exact.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from math import ceil, log

import numpy as np
from scipy.linalg import expm

from ..spec.model import Spec
from .assembly import assemble
from .block import Block, combination, connect
from .equations import Compensator, actuator_equations, controller_equations, load_equations, loads
from .march import Samples, trajectory
from .members import middle_of
from .response import step_response

RATE = 1000.0  # Hz, where the specification has none
TICKS = 60_000  # longest comparison
SETTLED = 1e-6


@dataclass(frozen=True)
class SampledComparison:
    """Nominal load, controller sampled at `rate` [Hz] with `delay` ticks of computation, against the simulated loop.

    `rms_difference` and `rms_theta` [rad] are over the response to a step of 1 N·m of length `duration` [s]; None when
    either loop is unstable.
    """

    rate: float
    delay: int
    spectral_radius: float
    stable: bool
    duration: float | None
    rms_difference: float | None
    rms_theta: float | None

    def to_json(self) -> dict[str, float | int | bool | None]:
        """Plain numbers."""
        return asdict(self)


def sampled_comparison(
    spec: Spec, compensator: Compensator, rate: float | None = None, delay: int | None = None
) -> SampledComparison:
    """Stability and step response of the sampled loop, of a range its middle; `rate` [Hz], `delay` [ticks].

    By default those of the specification, a delay of no whole ticks rounded up; 1 kHz and no delay where it says none.
    With a hold in the specification the other loop is the one with that hold and delay: what the claims are about.

    Raises: RobimpError for a singular algebraic loop, InputError for an improper C.
    """
    spec, sampling = middle_of(spec), spec.sampling
    rate = rate or (float(sampling.rate) if sampling else RATE)
    delay = delay if delay is not None else ceil(sampling.delay * sampling.rate) if sampling else 0
    loop = _sampled_loop(spec, compensator, 1 / rate, delay)
    radius = float(abs(np.linalg.eigvals(loop.A)).max())
    joint = assemble(spec, compensator, loads(spec)[0])
    if radius >= 1 or not joint.poles.stable:
        return SampledComparison(rate, delay, radius, radius < 1, None, None, None)
    duration = min(-log(SETTLED) / joint.poles.decay, TICKS / rate)
    continuous = step_response(joint, duration, 1 / rate)
    ticks = np.arange(ceil(continuous.times[-1] * rate) + 1)
    stepped = np.interp(continuous.times * rate, ticks, _step(loop, len(ticks)))
    return SampledComparison(
        rate, delay, radius, True, duration, _rms(stepped - continuous.theta), _rms(continuous.theta)
    )


def sampled_step(spec: Spec, compensator: Compensator, ticks: int, rate: float = 1000.0, delay: int = 0) -> Samples:
    """θ [rad] of the nominal joint at each tick, (ticks,), from rest under 1 N·m, with the sampled controller."""
    return _step(_sampled_loop(spec, compensator, 1 / rate, delay), ticks)


def _step(loop: Block, ticks: int) -> Samples:
    one = np.ones((1, 1))
    torque = Block((), ("tau_int",), one, np.zeros((1, 0)), one, np.zeros((1, 0)))
    driven = connect([torque, loop])
    return trajectory(driven.A, np.eye(len(driven.A))[0], ticks) @ driven.row("theta")


def _sampled_loop(spec: Spec, compensator: Compensator, tick: float, delay: int) -> Block:
    """Joint and sampled controller from tick to tick: input τ_int, output θ."""
    equations = [*load_equations(loads(spec)[0]), *actuator_equations(spec)]
    joint = _held(connect(equations, ["tau_int", "tau_d"], ["theta"]), tick)
    law = controller_equations(spec, compensator)
    controller = tustin(connect(law, ["tau_int", "theta", "velocity", "acceleration"], ["tau_d"]), tick)
    held = _delayed("held", "tau_d", delay)
    return connect(
        [replace(joint, inputs=("tau_int", "held")), differences(tick), controller, held], ["tau_int"], ["theta"]
    )


def _held(block: Block, tick: float) -> Block:
    """Exact step of a system whose inputs are held over the tick."""
    n, m = block.B.shape
    exponential = expm(tick * np.block([[block.A, block.B], [np.zeros((m, n + m))]]))
    return replace(block, A=exponential[:n, :n], B=exponential[:n, n:])


def tustin(block: Block, tick: float) -> Block:
    """Trapezoidal rule, `s → 2/T · (z−1)/(z+1)`."""
    half = tick / 2 * block.A
    resolvent = np.linalg.inv(np.eye(len(half)) - half)
    return replace(
        block,
        A=resolvent @ (np.eye(len(half)) + half),
        B=tick * resolvent @ block.B,
        C=block.C @ resolvent,
        D=block.D + tick / 2 * block.C @ resolvent @ block.B,
    )


def differences(tick: float) -> Block:
    """`θ'_k = (θ_k − θ_{k−1})/T`, `θ''_k = (θ_k − 2θ_{k−1} + θ_{k−2})/T²`."""
    past = np.array([[-1 / tick, 0.0], [-2 / tick**2, 1 / tick**2]])
    now = np.array([[1 / tick], [1 / tick**2]])
    return Block(("theta",), ("velocity", "acceleration"), np.eye(2, k=-1), np.eye(2, 1), past, now)


def _delayed(output: str, signal: str, ticks: int) -> Block:
    """`output_k = signal_{k−ticks}`."""
    if ticks == 0:
        return combination(output, **{signal: 1})
    return Block((signal,), (output,), np.eye(ticks, k=-1), np.eye(ticks, 1), np.eye(ticks)[-1:], np.zeros((1, 1)))


def _rms(values: Samples) -> float:
    return float(np.sqrt(np.mean(values**2)))
