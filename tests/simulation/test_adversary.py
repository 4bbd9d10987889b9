"""Attacks: inside what is proven they fail, outside they succeed; a claim that says too much is contradicted."""

import json
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from certified import golden

from robimp.models.rational import fraction
from robimp.synthesis.certificate.claim import Refutation
from robimp.synthesis.certificate.outcome import Outcome
from robimp.synthesis.challenge import challenge
from robimp.synthesis.challenge.attack import NEAR
from robimp.synthesis.challenge.company import environments, friction, real_joints
from robimp.synthesis.challenge.levels import levels
from robimp.synthesis.challenge.limits import boxes, deltas, discs, partners
from robimp.synthesis.challenge.perturbed import compensator, tolerance
from robimp.synthesis.challenge.proven import Subject, nominal_load
from robimp.synthesis.errors import InputError
from robimp.synthesis.simulation import members
from robimp.synthesis.simulation.adversary.population import Reality, population
from robimp.synthesis.simulation.adversary.stretched import stretch_of, vertices
from robimp.synthesis.simulation.batch.switched import Imperfections

FEW = {"haninger2016-paper": 40, "sampled-range": 19, "feedback-both": 12, "weight-disc": 12}
ATTACKS = {"level": levels, "Δ": deltas, "box": boxes, "partner": partners, "discs": discs}


def quiet(_):
    """No progress."""


def subject(name, claims=None, **changed):
    given = golden(name)
    claims = {(claim.id, claim.form): claim for claim in (given.claims if claims is None else claims)}
    return Subject(given.spec.model_copy(update=changed), given.C, claims)


def lying(name, id, form, **lie):
    """The certificate's claims, one of them changed."""
    return subject(name, [replace(c, **lie) if (c.id, c.form) == (id, form) else c for c in golden(name).claims])


@pytest.fixture(scope="module")
def attacked():
    found = {}

    def of(name):
        if name not in found:
            spec, C, claims, coefficients = golden(name)
            found[name] = challenge(
                spec, C, claims, count=FEW[name], seed=1, progress=quiet, coefficients=coefficients
            )  # fmt: skip
        return found[name]

    return of


class TestHonestClaims:
    @pytest.mark.parametrize("name", FEW)
    def test_nothing_contradicts(self, attacked, name):
        assert attacked(name).contradictions == ()
        assert len(attacked(name).drawn.loads) >= FEW[name]

    @pytest.mark.parametrize("name", FEW)
    def test_every_bound_is_reached_within_five_percent(self, attacked, name):
        found = {each.claim: each.share for each in attacked(name).reached}
        proven = {f"{c.id} {c.form}" for c in golden(name).claims if c.status is Outcome.PROVEN}
        without = {"eq12 paper", "stability-free winding", "stability-locked winding"}  # no figure to reach
        assert proven <= set(found)
        assert {claim: share for claim, share in found.items() if share is None or share < NEAR}.keys() <= without

    @pytest.mark.parametrize(
        ("name", "claims"),
        [
            ("haninger2016-paper", "bandwidth attenuation, eq9 printed, eq18 half-plane/physical, stability-free box"),
            ("haninger2016-paper", "eq12 structured"),
            ("sampled-range", "bandwidth attenuation, eq18 half-plane/physical, stability-free box, eq12 structured"),
            ("sampled-range", "tolerance coefficients"),
            ("feedback-both", "bandwidth attenuation, eq9 printed, eq18 half-plane/physical, stability-free box"),
            ("weight-disc", "bandwidth attenuation, eq9 printed, eq18 half-plane/frozen"),
        ],
    )
    def test_just_outside_something_gives(self, attacked, name, claims):
        for claim in claims.split(", "):
            outside = [f.agrees for f in attacked(name).findings if f.claim == claim and f.side == "outside"]
            assert set(outside) == {True}, claim

    def test_the_same_seed_draws_the_same_joints(self, attacked):
        spec, C, *_ = golden("haninger2016-paper")
        first, again = attacked("haninger2016-paper").drawn, population(spec, C, 40, 10.0, 1, quiet)
        assert (again.loads == first.loads).all()
        assert (again.lowest_energy == first.lowest_energy).all()
        assert not (population(spec, C, 40, 10.0, 2, quiet).loads == again.loads).all()


LIES = [
    ("level", "haninger2016-paper", "peak", "sensitivity", "1.51"),
    ("level", "haninger2016-paper", "rendering", "every-load", "0.083"),
    ("level", "haninger2016-paper", "eq12", "structured", "0.0999"),
    ("level", "haninger2016-paper", "stability-free", "hurwitz", "5.83"),
    ("level", "haninger2016-paper", "stability-locked", "hurwitz", "26.4"),
    ("level", "sampled-range", "peak", "sensitivity", "1.59"),
    ("level", "sampled-range", "rendering", "every-load", "0.0822"),
    ("level", "sampled-range", "eq12", "structured", "0.0798"),
    ("level", "sampled-range", "noise", "command", "0.799"),
    ("level", "feedback-both", "rendering", "every-load", "0.032"),
    ("level", "feedback-both", "friction", "strictly-positive-real", "1.178"),
    ("level", "weight-disc", "eq12", "disc", "0.481"),
    ("level", "weight-disc", "rendering", "every-load", "0.0162"),
    ("Δ", "haninger2016-paper", "eq18", "half-plane/physical", "1.6"),
    ("Δ", "sampled-range", "eq18", "half-plane/physical", "1.6"),
    ("Δ", "feedback-both", "eq9", "printed", "5.85"),
    ("Δ", "weight-disc", "eq18", "half-plane/frozen", "26.6"),
    ("box", "haninger2016-paper", "stability-free", "box", "3.7"),
    ("box", "sampled-range", "stability-free", "box", "3.42"),
]


class TestFalseClaims:
    @pytest.mark.parametrize(("attack", "name", "id", "form", "margin"), LIES, ids=[" ".join(lie[1:]) for lie in LIES])
    def test_a_margin_that_is_too_good_is_contradicted(self, attack, name, id, form, margin):
        found = ATTACKS[attack](lying(name, id, form, margin=Fraction(margin)))
        assert [f.agrees for f in found if f.claim == f"{id} {form}" and f.side == "inside"] == [False]

    def test_a_band_that_is_too_wide_is_contradicted(self):
        found = levels(lying("sampled-range", "bandwidth", "attenuation", interval=(Fraction(0), Fraction("8.84"))))
        assert any(f.claim == "bandwidth attenuation" and f.agrees is False for f in found)

    def test_a_tolerance_that_is_too_wide_is_contradicted(self):
        wide = lying("sampled-range", "tolerance", "coefficients", margin=Fraction(1, 20))
        found = tolerance(wide, golden("sampled-range").coefficients, seed=0)
        assert {f.what.split(":")[0] for f in found if f.agrees is False} == {"bandwidth attenuation"}

    def test_a_disc_on_top_that_stability_does_not_survive_is_contradicted(self):
        heavy = golden("feedback-both").spec.uncertainty.weight
        heavy = heavy.model_copy(update={"numerator": tuple(40 * c for c in heavy.numerator)})
        uncertainty = golden("feedback-both").spec.uncertainty.model_copy(update={"weight": heavy})
        assert [f.agrees for f in discs(subject("feedback-both"))] == [True]
        assert [f.agrees for f in discs(subject("feedback-both", uncertainty=uncertainty))] == [False]

    def test_a_robustness_that_is_not_there_is_contradicted_by_the_joints_drawn(self):
        spec, C, claims, _ = golden("haninger2016-paper")
        box = spec.uncertainty.box.model_copy(
            update={"inertia": (Fraction("0.005"), Fraction("0.06")), "damping": (Fraction(-1, 10), Fraction(1, 2))}
        )
        wider = spec.model_copy(update={"uncertainty": spec.uncertainty.model_copy(update={"box": box})})
        found = challenge(wider, C, claims, count=40, seed=0, progress=quiet)
        assert any("how many grew" in text for text in found.contradictions)
        assert any("energy drawn" in text for text in found.contradictions)
        eq18 = tuple(c for c in claims if c.form not in ("box", "structured", "disc", "strictly-positive-real"))
        found = challenge(wider, C, eq18, count=40, seed=0, progress=quiet)
        assert any("how many grew" in text for text in found.contradictions), "(18) alone makes every load stable"
        assert not any("energy drawn" in text for text in found.contradictions)

    @pytest.mark.parametrize("name", ["haninger2016-paper", "sampled-range"])
    def test_a_refuted_passivity_is_driven_unstable_by_a_mass_and_a_spring(self, name):
        wish = golden(name).spec.impedance
        wish = wish.model_copy(update={"stiffness": Fraction(3), "damping": Fraction(1, 4)})
        believed = subject(name, impedance=wish)
        refuted = [replace(c, status=Outcome.REFUTED) if c.id == "eq12" else c for c in golden(name).claims]
        (driven,) = partners(subject(name, refuted, impedance=wish))
        assert driven.agrees is True and driven.measured > 0
        assert [f.agrees for f in partners(believed) if f.side == "inside"] == [False]

    def test_a_joint_that_is_not_passive_is_seen_among_passive_environments(self):
        wish = golden("haninger2016-paper").spec.impedance
        wish = wish.model_copy(update={"stiffness": Fraction(12), "damping": Fraction(1, 10)})
        found = list(environments(subject("haninger2016-paper", impedance=wish)))
        assert any(f.agrees is False for f in found) and all(f.side == "inside" for f in found)


def claimed(name, id, form):
    """One claim of a certificate."""
    return next(c for c in golden(name).claims if (c.id, c.form) == (id, form))


def twin(name, id, form, value):
    """The certificate's claims, one of them with another level at which it is said to fail."""
    return lying(name, id, form, refuted_at=replace(claimed(name, id, form).refuted_at, value=Fraction(value)))


class TestJustOutside:
    @pytest.mark.parametrize("value", ["1.2", "9"])
    def test_the_stretch_is_that_of_the_joint_moved_whatever_the_claim_says(self, value):
        """Nominal I = 0.03 ± 0.006: the witness's inertia, 1.02 times as far, tells the stretch."""
        inertia = claimed("haninger2016-paper", "stability-free", "box").refuted_at.witness.load.inertia
        (outside,) = [
            f for f in boxes(twin("haninger2016-paper", "stability-free", "box", value)) if f.side != "inside"
        ]
        stretch = 1.02 * (0.03 - float(fraction(inertia))) / 0.006
        assert f"{stretch:.6g} × the box holds it" in outside.what
        assert outside.measured is None or outside.measured == pytest.approx(stretch, rel=1e-6)

    def test_a_joint_of_several_boxes_is_measured_by_the_parameter_furthest_out(self):
        spec, nominal = golden("sampled-range").spec, nominal_load(golden("sampled-range").spec)
        for k in (-2.0, 0.5, 3.0):
            corner = vertices(spec, abs(k))[0 if k < 0 else -1]
            assert stretch_of(spec, next(iter(members(spec))).spec, corner) == pytest.approx(abs(k))
        wish = next(iter(members(spec))).spec.impedance
        low, high = spec.impedance.stiffness
        moved = wish.model_copy(update={"stiffness": high + (high - low)})  # two half-ranges beyond the end
        joint = spec.model_copy(update={"impedance": moved})
        assert stretch_of(spec, joint, vertices(spec, 2.0)[0]) == pytest.approx(3.0)
        assert (
            stretch_of(spec, next(iter(members(spec))).spec, nominal + np.array([0, 0, 1.0])) == np.inf
        )  # K is certain

    @pytest.mark.parametrize(
        ("attack", "name", "id", "form", "value"),
        [
            ("box", "haninger2016-paper", "stability-free", "box", "1.2"),
            ("box", "sampled-range", "stability-free", "box", "3.2"),
            ("Δ", "haninger2016-paper", "eq18", "half-plane/physical", "1.4"),
            ("Δ", "feedback-both", "eq9", "printed", "2"),
            ("Δ", "weight-disc", "eq18", "half-plane/frozen", "20"),
            ("level", "haninger2016-paper", "bandwidth", "attenuation", "8"),
            ("level", "haninger2016-paper", "peak", "sensitivity", "1.89"),
            ("level", "haninger2016-paper", "rendering", "every-load", "0.2"),
            ("level", "haninger2016-paper", "eq12", "structured", "0.05"),
            ("level", "haninger2016-paper", "stability-free", "hurwitz", "5.8"),
            ("level", "haninger2016-paper", "stability-locked", "hurwitz", "20"),
            ("level", "sampled-range", "noise", "command", "0.9"),
            ("level", "weight-disc", "eq12", "disc", "0.3"),
            ("level", "sampled-range", "bandwidth", "attenuation", "8.8"),
        ],
    )
    def test_a_claim_that_still_holds_where_it_is_said_to_fail_is_contradicted(self, attack, name, id, form, value):
        found = ATTACKS[attack](twin(name, id, form, value))
        assert [f.agrees for f in found if f.claim == f"{id} {form}" and f.side == "outside"] == [False]

    def test_a_tolerance_that_its_own_witness_meets_is_contradicted(self):
        harmless = replace(claimed("sampled-range", "tolerance", "coefficients").refuted_at.witness, omega=Fraction(1))
        beyond = Refutation(Fraction("1e-6"), harmless)
        given = lying("sampled-range", "tolerance", "coefficients", refuted_at=beyond)
        found = tolerance(given, golden("sampled-range").coefficients, seed=0)
        assert [f.agrees for f in found if f.side == "outside"] == [False]

    def test_what_cannot_be_expected_is_counted_and_says_why(self):
        spec, C, claims, coefficients = golden("haninger2016-paper")
        nowhere = Refutation(claimed("haninger2016-paper", "stability-free", "box").refuted_at.value, None)
        unnamed = tuple(replace(c, refuted_at=nowhere) if c.form == "box" else c for c in claims)
        found = challenge(spec, C, unnamed, count=4, seed=0, progress=quiet, coefficients=coefficients)
        assert {f.claim for f in found.not_shown} >= {"stability-free box"}
        assert all(f.why and f"NOT SHOWN: {f.why}" in str(f) for f in found.not_shown)
        assert f"{len(found.not_shown)} could not be shown" in found.summary() and found.contradictions == ()

    def test_the_papers_form_is_measured_and_need_not_be_tight(self):
        given = lying("haninger2016", "eq12", "paper", refuted_at=Refutation(Fraction("1.00001"), None))
        inside, beyond = [f for f in levels(given) if f.claim == "eq12 paper"]
        assert inside.side == "inside" and inside.agrees and inside.measured > 0
        assert beyond.not_shown and "only sufficient" in beyond.why

    def test_a_form_that_is_only_sufficient_need_not_fail_where_it_does(self):
        given = [
            replace(c, form="lumped/physical", refuted_at=replace(c.refuted_at, value=Fraction("1.2")))
            for c in golden("haninger2016-paper").claims if c.id == "eq18"
        ]  # fmt: skip
        (said,) = [f for f in deltas(subject("haninger2016-paper", given)) if f.side == "outside"]
        assert said.not_shown and said.why == "this form is only sufficient" and said.measured is None


class TestReality:
    def test_is_met_by_the_same_joints_and_contradicts_nothing(self):
        spec, C, *_ = golden("haninger2016-paper")
        slow = Reality(Imperfections(load_friction=0.01), rate=40.0)  # too slow to be stable
        ideal, real = (population(spec, C, 8, 5.0, 0, quiet, *reality) for reality in ((), (slow,)))
        assert (ideal.loads == real.loads).all() and real.grew.any() and not ideal.grew.any()
        findings = list(real_joints(slow, real, ideal))
        assert {(f.side, f.agrees) for f in findings} == {("information", None)}
        assert "load friction 0.01, sampled at 40 Hz" in findings[0].what and findings[0].measured == real.grew.sum()
        json.dumps([f.to_json() for f in findings], allow_nan=False)

    def test_the_joints_of_ranges_are_the_same_at_every_rate(self):
        spec, C, *_ = golden("sampled-range")
        drawn = [population(spec, C, 40, 0.1, 0, quiet, Reality(rate=rate)).loads for rate in (500.0, 2000.0)]
        assert (drawn[0] == drawn[1]).all()

    def test_single_precision_needs_a_sampled_controller_and_differs_little(self):
        spec, C, *_ = golden("haninger2016-paper")
        with pytest.raises(InputError, match="rate"):
            population(spec, C, 8, 5.0, 0, quiet, Reality(arithmetic="float32"))
        double, single = (
            population(spec, C, 4, 5.0, 0, quiet, Reality(rate=1000.0, arithmetic=kind)).largest_angle
            for kind in ("float64", "float32")
        )
        assert 1e-9 < abs(double - single).max() < 1e-3


class TestFriction:
    def test_claimed_rest_is_contradicted_by_hunting(self):
        spec, C, claims, _ = golden("haninger2016-paper")
        dry = next(c for c in claims if c.id == "friction")
        claimed = {("friction", dry.form): replace(dry, status=Outcome.PROVEN, refuted_at=None)}
        integrating = ((Fraction(2500),), (Fraction(1), Fraction("70.75"), Fraction(0)))  # Q(0) = 1
        assert [f.agrees for f in friction(Subject(spec, C, claimed))] == [True]
        (hunting,) = friction(Subject(spec, integrating, claimed))
        assert hunting.agrees is False and hunting.measured > 2 and "hunts" in hunting.what

    def test_proven_rest_is_rest(self, attacked):
        assert [f.agrees for f in attacked("feedback-both").findings if "Coulomb friction" in f.what] == [True]


def test_the_compensator_of_coefficients_is_that_of_the_certificate():
    for name in FEW:
        spec, C, _, coefficients = golden(name)
        mine, s = compensator(spec, coefficients), 0.3 + 2j
        value = [np.polyval([float(c) for c in n], s) / np.polyval([float(c) for c in d], s) for n, d in (mine, C)]
        assert value[0] == pytest.approx(value[1], rel=1e-12)
