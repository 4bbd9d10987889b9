"""What a solver is given and what it answers."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from pathlib import Path
from typing import Any

from robimp.synthesis.problem.grid import frequency_scale
from robimp.synthesis.problem.setting import Setting
from robimp.synthesis.spec import load_spec
from robimp.synthesis.spec.model import Controller, Polynomials

ROOT = Path(__file__).parents[2]
PROBLEMS = {
    "haninger2016": ROOT / "examples" / "haninger2016.yaml",
    "slow-torque-loop": Path(__file__).parent / "problems" / "slow-torque-loop.yaml",
    "stiffness-range": Path(__file__).parent / "problems" / "stiffness-range.yaml",
    "ut-sea": ROOT / "examples" / "ut-sea.yaml",
    "tree-lemon": ROOT / "examples" / "tree-lemon.yaml",
}


@dataclass(frozen=True)
class Task:
    """One problem with an order of Q asked for. limit: seconds of searching."""

    setting: Setting
    order: int
    limit: float

    @classmethod
    def of(cls, spec_file: Path, order: int, limit: float) -> Task:
        """A specification's problem, whatever controller it names."""
        spec = load_spec(spec_file)
        controller = Controller(type="dob", order=order, filters=spec.controller.filters)
        return cls(Setting.of(spec.model_copy(update={"controller": controller})), order, limit)

    @cached_property
    def omega_0(self) -> float:
        """Middle of the frequencies at which anything happens [rad/s]: where everybody starts to look."""
        low, high = frequency_scale(self.setting)
        return math.sqrt(low * high)

    @property
    def attenuation(self) -> float:
        """δ of `|1−Q̃| ≤ δ` on [0, ω_B]."""
        return float(self.setting.spec.objective.attenuation)

    @property
    def peak(self) -> float:
        """Bound on `|1−Q̃|` everywhere."""
        return float(self.setting.spec.constraints.peak or 2)


@dataclass(frozen=True)
class Candidate:
    """A Q that a solver proposes, and the bandwidth [rad/s] it believes to have reached on its own grid."""

    coefficients: Polynomials
    claimed: float | None


@dataclass(frozen=True)
class Answer:
    """What a solver ends with: no candidate if it found none. note: what a reader of the table should know."""

    candidate: Candidate | None
    note: str = ""
    more: dict[str, Any] = field(default_factory=dict)


def exact_q(numerator: Any, denominator: Any) -> Polynomials:
    """Coefficients of Q in descending powers, floats, as the exact numbers with six digits that robimp ships too."""
    lead = float(denominator[0])
    rows = ([Fraction(f"{float(c) / lead:.5e}") for c in row] for row in (numerator, denominator))
    return Polynomials(**{key: tuple(row) for key, row in zip(("numerator", "denominator"), rows, strict=True)})
