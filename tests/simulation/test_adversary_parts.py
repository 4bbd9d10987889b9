"""What attacks are made of: the loop with its hold, bounds on Δ, a Δ within them, partners, stretched boxes."""

from fractions import Fraction

import numpy as np
import pytest
from certified import golden

from robimp.synthesis.errors import RobimpError
from robimp.synthesis.simulation import assemble, loads, middle_of, poles_against_wall
from robimp.synthesis.simulation.adversary import tones
from robimp.synthesis.simulation.adversary.bounds import lumped, on_top
from robimp.synthesis.simulation.adversary.delta import CHECKED, attack, built, reachable
from robimp.synthesis.simulation.adversary.loop import free, locked
from robimp.synthesis.simulation.adversary.motion import fading, left_alone
from robimp.synthesis.simulation.adversary.population import drawn
from robimp.synthesis.simulation.adversary.stretched import (
    joints,
    partner,
    ranges_stretched,
    stretch_to_yield,
    vertices,
)
from robimp.synthesis.simulation.members import members
from robimp.synthesis.spec.model import Polynomials, Table

BAND = (0.1, 1000.0)
OMEGA = np.geomspace(0.1, 800, 9)
LOAD = np.array([0.03, 0.2, 0.0])
GIVEN = ["haninger2016-paper", "sampled-range"]


def given(name):
    spec, C, *_ = golden(name)
    return middle_of(spec), C


@pytest.fixture(scope="module")
def paper():
    return given("haninger2016-paper")


class TestLoop:
    @pytest.mark.parametrize("name", GIVEN)
    def test_is_the_joint_of_the_other_simulator(self, name):
        spec, C = given(name)
        joint, loop = assemble(spec, C, loads(spec)[0]), free(spec, C, LOAD)
        (theta,) = loop.response(OMEGA, "theta", "push")
        assert abs(theta / joint.compliance(OMEGA) - 1).max() < 1e-8
        assert loop.rate == pytest.approx(joint.poles.worst.real, rel=1e-9)
        assert locked(spec, C).rate == pytest.approx(poles_against_wall(spec, C).worst.real, rel=1e-9)

    @pytest.mark.parametrize("name", GIVEN)
    @pytest.mark.parametrize("omega", [0.5, 60.0, 2000.0])
    def test_its_motion_under_a_sine_is_its_response(self, name, omega):
        loop = free(*given(name), LOAD)
        for signal in ("push", "disturbance", "noise"):
            amplitudes, error = loop.phasors(omega, signal)
            for output in ("theta", "tau_d"):
                expected = loop.response(np.array([omega]), output, signal)[0][0]
                assert abs(amplitudes[output] / expected - 1) < 1e-9 + 10 * error
            assert error < 1e-4

    def test_the_hold_turns_the_phase_and_nothing_else_at_low_frequency(self):
        spec, C = given("sampled-range")
        held = free(spec, C, LOAD)
        continuous = free(spec.model_copy(update={"sampling": None}), C, LOAD)
        theta = [loop.response(np.array([0.1, 100.0]), "theta", "push")[0] for loop in (held, continuous)]
        off = abs(theta[0] / theta[1] - 1)
        assert off[0] < 1e-4 and off[1] > 0.01

    def test_an_unstable_joint_is_not_measured(self, paper):
        spec, C = paper
        with pytest.raises(RobimpError, match="unstable"):
            free(spec, C, np.array([0.007, -0.1, 0.0])).phasors(1.0, "push")

    @pytest.mark.parametrize("name", GIVEN)
    def test_left_alone_it_grows_where_a_pole_is_on_the_right(self, name):
        spec, C = given(name)
        marginal = next(
            load for b in np.linspace(0, -0.6, 61) if free(spec, C, load := np.array([0.01, b, 0])).rate > 0
        )
        assert left_alone(free(spec, C, marginal)).grows
        assert not left_alone(free(spec, C, LOAD)).grows

    @pytest.mark.parametrize("name", GIVEN)
    def test_against_a_wall_torques_grow_where_a_pole_is_on_the_right(self, name):
        spec, C = given(name)
        greedy = (tuple(20 * c for c in C[0]), C[1])
        assert locked(spec, greedy).rate > 0 > locked(spec, C).rate
        assert left_alone(locked(spec, greedy)).grows and not left_alone(locked(spec, C)).grows

    def test_the_frozen_actuator_gives_the_same_torque_whatever_the_load(self, paper):
        spec, C = paper

        def A_cl(load, frozen):
            loop = free(spec, C, load, frozen=frozen)
            ratio = [loop.response(OMEGA, name, "noise")[0] for name in ("applied", "tau_d")]
            return ratio[0] / ratio[1]  # nothing but the actuator applies a torque

        heavy = np.array([0.06, 0.1, 0.0])
        np.testing.assert_allclose(A_cl(heavy, True), A_cl(LOAD, False), rtol=1e-9)
        assert abs(A_cl(heavy, False) / A_cl(LOAD, False) - 1).max() > 0.02


class TestBounds:
    def test_of_a_box_covers_every_load_and_no_more(self, paper):
        spec, _ = paper
        s = 1j * np.geomspace(0.01, 1000, 50)
        inertia, damping, stiffness = drawn(spec, 2000, np.random.default_rng(0)).T[:, :, None]
        found = abs((0.03 * s**2 + 0.2 * s) / (inertia * s**2 + damping * s + stiffness) - 1).max(axis=0)
        W = lumped(spec)(s.imag)
        assert (found <= W * (1 + 1e-9)).all() and (found >= 0.98 * W).all()
        assert on_top(spec) is None

    def test_weight_table_and_box_multiply(self, paper):
        spec, _ = paper
        box = lumped(spec)(OMEGA)
        weight = Polynomials(numerator=(Fraction(1, 10), Fraction(0)), denominator=(Fraction(1), Fraction(50)))
        points = ((Fraction(1), Fraction(1, 10)), (Fraction(101), Fraction(3, 10)))
        update = {"weight": weight, "table": Table(points=points, beyond="hold")}
        spec = spec.model_copy(update={"uncertainty": spec.uncertainty.model_copy(update=update)})
        of_weight, of_table = abs(0.1j * OMEGA / (50 + 1j * OMEGA)), np.interp(OMEGA, [1, 101], [0.1, 0.3])
        np.testing.assert_allclose(on_top(spec)(OMEGA), (1 + of_weight) * (1 + of_table) - 1, rtol=1e-12)
        np.testing.assert_allclose(lumped(spec)(OMEGA), (1 + box) * (1 + of_weight) * (1 + of_table) - 1, rtol=1e-12)


class TestDelta:
    @pytest.mark.parametrize("name", ["haninger2016-paper", "feedback-both", "weight-disc"])
    def test_stays_within_its_bound_everywhere_and_nearly_fills_it_where_it_counts(self, name):
        bound = lumped(golden(name).spec)
        for omega, phase in ((0.7, 2.0), (9.0, -1.0), (90.0, 3.1)):
            delta = built(bound, omega, phase)
            frequencies = CHECKED * omega
            value = np.polyval(delta.numerator, 1j * frequencies) / np.polyval(delta.denominator, 1j * frequencies)
            assert (abs(value) <= bound(frequencies) * (1 + 1e-9)).all()
            assert (np.roots(delta.denominator).real < 0).all(), "Δ itself is stable"
            here = np.polyval(delta.numerator, 1j * omega) / np.polyval(delta.denominator, 1j * omega)
            assert 0.95 * bound(np.array([omega]))[0] < abs(here) and np.angle(here) == pytest.approx(phase, abs=1e-6)

    def test_closes_the_loop_from_the_factor_on_that_can_reach_it(self, paper):
        spec, C = paper
        loop, bound = free(spec, C, LOAD), lumped(spec)
        limit = reachable(loop, bound, BAND)
        for factor, grows in ((0.98, False), (1.02, True)):
            tried = attack(loop, bound, factor * limit, BAND)
            assert (tried.reach > 1) == grows
            assert left_alone(loop.with_law(tried.delta.laws()), tried.delta.omega).grows == grows


class TestStretchedBox:
    def test_passivity_ends_where_the_resistance_turns(self, paper):
        spec, C = paper
        limit = stretch_to_yield(spec, C, BAND)
        assert 1.25 < limit < 1.35
        assert max(loop.rate for loop in joints(spec, C, vertices(spec, limit))) < 0, "it is still stable"

    def test_ranges_are_stretched_about_the_nominal_joint(self):
        spec = golden("sampled-range").spec
        wider = ranges_stretched(spec, Fraction(3))
        assert wider.impedance.stiffness == (Fraction(1, 2), Fraction(2))
        assert len(list(members(wider))) == len(list(members(spec))) == 3
        assert ranges_stretched(spec, Fraction(1)) == spec

    def test_a_partner_resonates_where_it_was_tuned_to(self, paper):
        spec, C = paper
        loop = free(spec, C, LOAD)
        other = partner(loop, 50.0)
        assert other.inertia > 0 and other.stiffness > 0
        near = loop.with_law(other.laws()).poles.values
        assert abs(near.imag - 50).min() < 0.1

    def test_a_tone_measures_what_the_response_says(self, paper):
        spec, C = paper
        loop = free(spec, C, LOAD)
        for quantity in (tones.ATTENUATION, tones.RESISTANCE, tones.DRY, tones.rendering_error(spec)):
            seen = tones.measured(loop, quantity, 20.0)
            assert seen.worse == pytest.approx(float(quantity.of(loop, np.array([20.0]))[0]), rel=1e-9)


@pytest.mark.parametrize("name", ["haninger2016", "sampled-range", "weight-disc"])
def test_what_is_left_of_a_run_fades_as_its_slowest_mode(name):
    spec, C, *_ = golden(name)
    nominal = vertices(spec).mean(axis=0)
    for loop in (free(spec, C, nominal), locked(spec, C)):
        seen = fading(loop)
        assert seen.rate == pytest.approx(loop.poles.decay, rel=1e-6) and seen.change < 1e-6 * seen.rate
    falling = fading(free(spec, C, nominal * [1, -1, 1] - [0, 1, 0]))
    assert falling.rate < 0, "what grows is seen to grow"


@pytest.mark.parametrize("phase", [0.0, np.pi, -np.pi, 1e-8, 1.0])
def test_no_pole_of_a_delta_is_at_the_origin_whatever_its_phase(phase):
    delta = built(lambda omega: np.full_like(omega, 0.5), 40.0, phase)
    poles = np.roots(delta.denominator)
    assert poles.real.max() < -1e-3 * 40 and abs(poles).max() < 1e3 * 40
    value = np.polyval(delta.numerator, 40j) / np.polyval(delta.denominator, 40j)
    assert abs(value / (delta.gain * np.exp(1j * phase)) - 1) < 1e-5 and delta.gain > 0.49
