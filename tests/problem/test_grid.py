"""The frequency grid and the evaluator on it."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from written_out import WEIGHT, Joint, form, only, setting, variables

from robimp.models.controller import disturbance_observer, eq23
from robimp.models.rational import RationalFunction
from robimp.synthesis.problem.constraints.inequality import Affine, Inequality, Role, Source, Term, Variable, X
from robimp.synthesis.problem.grid import Evaluator, frequency_scale, grid

C = disturbance_observer(*eq23("0.8", 50))


def test_scale_covers_every_corner_frequency() -> None:
    low, high = frequency_scale(setting())
    corners = [1.25**0.5 / 0.03**0.5, 0.28 / 0.024, 0.12 / 0.036, (4.8 / 0.01) ** 0.5]
    assert low <= min(corners)
    assert high >= max(corners)
    wider = frequency_scale(setting(uncertainty=f"{{weight: {WEIGHT.replace('20', '123456')}}}"))
    assert wider[1] >= 123456 > high


def test_scale_of_a_joint_without_dynamics_is_one() -> None:
    """A bare inertia, rendered as itself: no corner frequency at all."""
    bare = "{inertia: 1, damping: 0, stiffness: 0}"
    joint = setting(
        plant=bare, impedance=bare, actuator="{type: ideal}", uncertainty="{weight: {numerator: [1], denominator: [2]}}"
    )
    assert frequency_scale(joint) == (1.0, 1.0)


def test_grid_is_increasing_positive_and_wide() -> None:
    joint = setting()
    low, high = frequency_scale(joint)
    omega = grid(joint)
    assert np.all(np.diff(omega) > 0)
    assert 0 < omega[0] <= low / 29
    assert omega[-1] >= 29 * high
    dense = grid(joint, around=40.0, dense=50)
    near = (dense > 8) & (dense < 200)
    assert near.sum() >= 50 > ((omega > 8) & (omega < 200)).sum()


def test_radius_is_that_of_the_source(rng, omega) -> None:
    joint = setting(uncertainty=f"{{box: {{inertia: ±20 %, damping: ±40 %, stiffness: [0, 0]}}, weight: {WEIGHT}}}")
    w, evaluator = Joint(joint, C, omega), Evaluator(joint, omega)
    np.testing.assert_allclose(evaluator.radius(Source.DISC), w.weight, rtol=1e-9)
    np.testing.assert_allclose(evaluator.radius(Source.LUMPED), w.W, rtol=1e-9)
    assert np.all(w.weight < w.W)


def test_slack_is_relative_to_both_sides_unless_it_is_a_physical_margin() -> None:
    joint, omega = setting("{eq12: {form: structured}, peak: 2}"), np.array([20.0, 50.0])
    values, evaluator = variables(joint, C), Evaluator(setting(), omega)
    sensitivity = abs(1 - Joint(joint, C, omega).Q_tilde)
    slack = evaluator.slack(only(joint, "peak").inequalities[0], 2.0, values)
    np.testing.assert_allclose(slack, (2 - sensitivity) / (2 + sensitivity), rtol=1e-9)
    floor = only(joint, "friction").inequalities[0]
    difference = evaluator.slack(floor, 0.0, values) - evaluator.slack(floor, 0.25, values)
    np.testing.assert_allclose(difference, 0.25)  # N·m·s/rad, not a share


def test_ends_of_the_interval_are_on_the_grid_and_nothing_beyond_counts() -> None:
    joint = setting("{peak: 2}")
    constraint = replace(only(joint, "peak"), band=(Fraction(30), Fraction(70)))
    evaluator = Evaluator(joint, np.geomspace(1, 1000, 20)).with_ends(constraint)
    assert {30.0, 70.0} <= set(evaluator.omega)
    inside = evaluator.omega[evaluator.inside(constraint)]
    assert (inside[0], inside[-1]) == (30.0, 70.0)
    assert Evaluator(joint, np.array([1.0, 1e9])).inside(only(joint, "peak")).all()


def test_worst_finds_inequality_frequency_and_slack() -> None:
    joint = setting("{eq12: {form: structured}}")
    constraint, values = form(joint, "eq12", "structured"), variables(joint, C)
    evaluator = Evaluator(joint, np.geomspace(1, 300, 120))
    slacks = np.array([evaluator.slack(i, 0.0, values) for i in constraint.inequalities])
    index, k = np.unravel_index(slacks.argmin(), slacks.shape)
    assert evaluator.worst(constraint, 0.0, values) == (slacks.min(), evaluator.omega[k], index)
    turned = replace(constraint, inequalities=constraint.inequalities[::-1])
    assert evaluator.worst(turned, 0.0, values)[2] == len(slacks) - 1 - index


def test_what_is_not_a_number_counts_as_worst() -> None:
    """0/0 on the grid may hide anything: it is not passed over."""
    joint = setting("{peak: 2}")
    hidden = RationalFunction.of([1], [1, 0, 4])  # a pole at 2j
    inequality = Inequality(Variable.Q, Role.CEILING, Affine.of(hidden), True, (Term(X * hidden),))
    constraint = replace(only(joint, "peak"), inequalities=(inequality,))
    evaluator = Evaluator(joint, np.array([1.0, 2.0, 3.0]))
    slack, omega, _ = evaluator.worst(constraint, 10.0, variables(joint, C))
    assert (slack, omega) == (-np.inf, 2.0)
    clear = Evaluator(joint, np.array([1.0, 3.0]))
    assert clear.worst(constraint, 10.0, variables(joint, C))[0] > 0


@pytest.mark.parametrize("source", [Source.NONE, Source.DISC])
def test_without_a_weight_its_radius_is_zero(source: Source) -> None:
    assert np.all(Evaluator(setting(), np.array([1.0, 10.0])).radius(source) == 0)
