"""Load-side Coulomb friction: `s(1−Q̃)/Z` strictly positive real."""

from __future__ import annotations

import numpy as np
import pytest
from written_out import WEIGHT, Joint, disc, only, random_controller, setting, sides

from robimp.models.controller import disturbance_observer, eq23
from robimp.synthesis.problem.constraints.inequality import Role, Variable


def floor(joint, C, omega: np.ndarray, v: float = 0.0) -> np.ndarray:
    pairs = (sides(joint, i, v, C, omega) for i in only(joint, "friction").inequalities)
    return np.min([right - left for left, right in pairs], axis=0)


def test_it_is_the_real_part_of_the_inverse_over_the_box(rng, omega, controller) -> None:
    joint = setting(controller=controller)
    C = random_controller(joint, rng)
    w = Joint(joint, C, omega)
    least = floor(joint, C, omega)
    inverses = np.array([w.Z(g) / (w.s * (1 - w.Q_tilde)) for g in w.loads(rng, 300)])
    scale = 1 + abs(inverses).max(axis=0)
    assert np.all(least / scale <= inverses.real.min(axis=0) / scale + 1e-9)
    np.testing.assert_allclose(least / scale, inverses.real.min(axis=0) / scale, atol=0.05)
    # A function is positive real where its inverse is.
    assert np.all(((1 / inverses).real > 0) == (inverses.real > 0))


def test_a_weight_adds_its_disc(rng, omega) -> None:
    joint = setting(uncertainty=f"{{weight: {WEIGHT}}}")
    C = random_controller(joint, rng)
    w = Joint(joint, C, omega)
    inverse = w.Z(w.g_hat / (1 + disc(w.weight, 1441))) / (w.s * (1 - w.Q_tilde))
    scale = 1 + abs(inverse).max(axis=0)
    np.testing.assert_allclose(floor(joint, C, omega) / scale, inverse.real.min(axis=0) / scale, atol=1e-4)


@pytest.mark.parametrize(("alpha", "hunts"), [("0.8", False), ("1", True)])
def test_an_integrator_against_stiction_hunts(alpha: str, hunts: bool) -> None:
    """`Q(0) = 1` breaks it at ω → 0 for K_imp > 0; the paper's α = 0.8 does not."""
    joint = setting()
    C = disturbance_observer(*eq23(alpha, 50))
    assert bool(floor(joint, C, np.array([1e-4]))[0] < 0) is hunts


def test_reported_always_required_on_request() -> None:
    assert not only(setting(), "friction").required
    constraint = only(setting("{friction: require}"), "friction")
    assert (constraint.level, constraint.strict, constraint.role) == (0, True, Role.FLOOR)
    assert {i.variable for i in constraint.inequalities} == {Variable.L}
