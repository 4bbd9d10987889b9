"""The physical half of a specification: plant, actuator, sampling and the impedance to render."""

from __future__ import annotations

from fractions import Fraction

from .exact import decimal_text
from .fields import above, described, entries, non_negative, polynomials, require, word
from .model import (
    Actuator,
    IdealActuator,
    Impedance,
    Interval,
    Plant,
    Sampling,
    SeriesElasticActuator,
    TorqueLoop,
    TwoPortActuator,
)
from .ranges import one_or_range
from .tree import Node, Sequence
from .units import FREQUENCY, PLAIN, RATE, TIME, Dimension, Mechanics

_LOAD = ("inertia", "damping", "stiffness")
_ACTUATORS = {
    "ideal": (),
    "series-elastic": ("motor_inertia", "motor_damping", "spring_stiffness", "torque_loop"),
    "two-port": ("transfer", "impedance"),
}


def plant(node: Node, units: Mechanics) -> Plant:
    """Nominal load: inertia > 0, damping ≥ 0, stiffness ≥ 0."""
    section = entries(node, _LOAD)
    for key in _LOAD:
        message = "expected the nominal value; its uncertainty belongs under `uncertainty: box:`; found an interval"
        require(not isinstance(section[key], Sequence), message, section[key].where)
    return Plant(
        inertia=above(section["inertia"], 0, units.inertia),
        damping=non_negative(section["damping"], units.damping),
        stiffness=non_negative(section["stiffness"], units.stiffness),
    )


def actuator(node: Node, units: Mechanics) -> Actuator:
    """The actuator of the joint, by its `type`."""
    every = [key for keys in _ACTUATORS.values() for key in keys]
    section = entries(node, ("type",), every)
    kind = word(section["type"], *_ACTUATORS)
    for key, value in section.items():
        article = "an" if kind == "ideal" else "a"
        known = key in ("type", *_ACTUATORS[kind])
        require(known, f"{article} {kind} actuator has no {key}; remove it", value.where)
    section = entries(node, ("type", *_ACTUATORS[kind]), [key for key in every if key not in _ACTUATORS[kind]])
    if kind == "ideal":
        return IdealActuator(type="ideal")
    if kind == "two-port":
        transfer, port = polynomials(section["transfer"]), polynomials(section["impedance"], zero=True)
        return TwoPortActuator(type="two-port", transfer=transfer, impedance=port)
    return SeriesElasticActuator(
        type="series-elastic",
        motor_inertia=above(section["motor_inertia"], 0, units.inertia),
        motor_damping=non_negative(section["motor_damping"], units.damping),
        spring_stiffness=above(section["spring_stiffness"], 0, units.stiffness),
        torque_loop=_torque_loop(section["torque_loop"]),
    )


def sampling(node: Node) -> Sampling:
    """Hold and delay between torque command and torque."""
    section = entries(node, ("rate", "delay"))
    return Sampling(rate=above(section["rate"], 0, RATE), delay=non_negative(section["delay"], TIME))


def impedance(node: Node, units: Mechanics, nominal: Plant) -> Impedance:
    """The desired impedance, or a range of them; `inertia: nominal` leaves the load's own inertia as it is."""
    section = entries(node, _LOAD)
    return Impedance(
        inertia=_desired(section["inertia"], units.inertia, nominal.inertia),
        damping=_desired(section["damping"], units.damping),
        stiffness=_desired(section["stiffness"], units.stiffness),
    )


def _desired(node: Node, dimension: Dimension, nominal: Fraction | None = None) -> Fraction | Interval:
    """A desired value or range; only an inertia has a nominal one, and must not vanish."""
    value = one_or_range(node, dimension, nominal)
    low = value[0] if isinstance(value, tuple) else value
    sign = "≥ 0" if nominal is None else "> 0"
    found = f"{decimal_text(low)} at its low end" if isinstance(value, tuple) else described(node)
    message = f"expected {dimension.name} {sign}; found {found}"
    require(low > 0 or (low == 0 and nominal is None), message, node.where)
    return value


def _torque_loop(node: Node) -> TorqueLoop:
    section = entries(node, ("kp", "kd", "derivative_corner", "feedforward"))
    loop = TorqueLoop(
        kp=non_negative(section["kp"], PLAIN),
        kd=non_negative(section["kd"], TIME),
        derivative_corner=above(section["derivative_corner"], 0, FREQUENCY),
        feedforward=non_negative(section["feedforward"], PLAIN),
    )
    idle = loop.kp == loop.kd == loop.feedforward == 0
    require(
        not idle,
        "expected kp, kd or feedforward > 0; all are zero, and no torque is transmitted; write feedforward: 1",
        node.where,
    )
    return loop
