"""The compiled joint: exact where nothing switches, Coulomb's law where something does."""

from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import expm

from robimp.synthesis import load
from robimp.synthesis.errors import InputError
from robimp.synthesis.simulation import assemble, loads, sampled_step, step_response
from robimp.synthesis.simulation.batch.environment import (
    LIMBS,
    attached,
    held_by,
    second_robot,
    stable_with,
    through_spring,
)
from robimp.synthesis.simulation.batch.ladder import ladder
from robimp.synthesis.simulation.batch.law import sampled_law
from robimp.synthesis.simulation.batch.run import simulate_batch
from robimp.synthesis.simulation.batch.switched import Imperfections, Wall, switched
from robimp.synthesis.spec.model import IdealActuator, Impedance, Plant

SPEC = load(Path(__file__).parents[2] / "examples" / "haninger2016-paper.yaml")
C = ((Fraction(2000),), (Fraction(1), Fraction("70.75"), Fraction(500)))  # Q/(1−Q) of the paper's Q
NOTHING = ((Fraction(0),), (Fraction(1),))
EXACT = 1e-9


def mass(inertia=2, stiffness=0):
    """A load whose controller does nothing: it wishes the load as it is."""
    parts = {"inertia": Fraction(inertia), "damping": Fraction(0), "stiffness": Fraction(stiffness)}
    update = {"plant": Plant(**parts), "impedance": Impedance(**parts), "actuator": IdealActuator(type="ideal")}
    return SPEC.model_copy(update=update)


def body(inertia=2, stiffness=0, faults=None, **options):
    table = np.array([[inertia, 0.0, stiffness]], dtype=float)
    return switched(mass(inertia, stiffness), NOTHING, table, faults, **options)


class TestSteps:
    def test_every_step_of_the_ladder_is_the_exponential(self):
        joint = switched(SPEC, C, loads(SPEC))
        n, width = joint.states, joint.flows.shape[-1]
        steps = np.empty((6, n, width))
        ladder(joint.flows[1, 0], 4e-3, steps)
        square = np.zeros((width, width))
        square[:n] = joint.flows[1, 0]
        for level in range(6):
            exact = expm(square * 4e-3 / 2**level)[:n] - np.eye(n, width)
            assert abs(steps[level] - exact).max() < 1e-12 * abs(exact).max()

    def test_a_long_step_of_a_fast_joint_is_finite(self):
        joint = switched(SPEC, C, loads(SPEC))
        steps = np.empty((3, joint.states, joint.flows.shape[-1]))
        ladder(joint.flows[0, 0], 1000.0, steps)
        assert abs(steps[0][:, : joint.states] + np.eye(joint.states)).max() < 1e-6, "everything has decayed"

    def test_without_switches_it_is_the_joint_of_the_other_simulator(self):
        run = simulate_batch(switched(SPEC, C, loads(SPEC)), 1e-3, np.ones(2001), every=1)
        for i, each in enumerate(loads(SPEC)):
            response = step_response(assemble(SPEC, C, each), 2.0, 1e-3)
            assert abs(run.trace("theta", i) - response.theta).max() < EXACT
            assert run.energy[i] == pytest.approx(response.theta[-1], rel=1e-2), "one N·m through θ"

    def test_the_sampled_controller_is_that_of_the_other_simulator(self):
        joint, law = switched(SPEC, None, loads(SPEC)[:1]), sampled_law(SPEC, C, rate=1000, delay=2)
        run = simulate_batch(joint, law.tick, np.ones(1500), law=law, every=1)
        assert abs(run.trace("theta") - sampled_step(SPEC, C, 1500, 1000, 2)).max() < EXACT
        other = sampled_law(SPEC, C, rate=1000, delay=3)
        late = simulate_batch(joint, law.tick, np.ones(1500), law=other, every=1)
        assert abs(run.trace("theta") - late.trace("theta")).max() > 1e-4, "a tick of delay is seen"

    def test_single_precision_is_near_double_and_not_the_same(self):
        joint = switched(SPEC, None, loads(SPEC)[:1])
        runs = [
            simulate_batch(joint, 1e-3, np.ones(1000), law=sampled_law(SPEC, C, arithmetic=arithmetic), every=1)
            for arithmetic in ("float64", "float32")
        ]
        assert 1e-12 < abs(runs[0].trace("theta") - runs[1].trace("theta")).max() < 1e-3

    def test_a_closed_system_keeps_its_energy_for_a_million_steps(self):
        laws = through_spring(50, 0, Fraction(1, 2))
        joint = body(2, environment=laws)
        start = np.zeros(joint.states)
        start[0] = 1.0
        run = simulate_batch(joint, 1e-3, np.zeros(1_000_001), start=start, every=1_000_000, levels=1)
        again = simulate_batch(joint, 1e-3, np.zeros(1_000_001), start=start, every=1_000_000)
        # θ' and the spring's torque at the end give the rest: momentum is conserved too.
        for each in (run, again):
            speed, torque = each.trace("velocity")[-1], each.trace("tau_int")[-1]
            other = (2.0 - 2.0 * speed) / 0.5
            energy = 0.5 * 2 * speed**2 + 0.5 * 0.5 * other**2 + 0.5 * torque**2 / 50
            assert energy == pytest.approx(1.0, abs=1e-9)


class TestFriction:
    def test_a_body_pushed_and_let_go_stops_where_it_should_and_stays(self):
        push = np.where(np.arange(60) < 8, 3.0, 0.0)  # 1.04 s of 3 N·m on 2 kg·m² against 1 N·m
        run = simulate_batch(body(faults=Imperfections(load_friction=1.0)), 0.13, push, every=1)
        theta, velocity = run.trace("theta"), run.trace("velocity")
        assert velocity[8] == pytest.approx(1.04, abs=1e-12)
        assert theta[-1] == pytest.approx(0.5 * 1.04**2 + 1.04**2, abs=1e-4 * 0.13)
        at_rest = velocity == 0
        assert at_rest[-20:].all() and len(set(theta[-20:])) == 1, "exact sticking"
        free = simulate_batch(body(), 0.13, push, every=1)
        assert free.trace("velocity")[-1] == pytest.approx(1.56), "without friction it never stops"

    def test_less_than_the_friction_moves_nothing_and_more_does(self):
        joint = body(faults=Imperfections(load_friction=1.0))
        still = simulate_batch(joint, 0.1, np.full(100, 0.999999), every=1)
        assert (still.trace("theta") == 0).all() and still.stuck[0] == 25
        assert simulate_batch(joint, 0.1, np.full(100, 1.000001)).late[0] > 0

    def test_stiction_holds_more_than_it_brakes(self):
        joint = body(faults=Imperfections(load_friction=1.0, stiction=1.5))
        assert simulate_batch(joint, 0.1, np.full(100, 1.49)).late[0] == 0
        assert simulate_batch(joint, 0.1, np.full(10, 1.51), every=1).trace("velocity")[1] == pytest.approx(
            0.1 * 0.51 / 2, rel=1e-3
        )

    def test_an_oscillation_loses_the_same_angle_each_half_turn(self):
        joint = body(1, 100, Imperfections(load_friction=1.0))
        start = np.array([0.0, 0.105])  # 100 N·m/rad: 0.01 rad are held, 0.02 rad lost each half turn
        half = np.pi / 10
        run = simulate_batch(joint, half / 32, np.zeros(32 * 8), start=start, every=32, levels=20)
        expected = [0.105, -0.085, 0.065, -0.045, 0.025, -0.005, -0.005, -0.005]
        assert run.trace("theta") == pytest.approx(expected, abs=1e-7)
        assert run.trace("velocity")[-1] == 0

    def test_each_halving_of_the_finest_step_halves_the_error_of_stick_and_slip(self):
        faults = Imperfections(load_friction=0.3, motor_friction=0.1)
        joint = switched(SPEC, C, loads(SPEC)[:1], faults)
        push = np.sin(2 * np.pi * np.arange(400) * 5e-3)
        reference = simulate_batch(joint, 5e-3, push, every=1, levels=26)
        assert 0 < reference.stuck[0] < 100 and reference.reversals[0] >= 1, "it sticks, and slips"
        errors = []
        levels = range(3, 19, 3)
        for count in levels:
            run = simulate_batch(joint, 5e-3, push, every=1, levels=count)
            errors.append(abs(run.trace("theta") - reference.trace("theta")).max())
        order = -np.polyfit(list(levels), np.log2(errors), 1)[0]
        assert 0.9 < order < 2.1
        assert errors[-1] < 1e-6 * abs(reference.trace("theta")).max()

    def test_friction_only_takes_energy(self):
        rng = np.random.default_rng(1)
        push = 2 * rng.standard_normal(5000)
        joint = body(faults=Imperfections(load_friction=0.5))
        run = simulate_batch(joint, 1e-2, push, every=4999)
        kinetic = run.trace("velocity")[-1] ** 2
        before_last = run.energy[0]
        assert kinetic < before_last


class TestPorts:
    def test_a_limit_holds_the_drive_back(self):
        spec = mass(2, 0).model_copy(update={"impedance": SPEC.impedance})
        table = np.array([[2.0, 0.0, 0.0]])
        free, limited = (
            simulate_batch(switched(spec, C, table, Imperfections(torque_limit=limit)), 1e-3, np.ones(3000), every=1)
            for limit in (np.inf, 0.5)
        )
        pull = np.diff(limited.trace("velocity")) / 1e-3 * 2 - 1.0
        assert abs(pull).max() <= 0.5 + 1e-9
        assert abs(np.diff(free.trace("velocity")) / 1e-3 * 2 - 1.0).max() > 0.6

    def test_a_lossless_wall_gives_back_the_speed_and_never_pulls(self):
        wall = Wall(stiffness=5000.0, damping=0.0, place=0.3)
        joint = body(2, wall=wall)
        run = simulate_batch(joint, 1e-2, np.zeros(100), start=np.array([1.0, 0.0]), every=1, levels=20)
        assert run.trace("velocity")[-1] == pytest.approx(-1.0, abs=1e-6)
        assert (run.trace("tau_int") <= 1e-9).all() and run.trace("theta").max() > 0.3

    @pytest.mark.parametrize("place", [0.4508, 0.4511, 0.45124])
    def test_a_wall_that_is_met_and_left_within_one_tick_is_met(self, place):
        joint = body(2, wall=Wall(stiffness=5e4, damping=200.0, place=place))  # apex 0.95²/2 = 0.45125 at 0.95 s
        start = np.array([0.95, 0.0])
        coarse = simulate_batch(joint, 0.1, np.full(20, -2.0), start=start, every=1, levels=20)
        fine = simulate_batch(joint, 1e-3, np.full(2000, -2.0), start=start, every=100, levels=20)
        thrown = 0.95 * 1.9 - 1.9**2 / 2
        assert coarse.trace("theta")[-1] == pytest.approx(fine.trace("theta")[-1], abs=1e-6)
        assert abs(coarse.trace("theta")[-1] - thrown) > 1e-3, "without the wall"

    def test_contacts_much_shorter_than_a_tick_are_those_of_fine_ticks(self):
        rng = np.random.default_rng(0)
        for _ in range(30):
            place = rng.uniform(0, 0.3)
            joint = body(1, 100.0, wall=Wall(10 ** rng.uniform(3, 7), 0.0, place))
            start = np.array([rng.uniform(1, 5), rng.uniform(-0.3, min(place, 0.1))])
            coarse, fine = (
                simulate_batch(joint, 0.05 / n, np.zeros(20 * n), start=start, every=n, levels=20) for n in (1, 64)
            )
            assert abs(coarse.trace("theta") - fine.trace("theta")).max() < 1e-3

    def test_prescribed_motion_is_answered_by_the_torque_it_takes(self):
        joint = body(2, faults=Imperfections(load_friction=0.5), driven=True)
        run = simulate_batch(joint, 1e-2, np.zeros(100), motion=np.ones(100), every=1)
        assert run.trace("theta")[50] == pytest.approx(0.125)
        assert run.trace("tau_int")[50] == pytest.approx(2.5)

    @pytest.mark.parametrize(
        "laws",
        [
            attached(Fraction(1, 10), Fraction(1, 10), 2),
            held_by(LIMBS[1]),
            through_spring(50, Fraction(1, 10), Fraction(1, 10)),
            second_robot(SPEC, C, loads(SPEC)[1], 20, Fraction(1, 10)),
        ],
        ids=["attached", "arm", "mass on a spring", "second robot"],
    )
    def test_what_is_coupled_has_the_poles_of_the_whole(self, laws):
        joint = switched(SPEC, C, loads(SPEC)[:1], environment=laws)
        worst = max(np.linalg.eigvals(joint.flows[0, 0, :, : joint.states]), key=lambda pole: pole.real)
        expected = stable_with(assemble(SPEC, C, loads(SPEC)[0]).system, laws)
        assert worst.real == pytest.approx(expected.real, rel=1e-9) and expected.real < 0

    def test_encoder_and_noise_belong_to_a_sampled_controller_and_follow_the_seed(self):
        faults = Imperfections(encoder=1e-3, torque_noise=0.01)
        with pytest.raises(InputError, match="sampled"):
            simulate_batch(switched(SPEC, C, loads(SPEC), faults), 1e-3, np.ones(10))
        joint, law = switched(SPEC, None, loads(SPEC), faults), sampled_law(SPEC, C)
        late = [simulate_batch(joint, 1e-3, np.ones(500), law=law, seed=seed).late for seed in (1, 1, 2)]
        assert (late[0] == late[1]).all() and (late[0] != late[2]).all()
        assert len(set(late[0])) == len(late[0]), "every joint has its own noise"

    def test_each_joint_may_take_its_own_course(self):
        chosen = np.array([0, 1, 0, 1, 1])
        run = simulate_batch(switched(SPEC, C, loads(SPEC)), 1e-3, np.outer([0.0, 1.0], np.ones(100)), chosen=chosen)
        assert ((run.late > 0) == (chosen == 1)).all()
