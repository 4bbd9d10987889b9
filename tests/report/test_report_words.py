"""Numbers, specifications and formulas as a reader sees them."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
import pytest

from robimp.synthesis.certificate.claim import Claim
from robimp.synthesis.certificate.outcome import Outcome
from robimp.synthesis.report.html.figure import opened, rounded
from robimp.synthesis.report.html.mathml import transfer
from robimp.synthesis.report.html.words import described, load_names, margin, number, quantity, span, symbols
from robimp.synthesis.simulation import Load
from robimp.synthesis.spec import load_spec
from robimp.synthesis.spec.model import Polynomials

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (Fraction(3, 100), "0.03"),
        (Fraction(0), "0"),
        (Fraction(-5, 2), "−2.5"),
        (Fraction(1, 3), "≈ 0.333333"),
        (Fraction(5036329, 125000), "40.290632"),
        (Fraction(40290632123, 10**9), "≈ 40.2906"),
        (Fraction(547587, 10**11), "5.47587·10⁻⁶"),
        (Fraction(249070), "249070"),
        (Fraction(7392570), "7.39257·10⁶"),
        (Fraction(10**400), "1·10⁴⁰⁰"),
        (Fraction(1, 10**400), "1·10⁻⁴⁰⁰"),
        (0.1 + 0.2, "0.3"),
        (2.0, "2"),
    ],
)
def test_numbers(value: Fraction | float, text: str) -> None:
    assert number(value) == text


def test_intervals() -> None:
    assert span(Fraction(0), None) == "[0, ∞]"
    assert span(Fraction(1, 3), Fraction(40284289, 10**6)) == "[0.333334, 40.2842]", (
        "inwards: proven on what is printed"
    )
    assert quantity((Fraction(8, 10), Fraction(12, 10)), "kg", Fraction(1)) == "1 kg ± 20 %"
    assert quantity((Fraction(1), Fraction(3)), "kg", Fraction(1)) == "1 … 3 kg (nominal 1)"
    assert quantity((Fraction(1), Fraction(3)), "kg") == "1 … 3 kg"
    assert quantity((Fraction(0), Fraction(0)), "kg") == "0 kg"


def test_a_specification_in_words() -> None:
    words = dict(described(load_spec(EXAMPLES / "haninger2016-sampled.yaml")))
    assert "stiffness 0.2 … 10 N·m/rad: one controller for the whole range" in words["Should feel like"]
    assert words["Sampled"] == "hold of 1 ms (1000 Hz), computation delay 1 ms"
    assert "inertia 0.03 kg·m² ± 20 %" in words["Load"]
    words = dict(described(load_spec(EXAMPLES / "haninger2016-feedback.yaml")))
    assert "Sampled" not in words and words["Controller"].startswith("dynamic-error feedback (20)")


def test_symbols_are_typeset_and_names_are_not() -> None:
    assert symbols("[0, ω_B], K_sp") == "[0, <i>ω</i><sub>B</sub>], <i>K</i><sub>sp</sub>"
    assert symbols("<b>b_m") == "&lt;b&gt;<i>b</i><sub>m</sub>"
    for name in ("motor_damping", "plant.k_1.x_y_z", "haninger_B", "a_", "2_B"):
        assert "<sub>" not in symbols(name), name


def test_a_margin_is_proven_at_its_printed_value() -> None:
    claim = {"id": "a", "equation": "", "statement": "", "uncertainty": "", "interval": (Fraction(0), None)}

    def said(form: str, value: str, motion: str = "rotary") -> str:
        of = Claim(**claim, form=form, required=True, status=Outcome.PROVEN, margin=Fraction(value), refuted_at=None)  # type: ignore[arg-type]
        return margin(of, motion)

    assert said("attenuation", "40.284289") == "ω_B ≥ 40.2842 rad/s"
    assert said("sensitivity", "1.32950001") == "peak ≤ 1.32951"
    assert said("structured", "8.202849e-6", "linear") == "8.20284·10⁻⁶ N·s/m to spare"


def formula(numerator: tuple[Fraction, ...], denominator: tuple[Fraction, ...], name: str = "Q") -> str:
    """The text of a formula, which is well-formed."""
    return "".join(ET.fromstring(transfer(name, Polynomials(numerator=numerator, denominator=denominator))).itertext())


def test_formulas() -> None:
    one = Fraction(1)
    assert formula((Fraction(-2),), (one, Fraction(0), Fraction(-3, 2))) == "Q(s)=−2s2−1.5"
    assert formula((Fraction(0),), (one,)) == "Q(s)=01"
    assert formula((one, one), (one / 3, one)) == "Q(s)≈s+10.333333s+1"
    assert formula((Fraction(7392570),), (one,), "C_imp") == "Cimp(s)=7.39257·1061"
    assert "<msub><mi>C</mi><mi>imp</mi></msub>" in transfer("C_imp", Polynomials(numerator=(one,), denominator=(one,)))


def test_loads_are_named_by_what_differs() -> None:
    one, two = Load(Fraction(1), Fraction(2), Fraction(0)), Load(Fraction(1), Fraction(3), Fraction(0))
    assert load_names([one, two]) == ["nominal", "B=3"]


def test_plot_data_is_finite_and_short() -> None:
    assert rounded([1 / 3, np.nan, np.inf, None, 2]) == [0.33333, None, None, None, 2.0]


def test_an_axis_shows_everything_but_extremes() -> None:
    values = np.concatenate([np.linspace(0, 1, 1000), [1e9, np.nan]])
    low, high = opened([values], log=False)
    assert low <= 0 and 1 <= high < 5
    low, high = opened([values], log=False, include=[7])
    assert high > 7
    assert opened([np.array([np.nan])], log=True) == [-1, 1]
