"""Joints to export controllers for, and the exported law written out again from `export.json`, sample by sample."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from flint import fmpq, fmpq_poly

from robimp.models.controller import Compensator
from robimp.models.rational import exact
from robimp.models.sampling import Hold
from robimp.synthesis.export.law import Law, discretised
from robimp.synthesis.problem.setting import Setting
from robimp.synthesis.spec import parse_spec

GOLDEN = Path(__file__).parents[1] / "data" / "golden"
JOINT = """
robimp: 1
name: joint
motion: rotary
plant: {inertia: 0.03, damping: 0.2, stiffness: 0}
uncertainty: {box: {inertia: ±20 %, damping: ±40 %, stiffness: [0, 0]}}
actuator:
  type: series-elastic
  motor_inertia: 0.01
  motor_damping: 0.05
  spring_stiffness: 4.8
  torque_loop: {kp: 10, kd: 0.25, derivative_corner: 1000, feedforward: 1}
sampling: {rate: 1 kHz, delay: 1 ms}
impedance: {inertia: nominal, damping: 0.35, stiffness: 1.25}
controller: {type: dob, coefficients: {numerator: [2000], denominator: [1, 70.75, 2500]}}
objective: {maximize: bandwidth, attenuation: 0.3}
constraints: {eq9: {}, eq12: {form: structured}, eq18: {form: half-plane, coupling: physical}, peak: 2}
"""
IDEAL = JOINT[: JOINT.index("actuator:")] + "actuator: {type: ideal}\n" + JOINT[JOINT.index("sampling:") :]


def replaced(text: str, *changes: tuple[str, str]) -> str:
    """A specification with some of its text replaced; every piece has to be there."""
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new)
    return text


def setting_of(text: str) -> Setting:
    return Setting.of(parse_spec(text))


def compensator(setting: Setting) -> Compensator:
    coefficients = setting.spec.controller.coefficients
    assert coefficients is not None
    return setting.compensator(coefficients)


def law_of(setting: Setting, precision: str = "double", prewarp: float = 8.0) -> Law:
    hold = setting.loop.actuator.hold
    assert hold is not None
    rate = Fraction(int(hold.period.q), int(hold.period.p))
    return discretised(setting, compensator(setting), rate, precision, prewarp)


def held(setting: Setting, period: str, delay: str) -> Setting:
    """Another hold and delay [s]."""
    return setting.held(Hold(exact(period), exact(delay)))


def in_q(p: fmpq_poly, q: Any) -> Any:
    """A polynomial of z⁻¹ in floats."""
    return sum(float(Fraction(int(c.p), int(c.q))) * q**k for k, c in enumerate(p.coeffs()))


@dataclass
class Drive:
    """The law of an `export.json`, as its text says it, in NumPy's numbers of one precision."""

    document: dict[str, Any]
    number: type = np.float64
    torques: list[Any] = field(default_factory=list)
    angles: list[Any] = field(default_factory=list)

    def __post_init__(self) -> None:
        one = self.number
        self.k = {n: [[one(float(v)) for v in s] for s in f] for n, f in self.document["filters"].items()}
        self.z = {n: [[one(0), one(0)] for _ in f] for n, f in self.k.items()}
        self.nominal, self.desired = (
            [one(float(self.document[g][k])) for k in ("inertia", "damping", "stiffness")]
            for g in ("nominal", "desired")
        )

    def step(self, tau_int: Any, theta: Any) -> Any:
        """One tick without limit of torque."""
        tau_int, theta = self.number(tau_int), self.number(theta)
        if not self.torques:
            self.torques, self.angles = [tau_int] * 2, [theta] * 2
        (t1, t2), (a1, a2) = self.torques, self.angles
        error = self._mean("error", tau_int, t1, t2)
        M, V, A = self._motion("error", theta, a1, a2)
        I, B, K = self.desired  # noqa: E741 (the paper's symbol)
        dynamic = self._filtered("position", (I * A + B * V) + K * M)
        error = self._filtered("force", error) - dynamic
        M, V, A = self._motion("compensated", theta, a1, a2)
        dI, dB, dK = (n - d for n, d in zip(self.nominal, self.desired, strict=True))
        inner = self._filtered("derivative", (dI * A + dB * V) + dK * M)
        self.torques, self.angles = [tau_int, t1], [theta, a1]
        return self._filtered("compensator", error) + inner

    def _mean(self, name: str, x: Any, x1: Any, x2: Any) -> Any:
        return [x, (x + x1) * self.number(0.5), ((x + x2) + 2 * x1) * self.number(0.25)][self.document[name]["r"]]

    def _motion(self, name: str, x: Any, x1: Any, x2: Any) -> tuple[Any, Any, Any]:
        said = self.document[name]
        slope = [3 * (x - x1) - (x1 - x2), x - x1, x - x2][said["r"]]
        velocity, acceleration = (self.number(float(said[k])) for k in ("velocity", "acceleration"))
        return self._mean(name, x, x1, x2), slope * velocity, ((x - x1) - (x1 - x2)) * acceleration

    def _filtered(self, name: str, x: Any) -> Any:
        for (b0, b1, b2, a1, a2), z in zip(self.k[name], self.z[name], strict=True):
            y = b0 * x + z[0]
            z[0] = (b1 * x - a1 * y) + z[1]
            z[1] = b2 * x - a2 * y
            x = y
        return x


def poles(p: Sequence[fmpq]) -> list[complex]:
    return [complex(r) for r in np.roots([float(Fraction(int(c.p), int(c.q))) for c in reversed(list(p))])]
