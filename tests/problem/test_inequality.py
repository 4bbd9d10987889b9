"""The one shape of every constraint: gains, roles, levels, and the registry."""

from __future__ import annotations

import inspect
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from written_out import WEIGHT, disc, random_controller, setting, variables

from robimp.models.rational import ONE, RationalFunction, S
from robimp.synthesis.problem import constraints as package
from robimp.synthesis.problem.constraints import REGISTRY, constraints
from robimp.synthesis.problem.constraints.inequality import (
    ONE_MINUS_X,
    Affine,
    Constraint,
    Gain,
    Inequality,
    Role,
    Term,
    Variable,
    X,
    centre,
)
from robimp.synthesis.problem.grid import Evaluator

BOX_AND_WEIGHT = f"{{box: {{inertia: ±20 %, damping: ±40 %, stiffness: [0, 0]}}, weight: {WEIGHT}}}"
ASKED = [
    f"{{eq9: {{}}, eq12: {{form: {passive}}}, eq18: {{form: {form}, coupling: {coupling}}}, "
    "peak: 2, friction: require}"
    for passive, form, coupling in (
        ("structured", "half-plane", "physical"),
        ("disc", "paper", "frozen"),
        ("paper", "lumped", "frozen"),
        ("structured", "paper", "physical"),
    )
]
BOX, WEIGHTED = "{box: {inertia: ±20 %, damping: ±40 %, stiffness: [0, 0]}}", f"{{weight: {WEIGHT}}}"
CASES = [(text, uncertainty) for text in ASKED for uncertainty in (BOX, WEIGHTED)]
CASES += [(text, BOX_AND_WEIGHT) for text in ASKED if "structured" in text]  # the other forms take one source


# ---- gains


def test_delta_over_one_plus_delta_fills_the_disc_of_centre_and_rho() -> None:
    W = np.array([0.05, 0.3, 0.7, 0.95])
    Delta = disc(W, 4001)
    image = Delta / (1 + Delta)
    distance = abs(image - centre(W))
    np.testing.assert_allclose(distance, np.broadcast_to(Gain.RHO.of(W), distance.shape), rtol=1e-9)
    np.testing.assert_allclose(abs(image).max(axis=0), Gain.R.of(W), rtol=1e-5)
    inside = 0.9 * Delta / (1 + 0.9 * Delta)
    assert np.all(abs(inside - centre(W)) < Gain.RHO.of(W))
    assert np.all(abs(inside) < Gain.R.of(W))


def test_beyond_one_the_disc_is_unbounded() -> None:
    W = np.array([0.5, 1.0, 3.0])
    assert list(np.isinf(Gain.R.of(W))) == list(np.isinf(Gain.RHO.of(W))) == [False, True, True]
    assert list(np.isinf(centre(W))) == [False, True, True]
    assert Gain.ONE.of(W) == 1.0
    assert Gain.W.of(W) is W


# ---- affine expressions


def test_affine_is_constant_plus_slope_times_X() -> None:
    expression = (ONE_MINUS_X * S + X * 3) * 2
    value = RationalFunction.of([1, 2], [1, 5])
    assert expression(value) == 2 * ((1 - value) * S + 3 * value)
    assert expression(ONE) == RationalFunction.lift(6)


def test_convex_unless_the_right_modulus_depends_on_X() -> None:
    def of(right: Affine, modulus: bool) -> bool:
        return Inequality(Variable.Q, Role.CEILING, right, modulus, (Term(X),)).convex

    assert of(Affine.of(2), True)
    assert of(X, False)
    assert not of(X, True)


# ---- roles and levels, for every inequality of every constraint


def all_inequalities(joint) -> list[tuple[Constraint, Inequality]]:
    return [(c, i) for c in constraints(joint) for i in c.inequalities]


@pytest.mark.parametrize(("text", "uncertainty"), CASES)
def test_a_harder_level_never_helps(rng, text: str, uncertainty: str) -> None:
    joint = setting(text, uncertainty=uncertainty)
    values = variables(joint, random_controller(joint, rng))
    evaluator = Evaluator(joint, np.sort(10 ** rng.uniform(-2, 3.5, 25)))
    roles = set()
    for constraint, inequality in all_inequalities(joint):
        roles.add(constraint.role)
        assert constraint.role is inequality.role
        by_level = [evaluator.slack(inequality, v, values) for v in (0.2, 0.5, 0.9)[:: inequality.role.harder]]
        for easier, harder in pairwise(by_level):
            decided = np.isfinite(easier) & np.isfinite(harder)
            assert np.all((harder <= easier + 1e-12)[decided]), constraint.id
            assert np.any((harder < easier)[decided]), constraint.id
    assert roles == set(Role)


def bisected(evaluator: Evaluator, inequality: Inequality, values: dict) -> np.ndarray:
    """Where the slack changes sign, found without the formula."""
    shape = evaluator.omega.shape
    low = np.full(shape, -1e7 if inequality.role is Role.FLOOR else 0.0)
    high = np.full(shape, 1e7)
    for _ in range(90):
        middle = (low + high) / 2
        holds = evaluator.slack(inequality, middle, values) > 0  # type: ignore[arg-type]
        upwards = holds if inequality.role.harder > 0 else ~holds
        low, high = np.where(upwards, middle, low), np.where(upwards, high, middle)
    return np.asarray((low + high) / 2)


@pytest.mark.parametrize(("text", "uncertainty"), CASES)
def test_levels_are_where_the_slack_changes_sign(text: str, uncertainty: str) -> None:
    rng = np.random.default_rng(5)
    joint = setting(text, uncertainty=uncertainty)
    values = variables(joint, random_controller(joint, rng))
    evaluator = Evaluator(joint, np.sort(10 ** rng.uniform(-1, 2.5, 12)))
    compared = 0
    for _, inequality in all_inequalities(joint):
        levels = evaluator.levels(inequality, values)
        usable = np.isfinite(levels) & (abs(levels) < 1e6)
        if inequality.role is Role.RADIUS:  # negative: it fails even without uncertainty
            assert np.all((evaluator.slack(inequality, 0.0, values) < 0) == (levels < 0))
            usable &= levels > 0
        np.testing.assert_allclose(
            levels[usable], bisected(evaluator, inequality, values)[usable], rtol=1e-6, atol=1e-7
        )
        compared += int(usable.sum())
    assert compared > 50


# ---- the registry


@pytest.mark.parametrize(("text", "uncertainty"), [("{}", BOX), *CASES])
def test_every_entry_builds_or_has_nothing_to_say(text: str, uncertainty: str) -> None:
    joint = setting(text, uncertainty=uncertainty)
    built = [build(joint) for build in REGISTRY]
    assert all(isinstance(part, tuple) for part in built)
    named = [(c.id, c.form) for part in built for c in part]
    assert len(set(named)) == len(named)
    assert len({id for id, _ in named}) == sum(bool(part) for part in built)  # no id has two files
    assert all(c.inequalities and c.statement and c.uncertainty and c.equation for part in built for c in part)
    assert constraints(joint) == tuple(c for part in built for c in part)


def test_every_file_of_the_folder_is_registered() -> None:
    """One file, one line: a module that builds constraints and is forgotten here would be asked for in vain."""
    shared = {"__init__", "inequality", "small_gain"}
    files = {path.stem for path in Path(inspect.getfile(package)).parent.glob("*.py")} - shared
    assert {build.__module__.rsplit(".", 1)[-1] for build in REGISTRY} == files


def test_forms_asked_for_are_forms_built() -> None:
    for form in ("paper", "disc", "structured"):
        assert form in {c.form for c in constraints(setting(f"{{eq12: {{form: {form}}}}}")) if c.required}
