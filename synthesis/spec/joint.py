"""The physical half of a specification: plant, uncertainty, actuator and the impedance to render."""

from __future__ import annotations

from fractions import Fraction

from ..errors import InputError
from .exact import decimal_text
from .fields import above, described, entries, interval, non_negative, polynomials, require, tolerance, word
from .model import Box, IdealActuator, Impedance, Interval, Plant, SeriesElasticActuator, TorqueLoop, Uncertainty
from .tree import Node, Scalar, Sequence
from .units import FREQUENCY, PLAIN, TIME, Dimension, Mechanics

_LOAD = ("inertia", "damping", "stiffness")


def plant(node: Node, units: Mechanics) -> Plant:
    """Nominal load: inertia > 0, damping ≥ 0, stiffness ≥ 0."""
    section = entries(node, _LOAD)
    for key in _LOAD:
        _one_number(section[key], "the nominal value; its uncertainty belongs under `uncertainty: box:`")
    return Plant(
        inertia=above(section["inertia"], 0, units.inertia),
        damping=non_negative(section["damping"], units.damping),
        stiffness=non_negative(section["stiffness"], units.stiffness),
    )


def uncertainty(node: Node, units: Mechanics, nominal: Plant) -> Uncertainty:
    """A box of loads, a weight, or both; at least one."""
    section = entries(node, optional=("box", "weight"), later=("table", "measured"))
    require(bool(section), "expected `box:`, `weight:` or both; a joint known exactly has a box of [v, v]", node.where)
    return Uncertainty(
        box=_box(section["box"], units, nominal) if "box" in section else None,
        weight=polynomials(section["weight"]) if "weight" in section else None,
    )


def actuator(node: Node, units: Mechanics) -> IdealActuator | SeriesElasticActuator:
    """The actuator of the joint, by its `type`."""
    motor = ("motor_inertia", "motor_damping", "spring_stiffness", "torque_loop")
    section = entries(node, ("type",), motor)
    if word(section["type"], "ideal", "series-elastic") == "ideal":
        for key in motor:
            require(key not in section, f"an ideal actuator has no {key}; remove it", section.get(key, node).where)
        return IdealActuator(type="ideal")
    section = entries(node, ("type", *motor))
    return SeriesElasticActuator(
        type="series-elastic",
        motor_inertia=above(section["motor_inertia"], 0, units.inertia),
        motor_damping=non_negative(section["motor_damping"], units.damping),
        spring_stiffness=above(section["spring_stiffness"], 0, units.stiffness),
        torque_loop=_torque_loop(section["torque_loop"]),
    )


def impedance(node: Node, units: Mechanics, nominal: Plant) -> Impedance:
    """The desired impedance; `inertia: nominal` leaves the load's own inertia as it is."""
    section = entries(node, _LOAD)
    for key in _LOAD:
        _one_number(section[key], "one value: this version cannot yet prove one controller for a range of impedances")
    inertia = section["inertia"]
    keep = isinstance(inertia, Scalar) and inertia.text == "nominal"
    return Impedance(
        inertia=nominal.inertia if keep else above(inertia, 0, units.inertia),
        damping=non_negative(section["damping"], units.damping),
        stiffness=non_negative(section["stiffness"], units.stiffness),
    )


def _torque_loop(node: Node) -> TorqueLoop:
    section = entries(node, ("kp", "kd", "derivative_corner", "feedforward"))
    loop = TorqueLoop(
        kp=non_negative(section["kp"], PLAIN),
        kd=non_negative(section["kd"], TIME),
        derivative_corner=above(section["derivative_corner"], 0, FREQUENCY),
        feedforward=non_negative(section["feedforward"], PLAIN),
    )
    idle = loop.kp == loop.kd == loop.feedforward == 0
    require(not idle, "expected kp, kd or feedforward > 0; all are zero, and no torque is transmitted", node.where)
    return loop


def _box(node: Node, units: Mechanics, nominal: Plant) -> Box:
    section = entries(node, optional=_LOAD)
    for key in _LOAD:
        value = decimal_text(getattr(nominal, key))
        require(key in section, f"expected {key} too; write {key}: [{value}, {value}] if it is exact", node.where)
    box = Box(
        inertia=_range(section["inertia"], units.inertia, nominal.inertia),
        damping=_range(section["damping"], units.damping, nominal.damping),
        stiffness=_range(section["stiffness"], units.stiffness, nominal.stiffness),
    )
    for key in _LOAD:
        low = getattr(box, key)[0]
        sign = "> 0" if key == "inertia" else "≥ 0"
        message = f"expected a box in which every {key} is {sign}; found {decimal_text(low)} at its low end"
        require(low > 0 or (low == 0 and key != "inertia"), message, section[key].where)
    return box


def _range(node: Node, dimension: Dimension, nominal: Fraction) -> Interval:
    """`±p %` of the nominal value, or `[low, high]` around it."""
    around = tolerance(node, nominal)
    if around is not None:
        return around
    if not isinstance(node, Sequence):
        message = f'expected "±20 %" or [low, high]; found {described(node)}; write [v, v] if the value v is exact'
        raise InputError(message, node.where)
    low, high = interval(node, dimension)
    found = f"[{decimal_text(low)}, {decimal_text(high)}]"
    message = f"expected an interval that holds the nominal value {decimal_text(nominal)}; found {found}"
    require(low <= nominal <= high, message, node.where)
    return low, high


def _one_number(node: Node, what: str) -> None:
    require(not isinstance(node, Sequence), f"expected {what}; found an interval", node.where)
