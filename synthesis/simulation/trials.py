"""Every load of the specification, in every member of its ranges, put through every experiment."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ..spec.model import Spec
from .assembly import assemble, poles_against_wall
from .equations import Compensator, loads
from .excitation import Excitation, default_frequencies, multisine, step
from .joint import Joint
from .measure import MeasuredImpedance, measure_impedance
from .members import Member, extremes, members
from .response import Response, simulate
from .trial import KINDS, Kind, Trial, Trials, Wall

SETTLED = 1e-6
LONGEST = 300.0  # s, of a step response
MEASURED: tuple[Kind, ...] = ("multisine", "tone")  # what a quick look at the ends of the ranges consists of


def verify(
    spec: Spec, compensator: Compensator, *, quick: bool = False, progress: Callable[[str], None] | None = None
) -> Trials:
    """Move the joint of `spec`, under C (numerator, denominator), with the nominal load and each corner of the box.

    A step, a multisine over `default_frequencies`, and a long tone where the port resists least: the one that draws
    energy out if any does. Ranges of impedances and actuators: the middle so, and their ends with the nominal and two
    extreme loads. `quick` measures for a shorter time; `progress` is told of each trial.

    Raises: RobimpError for a singular algebraic loop, InputError for an improper C.
    """
    trials: list[Trial] = []
    walls: list[Wall] = []
    first, *others = members(spec)
    nominal = poles_against_wall(first.spec, compensator)
    for member in (first, *others):
        sines = multisine(default_frequencies(member.spec))
        for load in loads(spec) if member is first else extremes(spec):
            joint = assemble(member.spec, compensator, load)
            for kind in MEASURED if quick and member is not first else KINDS:
                if progress:
                    progress(f"{kind}, load {load}{member}")
                trial = _trial(joint, kind, sines, quick)
                trials.append(replace(trial, impedance=member.impedance, actuator=member.drive))
        if member is not first and member.drive and member.drive not in {wall.actuator for wall in walls}:
            walls.append(_wall(member, compensator))
    return Trials(tuple(trials), nominal.stable, nominal.worst, tuple(walls))


def _wall(member: Member, compensator: Compensator) -> Wall:
    assert member.drive is not None
    poles = poles_against_wall(member.spec, compensator)
    return Wall(member.drive, poles.stable, poles.worst)


def _trial(joint: Joint, kind: Kind, sines: Excitation, quick: bool) -> Trial:
    if not joint.poles.stable:
        return Trial(joint.load, kind, False, joint.poles.worst)
    if kind == "step":
        duration = min(-np.log(SETTLED) / joint.poles.decay, LONGEST)
        response = simulate(joint, step(), duration, duration / (2000 if quick else 20_000))
        return _summary(joint, kind, response, sines)
    if kind == "multisine":
        return _summary(joint, kind, *_measured(joint, sines, 2 if quick else 4))
    tone = multisine([least_resisted(joint, sines.frequencies.min(), sines.frequencies.max())])
    return _summary(joint, kind, *_measured(joint, tone, 60 if quick else 300))


def _measured(joint: Joint, sines: Excitation, periods: float) -> tuple[Response, Excitation, MeasuredImpedance]:
    response, measured = measure_impedance(joint, sines, periods)
    return response, sines, measured


def _summary(
    joint: Joint, kind: Kind, response: Response, sines: Excitation, measured: MeasuredImpedance | None = None
) -> Trial:
    duration = float(response.times[-1])
    # A relative error of Z is, at worst, that part of the energy that goes in and out of the port, at every radian.
    drift = float((joint.step_error(sines.frequencies) * sines.frequencies).max()) * duration
    trial = Trial(
        joint.load, kind, True, joint.poles.worst, duration, float(response.energy.min()), response.energy_scale,
        energy_error=drift,
    )  # fmt: skip
    if measured is None:
        return trial
    return replace(
        trial,
        frequencies=tuple(measured.frequencies.tolist()),
        Z_measured=tuple(measured.Z.tolist()),
        accuracy=tuple(measured.accuracy.tolist()),
    )


def least_resisted(joint: Joint, low: float, high: float, count: int = 1000) -> float:
    """Frequency in [low, high] [rad/s] where the resistance `Re(τ_int/θ')` of the motion is smallest, on a log grid."""
    omega = np.geomspace(low, high, count)
    resistance = (1 / (1j * omega * joint.compliance(omega))).real
    return float(omega[np.argmin(resistance)])
