"""(9), robust stability behind an ideal actuator: `W|Ω+Q| < |1+Ω|`."""

from __future__ import annotations

import numpy as np
import pytest
from written_out import Joint, disc, only, ordering, random_controller, setting, sides

from robimp.synthesis.problem.constraints.inequality import Role, Variable
from robimp.synthesis.problem.constraints.small_gain import compensated_error

UNCERTAINTIES = [
    "{box: {inertia: ±20 %, damping: ±40 %, stiffness: [0, 0]}}",
    "{weight: {numerator: [0.5, 1], denominator: [1, 20]}}",
    "{box: {inertia: ±20 %, damping: ±40 %, stiffness: [0, 0]}, weight: {numerator: [0.2, 1], denominator: [1, 20]}}",
]


@pytest.mark.parametrize("uncertainty", UNCERTAINTIES, ids=["box", "weight", "both"])
def test_multiplied_by_the_model_it_is_the_printed_inequality(rng, omega, uncertainty) -> None:
    joint = setting("{eq9: {}}", uncertainty=uncertainty)
    C = random_controller(joint, rng)
    w = Joint(joint, C, omega)
    (inequality,) = only(joint, "eq9").inequalities
    for v in (1.0, 0.4, 2.5):
        left, right = sides(joint, inequality, v, C, omega)
        np.testing.assert_allclose(left, v * w.W * abs(w.Omega + w.Q) * abs(w.g_hat), rtol=1e-9)
        np.testing.assert_allclose(right, abs(1 + w.Omega) * abs(w.g_hat), rtol=1e-9)
    printed = ordering(w.W * abs(w.Omega + w.Q), abs(1 + w.Omega))
    np.testing.assert_allclose(ordering(*sides(joint, inequality, 1.0, C, omega)), printed, atol=1e-9)
    without_wish = ordering(w.W * abs(w.Q), abs(1 + w.Omega))
    assert not np.allclose(without_wish, printed, atol=1e-3)


def test_eq6_is_the_case_without_observer(rng, omega) -> None:
    joint = setting("{eq9: {}}")
    (inequality,) = only(joint, "eq9").inequalities
    w = Joint(joint, random_controller(joint, rng), omega)
    left, right = inequality.sides(1.0, w.W, np.zeros_like(w.s), lambda r: r.at(omega))
    np.testing.assert_allclose(left / right, w.W * abs(w.Omega) / abs(1 + w.Omega), rtol=1e-9)


def test_it_is_exact_over_the_disc_with_any_filters(rng, omega, controller) -> None:
    """It holds iff no Δ of the disc makes `1 − Q + (1+Δ)T` zero; with filters the nominal loop is still `1 − Q + T`."""
    joint = setting("{eq9: {}}", controller=controller)
    C = random_controller(joint, rng)
    w = Joint(joint, C, omega)
    (inequality,) = only(joint, "eq9").inequalities
    left, right = sides(joint, inequality, 1.0, C, omega)
    T = (w.Q * w.F_theta / w.F * w.G_imp - (1 - w.Q) * w.F_d * (w.g_hat - w.G_imp)) * w.G_hat
    nearest = np.abs(1 - w.Q + (1 + disc(w.W, 721)) * T).min(axis=0)
    margin = (right - left) / abs(w.g_hat)
    np.testing.assert_allclose(nearest, abs(margin), atol=2e-2 * (w.W * abs(T)).max(), rtol=1e-3)
    np.testing.assert_allclose(nearest[margin > 0], margin[margin > 0], atol=1e-4, rtol=1e-4)


def test_it_can_fail_and_says_where() -> None:
    """A filter of gain 1.5 at the load's own resonance of model error."""
    joint = setting("{eq9: {}}", uncertainty="{weight: {numerator: [3], denominator: [1]}}")
    rng, omega = np.random.default_rng(0), np.geomspace(0.1, 1e3, 50)
    C = random_controller(joint, rng)
    left, right = sides(joint, only(joint, "eq9").inequalities[0], 1.0, C, omega)
    assert np.any(left > right)
    assert np.any(left < right)


def test_no_pole_at_zero_for_a_load_without_stiffness() -> None:
    joint = setting("{eq9: {}}")
    C = random_controller(joint, np.random.default_rng(0))
    left, right = sides(joint, only(joint, "eq9").inequalities[0], 1.0, C, np.array([1e-9]))
    assert np.isfinite([left, right]).all()
    assert right[0] == pytest.approx(1.25)  # G_imp(0)
    assert Joint(joint, C, np.array([0.0])).g_hat == 0  # by which the printed form divides there


def test_what_it_is_about(controller) -> None:
    constraint = only(setting("{eq9: {}}", controller=controller), "eq9")
    assert (constraint.equation, constraint.level, constraint.role) == ("(9)", 1, Role.RADIUS)
    assert constraint.inequalities[0].variable is Variable.Q
    assert constraint.strict
    assert constraint.inequalities[0].convex is ("derivative" not in controller)


def test_compensated_error_is_omega_plus_q_times_the_model(rng, omega) -> None:
    joint = setting()
    C = random_controller(joint, rng)
    w = Joint(joint, C, omega)
    error = compensated_error(joint.loop)(joint.loop.Q_ideal(C)).at(omega)
    np.testing.assert_allclose(error, (w.Omega + w.Q) * w.g_hat, rtol=1e-9)
    assert not np.allclose(error, (w.Omega - w.Q) * w.g_hat)
