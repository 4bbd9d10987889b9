"""Whether the simulated physics and the proof say the same: the job is not done while they differ."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..models.controller import Compensator
from ..models.impedance import DynamicStiffness
from .certificate.claim import Claim
from .certificate.document import robustly_stable
from .certificate.outcome import Outcome
from .problem.setting import Setting
from .simulation import Trial, Trials

IMPEDANCE_TOLERANCE = 1e-6  # relative, beside ten times the measurement's own error estimate
ENERGY_ROUNDING = 1e-9  # of the largest energy exchanged


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
    status = {claim.id: claim.status for claim in claims if claim.required}
    stable = all(status[id] is Outcome.PROVEN for id in ("stability-free", "stability-locked"))
    passive = stable and any(
        c.id == "eq12" and c.form == "structured" and c.interval[1] is None and c.status is Outcome.PROVEN
        for c in claims
    )
    robust = robustly_stable(setting, claims)
    contradictions = []
    if trials.wall_stable != (status["stability-locked"] is Outcome.PROVEN):
        contradictions.append(f"rigid wall: simulated poles {_word(trials.wall_stable)}, stability-locked is otherwise")
    errors: list[float] = []
    energies = [0.0]
    for index, trial in enumerate(trials.trials):
        nominal = trial.load == trials.trials[0].load
        if nominal and trial.stable != (status["stability-free"] is Outcome.PROVEN):
            contradictions.append(f"nominal load: simulated {_word(trial.stable)}, stability-free is otherwise")
        if robust and not trial.stable:
            contradictions.append(f"trial {index} ({trial.kind}): unstable, but stability is proven for every load")
        if trial.min_energy is not None and trial.energy_scale:
            energies.append(trial.min_energy / trial.energy_scale)
            if passive and energies[-1] < -ENERGY_ROUNDING:
                contradictions.append(f"trial {index} ({trial.kind}): energy extracted, but passivity is proven")
        if trial.frequencies:
            load = DynamicStiffness.of(trial.load.inertia, trial.load.damping, trial.load.stiffness)
            predicted = setting.loop.Z(compensator, load).at(np.array(trial.frequencies))
            error = np.abs(np.array(trial.Z_measured) / predicted - 1)
            errors.append(float(error.max()))
            if np.any(error > IMPEDANCE_TOLERANCE + 10 * np.array(trial.accuracy)):
                contradictions.append(f"trial {index} ({trial.kind}): measured Z differs from (★) by {error.max():.2g}")
    unstable = tuple(trial for trial in trials.trials if not trial.stable)
    return Agreement(max(errors, default=None), min(energies), unstable, tuple(contradictions))


def _word(stable: bool) -> str:
    return "stable" if stable else "unstable"
