"""Attacks: inside what is proven they fail, outside they succeed; a claim that says too much is contradicted."""

import json
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from robimp.synthesis.certificate.claims import certify
from robimp.synthesis.certificate.outcome import Outcome
from robimp.synthesis.challenge import challenge
from robimp.synthesis.pipeline import realizable, setting_of
from robimp.synthesis.simulation.adversary.delta import CHECKED, attack, bound_of
from robimp.synthesis.simulation.adversary.friction import rest_under_friction
from robimp.synthesis.simulation.adversary.motion import left_alone
from robimp.synthesis.simulation.adversary.population import drawn, population
from robimp.synthesis.simulation.adversary.stretched import stretch_to_yield, vertices, worst_poles
from robimp.synthesis.spec import from_canonical
from robimp.synthesis.spec.model import Polynomials

GOLDEN = Path(__file__).parents[1] / "data" / "golden"
BAND = (0.1, 1000.0)


def quiet(_):
    """No progress."""


def given(name):
    certificate = json.loads((GOLDEN / f"{name}.json").read_bytes())
    spec = from_canonical(certificate["spec"])
    written = certificate["controller"]
    of = {
        key: Polynomials(**{part: tuple(map(Fraction, row)) for part, row in written[key].items()})
        for key in written
        if key in "QC"
    }
    setting = setting_of(spec)
    claims = certify(setting, realizable(setting, of["Q"] if spec.controller.type == "dob" else of["C"]))
    return spec, (of["C"].numerator, of["C"].denominator), claims


@pytest.fixture(scope="module")
def paper():
    return given("haninger2016-paper")


@pytest.fixture(scope="module")
def attacked(paper):
    spec, C, claims = paper
    return challenge(spec, C, claims, count=40, seed=1, progress=quiet)


class TestHonestClaims:
    def test_nothing_contradicts(self, attacked):
        assert attacked.contradictions == ()

    @pytest.mark.parametrize(
        "claim",
        [
            "bandwidth attenuation",
            "peak sensitivity",
            "rendering every-load",
            "eq12 structured",
            "stability-free hurwitz",
        ],
    )
    def test_every_level_is_reached_within_five_percent(self, attacked, claim):
        assert max(f.tightness or 0 for f in attacked.findings if f.claim == claim and f.side == "inside") >= 0.95

    @pytest.mark.parametrize(
        "claim",
        ["bandwidth attenuation", "eq9 printed", "eq18 half-plane/physical", "stability-free box", "eq12 structured"],
    )
    def test_just_outside_something_gives(self, attacked, claim):
        assert [f.agrees for f in attacked.findings if f.claim == claim and f.side == "outside"] == [True]

    def test_the_same_seed_draws_the_same_joints(self, paper, attacked):
        spec, C, _ = paper
        again = population(spec, C, 40, 10.0, 1, quiet)
        assert (again.loads == attacked.drawn.loads).all()
        assert (again.lowest_energy == attacked.drawn.lowest_energy).all()
        assert not (population(spec, C, 40, 10.0, 2, quiet).loads == again.loads).all()


class TestFalseClaims:
    @pytest.mark.parametrize(
        ("id", "form", "margin"),
        [
            ("peak", "sensitivity", "1.51"),
            ("rendering", "every-load", "0.083"),
            ("eq12", "structured", "0.0999"),
            ("stability-free", "hurwitz", "5.83"),
            ("stability-free", "box", "3.7"),
            ("bandwidth", "attenuation", "8.9"),
            ("eq18", "half-plane/physical", "1.6"),
        ],
    )
    def test_a_margin_that_is_too_good_is_contradicted(self, paper, id, form, margin):
        spec, C, claims = paper
        lies = tuple(
            replace(claim, margin=Fraction(margin)) if (claim.id, claim.form) == (id, form) else claim
            for claim in claims
        )
        found = challenge(spec, C, lies, count=8, seed=0, progress=quiet)
        assert any(text.startswith(f"{id} {form}, inside") for text in found.contradictions)

    def test_a_robustness_that_is_not_there_is_contradicted_by_the_joints_drawn(self, paper):
        spec, C, claims = paper
        box = spec.uncertainty.box.model_copy(
            update={"inertia": (Fraction("0.005"), Fraction("0.06")), "damping": (Fraction(-1, 10), Fraction(1, 2))}
        )
        wider = spec.model_copy(update={"uncertainty": spec.uncertainty.model_copy(update={"box": box})})
        found = challenge(wider, C, claims, count=40, seed=0, progress=quiet)
        assert any("how many grew" in text for text in found.contradictions)
        assert any("energy drawn" in text for text in found.contradictions)

    def test_a_refuted_passivity_is_driven_unstable_by_a_mass_and_a_spring(self, paper):
        spec, C, claims = paper
        stiff = spec.impedance.model_copy(update={"stiffness": Fraction(3), "damping": Fraction(1, 4)})
        spec = spec.model_copy(update={"impedance": stiff})
        refuted = tuple(replace(c, status=Outcome.REFUTED) if c.id == "eq12" else c for c in claims)
        found = challenge(spec, C, refuted, count=8, seed=0, progress=quiet)
        partner = next(
            f for f in found.findings if f.claim == "eq12 structured" and "mass" in f.what and f.side == "outside"
        )
        assert partner.agrees is True and partner.measured > 0
        believed = challenge(spec, C, claims, count=8, seed=0, progress=quiet)
        assert any("on spring" in text for text in believed.contradictions)


class TestDelta:
    def test_stays_within_its_bound_everywhere_and_reaches_it_where_it_counts(self, paper):
        spec, C, _ = paper
        bound = bound_of(spec)
        tried = attack(spec, C, bound, 1.53, BAND)
        omega = CHECKED * tried.omega
        value = np.polyval(tried.numerator, 1j * omega) / np.polyval(tried.denominator, 1j * omega)
        assert (abs(value) <= 1.53 * bound(omega) * (1 + 1e-9)).all()
        assert (np.roots(tried.denominator).real < 0).all(), "Δ itself is stable"
        assert tried.reach > 1 and left_alone(tried.joint(spec, C), tried.omega).grows

    def test_the_bound_of_a_box_covers_every_load_and_no_more(self, paper):
        spec, _, _ = paper
        s = 1j * np.geomspace(0.01, 1000, 50)
        inertia, damping, stiffness = drawn(spec, 2000, np.random.default_rng(0)).T[:, :, None]
        true = inertia * s**2 + damping * s + stiffness
        found = abs((0.03 * s**2 + 0.2 * s) / true - 1).max(axis=0)
        W = bound_of(spec)(s.imag)
        assert (found <= W * (1 + 1e-9)).all() and (found >= 0.98 * W).all()


class TestStretchedBox:
    def test_passivity_ends_where_the_resistance_turns(self, paper):
        spec, C, _ = paper
        limit = stretch_to_yield(spec, C, BAND)
        assert 1.25 < limit < 1.35
        assert worst_poles(spec, C, vertices(spec, limit)).max() < 0, "it is still stable"


class TestFriction:
    def test_rests_with_less_than_one_and_hunts_with_an_integrator(self, paper):
        spec, C, _ = paper
        assert rest_under_friction(spec, C, seconds=30).hunting == ()
        integrating = ((Fraction(2500),), (Fraction(1), Fraction("70.75"), Fraction(0)))  # Q(0) = 1
        assert rest_under_friction(spec, integrating, seconds=30).hunting
