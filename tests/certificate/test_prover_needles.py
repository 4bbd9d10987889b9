"""Resonances between grid points: every grid passes, the continuum fails, the proof sees it."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from certificate_joints import rational, spec, subject

from robimp.synthesis.certificate.claim import Claim
from robimp.synthesis.certificate.claims import certify, counterexamples
from robimp.synthesis.certificate.outcome import Outcome
from robimp.synthesis.problem.setting import Setting
from robimp.synthesis.spec.model import Polynomials, Spec

LOW, HIGH = 1e-2, 1e5
ASKED = spec(actuator={"type": "ideal"}, constraints={"eq9": None, "eq12": None, "eq18": None, "peak": "2"})


def between(points: int) -> Fraction:
    """A frequency in the middle, in logarithms, between two points of the grid near 40 rad/s."""
    grid = np.geomspace(LOW, HIGH, points)
    k = int(np.searchsorted(grid, 40.0))
    return Fraction(float(np.sqrt(grid[k - 1] * grid[k])))


def resonant(zeta: Fraction, height: Fraction, omega: Fraction) -> Polynomials:
    """`Q = 0.8·20/(s+20) − height·2ζωs/(s² + 2ζωs + ω²)`: at ω the second part is −height, elsewhere about nothing."""
    width = 2 * zeta * omega
    pair = [Fraction(1), width, omega**2]
    numerator = np.polysub(np.polymul([Fraction(16)], pair), [height * width, 20 * height * width, Fraction(0)])
    return rational(list(numerator), list(np.polymul([Fraction(1), Fraction(20)], pair)))


def worst_on_grid(asked: Spec, coefficients: Polynomials, points: int) -> float:
    """Largest `|1 − Q̃|` on the grid, in floats."""
    setting = Setting.of(asked)
    X = setting.loop.Q_tilde(setting.compensator(coefficients))
    return float(np.max(np.abs(1 - X.at(np.geomspace(LOW, HIGH, points)))))


def peak(coefficients: Polynomials) -> Claim:
    return next(c for c in certify(*subject(ASKED, coefficients)) if c.id == "peak")


@pytest.mark.parametrize(
    ("zeta", "height", "points"),
    [
        (Fraction(1, 10**9), Fraction(5), 100_000),
        (Fraction(1, 10**9), Fraction(5), 1_000_000),
        (Fraction(1, 10**4), Fraction("1.14"), 100_000),  # wider than the grid's step, but only its tip is too high
    ],
)
def test_grid_passes_and_proof_refutes(zeta, height, points):
    omega = between(points)
    needle = resonant(zeta, height, omega)
    assert worst_on_grid(ASKED, needle, points) < 2
    claim = peak(needle)
    assert claim.status is Outcome.REFUTED
    assert abs(claim.refuted_at.witness.omega / omega - 1) < 10 * zeta
    at = np.array([float(claim.refuted_at.witness.omega)])
    setting = Setting.of(ASKED)
    assert abs(1 - setting.loop.Q_tilde(setting.compensator(needle)).at(at))[0] > 2
    assert any(
        abs(c.omega / float(omega) - 1) < 10 * zeta
        for c in counterexamples(*subject(ASKED, needle), omega_B=1.0)
        if c.id == "peak"
    )


@pytest.mark.parametrize(
    ("zeta", "height"), [(Fraction(1, 10**9), Fraction("0.9")), (Fraction(1, 10**4), Fraction("0.9"))]
)
def test_a_needle_that_stays_below_is_proven(zeta, height):
    """Control: the same resonance, not so high."""
    assert peak(resonant(zeta, height, between(100_000))).status is Outcome.PROVEN


def test_the_band_ends_at_a_needle_inside_it():
    """|1 − Q̃| ≤ 0.3 up to several rad/s but for a resonance at 2 rad/s."""
    smooth, needle = (
        next(
            c
            for c in certify(*subject(ASKED, resonant(Fraction(1, 10**9), height, Fraction(2))))
            if c.id == "bandwidth"
        )
        for height in (Fraction(0), Fraction(5))
    )
    assert smooth.margin > 4
    assert Fraction(19, 10) < needle.margin < 2 <= needle.refuted_at.value < Fraction(21, 10)


def test_passivity_lost_in_a_needle():
    """Re(Z/jω) dips below 0 only within a part in 10⁹ of one frequency."""
    asked = spec(constraints={"eq9": None, "eq18": None, "peak": None}, actuator={"type": "ideal"})
    omega = between(100_000)
    for height, expected in ((Fraction(0), Outcome.PROVEN), (Fraction(5), Outcome.REFUTED)):
        setting, C = subject(asked, resonant(Fraction(1, 10**9), height, omega))
        claim = next(c for c in certify(setting, C) if c.form == "structured")
        assert claim.status is expected
    assert abs(claim.refuted_at.witness.omega / omega - 1) < Fraction(1, 10**6)
    grid = np.geomspace(LOW, HIGH, 100_000)
    for load in setting.uncertainty.corners():
        assert np.all((setting.loop.Z(C, load).at(grid) / (1j * grid)).real > 0)
