"""Controller families: few exact digits, starts inside their bounds, each contained in the next larger one."""

from __future__ import annotations

from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest

from robimp.synthesis.solve.classical import FORMS, Classical
from robimp.synthesis.solve.structure import DIGITS, Feedback, QFilter, Structure, contained, convolve
from robimp.synthesis.spec.model import FORMS as SPEC_FORMS

FAMILIES: list[Structure] = [*map(QFilter, range(2, 9)), *map(Feedback, range(5)), *FORMS.values()]
OMEGA_0 = 37.3


def digits(value: Fraction) -> int:
    """Significant digits of an exact decimal; fails for a number that is none."""
    scaled, shift = value, 0
    while scaled.denominator != 1:
        scaled, shift = scaled * 10, shift + 1
        assert shift < 60, f"{value} is no decimal of few digits"
    return len(str(abs(scaled.numerator)).rstrip("0") or "0")


@pytest.mark.parametrize("family", FAMILIES, ids=str)
def test_a_start_lies_inside_the_bounds(family: Structure) -> None:
    low, high = family.bounds
    assert np.all(low < high)
    rng = np.random.default_rng(0)
    for _ in range(50):
        x = family.start(rng)
        assert x.shape == low.shape
        assert np.all(low <= x) and np.all(x <= high)
    assert not np.all(2 * high <= high), "a point outside is seen"


@pytest.mark.parametrize("family", FAMILIES, ids=str)
def test_a_start_is_a_stable_proper_filter(family: Structure) -> None:
    rng = np.random.default_rng(1)
    for _ in range(50):
        num, den = family.polynomials(family.start(rng))
        integral = isinstance(family, Classical) and family.integral
        assert np.all(np.roots(den).real < 0) or (integral and den[-1] == 0 and np.all(np.roots(den[:-1]).real < 0))
        filtered = isinstance(family, Classical) and family.filtered
        assert len(den) - len(num) == (2 if isinstance(family, QFilter) else int(filtered))
        if isinstance(family, QFilter):
            assert 0 < num[-1] / den[-1] < 1, "Q(0) starts below 1"


@pytest.mark.parametrize("family", FAMILIES, ids=str)
def test_a_rounded_controller_is_exact_decimals_of_few_digits(family: Structure) -> None:
    rng = np.random.default_rng(2)
    for _ in range(10):
        x = family.start(rng)
        shipped = family.rounded(x, OMEGA_0)
        for exact in (*shipped.numerator, *shipped.denominator):
            assert isinstance(exact, Fraction) and digits(exact) <= DIGITS
        num, den = family.polynomials(x)
        s = np.array([0.1, 1.0, 10.0]) * 1j * OMEGA_0
        wanted = np.polyval(num, s / OMEGA_0) / np.polyval(den, s / OMEGA_0)
        numerator, denominator = ([float(c) for c in part] for part in (shipped.numerator, shipped.denominator))
        got = np.polyval(numerator, s) / np.polyval(denominator, s)
        np.testing.assert_allclose(got, wanted, rtol=10.0 ** (2 - DIGITS))


def test_an_unrounded_coefficient_would_be_seen() -> None:
    assert digits(Fraction(Decimal("0.00123456"))) == 6
    assert digits(Fraction(Decimal("1.234567"))) == 7
    assert digits(Fraction(0.1)) > DIGITS, "the double next to 0.1 is not 0.1"
    with pytest.raises(AssertionError):
        digits(Fraction(1, 3))


PAIRS = [(family, simpler) for family in [*FAMILIES, *map(Feedback, range(5, 9))] for simpler in family.simpler]


@pytest.mark.parametrize(("family", "smaller"), PAIRS, ids=str)
def test_extending_a_family_keeps_the_controller(family: Structure, smaller: Structure) -> None:
    assert smaller.bounds[0].size < family.bounds[0].size
    low, high = family.bounds
    p = 1j * np.geomspace(0.01, 100, 30)
    added_filter = getattr(family, "filtered", False) and not getattr(smaller, "filtered", False)

    def value(structure: Structure, parameters: np.ndarray) -> np.ndarray:
        num, den = structure.polynomials(parameters)
        return np.polyval(num, p) / np.polyval(den, p)

    for seed in range(20):
        rng = np.random.default_rng(seed)
        x = smaller.start(rng)
        larger = family.extended(x, rng, smaller)
        assert larger.shape == low.shape and np.all(low <= larger) and np.all(larger <= high)
        up_to = 1.01e-3 if added_filter else 1e-9  # at 100 ω₀, of a corner at 10⁵ ω₀
        np.testing.assert_allclose(value(family, larger), value(smaller, x), rtol=up_to)
        larger[0] += 0.01
        assert not np.allclose(value(family, larger), value(smaller, x), rtol=2 * up_to)


def test_every_form_that_is_contained_is_searched_first() -> None:
    """Whatever has no integrator the form has not, no lead and no filter; each after those it contains itself."""
    for form in FORMS.values():
        if isinstance(form, Classical):
            chain = contained(form)
            within = {
                f
                for f in FORMS.values()
                if isinstance(f, Classical)
                and (f.integral, f.lead <= form.lead, f.filtered <= form.filtered) == (form.integral, True, True)
            }
            assert set(chain) == within and len(chain) == len(within) and chain[-1] == form
            assert all(chain.index(s) < chain.index(f) for f in chain for s in f.simpler)
    assert contained(Feedback(6)) == [Feedback(n) for n in range(7)]
    assert contained(QFilter(8)) == [QFilter(n) for n in (2, 4, 6, 8)]


def test_the_simplest_families_have_nothing_below() -> None:
    assert QFilter(2).simpler == () and Feedback(0).simpler == () and FORMS["pi"].simpler == ()
    with pytest.raises(NotImplementedError):
        Structure.extended(Feedback(0), np.zeros(1), np.random.default_rng(0), Feedback(0))


def test_order_2_is_the_papers_filter() -> None:
    """(23) with α = 0.8, ω = 50 rad/s, ζ = 0.7075."""
    x = np.array([np.log(50 / OMEGA_0), 0.7075, 0.8])
    shipped = QFilter(2).rounded(x, OMEGA_0)
    assert shipped.numerator == (Fraction(2000),)
    assert shipped.denominator == (Fraction(1), Fraction("70.75"), Fraction(2500))


def test_products_of_polynomials() -> None:
    assert convolve([1, 2], [3, 4, 5]) == [3, 10, 13, 10]
    assert convolve([1, 2], [3, 4, 5]) == list(np.polymul([1, 2], [3, 4, 5]))


CLASSICAL = {  # coefficients of p for k = 2, ω_i = 0.5, ω_z = 3, ω_p = 10, ω_f = 40
    "p": ([2], [1]),
    "pi": ([2, 1], [1, 0]),
    "lead-lag": ([20 / 3, 20], [1, 10]),
    "pi-lead": (np.polymul([2, 1], [10 / 3, 10]), [1, 10, 0]),
    "p-filtered": ([80], [1, 40]),
    "pi-filtered": ([80, 40], [1, 40, 0]),
    "lead-lag-filtered": ([800 / 3, 800], np.polymul([1, 10], [1, 40])),
    "pi-lead-filtered": (np.polymul([80, 40], [10 / 3, 10]), np.polymul([1, 10, 0], [1, 40])),
}


@pytest.mark.parametrize("name", CLASSICAL)
def test_a_form_has_the_factors_of_its_name(name: str) -> None:
    family = FORMS[name]
    assert isinstance(family, Classical)
    values = [2.0, *[0.5] * ("pi" in name), *[3.0, 10.0] * ("lead" in name), *[40.0] * name.endswith("filtered")]
    num, den = family.polynomials(np.log(values))
    np.testing.assert_allclose(num, CLASSICAL[name][0], rtol=1e-12)
    np.testing.assert_allclose(den, CLASSICAL[name][1], rtol=1e-12)
    assert set(FORMS) == {*CLASSICAL, "eq23"} == {form for forms in SPEC_FORMS.values() for form in forms}


def test_a_filtered_form_is_not_shipped_without_its_filter() -> None:
    """The checker counts its poles: what has no filter is only a start for it."""
    lead = FORMS["pi-lead-filtered"]
    assert lead.includes(FORMS["pi-filtered"]) and not lead.includes(FORMS["pi-lead"])
    assert FORMS["pi-lead"].includes(FORMS["pi"]) and QFilter(6).includes(QFilter(4))
