"""Sections: the certified filter under Tustin's rule, exact where it has to be, ordered for small signals between."""

from __future__ import annotations

from fractions import Fraction
from itertools import permutations

import numpy as np
import pytest
from export_joints import JOINT, compensator, in_q, law_of, replaced, setting_of
from flint import fmpq, fmpq_poly

from robimp.models.rational import RationalFunction, descending, exact
from robimp.synthesis.errors import InputError
from robimp.synthesis.export.law import discretised
from robimp.synthesis.export.motion import Motion
from robimp.synthesis.export.sections import GRID, MANTISSA, Sections, sections_of

C = exact(2000)  # of Tustin's rule at 1 kHz
OMEGA = np.array([2.0, 5.0, 30.0, 200.0, 1500.0])
FILTERS = {
    "order 4, no integrator": ([248560, 7.4343e6, 5.59805e8], [1, 6040.7, 197939, 1.03e7, 2.1476e8]),
    "integrator and slow real pole": ([2500.0], [1, "0.001", 0]),
    "integrator and three complex zeros": ([1, 3, 50, 300], [1, 80, 3000, 0]),
    "two integrators": ([2, 50], [1, 40, 0, 0]),
    "first order": ([1], [0.01, 1]),
    "as many zeros as poles": ([3, 4, 5], [1, 2, 30]),
}


def response(cascade: Sections, omega: np.ndarray, T: float = 1e-3) -> np.ndarray:
    z = np.exp(-1j * np.outer(omega * T, np.arange(3)))
    return np.prod([(z @ row[:3]) / (z @ row[3:]) for row in cascade.sos], axis=0)


@pytest.mark.parametrize("name", FILTERS)
@pytest.mark.parametrize("means", [0, 1, 2])
def test_is_the_filter_under_tustins_rule(name: str, means: int) -> None:
    filter_ = RationalFunction.of(*FILTERS[name])
    means = min(means, filter_.relative_degree)
    cascade = sections_of(filter_.num, filter_.den, C, "double", means)
    found = response(cascade, OMEGA) * ((1 + np.exp(-1j * OMEGA * 1e-3)) / 2) ** means
    warped = 2000 * np.tan(OMEGA * 1e-3 / 2)
    np.testing.assert_allclose(found, filter_.at(warped), rtol=1e-9)


@pytest.mark.parametrize("precision", ["double", "float"])
@pytest.mark.parametrize("name", [name for name in FILTERS if "integrator" in name and "no" not in name])
def test_an_integrator_stays_exactly_one(name: str, precision: str) -> None:
    filter_ = RationalFunction.of(*FILTERS[name])
    cascade = sections_of(filter_.num, filter_.den, C, precision)
    assert cascade.den(fmpq(1)) == 0
    last = cascade.sections[-1]
    assert 1 + last.a1 + last.a2 == 0, "an integrating section comes last"


def test_plain_rounding_would_lose_the_integrator() -> None:
    """The control: the nearest floats of a1 and a2 of such a section do not add up to −1."""
    lost = 0
    for k in range(200):
        pole = (1 - 1e-3 * (k + 1) / 7) / (1 + 1e-3 * (k + 1) / 7)
        lost += float(np.float32(-1 - pole)) + float(np.float32(pole)) != -1.0
    assert lost > 50


def test_numbers_fit_the_precision() -> None:
    filter_ = RationalFunction.of(*FILTERS["order 4, no integrator"])
    rows = sections_of(filter_.num, filter_.den, C, "float").sos
    assert (rows == rows.astype(np.float32)).all()
    assert not (sections_of(filter_.num, filter_.den, C, "double").sos == rows).all()
    assert {"double": np.finfo(np.float64).nmant + 1, "float": np.finfo(np.float32).nmant + 1} == MANTISSA


def test_no_other_order_has_smaller_signals_between() -> None:
    filter_ = RationalFunction.of([1, 40, 3e4, 1e5, 4e7], [1, 300, 9e4, 6e6, 8e8, 9e9, 1e12])
    cascade = sections_of(filter_.num, filter_.den, C, "double")
    assert len(cascade.sections) == 3
    z = np.exp(-1j * np.outer(GRID, np.arange(3)))
    gains = [np.abs((z @ row[:3]) / (z @ row[3:])) for row in cascade.sos]
    gains[0] = gains[0] / abs(cascade.sections[0].b0 or 1)
    shape = [g / abs(s.b0) if k else g for k, (g, s) in enumerate(zip(gains, cascade.sections, strict=True))]

    def between(order: tuple[int, ...]) -> float:
        return float(np.cumprod([shape[k] for k in order[:-1]], axis=0).max())

    peaks = {order: between(order) for order in permutations(range(3))}
    assert peaks[(0, 1, 2)] == min(peaks.values())
    assert max(peaks.values()) > 2 * min(peaks.values()), "the order matters here"


def test_agrees_with_the_continuous_controller_where_it_is_prewarped() -> None:
    setting = setting_of(JOINT)
    for prewarp in (8.0, 60.0):
        law = law_of(setting, prewarp=prewarp)
        at = np.array([prewarp, 300.0])
        mean = in_q(law.error.M, np.exp(-1j * at * 1e-3))
        ratio = response(law.compensator, at) * mean / compensator(setting).rational.at(at)
        assert abs(ratio[0] - 1) < 1e-10
        assert abs(ratio[1] - 1) > 1e-3, "and only there"


def test_motion_is_the_derivative_without_a_tick_of_lag() -> None:
    """Phase of V and A over M against jω and −ω²: second order in ωT, where a backward difference has first."""
    T, omega = 1e-3, np.array([50.0])
    q = np.exp(-1j * omega * T)
    for r in (0, 1, 2):
        motion = Motion.of(r, C, exact("0.001"), float)
        V, A, M = (in_q(p, q) for p in (motion.V, motion.A, motion.M))
        assert abs(V / M / (1j * omega) - 1) < (omega * T) ** 2
        assert abs(A / M / -(omega**2) - 1) < ((omega * T) ** 2 if r == 2 else omega * T * 1.01)
    backward = (1 - q) / T
    assert abs(backward / (1j * omega) - 1) > 5 * (omega[0] * T) ** 2


def test_back_calculation_turns_the_observer_into_its_filter() -> None:
    """k = 1 for a disturbance observer; a gain of 40 has to be taken back to 1/40 or less."""
    assert law_of(setting_of(JOINT)).back_calculation == 1
    given = "{type: dob, coefficients: {numerator: [2000], denominator: [1, 70.75, 2500]}}"
    gain = replaced(JOINT, (given, "{type: dynamic-feedback, coefficients: {numerator: [40], denominator: [1]}}"))
    k = law_of(setting_of(gain)).back_calculation
    assert fmpq(1, 80) <= k < fmpq(1, 40)


def test_a_rate_too_low_is_refused_with_the_least_one() -> None:
    setting = setting_of(JOINT)
    with pytest.raises(InputError, match=r"--rate 20 Hz is too low .* at least 25.5 Hz"):
        discretised(setting, compensator(setting), Fraction(20), "double", 40.0)


def test_polynomials_are_exact() -> None:
    cascade = sections_of(fmpq_poly([1]), fmpq_poly([1, fmpq(1, 100)]), C, "double")
    section = cascade.sections[0]
    assert descending(cascade.num)[-1] == section.b0
    assert cascade.den[1] == exact(section.a1)
