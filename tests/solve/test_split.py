"""Split arithmetic is complex arithmetic in CasADi, lines are affine; so every numeric view of a constraint agrees."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest

from robimp.synthesis.problem.constraints import constraints
from robimp.synthesis.problem.constraints.inequality import Inequality, Role, Source
from robimp.synthesis.problem.grid import Evaluator
from robimp.synthesis.problem.setting import Setting
from robimp.synthesis.solve.places import Casadi
from robimp.synthesis.solve.rows import Rows
from robimp.synthesis.solve.split import Split
from robimp.synthesis.spec import parse_spec

GOOD = (Path(__file__).parents[1] / "data" / "specs" / "good.yaml").read_text(encoding="utf-8")
N = 7


def numbers(seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return rng.normal(size=N) + 1j * rng.normal(size=N)


def casadi_split(z: np.ndarray) -> Split:
    return Split(ca.DM(z.real), ca.DM(z.imag), Casadi())


def real(value: Any) -> np.ndarray:
    """The numbers an expression stands for."""
    return np.array(value, dtype=float).ravel()


def complex_of(z: Split) -> np.ndarray:
    return real(z.re) + 1j * real(z.im)


AFFINE: dict[str, Callable[[Any, np.ndarray], Any]] = {
    "z + w": lambda z, w: z + w,
    "w + z": lambda z, w: w + z,
    "z − w": lambda z, w: z - w,
    "w − z": lambda z, w: w - z,
    "z·w": lambda z, w: z * w,
    "w·z": lambda z, w: w * z,
    "−z": lambda z, w: -z,
    "z + 2": lambda z, w: z + 2.0,
    "1 − z": lambda z, w: 1.0 - z,
    "3 z": lambda z, w: 3 * z,
    "z·Re w": lambda z, w: z * w.real,
    "z·2j": lambda z, w: z * 2j,
}
RATIONAL: dict[str, Callable[[Any, Any], Any]] = {
    "y + z": lambda y, z: y + z,
    "y − z": lambda y, z: y - z,
    "y·z": lambda y, z: y * z,
    "y/z": lambda y, z: y / z,
    "y/(1 + z)": lambda y, z: y / (1.0 + z),
}


@pytest.mark.parametrize("split", [casadi_split])
@pytest.mark.parametrize("operation", AFFINE.values(), ids=AFFINE)
def test_with_numpy_numbers(split: Callable[[np.ndarray], Split], operation: Callable[[Any, Any], Any]) -> None:
    z, w = numbers(1), numbers(2)
    np.testing.assert_allclose(complex_of(operation(split(z), w)), operation(z, w), rtol=1e-13)


@pytest.mark.parametrize("operation", RATIONAL.values(), ids=RATIONAL)
def test_with_each_other(operation: Callable[[Any, Any], Any]) -> None:
    y, z = numbers(3), numbers(4)
    np.testing.assert_allclose(complex_of(operation(casadi_split(y), casadi_split(z))), operation(y, z), rtol=1e-12)


@pytest.mark.parametrize("split", [casadi_split])
def test_modulus_and_real_part(split: Callable[[np.ndarray], Split]) -> None:
    z = numbers(5)
    np.testing.assert_allclose(real(abs(split(z))), np.abs(z), rtol=1e-10)
    np.testing.assert_allclose(real(split(z).real), z.real, rtol=1e-13)


def test_the_modulus_has_a_derivative_at_zero() -> None:
    x = ca.MX.sym("x")
    slope = ca.Function("slope", [x], [ca.jacobian(abs(Split(x, 0 * x, Casadi())), x)])
    assert float(slope(0.0)) == 0.0
    assert float(slope(-1.0)) == pytest.approx(-1.0)


def test_a_conjugated_product_would_be_seen() -> None:
    class Conjugated(Split):
        def __mul__(self, other: Any) -> Split:
            return super().__mul__(np.conj(other))

    z, w = numbers(1), numbers(2)
    wrong = Conjugated(ca.DM(z.real), ca.DM(z.imag), Casadi())
    assert not np.allclose(complex_of(wrong * w), z * w)


VARIANTS = {
    "structured": (),
    "disc": (("{form: structured}", "{form: disc, band: [1, 60]}"),),
    "printed": (("{form: structured}", "{form: paper, band: [1, 30]}"), ("half-plane", "paper")),
    "lumped, frozen": (("half-plane, coupling: physical", "lumped, coupling: frozen"),),
    "weight on the box": (
        ("stiffness: [0, 0]}}", "stiffness: [0, 0]}, weight: {numerator: [0.2, 0], denominator: [1, 800]}}"),
    ),
    "everything": (
        ("attenuation: 0.3", "attenuation: 0.3, rendering_error: 0.1"),
        ("peak: 2.0", "peak: 2.0, friction: require"),
    ),
    "feedback, filtered": (
        ("{type: dob, order: 4}", "{type: dynamic-feedback, order: 1, filters: {force: 100, derivative: 1000}}"),
    ),
}


def setting(variant: str) -> Setting:
    text = GOOD
    for old, new in VARIANTS[variant]:
        assert old in text
        text = text.replace(old, new)
    return Setting.of(parse_spec(text))


def views(joint: Setting, inequality: Inequality, X: np.ndarray, omega: np.ndarray) -> list[np.ndarray]:
    """Right minus left side through NumPy and CasADi."""
    radius = joint.uncertainty.radius if inequality.source is Source.LUMPED else joint.uncertainty.disc_radius
    W, slacks = radius(omega), []
    for value in (X, casadi_split(X)):
        left, right = inequality.sides(1.25, W, value, lambda r: r.at(omega))
        slacks.append(np.broadcast_to(real(right), omega.shape) - np.broadcast_to(real(left), omega.shape))
    return slacks


@pytest.mark.parametrize("variant", VARIANTS)
def test_every_view_of_every_constraint_agrees(variant: str) -> None:
    joint, omega = setting(variant), np.array([1.5, 4.0, 9.0, 15.0, 20.0, 27.0, 29.0])
    assert np.all(joint.uncertainty.radius(omega) * 1.25 < 1), "the disc is bounded where the views are compared"
    seen = 0
    for seed, constraint in enumerate(constraints(joint)):
        for inequality in constraint.inequalities:
            numpy_view, casadi_view = views(joint, inequality, numbers(seed), omega)
            assert np.all(np.isfinite(numpy_view))
            np.testing.assert_allclose(casadi_view, numpy_view, rtol=1e-7, atol=1e-9, err_msg=constraint.form)
            moved, _ = views(joint, inequality, numbers(seed) + 0.01, omega)
            assert not np.allclose(moved, numpy_view, rtol=1e-6), "the comparison does not depend on X"
            seen += 1
    assert seen >= 6


@pytest.mark.parametrize("variant", VARIANTS)
def test_rows_of_a_cone_program_say_what_the_inequality_says(variant: str) -> None:
    joint, omega, seen = setting(variant), np.array([1.5, 4.0, 9.0, 15.0, 20.0, 27.0, 29.0]), 0
    for seed, constraint in enumerate(c for c in constraints(joint) if c.required):
        for inequality in constraint.inequalities:
            X, rows = numbers(seed), Rows.of(joint, constraint, inequality, omega)
            W = Evaluator(joint, omega).radius(inequality.source)
            left, right = inequality.sides(float(constraint.level or 0), W, X, lambda r: r.at(omega))
            size = np.abs(inequality.right.constant.at(omega)) + np.abs(inequality.right.slope.at(omega))
            size = np.full(N, size.min()) if inequality.role is Role.FLOOR else size
            np.testing.assert_allclose(rows.slack(X), (right - left) / size, rtol=1e-9, atol=1e-12)
            assert not np.allclose(rows.slack(X + 0.01), rows.slack(X), rtol=1e-6), "the rows do not depend on X"
            seen += 1
    assert seen >= 5
