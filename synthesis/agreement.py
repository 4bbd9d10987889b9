"""Whether the simulated physics and the proof say the same: the job is not done while they differ."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from flint import fmpq

from ..models.controller import Compensator
from ..models.impedance import DynamicStiffness
from ..models.rational import exact
from .certificate.claim import Claim
from .certificate.document import robustly_stable
from .certificate.outcome import Outcome
from .problem.setting import Setting
from .simulation import Trial, Trials

if TYPE_CHECKING:
    from numpy.typing import NDArray

IMPEDANCE_TOLERANCE = 1e-6  # relative, beside ten times the measurement's own error estimate
ENERGY_ROUNDING = 1e-9  # of the largest energy exchanged
NOMINAL = ("hurwitz", "winding")  # forms of the stability of the nominal joint
CONTRARY = {True: Outcome.REFUTED, False: Outcome.PROVEN}  # what a simulated joint's being stable contradicts


@dataclass(frozen=True)
class Agreement:
    """Worst figures of the comparison, and every contradiction in words."""

    impedance_error: float | None  # relative; None when nothing could be measured
    lowest_energy: float
    unstable: tuple[Trial, ...]  # trials that were not moved
    contradictions: tuple[str, ...]

    def summary(self, trials: int) -> str:
        """One line for a person."""
        if self.impedance_error is None:
            return f"agrees that the joint is unstable: {len(self.unstable)} of {trials} trials, nothing to measure"
        return (
            f"{trials} trials agree, measured Z within {self.impedance_error:.1g} of (★), "
            f"lowest port energy {self.lowest_energy:.1g} of the largest"
            + (f"; {len(self.unstable)} of them unstable" if self.unstable else "")
        )


def compare(setting: Setting, compensator: Compensator, claims: tuple[Claim, ...], trials: Trials) -> Agreement:
    """Compare trials with the claims, and the measured impedance with (★) at the excited frequencies."""
    proven = Proven.by(setting, claims)
    contradictions = [*_against_wall(proven, trials)]
    errors: list[float] = []
    energies = [0.0]
    for index, trial in enumerate(trials.trials):
        name = f"trial {index} ({trial.kind})"
        nominal = _joint(trial) == _joint(trials.trials[0])
        if nominal and proven.free is CONTRARY[trial.stable]:
            contradictions.append(f"nominal load: simulated {_word(trial.stable)}, stability-free is otherwise")
        if proven.every and not trial.stable:
            contradictions.append(f"{name}: unstable, but stability is proven for every {proven.every}")
        if trial.min_energy is not None and trial.energy_scale:
            energies.append(trial.min_energy / trial.energy_scale)
            if proven.passive and energies[-1] < -ENERGY_ROUNDING - 10 * trial.energy_error:
                contradictions.append(f"{name}: energy extracted, but passivity is proven")
        if trial.frequencies:
            error = np.abs(np.array(trial.Z_measured) / predicted(setting, compensator, trial) - 1)
            errors.append(float(error.max()))
            if np.any(error > IMPEDANCE_TOLERANCE + 10 * np.array(trial.accuracy)):
                contradictions.append(f"{name}: measured Z differs from (★) by {error.max():.2g}")
    unstable = tuple(trial for trial in trials.trials if not trial.stable)
    return Agreement(max(errors, default=None), min(energies), unstable, tuple(contradictions))


@dataclass(frozen=True)
class Proven:
    """What the claims say that a simulation can contradict; `every`: what stability is proven for, "" for nominal."""

    free: Outcome
    locked: Outcome
    every: str
    every_actuator: bool
    passive: bool

    @classmethod
    def by(cls, setting: Setting, claims: tuple[Claim, ...]) -> Proven:
        """From the required claims of stability, and passivity on the whole axis."""
        status = {(c.id, c.form): c.status for c in claims if c.required}
        free, locked = (
            next(status[key] for form in NOMINAL if (key := (f"stability-{end}", form)) in status)
            for end in ("free", "locked")
        )
        boxed = {end for end in ("free", "locked") if status.get((f"stability-{end}", "box")) is Outcome.PROVEN}
        stable = {end for end, is_ in (("free", free), ("locked", locked)) if is_ is Outcome.PROVEN}
        every = "joint of the boxes" if "free" in boxed & stable else ""
        every = every or ("load" if robustly_stable(setting, claims) else "")
        passive = any(
            c.id == "eq12" and c.form == "structured" and c.interval[1] is None and c.status is Outcome.PROVEN
            for c in claims
        )
        return cls(free, locked, every, "locked" in boxed & stable, len(stable) == 2 and passive)


def predicted(setting: Setting, compensator: Compensator, trial: Trial) -> NDArray[np.complex128]:
    """(★) for the trial's own joint at its frequencies."""
    load = DynamicStiffness.of(trial.load.inertia, trial.load.damping, trial.load.stiffness)
    loop = setting.at(_parameters(setting, trial)).loop
    return loop.Z_at(compensator, load, np.array(trial.frequencies))


def _parameters(setting: Setting, trial: Trial) -> dict[str, fmpq]:
    """Where in the ranges the trial's joint is, in the words of `Setting.at`."""
    of = {"impedance": (trial.impedance, setting.impedances), "actuator": (trial.actuator, setting.actuators)}
    return {
        f"{kind}.{name}": exact(getattr(values, name))
        for kind, (values, names) in of.items() if values is not None for name in names
    }  # fmt: skip


def _against_wall(proven: Proven, trials: Trials) -> Iterator[str]:
    if proven.locked is CONTRARY[trials.wall_stable]:
        yield f"rigid wall: simulated poles {_word(trials.wall_stable)}, stability-locked is otherwise"
    for wall in trials.other_walls:
        if proven.every_actuator and not wall.stable:
            yield f"rigid wall: simulated poles unstable with {wall.actuator}, stability-locked is proven for the box"


def _joint(trial: Trial) -> tuple[object, ...]:
    return trial.load, trial.impedance, trial.actuator


def _word(stable: bool) -> str:
    return "stable" if stable else "unstable"
