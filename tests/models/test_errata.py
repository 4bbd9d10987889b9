"""The paper's equations, each derived anew from the physics; where it is misprinted, the printed version must fail."""

from __future__ import annotations

import elimination as e
import numpy as np
import pytest
import sympy as sp
from elimination import C, G_imp, H, Q, Z_a, eliminate, expression, g, g_hat, identical, ratio, s
from random_joints import Draw

from robimp.models.actuator import A, SeriesElastic
from robimp.models.closed_loop import ImpedanceLoop
from robimp.models.controller import Compensator, Filters, disturbance_observer, eq23, inverse_dynamics
from robimp.models.impedance import DynamicStiffness, inverse_dynamic_compensation
from robimp.models.rational import ZERO, RationalFunction, exact, polynomial
from robimp.models.uncertainty import Omega

UNFILTERED = {e.F: 1, e.F_theta: 1, e.F_d: 1}
DOB = {C: Q / (1 - Q)}
Delta = g_hat / g - 1  # (3)
Om = G_imp / g_hat - 1  # (4)
FreeInertia = tuple[SeriesElastic, DynamicStiffness, dict[sp.Symbol, sp.Expr]]


@pytest.fixture(scope="session")
def ideal() -> sp.Expr:
    """θ behind an ideal actuator, for both inputs."""
    return eliminate([e.LOAD, *e.IDEAL_ACTUATOR, e.LAW], [e.theta, e.tau_sea, e.tau_d])[e.theta]


@pytest.fixture(scope="session")
def undamped() -> dict[sp.Symbol, sp.Expr]:
    """τ_sea and θ of section IV's model: two inertias and a spring, in closed torque loop."""
    solution = eliminate([e.LOAD, *e.SERIES_ELASTIC], [e.theta, e.phi, e.tau_m, e.tau_sea])
    return {name: value.subs({e.B: 0, e.K: 0, e.b_m: 0, e.feedforward: 0}) for name, value in solution.items()}


def ideal_loop(draw: Draw, filters: Filters | None = None) -> ImpedanceLoop:
    loop = ImpedanceLoop(draw.series_elastic().two_port, draw.stiffness(), draw.stiffness(), filters or Filters())
    return loop.with_ideal_actuator()


def values(loop: ImpedanceLoop, load: DynamicStiffness, Q_value: RationalFunction = ZERO) -> dict[sp.Symbol, sp.Expr]:
    numbers = {e.I: load.inertia, e.B: load.damping, e.K: load.stiffness}
    known = {symbol: sp.Rational(str(value)) for symbol, value in numbers.items()}
    models = {g_hat: loop.nominal.rational, G_imp: loop.desired.rational, Q: Q_value}
    return known | {symbol: expression(model) for symbol, model in models.items()}


def observer(Q_value: RationalFunction) -> Compensator:
    return disturbance_observer(Q_value.num, Q_value.den)


# ---- II. Inverse dynamic compensation


def test_eq2_is_the_difference_of_each_parameter(draw: Draw) -> None:
    nominal, desired = draw.stiffness(), draw.stiffness()
    t = sp.Symbol("t")
    motion = sp.exp(s * t)
    printed = sum(
        sp.Rational(str(getattr(nominal, name) - getattr(desired, name))) * sp.diff(motion, t, order)
        for name, order in (("inertia", 2), ("damping", 1), ("stiffness", 0))
    )
    assert identical(sp.simplify(printed / motion), inverse_dynamic_compensation(nominal, desired))
    assert not identical(sp.simplify(printed / motion), inverse_dynamic_compensation(desired, nominal))


def test_eq4_omega_takes_the_model_to_the_wish(draw: Draw) -> None:
    nominal, desired = draw.stiffness(), draw.stiffness()
    assert nominal.rational * (1 + Omega(nominal, desired)) == desired.rational
    assert Omega(nominal, nominal) == ZERO
    assert Omega(desired, nominal) != Omega(nominal, desired)


def test_eq5_inverse_dynamic_compensation(draw: Draw, ideal: sp.Expr) -> None:
    rendered = ratio(ideal, e.tau_int).subs(UNFILTERED).subs(C, 0)
    assert identical(rendered, (1 + Delta) / (1 + Delta * Om / (1 + Om)) / G_imp)
    loop, load = ideal_loop(draw), draw.stiffness()
    assert identical(rendered.subs(values(loop, load)), 1 / loop.Z(inverse_dynamics(), load))


# ---- III. Disturbance observer


def test_eq7_is_the_loop_without_inner_compensation(draw: Draw, ideal: sp.Expr) -> None:
    bare = ideal.subs({e.F: 1, e.F_theta: 1, e.F_d: 0}).subs(DOB)
    G = 1 / g
    from_torque, from_disturbance = ratio(bare, e.tau_int), ratio(bare, e.d)
    assert identical(from_torque, G / (1 + Q * G * G_imp - Q))
    assert identical(from_disturbance, G * (1 - Q) / (1 + Q * G * G_imp - Q))
    loop, load, q = ideal_loop(draw, Filters(derivative=ZERO)), draw.stiffness(), draw.function(2)
    assert identical(from_torque.subs(values(loop, load, q)), 1 / loop.Z(observer(q), load))
    compensated = ImpedanceLoop(loop.actuator, loop.nominal, loop.desired)
    assert not identical(from_torque.subs(values(loop, load, q)), 1 / compensated.Z(observer(q), load))


def test_eq8_the_loop_with_inner_compensation(draw: Draw, ideal: sp.Expr) -> None:
    rendered = ratio(ideal, e.tau_int).subs(UNFILTERED).subs(DOB)
    G = 1 / g
    assert identical(rendered, G / (1 - Q + G_imp * G - (1 - Q) * G * g_hat))
    loop, load, q = ideal_loop(draw), draw.stiffness(), draw.function(2)
    assert identical(rendered.subs(values(loop, load, q)), 1 / loop.Z(observer(q), load))


def test_eq9_its_two_sides_are_the_denominator_of_eq8(ideal: sp.Expr) -> None:
    rendered = ratio(ideal, e.tau_int).subs(UNFILTERED).subs(DOB)
    assert identical(1 / (g * rendered), 1 - Q + (1 + Delta) * (Om + Q))
    assert identical(1 / (g * rendered), 1 + Om + Delta * (Om + Q))
    assert not identical(1 / (g * rendered), 1 + Om + Delta * Om)


def test_eq6_is_eq9_without_the_observer(ideal: sp.Expr) -> None:
    """(6) bounds ΔΩ/(1+Ω); the denominator of (5) is that of (9) at Q = 0."""
    rendered = ratio(ideal, e.tau_int).subs(UNFILTERED).subs(C, 0)
    assert identical(1 / (g * rendered), 1 + Om + Delta * Om)


def test_eq10_the_observer_adds_its_filtered_estimate_to_itself(draw: Draw) -> None:
    """Fig. 3: the torque plus the dynamic error, through Q, is the torque: `u = Q(u + e)`."""
    q = draw.function(2)
    u, error = sp.symbols("u error")
    C_from_figure = eliminate([sp.Eq(u, Q * (u + error))], [u])[u] / error
    assert identical(C_from_figure.subs(Q, expression(q)), observer(q).rational)


@pytest.mark.parametrize(
    ("num", "den", "reason"), [([1, 1], [1, 1], "identically"), ([1, 0, 0], [1, 1], "proper")], ids=["Q=1", "improper"]
)
def test_eq10_refuses_a_filter_without_compensator(num: list[int], den: list[int], reason: str) -> None:
    with pytest.raises(ValueError, match=reason):
        disturbance_observer(polynomial(num), polynomial(den))


# ---- (11), (12): erratum, the two sides exchanged


def cayley(port: sp.Expr) -> sp.Expr:
    """`(T−1)/(T+1)` of the velocity per torque `T = s/Z`; its modulus is below 1 iff T is positive real."""
    T = s / port
    return (T - 1) / (T + 1)


Delta_tilde = (1 - Q) * Delta / (1 + Delta)
EQ11 = ((s - G_imp) / g_hat + Delta_tilde) / ((s + G_imp) / g_hat - Delta_tilde)
EQ11_PRINTED = ((s + G_imp) / g_hat + Delta_tilde) / ((s - G_imp) / g_hat - Delta_tilde)


def test_eq11_is_the_cayley_transform_of_the_port_with_its_sides_exchanged(ideal: sp.Expr) -> None:
    port = 1 / ratio(ideal, e.tau_int).subs(UNFILTERED).subs(DOB)
    assert identical(cayley(port), EQ11)
    assert not identical(cayley(port), EQ11_PRINTED)


def test_eq12_as_printed_refuses_every_passive_impedance_of_an_exact_model(draw: Draw) -> None:
    """With Δ = 0 passivity is that of G_imp. Corrected, (12) holds wherever `Re(G_imp/jω) > 0`; printed, nowhere."""
    omega = np.geomspace(1e-3, 1e4, 60)
    desired = draw.stiffness().rational.at(omega)
    model = np.abs(1 / draw.stiffness().rational.at(omega))
    printed = (model * abs(1j * omega + desired) < model * abs(1j * omega - desired)).any()
    corrected = (model * abs(1j * omega - desired) < model * abs(1j * omega + desired)).all()
    assert corrected
    assert not printed


# ---- IV. Series-elastic actuator


def test_eq13_from_the_free_bodies() -> None:
    """Two inertias, a spring: `τ̈_sea/K_sp = φ̈ − θ̈`."""
    load = sp.Eq(e.I * s**2 * e.theta, e.tau_int + e.tau_sea)
    motor = sp.Eq(e.J * s**2 * e.phi, e.tau_m - e.tau_sea)
    tau_sea = eliminate([load, motor, e.SPRING], [e.theta, e.phi, e.tau_sea])[e.tau_sea]
    left = s**2 * tau_sea / e.K_sp
    assert identical(left, -(1 / e.I + 1 / e.J) * tau_sea + e.tau_m / e.J - e.tau_int / e.I)


def test_eq14_the_spring_between_two_inertias(draw: Draw) -> None:
    inertia, motor, spring = draw.number(), draw.number(), draw.number()
    open_loop = eliminate([e.LOAD, e.SPRING, e.MOTOR], [e.theta, e.phi, e.tau_sea])[e.tau_sea]
    from_motor = (e.J * ratio(open_loop, e.tau_m)).subs({e.B: 0, e.K: 0, e.b_m: 0})
    known = {name: sp.Rational(str(x)) for name, x in ((e.I, inertia), (e.J, motor), (e.K_sp, spring))}
    assert identical(from_motor.subs(known), A(inertia, motor, spring))  # type: ignore[arg-type]


@pytest.fixture
def free_inertia(draw: Draw) -> FreeInertia:
    """Section IV's actuator on a free inertia, and its numbers."""
    actuator = SeriesElastic(draw.number(), exact(0), draw.number(), draw.function(1, proper=0), exact(0))  # type: ignore[arg-type]
    load = DynamicStiffness(draw.number(), exact(0), exact(0))  # type: ignore[arg-type]
    known = {e.I: load.inertia, e.J: actuator.J, e.K_sp: actuator.K_sp}
    numbers = {name: sp.Rational(str(x)) for name, x in known.items()} | {e.C_t: expression(actuator.C_t)}
    return actuator, load, numbers


def test_eq15_closed_torque_loop(free_inertia: FreeInertia, undamped: dict[sp.Symbol, sp.Expr]) -> None:
    actuator, load, numbers = free_inertia
    derived = ratio(undamped[e.tau_sea], e.tau_d).subs(numbers)
    spring = A(load.inertia, actuator.J, actuator.K_sp)
    assert identical(derived, actuator.two_port.A_cl(load))
    assert identical(derived, actuator.C_t * spring / (actuator.J + actuator.C_t * spring))


def test_eq16_has_the_other_sign(free_inertia: FreeInertia, undamped: dict[sp.Symbol, sp.Expr]) -> None:
    actuator, load, numbers = free_inertia
    derived = ratio(undamped[e.tau_sea], e.tau_int).subs(numbers)
    spring, inertia = A(load.inertia, actuator.J, actuator.K_sp), load.inertia
    printed = actuator.J * spring / (inertia * actuator.J + inertia * actuator.C_t * spring)
    assert identical(derived, actuator.two_port.A_int(load))
    assert identical(derived, -printed)
    assert not identical(derived, printed)


def test_eq16_as_printed_breaks_newton() -> None:
    """Without torque control, a slow push moves load and motor as one body: `θ̈ = τ_int/(I+J)`."""
    inertia, motor = exact("0.03"), exact("0.01")
    passive = SeriesElastic(motor, exact(0), exact("4.8"), ZERO, exact(0)).two_port
    A_int = passive.A_int(DynamicStiffness(inertia, exact(0), exact(0)))
    acceleration = (1 + A_int) / inertia
    assert float(acceleration(0.0)) == pytest.approx(1 / 0.04)
    assert float(((1 - A_int) / inertia)(0.0)) > 1 / 0.03


def eq17(A_int: RationalFunction, q: RationalFunction, loop: ImpedanceLoop, load: DynamicStiffness) -> RationalFunction:
    A_cl, G, wish = loop.actuator.A_cl(load), 1 / load.rational, loop.desired.rational
    above = G * A_cl * q + (1 - q) * G * (1 + A_int)
    return above / (1 - q + G * A_cl * wish - (1 - q) * G * A_cl * loop.nominal.rational)


def test_eq17_holds_with_the_corrected_eq16_only(draw: Draw) -> None:
    joint, q = draw.joint(), draw.function(2)
    numbers = joint.values | {C: expression(observer(q).rational)}
    motion = eliminate([e.LOAD, *e.TWO_PORT, e.LAW], [e.theta, e.tau_sea, e.tau_d])[e.theta]
    derived = ratio(motion, e.tau_int).subs(numbers)
    A_int = joint.loop.actuator.A_int(joint.load)
    assert identical(derived, 1 / joint.loop.Z(observer(q), joint.load))
    assert identical(derived, eq17(A_int, q, joint.loop, joint.load))
    assert not identical(derived, eq17(-A_int, q, joint.loop, joint.load))


def test_eq18_is_the_denominator_of_eq17_in_delta_and_omega() -> None:
    A_cl, De, Ome = sp.symbols("A_cl Delta Omega")
    G_hat = 1 / g_hat
    G = G_hat * (1 + De)
    denominator = 1 - Q + G * A_cl * G_imp - (1 - Q) * G * A_cl * g_hat
    assert identical(denominator.subs(G_imp, g_hat * (1 + Ome)), 1 - Q + A_cl * (1 + De) * (Ome + Q))


def test_eq18_physical_denominator_is_that_of_the_port() -> None:
    """`Z(1+HCF)(1−Q)G = 1−Q + (1+Δ)((1−Q)Z_aĜ + H(Ω+Q))`: here the load appears in Δ alone."""
    motion = eliminate([e.LOAD, *e.TWO_PORT, e.LAW], [e.theta, e.tau_sea, e.tau_d])[e.theta]
    port = 1 / ratio(motion, e.tau_int).subs(UNFILTERED).subs(DOB)
    loop_gain = H * Q / (1 - Q)
    assert identical(port * (1 + loop_gain) * (1 - Q) / g, 1 - Q + (1 + Delta) * ((1 - Q) * Z_a / g_hat + H * (Om + Q)))


# ---- V. Dynamic error feedback: erratum, the numerator


def test_eq22_is_the_compensated_plant(draw: Draw) -> None:
    """`N` takes a torque beside the inner compensation to `G_imp θ`."""
    inner = sp.Eq(e.tau_d, (g_hat - G_imp) * e.theta)
    motion = eliminate([e.LOAD, *e.IDEAL_ACTUATOR, inner], [e.theta, e.tau_sea, e.tau_d])[e.theta]
    loop, load = ideal_loop(draw), draw.stiffness()
    derived = (G_imp * ratio(motion, e.d)).subs(values(loop, load))
    assert identical(derived, loop.dynamic_error_gain(load))


def test_eq21_needs_the_torque_that_acts_on_the_plant_directly(draw: Draw, ideal: sp.Expr) -> None:
    loop, load, compensator = ideal_loop(draw), draw.stiffness(), draw.compensator()
    numbers = values(loop, load) | {C: expression(compensator.rational)}
    derived = ratio(ideal, e.tau_int).subs(UNFILTERED).subs(numbers)
    N, gain, wish = loop.dynamic_error_gain(load), compensator.rational, loop.desired.rational
    assert identical(derived, 1 / loop.Z(compensator, load))
    assert identical(derived, (1 + gain) * N / (1 + gain * N) / wish)
    assert not identical(derived, gain * N / (1 + gain * N) / wish)


def test_eq21_agrees_with_eq8_for_the_observer_only_when_corrected(ideal: sp.Expr) -> None:
    G, gain = 1 / g, Q / (1 - Q)
    N = G * G_imp / (1 - G * (g_hat - G_imp))
    eq8 = G / (1 - Q + G_imp * G - (1 - Q) * G * g_hat)
    assert identical(eq8, (1 + gain) * N / (1 + gain * N) / G_imp)
    assert not identical(eq8, gain * N / (1 + gain * N) / G_imp)


# ---- VI. The filter


def test_eq23_the_papers_filter() -> None:
    q = RationalFunction(*eq23("0.8", 50))
    assert q == RationalFunction.of([2000], [1, "70.75", 2500])
    assert q(0.0) == pytest.approx(0.8)
    assert q(50j) == pytest.approx(-0.8j / 1.415)  # at ω, nothing but the damping term is left
    assert q != RationalFunction(*eq23("0.8", 50, "1.414"))
