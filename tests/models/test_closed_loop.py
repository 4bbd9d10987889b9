"""(★) and its consequences, against the equations of motion solved for random joints."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from itertools import pairwise

import elimination as e
import pytest
import sympy as sp
from elimination import eliminate, identical, ratio, s
from flint import fmpq_poly
from random_joints import Draw, Joint

from robimp.models.actuator import IDEAL, SeriesElastic, TwoPort, torque_loop
from robimp.models.closed_loop import ImpedanceLoop
from robimp.models.controller import Compensator, Filters, dynamic_error_feedback, inverse_dynamics, low_pass
from robimp.models.impedance import DynamicStiffness
from robimp.models.rational import ONE, ZERO, RationalFunction, descending, exact, polynomial


@pytest.fixture(scope="session")
def motion() -> sp.Expr:
    """θ of the whole series-elastic joint for τ_int and d: the actuator's own unknowns first, then the rest."""
    torque = eliminate(e.SERIES_ELASTIC, [e.phi, e.tau_m, e.tau_sea])[e.tau_sea]
    return eliminate([e.LOAD, sp.Eq(e.tau_sea, torque), e.LAW], [e.theta, e.tau_sea, e.tau_d])[e.theta]


@pytest.fixture(scope="session")
def two_port_motion() -> sp.Expr:
    return eliminate([e.LOAD, *e.TWO_PORT, e.LAW], [e.theta, e.tau_sea, e.tau_d])[e.theta]


# ---- the actuator


def test_series_elastic_two_port_from_motor_spring_and_torque_loop(draw: Draw) -> None:
    joint = draw.joint()
    torque = eliminate(e.SERIES_ELASTIC, [e.phi, e.tau_m, e.tau_sea])[e.tau_sea].subs(joint.values)
    assert identical(ratio(torque, e.tau_d), joint.loop.actuator.H)
    assert identical(-ratio(torque, e.theta), joint.loop.actuator.Z_a)
    assert not identical(ratio(torque, e.theta), joint.loop.actuator.Z_a)


def test_load_dependent_pair_of_any_two_port(draw: Draw) -> None:
    """(15) and corrected (16) for a load with damping and stiffness and an actuator of any order."""
    port, load = TwoPort.of(draw.function(3), draw.function(2)), draw.stiffness()
    parameters = {e.I: load.inertia, e.B: load.damping, e.K: load.stiffness}
    values = {e.H: e.expression(port.H), e.Z_a: e.expression(port.Z_a)}
    values |= {name: sp.Rational(str(x)) for name, x in parameters.items()}
    torque = eliminate([e.LOAD, *e.TWO_PORT], [e.theta, e.tau_sea])[e.tau_sea].subs(values)
    assert identical(ratio(torque, e.tau_d), port.A_cl(load))
    assert identical(ratio(torque, e.tau_int), port.A_int(load))


def test_torque_loop_is_proportional_plus_filtered_derivative() -> None:
    kp, kd, corner = sp.Rational(10), sp.Rational(1, 4), sp.Rational(1000)
    assert identical(kp + kd * s / (1 + s / corner), torque_loop(10, "0.25", 1000))


@pytest.mark.parametrize("order", [0, 1, 2, 5])
def test_two_port_of_any_order_keeps_both_functions_over_one_denominator(draw: Draw, order: int) -> None:
    H, Z_a = draw.function(order, proper=0), draw.function(2)
    port = TwoPort.of(H, Z_a)
    assert (port.H, port.Z_a) == (H, Z_a)
    assert RationalFunction(port.d, H.den * Z_a.den).num.degree() == 0  # their least common multiple


def test_two_port_counts_a_shared_pole_once() -> None:
    pole = RationalFunction.of([1], [1, 3])
    assert TwoPort.of(pole, pole * pole).d.degree() == 2
    assert TwoPort.of(pole, RationalFunction.of([1], [1, 4])).d.degree() == 2


# ---- (★)


def test_star_is_what_the_equations_of_motion_say(joint: Joint, motion: sp.Expr) -> None:
    port = 1 / ratio(motion, e.tau_int).subs(joint.values)
    Z = joint.loop.Z(joint.C, joint.load)
    assert identical(port, Z)
    assert not identical(port, Z + RationalFunction.of(["1/1000000"]))


def test_star_holds_for_a_two_port_of_any_order(draw: Draw, two_port_motion: sp.Expr) -> None:
    joint = draw.joint()
    loop = ImpedanceLoop(
        TwoPort.of(draw.function(3), draw.function(2)), joint.loop.nominal, joint.loop.desired, draw.filters("separate")
    )
    joint = Joint(loop, joint.actuator, joint.load, joint.C)
    assert identical(1 / ratio(two_port_motion, e.tau_int).subs(joint.values), loop.Z(joint.C, joint.load))


def test_a_load_disturbance_is_attenuated_by_one_minus_q_tilde(joint: Joint, motion: sp.Expr) -> None:
    """d acts as (1−Q̃)d in the place of τ_int."""
    factor = (ratio(motion, e.d) / ratio(motion, e.tau_int)).subs(joint.values)
    assert identical(factor, 1 - joint.loop.Q_tilde(joint.C))
    assert not identical(factor, joint.loop.Q_tilde(joint.C))


def test_without_force_feedback_the_port_renders_Z0(joint: Joint, motion: sp.Expr) -> None:
    port = 1 / ratio(motion, e.tau_int).subs(joint.values | {e.C: 0})
    assert identical(port, joint.loop.Z0(joint.load))
    assert joint.loop.Z(inverse_dynamics(), joint.load) == joint.loop.Z0(joint.load)
    assert joint.loop.Z(joint.C, joint.load) != joint.loop.Z0(joint.load)


def test_ideal_actuator_leaves_only_the_model_error(draw: Draw) -> None:
    """`Z = G_imp + (1−Q)(G⁻¹ − Ĝ⁻¹)`."""
    joint = draw.joint()
    loop, load = joint.loop.with_ideal_actuator(), joint.load
    Q = loop.Q_tilde(joint.C)
    assert Q == loop.Q_ideal(joint.C) == joint.loop.Q_ideal(joint.C) != joint.loop.Q_tilde(joint.C)
    assert loop.Z(joint.C, load) == loop.desired.rational + (1 - Q) * (load.rational - loop.nominal.rational)
    assert loop.Z(joint.C, loop.nominal) == loop.desired.rational


def test_the_ideal_actuator_is_the_limit_without_impedance() -> None:
    assert (IDEAL.H, IDEAL.Z_a) == (ONE, ZERO)


# ---- affine in load and impedance, jointly


def blend(a: DynamicStiffness, b: DynamicStiffness, t: Fraction) -> DynamicStiffness:
    share = exact(t)
    parts = ((getattr(a, n), getattr(b, n)) for n in ("inertia", "damping", "stiffness"))
    return DynamicStiffness(*((1 - share) * x + share * y for x, y in parts))


def test_Z_is_affine_in_load_and_impedance_jointly(joint: Joint) -> None:
    """On a line through the space of (load, impedance), Z is interpolated; no product of the two appears."""
    draw = Draw(20)
    loops = [joint.loop, ImpedanceLoop(joint.loop.actuator, joint.loop.nominal, draw.stiffness(), joint.loop.filters)]
    loads = [joint.load, draw.stiffness()]
    t = Fraction(1, 3)
    between = ImpedanceLoop(
        joint.loop.actuator, joint.loop.nominal, blend(loops[0].desired, loops[1].desired, t), joint.loop.filters
    )
    load = blend(*loads, t)
    ends = [loop.Z(joint.C, end) for loop, end in zip(loops, loads, strict=True)]
    assert between.Z(joint.C, load) == ends[0] * exact(1 - t) + ends[1] * exact(t)
    # The paper's A_cl contains the load, and is not affine in it.
    A_cl = [joint.loop.actuator.A_cl(end) for end in (loads[0], load, loads[1])]
    assert A_cl[1] != A_cl[0] * exact(1 - t) + A_cl[2] * exact(t)


# ---- poles: the determinant of every differential equation of the joint, nothing cancelled


def poly(p: fmpq_poly) -> sp.Expr:
    return e.expression(RationalFunction.lift(p))


def equations(joint: Joint, theta: sp.Symbol | int, tau_int: sp.Symbol | int) -> list[sp.Expr]:
    """Equations of motion but the load's, each with the state of its own filter: polynomial coefficients only."""
    a, filters, v = joint.actuator, joint.loop.filters, joint.values
    torque_loop_out, error, feedback, compensation, phi = sp.symbols("m e y f phi")
    tau_sea, tau_d = v[e.K_sp] * (phi - theta), feedback + compensation
    wish = poly(joint.loop.desired.polynomial)
    rows = [
        (v[e.J] * s**2 + v[e.b_m] * s) * phi - v[e.feedforward] * tau_d - torque_loop_out + tau_sea,
        poly(a.C_t.den) * torque_loop_out - poly(a.C_t.num) * (tau_d - tau_sea),
        poly(joint.C.den) * feedback - poly(joint.C.num) * error,
        poly(filters.derivative.den) * compensation
        - poly(filters.derivative.num) * poly(joint.loop.nominal.polynomial - joint.loop.desired.polynomial) * theta,
    ]
    F = filters.force
    if filters.position is None:
        return [*rows, poly(F.den) * error - poly(F.num) * (tau_int - wish * theta)]
    force, position = sp.symbols("e_tau e_theta")
    return [
        *(row.subs(error, force - position) for row in rows),
        poly(F.den) * force - poly(F.num) * tau_int,
        poly(filters.position.den) * position - poly(filters.position.num) * wish * theta,
    ]


def characteristic(rows: list[sp.Expr]) -> tuple[Fraction, ...]:
    """Monic determinant of homogeneous equations, linear in their unknowns."""
    unknowns = sorted(set().union(*(row.free_symbols for row in rows)) - {s}, key=str)
    matrix = sp.Matrix([[sp.expand(row).coeff(x) for x in unknowns] for row in rows])
    determinant = sp.Poly(matrix.det(method="berkowitz"), s).monic()
    return tuple(Fraction(int(c.p), int(c.q)) for c in determinant.all_coeffs())


def monic(p: fmpq_poly) -> tuple[Fraction, ...]:
    return descending(p / p.leading_coefficient())


def free_equations(joint: Joint) -> list[sp.Expr]:
    load = poly(joint.load.polynomial) * e.theta - joint.values[e.K_sp] * (sp.Symbol("phi") - e.theta)
    return [load, *equations(joint, e.theta, 0)]


def locked_equations(joint: Joint) -> list[sp.Expr]:
    """The wall holds θ = 0 and answers with `τ_int = −τ_sea`."""
    return equations(joint, 0, -joint.values[e.K_sp] * sp.Symbol("phi"))


def test_free_poles_are_those_of_the_whole_joint(joint: Joint) -> None:
    polynomial_ = joint.loop.free(joint.load)(joint.C)
    assert monic(polynomial_) == characteristic(free_equations(joint))
    assert monic(polynomial_) != monic(joint.loop.free(joint.loop.nominal)(joint.C))


def test_locked_poles_are_those_of_the_whole_joint_against_a_wall(joint: Joint) -> None:
    polynomial_ = joint.loop.locked()(joint.C)
    assert monic(polynomial_) == characteristic(locked_equations(joint))
    assert monic(polynomial_) != characteristic(free_equations(joint))


def divides(p: fmpq_poly, q: fmpq_poly) -> bool:
    return bool((q % p).degree() < 0)


def test_zeros_of_Z_are_free_poles_and_poles_of_Z_are_locked_poles(joint: Joint) -> None:
    Z = joint.loop.Z(joint.C, joint.load)
    free, locked = joint.loop.free(joint.load)(joint.C), joint.loop.locked()(joint.C)
    assert divides(Z.num, free)
    assert divides(Z.den, locked)
    assert RationalFunction(free, locked) == Z
    assert not divides(Z.num, locked)


UNSTABLE = polynomial([1, -1])


@pytest.mark.parametrize("where", ["free", "locked"])
def test_an_unstable_pair_that_cancels_in_C_is_still_counted(joint: Joint, where: str) -> None:
    hidden = Compensator(joint.C.num * UNSTABLE, joint.C.den * UNSTABLE)
    assert joint.loop.Z(hidden, joint.load) == joint.loop.Z(joint.C, joint.load)  # the port does not see it

    def polynomial_(C: Compensator) -> fmpq_poly:
        return joint.loop.locked()(C) if where == "locked" else joint.loop.free(joint.load)(C)

    assert divides(UNSTABLE, polynomial_(hidden))
    assert not divides(UNSTABLE, polynomial_(joint.C))
    assert not divides(UNSTABLE, polynomial_(dynamic_error_feedback(hidden.rational.num, hidden.rational.den)))


def test_a_mode_that_cancels_inside_the_actuator_is_still_counted() -> None:
    """The two-port's denominator is kept as it came, so H and Z_a do not tell the whole."""
    port = SeriesElastic(exact(1), exact(2), exact(3), RationalFunction.of([1, 2], [1, 2]), exact(0)).two_port
    hidden = TwoPort(port.h * UNSTABLE, port.z * UNSTABLE, port.d * UNSTABLE)
    nominal, C = DynamicStiffness.of(1, 1, 1), dynamic_error_feedback(polynomial([1]), polynomial([1]))
    loop = ImpedanceLoop(hidden, nominal, DynamicStiffness.of(1, 2, 1))
    assert (hidden.H, hidden.Z_a) == (port.H, port.Z_a)
    assert divides(UNSTABLE, loop.locked()(C))
    assert divides(UNSTABLE, loop.free(nominal)(C))
    assert not divides(UNSTABLE, ImpedanceLoop(port, nominal, loop.desired).locked()(C))


@pytest.mark.parametrize("inertia", ["1/200", "1/3"])
@pytest.mark.parametrize("derivative", [None, 300])
@pytest.mark.parametrize("end", ["free", "locked"])
def test_a_loop_is_well_posed_if_a_short_lag_adds_a_root_on_the_left(
    end: str, derivative: int | None, inertia: str
) -> None:
    """H = 2: of `(1 + εs) P + R` instead of `P + R` the new root is at about −(1 + R/P)(∞)/ε."""
    nominal, desired = DynamicStiffness.of("1/20", "3/10", 1), DynamicStiffness.of(inertia, "1/50", 2)
    filters = Filters() if derivative is None else Filters(derivative=low_pass(derivative))
    found = set()
    for gain in ("-7", "-3", "-2/3", "-2/5", "0", "399/100", "401/100"):
        C = dynamic_error_feedback(polynomial([exact(gain), exact(3)]), polynomial([1, 1]))
        port = TwoPort(polynomial([2]), polynomial([0]), polynomial([1]))
        well_posed = ImpedanceLoop(port, nominal, desired, filters).well_posed(C, end)
        lag = polynomial([Fraction(1, 10**9), 1])
        lagging = ImpedanceLoop(replace(port, d=lag), nominal, desired, filters)
        roots = (lagging.free(nominal) if end == "free" else lagging.locked())(C).complex_roots()
        fastest = max((root for root, _ in roots), key=lambda root: float(abs(root)))
        assert abs(float(fastest.real)) > 1e5
        assert well_posed is (float(fastest.real) < 0)
        found.add(well_posed)
    assert found == {True, False}


def test_a_characteristic_polynomial_is_linear_in_the_compensator(joint: Joint) -> None:
    """What the search uses: values at three compensators on a line lie on a line."""
    pencil = joint.loop.free(joint.load)
    compensators = [Compensator(joint.C.num + k * polynomial([1, 2]), joint.C.den) for k in range(3)]
    first, second = pairwise(pencil(C) for C in compensators)
    assert first[1] - first[0] == second[1] - second[0]
    assert first[1] - first[0] != polynomial([0])
