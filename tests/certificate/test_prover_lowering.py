"""Lowered polynomials are the constraint's own two sides, evaluated exactly."""

from __future__ import annotations

from fractions import Fraction
from math import sqrt
from random import Random

import numpy as np
import pytest
from certificate_joints import random_case, subject
from flint import fmpq, fmpq_poly

from robimp.models.rational import exact, to_float
from robimp.synthesis.certificate.lowering import SumOfRoots, abs2, even_part, in_s, lower, mirror
from robimp.synthesis.certificate.prover import Subject
from robimp.synthesis.problem.constraints import constraints
from robimp.synthesis.problem.constraints.inequality import Constraint, Inequality, Role
from robimp.synthesis.problem.grid import Evaluator
from robimp.synthesis.problem.setting import Setting

PLACES = 401  # samples along a segment of loads


def sides(lowered: SumOfRoots, x: fmpq, t: fmpq) -> tuple[float, float]:
    def value(p: tuple[fmpq_poly, ...]) -> float:
        return to_float(sum((c(x) * t**k for k, c in enumerate(p)), fmpq(0)))

    right = value(lowered.right)
    return sum(sqrt(value(p)) for p in lowered.radicands), sqrt(right) if lowered.squared else right


def along(lowered: SumOfRoots, x: fmpq) -> list[tuple[float, float]]:
    moving = max(len(p) for p in (*lowered.radicands, lowered.right)) > 1
    return [sides(lowered, x, fmpq(k, PLACES - 1)) for k in range(PLACES if moving else 1)]


def statement(setting: Setting, inequality: Inequality, v: Fraction, X: object, omega: float) -> tuple[float, float]:
    """Left and right side in floats, W from the whole uncertainty."""
    at = Evaluator(setting, np.array([omega]))
    left, right = inequality.sides(float(v), at.radius(inequality.source), X.at(at.omega), lambda r: r.at(at.omega))
    return float(np.real(left + 0 * at.omega)[0]), float(np.real(right)[0])


def cases(seed: int) -> list[tuple[Setting, Constraint, Inequality, object]]:
    setting, C = subject(*random_case(seed))
    variables = Subject(setting, C).variables
    return [(setting, c, one, variables[one.variable]) for c in constraints(setting) for one in c.inequalities]


@pytest.mark.parametrize("seed", range(16))
def test_sides_in_floats_and_lowered_polynomials_are_in_one_ratio(seed):
    rng, compared = Random(seed), 0
    for setting, _, inequality, X in cases(seed):
        for _ in range(4):
            omega = 10 ** rng.uniform(-1, 2.5)
            least = 10 if inequality.role is Role.RADIUS else 2  # below v = 1 nothing is claimed of a radius
            x, v = exact(omega) ** 2, Fraction(rng.randint(least, 30), 10)
            left, right = statement(setting, inequality, v, X, omega)
            if not np.isfinite(left):  # W ≥ 1: no disc
                outcomes = [
                    a < b for one in lower(inequality, exact(v), X, setting.uncertainty) for a, b in along(one, x)
                ]
                assert not all(outcomes)
                continue
            lowered = [one for one in lower(inequality, exact(v), X, setting.uncertainty) if not one.strict]
            pairs = [pair for one in lowered for pair in along(one, x)]
            compared += 1
            if inequality.role is Role.FLOOR:
                assert min(b - a for a, b in pairs) * (right - left) > 0 or abs(right - left) < 1e-9 * abs(right)
            else:
                assert max(a / b for a, b in pairs) == pytest.approx(left / right, rel=1e-4, abs=1e-9)
    assert compared > 4


@pytest.mark.parametrize("seed", range(16))
def test_levels_of_floors_are_where_the_lowered_slack_vanishes(seed):
    """The slack is linear in v: its zero is the level that floats find."""
    rng = Random(seed)
    for setting, constraint, inequality, X in cases(seed):
        if inequality.role is not Role.FLOOR:
            continue
        omega = 10 ** rng.uniform(-1, 2.5)
        x, levels = exact(omega) ** 2, []
        expected = float(Evaluator(setting, np.array([omega])).levels(inequality, {inequality.variable: X})[0])
        if not np.isfinite(expected):
            continue
        by_level = [
            [b - a for one in lower(inequality, v, X, setting.uncertainty) if not one.strict for a, b in along(one, x)]
            for v in (fmpq(0), fmpq(1))
        ]
        for at_0, at_1 in zip(*by_level, strict=True):
            levels.append(at_0 / (at_0 - at_1))
        assert min(levels) == pytest.approx(expected, rel=1e-6, abs=1e-9), constraint.id


def test_a_wrong_gain_would_be_seen():
    """Control: twice the radius moves the ratio of the sides by far more than the tolerance."""
    setting, _, inequality, X = next(case for case in cases(0) if case[2].role is Role.RADIUS)
    honest = statement(setting, inequality, Fraction(1), X, 5.0)
    doubled = statement(setting, inequality, Fraction(2), X, 5.0)
    assert honest[0] / honest[1] != pytest.approx(doubled[0] / doubled[1], rel=1e-4)


def test_polynomials_on_the_imaginary_axis():
    p = fmpq_poly([3, -2, 5, 7])
    omega = fmpq(3, 4)
    value = complex(3, 0) + -2 * 0.75j + 5 * (0.75j) ** 2 + 7 * (0.75j) ** 3
    assert to_float(even_part(p)(omega**2)) == pytest.approx(value.real)
    assert to_float(abs2(p)(omega**2)) == pytest.approx(abs(value) ** 2)
    assert in_s(abs2(p)) == p * mirror(p)
