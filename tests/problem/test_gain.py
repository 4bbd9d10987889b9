"""A controller that is one number: every gain is tried, and what excludes them all is named."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from written_out import setting

from robimp.synthesis.problem.constraints import constraints
from robimp.synthesis.problem.grid import Evaluator
from robimp.synthesis.problem.setting import Setting
from robimp.synthesis.solve.gain import excluded
from robimp.synthesis.solve.infeasible import impossible
from robimp.synthesis.spec.model import Polynomials

ASKED = "{eq9: {}, eq12: {form: structured}, eq18: {form: half-plane, coupling: physical}, peak: 2}"
GAIN = "{type: dynamic-feedback, form: p}"


def joint(attenuation: float, controller: str = GAIN) -> Setting:
    objective = f"{{maximize: bandwidth, attenuation: {attenuation}}}"
    return setting(ASKED, controller=controller, objective=objective)


def slack(asked: Setting, k: float) -> float:
    """The least slack of what is required, of the objective at its lowest frequency only."""
    X = asked.variables(asked.compensator(Polynomials(numerator=(Fraction(k),), denominator=(Fraction(1),))))
    omega = np.geomspace(0.01, 1e6, 800)
    required = [c for c in constraints(asked) if c.required]
    return min(
        Evaluator(asked, omega[:1] if c.on_band else omega).worst(c, float(c.level or 0), X)[0] for c in required
    )


def slack_of_peak(asked: Setting, k: float) -> float:
    """Where passivity fails another constraint need not."""
    X = asked.variables(asked.compensator(Polynomials(numerator=(Fraction(k),), denominator=(Fraction(1),))))
    (peak,) = (c for c in constraints(asked) if c.id == "peak")
    return Evaluator(asked, np.geomspace(0.01, 1e6, 800)).worst(peak, 2.0, X)[0]


@pytest.mark.parametrize("controller", [GAIN, "{type: dynamic-feedback, order: 0}"])
def test_a_gain_cannot_attenuate_and_be_passive(controller: str) -> None:
    asked = joint(0.3, controller)
    found = impossible(asked)
    assert found is not None and found.what == "(12) structured and attenuation"
    assert "for any C_imp = k" in str(found) and "form: pi" in found.remedy
    assert 100 < found.omega < 2000, "where passivity fails"
    passivity, attenuation = found.why.split("; ")
    assert f"at ω = {found.omega:.4g} rad/s" in passivity and "ω → 0" in attenuation
    assert "rad/s" not in str(found).split(": ")[0] and "→" not in str(found).split(": ")[0], "no place is shared"
    edge = float(passivity.split("k = ")[1].split()[0])
    X = asked.variables(asked.compensator(Polynomials(numerator=(Fraction(edge),), denominator=(Fraction(1),))))
    (passive,) = (c for c in constraints(asked) if c.id == "eq12" and c.required)
    assert Evaluator(asked, np.array([found.omega])).worst(passive, 0.0, X)[0] < 0 < slack_of_peak(asked, edge)
    for k in np.geomspace(1e-4, 1e6, 20):
        assert slack(asked, float(k)) < 0, "and so each of them fails"


def test_the_gains_that_remain_are_not_excluded() -> None:
    """A proportional controller of 0.15 attenuates to 1/1.15 and is passive; without (12) a gain of 3 does it all."""
    assert excluded(joint(0.95)) is None and slack(joint(0.95), 0.148) > 0
    free = setting("{peak: 2}", controller=GAIN)
    assert excluded(free) is None and slack(free, 3.0) > 0


def test_the_edge_is_found_from_both_sides() -> None:
    """|1−Q̃| = 1/(1+k) at ω → 0, and the largest passive gain is 0.1481."""
    largest = 0.148
    assert slack(joint(0.99), largest) > 0 > slack(joint(0.99), largest + 0.001)
    assert excluded(joint(1 / (1 + largest - 0.002))) is None
    assert excluded(joint(1 / (1 + largest + 0.002))) is not None


@pytest.mark.parametrize("controller", ["{type: dynamic-feedback, form: pi}", "{type: dob, order: 2}"])
def test_other_controllers_are_not_spoken_of(controller: str) -> None:
    assert excluded(joint(0.3, controller)) is None
