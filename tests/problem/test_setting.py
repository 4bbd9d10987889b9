"""From a specification to exact models."""

from __future__ import annotations

from fractions import Fraction

import pytest
from written_out import WEIGHT, setting

from robimp.models.actuator import IDEAL
from robimp.models.controller import disturbance_observer, dynamic_error_feedback, low_pass
from robimp.models.impedance import DynamicStiffness
from robimp.models.rational import ONE, RationalFunction, polynomial
from robimp.synthesis.problem.setting import Setting, rational
from robimp.synthesis.spec.model import Polynomials


def test_numbers_arrive_exactly() -> None:
    joint = setting(uncertainty=f"{{box: {{inertia: ±20 %, damping: ±40 %, stiffness: [0, 1/3]}}, weight: {WEIGHT}}}")
    assert joint.loop.nominal == joint.uncertainty.nominal == DynamicStiffness.of("3/100", "1/5", 0)
    assert joint.loop.desired == DynamicStiffness.of("3/100", "7/20", "5/4")
    box = joint.uncertainty.box
    assert box is not None
    assert [str(x) for interval in (box.inertia, box.damping, box.stiffness) for x in interval] == [
        "3/125", "9/250", "3/25", "7/25", "0", "1/3",
    ]  # fmt: skip
    assert joint.uncertainty.weight == RationalFunction.of(["1/2", 1], [1, 20])


def test_without_a_source_it_is_absent() -> None:
    assert setting().uncertainty.weight is None
    assert setting(uncertainty=f"{{weight: {WEIGHT}}}").uncertainty.box is None


def test_actuators() -> None:
    assert setting(actuator="{type: ideal}").loop.actuator == IDEAL
    port = setting().loop.actuator
    assert port.H(0.0) == pytest.approx(1)  # kp and feedforward: (10+1)/(10+1)
    assert port.Z_a(0.0) == 0


@pytest.mark.parametrize(
    ("text", "force", "position", "derivative"),
    [
        ("{}", ONE, None, ONE),
        ("{force: 100}", low_pass(100), None, ONE),
        ("{force: 100, position: none}", low_pass(100), ONE, ONE),
        ("{force: 100, position: 50, derivative: 400}", low_pass(100), low_pass(50), low_pass(400)),
    ],
)
def test_filters(text: str, force: object, position: object, derivative: object) -> None:
    filters = setting(controller=f"{{type: dob, order: 4, filters: {text}}}").loop.filters
    assert (filters.force, filters.position, filters.derivative) == (force, position, derivative)
    assert filters.ratio == (ONE if position is None else position / force)  # type: ignore[operator]


def test_coefficients_are_of_Q_or_of_C_imp() -> None:
    coefficients = Polynomials(numerator=(Fraction(1),), denominator=(Fraction(1), Fraction(2)))
    num, den = polynomial([1]), polynomial([1, 2])
    assert rational(coefficients) == RationalFunction(num, den)
    dob = setting().compensator(coefficients)
    feedback = setting(controller="{type: dynamic-feedback, order: 1}").compensator(coefficients)
    assert (dob, feedback) == (disturbance_observer(num, den), dynamic_error_feedback(num, den))
    assert dob != feedback


def test_a_setting_belongs_to_its_specification() -> None:
    joint = setting()
    assert Setting.of(joint.spec) == joint
    assert Setting.of(setting("{peak: 3}").spec) != joint
