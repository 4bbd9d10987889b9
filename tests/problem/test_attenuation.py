"""Bandwidth and peak: what is left of a load disturbance, `|1−Q̃|`."""

from __future__ import annotations

import numpy as np
import pytest
from written_out import Joint, only, random_controller, setting, sides, variables

from robimp.synthesis.problem.constraints import constraints
from robimp.synthesis.problem.constraints.inequality import Role
from robimp.synthesis.problem.grid import Evaluator


@pytest.mark.parametrize("id", ["bandwidth", "peak"])
def test_sides_are_sensitivity_and_level(rng, omega, controller, id: str) -> None:
    joint = setting("{peak: 2}", controller=controller)
    C = random_controller(joint, rng)
    w = Joint(joint, C, omega)
    left, right = sides(joint, only(joint, id).inequalities[0], 0.3, C, omega)
    np.testing.assert_allclose(left, abs(1 / (1 + w.L)), rtol=1e-9)
    np.testing.assert_allclose(right, 0.3)
    assert not np.allclose(left, abs(1 - w.Q), rtol=1e-3)  # not the Q of the ideal actuator


def test_sensitivity_is_what_the_loop_leaves_of_a_disturbance_of_any_load(rng, omega) -> None:
    """Equations of motion with d in the load's: the same θ as without force feedback, divided by `1 + L`."""
    joint = setting()
    C = random_controller(joint, rng)
    w = Joint(joint, C, omega)
    for g in w.loads(rng, 3):
        wish = w.gain * w.F_theta * w.G_imp - w.F_d * (w.g_hat - w.G_imp)
        from_disturbance = 1 / (g + w.Z_a + w.H * wish)  # no τ_int: θ/d
        from_torque = (1 + w.H * w.gain * w.F) * from_disturbance  # θ/τ_int
        np.testing.assert_allclose(abs(from_disturbance / from_torque), abs(1 - w.Q_tilde), rtol=1e-9)


def test_levels_required_and_intervals() -> None:
    joint = setting("{peak: 2}", objective="{maximize: bandwidth, attenuation: 0.25}")
    bandwidth, peak = only(joint, "bandwidth"), only(joint, "peak")
    assert (bandwidth.level, bandwidth.on_band, bandwidth.role) == (1 / 4, True, Role.CEILING)
    assert (peak.level, peak.on_band, peak.role) == (2, False, Role.CEILING)
    assert not only(setting(), "peak").required
    assert {c.id for c in constraints(setting())} >= {"bandwidth", "peak"}  # reported all the same


def test_the_worst_level_of_the_peak_is_the_largest_sensitivity(rng) -> None:
    joint = setting("{peak: 2}")
    C, omega = random_controller(joint, rng), np.geomspace(0.1, 1e4, 400)
    levels = Evaluator(joint, omega).levels(only(joint, "peak").inequalities[0], variables(joint, C))
    assert levels.max() == pytest.approx(abs(1 / (1 + Joint(joint, C, omega).L)).max(), rel=1e-9)
    assert levels.max() > 1  # Bode's integral: somewhere a disturbance is amplified
