"""Every load of the specification, put through every experiment."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from ..spec.model import Spec
from .assembly import assemble, poles_against_wall
from .equations import Compensator, Load, loads
from .excitation import Excitation, default_frequencies, multisine, step
from .joint import Joint
from .measure import MeasuredImpedance, measure_impedance
from .response import Response, simulate

Kind = Literal["step", "multisine", "tone"]
KINDS: tuple[Kind, ...] = ("step", "multisine", "tone")

SETTLED = 1e-6
LONGEST = 300.0  # s, of a step response


@dataclass(frozen=True)
class Trial:
    """One experiment on one load; an unstable joint is not moved, and what was not measured is None or empty.

    Energies [J] that entered through the port since rest: the lowest reached, and the largest in either direction.
    Frequencies [rad/s], measured `Z = τ_int/θ` [N·m/rad] and its estimated relative error, for multisine and tone.
    """

    load: Load
    kind: Kind
    stable: bool
    worst_pole: complex | None
    duration: float | None = None
    min_energy: float | None = None
    energy_scale: float | None = None
    frequencies: tuple[float, ...] = ()
    Z_measured: tuple[complex, ...] = ()
    accuracy: tuple[float, ...] = ()

    def to_json(self) -> dict[str, Any]:
        """Plain numbers; complex ones as [real, imaginary]."""
        load = {name: float(getattr(self.load, name)) for name in ("inertia", "damping", "stiffness")}
        return {
            **vars(self),
            "load": load,
            "worst_pole": _pair(self.worst_pole),
            "frequencies": list(self.frequencies),
            "Z_measured": [_pair(Z) for Z in self.Z_measured],
            "accuracy": list(self.accuracy),
        }


@dataclass(frozen=True)
class Trials:
    """All trials of one controller, and its poles against a rigid wall [rad/s]."""

    trials: tuple[Trial, ...]
    wall_stable: bool
    wall_worst_pole: complex | None

    @property
    def stable(self) -> bool:
        """Stable in free motion with every load, and against the wall."""
        return self.wall_stable and all(trial.stable for trial in self.trials)

    def to_json(self) -> dict[str, Any]:
        """Plain numbers; complex ones as [real, imaginary]."""
        wall = {"stable": self.wall_stable, "worst_pole": _pair(self.wall_worst_pole)}
        return {"trials": [trial.to_json() for trial in self.trials], "wall": wall}


def verify(
    spec: Spec, compensator: Compensator, *, quick: bool = False, progress: Callable[[str], None] | None = None
) -> Trials:
    """Move the joint of `spec`, under C (numerator, denominator), with the nominal load and each corner of the box.

    A step, a multisine over `default_frequencies`, and a long tone where the port resists least: the one that draws
    energy out if any does. `quick` measures for a shorter time; `progress` is told of each trial.

    Raises: RobimpError for a singular algebraic loop, InputError for an improper C.
    """
    wall = poles_against_wall(spec, compensator)
    sines = multisine(default_frequencies(spec))
    trials: list[Trial] = []
    for load in loads(spec):
        joint = assemble(spec, compensator, load)
        for kind in KINDS:
            if progress:
                progress(f"{kind}, load {load}")
            trials.append(_trial(joint, kind, sines, quick))
    return Trials(tuple(trials), wall.stable, wall.worst)


def _trial(joint: Joint, kind: Kind, sines: Excitation, quick: bool) -> Trial:
    if not joint.poles.stable:
        return Trial(joint.load, kind, False, joint.poles.worst)
    if kind == "step":
        duration = min(-np.log(SETTLED) / joint.poles.decay, LONGEST)
        return _summary(joint, kind, simulate(joint, step(), duration, duration / (2000 if quick else 20_000)))
    if kind == "multisine":
        return _summary(joint, kind, *measure_impedance(joint, sines, periods=2 if quick else 4))
    tone = multisine([least_resisted(joint, sines.frequencies.min(), sines.frequencies.max())])
    return _summary(joint, kind, *measure_impedance(joint, tone, periods=60 if quick else 300))


def _summary(joint: Joint, kind: Kind, response: Response, measured: MeasuredImpedance | None = None) -> Trial:
    trial = Trial(
        joint.load, kind, True, joint.poles.worst,
        float(response.times[-1]), float(response.energy.min()), response.energy_scale,
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


def _pair(value: complex | None) -> list[float] | None:
    return None if value is None else [value.real, value.imag]
