"""Figures of the paper's own tuning, (23) with α = 0.8 and ω = 50, on the reference joint."""

from __future__ import annotations

import numpy as np
import pytest
from written_out import form, only, setting, variables

from robimp.models.controller import disturbance_observer, eq23
from robimp.synthesis.problem.constraints.inequality import Role
from robimp.synthesis.problem.grid import Evaluator

PAPERS_Q = disturbance_observer(*eq23("0.8", 50))
OMEGA = np.unique(np.concatenate([np.geomspace(0.01, 1e4, 600), np.linspace(10, 100, 3601)]))


def passivity_margin(impedance: str) -> tuple[float, float]:
    joint = setting("{eq12: {form: structured}}", impedance=impedance)
    constraint = form(joint, "eq12", "structured")
    assert constraint.role is Role.FLOOR
    slack, omega, _ = Evaluator(joint, OMEGA).worst(constraint, 0.0, variables(joint, PAPERS_Q))
    return slack, omega


def test_passive_at_the_papers_impedance_with_a_margin() -> None:
    margin, omega = passivity_margin("{inertia: nominal, damping: 0.35, stiffness: 1.25}")
    assert margin == pytest.approx(0.10, abs=0.005)
    assert omega == pytest.approx(50, abs=2)


@pytest.mark.parametrize("stiffness", ["0.2", "1", "3", "10"])
def test_passive_at_every_stiffness_of_the_experiments(stiffness: str) -> None:
    assert passivity_margin(f"{{inertia: nominal, damping: 0.35, stiffness: {stiffness}}}")[0] > 0


def test_not_passive_with_less_damping() -> None:
    margin, omega = passivity_margin("{inertia: nominal, damping: 0.25, stiffness: 3}")
    assert margin == pytest.approx(-0.053, abs=0.0005)
    assert omega == pytest.approx(51.3, abs=0.1)


def test_attenuation_bandwidth_of_the_papers_filter() -> None:
    joint = setting()
    bandwidth = only(joint, "bandwidth")
    omega = np.linspace(0.01, 20, 20000)
    left = Evaluator(joint, omega).levels(bandwidth.inequalities[0], variables(joint, PAPERS_Q))
    assert omega[np.argmax(left > 0.3)] == pytest.approx(8.88, abs=0.005)
    assert float(bandwidth.level or 0) == 0.3


def test_eq9_and_eq18_leave_room() -> None:
    """Passivity is what limits this joint."""
    joint = setting("{eq9: {}, eq18: {form: half-plane, coupling: physical}}")
    for id in ("eq9", "eq18"):
        assert Evaluator(joint, OMEGA).worst(only(joint, id), 1.0, variables(joint, PAPERS_Q))[0] > 0
        assert Evaluator(joint, OMEGA).worst(only(joint, id), 50.0, variables(joint, PAPERS_Q))[0] < 0
