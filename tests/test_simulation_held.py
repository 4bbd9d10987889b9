"""A torque demand behind hold and delay: the simulated joint is the one with `e^{−sT_d}(1−e^{−sT})/(sT)` in H."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from test_simulation import CORNER, DRIVE, IDEAL, PAPER, error, given, rational, star

from robimp.synthesis.certificate.enclosure.claims import family_of
from robimp.synthesis.certificate.enclosure.prover import CellProver
from robimp.synthesis.certificate.enclosure.winding import turns
from robimp.synthesis.problem.setting import Setting
from robimp.synthesis.simulation import (
    assemble,
    default_frequencies,
    loads,
    measure_impedance,
    multisine,
    poles_against_wall,
    sampled_comparison,
    simulate,
    step,
    step_response,
    verify,
)
from robimp.synthesis.spec.model import Polynomials, Sampling

FEEDTHROUGH = rational([0.4, 30], [1, 20])
TIMINGS = [
    ("1000", "0.001"),
    ("1000", "0"),
    ("1000", "0.00037"),
    ("300", "0.0001"),
    ("100", "0.002"),
    ("5000", "0.004"),
]


def held(rate="1000", delay="0.001", **options):
    sampling = Sampling(rate=Fraction(rate), delay=Fraction(delay))
    return given(**options).model_copy(update={"sampling": sampling})


class TestMeasuredImpedance:
    @pytest.mark.parametrize("actuator", [DRIVE, IDEAL], ids=["series-elastic", "ideal"])
    @pytest.mark.parametrize(("rate", "delay"), TIMINGS)
    def test_is_star_with_the_hold(self, rate, delay, actuator):
        spec = held(rate, delay, actuator=actuator)
        for load in (loads(spec)[0], CORNER):
            sines = multisine(default_frequencies(spec))
            measured = measure_impedance(assemble(spec, PAPER, load), sines, periods=2)[1]
            s = 1j * measured.frequencies
            off = error(measured.Z, star(spec, PAPER, load, s))
            assert (off <= measured.accuracy).all()
            assert measured.accuracy.max() < 1e-6
            later = held(rate, str(float(delay) + 1e-5), actuator=actuator)
            assert (error(measured.Z, star(later, PAPER, load, s)) > 10 * measured.accuracy).any()

    @pytest.mark.parametrize(("rate", "delay"), [("1000", "0"), ("1000", "0.0003"), ("1000", "0.0015")])
    def test_holds_when_C_passes_infinite_frequency(self, rate, delay):
        """θ'' then depends on the held torque, and τ_d on θ''."""
        spec = held(rate, delay, actuator=IDEAL, I="0.025")
        measured = measure_impedance(assemble(spec, FEEDTHROUGH, CORNER), multisine([2.0, 20.0, 100.0]))[1]
        off = error(measured.Z, star(spec, FEEDTHROUGH, CORNER, 1j * measured.frequencies))
        assert (off <= measured.accuracy).all()
        assert measured.accuracy.max() < 1e-6

    def test_error_of_the_steps_is_of_fourth_order_and_not_understated(self):
        for rate, delay in TIMINGS:
            spec = held(rate, delay)
            omega = 2 * default_frequencies(spec)
            joint = assemble(spec, PAPER, CORNER)
            exact = star(spec, PAPER, CORNER, 1j * omega)
            fine, coarse = (error(1 / steps.compliance(omega), exact) for steps in joint.pair)
            assert (fine <= joint.step_error(omega) + 1e-10).all()
            assert fine.max() < coarse.max() / 10

    def test_reduces_to_the_continuous_joint_at_a_very_fast_rate_without_delay(self):
        plain, fast = given(), held("100000", "0")
        continuous, quick = (assemble(spec, PAPER, CORNER) for spec in (plain, fast))
        assert quick.poles.worst == pytest.approx(continuous.poles.worst, rel=1e-5)
        wall = poles_against_wall(plain, PAPER).worst
        assert poles_against_wall(fast, PAPER).worst == pytest.approx(wall, rel=1e-3)
        omega = default_frequencies(plain)
        assert error(quick.compliance(omega), continuous.compliance(omega)).max() < 5e-4
        slow, exact = (step_response(joint, 1.0, 1e-2) for joint in (quick, continuous))
        assert slow.times == pytest.approx(exact.times)
        assert slow.theta == pytest.approx(exact.theta, abs=1e-4 * abs(exact.theta).max())
        assert slow.energy == pytest.approx(exact.energy, abs=1e-4 * exact.energy_scale)


class TestMotion:
    @pytest.mark.parametrize("excitation", [step(1.5), multisine([3.0, 17.0, 60.0])], ids=["step", "multisine"])
    @pytest.mark.parametrize(("rate", "delay"), [("100", "0.02"), ("100", "0"), ("100", "0.003")])
    def test_is_what_small_steps_with_a_record_of_the_demand_compute(self, rate, delay, excitation):
        """Ideal actuator and C of (23), by the midpoint rule, hold and delay from the recorded sum of τ_d."""
        dt, n = 2e-5, 20_000
        hold, late = round(1 / float(rate) / dt), round(float(delay) / dt)
        summed = np.zeros(n + 1)  # y
        theta = speed = c = c_rate = energy = 0.0
        record = []

        def demand(c, speed, theta):
            return 2000 * c - 0.15 * speed - 1.25 * theta

        def mean(k):
            return (summed[max(k - late, 0)] - summed[max(k - late - hold, 0)]) / (hold * dt)

        torque = (np.exp(1j * np.outer(np.arange(2 * n + 2) * dt / 2, excitation.frequencies))
                  @ excitation.amplitudes).real  # fmt: skip

        def rates(theta, speed, c, c_rate, w, tau_int):
            acceleration = (tau_int + w - 0.2 * speed) / 0.03
            dynamic_error = tau_int - 0.03 * acceleration - 0.35 * speed - 1.25 * theta
            return np.array([speed, acceleration, c_rate, dynamic_error - 70.75 * c_rate - 500 * c, tau_int * speed])

        x = np.array([theta, speed, c, c_rate, energy])
        for k in range(n):
            record.append(x)
            now = demand(x[2], x[1], x[0])
            w = mean(k)
            # Without delay the newest demand is in w already; over half a step it hardly changes.
            ahead = (now - (0 if k < hold else demand(*record[k - hold][[2, 1, 0]]))) / (hold * dt) if not late else 0.0
            half = x + dt / 2 * rates(*x[:4], w, torque[2 * k])
            w_half = w + dt / 2 * ahead if not late else (mean(k) + mean(k + 1)) / 2
            x = x + dt * rates(*half[:4], w_half, torque[2 * k + 1])
            summed[k + 1] = summed[k] + dt * (now + demand(x[2], x[1], x[0])) / 2
        theirs = np.array(record)
        ours = simulate(assemble(held(rate, delay, actuator=IDEAL), PAPER, loads(given())[0]), excitation, 0.35, 1e-3)
        for name, column in (("theta", 0), ("velocity", 1), ("energy", 4)):
            expected = np.interp(ours.times, dt * np.arange(n), theirs[:, column])
            assert getattr(ours, name) == pytest.approx(expected, abs=2e-5 * abs(expected).max()), name
        longer = simulate(
            assemble(held(rate, str(float(delay) + 1e-3), actuator=IDEAL), PAPER, loads(given())[0]),
            excitation, 0.35, 1e-3,
        )  # fmt: skip
        n = min(len(longer.theta), len(ours.theta))
        assert abs(longer.theta[:n] - ours.theta[:n]).max() > 1e-4 * abs(ours.theta).max()

    def test_energy_does_not_depend_on_the_sampling_of_the_record(self):
        joint = assemble(held(), PAPER, CORNER)
        coarse, fine = (simulate(joint, multisine([2.0, 150.0]), 2.0, dt) for dt in (0.1, 0.001))
        for name in ("theta", "energy", "tau_d"):
            values = getattr(fine, name)[::100]
            assert getattr(coarse, name) == pytest.approx(values, abs=1e-10 * abs(values).max())

    def test_of_a_step_the_energy_is_torque_times_angle(self):
        run = step_response(assemble(held(), PAPER, CORNER), 3.0, 1e-3, torque=1.5)
        assert run.energy == pytest.approx(1.5 * run.theta, abs=1e-10)


def turned(spec, end):
    Q = (Fraction(2000),), (Fraction(1), Fraction("70.75"), Fraction(2500))
    coefficients = Polynomials(numerator=Q[0], denominator=Q[1])
    setting = Setting.of(spec)
    return turns(CellProver(replace(family_of(setting, setting.compensator(coefficients)), single=True)), end)


class TestStability:
    @pytest.mark.parametrize(
        ("rate", "end", "critical"),
        [("1000", "free", 0.0294523), ("1000", "locked", 0.0402667), ("40", "free", 0.0189555)],
    )
    def test_is_lost_at_the_delay_at_which_the_certificate_turns(self, rate, end, critical):
        for factor in (0.999, 1.001):
            spec = held(rate, f"{critical * factor:.9f}")
            poles = poles_against_wall(spec, PAPER) if end == "locked" else assemble(spec, PAPER, loads(spec)[0]).poles
            assert poles.stable == (factor < 1) == (turned(spec, end) == 0)
            assert poles.error < 1e-6

    def test_lost_to_delay_is_reported_for_every_load_and_not_moved(self):
        trials = verify(held(delay="0.06"), PAPER, quick=True)
        assert not trials.wall_stable
        assert {trial.stable for trial in trials.trials} == {False}
        assert {trial.min_energy for trial in trials.trials} == {None}

    def test_of_an_algebraic_part_beyond_one_any_delay_destroys(self):
        """C(∞) = 0.7 makes 1 + HCF ≈ 1 + 2.3 e^{−sT_d}: infinitely many poles on the right."""
        spec, C = held("1000", "0.0003", actuator=IDEAL), rational([2.3, 60], [1, 20])
        assert assemble(given(actuator=IDEAL), C, loads(spec)[0]).poles.stable
        assert not poles_against_wall(spec, C).stable

    @pytest.mark.parametrize(("rate", "delay"), [("10000000", "0"), ("100000", "0.002"), ("1000000", "0.0001")])
    def test_extreme_timings_keep_their_accuracy(self, rate, delay):
        trials = verify(held(rate, delay, boxed=False), PAPER, quick=True)
        assert trials.stable
        assert max(max(trial.accuracy, default=0) for trial in trials.trials) < 1e-6


class TestSampledComparison:
    def test_takes_rate_and_delay_of_the_specification(self):
        found = sampled_comparison(held("500", "0.003"), PAPER)
        assert (found.rate, found.delay, found.stable) == (500.0, 2, True)
        assert sampled_comparison(given(), PAPER).rate == 1000.0

    def test_is_closer_to_the_loop_with_the_hold_than_to_the_one_without(self):
        own = sampled_comparison(held("1000", "0.002"), PAPER)
        plain = sampled_comparison(given(), PAPER, rate=1000.0, delay=2)
        assert own.rms_difference < plain.rms_difference

    def test_passes_over_an_unstable_loop(self):
        assert sampled_comparison(held(delay="0.06"), PAPER).rms_difference is None
