"""The laws of the joint, each equation one block: load (1), series-elastic drive (13), control law (20)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import product

from ..spec.model import Impedance, SeriesElasticActuator, Spec
from .block import Block, combination, integrator, low_pass, transfer

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


def actuator_equations(spec: Spec) -> list[Block]:
    """(13): `J φ'' + b_m φ' = τ_m − τ_sea`, `τ_sea = K_sp (φ − θ)`, `τ_m = λ τ_d + C_t (τ_d − τ_sea)`.

    The ideal actuator is `τ_sea = τ_d`.
    """
    actuator = spec.actuator
    if not isinstance(actuator, SeriesElasticActuator):
        return [combination("tau_sea", tau_d=1)]
    J, b_m, K_sp, loop = actuator.motor_inertia, actuator.motor_damping, actuator.spring_stiffness, actuator.torque_loop
    return [
        combination("tau_sea", phi=K_sp, theta=-K_sp),
        combination("motor_acceleration", tau_m=1 / J, tau_sea=-1 / J, motor_velocity=-b_m / J),
        integrator("motor_velocity", "motor_acceleration"),
        integrator("phi", "motor_velocity"),
        combination("torque_error", tau_d=1, tau_sea=-1),
        transfer("torque_lead", "torque_error", [loop.kd, Fraction(0)], [1 / loop.derivative_corner, Fraction(1)]),
        combination("tau_m", tau_d=loop.feedforward, torque_error=loop.kp, torque_lead=1),
    ]


def controller_equations(spec: Spec, compensator: Compensator) -> list[Block]:
    """(20): `τ_d = C (F τ_int − F_θ G_imp θ) + F_d (Ĝ⁻¹ − G_imp) θ`, G_imp and Ĝ⁻¹ acting on θ, θ', θ''."""
    wish, plant, filters = spec.impedance, spec.plant, spec.controller.filters
    gap = Impedance(
        inertia=plant.inertia - wish.inertia,
        damping=plant.damping - wish.damping,
        stiffness=plant.stiffness - wish.stiffness,
    )
    if filters.position is None:  # one filter on the dynamic error, not two copies of it
        error = [
            combination("raw_error", tau_int=1, wish=-1),
            low_pass("error", "raw_error", filters.force),
        ]
    else:
        corner = None if filters.position == "none" else filters.position
        error = [
            low_pass("filtered_tau_int", "tau_int", filters.force),
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


def _stiffness(output: str, dynamics: Impedance) -> Block:
    """`output = I θ'' + B θ' + K θ`; terms with a zero coefficient are left out, so that no loop is imagined."""
    weights = {"acceleration": dynamics.inertia, "velocity": dynamics.damping, "theta": dynamics.stiffness}
    return combination(output, **{signal: weight for signal, weight in weights.items() if weight})
