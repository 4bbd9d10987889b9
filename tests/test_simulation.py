"""The simulator integrates (1), (13) and (20); what it measures is what (★) predicts, computed here on its own."""

import ast
import json
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from robimp.synthesis import simulation
from robimp.synthesis.errors import InputError, RobimpError
from robimp.synthesis.simulation import (
    Load,
    assemble,
    default_frequencies,
    loads,
    measure_impedance,
    multisine,
    multisine_response,
    poles_against_wall,
    sampled_comparison,
    sampled_step,
    simulate,
    step,
    step_response,
    verify,
)
from robimp.synthesis.simulation.block import connect, transfer
from robimp.synthesis.spec.model import (
    Box,
    Constraints,
    Controller,
    Filters,
    IdealActuator,
    Impedance,
    Objective,
    Plant,
    SeriesElasticActuator,
    Spec,
    TorqueLoop,
    Uncertainty,
)

DRIVE = SeriesElasticActuator(
    type="series-elastic",
    motor_inertia=Fraction("0.01"),
    motor_damping=Fraction("0.05"),
    spring_stiffness=Fraction("4.8"),
    torque_loop=TorqueLoop(
        kp=Fraction(10), kd=Fraction("0.25"), derivative_corner=Fraction(1000), feedforward=Fraction(1)
    ),
)
IDEAL = IdealActuator(type="ideal")


def given(K="1.25", B="0.35", I="0.03", actuator=DRIVE, plant=("0.03", "0.2", "0"), boxed=True, **filters):  # noqa: E741
    inertia, damping, stiffness = (Fraction(value) for value in plant)
    box = Box(
        inertia=(inertia * Fraction("0.8"), inertia * Fraction("1.2")),
        damping=(damping * Fraction("0.6"), damping * Fraction("1.4")),
        stiffness=(stiffness, stiffness),
    )
    corners = {name: value if value == "none" else Fraction(value) for name, value in filters.items()}
    return Spec(
        robimp=1,
        name="test",
        motion="rotary",
        plant=Plant(inertia=inertia, damping=damping, stiffness=stiffness),
        uncertainty=Uncertainty(box=box if boxed else None),
        actuator=actuator,
        impedance=Impedance(inertia=Fraction(I), damping=Fraction(B), stiffness=Fraction(K)),
        controller=Controller(type="dob", order=2, filters=Filters(**corners)),
        objective=Objective(maximize="bandwidth", attenuation=Fraction("0.3")),
        constraints=Constraints(),
    )


def rational(numerator, denominator):
    return [Fraction(str(value)) for value in numerator], [Fraction(str(value)) for value in denominator]


PAPER = rational([2000], [1, 70.75, 500])  # Q/(1−Q) of (23), α = 0.8, ω = 50
GREEDY = rational([20000], [1, 10, 500])  # too much gain for the drive's phase at its crossover
NOTHING = rational([0], [1])
CORNER = Load(Fraction("0.036"), Fraction("0.12"), Fraction(0))
VARIANTS = [
    {},
    {"force": "100"},
    {"derivative": "1000"},
    {"force": "100", "derivative": "1000"},
    {"force": "100", "position": "none"},
    {"force": "100", "position": "40", "derivative": "300"},
    {"position": "40"},
]


def star(spec, compensator, load, s):
    """(★) with separate filters: Z = (Z₀ + H C F_θ G_imp)/(1 + H C F), hold and delay in H."""

    def lag(corner):
        return 1 if corner in (None, "none") else 1 / (1 + s / float(corner))

    def stiffness(of):
        return float(of.inertia) * s**2 + float(of.damping) * s + float(of.stiffness)

    H, Z_a = 1, 0
    if spec.actuator.type == "series-elastic":
        a, loop = spec.actuator, spec.actuator.torque_loop
        P = 1 / (float(a.motor_inertia) * s**2 + float(a.motor_damping) * s)
        C_t = float(loop.kp) + float(loop.kd) * s / (1 + s / float(loop.derivative_corner))
        K_sp = float(a.spring_stiffness)
        rest = 1 + K_sp * P * (1 + C_t)
        H, Z_a = K_sp * P * (C_t + float(loop.feedforward)) / rest, K_sp / rest
    if spec.sampling is not None:
        T, T_d = 1 / float(spec.sampling.rate), float(spec.sampling.delay)
        H = H * np.exp(-s * T_d) * (1 - np.exp(-s * T)) / (s * T)
    C = np.polyval([float(c) for c in compensator[0]], s) / np.polyval([float(c) for c in compensator[1]], s)
    filters = spec.controller.filters
    F = lag(filters.force)
    F_theta = F if filters.position is None else lag(filters.position)
    wish = stiffness(spec.impedance)
    Z_0 = stiffness(load) + Z_a - H * lag(filters.derivative) * (stiffness(spec.plant) - wish)
    return (Z_0 + H * C * F_theta * wish) / (1 + H * C * F)


def error(measured, expected):
    return abs(measured / expected - 1)


class TestMotion:
    """The trajectory is the solution of the equations of motion."""

    FILTERS = {"force": "100", "derivative": "1000"}  # noqa: RUF012

    @staticmethod
    def integrate(torque, times, feedforward=1.0):
        """(1), (13), (20) with the numbers of `given(force=100, derivative=1000)` and C of (23), written out."""

        def motion(t, x):
            theta, speed, phi, motor_speed, lead, filtered, c, c_rate, compensation, _ = x
            tau_int = torque(t)
            tau_sea = 4.8 * (phi - theta)
            acceleration = (tau_int + tau_sea - 0.2 * speed) / 0.03
            dynamic_error = tau_int - (0.03 * acceleration + 0.35 * speed + 1.25 * theta)
            tau_d = 2000 * c + compensation
            lack = tau_d - tau_sea
            tau_m = feedforward * tau_d + 10 * lack + 0.25 * 1000 * (lack - lead)
            return [
                speed,
                acceleration,
                motor_speed,
                (tau_m - tau_sea - 0.05 * motor_speed) / 0.01,
                1000 * (lack - lead),
                100 * (dynamic_error - filtered),
                c_rate,
                filtered - 70.75 * c_rate - 500 * c,
                1000 * ((0.2 - 0.35) * speed - 1.25 * theta - compensation),
                tau_int * speed,
            ]

        span = (times[0], times[-1])
        x = solve_ivp(motion, span, np.zeros(10), "DOP853", times, rtol=1e-11, atol=1e-13).y
        return {"theta": x[0], "velocity": x[1], "energy": x[9], "tau_d": 2000 * x[6] + x[8]}

    @pytest.mark.parametrize("excitation", [step(1.5), multisine([3.0, 17.0, 60.0, 150.0])], ids=["step", "multisine"])
    def test_agrees_with_a_general_integrator(self, excitation):
        joint = assemble(given(**self.FILTERS), PAPER, loads(given())[0])
        ours = simulate(joint, excitation, 1.0, 2e-3)

        def torque(t):
            return float((excitation.amplitudes * np.exp(1j * excitation.frequencies * t)).real.sum())

        theirs = self.integrate(torque, ours.times)
        for name, values in theirs.items():
            assert getattr(ours, name) == pytest.approx(values, abs=1e-8 * abs(values).max()), name
        wrong = self.integrate(torque, ours.times, feedforward=0.0)
        assert abs(ours.theta - wrong["theta"]).max() > 1e-4 * abs(ours.theta).max()

    def test_starts_from_rest_and_settles_where_the_wished_stiffness_says(self):
        response = step_response(assemble(given(), PAPER, CORNER), 8.0, 1e-3, torque=2.0)
        assert (response.theta[0], response.velocity[0], response.energy[0]) == (0, 0, 0)
        assert response.theta[-1] == pytest.approx(2.0 / 1.25, rel=1e-9)  # K = 0, so Z(0) = K_imp

    def test_motion_is_linear_and_energy_quadratic_in_the_torque(self):
        joint = assemble(given(), PAPER, CORNER)
        one, three = (multisine_response(joint, [2.0, 30.0], 2.0, 1e-2, torque) for torque in (1.0, 3.0))
        assert three.theta == pytest.approx(3 * one.theta, rel=1e-12)
        assert three.energy == pytest.approx(9 * one.energy, rel=1e-9, abs=1e-12)

    def test_the_sampling_of_the_record_does_not_matter(self):
        joint = assemble(given(), PAPER, CORNER)
        coarse, fine = (multisine_response(joint, [2.0, 150.0], 2.0, dt) for dt in (0.1, 0.001))
        for name in ("theta", "energy"):
            values = getattr(fine, name)[::100]
            assert getattr(coarse, name) == pytest.approx(values, abs=1e-11 * abs(values).max())


class TestEnergy:
    """∫ τ_int θ' dt is exact at the samples, and shows whether the port gives more than it got."""

    @pytest.mark.parametrize("excitation", [step(), multisine([3.0, 11.0])], ids=["step", "multisine"])
    def test_an_undamped_mass_on_a_spring_stores_what_enters(self, excitation):
        def stored_and_entered(damping):
            spec = given(K="2", B="0", plant=("0.03", "0", "2"), boxed=False, actuator=IDEAL)
            joint = assemble(spec, NOTHING, Load(Fraction("0.03"), Fraction(damping), Fraction(2)))
            run = simulate(joint, excitation, 20.0, 1e-2)
            return 0.03 / 2 * run.velocity**2 + run.theta**2, run

        stored, run = stored_and_entered("0")
        assert run.energy == pytest.approx(stored, abs=1e-12 * run.energy_scale)
        stored, run = stored_and_entered("0.001")
        assert run.energy[-1] - stored[-1] > 1e-3 * run.energy_scale  # a little friction is seen

    def test_of_a_step_is_torque_times_angle(self):
        run = step_response(assemble(given(), PAPER, CORNER), 3.0, 1e-3, torque=1.5)
        assert run.energy == pytest.approx(1.5 * run.theta, abs=1e-12)

    def test_never_drawn_from_a_passive_port(self):
        for trial in verify(given(), PAPER, quick=True).trials:
            assert trial.min_energy >= -1e-9 * trial.energy_scale

    def test_drawn_from_a_port_that_is_not_passive_at_its_worst_tone(self):
        trials = verify(given(K="3", B="0.25"), PAPER, quick=True).trials
        drained = [trial for trial in trials if trial.min_energy < -1e-9 * trial.energy_scale]
        assert [(trial.load, trial.kind) for trial in drained] == [(CORNER, "tone")]
        assert drained[0].frequencies[0] == pytest.approx(51.3, abs=0.3)
        assert (drained[0].Z_measured[0] / (1j * drained[0].frequencies[0])).real == pytest.approx(-0.053, abs=5e-4)

    def test_keeps_falling_in_steady_state_under_that_tone(self):
        run = multisine_response(assemble(given(K="3", B="0.25"), PAPER, CORNER), [51.3], 40.0, 2 * np.pi / 51.3 / 20)
        after_each_cycle = run.energy[run.times > 5][::20]
        assert all(later < earlier for earlier, later in pairwise(after_each_cycle))
        assert run.energy[-1] < -0.1


class TestMeasuredImpedance:
    """Z = τ_int/θ, measured, is (★) within the error that the measurement itself admits."""

    @pytest.mark.parametrize("actuator", [DRIVE, IDEAL], ids=["series-elastic", "ideal"])
    @pytest.mark.parametrize("filters", VARIANTS, ids=str)
    def test_is_star_for_every_filter_and_actuator(self, filters, actuator):
        spec = given(actuator=actuator, **filters)
        sines = multisine(default_frequencies(spec))
        for load in (loads(spec)[0], CORNER):
            measured = measure_impedance(assemble(spec, PAPER, load), sines, periods=2)[1]
            s = 1j * measured.frequencies
            off = error(measured.Z, star(spec, PAPER, load, s))
            assert (off <= measured.accuracy).all()
            assert measured.accuracy.max() < 1e-6
            heavier = Load(load.inertia * Fraction("1.001"), load.damping, load.stiffness)
            assert (error(measured.Z, star(spec, PAPER, heavier, s)) > measured.accuracy).any()

    def test_tells_the_filter_variants_apart(self):
        s = 1j * default_frequencies(given())
        Z = [star(given(**filters), PAPER, CORNER, s) for filters in VARIANTS]
        assert all(error(Z[i], Z[j]).max() > 1e-3 for i in range(len(Z)) for j in range(i))

    def test_holds_when_C_passes_infinite_frequency_through_an_ideal_actuator(self):
        """θ'' then depends on τ_d, and τ_d on θ'': the loop is solved."""
        spec, C = given(actuator=IDEAL, I="0.02"), rational([2.5, 1], [1, 3])
        measured = measure_impedance(assemble(spec, C, CORNER), multisine([2.0, 20.0, 100.0]))[1]
        assert (error(measured.Z, star(spec, C, CORNER, 1j * measured.frequencies)) < 1e-9).all()

    @pytest.mark.parametrize(("K", "B"), [("0.01", "0.35"), ("1.25", "0.01")], ids=["creeping", "ringing"])
    def test_does_not_wait_for_a_slow_mode_but_fits_it(self, K, B):
        spec, damped = given(K=K, B=B, actuator=IDEAL), Load(Fraction("0.036"), Fraction("0.25"), Fraction(0))
        joint = assemble(spec, PAPER, damped)
        run, measured = measure_impedance(joint, multisine([5.0, 25.0, 60.0]))
        assert np.exp(-joint.poles.decay * run.times[-1]) > 1e-3
        assert run.times[-1] < 15
        off = error(measured.Z, star(spec, PAPER, damped, 1j * measured.frequencies))
        assert (off <= measured.accuracy).all()
        assert measured.accuracy.max() < 1e-6

    def test_admits_a_transient_it_could_not_fit(self):
        """A pole that the joint has and the fit is not told about."""
        spec = given()
        joint = assemble(given(K="0.01"), PAPER, CORNER)
        joint.__dict__["poles"] = assemble(spec, PAPER, CORNER).poles
        measured = measure_impedance(joint, multisine([5.0, 25.0, 60.0]))[1]
        assert measured.accuracy.max() > 1e-4

    @pytest.mark.parametrize("frequencies", [[], [0.0], [-1.0, 2.0], [float("nan")], [5.0, 5.0], [5.0, 5.0 + 1e-9]])
    def test_refuses_frequencies_that_cannot_be_told_apart(self, frequencies):
        with pytest.raises(InputError, match="frequenc"):
            measure_impedance(assemble(given(), PAPER, CORNER), multisine(frequencies))


class TestExcitation:
    def test_covers_the_reference_joint_from_1_to_200_rad_per_s(self):
        frequencies = default_frequencies(given())
        assert 0.5 < frequencies.min() < 1.5
        assert 150 < frequencies.max() < 300
        assert 10 <= len(frequencies) <= 12

    def test_harmonics_of_the_lowest_with_the_rms_asked_for_and_a_low_crest(self):
        sines = multisine(default_frequencies(given()), torque=2.0)
        base = sines.frequencies.min()
        assert sines.frequencies / base == pytest.approx(np.round(sines.frequencies / base), abs=1e-9)
        t = np.linspace(0, 2 * np.pi / base, 20_000, endpoint=False)
        waves = np.exp(1j * np.outer(t, sines.frequencies))
        torque, aligned = (waves @ sines.amplitudes).real, (waves @ abs(sines.amplitudes)).real
        rms = np.sqrt(np.mean(torque**2))
        assert rms == pytest.approx(2 / np.sqrt(2), rel=1e-9)
        assert abs(torque).max() / rms < 2.9 < 4 < abs(aligned).max() / rms


class TestPoles:
    @pytest.mark.parametrize("filters", VARIANTS, ids=str)
    def test_in_free_motion_are_the_zeros_of_star(self, filters):
        spec = given(**filters)
        poles = assemble(spec, PAPER, CORNER).poles.values
        near = 1 + 1e-3
        hidden = [-float(c) for c in filters.values() if c != "none"]
        for pole in poles:
            if min((abs(pole - h) for h in hidden), default=1) > 1e-3:
                assert abs(star(spec, PAPER, CORNER, pole)) < 1e-5 * abs(star(spec, PAPER, CORNER, pole * near))

    def test_against_a_wall_are_the_zeros_of_one_plus_HCF(self):
        n_H = np.polyadd([4.8 * 11 / 1000 + 4.8 * 0.25, 4.8 * 11], [0])  # K_sp (kp + λ)(1 + s/ω_c) + K_sp kd s
        d = np.polyadd(np.polymul([0.01, 0.05, 0], [1e-3, 1]), n_H)
        locked = np.polyadd(np.polymul(np.polymul(d, [1, 70.75, 500]), [0.01, 1]), 2000 * n_H)
        poles = poles_against_wall(given(force="100"), PAPER)
        assert np.sort_complex(poles.values) == pytest.approx(np.sort_complex(np.roots(locked)), rel=1e-8)
        assert poles.stable

    def test_one_filter_on_the_error_is_one_state_and_two_equal_filters_are_two(self):
        shared = assemble(given(force="100"), PAPER, CORNER)
        split = assemble(given(force="100", position="100"), PAPER, CORNER)
        assert len(split.A) == len(shared.A) + 1 == len(assemble(given(), PAPER, CORNER).A) + 2
        assert split.poles.worst == pytest.approx(shared.poles.worst)

    def test_a_marginal_joint_is_not_called_stable(self):
        spec = given(K="0", B="0.35")  # no stiffness anywhere: θ may rest anywhere
        assert not assemble(spec, PAPER, CORNER).poles.stable

    def test_an_unstable_cancellation_in_C_is_not_cancelled(self):
        stable, hidden = rational([2], [1]), rational([2, -2], [1, -1])
        assert assemble(given(), stable, CORNER).poles.stable
        assert assemble(given(), hidden, CORNER).poles.worst == pytest.approx(1)


class TestUnstable:
    def test_is_reported_with_its_worst_pole_for_every_load(self):
        trials = verify(given(), GREEDY, quick=True)
        assert not trials.stable
        assert not trials.wall_stable
        for trial in trials.trials:
            assert not trial.stable
            assert trial.worst_pole.real > 1
            assert trial.min_energy is None

    def test_has_no_impedance_to_measure(self):
        with pytest.raises(RobimpError, match=r"nothing to measure: worst pole .*rad/s, load I=0.036"):
            measure_impedance(assemble(given(), GREEDY, CORNER), multisine([5.0]))

    def test_overflow_is_one_line_that_names_the_pole(self):
        joint = assemble(given(), GREEDY, CORNER)
        with pytest.raises(RobimpError, match=r"overflows: worst pole .*rad/s, load I=0.036"):
            step_response(joint, 1000.0, 0.1)
        assert abs(step_response(joint, 0.1, 0.01).theta[-1]) < 1e6  # short of that it is simulated like any other


class TestAlgebraicLoop:
    def test_singular_loop_is_named(self):
        """C(∞) = −1 with I_imp = I cancels the acceleration's own effect on itself."""
        nominal = loads(given())[0]
        with pytest.raises(RobimpError, match=r"algebraic loop through.*acceleration.*tau_d"):
            assemble(given(actuator=IDEAL), rational([-1], [1]), nominal)
        assert assemble(given(actuator=IDEAL), rational([-0.5], [1]), nominal).poles.stable

    def test_singular_loop_against_the_wall_is_named(self):
        with pytest.raises(RobimpError, match=r"algebraic loop through.*tau_int"):
            poles_against_wall(given(actuator=IDEAL), rational([-1], [1]))
        static = poles_against_wall(given(actuator=IDEAL), rational([2], [1]))
        assert (static.worst, static.stable) == (None, True)  # a loop without states has nothing to diverge


class TestCompensator:
    @pytest.mark.parametrize(
        ("numerator", "denominator"), [([1, 0], [1]), ([1], [0]), ([1], []), (["1e400"], [1, 1])], ids=str
    )
    def test_that_cannot_be_realised_is_refused(self, numerator, denominator):
        with pytest.raises(InputError, match="correction"):
            assemble(given(), rational(numerator, denominator), CORNER)

    def test_leading_zeros_do_not_count(self):
        padded = rational([0, 0, 2000], [0, 1, 70.75, 500])
        assert (assemble(given(), padded, CORNER).A == assemble(given(), PAPER, CORNER).A).all()

    def test_spanning_many_decades_keeps_its_frequency_response(self):
        roots = [1e-6, 1e-3, 1, 40, 2e3, 1e8]
        denominator, numerator = np.poly(-np.array(roots)), 1e5 * np.poly([-0.5, -3e4])
        block = connect([transfer("y", "u", *rational(numerator, denominator))], inputs=["u"])
        for s in 1j * np.array([1e-5, 0.1, 30.0, 1e4, 1e7]):
            y = block.C @ np.linalg.solve(s * np.eye(6) - block.A, block.B) + block.D
            exact = np.polyval(numerator, s) / np.prod(s + np.array(roots))
            assert abs(y[0, 0] / exact - 1) < 1e-8


class TestVerify:
    def test_moves_every_corner_of_the_box_in_three_ways(self):
        heard = []
        spec = given()
        trials = verify(spec, PAPER, quick=True, progress=heard.append)
        corners = {(i, b) for i in ("0.024", "0.036") for b in ("0.12", "0.28")} | {("0.03", "0.2")}
        assert {(trial.load.inertia, trial.load.damping) for trial in trials.trials} == {
            (Fraction(i), Fraction(b)) for i, b in corners
        }
        assert len(heard) == len(trials.trials) == 3 * len(corners)
        assert trials.stable

    def test_every_measured_impedance_is_star(self):
        spec = given()
        for trial in verify(spec, PAPER).trials:
            s = 1j * np.array(trial.frequencies)
            assert (error(np.array(trial.Z_measured), star(spec, PAPER, trial.load, s)) <= trial.accuracy).all()
            assert len(trial.frequencies) == {"step": 0, "tone": 1}.get(trial.kind, len(default_frequencies(spec)))

    def test_stable_means_free_and_against_the_wall(self):
        trials = verify(given(boxed=False), PAPER, quick=True)
        assert trials.stable
        assert not replace(trials, wall_stable=False).stable
        assert not replace(trials, trials=(*trials.trials, replace(trials.trials[0], stable=False))).stable

    def test_without_a_box_only_the_nominal_load(self):
        assert {trial.load for trial in verify(given(boxed=False), PAPER, quick=True).trials} == {loads(given())[0]}

    @pytest.mark.parametrize("compensator", [PAPER, GREEDY, rational([2], [1])], ids=["stable", "unstable", "static"])
    @pytest.mark.parametrize("actuator", [DRIVE, IDEAL], ids=["series-elastic", "ideal"])
    def test_result_is_plain_json(self, compensator, actuator):
        result = verify(given(actuator=actuator, boxed=False), compensator, quick=True).to_json()
        assert json.loads(json.dumps(result, allow_nan=False)) == result
        assert set(result) == {"trials", "wall"}


class TestSampled:
    def test_approaches_the_continuous_loop_as_the_rate_grows(self):
        coarse, fine = (sampled_comparison(given(), PAPER, rate=rate) for rate in (1000.0, 4000.0))
        assert coarse.stable
        assert coarse.rms_difference < 2e-3 * coarse.rms_theta
        assert coarse.rms_difference / fine.rms_difference == pytest.approx(4, rel=0.1)
        slowest = assemble(given(), PAPER, loads(given())[0]).poles.decay
        assert fine.spectral_radius == pytest.approx(np.exp(-slowest / 4000), abs=1e-6)

    def test_delay_makes_it_worse(self):
        differences = [sampled_comparison(given(), PAPER, delay=delay).rms_difference for delay in (0, 1, 5)]
        assert differences == sorted(differences)
        assert differences[0] < differences[1]

    def test_a_rate_too_slow_is_unstable_and_said_so(self):
        slow = sampled_comparison(given(), PAPER, rate=20.0)
        assert (slow.stable, slow.rms_difference) == (False, None)
        assert slow.spectral_radius > 1
        json.dumps(slow.to_json(), allow_nan=False)

    @pytest.mark.parametrize("delay", [0, 1, 3])
    def test_is_what_a_loop_of_ticks_computes(self, delay):
        """Ideal actuator, I θ'' + B θ' = τ between ticks solved by hand, C = 40/(s + 20) by Tustin, by hand."""
        spec, C, T, n = given(actuator=IDEAL), rational([40], [1, 20]), 1e-3, 1000
        I, B = 0.03, 0.2  # noqa: E741
        theta = speed = before = before_that = output = last_error = 0.0
        queue, record = [0.0] * delay, []
        for _ in range(n):
            record.append(theta)
            rate, rate_of_rate = (theta - before) / T, (theta - 2 * before + before_that) / T**2
            dynamic_error = 1.0 - (0.03 * rate_of_rate + 0.35 * rate + 1.25 * theta)
            output = ((2 / T - 20) * output + 40 * (dynamic_error + last_error)) / (2 / T + 20)
            queue.append(output + (0.2 - 0.35) * rate - 1.25 * theta)
            last_error, before, before_that = dynamic_error, theta, before
            final, fade = (1.0 + queue.pop(0)) / B, np.exp(-B / I * T)
            theta, speed = theta + final * T + (speed - final) * I / B * (1 - fade), final + (speed - final) * fade
        assert sampled_step(spec, C, n, 1 / T, delay) == pytest.approx(record, abs=1e-9)
        assert abs(sampled_step(spec, C, n, 1 / T, delay + 1) - record).max() > 1e-5
        assert abs(step_response(assemble(spec, C, loads(spec)[0]), (n - 1) * T, T).theta - record).max() > 1e-5


def test_shares_no_formula_with_models_or_certificate():
    """The folder imports numpy, scipy, the standard library, the errors and the specification's types; nothing else."""
    allowed = {"numpy", "scipy", "errors", "spec.model", "__future__", "typing", "dataclasses", "collections",
               "fractions", "functools", "itertools", "math"}  # fmt: skip
    for file in Path(simulation.__file__).parent.glob("*.py"):
        for node in ast.walk(ast.parse(file.read_text())):
            if isinstance(node, ast.Import):
                assert {alias.name.split(".")[0] for alias in node.names} <= allowed, file.name
            elif isinstance(node, ast.ImportFrom) and node.level != 1:
                name = node.module if node.level == 2 else node.module.split(".")[0]
                assert name in allowed, (file.name, name)
