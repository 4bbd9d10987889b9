"""The paper's experiments: figures that follow from theory, and what must show when the experiment is broken."""

from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from robimp.synthesis import load
from robimp.synthesis.errors import InputError
from robimp.synthesis.simulation.adversary.loop import free
from robimp.synthesis.simulation.experiments import EXPERIMENTS, loading, rendering
from robimp.synthesis.simulation.experiments.experiment import NONE, true_load
from robimp.synthesis.simulation.experiments.hunting import integrating

SPEC = load(Path(__file__).parents[2] / "examples" / "haninger2016-paper.yaml")
DOB = ((Fraction(2000),), (Fraction(1), Fraction("70.75"), Fraction(500)))


def verdicts(name, C=DOB):
    return {each.finding: each.reproduced for each in EXPERIMENTS[name](SPEC, C).observations}


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_the_papers_own_q_reproduces_most_findings(name):
    found = verdicts(name)
    assert sum(found.values()) >= len(found) - 1


def test_the_loop_of_traditional_control_is_the_frictions_two_sides():
    theta, tau = loading.loaded(SPEC, NONE, 1.25)
    assert loading.hysteresis(theta, tau) == pytest.approx(2 * 0.05 / 1.25, rel=0.2)
    assert loading.stiffness(theta, tau) == pytest.approx(1.25, rel=0.02)


def test_without_friction_the_estimate_is_the_impedance_of_the_joint(monkeypatch):
    monkeypatch.setattr(rendering, "FRICTION", 0.0)
    Z = rendering.estimated(SPEC, NONE)
    s, load_ = 1j * rendering.FREQUENCIES, true_load(SPEC)
    with_friction = rendering.wished(SPEC)
    assert abs(Z[0] - with_friction[0]) / abs(with_friction[0]) < 0.1
    load_row = np.array([float(load_.inertia), float(load_.damping), float(load_.stiffness)])
    (theta,) = free(SPEC, NONE, load_row).response(s.imag, "theta", "push")
    assert abs(Z * theta - 1).max() < 1e-6


def test_a_dob_that_does_nothing_reproduces_nothing_of_it():
    assert not verdicts("fig9", NONE)["greatly reduced by the DOB"]
    found = verdicts("fig11", NONE)
    assert not found["the DOB is more accurate than (2) at low frequency"]
    assert not found["and less than half as wrong over the whole band"]


def test_only_an_integrator_hunts():
    assert set(verdicts("hunting").values()) == {True}
    assert verdicts("hunting", integrating(DOB)) == {
        "with Q(0) < 1 it comes to rest": False,
        "with Q(0) = 1 it hunts": True,
    }
    n, d = integrating(DOB)
    assert d[-1] == 0 and n[-1] == 2500 and [a + b for a, b in zip(n, d, strict=True)] == [1, Fraction("70.75"), 2500]
    with pytest.raises(InputError, match="gain"):
        integrating(((Fraction(5, 2),), (Fraction(1),)))
