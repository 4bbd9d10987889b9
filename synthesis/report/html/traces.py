"""A few experiments in the time domain, from the simulation: it shares no formula with the plots over frequency."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.linalg import expm

from ...errors import RobimpError
from ...simulation import Response, assemble, loads, middle_of, multisine_response, step_response
from .curves import least_resistance
from .words import load_names, real

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ...simulation import Joint
    from .study import Study

    Samples = NDArray[np.floating[Any]]

SETTLED, GROWN = 1e-3, 1e6  # a stable joint is shown until it settles, an unstable one until it has grown
LONGEST, POINTS, PERIODS = 60.0, 400, 8  # s; samples; periods of the tone


@dataclass(frozen=True)
class Trace:
    """One load's motion. step: θ [rad] and τ_d [N·m] under 1 N·m; energy: into the port under a tone [J]."""

    name: str
    stable: bool
    step: Response
    tone: Response | None


@dataclass(frozen=True)
class Traces:
    """The trials shown, the tone [rad/s], and the step response of the impedance wished for, (times, θ)."""

    traces: tuple[Trace, ...]
    tone: float
    wish: tuple[Samples, Samples] | None


def simulated(study: Study) -> Traces | None:
    """Nominal load, then the corners of the box, of ranges the middle; None where the motion leaves floating point."""
    spec, tone = middle_of(study.spec), _least_resisted(study)
    try:
        joints = [assemble(spec, study.C, load) for load in loads(spec)]
        names = load_names(loads(spec))
        durations = [_duration(joint) for joint in joints]
        longest = max((d for d, joint in zip(durations, joints, strict=True) if joint.poles.stable), default=None)
        end = longest or max(durations)
        traces = tuple(_trace(name, joint, end, tone) for name, joint in zip(names, joints, strict=True))
    except (RobimpError, OverflowError):
        return None
    return Traces(traces, tone, _wish(study, float(traces[0].step.times[-1])))


def _trace(name: str, joint: Joint, duration: float, tone: float) -> Trace:
    stable = joint.poles.stable
    if not stable:
        duration = min(duration, _duration(joint))
    step = step_response(joint, duration, duration / POINTS)
    period = 2 * np.pi / tone
    energy = multisine_response(joint, [tone], PERIODS * period, PERIODS * period / POINTS) if stable else None
    return Trace(name, stable, step, energy)


def _duration(joint: Joint) -> float:
    """How long [s] a joint's motion is worth looking at."""
    decay = joint.poles.decay
    return float(min(LONGEST, np.log(1 / SETTLED) / decay if decay > 0 else np.log(GROWN) / max(-decay, 1 / LONGEST)))


def _least_resisted(study: Study) -> float:
    """The frequency [rad/s] of the plots' own view at which the port resists least."""
    return float(study.omega[study.inside][np.argmin(least_resistance(study)[study.inside])])


def _wish(study: Study, duration: float) -> tuple[Samples, Samples] | None:
    """Step response of `I θ'' + B θ' + K θ = 1`; None without inertia."""
    wish = study.setting.loop.desired
    I, B, K = (real(v) for v in (wish.inertia, wish.damping, wish.stiffness))  # noqa: E741
    if I <= 0:
        return None
    motion = np.array([[0, 1, 0], [-K / I, -B / I, 1 / I], [0, 0, 0]])  # of (θ, θ', torque)
    times = np.linspace(0, duration, POINTS)
    return times, expm(motion * times[:, None, None])[:, 0, 2]
