"""(12), passivity of the port, in its three forms."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from written_out import WEIGHT, Joint, disc, form, only, ordering, random_controller, setting, sides

from robimp.synthesis.problem.constraints import constraints
from robimp.synthesis.problem.constraints.inequality import Role

IDEAL = "{type: ideal}"
SMALL_BOX = "{box: {inertia: [0.03, 0.03], damping: ±40 %, stiffness: [0, 0]}}"


def passivity(joint: Joint, g: np.ndarray) -> np.ndarray:
    """`Re(Z/jω)` on a load."""
    return np.asarray((joint.Z(g) / joint.s).real)


# ---- paper


def test_paper_form_is_the_printed_one_with_its_sides_exchanged(rng, omega) -> None:
    joint = setting("{eq12: {form: paper}}", actuator=IDEAL, uncertainty=f"{{weight: {WEIGHT}}}")
    C = random_controller(joint, rng)
    w = Joint(joint, C, omega)
    left, right = sides(joint, only(joint, "eq12").inequalities[0], 1.0, C, omega)
    R = w.W / (1 - w.W)
    minus, plus = abs(w.G_hat * (w.s - w.G_imp)), abs(w.G_hat * (w.s + w.G_imp))
    np.testing.assert_allclose(left, (minus + 2 * R * abs(1 - w.Q)) * abs(w.g_hat), rtol=1e-9)
    np.testing.assert_allclose(right, plus * abs(w.g_hat), rtol=1e-9)
    as_printed = ordering(plus + 2 * R * abs(1 - w.Q), minus)
    assert np.all(as_printed < 0)  # the printed test refuses every passive impedance
    assert np.any(ordering(left, right) > 0)


def test_paper_form_is_sufficient_for_passivity_over_the_disc_and_no_more(many) -> None:
    joint = setting("{eq12: {form: paper}}", actuator=IDEAL, uncertainty=f"{{weight: {WEIGHT}}}")
    (inequality,) = only(joint, "eq12").inequalities
    holds, passive = [], []
    for rng, omega in many:
        C = random_controller(joint, rng)
        w = Joint(joint, C, omega)
        left, right = sides(joint, inequality, 1.0, C, omega)
        holds.append(left < right)
        passive.append((w.Z(w.g_hat / (1 + disc(w.W))) / w.s).real.min(axis=0) > 0)
    assert np.any(holds)
    assert np.all(np.array(passive)[np.array(holds)])
    assert np.any(np.array(passive) & ~np.array(holds))


def test_the_level_scales_the_radius(omega) -> None:
    joint = setting("{eq12: {form: paper}}", actuator=IDEAL, uncertainty=f"{{weight: {WEIGHT}}}")
    C = random_controller(joint, np.random.default_rng(1))
    w = Joint(joint, C, omega)
    (inequality,) = only(joint, "eq12").inequalities
    left, _ = sides(joint, inequality, 0.5, C, omega)
    half = 0.5 * w.W
    np.testing.assert_allclose(left, abs(w.s - w.G_imp) + 2 * half / (1 - half) * abs((1 - w.Q) * w.g_hat), rtol=1e-9)
    assert only(joint, "eq12").role is Role.RADIUS


# ---- disc


@pytest.mark.parametrize("margin", ["0", "0.02"])
@pytest.mark.parametrize("actuator", [IDEAL, None], ids=["ideal", "series-elastic"])
def test_disc_form_is_the_least_over_the_disc(rng, omega, actuator, margin) -> None:
    chosen = {} if actuator is None else {"actuator": actuator}
    joint = setting(f"{{eq12: {{form: disc, margin: {margin}}}}}", uncertainty=f"{{weight: {WEIGHT}}}", **chosen)
    C = random_controller(joint, rng)
    w = Joint(joint, C, omega)
    constraint = form(joint, "eq12", "disc")
    left, right = sides(joint, constraint.inequalities[0], float(constraint.level or 0), C, omega)
    Z = w.Z(w.g_hat / (1 + disc(w.W, 1441)))
    least = (Z / w.s).real.min(axis=0) - float(margin)
    scale = 1 + abs(w.Z(w.g_hat / (1 - w.W)) / w.s)
    np.testing.assert_allclose((right - left) / scale, least / scale, atol=1e-4)
    np.testing.assert_array_less((right - left) / scale, least / scale + 1e-12)  # never above a sampled load
    nominal_only = passivity(w, w.g_hat) - float(margin)
    assert not np.allclose(nominal_only / scale, least / scale, atol=1e-2)


def test_disc_form_for_an_ideal_actuator_is_the_one_of_the_theory(rng, omega) -> None:
    """`ω B_imp |Ĝ| > ρ|1−Q| + Re[c(1−Q)|Ĝ|/(jĜ)]`, here per |Ĝ|ω."""
    joint = setting("{eq12: {form: disc}}", actuator=IDEAL, uncertainty=f"{{weight: {WEIGHT}}}")
    C = random_controller(joint, rng)
    w = Joint(joint, C, omega)
    left, right = sides(joint, form(joint, "eq12", "disc").inequalities[0], 0.0, C, omega)
    c, rho, size = -(w.W**2) / (1 - w.W**2), w.W / (1 - w.W**2), abs(w.G_hat)
    margin = omega * 0.35 * size - rho * abs(1 - w.Q) - (c * (1 - w.Q) * size / (1j * w.G_hat)).real
    np.testing.assert_allclose((right - left) * omega * size, margin, rtol=1e-7, atol=1e-9)


def test_paper_form_holds_only_where_the_disc_form_does(many) -> None:
    joint = setting("{eq12: {form: disc}}", actuator=IDEAL, uncertainty=f"{{weight: {WEIGHT}}}")
    paper, exact = [], []
    for rng, omega in many:
        C = random_controller(joint, rng)
        for found, name, v in ((paper, "paper", 1.0), (exact, "disc", 0.0)):
            left, right = sides(joint, form(joint, "eq12", name).inequalities[0], v, C, omega)
            found.append(left < right)
    assert np.all(np.array(exact)[np.array(paper)])
    assert np.any(np.array(exact) & ~np.array(paper))


@pytest.mark.parametrize("name", ["paper", "disc"])
def test_a_disc_that_reaches_minus_one_cannot_pass(name: str) -> None:
    """W ≥ 1: the load may be arbitrarily stiff or have any phase."""
    joint = setting(
        f"{{eq12: {{form: {name}, band: [0, 100]}}}}", uncertainty="{weight: {numerator: [1], denominator: [1]}}"
    )
    C, omega = random_controller(joint, np.random.default_rng(2)), np.geomspace(1, 50, 5)
    constraint = form(joint, "eq12", name)
    with np.errstate(all="ignore"):
        left, right = sides(joint, constraint.inequalities[0], float(constraint.level or 0), C, omega)
    assert not np.any(left <= right)


def test_neither_disc_form_can_hold_at_infinity_when_the_inertia_is_uncertain(rng) -> None:
    joint = setting("{eq12: {form: disc}}")
    C, high = random_controller(joint, rng), np.array([1e6, 1e7])
    for name, v in (("paper", 1.0), ("disc", 0.0)):
        left, right = sides(joint, form(joint, "eq12", name).inequalities[0], v, C, high)
        assert np.all(left > right)
    known = setting("{eq12: {form: disc}}", uncertainty=SMALL_BOX)
    left, right = sides(known, form(known, "eq12", "disc").inequalities[0], 0.0, C, high)
    assert np.all(left < right)  # with the inertia known, it can


# ---- structured


def structured(joint, C, omega, v: float = 0.0) -> np.ndarray:
    inequalities = form(joint, "eq12", "structured").inequalities
    return np.min([np.subtract(*sides(joint, i, v, C, omega)[::-1]) for i in inequalities], axis=0)


def test_structured_form_is_the_least_over_the_box(rng, omega, controller) -> None:
    joint = setting("{eq12: {form: structured}}", controller=controller)
    C = random_controller(joint, rng)
    w = Joint(joint, C, omega)
    least = structured(joint, C, omega)
    sampled = np.array([passivity(w, g) for g in w.loads(rng, 300)])
    box = joint.spec.uncertainty.box
    assert box is not None
    vertices = [
        passivity(w, w.stiffness(float(i), float(b), float(k)))
        for i in box.inertia
        for b in box.damping
        for k in box.stiffness
    ]
    scale = 1 + np.abs(sampled).max(axis=0)
    np.testing.assert_allclose(least / scale, np.min(vertices, axis=0) / scale, atol=1e-9)
    assert np.all(least / scale <= sampled.min(axis=0) / scale + 1e-9)
    assert np.any(passivity(w, w.g_hat) > least + 1e-3 * scale)  # the nominal load does not decide


def test_structured_form_with_stiffness_uncertain(rng, omega) -> None:
    joint = setting(
        "{eq12: {form: structured}}",
        plant="{inertia: 0.03, damping: 0.2, stiffness: 2}",
        uncertainty="{box: {inertia: ±20 %, damping: ±40 %, stiffness: [1, 4]}}",
    )
    C = random_controller(joint, rng)
    w = Joint(joint, C, omega)
    sampled = np.array([passivity(w, g) for g in w.loads(rng, 300)])
    scale = 1 + np.abs(sampled).max(axis=0)
    assert np.all(structured(joint, C, omega) / scale <= sampled.min(axis=0) / scale + 1e-9)


def test_structured_form_with_a_weight_covers_the_disc_around_every_load(rng, omega) -> None:
    both = setting(
        "{eq12: {form: structured}}",
        uncertainty=f"{{box: {{inertia: ±20 %, damping: ±40 %, stiffness: [0, 0]}}, weight: {WEIGHT}}}",
    )
    C = random_controller(both, rng)
    w = Joint(both, C, omega)
    least = structured(both, C, omega)
    for g in w.loads(rng, 40):
        sampled = (w.Z(g / (1 + disc(w.weight))) / w.s).real.min(axis=0)
        assert np.all(least <= sampled + 1e-9 * (1 + abs(sampled)))
    without = setting("{eq12: {form: structured}}")
    assert np.all(structured(without, C, omega) >= least)
    assert np.any(structured(without, C, omega) > least + 1e-3)


def test_the_margin_is_what_is_left_above_it(omega) -> None:
    joint = setting("{eq12: {form: structured, margin: 0.02}}")
    C = random_controller(joint, np.random.default_rng(3))
    assert form(joint, "eq12", "structured").level == Fraction(1, 50)
    np.testing.assert_allclose(structured(joint, C, omega, 0.02), structured(joint, C, omega) - 0.02)


# ---- what is asked, and what is only reported


def test_beside_passivity_the_printed_form_is_reported_on_its_largest_band() -> None:
    joint = setting("{eq12: {form: structured, band: [1, 30]}}")
    passive, paper = (c for c in constraints(joint) if c.id == "eq12")
    assert (passive.form, passive.required, passive.positive_real, passive.strict) == ("structured", True, False, False)
    assert (paper.form, paper.required, paper.largest_band) == ("paper", False, True)
    assert passive.band == paper.band == (1, 30)
    assert form(setting("{eq12: {form: structured}}"), "eq12", "structured").positive_real


@pytest.mark.parametrize(
    ("filters", "says"),
    [
        ("force: 100", "with stability, passive behind an ideal actuator"),
        ("force: 100, derivative: 2", "not passivity"),
        ("force: 100, position: 3", "not passivity"),
    ],
)
def test_the_printed_form_is_not_called_passivity_where_it_leaves_filters_out(filters: str, says: str, many) -> None:
    controller = f"{{type: dob, order: 4, filters: {{{filters}}}}}"
    weight = f"{{weight: {WEIGHT}}}"
    joint = setting("{eq12: {form: paper}}", actuator=IDEAL, uncertainty=weight, controller=controller)
    constraint = only(joint, "eq12")
    assert says in constraint.statement
    contradicted = False
    for draw, omega in many:
        C = random_controller(joint, draw)
        w = Joint(joint, C, omega)
        left, right = sides(joint, constraint.inequalities[0], 1.0, C, omega)
        passive = (w.Z(w.g_hat / (1 + disc(w.W))) / w.s).real.min(axis=0) > 0
        contradicted |= bool(np.any((left < right) & ~passive))
    assert contradicted == ("not" in says)


def test_no_eq12_no_constraint() -> None:
    assert [c.id for c in constraints(setting()) if c.id == "eq12"] == []
