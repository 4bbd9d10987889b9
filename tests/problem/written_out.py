"""The joint as plain complex numbers at given frequencies, and the specifications to compare it with."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from robimp.models.controller import Compensator, disturbance_observer, eq23
from robimp.models.rational import RationalFunction, descending
from robimp.synthesis.problem.constraints import constraints
from robimp.synthesis.problem.constraints.inequality import Constraint, Inequality, Variable
from robimp.synthesis.problem.grid import Evaluator
from robimp.synthesis.problem.setting import Setting
from robimp.synthesis.spec import parse_spec
from robimp.synthesis.spec.model import IdealActuator

Complex: TypeAlias = NDArray[np.complex128]
Real: TypeAlias = NDArray[np.float64]

SERIES_ELASTIC = (
    "{type: series-elastic, motor_inertia: 0.01, motor_damping: 0.05, spring_stiffness: 4.8, "
    "torque_loop: {kp: 10, kd: 0.25, derivative_corner: 1000, feedforward: 1}}"
)
BOX = "{inertia: ±20 %, damping: ±40 %, stiffness: [0, 0]}"
WEIGHT = "{numerator: [0.5, 1], denominator: [1, 20]}"


def setting(
    constraints_: str = "{}",
    *,
    uncertainty: str = f"{{box: {BOX}}}",
    actuator: str = SERIES_ELASTIC,
    plant: str = "{inertia: 0.03, damping: 0.2, stiffness: 0}",
    impedance: str = "{inertia: nominal, damping: 0.35, stiffness: 1.25}",
    controller: str = "{type: dob, order: 4}",
    objective: str = "{maximize: bandwidth, attenuation: 0.3}",
    sampling: str | None = None,
) -> Setting:
    """The reference joint with what a test changes."""
    sections = {
        "robimp": "1",
        "name": "joint",
        "motion": "rotary",
        "plant": plant,
        "uncertainty": uncertainty,
        "actuator": actuator,
        "impedance": impedance,
        "controller": controller,
        "objective": objective,
        "constraints": constraints_,
    }
    sections |= {} if sampling is None else {"sampling": sampling}
    return Setting.of(parse_spec("\n".join(f"{key}: {value}" for key, value in sections.items())))


def only(setting: Setting, id: str) -> Constraint:
    """The one constraint of this id."""
    (constraint,) = (c for c in constraints(setting) if c.id == id)
    return constraint


def form(setting: Setting, id: str, form: str) -> Constraint:
    (constraint,) = (c for c in constraints(setting) if (c.id, c.form) == (id, form))
    return constraint


def random_controller(setting: Setting, rng: np.random.Generator) -> Compensator:
    """A proper second-order filter, any gain up to 1.5, so that conditions are met in some places and not in others."""
    q = [round(float(x), 3) for x in (rng.uniform(0.2, 1.5), rng.uniform(3, 150), rng.uniform(0.2, 2))]
    return disturbance_observer(*eq23(*map(str, q)))


def variables(setting: Setting, C: Compensator) -> dict[Variable, RationalFunction]:
    loop = setting.loop
    return {Variable.Q: loop.Q_ideal(C), Variable.Q_TILDE: loop.Q_tilde(C), Variable.L: loop.L(C)}


def sides(setting: Setting, inequality: Inequality, v: float, C: Compensator, omega: Real) -> tuple[Real, Real]:
    """Left and right of an inequality as the grid sees them."""
    evaluator = Evaluator(setting, omega)
    W = evaluator.radius(inequality.source)
    X = variables(setting, C)[inequality.variable].at(omega)
    left, right = inequality.sides(v, W, X, lambda r: r.at(omega))
    return np.asarray(left) + 0 * omega, np.asarray(right) + 0 * omega


@dataclass(frozen=True)
class Joint:
    """Every quantity of the equations at s = jω, from the numbers of the specification."""

    setting: Setting
    C: Compensator
    omega: Real

    @property
    def s(self) -> Complex:
        return 1j * self.omega

    def stiffness(self, inertia: float, damping: float, stiffness: float) -> Complex:
        return inertia * self.s**2 + damping * self.s + stiffness

    @property
    def g_hat(self) -> Complex:
        """Ĝ⁻¹."""
        p = self.setting.spec.plant
        return self.stiffness(float(p.inertia), float(p.damping), float(p.stiffness))

    @property
    def G_hat(self) -> Complex:
        return 1 / self.g_hat

    @property
    def G_imp(self) -> Complex:
        p = self.setting.spec.impedance
        return self.stiffness(float(p.inertia), float(p.damping), float(p.stiffness))

    @property
    def Omega(self) -> Complex:
        return self.G_imp * self.G_hat - 1

    @property
    def port(self) -> tuple[Complex, Complex]:
        """H and Z_a."""
        a = self.setting.spec.actuator
        if isinstance(a, IdealActuator):
            return np.ones_like(self.s), np.zeros_like(self.s)
        loop = a.torque_loop
        C_t = float(loop.kp) + float(loop.kd) * self.s / (1 + self.s / float(loop.derivative_corner))
        P_m = 1 / (float(a.motor_inertia) * self.s**2 + float(a.motor_damping) * self.s)
        K_sp = float(a.spring_stiffness)
        below = 1 + K_sp * P_m * (1 + C_t)
        return K_sp * P_m * (C_t + float(loop.feedforward)) / below, K_sp / below

    @property
    def H(self) -> Complex:
        return self.port[0]

    @property
    def Z_a(self) -> Complex:
        return self.port[1]

    @property
    def A_cl(self) -> Complex:
        return self.H * self.g_hat / (self.g_hat + self.Z_a)

    def lag(self, corner: object) -> Complex:
        return np.ones_like(self.s) if corner in (None, "none") else 1 / (1 + self.s / float(corner))  # type: ignore[arg-type]

    @property
    def F(self) -> Complex:
        return self.lag(self.setting.spec.controller.filters.force)

    @property
    def F_theta(self) -> Complex:
        filters = self.setting.spec.controller.filters
        return self.F if filters.position is None else self.lag(filters.position)

    @property
    def F_d(self) -> Complex:
        return self.lag(self.setting.spec.controller.filters.derivative)

    @property
    def gain(self) -> Complex:
        """C."""
        num, den = ([float(c) for c in descending(p)] for p in (self.C.num, self.C.den))
        return np.polyval(num, self.s) / np.polyval(den, self.s)

    @property
    def L(self) -> Complex:
        return self.H * self.gain * self.F

    @property
    def Q(self) -> Complex:
        return self.gain * self.F / (1 + self.gain * self.F)

    @property
    def Q_tilde(self) -> Complex:
        return self.L / (1 + self.L)

    def Z(self, g: Complex) -> Complex:
        """Port on a load `g = G⁻¹`: the equations of motion, not (★)."""
        wish = self.gain * self.F_theta * self.G_imp - self.F_d * (self.g_hat - self.G_imp)
        return (g + self.Z_a + self.H * wish) / (1 + self.L)

    @property
    def W(self) -> Real:
        """Radius of the disc for box and weight, corners deciding where K = 0."""
        box, weight = self.setting.spec.uncertainty.box, self.weight
        if box is None:
            return weight
        loads = itertools.product(*((float(lo), float(hi)) for lo, hi in (box.inertia, box.damping, box.stiffness)))
        radius = np.max([abs(self.g_hat / self.stiffness(*load) - 1) for load in loads], axis=0)
        return np.asarray((1 + radius) * (1 + weight) - 1)

    @property
    def weight(self) -> Real:
        weight = self.setting.spec.uncertainty.weight
        if weight is None:
            return np.zeros_like(self.omega)
        num, den = ([float(c) for c in p] for p in (weight.numerator, weight.denominator))
        return np.abs(np.polyval(num, self.s) / np.polyval(den, self.s))

    def loads(self, rng: np.random.Generator, count: int) -> list[Complex]:
        """G⁻¹ of random loads of the box."""
        box = self.setting.spec.uncertainty.box
        assert box is not None
        intervals = [(float(lo), float(hi)) for lo, hi in (box.inertia, box.damping, box.stiffness)]
        return [self.stiffness(*(rng.uniform(lo, hi) for lo, hi in intervals)) for _ in range(count)]


def disc(radius: Real, points: int = 181) -> Complex:
    """Δ on the rim of `|Δ| ≤ W`, where whatever is fractional linear in Δ has its extremes. Returns (points, n)."""
    return np.asarray(np.exp(1j * np.linspace(0, 2 * np.pi, points))[:, None] * radius)


def ordering(left: Real, right: Real) -> Real:
    """What decides and does not depend on a common positive factor."""
    return np.asarray((right - left) / (abs(right) + abs(left)))
