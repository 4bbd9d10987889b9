"""Rendering error `|Z − G_imp| ≤ ε|G_imp|` for every load."""

from __future__ import annotations

import numpy as np
import pytest
from written_out import WEIGHT, Joint, disc, only, random_controller, setting, sides

from robimp.synthesis.problem.constraints.inequality import Role

BOX = "box: {inertia: ±20 %, damping: ±40 %, stiffness: [0, 0]}"


def worst_error(joint, C, omega: np.ndarray) -> np.ndarray:
    """Largest level over the corners' inequalities: left over right at v = 1."""
    ratios = [np.divide(*sides(joint, i, 1.0, C, omega)) for i in only(joint, "rendering").inequalities]
    return np.asarray(np.max(ratios, axis=0))


def test_it_is_the_largest_relative_error_over_the_box(rng, omega, controller) -> None:
    joint = setting(controller=controller)
    C = random_controller(joint, rng)
    w = Joint(joint, C, omega)
    errors = [abs(w.Z(g) - w.G_imp) / abs(w.G_imp) for g in w.loads(rng, 300)]
    worst = worst_error(joint, C, omega)
    assert np.all(np.max(errors, axis=0) <= worst * (1 + 1e-9))
    np.testing.assert_allclose(np.max(errors, axis=0), worst, rtol=0.25)
    nominal = abs(w.Z(w.g_hat) - w.G_imp) / abs(w.G_imp)
    assert np.any(worst > 1.05 * nominal)


def test_at_each_corner_it_is_the_error_there(rng, omega) -> None:
    joint = setting()
    C = random_controller(joint, rng)
    w = Joint(joint, C, omega)
    for inequality in only(joint, "rendering").inequalities:
        load = inequality.load
        assert load is not None
        g = w.stiffness(*(float(str(x.p)) / float(str(x.q)) for x in (load.inertia, load.damping, load.stiffness)))
        left, right = sides(joint, inequality, 0.1, C, omega)
        np.testing.assert_allclose(left, abs(w.Z(g) - w.G_imp), rtol=1e-6, atol=1e-9)
        np.testing.assert_allclose(right, 0.1 * abs(w.G_imp), rtol=1e-9)


def test_a_weight_adds_its_disc_around_every_corner(rng, omega) -> None:
    both = setting(uncertainty=f"{{{BOX}, weight: {WEIGHT}}}")
    C = random_controller(both, rng)
    w = Joint(both, C, omega)
    worst = worst_error(both, C, omega)
    for g in w.loads(rng, 40):
        assert np.all(abs(w.Z(g / (1 + disc(w.weight))) - w.G_imp).max(axis=0) <= worst * abs(w.G_imp) * (1 + 1e-9))
    assert np.any(worst > worst_error(setting(), C, omega) * 1.01)


def test_the_disc_is_exact_around_one_load(rng, omega) -> None:
    joint = setting(uncertainty=f"{{weight: {WEIGHT}}}")
    C = random_controller(joint, rng)
    w = Joint(joint, C, omega)
    sampled = abs(w.Z(w.g_hat / (1 + disc(w.weight, 721))) - w.G_imp).max(axis=0) / abs(w.G_imp)
    np.testing.assert_allclose(worst_error(joint, C, omega), sampled, rtol=1e-3)


@pytest.mark.parametrize(("objective", "level"), [("", None), (", rendering_error: 0.1", 1 / 10)])
def test_required_when_the_objective_names_it(objective: str, level: float | None) -> None:
    constraint = only(setting(objective=f"{{maximize: bandwidth, attenuation: 0.3{objective}}}"), "rendering")
    assert constraint.required is (level is not None)
    assert constraint.level is None or float(constraint.level) == level
    assert (constraint.role, constraint.on_band) == (Role.CEILING, True)
