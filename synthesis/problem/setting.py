"""The physical side of a specification: its models, exact."""

from __future__ import annotations

from dataclasses import dataclass

from flint import fmpq

from ...models.actuator import IDEAL, SeriesElastic, TwoPort, torque_loop
from ...models.closed_loop import ImpedanceLoop
from ...models.controller import Compensator, Filters, disturbance_observer, dynamic_error_feedback, low_pass
from ...models.impedance import DynamicStiffness, LoadBox
from ...models.rational import ONE, RationalFunction, exact, polynomial
from ...models.uncertainty import Uncertainty
from ..spec.model import Filters as FilterSpec
from ..spec.model import IdealActuator, Impedance, Interval, Plant, Polynomials, Spec


@dataclass(frozen=True)
class Setting:
    """A specification with the models it describes."""

    spec: Spec
    loop: ImpedanceLoop
    uncertainty: Uncertainty

    @classmethod
    def of(cls, spec: Spec) -> Setting:
        """Build the models a specification describes."""
        nominal = _stiffness(spec.plant)
        box = spec.uncertainty.box
        return cls(
            spec,
            ImpedanceLoop(_actuator(spec), nominal, _stiffness(spec.impedance), _filters(spec.controller.filters)),
            Uncertainty(
                nominal,
                None if box is None else LoadBox(_pair(box.inertia), _pair(box.damping), _pair(box.stiffness)),
                None if spec.uncertainty.weight is None else rational(spec.uncertainty.weight),
            ),
        )

    def compensator(self, coefficients: Polynomials) -> Compensator:
        """The compensator C a controller's coefficients (of Q or of C_imp) stand for."""
        num, den = polynomial(coefficients.numerator), polynomial(coefficients.denominator)
        build = disturbance_observer if self.spec.controller.type == "dob" else dynamic_error_feedback
        return build(num, den)


def rational(coefficients: Polynomials) -> RationalFunction:
    """Coefficients of a specification as a rational function."""
    return RationalFunction.of(coefficients.numerator, coefficients.denominator)


def _pair(interval: Interval) -> tuple[fmpq, fmpq]:
    return exact(interval[0]), exact(interval[1])


def _stiffness(section: Plant | Impedance) -> DynamicStiffness:
    return DynamicStiffness.of(section.inertia, section.damping, section.stiffness)


def _actuator(spec: Spec) -> TwoPort:
    a = spec.actuator
    if isinstance(a, IdealActuator):
        return IDEAL
    loop = a.torque_loop
    C_t = torque_loop(loop.kp, loop.kd, loop.derivative_corner)
    return SeriesElastic(
        exact(a.motor_inertia), exact(a.motor_damping), exact(a.spring_stiffness), C_t, exact(loop.feedforward)
    ).two_port


def _filters(spec: FilterSpec) -> Filters:
    def first_order(corner: object) -> RationalFunction:
        return ONE if corner is None or corner == "none" else low_pass(corner)  # type: ignore[arg-type]

    position = None if spec.position is None else first_order(spec.position)
    return Filters(first_order(spec.force), position, first_order(spec.derivative))
