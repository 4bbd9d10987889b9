"""Ranges of impedances and actuators: their ends are simulated; two-ports; what of it contradicts a certificate."""

import json
from collections import Counter
from dataclasses import replace
from fractions import Fraction
from itertools import combinations, product

import numpy as np
import pytest
from test_simulation import CORNER, DRIVE, PAPER, error, given, rational, star

from robimp.models.rational import descending
from robimp.synthesis.agreement import compare
from robimp.synthesis.certificate.claims import certify
from robimp.synthesis.problem.setting import Setting
from robimp.synthesis.simulation import (
    assemble,
    default_frequencies,
    loads,
    members,
    multisine,
    poles_against_wall,
    sampled_comparison,
    simulate,
    verify,
)
from robimp.synthesis.simulation.members import drawn_members
from robimp.synthesis.spec.model import ActuatorBox, Constraints, Eq12, Polynomials, Sampling, TwoPortActuator

Q = Polynomials(numerator=(Fraction(2000),), denominator=(Fraction(1), Fraction("70.75"), Fraction(2500)))
HELD = Sampling(rate=Fraction(1000), delay=Fraction("0.001"))
WISH = {"stiffness": (Fraction("1.1"), Fraction("1.4")), "damping": (Fraction("0.34"), Fraction("0.37"))}
BOX = {"motor_inertia": (Fraction("0.0099"), Fraction("0.0102")), "spring_stiffness": (Fraction("4.7"), Fraction(5))}


def ranged(wish=WISH, box=BOX, sampling=None, **options):
    spec = given(**options)
    uncertainty = spec.uncertainty.model_copy(update={"actuator": ActuatorBox(**box) if box else None})
    impedance = spec.impedance.model_copy(update=wish)
    constraints = Constraints(eq12=Eq12(form="structured"))
    return spec.model_copy(
        update={"impedance": impedance, "uncertainty": uncertainty, "sampling": sampling, "constraints": constraints}
    )


def certified(spec):
    setting = Setting.of(spec)
    C = setting.compensator(Q)
    return setting, C, certify(setting, C)


RANGES = {"plain": ({}, {}), "wish": (WISH, {}), "box": ({}, BOX)}


@pytest.fixture(scope="module")
def studied():
    """Setting, compensator and claims of a joint, and its trials: of each once."""
    found = {}

    def of(name, sampling):
        if (name, sampling) not in found:
            spec = ranged(*RANGES[name], sampling)
            found[name, sampling] = certified(spec), verify(spec, PAPER, quick=True)
        return found[name, sampling]

    return of


class TestMembers:
    def test_are_the_middle_and_then_every_vertex(self):
        first, *others = members(ranged())
        assert (first.impedance.stiffness, first.impedance.damping) == (Fraction("1.25"), Fraction("0.355"))
        assert (first.drive.motor_inertia, first.drive.spring_stiffness) == (Fraction("0.01"), Fraction("4.8"))
        ends = [(m.impedance.stiffness, m.impedance.damping, m.drive.motor_inertia, m.drive.spring_stiffness)
                for m in others]  # fmt: skip
        expected = product(WISH["stiffness"], WISH["damping"], BOX["motor_inertia"], BOX["spring_stiffness"])
        assert sorted(ends) == sorted(expected)
        for member in others:
            assert member.spec.impedance.stiffness == member.impedance.stiffness
            assert member.spec.actuator.motor_inertia == member.drive.motor_inertia
            assert member.spec.uncertainty.actuator is None

    def test_of_six_ranges_are_sixteen_in_which_any_two_meet_in_every_way(self):
        wish = {**WISH, "inertia": (Fraction("0.029"), Fraction("0.031"))}
        box = {**BOX, "motor_damping": (Fraction("0.04"), Fraction("0.06"))}
        others = list(members(ranged(wish, box)))[1:]
        rows = [(*vars(m.impedance).values(), *vars(m.drive).values()) for m in others]
        assert len(rows) == len(set(rows)) == 16
        for i, j in combinations(range(6), 2):
            assert set(Counter((row[i], row[j]) for row in rows).values()) == {4}

    def test_without_ranges_there_is_one_and_trials_say_so(self):
        (only,) = members(given())
        assert (only.spec, only.impedance, only.drive) == (given(), None, None)
        assert {(t.impedance, t.actuator) for t in verify(given(), PAPER, quick=True).trials} == {(None, None)}

    def test_drawn_ones_lie_inside_every_range_and_differ(self):
        drawn = drawn_members(ranged(), 20, np.random.default_rng(0))
        for name, (low, high) in WISH.items():
            assert all(low <= getattr(member.impedance, name) <= high for member in drawn)
        for name, (low, high) in BOX.items():
            assert all(low <= getattr(member.spec.actuator, name) <= high for member in drawn)
        assert len({str(member) for member in drawn}) == 20
        assert drawn_members(given(), 20, np.random.default_rng(0)) == []

    def test_an_interval_of_no_width_is_no_range(self):
        exact = (Fraction("0.01"), Fraction("0.01"))
        assert len(list(members(ranged({}, {"motor_inertia": exact})))) == 1


class TestVerify:
    @pytest.mark.parametrize("sampling", [None, HELD], ids=["continuous", "held"])
    def test_moves_every_member_and_measures_its_own_star(self, sampling):
        spec = ranged(sampling=sampling)
        trials = verify(spec, PAPER, quick=True)
        assert trials.stable
        found = {(t.impedance, t.actuator) for t in trials.trials}
        assert found == {(m.impedance, m.drive) for m in members(spec)}
        assert len(found) == 17
        assert {w.actuator for w in trials.other_walls} == {m.drive for m in list(members(spec))[1:]}
        of = {(m.impedance, m.drive): m.spec for m in members(spec)}
        middle = of[(trials.trials[0].impedance, trials.trials[0].actuator)]
        for trial in trials.trials:
            s, Z = 1j * np.array(trial.frequencies), np.array(trial.Z_measured)
            own = of[(trial.impedance, trial.actuator)]
            assert (error(Z, star(own, PAPER, trial.load, s)) <= trial.accuracy).all()
            if trial.kind == "multisine" and own is not middle:
                assert (error(Z, star(middle, PAPER, trial.load, s)) > 1e-3).any()
        assert {trial.load for trial in trials.trials} == set(loads(spec))
        assert json.loads(json.dumps(trials.to_json(), allow_nan=False)) == trials.to_json()

    def test_sees_a_member_that_is_unstable_where_the_middle_is_not(self):
        spec = ranged({"stiffness": (Fraction("-0.5"), Fraction(3))}, None)
        trials = verify(spec, PAPER, quick=True)
        assert trials.trials[0].stable
        assert {trial.impedance.stiffness for trial in trials.trials if not trial.stable} == {Fraction("-0.5")}
        assert not trials.stable

    def test_sampled_comparison_takes_the_middle(self):
        own = ranged()
        middle = next(members(own)).spec
        assert sampled_comparison(own, PAPER) == sampled_comparison(middle, PAPER)


class TestTwoPort:
    @staticmethod
    def of_the_drive(apart=False, sampling=None):
        """The series-elastic drive as H and Z_a; `apart`: over denominators that differ by a factor."""
        port = Setting.of(given()).loop.actuator
        h, z, d = (descending(p) for p in (port.h, port.z, port.d))
        scaled = tuple(2 * c for c in z), tuple(2 * c for c in d)
        impedance = Polynomials(numerator=scaled[0], denominator=scaled[1]) if apart else None
        actuator = TwoPortActuator(
            type="two-port",
            transfer=Polynomials(numerator=h, denominator=d),
            impedance=impedance or Polynomials(numerator=z, denominator=d),
        )
        return given(actuator=actuator, force="100").model_copy(update={"sampling": sampling})

    @pytest.mark.parametrize("sampling", [None, HELD], ids=["continuous", "held"])
    @pytest.mark.parametrize("apart", [False, True])
    def test_that_is_the_drive_moves_like_it(self, apart, sampling):
        elastic = given(force="100").model_copy(update={"sampling": sampling})
        spec = self.of_the_drive(apart, sampling)
        both = [assemble(each, PAPER, CORNER) for each in (spec, elastic)]
        ours, theirs = (simulate(joint, multisine([2.0, 30.0, 150.0]), 1.0, 2e-3) for joint in both)
        for name in ("theta", "velocity", "tau_d", "energy"):
            expected = getattr(theirs, name)
            assert getattr(ours, name) == pytest.approx(expected, abs=1e-8 * abs(expected).max()), name
        assert len(both[0].A) == len(both[1].A) + (3 if apart else 0)  # one denominator is one mechanism
        worst = poles_against_wall(elastic, PAPER).worst
        assert poles_against_wall(spec, PAPER).worst == pytest.approx(worst, rel=1e-6)

    @pytest.mark.parametrize("denominators", [([1, 3], [1, 4]), ([1, 3], [1, 3]), ([2], [1, 4]), ([2], [4])], ids=str)
    def test_measures_its_star(self, denominators):
        H, Z_a = (rational([1], d) for d in denominators)
        actuator = TwoPortActuator(
            type="two-port",
            transfer=Polynomials(numerator=tuple(H[0]), denominator=tuple(H[1])),
            impedance=Polynomials(numerator=tuple(Z_a[0]), denominator=tuple(Z_a[1])),
        )
        spec = given(actuator=actuator)
        setting = Setting.of(spec)
        loop, C = setting.loop, setting.compensator(Q)
        trials = verify(spec, PAPER, quick=True)
        assert trials.stable
        for trial in trials.trials[:3]:
            Z = loop.Z(C, loop.nominal).at(np.array(trial.frequencies))
            assert (error(np.array(trial.Z_measured), Z) <= trial.accuracy).all()

    def test_modes_are_excited_as_far_as_the_lowest_frequency_allows(self):
        def mode(omega):
            flexible = Polynomials(numerator=(omega**2,), denominator=(Fraction(1), omega / 50, omega**2))
            nothing = Polynomials(numerator=(Fraction(0),), denominator=(Fraction(1),))
            actuator = TwoPortActuator(type="two-port", transfer=flexible, impedance=nothing)
            return default_frequencies(given(actuator=actuator))

        plain = mode(Fraction(1))
        assert mode(Fraction(60)).max() >= 179 > plain.max()
        assert mode(Fraction(60)).min() == plain.min()
        assert mode(Fraction(10**6)).max() == plain.max()


class TestAgreement:
    @pytest.mark.parametrize("sampling", [None, HELD], ids=["continuous", "held"])
    @pytest.mark.parametrize("name", RANGES)
    def test_of_simulation_and_proof(self, studied, name, sampling):
        (setting, C, claims), trials = studied(name, sampling)
        agreement = compare(setting, C, claims, trials)
        assert agreement.contradictions == ()
        assert agreement.impedance_error < 1e-8

    def test_of_instability_by_delay(self):
        late = Sampling(rate=Fraction(1000), delay=Fraction("0.06"))
        spec = ranged({}, {}, late)
        setting, C, claims = certified(spec)
        agreement = compare(setting, C, claims, verify(spec, PAPER, quick=True))
        assert agreement.contradictions == ()
        assert len(agreement.unstable) == 15

    @pytest.mark.parametrize("sampling", [None, HELD], ids=["continuous", "held"])
    def test_a_wrong_word_on_either_side_is_a_contradiction(self, studied, sampling):
        (setting, C, claims), trials = studied("wish", sampling)
        last = len(trials.trials) - 1

        def said(index, **wrong):
            changed = [*trials.trials]
            changed[index] = replace(changed[index], **wrong)
            return compare(setting, C, claims, replace(trials, trials=tuple(changed))).contradictions

        Z = trials.trials[last].Z_measured
        assert said(last, Z_measured=tuple(1.0001 * value for value in Z))[0].startswith(f"trial {last} (tone): meas")
        assert "(★)" in said(last, impedance=trials.trials[0].impedance)[0]
        assert "every joint of the boxes" in said(last, stable=False)[0]
        assert said(0, stable=False)[0].startswith("nominal load")
        scale = trials.trials[last].energy_scale
        assert "passivity" in said(last, min_energy=-1e-3 * scale)[0]
        wall = compare(setting, C, claims, replace(trials, wall_stable=False)).contradictions
        assert wall == ("rigid wall: simulated poles unstable, stability-locked is otherwise",)

    def test_a_prediction_without_the_delay_or_with_another_is_a_contradiction(self, studied):
        _, trials = studied("plain", HELD)
        for wrong in (None, Sampling(rate=Fraction(1000), delay=Fraction("0.00101"))):
            setting = Setting.of(ranged({}, {}, wrong))
            (_, _, claims), _ = studied("plain", None)
            contradictions = compare(setting, setting.compensator(Q), claims, trials).contradictions
            assert any("(★)" in text for text in contradictions)

    def test_an_actuator_unstable_at_the_wall_contradicts_its_box(self, studied):
        (setting, C, claims), trials = studied("box", None)
        wrong = replace(trials, other_walls=(replace(trials.other_walls[0], stable=False), *trials.other_walls[1:]))
        assert "stability-locked is proven for the box" in compare(setting, C, claims, wrong).contradictions[0]


def test_the_drive_of_a_member_is_used():
    first, stiff = list(members(ranged({}, {"spring_stiffness": BOX["spring_stiffness"]})))[0::2]
    assert DRIVE.spring_stiffness < stiff.drive.spring_stiffness == 5
    assert first.spec.actuator == DRIVE
