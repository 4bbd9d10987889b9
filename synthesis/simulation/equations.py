"""The laws of the joint, each equation one block: load (1), actuator (13), control law (20)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import product

from ..spec.model import Interval, SeriesElasticActuator, Spec, TwoPortActuator
from .block import Block, combination, integrator, leading, low_pass, transfer, transfers

Compensator = tuple[Sequence[Fraction], Sequence[Fraction]]  # C: numerator, denominator, descending powers of s


@dataclass(frozen=True)
class Load:
    """True load of (1): inertia [kg·m²], damping [N·m·s/rad], stiffness [N·m/rad]; linear motion: kg, N·s/m, N/m."""

    inertia: Fraction
    damping: Fraction
    stiffness: Fraction

    def __str__(self) -> str:
        return f"I={float(self.inertia):g} B={float(self.damping):g} K={float(self.stiffness):g}"


def loads(spec: Spec) -> tuple[Load, ...]:
    """The nominal load first, then the distinct corners of the box."""
    plant, box = spec.plant, spec.uncertainty.box
    nominal = Load(plant.inertia, plant.damping, plant.stiffness)
    corners = product(box.inertia, box.damping, box.stiffness) if box else ()
    return tuple(dict.fromkeys([nominal, *(Load(*corner) for corner in corners)]))


def load_equations(load: Load) -> list[Block]:
    """(1): `I θ'' + B θ' + K θ = τ_int + τ_sea`."""
    I, B, K = load.inertia, load.damping, load.stiffness  # noqa: E741
    return [
        combination("acceleration", tau_int=1 / I, tau_sea=1 / I, velocity=-B / I, theta=-K / I),
        integrator("velocity", "acceleration"),
        integrator("theta", "velocity"),
    ]


def actuator_equations(spec: Spec, command: str = "tau_d") -> list[Block]:
    """(13): `J φ'' + b_m φ' = τ_m − τ_sea`, `τ_sea = K_sp (φ − θ)`, `τ_m = λ τ_d + C_t (τ_d − τ_sea)`.

    The ideal actuator is `τ_sea = τ_d`, a two-port `τ_sea = H τ_d − Z_a θ`. `command`: the signal it takes for τ_d.
    """
    actuator = spec.actuator
    if isinstance(actuator, TwoPortActuator):
        return _two_port(actuator, command)
    if not isinstance(actuator, SeriesElasticActuator):
        return [combination("tau_sea", **{command: 1})]
    J, b_m, K_sp, loop = actuator.motor_inertia, actuator.motor_damping, actuator.spring_stiffness, actuator.torque_loop
    return [
        combination("tau_sea", phi=K_sp, theta=-K_sp),
        combination("motor_acceleration", tau_m=1 / J, tau_sea=-1 / J, motor_velocity=-b_m / J),
        integrator("motor_velocity", "motor_acceleration"),
        integrator("phi", "motor_velocity"),
        combination("torque_error", **{command: 1, "tau_sea": -1}),
        transfer("torque_lead", "torque_error", [loop.kd, Fraction(0)], [1 / loop.derivative_corner, Fraction(1)]),
        combination("tau_m", torque_error=loop.kp, torque_lead=1, **{command: loop.feedforward}),
    ]


def _two_port(actuator: TwoPortActuator, command: str) -> list[Block]:
    """`τ_sea = H τ_d − Z_a θ`; one denominator means one mechanism, so its modes are there once."""
    H, Z_a = actuator.transfer, actuator.impedance
    if leading(H.denominator) == leading(Z_a.denominator):
        yielded = [-value for value in Z_a.numerator]
        return [transfers("tau_sea", {command: H.numerator, "theta": yielded}, H.denominator)]
    return [
        transfer("pushed", command, H.numerator, H.denominator),
        transfer("yielded", "theta", Z_a.numerator, Z_a.denominator),
        combination("tau_sea", pushed=1, yielded=-1),
    ]


def controller_equations(spec: Spec, compensator: Compensator) -> list[Block]:
    """(20): `τ_d = C (F τ_int − F_θ G_imp θ) + F_d (Ĝ⁻¹ − G_imp) θ`, G_imp and Ĝ⁻¹ acting on θ, θ', θ''."""
    wish, plant, filters = desired(spec), spec.plant, spec.controller.filters
    gap = Load(plant.inertia - wish.inertia, plant.damping - wish.damping, plant.stiffness - wish.stiffness)
    if filters.position is None:  # one filter on the dynamic error, not two copies of it
        error = [
            combination("raw_error", tau_int=1, wish=-1),
            low_pass("error", "raw_error", filters.force_corner),
        ]
    else:
        corner = None if filters.position == "none" else filters.position
        error = [
            low_pass("filtered_tau_int", "tau_int", filters.force_corner),
            low_pass("filtered_wish", "wish", corner),
            combination("error", filtered_tau_int=1, filtered_wish=-1),
        ]
    return [
        _stiffness("wish", wish),
        *error,
        transfer("correction", "error", *compensator),
        _stiffness("gap", gap),
        low_pass("compensation", "gap", filters.derivative),
        combination("tau_d", correction=1, compensation=1),
    ]


def desired(spec: Spec) -> Load:
    """The impedance wished for; of a range its middle."""
    return Load(*(middle(getattr(spec.impedance, name)) for name in ("inertia", "damping", "stiffness")))


def middle(value: Fraction | Interval) -> Fraction:
    """A number, or the middle of an interval."""
    return (value[0] + value[1]) / 2 if isinstance(value, tuple) else value


def _stiffness(output: str, dynamics: Load) -> Block:
    """`output = I θ'' + B θ' + K θ`; terms with a zero coefficient are left out, so that no loop is imagined."""
    weights = {"acceleration": dynamics.inertia, "velocity": dynamics.damping, "theta": dynamics.stiffness}
    return combination(output, **{signal: weight for signal, weight in weights.items() if weight})
