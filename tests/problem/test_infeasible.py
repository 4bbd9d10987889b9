"""Why nothing can work: every "impossible" is confirmed by searching over X, and a feasible joint is left alone."""

from __future__ import annotations

import re

import numpy as np
import pytest
from scipy.optimize import minimize
from written_out import BOX, WEIGHT, only, random_controller, setting

from robimp.synthesis.problem.constraints import constraints
from robimp.synthesis.problem.constraints.inequality import Inequality
from robimp.synthesis.problem.grid import Evaluator
from robimp.synthesis.problem.setting import Setting
from robimp.synthesis.solve.alone import _best_ratio
from robimp.synthesis.solve.infeasible import impossible
from robimp.synthesis.solve.reason import Impossible

REFERENCE = "{eq9: {}, eq12: {form: structured}, eq18: {form: half-plane, coupling: physical}, peak: 2}"
PAPER_18 = "{{eq18: {{form: paper, coupling: {}}}}}"
CONSTANT = "{{weight: {{numerator: [{}], denominator: [1]}}}}"


def at(joint: Setting, inequality: Inequality, omega: float, X: complex) -> float:
    """left/right for one complex number X."""
    w = np.array([omega])
    W = Evaluator(joint, w).radius(inequality.source)
    left, right = inequality.sides(1.0, W, np.array([X]), lambda r: r.at(w))
    return float((np.asarray(left) / np.asarray(right)).max())


def best(joint: Setting, inequality: Inequality, omega: float) -> float:
    """Least left/right over the plane of X: a convex function, minimised from several starts."""
    starts = [0, 1 - 4j]
    runs = [
        minimize(
            lambda x: at(joint, inequality, omega, complex(*x)),
            [z.real, z.imag],
            method="Nelder-Mead",
            options={"xatol": 1e-10, "fatol": 1e-12, "maxiter": 600},
        )
        for z in map(complex, starts)
    ]
    return float(min(run.fun for run in runs))


def stated_ratio(found: Impossible) -> float:
    """The least left/right, as the user is told it."""
    match = re.search(r"at best (\S+) ", found.why)
    assert match is not None
    return float(match[1])


def reason(joint: Setting) -> Impossible:
    found = impossible(joint)
    assert found is not None
    return found


def test_the_reference_joint_is_not_excluded() -> None:
    assert impossible(setting(REFERENCE)) is None
    assert impossible(setting()) is None


# ---- ω → 0


@pytest.mark.parametrize("coupling", ["frozen", "physical"])
def test_printed_eq18_makes_no_stiffness_from_nothing(coupling: str) -> None:
    """K̂ = 0, K_imp > 0: |Ω| → ∞, which only |Ω| < 1 would allow."""
    joint = setting(PAPER_18.format(coupling))
    found = reason(joint)
    assert (found.what, found.omega, found.why) == (f"(18) paper/{coupling}", 0.0, "its right side vanishes")
    ratios = [best(joint, only(joint, "eq18").inequalities[0], omega) for omega in (1.0, 0.1)]
    assert 1 < ratios[0] < ratios[1]
    assert "ω → 0" in str(found)
    assert "half-plane" in str(found)


@pytest.mark.parametrize("form", ["half-plane", "lumped"])
def test_other_forms_of_eq18_have_a_way(form: str) -> None:
    assert impossible(setting(f"{{eq18: {{form: {form}, coupling: frozen}}}}")) is None


@pytest.mark.parametrize(("share", "excluded"), [("50", True), ("49", False), ("60", True)])
def test_damping_down_to_half_leaves_eq9_nothing_at_zero(share: str, excluded: bool) -> None:
    """K̂ = 0: W(0) = B̂/B_min − 1 is 1 exactly at half the damping, and (9) an equality whatever Q(0) is."""
    joint = setting("{eq9: {}}", uncertainty=BOX.join(["{box: ", "}"]).replace("±40", f"±{share}"))
    found = impossible(joint)
    assert (found is not None) is excluded
    if found is not None:
        assert (found.what, found.omega) == ("(9) printed", 0.0)
        assert stated_ratio(found) == pytest.approx(1 if share == "50" else 1.5)
        X = np.random.default_rng(0).normal(size=(5, 2)) @ [1, 1j]
        near_zero = [at(joint, only(joint, "eq9").inequalities[0], 1e-6, complex(x)) for x in X]
        assert near_zero == pytest.approx([stated_ratio(found)] * 5, rel=1e-5)


# ---- W ≥ 1 and (12)


@pytest.mark.parametrize("form", ["paper", "disc"])
def test_a_disc_that_reaches_minus_one_has_no_passive_port(form: str) -> None:
    found = reason(setting(f"{{eq12: {{form: {form}}}}}", uncertainty=CONSTANT.format(1)))
    assert found.what == f"(12) {form}"
    assert "W ≥ 1" in found.why
    assert "structured" in str(found)
    below = setting(f"{{eq12: {{form: {form}, band: [1, 1000]}}}}", uncertainty=CONSTANT.format("0.9"))
    assert impossible(below) is None


@pytest.mark.parametrize(("band", "excluded"), [("[0, 20]", True), ("[1, 20]", False)])
def test_printed_eq12_is_an_equality_at_zero_for_any_stiffness(band: str, excluded: bool) -> None:
    """`|0 − K_imp| = |0 + K_imp|`: strict on no band that starts at 0."""
    found = impossible(setting(f"{{eq12: {{form: paper, band: {band}}}}}", uncertainty=CONSTANT.format("0.1")))
    assert (found is not None) is excluded
    if found is not None:
        assert (found.what, found.omega, stated_ratio(found)) == ("(12) paper", 0.0, 1.0)


@pytest.mark.parametrize("form", ["paper", "disc"])
def test_only_the_band_that_was_asked_for_counts(form: str) -> None:
    """W = 2 at high frequency, 1/10 at low."""
    growing = "{weight: {numerator: [2, 10], denominator: [1, 100]}}"
    low, high = (
        impossible(setting(f"{{eq12: {{form: {form}, band: {band}}}}}", uncertainty=growing))
        for band in ("[1, 20]", "[1, 500]")
    )
    assert low is None
    assert high is not None
    assert 50 < high.omega <= 500
    assert impossible(setting(f"{{eq12: {{form: {form}}}}}", uncertainty=growing)) is not None


def test_the_printed_form_that_is_only_reported_excludes_nothing() -> None:
    joint = setting("{eq12: {form: structured}}", uncertainty=BOX.join(["{box: ", "}"]).replace("±40", "±60"))
    assert any(c.form == "paper" and not c.required for c in constraints(joint))
    assert impossible(joint) is None


# ---- two distances from X


STIFF = "{inertia: 0.03, damping: 0.2, stiffness: 2}"


@pytest.mark.parametrize("wish", ["4.5", "6", "20"])
@pytest.mark.parametrize("coupling", ["frozen", "physical"])
@pytest.mark.parametrize("uncertainty", [f"{{weight: {WEIGHT}}}", CONSTANT.format("0.4"), CONSTANT.format("1.5")])
def test_closed_form_of_two_distances_is_the_minimum_over_X(wish: str, coupling: str, uncertainty: str) -> None:
    """K_imp > 2K̂ asks (18) as printed for |Ω| < 1 where A_cl ≈ 1."""
    impedance = f"{{inertia: nominal, damping: 0.35, stiffness: {wish}}}"
    joint = setting(PAPER_18.format(coupling), uncertainty=uncertainty, plant=STIFF, impedance=impedance)
    found = reason(joint)
    assert found.omega > 0
    (inequality,) = only(joint, "eq18").inequalities
    (ratio,) = _best_ratio(inequality, Evaluator(joint, np.array([found.omega])))
    assert ratio == pytest.approx(best(joint, inequality, found.omega), rel=1e-6)
    assert ratio == pytest.approx(stated_ratio(found), rel=1e-3)
    assert ratio > 1
    assert f"{found.omega:.4g} rad/s" in str(found)


@pytest.mark.parametrize("coupling", ["frozen", "physical"])
def test_up_to_twice_the_stiffness_there_is_a_way(coupling: str) -> None:
    damped = "{inertia: 0.03, damping: 2, stiffness: 2}"  # no resonance of the model, where |Ω| would be large again
    wishes = (f"{{inertia: nominal, damping: 2, stiffness: {stiffness}}}" for stiffness in ("3.6", "4.4"))
    small = CONSTANT.format("0.1")
    below, beyond = (
        impossible(setting(PAPER_18.format(coupling), uncertainty=small, plant=damped, impedance=wish))
        for wish in wishes
    )
    assert below is None
    assert beyond is not None


def test_the_first_of_two_reasons_is_given() -> None:
    joint = setting("{eq9: {}, eq18: {form: paper, coupling: frozen}}", uncertainty=CONSTANT.format("1.1"))
    assert reason(joint).what == "(9) printed"


# ---- nothing that restores the position


@pytest.mark.parametrize(("stiffness", "excluded"), [("0", True), ("0.2", False)])
def test_without_any_stiffness_free_motion_keeps_a_pole_at_zero(stiffness: str, excluded: bool) -> None:
    joint = setting(impedance=f"{{inertia: nominal, damping: 0.35, stiffness: {stiffness}}}")
    found = impossible(joint)
    assert (found is not None) is excluded
    for seed in range(3):  # whatever the controller
        C = random_controller(joint, np.random.default_rng(seed))
        assert (joint.loop.free(joint.loop.nominal)(C)(0) == 0) is excluded
    if found is not None:
        assert (found.what, found.omega) == ("stability-free", 0.0)
